//! What two values of a scene say of each other, beyond the range of each; the rules of effects stand in `effects::rules`.

use super::design_model::*;
use super::limits::{LEAST_AXIS_DEG, MARCHED_POINTS};
use super::model::*;
use super::source::ValueSource;
use crate::effect::Effects;
use crate::error::Error;
use crate::geom::Rect;
use crate::num::bernstein::MAX_DEGREE;
use crate::surface::shape::RevolvedPatch;
use glam::DVec3;

/// A name may become a file's name on any system.
pub(super) fn name(source: &dyn ValueSource, name: &str) -> Result<(), Error> {
    let allowed = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "_-".contains(c);
    match name.chars().find(|c| !allowed(*c)).or(name.chars().next().filter(|c| *c == '-')) {
        None => Ok(()),
        Some(c) => {
            let rule = format!("`name` is {name:?}, and {c:?} may not stand there");
            Err(source.refuse("name", rule, "use lower-case letters, digits, - and _, and begin without -"))
        }
    }
}

/// What a sensor's gamma has coded is written as it is.
pub(super) fn coded_once(source: &dyn ValueSource, encoding: Encoding, effects: &Effects) -> Result<(), Error> {
    let gamma = effects.sensor.map_or(1.0, |sensor| sensor.gamma);
    if encoding == Encoding::Linear || gamma == 1.0 {
        return Ok(());
    }
    let rule = format!(
        "`output.encoding` is \"srgb\" beside `effect.sensor.gamma` {gamma}, and the picture would be coded twice"
    );
    let help = "write \"linear\", which keeps the sensor's values as they are, or take `gamma` out";
    Err(source.refuse("output.encoding", rule, help))
}

/// No two directions are seen in one place of the sensor by the distortion, which `key` gives.
pub(super) fn picture_is_not_folded(source: &dyn ValueSource, key: &str, camera: &CameraSpec) -> Result<(), Error> {
    let principal_px = camera.principal_px();
    let size_px = 2.0 * camera.middle_px();
    let folds = camera.calibrated().and_then(|pinhole| pinhole.fold_px(-principal_px, size_px - principal_px));
    let Some(place) = folds else { return Ok(()) };
    let at = place + principal_px;
    let rule = format!(
        "`{key}` gives k1, k2, p1, p2, k3 as {:?}, by which the picture folds over {:.1} px from the principal point, at \
         ({:.1}, {:.1}): two directions would be seen in one place there",
        camera.calibration.distortion.coefficients(),
        place.length(),
        at.x,
        at.y
    );
    let help = "give coefficients that hold up to the corners of the sensor and a twentieth of its size beyond, in the order \
                k1, k2, p1, p2, k3: calibrate with corners near the border, or with fewer coefficients";
    Err(source.refuse(key, rule, help))
}

/// A telecentric lens has neither a principal point nor tangents to distort.
pub(super) fn calibrated_pinhole(
    source: &dyn ValueSource,
    camera: &CameraSpec,
    effects: &Effects,
) -> Result<(), Error> {
    if effects.lens.telecentric().is_none() || camera.calibrated().is_none() {
        return Ok(());
    }
    let rule = "`[effect.telecentric]` stands beside a principal point, a rotation or a distortion of the camera, which are of a \
                pinhole or a thin lens";
    let help =
        "take these out of `[camera]`, and turn or move prism and board instead; or take `[effect.telecentric]` out";
    Err(source.refuse("effect.telecentric", rule.to_owned(), help))
}

/// What the keys of a design say of each other.
pub(super) fn design(source: &dyn ValueSource, settings: &DesignSettings, camera: &CameraSpec) -> Result<(), Error> {
    marched_points(source, settings, camera)?;
    if settings.surface == DesignedSurface::Revolved && settings.objective == Objective::March {
        let rule = "`prism.design.surface` is \"revolved\", and the march makes no surfaces of revolution".to_owned();
        let help = "write `objective = \"epipolar\"` or \"toed-in\", or take `surface` out";
        return Err(source.refuse("prism.design.surface", rule, help));
    }
    if settings.surface == DesignedSurface::Revolved && settings.by_least_squares() {
        let rule = "`prism.design.surface` is \"revolved\" beside an objective, a rear or a spot weight that no surface of revolution has"
            .to_owned();
        let help = "write `objective = \"epipolar\"` or \"toed-in\" with their own rears, or take `surface` out";
        return Err(source.refuse("prism.design.surface", rule, help));
    }
    if let (Some(z_mm), true) = (settings.virtual_camera_z_mm, settings.by_least_squares()) {
        let rule = format!("`prism.design.virtual_camera_z_mm` is {z_mm}, and least squares choose it");
        return Err(source.refuse("prism.design.virtual_camera_z_mm", rule, "take it out"));
    }
    let z_mm = settings.virtual_camera_z_mm.unwrap_or(1.0);
    let (objective, rule, help) = match settings.objective {
        Objective::Epipolar if settings.virtual_camera_z_mm.is_some_and(|z_mm| z_mm != 0.0) => {
            ("epipolar", "must be 0", "take it out, or write `objective = \"toed-in\"`")
        }
        Objective::ToedIn if z_mm == 0.0 => ("toed-in", "must not be 0", "take it out for the default, or give -6"),
        _ => return Ok(()),
    };
    let rule = format!("`prism.design.virtual_camera_z_mm` is {z_mm} beside `objective = \"{objective}\"`, and {rule}");
    Err(source.refuse("prism.design.virtual_camera_z_mm", rule, help))
}

/// A design marches a bounded number of points.
fn marched_points(source: &dyn ValueSource, settings: &DesignSettings, camera: &CameraSpec) -> Result<(), Error> {
    let pixels = (camera.width_px as f64 / 2.0) * camera.height_px as f64;
    let points = pixels / (settings.step_px * settings.step_px);
    if points <= MARCHED_POINTS {
        return Ok(());
    }
    let rule = format!(
        "`prism.design.step_px` is {}, which marches {points:.1e} points over a half image; the limit is \
         {MARCHED_POINTS:e}",
        settings.step_px
    );
    let help = format!("give a step of at least {:.3}", (pixels / MARCHED_POINTS).sqrt() + 0.0005);
    Err(source.refuse("prism.design.step_px", rule, &help))
}

/// Triangles do not tell whose back they are.
pub(super) fn solid_mesh(source: &dyn ValueSource) -> Error {
    let rule = "`prism.solid` is about prisms of smooth surfaces, and this one is of triangles".to_owned();
    source.refuse("prism.solid", rule, "take it out; a mesh is one piece of glass where you give it as `body`")
}

/// The surface of revolution at `path` is a sheet: its profile keeps off the axis, and its axis off z.
pub(super) fn revolved(source: &dyn ValueSource, path: &str, patch: &RevolvedPatch) -> Result<(), Error> {
    let [low, high] = patch.profile.ends();
    if low >= high {
        let at = format!("{path}.along_mm");
        let rule = format!("`{at}` runs from {low} to {high}, which is nowhere");
        return Err(source.refuse(&at, rule, "give the smaller place along the axis first"));
    }
    let axis_deg = patch.axis.angle_between(DVec3::Z).to_degrees();
    if !(LEAST_AXIS_DEG..=180.0 - LEAST_AXIS_DEG).contains(&axis_deg) {
        let at = format!("{path}.axis");
        let rule = format!(
            "`{at}` is {:?}, and must be a direction at least {LEAST_AXIS_DEG} deg from z",
            patch.axis.to_array()
        );
        return Err(source.refuse(&at, rule, "give [1, 0, 0] for an axis along the baseline"));
    }
    let first = patch.profile.coefficients().first().copied().unwrap_or(0.0);
    let others = patch.profile.departure();
    if first > others {
        return Ok(());
    }
    let at = format!("{path}.profile_mm");
    let rule = format!(
        "`{at}` begins with {first} and the magnitudes of its other coefficients add up to {others}: the surface might reach the axis"
    );
    Err(source.refuse(&at, rule, "give the distance from the axis, which is far greater than its changes"))
}

/// The domain of the surface at `path` is somewhere, and in the right half.
pub(super) fn domain(source: &dyn ValueSource, path: &str, domain: &Rect) -> Result<(), Error> {
    let Rect { min: lower, max: upper } = domain;
    for (i, [min, max]) in [[lower.x, upper.x], [lower.y, upper.y]].into_iter().enumerate() {
        if min >= max {
            let at = format!("{path}.domain_mm[{i}]");
            let rule = format!("`{at}` runs from {min} to {max}, which is nowhere");
            let help = "give the smaller bound first: [[x_min, x_max], [y_min, y_max]]";
            return Err(source.refuse(&at, rule, help));
        }
    }
    if upper.x <= 0.0 {
        let rule = format!("`{path}.domain_mm` ends at x = {}, and the right half of the prism has x above 0", upper.x);
        let help = "describe the right half: the left one is its mirror image";
        return Err(source.refuse(&format!("{path}.domain_mm"), rule, help));
    }
    Ok(())
}

/// The term X^m Y^n at `at` is of a degree that surfaces may have.
pub(super) fn term(source: &dyn ValueSource, at: &str, m: usize, n: usize) -> Result<(), Error> {
    if m + n <= MAX_DEGREE {
        return Ok(());
    }
    let rule = format!("`{at}` is a term in X^{m} Y^{n}, of degree {}, and the limit is {MAX_DEGREE}", m + n);
    Err(source.refuse(at, rule, "leave the term out"))
}

/// Claim number `i` names a value of the report and bounds it.
pub(super) fn claim(source: &dyn ValueSource, i: usize, claim: &Expect) -> Result<(), Error> {
    let step = |s: &str| !s.is_empty() && s.chars().all(|c| c.is_ascii_alphanumeric() || "_-".contains(c));
    let value = &claim.value;
    if !value.contains('/') || !value.split('/').all(step) {
        let rule = format!("`expect[{i}].value` is {value:?}, and must be a path in the report");
        let help = "write it as freeform/pinhole/designed/mean_abs_v_mm: the design, then the keys of report.json";
        return Err(source.refuse(&format!("expect[{i}].value"), rule, help));
    }
    match (claim.min, claim.max) {
        (None, None) => {
            let rule = format!("`expect[{i}]` has neither `min` nor `max`, so it claims nothing of {value:?}");
            Err(source.refuse(&format!("expect[{i}]"), rule, "add `min = ...`, `max = ...` or both"))
        }
        (Some(min), Some(max)) if min > max => {
            let rule = format!("`expect[{i}].min` is {min}, above its `max` {max}");
            Err(source.refuse(&format!("expect[{i}].min"), rule, "give the smaller bound as `min`"))
        }
        _ => Ok(()),
    }
}
