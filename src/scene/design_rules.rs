//! What the keys of `[prism.design]` ask of each other, and where a baseline puts the ridge.

use super::design_model::{DesignSettings, Objective, Rear};
use super::limits::{LONGEST_MM, SHORTEST_MM};
use super::model::{BiprismSpec, CameraSpec};
use super::source::ValueSource;
use crate::error::Error;
use crate::optics::snell::straightening_facet_rad;

/// What a design is asked for, its objective has.
pub(super) fn goal(source: &dyn ValueSource, settings: &DesignSettings) -> Result<(), Error> {
    let goal = &settings.goal;
    let marched = settings.objective == Objective::March;
    let refuse = |key: &str, rule: String, help: &str| Err(source.refuse(&format!("prism.design.{key}"), rule, help));
    if marched && goal.rear != Rear::Own {
        let rule = "`prism.design.rear` asks for one rear surface, and `march` makes one for each half".to_owned();
        return refuse("rear", rule, "add objective = \"epipolar\" to [prism.design], or leave `rear` out");
    }
    if marched && goal.spot_weight > 0.0 {
        let rule = format!("`prism.design.spot_weight` is {}, and `march` does not know the lens", goal.spot_weight);
        return refuse("spot_weight", rule, "add another objective to [prism.design], or leave `spot_weight` out");
    }
    if goal.square && settings.objective != Objective::Pinhole {
        let rule = "`prism.design.square` is said of an objective other than \"pinhole\"".to_owned();
        return refuse("square", rule, "write objective = \"pinhole\", or leave `square` out");
    }
    if goal.spot_weight > 0.0 && goal.f_number.is_none() {
        let rule = format!("`prism.design.spot_weight` is {}, and no aperture is given", goal.spot_weight);
        return refuse("spot_weight", rule, "add aperture = 8.0 to [prism.design], the f-number of the lens");
    }
    Ok(())
}

/// `prism` with its ridge where the virtual cameras of the right and the left half are `baseline_mm` apart; their distance
/// from the middle is that of the flat base where the central ray of a half image leaves it.
///
/// # Errors
/// When the ridge would have to be nowhere a prism can be.
pub(super) fn with_baseline(
    source: &dyn ValueSource,
    prism: BiprismSpec,
    camera: &CameraSpec,
    baseline_mm: f64,
) -> Result<BiprismSpec, Error> {
    // Find facet and ray, as for the virtual camera of the design; a facet that cannot be is refused there.
    let (ratio, delta) = (prism.body.index / prism.body.outer_index, camera.half_centre_rad());
    let Some(alpha) = prism.facet_angle_rad.or_else(|| straightening_facet_rad(ratio, delta)) else {
        return Ok(prism);
    };
    let in_glass = match prism.facet_angle_rad {
        None => 0.0,
        Some(_) => libm::tan(libm::asin(libm::sin(alpha + delta) / ratio) - alpha),
    };

    // The ray leaves at x = D tan(delta)/(1 - q) + (D + T - D/(1 - q)) in_glass with q = tan(delta) tan(alpha): solve for D.
    let tan_delta = libm::tan(delta);
    let rise = 1.0 / (1.0 - tan_delta * libm::tan(alpha));
    let ridge_distance_mm =
        (0.5 * baseline_mm - prism.thickness_mm * in_glass) / (tan_delta * rise + (1.0 - rise) * in_glass);
    if !(SHORTEST_MM..=LONGEST_MM).contains(&ridge_distance_mm) {
        let rule = format!(
            "`prism.design.baseline_mm` is {baseline_mm}, which puts the ridge at z = {ridge_distance_mm:.3} mm, and it must be \
             within {SHORTEST_MM} .. {LONGEST_MM}"
        );
        let help =
            "give a baseline that the camera's half angle reaches, or leave it out and give `prism.ridge_distance_mm`";
        return Err(source.refuse("prism.design.baseline_mm", rule, help));
    }
    Ok(BiprismSpec { ridge_distance_mm, ..prism })
}
