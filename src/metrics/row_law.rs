//! The row law: a pinhole but for a known shift of each row, as a prism has it whose epipolar lines are the rows.
//!
//! A point at (X, Y, Z) from the centre is seen at v = f_y Y/Z and u = f_x X/Z + c_x + kappa(v), the same at every depth, with
//! kappa(v) = b (sqrt(1 + v^2/f^2) - 1). Of a pair of such images the vertical disparity is 0, and a matcher needs one constant a
//! row.

use super::deviation::Unmeasurable;
use super::observation::Observation;
use super::pinhole::Pinhole;
use super::reprojection::{self, Parameter};
use glam::{DVec2, DVec3};

/// The shift of each row of an image along it: kappa(v) = b (sqrt(1 + v^2/f^2) - 1), v from the middle row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RowShift {
    /// b, in px: above 0 where rows are shifted to the right.
    pub amplitude_px: f64,
    /// f, in px.
    pub focal_px: f64,
    /// The middle row, in px.
    pub middle_px: f64,
}

impl RowShift {
    /// kappa of the row at `y_px`, in px.
    pub fn at(&self, y_px: f64) -> f64 {
        let slope = (y_px - self.middle_px) / self.focal_px;
        // sqrt(1 + s^2) - 1, without the difference of two numbers near 1.
        self.amplitude_px * slope * slope / (libm::hypot(1.0, slope) + 1.0)
    }

    /// Where a pinhole would see what is seen at `image_px`.
    #[must_use]
    pub fn undone(&self, image_px: DVec2) -> DVec2 {
        image_px - DVec2::new(self.at(image_px.y), 0.0)
    }

    /// Where is seen what a pinhole would see at `pinhole_px`: the inverse of [`RowShift::undone`].
    #[must_use]
    pub fn applied(&self, pinhole_px: DVec2) -> DVec2 {
        pinhole_px + DVec2::new(self.at(pinhole_px.y), 0.0)
    }
}

/// How far an image is from the row law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RowDeviation {
    /// N, the count of points.
    pub n: usize,
    /// sqrt(sum e^2 / N) along u and along v, in px.
    pub rms_px: DVec2,
    /// Largest |e| of the vectors, in px.
    pub max_px: f64,
}

impl RowDeviation {
    /// The sizes of `residuals_px`, found minus ideal.
    fn of(residuals_px: &[DVec2]) -> Self {
        let squares: DVec2 = residuals_px.iter().map(|e| *e * *e).sum();
        Self {
            n: residuals_px.len(),
            rms_px: (squares / residuals_px.len() as f64).map(f64::sqrt),
            max_px: residuals_px.iter().fold(0.0, |most: f64, e| most.max(e.length())),
        }
    }

    /// Two images taken together.
    #[must_use]
    pub fn pooled(&self, other: &Self) -> Self {
        let (a, b) = (self.n as f64, other.n as f64);
        let squares = self.rms_px * self.rms_px * a + other.rms_px * other.rms_px * b;
        Self { n: self.n + other.n, rms_px: (squares / (a + b)).map(f64::sqrt), max_px: self.max_px.max(other.max_px) }
    }
}

/// What is free in the law over several depths: X and Z of its centre, f_x, f_y and c_x. Nothing turns it or moves it up or down,
/// so that what is left in v is what two images have of vertical disparity.
pub(crate) const ROW_LAW: [Parameter; 5] =
    [Parameter::ShiftX, Parameter::ShiftZ, Parameter::FocalX, Parameter::FocalY, Parameter::PrincipalX];

/// What is free of it over one depth, which does not tell focal lengths from distances.
pub(crate) const ROW_LAW_AT_ONE_DEPTH: [Parameter; 2] = [Parameter::ShiftX, Parameter::ShiftZ];

/// The deviation of an image from the row law that fits it best, beginning at the centre and the focal lengths of `start`, of
/// which `free` are fitted. `rows` is undone before; without it the rows are taken as they are.
///
/// # Errors
/// As [`reprojection::fit`].
pub fn deviation(
    start: &Pinhole,
    free: &[Parameter],
    rows: Option<&RowShift>,
    observations: &[Observation],
) -> Result<RowDeviation, Unmeasurable> {
    let undone = |o: &Observation| Observation { image_px: rows.map_or(o.image_px, |r| r.undone(o.image_px)), ..*o };
    let observations: Vec<Observation> = observations.iter().map(undone).collect();
    // Stand at the centre of `start`, but look along z.
    let centre_mm: DVec3 = start.centre_mm();
    let parallel = Pinhole { focal_px: start.focal_px, ..Pinhole::parallel(centre_mm, 1.0, 1.0, start.principal_px) };
    Ok(RowDeviation::of(&reprojection::fit(&parallel, free, &observations)?.residuals_px))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROWS: RowShift = RowShift { amplitude_px: 480.0, focal_px: 6400.0, middle_px: 540.0 };

    /// Points at three depths as a law sees them with f_x = 6300, f_y = 6400, c_x = 7 px from (20, 0, -3).
    fn observations(noise: f64) -> Vec<Observation> {
        let grid = |k: i32| (-3..=3).flat_map(move |i| (-3..=3).map(move |j| (i, j, k)));
        let seen = |(i, j, k): (i32, i32, i32)| {
            let z = [500.0, 1000.0, 2000.0][k as usize];
            let point_mm = DVec3::new(0.02 * f64::from(i) * z, 0.026 * f64::from(j) * z, z);
            let p = (point_mm - DVec3::new(20.0, 0.0, -3.0)).truncate() / (z + 3.0);
            let pinhole = DVec2::new(487.0 + 6300.0 * p.x, 540.0 + 6400.0 * p.y);
            let sign = if (i + j + k) % 2 == 0 { noise } else { -noise };
            Observation { point_mm, image_px: ROWS.applied(pinhole) + DVec2::new(0.0, sign) }
        };
        (0..3).flat_map(grid).map(seen).collect()
    }

    fn start() -> Pinhole {
        Pinhole::parallel(DVec3::new(12.0, 0.0, 0.0), 35.0, 0.0055, DVec2::new(480.0, 540.0))
    }

    #[test]
    fn kappa_is_its_closed_form() {
        // The design paper's camera: 1.73 px at the top row.
        let paper = RowShift { amplitude_px: 480.0, focal_px: 35.0 / 0.0055, middle_px: 540.0 };
        assert!((paper.at(0.0) - 480.0 * (libm::hypot(1.0, 540.0 * 0.0055 / 35.0) - 1.0)).abs() < 1e-12);
        assert!((paper.at(0.0) - 1.725).abs() < 1e-3, "{}", paper.at(0.0));
        let p = DVec2::new(3.0, 900.0);
        assert!((paper.undone(paper.applied(p)) - p).length() < 1e-12 && paper.at(540.0) == 0.0);
    }

    #[test]
    fn what_obeys_the_law_leaves_nothing_once_kappa_is_undone() {
        let undone = deviation(&start(), &ROW_LAW, Some(&ROWS), &observations(0.0)).unwrap();
        assert!(undone.n == 147 && undone.max_px < 1e-7, "{undone:?}");
        // With kappa it is a row's shift too much, in u alone.
        let raw = deviation(&start(), &ROW_LAW, None, &observations(0.0)).unwrap();
        assert!(raw.rms_px.x > 0.3 && raw.rms_px.y < 1e-4 * raw.rms_px.x, "{raw:?}");
    }

    #[test]
    fn what_is_wrong_in_v_stays_in_v() {
        let noisy = deviation(&start(), &ROW_LAW, Some(&ROWS), &observations(0.25)).unwrap();
        // The fit takes little of a change from point to point.
        assert!((noisy.rms_px.y - 0.25).abs() < 0.01 && noisy.rms_px.x < 1e-2, "{noisy:?}");
        let pooled = noisy.pooled(&RowDeviation { n: 147, rms_px: DVec2::ZERO, max_px: 0.0 });
        assert!((pooled.rms_px * 2f64.sqrt() - noisy.rms_px).length() < 1e-12 && pooled.n == 294);
        assert_eq!(pooled.max_px, noisy.max_px);
    }
}
