//! The law of a design: which camera each half is to be.

use crate::num::scalar::Differentiable;
use crate::scene::PrismLaw;

/// The virtual camera that a design makes of the right half; the left one is its mirror image. In its frame, turned by `toe`
/// about y at O' = (half the baseline, 0, z), a point at (X, Y, Z) is seen at u = f_x X/Z + c_x + kappa(v) and v = f_y Y/Z from
/// the middle of the half image, with kappa(v) = (b + c_x)(sqrt(1 + v^2/f_y^2) - 1) where `rows`, else 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DesignedLaw {
    /// f_x and f_y, in mm.
    pub focal_mm: [f64; 2],
    /// c_x, where the axis meets the sensor, from the middle of the half image, in mm.
    pub centre_x_mm: f64,
    /// O', in the prism's frame, in mm.
    pub eye_mm: [f64; 3],
    /// The angle from z to the axis, towards the ridge where it is positive, in rad.
    pub toe_rad: f64,
    /// Whether each row is shifted by its kappa.
    pub rows: bool,
}

/// A free number of the law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::design) enum LawNumber {
    FocalX,
    FocalY,
    CentreX,
    EyeZ,
    Toe,
}

/// The law over any kind of number.
#[derive(Debug, Clone, Copy)]
pub(in crate::design) struct LawOf<N> {
    /// f_x, f_y, c_x, z of O', and the tangent of the toe.
    pub(in crate::design) numbers: [N; 5],
    /// x of O'.
    pub(in crate::design) eye_x_mm: f64,
    /// b where rows are shifted.
    pub(in crate::design) half_centre_mm: Option<f64>,
}

impl LawNumber {
    /// Its place in [`LawOf::numbers`].
    pub(in crate::design) fn place(self) -> usize {
        self as usize
    }
}

impl<N: Differentiable> LawOf<N> {
    /// Where the camera sees what lies at the end of the ray through `point` along `direction`, at z = `depth_mm`, which may be
    /// infinite, less kappa of the row `v_mm`.
    pub(in crate::design) fn image(&self, point: [N; 3], direction: [N; 3], depth_mm: f64, v_mm: f64) -> [N; 2] {
        let [fx, fy, cx, z, toe] = self.numbers;

        // Go to the depth, seen from O'.
        let w = if depth_mm.is_finite() {
            let way = (N::constant(depth_mm) - point[2]) / direction[2];
            let at = |k: usize| point[k] + way * direction[k];
            [at(0) - N::constant(self.eye_x_mm), at(1), N::constant(depth_mm) - z]
        } else {
            direction
        };

        // Turn the axis, each coordinate divided by the cosine of the toe.
        let secant = (N::constant(1.0) + toe * toe).sqrt();
        let turned = [w[0] + toe * w[2], w[1] * secant, w[2] - toe * w[0]];
        let v = fy * turned[1] / turned[2];
        let kappa = match self.half_centre_mm {
            None => N::constant(0.0),
            Some(b) => {
                let tilt = N::constant(v_mm) / fy;
                (cx + N::constant(b)) * ((N::constant(1.0) + tilt * tilt).sqrt() - N::constant(1.0))
            }
        };
        [fx * turned[0] / turned[2] + cx + kappa, v]
    }
}

impl From<&PrismLaw> for DesignedLaw {
    /// The same law; rows are shifted where the other has a kappa.
    fn from(law: &PrismLaw) -> Self {
        Self {
            focal_mm: law.focal_mm,
            centre_x_mm: law.c_x_mm,
            eye_mm: [0.5 * law.baseline_mm, 0.0, law.centre_z_mm],
            toe_rad: -law.tau_rad,
            rows: law.kappa_mm != 0.0,
        }
    }
}

impl DesignedLaw {
    /// The law as a scene states it. `half_centre_mm` is b.
    pub(in crate::design) fn stated(&self, half_centre_mm: f64) -> PrismLaw {
        PrismLaw {
            focal_mm: self.focal_mm,
            c_x_mm: self.centre_x_mm,
            baseline_mm: 2.0 * self.eye_mm[0],
            centre_z_mm: self.eye_mm[2],
            tau_rad: -self.toe_rad,
            kappa_mm: if self.rows { half_centre_mm + self.centre_x_mm } else { 0.0 },
        }
    }

    /// The law as numbers of any kind. `half_centre_mm` is b.
    pub(in crate::design) fn of<N: Differentiable>(&self, half_centre_mm: f64) -> LawOf<N> {
        let Self { focal_mm: [fx, fy], centre_x_mm, eye_mm, toe_rad, rows } = *self;
        LawOf {
            numbers: [fx, fy, centre_x_mm, eye_mm[2], libm::tan(toe_rad)].map(N::constant),
            eye_x_mm: eye_mm[0],
            half_centre_mm: rows.then_some(half_centre_mm),
        }
    }

    /// The direction from O', scaled to z = 1, in which the camera of the half image centre b sees the pixel at (u, v), in mm.
    pub(in crate::design) fn direction(&self, half_centre_mm: f64, [u_mm, v_mm]: [f64; 2]) -> [f64; 2] {
        let [fx, fy] = self.focal_mm;
        let kappa =
            if self.rows { (half_centre_mm + self.centre_x_mm) * (libm::hypot(1.0, v_mm / fy) - 1.0) } else { 0.0 };
        let [x, y] = [(u_mm - self.centre_x_mm - kappa) / fx, v_mm / fy];
        let (sin, cos) = libm::sincos(self.toe_rad);
        let z = cos + sin * x;
        [(cos * x - sin) / z, y / z]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What lies in the direction of a pixel is seen there, near and far.
    #[test]
    fn a_pixel_sees_what_lies_in_its_direction() {
        for rows in [false, true] {
            let law =
                DesignedLaw { focal_mm: [34.0, 36.0], centre_x_mm: 0.4, eye_mm: [6.0, 0.0, 2.0], toe_rad: 0.05, rows };
            let (u, v) = (-1.7, 2.3);
            let [x, y] = law.direction(2.64, [u, v]);
            let point = [6.0 + 100.0 * x, 100.0 * y, 102.0];
            for depth_mm in [300.0, f64::INFINITY] {
                let [su, sv] = law.of::<f64>(2.64).image(point, [x, y, 1.0], depth_mm, v);
                assert!((su - u).abs() < 1e-13 && (sv - v).abs() < 1e-13, "{rows} {depth_mm}: {su} {sv}");
            }
        }
    }
}
