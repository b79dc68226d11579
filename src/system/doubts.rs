//! Doubts about an instrument that can be: what its maker may not have meant, each with what to write instead.

use super::instrument::System;
use super::light::{LightStudy, PassedRay, grid, shares, some_variants};
use super::shape_doubts;
use crate::effect::EffectId;
use crate::optics::fate::Fate;
use crate::prism::side::Side;
use crate::scene::{GlassSpec, PrismSpec, Scene};
use std::collections::BTreeMap;

/// Glass thinner than this, in mm, is no prism.
const THINNEST_MM: f64 = 0.1;
/// A virtual camera of a focal length so many times longer or shorter than that of the camera is hardly meant.
const LARGEST_FOCAL_RATIO: f64 = 4.0;
/// Places of the picture at which the rays of the pupil are asked, along its width and its height.
const PUPIL_PLACES: [usize; 2] = [9, 7];
/// Points of the pupil, and slopes of rough surfaces, that are asked.
const PUPIL_POINTS: usize = 64;

/// What gives reason to doubt a scene whose instrument is `system`, in sentences; empty of one without reasons.
pub fn doubts(scene: &Scene, system: &System) -> Vec<String> {
    let mut doubts: Vec<String> = scene.prism.body().and_then(GlassSpec::index_doubt).into_iter().collect();
    if let PrismSpec::Mesh(mesh) = &scene.prism {
        doubts.extend(mesh.told.clone());
    }
    if !scene.objects.is_empty() {
        doubts.push(
            "`[[object]]` may hide corners of the board: where they are compared with true ones, those count as missed"
                .to_owned(),
        );
    }
    if system.prism.is_none() {
        doubts.extend(glassless(scene));
        return doubts;
    }
    doubts.extend(law_in_other_units(scene, system));
    let study = LightStudy::new(system);
    doubts.extend(shape_doubts::of(scene, system));
    doubts.extend(few_points(system));
    doubts.extend(thin(&study.passed));
    doubts.extend(near(scene, &study.passed));
    doubts.extend(unseen_half(&study));
    doubts.extend(lost(&study));
    doubts.extend(board_in_front(&study));
    doubts.extend(beam(system));
    doubts
}

/// Effects that act by a glass that the scene has not.
fn glassless(scene: &Scene) -> Option<String> {
    let rims = scene.effects.clipping.is_some_and(|clipping| clipping.outline.is_some() || clipping.chamfer_mm > 0.0);
    let idle = scene.effects.acting().filter(|row| row.of_glass || (row.id == EffectId::Clipping && rims));
    let idle: Vec<String> = idle.map(|row| format!("`[effect.{}]`", row.key())).collect();
    let (acts, them) = if idle.len() == 1 { ("acts", "it") } else { ("act", "them") };
    (!idle.is_empty()).then(|| {
        let words = idle.join(", ");
        format!(
            "{words} {acts} by the glass of a prism, and `prism.kind` is \"none\": take {them} out, or give a prism"
        )
    })
}

/// A law whose focal lengths are those of another camera.
fn law_in_other_units(scene: &Scene, system: &System) -> Option<String> {
    let law = system.designed.as_ref()?.law()?;
    let camera_mm = scene.camera.focal_length_mm;
    let far = |mm: f64| mm / camera_mm > LARGEST_FOCAL_RATIO || camera_mm / mm > LARGEST_FOCAL_RATIO;
    let mm = law.focal_mm.into_iter().find(|mm| far(*mm))?;
    Some(format!(
        "`prism.law.f_mm` has {mm} where the camera has {camera_mm} mm: give it in mm on the sensor, {:.4} of pixels of \
         {} um where it is in px",
        mm * scene.camera.pitch_mm,
        1000.0 * scene.camera.pitch_mm
    ))
}

fn few_points(system: &System) -> Option<String> {
    let fits = system.designed.as_ref()?.fits()?;
    let (key, fit) = ["prism.front", "prism.back"].into_iter().zip(fits).find(|(_, fit)| fit.says_little())?;
    Some(format!(
        "`{key}` has {} points for {} coefficients, so that its residuals say little of it: give more points, or a lower \
         `degree`",
        fit.points, fit.coefficients
    ))
}

fn thin(passed: &[PassedRay]) -> Option<String> {
    let thickness = |p: &PassedRay| p.met_mm[0].distance(p.met_mm[1]);
    let thinnest = passed.iter().min_by(|a, b| thickness(a).total_cmp(&thickness(b)))?;
    let [front, _] = thinnest.met_mm;
    (thickness(thinnest) < THINNEST_MM).then(|| {
        format!(
            "the glass is {:.2e} mm thin at ({:.3}, {:.3}) mm, below {THINNEST_MM} mm: check the unit of its surfaces \
             (`unit = \"m\"`, \"in\"), their `offset_mm`, or the thickness",
            thickness(thinnest),
            front.x,
            front.y
        )
    })
}

fn near(scene: &Scene, passed: &[PassedRay]) -> Option<String> {
    if scene.effects.lens.telecentric().is_some() {
        return None;
    }
    let body = scene.prism.body()?;
    let pinhole = scene.camera.position_mm;
    let distance = |p: &PassedRay| (body.world_from_prism.point(p.met_mm[0]) - pinhole).z;
    let nearest = passed.iter().map(distance).min_by(f64::total_cmp)?;
    let focal = scene.camera.focal_length_mm;
    let keys = match scene.prism {
        PrismSpec::Flat(_) | PrismSpec::Freeform(..) => "`prism.ridge_distance_mm`",
        PrismSpec::Polynomial(_) => "the constant terms [0, 0, c] of front and back, or `prism.position_mm`",
        _ => "the unit of its surfaces (`unit = \"m\"`, \"in\") and their `offset_mm`",
    };
    (nearest < focal).then(|| {
        format!(
            "the glass is {nearest:.4} mm from the pinhole, nearer than the focal length of {focal} mm: check {keys}"
        )
    })
}

fn unseen_half(study: &LightStudy) -> Option<String> {
    let seen = |side: Side| study.passed.iter().any(|p| p.side == side);
    let unseen = match (seen(Side::Left), seen(Side::Right)) {
        (true, false) => "right",
        (false, true) => "left",
        _ => return None,
    };
    Some(format!(
        "no ray passes the {unseen} half of the prism, so that there is one view only: move the ridge into the picture with \
         `prism.position_mm`, or check the surfaces of that half"
    ))
}

fn lost(study: &LightStudy) -> Option<String> {
    let words = study.fates();
    if words.is_empty() || study.passed.is_empty() {
        return None;
    }
    let all = study.passed.len() + study.lost.values().sum::<usize>();
    let help = match study.lost.iter().max_by_key(|(_, n)| **n) {
        Some((Fate::TotalReflection, _)) => "a smaller index or gentler surfaces would let them pass",
        Some((Fate::Clipped, _)) => "`effect.clipping` takes them",
        _ => "surfaces that reach farther in x and y would let them pass",
    };
    Some(format!(
        "only {:.1} % of the rays pass the prism ({words}): {help}",
        100.0 * study.passed.len() as f64 / all as f64
    ))
}

fn board_in_front(study: &LightStudy) -> Option<String> {
    let none = !study.passed.is_empty() && study.passed.iter().all(|p| !p.reaches_board);
    none.then(|| {
        "every ray leaves the glass behind the board or away from it: check `board.position_mm`, and the unit and place of \
         the surfaces (`unit`, `offset_mm`)"
            .to_owned()
    })
}

/// Rays of the pupil, and of rough surfaces, that end at the prism where the ray through the middle passes.
fn beam(system: &System) -> Option<String> {
    // Count the rays that end where the middle one passes.
    let variants = some_variants(system, PUPIL_POINTS);
    let places: Vec<_> = grid(system, PUPIL_PLACES).filter(|px| system.exit_ray(*px).is_ok()).collect();
    let mut ended: BTreeMap<Fate, usize> = BTreeMap::new();
    for (px, variant) in places.iter().flat_map(|px| variants.iter().map(move |variant| (px, variant))) {
        if let Err(fate) = variant.exit_ray(*px)
            && fate != Fate::Clipped
        {
            *ended.entry(fate).or_default() += 1;
        }
    }
    let all = places.len() * variants.len();
    let count: usize = ended.values().sum();
    if count == 0 {
        return None;
    }

    // Say what would let them pass.
    let spare = system.effects.spare_mm(0.0, 0.0, 1.0);
    let share = 100.0 * count as f64 / all as f64;
    let words = shares(&ended, all);
    let mostly_missed = ended.iter().max_by_key(|(_, n)| **n).is_some_and(|(fate, _)| *fate != Fate::TotalReflection);
    Some(if mostly_missed && spare > 0.0 {
        format!(
            "the beam leaves the prism's surfaces: {share:.1} % of the rays of the pupil end there ({words}) though those \
             through its middle pass; give surfaces that reach {spare:.2} mm farther on every side, as `biprism design` does \
             for the scene that it is given"
        )
    } else {
        format!(
            "a part of the beam ends at the prism: {share:.1} % of its rays ({words}) though those through the middle of the \
             pupil, and of smooth surfaces, pass; a smaller index, gentler or smoother surfaces would let them pass"
        )
    })
}
