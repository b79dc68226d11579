//! A user's cloud of points as a polynomial: fitted, judged by its residuals, and refused with what is wrong with it.

use super::fit::{SurfaceFit, coefficients, fit_powers};
use super::misfit::{self, CloudFitInput, Misfit};
use crate::error::Error;
use crate::surface::shape::PolynomialPatch;
use glam::DVec3;

/// How well a polynomial goes through its cloud.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitResiduals {
    /// Total degree.
    pub degree: usize,
    /// Coefficients that were fitted.
    pub coefficients: usize,
    /// Points that they were fitted to.
    pub points: usize,
    /// Root mean square of the residuals along z, in mm.
    pub rms_mm: f64,
    /// Largest residual along z, in mm.
    pub max_mm: f64,
    /// The point that has it, in mm.
    pub worst_mm: DVec3,
    /// Its number in the file, from 1.
    pub worst_number: usize,
}

impl FitResiduals {
    /// Whether there are so few points that the residuals say little: fewer than twice as many as coefficients.
    pub fn says_little(&self) -> bool {
        self.points < 2 * self.coefficients
    }
}

/// The polynomial through a cloud, and what it leaves.
///
/// # Errors
/// As [`fit_powers`]; and where a residual is above what the cloud is allowed: then the worst point and its value are
/// named, and what is to be written instead, as far as the residuals tell it.
pub(crate) fn fit_cloud(input: &CloudFitInput) -> Result<(PolynomialPatch, FitResiduals), Error> {
    let fitted = fit_powers(input.points_mm, input.degree, input.powers, None)
        .map_err(|problem| Error { place: input.name.to_owned(), ..problem })?;
    // A fit whose numbers overflow is no better than one that is too far off.
    if fitted.max_mm.is_nan() || fitted.max_mm > input.max_residual_mm {
        return Err(refused(input, &fitted));
    }
    let residuals = FitResiduals {
        degree: input.degree,
        coefficients: coefficients(input.degree, input.powers),
        points: fitted.points,
        rms_mm: fitted.rms_mm,
        max_mm: fitted.max_mm,
        worst_mm: input.points_mm[fitted.worst],
        worst_number: fitted.worst + 1,
    };
    Ok((fitted.patch, residuals))
}

fn refused(input: &CloudFitInput, fitted: &SurfaceFit) -> Error {
    let worst = input.points_mm[fitted.worst];
    let rule = format!(
        "point {} at ({:.4}, {:.4}, {:.4}) mm lies {:.3e} mm from the polynomial of degree {} (RMS of all {}: {:.3e} mm), \
         and `max_residual_mm` is {:?}",
        fitted.worst + 1,
        worst.x,
        worst.y,
        worst.z,
        fitted.max_mm,
        input.degree,
        fitted.points,
        fitted.rms_mm,
        input.max_residual_mm
    );
    // Two digits, rounded up, so that what is offered is enough.
    let enough = || {
        let step = libm::pow(10.0, libm::floor(libm::log10(fitted.max_mm)) - 1.0);
        format!("`max_residual_mm = {:.1e}`", (libm::floor(fitted.max_mm / step) + 1.0) * step)
    };
    let (found, help) = match misfit::of(input, fitted) {
        Misfit::TwoSheets { numbers: [a, b], apart_mm } => (
            format!("; points {a} and {b} stand {apart_mm:.4} mm apart over one (x, y): the cloud holds two sheets"),
            "write the front and the back into a file each".to_owned(),
        ),
        Misfit::Kink { x_mm: 0.0 } => (
            "; the surface has a kink at x = 0: the cloud holds both facets".to_owned(),
            "give the right half only, the points with x >= 0: the left half is its mirror image".to_owned(),
        ),
        Misfit::Kink { x_mm } => (
            format!("; the surface has a kink near x = {x_mm:.2} mm: the cloud holds both facets"),
            format!(
                "give the right half only, and move the ridge to x = 0: `offset_mm = [{:.4}, 0, 0]` moves the surface",
                -x_mm
            ),
        ),
        Misfit::Outliers { worst, rest_mm } => {
            let named: Vec<String> = worst.iter().take(NAMED).map(|o| outlier(input, o)).collect();
            let more = if worst.len() > NAMED { format!(" and {} more", worst.len() - NAMED) } else { String::new() };
            let (it, plural) = if worst.len() == 1 { ("it", "") } else { ("them", "s") };
            (
                format!(
                    "; without {} outlier{plural} the rest leaves {rest_mm:.1e} mm: {}{more}",
                    worst.len(),
                    named.join(", ")
                ),
                format!("remove {it} from the file, or write {} to fit through {it}", enough()),
            )
        }
        Misfit::Degree(degree) => (
            format!("; a polynomial of degree {degree} goes through all points"),
            format!("write `degree = {degree}`, or {} to take the misfit", enough()),
        ),
        Misfit::Asymmetric => (
            "; the surface is not its own mirror image in y = 0".to_owned(),
            "leave `symmetric` out, so that odd powers of y are fitted too".to_owned(),
        ),
        Misfit::Unknown => {
            (String::new(), format!("write {} if the points are no truer than that, or give truer points", enough()))
        }
    };
    Error::new(input.name, rule + &found, help)
}

/// Outliers that are named in a message.
const NAMED: usize = 5;

fn outlier(input: &CloudFitInput, found: &misfit::Outlier) -> String {
    let at = input.points_mm[found.index];
    format!("point {} at ({:.4}, {:.4}, {:.4}) is off by {:.3e} mm", found.index + 1, at.x, at.y, at.z, found.off_mm)
}
