//! The profiles of the exact prisms: what holds in a plane through the line from O to O'.
//!
//! Both surfaces are of revolution about that line: by symmetry every ray stays in the plane that holds it and the axis. There
//! it has the polar angle theta about the axis before the prism and theta' behind it, with cot theta' = m cot theta - c.
//! The optical path |OP| + k |PP'| - |P'O'| is held constant: then any first profile fixes the second one with an exact centre
//! O' (a condition of Cartesian ovals). The first profile follows from refraction, as one ordinary differential equation.

use super::slope::{SMALLEST_COSINE, Singular};
use crate::error::Error;
use crate::num::chebyshev::points;
use crate::num::curve::ChebyshevCurve;
use crate::num::ode::{Integrator, OdeError};

/// Points of the profile's interpolation.
const NODES: usize = 25;
/// Tolerance of a step of the integration, in mm.
const TOLERANCE_MM: f64 = 1e-13;
/// The interpolation must agree with the integration between its points to this, in mm.
const RESIDUAL_MM: f64 = 1e-8;
/// Coefficients of a profile below this, in mm, are the rounding of the integration.
const LEAST_COEFFICIENT_MM: f64 = 1e-15;
/// Steps of the search for the angle at a place along the axis.
const SEARCH_STEPS: usize = 64;
/// It ends where the place is as near as this share of its distance from the middle of the glass.
const NEAR: f64 = 1e-15;

pub(super) fn refused(objective: &str, why: &str) -> Error {
    Error::new(
        "the prism's design",
        format!("no prism is exact for this camera (`prism.design.objective` = \"{objective}\"): {why}"),
        "use a thicker prism, a longer focal length or a smaller sensor",
    )
}

/// What holds in a plane through the axis: along it s, from O towards O', and beside it rho.
#[derive(Debug, Clone, Copy)]
pub(super) struct AxialPlane {
    /// n_glass / n_outside.
    pub(super) index_ratio: f64,
    /// |OO'|.
    pub(super) axis_mm: f64,
    /// m
    pub(super) stretch: f64,
    /// c
    pub(super) turn: f64,
    /// |OP| + k |PP'| - |P'O'|.
    pub(super) path_mm: f64,
}

impl AxialPlane {
    /// The direction in the glass and the distance |O'P'|, of the ray of polar angle `theta` that meets the front at the
    /// distance `p` from O.
    pub(super) fn back(&self, theta: f64, p: f64) -> Result<([f64; 2], f64), Singular> {
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
        let cot = self.stretch * libm::cos(theta) / libm::sin(theta) - self.turn;
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

/// A point of a profile: its place along the axis and its distance from it, in mm, and how the place changes with theta.
struct ProfilePoint {
    s_mm: f64,
    rho_mm: f64,
    rate: f64,
}

impl AxialPlane {
    /// The front's point on the ray of polar angle `theta`, `p` from O.
    fn front_point(&self, theta: f64, p: f64) -> Result<ProfilePoint, Singular> {
        let [c, s] = [libm::cos(theta), libm::sin(theta)];
        Ok(ProfilePoint { s_mm: p * c, rho_mm: p * s, rate: self.slope(theta, p)? * c - p * s })
    }

    /// The back's point on the same ray. It moves at a right angle to the normal N = i' - k i'', by which q changes.
    fn back_point(&self, theta: f64, p: f64) -> Result<ProfilePoint, Singular> {
        let (glass, q) = self.back(theta, p)?;
        let out = self.out(theta);
        let normal = [0, 1].map(|axis| out[axis] - self.index_ratio * glass[axis]);
        let sine = libm::sin(theta);
        let turned = self.stretch * (out[1] / sine) * (out[1] / sine);
        let change = [-out[1] * turned, out[0] * turned];
        let dot = |v: [f64; 2]| normal[0] * v[0] + normal[1] * v[1];
        let rate = -q * dot(change) / dot(out) * out[0] + q * change[0];
        Ok(ProfilePoint { s_mm: self.axis_mm + q * out[0], rho_mm: q * out[1], rate })
    }
}

/// The front's profile p(theta), by its values at Chebyshev points.
pub(super) struct FrontProfile {
    pub(super) plane: AxialPlane,
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
    /// The profile from `start`, an angle and the distance p there, over the angles between `ends`, in rad.
    ///
    /// # Errors
    /// Why there is none.
    pub(super) fn new(plane: AxialPlane, start: [f64; 2], ends: [f64; 2]) -> Result<Self, String> {
        let range = [0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0])];

        // Integrate from the start outwards, to the points and to the middles between them.
        let mut places = points(NODES);
        let middles: Vec<f64> = places.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
        places.extend(&middles);
        let found = integrated(&plane, start, &places.iter().map(|s| range[0] + range[1] * s).collect::<Vec<_>>())?;

        // Hold the interpolation against the middles.
        let (values, between) = found.split_at(NODES);
        let node = |(k, (&s, &p_mm)): (usize, (&f64, &f64))| {
            let sine = libm::sin(std::f64::consts::PI * (k as f64 + 0.5) / NODES as f64);
            ProfileNode { s, weight: if k % 2 == 0 { sine } else { -sine }, p_mm }
        };
        let nodes = places.iter().zip(values).enumerate().map(node).collect();
        let profile = Self { plane, range, nodes };
        let off = |(s, p): (&f64, &f64)| (profile.at(range[0] + range[1] * s) - p).abs();
        smooth(middles.iter().zip(between).map(off).fold(0.0, f64::max)).map(|()| profile)
    }

    /// rho over s of front and back.
    ///
    /// # Errors
    /// Why there are none.
    pub(super) fn curves(&self) -> Result<[ChebyshevCurve; 2], String> {
        let plane = &self.plane;
        Ok([
            self.curve(|theta| plane.front_point(theta, self.at(theta)))?,
            self.curve(|theta| plane.back_point(theta, self.at(theta)))?,
        ])
    }

    fn curve(&self, point: impl Fn(f64) -> Result<ProfilePoint, Singular>) -> Result<ChebyshevCurve, String> {
        let at = |theta: f64| point(theta).map_err(|why| why.to_string());
        // The place along the axis falls as the angle grows.
        let ends = [at(self.range[0] + self.range[1])?.s_mm, at(self.range[0] - self.range[1])?.s_mm];
        let radius = |s_mm: f64| self.search(&at, s_mm, ends).map(|point| point.rho_mm);
        let nodes = ChebyshevCurve::nodes(ends, NODES);
        let values = nodes.iter().map(|s| radius(*s)).collect::<Result<Vec<_>, _>>()?;
        let curve = ChebyshevCurve::through(ends, &values, LEAST_COEFFICIENT_MM);
        let mut residual = 0.0f64;
        for pair in nodes.windows(2) {
            let s = 0.5 * (pair[0] + pair[1]);
            residual = residual.max((curve.gradient(s)[0] - radius(s)?).abs());
        }
        smooth(residual).map(|()| curve)
    }

    /// The point of a profile at a place along the axis, by Newton's method between angles that enclose it.
    fn search(
        &self,
        at: &impl Fn(f64) -> Result<ProfilePoint, String>,
        s_mm: f64,
        [low_mm, high_mm]: [f64; 2],
    ) -> Result<ProfilePoint, String> {
        let [mut below, mut above] = [self.range[0] - self.range[1], self.range[0] + self.range[1]];
        let mut theta = above + (below - above) * (s_mm - low_mm) / (high_mm - low_mm);
        for _ in 0..SEARCH_STEPS {
            let point = at(theta)?;
            let off = point.s_mm - s_mm;
            if off.abs() <= NEAR * (point.rho_mm + s_mm.abs()) {
                return Ok(point);
            }
            if off > 0.0 {
                below = theta
            } else {
                above = theta
            }
            let next = theta - off / point.rate;
            if next == theta {
                return Ok(point);
            }
            theta = if below < next && next < above { next } else { 0.5 * (below + above) };
        }
        at(theta)
    }

    /// p(theta), by the barycentric formula (Berrut & Trefethen, "Barycentric Lagrange Interpolation", 2004).
    pub(super) fn at(&self, theta: f64) -> f64 {
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

/// Refuses what the interpolation misses by `residual` mm.
fn smooth(residual: f64) -> Result<(), String> {
    if residual <= RESIDUAL_MM {
        return Ok(());
    }
    Err(format!("its profile is not smooth (a series of degree {} errs by {residual:.1e} mm)", NODES - 1))
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
