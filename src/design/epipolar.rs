//! The exact prism: two surfaces of revolution about the line through O and O'.
//!
//! Where that line is the baseline, it is the axis of both halves, and the planes through it are the epipolar planes: by
//! symmetry every ray stays in its plane, so the vertical disparity is 0 at every depth, in every light and for every index. In
//! such a plane a ray has the polar angle theta about the axis before the prism and theta' behind it, with
//! cot theta' = cot theta - b/f, so that the half image is that of a pinhole but for a shift of each row by
//! kappa(v) = b (sqrt(1 + v^2/f^2) - 1), the same at every depth.
//!
//! The optical path |OP| + k |PP'| - |P'O'| is held constant: then any first profile fixes the second one with an exact centre
//! O' (a condition of Cartesian ovals). The first profile follows from refraction, as one ordinary differential equation.

use super::march::GridLayout;
use super::point_grid::{PointGrid, TargetLaw};
use super::slope::{SMALLEST_COSINE, Singular, optical_path_mm};
use super::virtual_camera::VirtualCamera;
use crate::error::Error;
use crate::num::chebyshev::points;
use crate::num::ode::{Integrator, OdeError};
use crate::scene::{CameraSpec, DesignSettings, MarchOrder};
use rayon::prelude::*;

/// Points of the profile's interpolation.
const NODES: usize = 25;
/// Tolerance of a step of the integration, in mm.
const TOLERANCE_MM: f64 = 1e-13;
/// The interpolation must agree with the integration between its points to this, in mm.
const RESIDUAL_MM: f64 = 1e-8;
/// How far the profile reaches beyond the angles of the half image's pixels, as a share of their range.
const MARGIN: f64 = 0.02;

/// Columns and rows of the grid that polynomials are fitted to: Chebyshev points, which hold the borders as close as the middle.
const FITTED: usize = 61;

/// The surfaces of the right half (x > 0), revolved about the baseline.
pub(super) struct Revolved {
    camera: CameraSpec,
    target: VirtualCamera,
    profile: FrontProfile,
}

impl Revolved {
    /// The surfaces for the right half of the sensor of `camera`, whose virtual camera is `target`.
    ///
    /// # Errors
    /// An [`Error`] when the glass pinches to nothing, or the profile is not smooth.
    pub(super) fn new(camera: &CameraSpec, target: &VirtualCamera) -> Result<Self, Error> {
        let half_mm = 0.25 * camera.width_px as f64 * camera.pitch_mm;
        Ok(Self { camera: *camera, target: *target, profile: FrontProfile::new(target, [-half_mm, half_mm])? })
    }

    /// Their points on the grid that [`super::march::march`] would march.
    ///
    /// # Errors
    /// An [`Error`] when the grid is refused, or the glass ends.
    pub(super) fn cloud(&self, settings: &DesignSettings) -> Result<PointGrid, Error> {
        let GridLayout { u_px, v_px, .. } = GridLayout::new(&self.camera, settings)?;
        self.grid(u_px, v_px)
    }

    /// Their points to which polynomials are fitted.
    ///
    /// # Errors
    /// An [`Error`] when the glass ends.
    pub(super) fn fitted(&self) -> Result<PointGrid, Error> {
        let nodes = |half: f64| points(FITTED).into_iter().map(|s| half * s).collect();
        self.grid(nodes(0.25 * self.camera.width_px as f64), nodes(0.5 * self.camera.height_px as f64))
    }

    /// A pixel's ray has its own polar angle, and meets the profile at its distance.
    fn grid(&self, u_px: Vec<f64>, v_px: Vec<f64>) -> Result<PointGrid, Error> {
        let Self { camera, target, profile } = self;
        let place = |u_px: f64, v_px: f64| -> Result<[f64; 2], Singular> {
            let (u, v) = (u_px * camera.pitch_mm, v_px * camera.pitch_mm);
            let (a, g) = (target.outer_direction(u, v), TargetLaw::Rows.direction(target, u, v));
            let theta = libm::atan2(libm::hypot(a.y, a.z), a.x);
            let p = profile.at(theta);
            let q = profile.plane.back(theta, p)?.1;
            Ok([p / a.length(), target.centre_mm.z + q / g.length()])
        };
        let z_mm = u_px
            .par_iter()
            .map(|&u| v_px.iter().map(|&v| place(u, v)).collect::<Result<Vec<_>, _>>())
            .collect::<Result<Vec<_>, Singular>>()
            .map_err(|why| refused(&why.to_string()))?
            .concat();
        let (order, law) = (MarchOrder::XThenY, TargetLaw::Rows);
        Ok(PointGrid { camera: *target, pitch_mm: camera.pitch_mm, order, law, u_px, v_px, z_mm })
    }
}

fn refused(why: &str) -> Error {
    Error::new(
        "the prism's design",
        format!("no prism is exact for this camera (`prism.design.objective` = \"epipolar\"): {why}"),
        "use a thicker prism, a longer focal length or a smaller sensor",
    )
}

/// What holds in a plane through the axis: along it s, from O towards O', and beside it rho.
struct AxialPlane {
    /// n_glass / n_outside.
    index_ratio: f64,
    /// |OO'|.
    axis_mm: f64,
    /// cot theta - cot theta'.
    turn: f64,
    /// |OP| + k |PP'| - |P'O'|.
    path_mm: f64,
}

impl AxialPlane {
    /// The direction in the glass and the distance |O'P'|, of the ray of polar angle `theta` that meets the front at the
    /// distance `p` from O.
    fn back(&self, theta: f64, p: f64) -> Result<([f64; 2], f64), Singular> {
        let [c, s] = [libm::cos(theta), libm::sin(theta)];
        let out = self.out(theta);
        let k2 = self.index_ratio * self.index_ratio;

        // With D = P - O' and E = path - p: k |q i'' - D| = E + q, of which the farther root lies behind the front.
        let d = [p * c - self.axis_mm, p * s];
        let along = out[0] * d[0] + out[1] * d[1];
        let e = self.path_mm - p;
        let half = k2 * along + e;
        let square = half * half - (k2 - 1.0) * (k2 * (d[0] * d[0] + d[1] * d[1]) - e * e);
        if square.is_nan() || square < 0.0 {
            return Err(Singular::BackCritical);
        }
        let q = (half + square.sqrt()) / (k2 - 1.0);
        let through = [q * out[0] - d[0], q * out[1] - d[1]];
        let length = libm::hypot(through[0], through[1]);
        if !(p > 0.0 && through[1] > 0.0) {
            return Err(Singular::NoGlass);
        }
        Ok((through.map(|v| v / length), q))
    }

    /// The direction behind the prism.
    fn out(&self, theta: f64) -> [f64; 2] {
        let cot = libm::cos(theta) / libm::sin(theta) - self.turn;
        let length = libm::hypot(cot, 1.0);
        [cot / length, 1.0 / length]
    }

    /// dp/dtheta = -p (N . di/dtheta) / (N . i), with the front's normal N = i - k i'.
    fn slope(&self, theta: f64, p: f64) -> Result<f64, Singular> {
        let i = [libm::cos(theta), libm::sin(theta)];
        let (glass, _) = self.back(theta, p)?;
        let normal = [0, 1].map(|axis| i[axis] - self.index_ratio * glass[axis]);
        let cosine = normal[0] * i[0] + normal[1] * i[1];
        if cosine > -SMALLEST_COSINE * (self.index_ratio - 1.0) {
            return Err(Singular::FrontGrazing);
        }
        Ok(-p * (normal[1] * i[0] - normal[0] * i[1]) / cosine)
    }
}

/// The front's profile p(theta), by its values at Chebyshev points.
struct FrontProfile {
    plane: AxialPlane,
    /// Middle and half width of the angles, in rad.
    range: [f64; 2],
    nodes: Vec<ProfileNode>,
}

/// A Chebyshev point of the interpolation, its barycentric weight, and p there.
struct ProfileNode {
    s: f64,
    weight: f64,
    p_mm: f64,
}

impl FrontProfile {
    /// The profile through the central ray of `target`, over the pixels from u = `u_mm`\[0\] to \[1\].
    fn new(target: &VirtualCamera, u_mm: [f64; 2]) -> Result<Self, Error> {
        let axis_mm = target.centre_mm.x;
        if target.centre_mm.y != 0.0 || target.centre_mm.z != 0.0 || axis_mm <= 0.0 {
            return Err(refused("O' does not lie on the baseline"));
        }
        let plane = AxialPlane {
            index_ratio: target.index_ratio,
            axis_mm,
            turn: target.half_centre_mm / target.focal_length_mm,
            path_mm: optical_path_mm(target, target.front_mm, target.back_mm),
        };

        // Find the angles of all pixels: those of the middle row and, for the outer ones, of the corners too.
        let polar = |u: f64| libm::atan2(target.focal_length_mm, target.half_centre_mm + u);
        let (low, high) = (polar(u_mm[1]), polar(u_mm[0]));
        let range = [0.5 * (low + high), 0.5 * (high - low) * (1.0 + 2.0 * MARGIN)];

        // Integrate from the central ray outwards, to the points and to the middles between them.
        let start = [libm::atan2(target.front_mm.z, target.front_mm.x), target.front_mm.length()];
        let mut places = points(NODES);
        let middles: Vec<f64> = places.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
        places.extend(&middles);
        let found = integrated(&plane, start, &places.iter().map(|s| range[0] + range[1] * s).collect::<Vec<_>>())
            .map_err(|why| refused(&why))?;

        // Hold the interpolation against the middles.
        let (values, between) = found.split_at(NODES);
        let node = |(k, (&s, &p_mm)): (usize, (&f64, &f64))| {
            let sine = libm::sin(std::f64::consts::PI * (k as f64 + 0.5) / NODES as f64);
            ProfileNode { s, weight: if k % 2 == 0 { sine } else { -sine }, p_mm }
        };
        let nodes = places.iter().zip(values).enumerate().map(node).collect();
        let profile = Self { plane, range, nodes };
        let off = |(s, p): (&f64, &f64)| (profile.at(range[0] + range[1] * s) - p).abs();
        let residual = middles.iter().zip(between).map(off).fold(0.0, f64::max);
        if residual > RESIDUAL_MM {
            return Err(refused(&format!(
                "its profile is not smooth (a series of degree {} errs by {residual:.1e} mm)",
                NODES - 1
            )));
        }
        Ok(profile)
    }

    /// p(theta), by the barycentric formula (Berrut & Trefethen, "Barycentric Lagrange Interpolation", 2004).
    fn at(&self, theta: f64) -> f64 {
        let s = (theta - self.range[0]) / self.range[1];
        let (mut over, mut under) = (0.0, 0.0);
        for node in &self.nodes {
            if s == node.s {
                return node.p_mm;
            }
            let weight = node.weight / (s - node.s);
            over += weight * node.p_mm;
            under += weight;
        }
        over / under
    }
}

/// p at each of the angles, from [theta, p] at the start.
fn integrated(plane: &AxialPlane, start: [f64; 2], angles: &[f64]) -> Result<Vec<f64>, String> {
    let rate = |theta: f64, [p]: [f64; 1]| plane.slope(theta, p).map(|slope| [slope]);
    let why = |error: OdeError<Singular>| match error {
        OdeError::Refused(singular) => singular.to_string(),
        OdeError::NoProgress => "adaptive steps make no progress".to_owned(),
    };
    let mut found = vec![0.0; angles.len()];
    for side in [1.0, -1.0] {
        let mut order: Vec<usize> = (0..angles.len()).filter(|&k| side * (angles[k] - start[0]) >= 0.0).collect();
        order.sort_by(|&a, &b| (side * angles[a]).total_cmp(&(side * angles[b])));
        let [mut theta, mut p] = start;
        for k in order {
            let step = angles[k] - theta;
            if step != 0.0 {
                [p] = Integrator::DormandPrince(TOLERANCE_MM).advance(&rate, theta, [p], step).map_err(why)?;
            }
            (theta, found[k]) = (angles[k], p);
        }
    }
    Ok(found)
}
