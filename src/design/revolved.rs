//! The exact prisms: two surfaces of revolution about the line through O and O'.
//!
//! Of `epipolar` that line is the baseline, the axis of both halves, and the planes through it are the epipolar planes, so that the
//! vertical disparity is 0 at every depth, in every light and for every index. There cot theta' = cot theta - b/f: the half image
//! is that of a pinhole but for a shift of each row by kappa(v) = b (sqrt(1 + v^2/f^2) - 1), the same at every depth.
//!
//! Of `toed-in` O' lies before or behind the plane of O, and cot theta' = m cot theta: the directions behind the prism are
//! the linear map I + (m - 1) e e^T of those before it, e along the axis, and each half is exactly a pinhole, its axis turned
//! outwards. There is one m by which the middle of the half image looks along z and the axis is turned by delta; near it is one
//! by which the surfaces bend so little that polynomials follow them a thousand times as well, which is taken.

use super::axial::{AxialPlane, FrontProfile, refused};
use super::fit::fit;
use super::march::GridLayout;
use super::point_grid::{PointGrid, TargetLaw};
use super::slope::{Singular, optical_path_mm};
use super::virtual_camera::VirtualCamera;
use crate::error::Error;
use crate::num::chebyshev::points;
use crate::scene::{CameraSpec, DesignSettings, MarchOrder, Objective};
use crate::surface::shape::RevolvedPatch;
use glam::DVec3;
use rayon::prelude::*;

/// How far the profiles reach beyond the angles of the half image's pixels, as a share of their range.
const MARGIN: f64 = 0.02;
/// Columns and rows of the grid that polynomials are fitted to: Chebyshev points, which hold the borders as close as the middle.
const FITTED: usize = 61;
/// The widest part, to each side, in rad: a little less than a scene may state.
const WIDEST_RAD: f64 = 1.39;
/// The nearest that a ray may run to the direction of the axis, in rad.
const LEAST_ANGLE_RAD: f64 = 0.01;
/// Cells along each side of the half image at whose corners angles are taken. They are greatest or least on its border or its
/// middle row.
const CELLS: usize = 32;

/// m of `toed-in` is sought between these shares of the way from 1 to the one by which the middle of the half image looks along
/// z, first in so many steps.
const SHARES: [f64; 2] = [0.5, 1.5];
const SHARE_STEPS: usize = 40;
/// Then the step is narrowed to this share of itself.
const SHARE_PRECISION: f64 = 1e-3;
/// There polynomials of this degree, through a grid of so many points a side, are to follow the surfaces best: the one of the design
/// paper, whatever the degree of the design, so that its surfaces do not depend on it.
const SEARCH_DEGREE: usize = 5;
const SEARCH_POINTS: usize = 17;

/// What the rays do in the planes through the axis.
#[derive(Clone, Copy)]
enum RevolvedLaw {
    /// cot theta' = cot theta - b/f.
    Rows,
    /// cot theta' = m cot theta, with this m.
    Stretched(f64),
}

/// The surfaces of the right half (x > 0).
pub(super) struct Revolved {
    camera: CameraSpec,
    target: VirtualCamera,
    law: TargetLaw,
    frame: AxisFrame,
    profile: FrontProfile,
    /// How far the pixels' rays lie to both sides of the plane through the axis along z, in rad.
    azimuth_rad: f64,
    objective: &'static str,
}

/// The frame of the axis: along it, from O towards O', and at a right angle to it towards +z; the third direction is y.
#[derive(Debug, Clone, Copy)]
struct AxisFrame {
    along: DVec3,
    towards: DVec3,
}

impl AxisFrame {
    fn new(centre_mm: DVec3) -> Self {
        // Along the baseline exactly so.
        let along = if centre_mm.z == 0.0 { DVec3::X } else { centre_mm.normalize() };
        Self { along, towards: DVec3::new(-along.z, 0.0, along.x) }
    }

    /// Angle from the axis, and about it from the half-plane towards +z.
    fn polar(&self, v: DVec3) -> [f64; 2] {
        let (a, b) = (v.dot(self.towards), v.y);
        [libm::atan2(libm::hypot(a, b), v.dot(self.along)), libm::atan2(b, a)]
    }
}

impl Revolved {
    /// By what directions belong to pixels.
    pub(super) fn law(&self) -> TargetLaw {
        self.law
    }

    /// The surfaces for the right half of the sensor of `camera`, whose virtual camera is `target`, by an objective that has them; they
    /// reach `spare_rad` farther than the rays of the design, seen from O.
    ///
    /// # Errors
    /// An [`Error`] when the glass pinches to nothing, or a profile is not smooth.
    pub(super) fn new(
        camera: &CameraSpec,
        target: &VirtualCamera,
        objective: Objective,
        spare_rad: f64,
    ) -> Result<Self, Error> {
        if objective != Objective::ToedIn {
            return Self::by(camera, target, RevolvedLaw::Rows, spare_rad);
        }

        // The m by which the middle of the half image looks along z.
        let along = AxisFrame::new(target.centre_mm).along;
        let middle = target.outer_direction(0.0, 0.0);
        let straight = 1.0 - middle.x / (middle.dot(along) * along.x);
        let law = |share: f64| RevolvedLaw::Stretched(1.0 + (straight - 1.0) * share);

        // Near it, the one whose surfaces polynomials follow best.
        let misfit = |share: f64| {
            let made = Self::by(camera, target, law(share), 0.0).and_then(|made| made.misfit_mm());
            made.unwrap_or(f64::INFINITY)
        };
        let step = (SHARES[1] - SHARES[0]) / SHARE_STEPS as f64;
        let shares = (0..=SHARE_STEPS).map(|k| SHARES[0] + step * k as f64);
        let best = shares.map(|share| (misfit(share), share)).min_by(|a, b| a.0.total_cmp(&b.0));
        let (least, near) = best.unwrap_or((f64::INFINITY, 1.0));
        if least == f64::INFINITY {
            // What is wrong with the middle one.
            return Self::by(camera, target, law(1.0), spare_rad);
        }
        Self::by(camera, target, law(least_between([near - step, near + step], misfit)), spare_rad)
    }

    fn by(camera: &CameraSpec, target: &VirtualCamera, law: RevolvedLaw, spare_rad: f64) -> Result<Self, Error> {
        let frame = AxisFrame::new(target.centre_mm);
        let (name, law, stretch, turn) = match law {
            RevolvedLaw::Stretched(by) => ("toed-in", TargetLaw::Stretched { axis: frame.along, by }, by, 0.0),
            RevolvedLaw::Rows => ("epipolar", TargetLaw::Rows, 1.0, target.half_centre_mm / target.focal_length_mm),
        };
        if !(stretch > 0.0 && stretch.is_finite()) {
            return Err(refused(name, "O' lies too near to the plane of the camera's pinhole"));
        }

        // Begin with the central ray, through the thickness of the glass.
        let behind = law.direction(target, 0.0, 0.0);
        let back_mm = target.centre_mm + behind * ((target.back_mm.z - target.centre_mm.z) / behind.z);
        let plane = AxialPlane {
            index_ratio: target.index_ratio,
            axis_mm: target.centre_mm.length(),
            stretch,
            turn,
            path_mm: optical_path_mm(target, target.front_mm, back_mm),
        };

        // Find the angles of all pixels, corners included.
        let half_px = 0.25 * camera.width_px as f64;
        let share = |k: usize| 2.0 * k as f64 / CELLS as f64 - 1.0;
        let angles = (0..(CELLS + 1) * (CELLS + 1)).map(|k| {
            let (u, v) = (share(k % (CELLS + 1)) * half_px, share(k / (CELLS + 1)) * 0.5 * camera.height_px as f64);
            frame.polar(target.outer_direction(u * camera.pitch_mm, v * camera.pitch_mm))
        });
        let [low, high, azimuth] = angles
            .fold([f64::INFINITY, f64::NEG_INFINITY, 0.0f64], |[low, high, most], [theta, phi]| {
                [low.min(theta), high.max(theta), most.max(phi.abs())]
            });
        let spare = MARGIN * (high - low) + spare_rad;
        let ends = [low - spare, high + spare];
        if !(ends[0] > LEAST_ANGLE_RAD && ends[1] < std::f64::consts::PI - LEAST_ANGLE_RAD) {
            return Err(refused(name, "the axis from O to O' runs through the half image, or too near to it"));
        }
        let [start, _] = frame.polar(target.front_mm);
        let profile =
            FrontProfile::new(plane, [start, target.front_mm.length()], ends).map_err(|why| refused(name, &why))?;
        let azimuth_rad = (azimuth * (1.0 + 2.0 * MARGIN) + 2.0 * spare_rad).min(WIDEST_RAD);
        Ok(Self { camera: *camera, target: *target, law, frame, profile, azimuth_rad, objective: name })
    }

    /// What polynomials leave of both surfaces, in mm.
    fn misfit_mm(&self) -> Result<f64, Error> {
        let grid = self.chebyshev_grid(SEARCH_POINTS)?;
        let left = |points: Vec<DVec3>| fit(&points, SEARCH_DEGREE, None).map(|fit| fit.rms_mm);
        Ok(libm::hypot(left(grid.front_mm())?, left(grid.back_mm())?))
    }

    /// The surfaces themselves, front and back.
    ///
    /// # Errors
    /// An [`Error`] when a profile is not smooth over the axis.
    pub(super) fn patches(&self) -> Result<[RevolvedPatch; 2], Error> {
        let patch = |profile| RevolvedPatch {
            point_mm: DVec3::ZERO,
            axis: self.frame.along,
            profile,
            azimuth_rad: self.azimuth_rad,
        };
        let curves = self.profile.curves().map_err(|why| refused(self.objective, &why))?;
        Ok(curves.map(patch))
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
        self.chebyshev_grid(FITTED)
    }

    fn chebyshev_grid(&self, count: usize) -> Result<PointGrid, Error> {
        let nodes = |half: f64| points(count).into_iter().map(|s| half * s).collect();
        self.grid(nodes(0.25 * self.camera.width_px as f64), nodes(0.5 * self.camera.height_px as f64))
    }

    /// A pixel's ray has its own polar angle, and meets the profile at its distance.
    fn grid(&self, u_px: Vec<f64>, v_px: Vec<f64>) -> Result<PointGrid, Error> {
        let Self { camera, target, law, frame, profile, .. } = self;
        let place = |u_px: f64, v_px: f64| -> Result<[f64; 2], Singular> {
            let (u, v) = (u_px * camera.pitch_mm, v_px * camera.pitch_mm);
            let (a, g) = (target.outer_direction(u, v), law.direction(target, u, v));
            let [theta, _] = frame.polar(a);
            let p = profile.at(theta);
            let q = profile.plane.back(theta, p)?.1;
            Ok([p / a.length(), target.centre_mm.z + q / g.length()])
        };
        let z_mm = u_px
            .par_iter()
            .map(|&u| v_px.iter().map(|&v| place(u, v)).collect::<Result<Vec<_>, _>>())
            .collect::<Result<Vec<_>, Singular>>()
            .map_err(|why| refused(self.objective, &why.to_string()))?
            .concat();
        Ok(PointGrid {
            camera: *target,
            pitch_mm: camera.pitch_mm,
            order: MarchOrder::XThenY,
            law: *law,
            u_px,
            v_px,
            z_mm,
        })
    }
}

/// Where `f` is least between two ends, by golden section.
fn least_between([mut a, mut b]: [f64; 2], f: impl Fn(f64) -> f64) -> f64 {
    let share = 0.5 * (5f64.sqrt() - 1.0);
    let narrow = SHARE_PRECISION * (b - a);
    let (mut low, mut high) = (b - share * (b - a), a + share * (b - a));
    let (mut at_low, mut at_high) = (f(low), f(high));
    while b - a > narrow {
        if at_low < at_high {
            (b, high, at_high) = (high, low, at_low);
            low = b - share * (b - a);
            at_low = f(low);
        } else {
            (a, low, at_low) = (low, high, at_high);
            high = a + share * (b - a);
            at_high = f(high);
        }
    }
    0.5 * (a + b)
}
