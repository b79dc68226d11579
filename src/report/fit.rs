//! The fits of a prism's surfaces as entries of the report, and in words.

use super::json::{SurfaceFitEntry, SurfaceFits};
use crate::analysis::fit_shift::FitShift;

/// The entries of front and back.
pub fn entry(fits: &[FitShift; 2]) -> SurfaceFits {
    let [front, back] = fits.map(|fit| {
        let residuals = fit.residuals;
        SurfaceFitEntry {
            degree: residuals.degree as u64,
            coefficients: residuals.coefficients as u64,
            points: residuals.points as u64,
            rms_mm: residuals.rms_mm,
            max_mm: residuals.max_mm,
            worst_point: residuals.worst_number as u64,
            worst_mm: residuals.worst_mm.to_array(),
            rms_px: fit.px_per_mm.map(|px| px * residuals.rms_mm),
            max_px: fit.px_per_mm.map(|px| px * residuals.max_mm),
            finer_px: fit.finer_px,
        }
    });
    SurfaceFits { front, back }
}

/// A line of words for front and for back.
pub fn words(fits: &SurfaceFits) -> [String; 2] {
    [("front", &fits.front), ("back", &fits.back)].map(|(name, fit)| {
        let px = |px: Option<f64>| px.map_or(String::new(), |px| format!(" ({px:.1e} px by its sag)"));
        let finer = fit.finer_px.map_or(String::new(), |px| {
            format!("; two degrees more would move the picture by up to {px:.1e} px")
        });
        let [x, y, _] = fit.worst_mm;
        format!(
            "{name}: degree {} through {} points leaves RMS {:.1e} mm{}, largest {:.1e} mm{} at ({x:.3}, {y:.3}) mm{finer}",
            fit.degree,
            fit.points,
            fit.rms_mm,
            px(fit.rms_px),
            fit.max_mm,
            px(fit.max_px)
        )
    })
}
