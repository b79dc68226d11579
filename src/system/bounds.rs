//! Bounds of effects: what each changes at most, from rays over a grid of the picture.
//!
//! Every bound is of one effect against the instrument without it, alone and among the others: rays that stray through a lens
//! meet other factors, a lamp makes light brighter, and the sensor makes numbers of it. Where what is bounded is smooth, its extremes between the
//! rays of the grid are covered by the largest step from one ray to the next. With M the brightest radiance of the scene and C the
//! largest contrast in it:
//!
//! - Factors of light from g0 to g1 change a pixel by at most M |g1 - g0|. An edge is where pixels cross the middle of its
//!   two sides; a factor that changes by a share q from one pixel to the next moves it by q mean / (white - black) px.
//! - Where variants see points that are d px across a line from those of the instrument itself, the line moves by d px. It
//!   sweeps at most s d of a pixel, where s is the longest that a line of its direction is in one; so a pixel changes by at most
//!   C s d for each line through it, and a mean over variants by the mean of that. The image of the ridge moves by a way of its
//!   own, and parts contents of any contrast; it is no edge of the board.
//! - A ground ridge that is d px wide takes at most sqrt(2) d of a pixel and M from that. A rim or a stop that is seen has no bound but M.
//! - Diffraction moves light by r px with a known distribution, and each part of it changes a pixel as a displacement by r.
//! - Ghosts add at most their power times the brightest thing to be seen, or times what lies behind the camera. What moves,
//!   stops or weakens their rays changes at most all of their light, since a pixel in which routes part is sampled by a few rays.
//! - What changes pixels by up to g on both sides of an edge, which is a ramp over one pixel, moves it by at most
//!   2 g / (white - black) px.

use super::displacement_bounds::{displaced_among, displacements, variants};
use super::factor_bounds::{PairedVariants, factors, strayed};
use super::instrument::System;
use super::output_gain::{OutputGain, lamp_range};
use super::radiance_range::{Bound, GRID, RadianceRange, SMALL_GRID, extremes, grid};
use super::ridge_image::{INSET_PX, ridge, rows};
use crate::effect::clipping::Clipping;
use crate::effect::diffraction::{encircled_energy, leaving_square};
use crate::effect::{Bounding, EffectId, EffectRow, Effects, Variant};
use crate::prism::reflections::Exit;
use crate::prism::side::Side;
use crate::scene::Scene;
use crate::surface::face::Face;
use glam::DVec2;
use rayon::prelude::*;
use std::f64::consts::SQRT_2;

/// Variants of other effects among which the width of a ground ridge is looked at.
const CHAMFERS: usize = 64;
/// Rays along the width and the height of the grid of ghosts, whose power has steps where one of them begins.
const FINE_GRID: [usize; 2] = [129, 65];

/// What an effect of `scene`, whose instrument without effects is `ideal` and whose changes grow by `gain`, changes at most,
/// at the output and whatever other effects of the scene are simulated; `None` where that is not known.
pub(super) fn bound(ideal: &System, scene: &Scene, gain: &OutputGain, row: &EffectRow) -> Option<Bound> {
    let effects = &scene.effects;
    // Another camera is another picture: what it sees is what the others change.
    let stands_on =
        |other: &EffectRow| other.id != row.id && (other.id == EffectId::Telecentric || row.needs == Some(other.id));
    let strays = |other: &EffectRow| other.id != row.id && other.bounding == Bounding::Displacements;
    let of = |has: &dyn Fn(&EffectRow) -> bool| ideal.with_effects(&effects.only(has));
    let without = of(&stands_on);
    let with = of(&|other| other.id == row.id || stands_on(other));

    // Light that a lamp makes brighter than the scene's radiances makes every change of it larger.
    let lamp = match row.id {
        EffectId::Lamp => 1.0,
        EffectId::Ghosts => gain.lamp_anywhere,
        _ => gain.lamp,
    };
    let unlit = RadianceRange::of(&without);
    let light = unlit.times(lamp);

    // Bound it alone, and among the effects that let rays stray.
    let stray = effects.acting().any(strays);
    let found = match row.bounding {
        Bounding::Factors => {
            let alone = factors(&PairedVariants::all(&without, &with), light, GRID);
            let among = stray.then(|| {
                let without = of(&|other| stands_on(other) || strays(other));
                let with = of(&|other| other.id == row.id || stands_on(other) || strays(other));
                factors(&PairedVariants::all(&without, &with), light, SMALL_GRID)
            });
            Some(among.map_or(alone, |among| alone.or(among)).or(lamp_bound(ideal, scene, row, light)))
        }
        Bounding::Displacements => {
            let alone = displacements(&without, &with, light)?;
            let among = match stray {
                true => displaced_among(ideal, effects, row, light)?,
                false => alone,
            };
            Some(alone.or(among).and(strayed(ideal, effects, row, light)))
        }
        Bounding::Borders => borders(&without, ideal, scene, light),
        Bounding::Spread => spread(effects, light),
        Bounding::Added => added(ideal, effects, light),
        Bounding::Never(_) => None,
    };

    // Add what it changes of the ghosts, but for what they stand on, which goes after them only.
    let found = found.map(|found| {
        let ghosts = effects.ghosts.filter(|ghosts| !ghosts.is_nothing());
        let brought = match row.id {
            EffectId::Ghosts | EffectId::Fresnel => None,
            _ => ghosts.and_then(|_| added(ideal, effects, unlit.times(gain.lamp_anywhere))),
        };
        // Rays that stray, or are stopped, may take another route in the glass, and meet other factors where ghosts lie; a
        // factor of the place in the picture, or what is collected there, is the same for them.
        let share = match row.id {
            EffectId::Cos4 => (found.grey / light.brightest).min(1.0),
            EffectId::Diffraction => (found.grey / light.contrast.max(f64::MIN_POSITIVE)).min(1.0),
            _ => 1.0,
        };
        brought.map_or(found, |Bound { grey, px }| found.and(Bound { grey: share * grey, px: share * px }))
    });

    // The sensor has the last word.
    let found = found.map(|bound| gain.at_output(bound));
    found.filter(|bound| bound.grey.is_finite() && bound.px.is_finite())
}

/// Rims and stops, with the pupil and all else that lets rays stray; a ground ridge by its width.
fn borders(without: &System, ideal: &System, scene: &Scene, light: RadianceRange) -> Option<Bound> {
    let clipping = scene.effects.clipping?;
    let others =
        scene.effects.only(|row| matches!(row.bounding, Bounding::Displacements) || row.id == EffectId::Telecentric);
    let rims = Clipping { chamfer_mm: 0.0, ..clipping };
    if !rims.is_nothing() {
        // Ghosts walk sideways in the glass, where a rim may stop them.
        if scene.effects.ghosts.is_some_and(|ghosts| !ghosts.is_nothing()) {
            return None;
        }
        let effects = Effects { clipping: Some(rims), ..others.clone() };
        let system = ideal.with_effects(&effects);
        // Nothing is clipped where the least margin along the border of the picture is more than its largest step there.
        let clear = |variant: &Variant| {
            let system = system.variant(variant);
            let margins: Vec<f64> = outline(&system).iter().map(|px| system.margin_mm(*px)).collect();
            let step = margins.windows(2).map(|m| (m[0] - m[1]).abs()).fold(0.0, f64::max);
            margins.iter().all(|margin| *margin > step)
        };
        if !variants(&others)?.par_iter().all(clear) {
            return None;
        }
    }
    if clipping.chamfer_mm == 0.0 {
        return Some(Bound { grey: 0.0, px: 0.0 });
    }
    // Others may bring the ridge into the picture, or bring it nearer.
    let with = ideal.with_effects(&others);
    let all = variants(&others)?;
    let some = all.iter().step_by(all.len().div_ceil(CHAMFERS)).map(|variant| with.variant(variant));
    let widths: Option<Vec<f64>> =
        std::iter::once(without.clone()).chain(some).map(|system| chamfer_px(&system, clipping.chamfer_mm)).collect();
    let px = widths?.into_iter().fold(0.0, f64::max);
    Some(Bound { grey: light.brightest * (SQRT_2 * px).min(1.0), px })
}

/// Places along the border of the picture, around it.
fn outline(system: &System) -> Vec<DVec2> {
    const STEPS: usize = 128;
    let [width, height] = system.camera().size_px().map(|n| n as f64);
    let corners = [DVec2::ZERO, DVec2::new(width, 0.0), DVec2::new(width, height), DVec2::new(0.0, height)];
    let inside = |p: DVec2| p.clamp(DVec2::splat(INSET_PX), DVec2::new(width, height) - INSET_PX);
    let side =
        |k: usize| (0..=STEPS).map(move |i| inside(corners[k].lerp(corners[(k + 1) % 4], i as f64 / STEPS as f64)));
    (0..4).flat_map(side).collect()
}

/// The width of a ground ridge in the picture, in px: what of the front is seen within half its width of the ridge.
fn chamfer_px(system: &System, chamfer_mm: f64) -> Option<f64> {
    let widths = rows(system).map(|y| {
        let Some(x) = ridge(system, y)? else { return Some(0.0) };
        // How far the point on the front moves for a pixel, on either side of the ridge.
        let step = |side: Side| {
            let at = |x: f64| system.front_x_mm(DVec2::new(x, y), side);
            Some((at(x + 1.0)? - at(x - 1.0)?).abs() * 0.5)
        };
        Some(0.5 * chamfer_mm * (1.0 / step(Side::Left)? + 1.0 / step(Side::Right)?))
    });
    // Away from the ridge the steps differ by a few parts in a hundred.
    widths.collect::<Option<Vec<f64>>>().map(|widths| 1.1 * widths.into_iter().fold(0.0, f64::max))
}

/// Diffraction: the mean over its spread of what a displacement by so much does, or what leaves and enters the square that
/// collects light, whichever is less.
fn spread(effects: &Effects, light: RadianceRange) -> Option<Bound> {
    const STEPS: usize = 4096;
    let scale_px = effects.diffraction?.scale_px();
    // Beyond this radius a displacement changes all of a pixel, and light there counts in full.
    let far_px = 1.0 / light.sweep;
    let share = |r_px: f64| encircled_energy(r_px / scale_px);
    let ring = |k: usize| {
        let (inner, outer) = (far_px * k as f64 / STEPS as f64, far_px * (k + 1) as f64 / STEPS as f64);
        (share(outer) - share(inner)) * light.moved_by([outer; 2], outer)
    };
    let near: f64 = (0..STEPS).map(ring).sum();
    let moved = near + light.contrast * (1.0 - share(far_px));
    let grey = moved.min(light.contrast * leaving_square(scale_px / effects.collecting_side()));
    Some(Bound { grey, px: light.moved_px(grey) })
}

/// The factor of a lamp from the place nearest to its foot to the farthest: its light may be bright between the rays of a grid.
fn lamp_bound(ideal: &System, scene: &Scene, row: &EffectRow, light: RadianceRange) -> Bound {
    let range = lamp_range(ideal, &scene.effects).filter(|_| row.id == EffectId::Lamp);
    let [least, most] = range.unwrap_or([1.0; 2]);
    Bound { grey: light.brightest * (most - 1.0).max(1.0 - least), px: 0.0 }
}

/// Ghosts: their light at each place of the grid, as if all that leaves the glass towards the board came from the brightest
/// thing of `light`, and what leaves it towards the camera from what lies behind that, which no lamp lights; of the prism as
/// it is designed and as it is made, with its coating and without. What is seen only between two places of the grid, 1 / 128
/// of the picture's width apart, may be missed.
fn added(ideal: &System, effects: &Effects, light: RadianceRange) -> Option<Bound> {
    let ghosts = effects.ghosts?;
    let polarised = effects.fresnel?.light;

    // The most light that ghosts add, coated or not, made or designed.
    let one = |coated: bool, made: bool| {
        let has = |row: &EffectRow| match row.id {
            EffectId::Ghosts | EffectId::Fresnel | EffectId::Telecentric => true,
            EffectId::Coating => coated,
            EffectId::Manufacture => made,
            _ => false,
        };
        let with = ideal.with_effects(&effects.only(has));
        let Some(body) = with.body() else { return 0.0 };
        let added = |px: &DVec2| {
            let mut sum = 0.0;
            let weight = |exit: &Exit| if exit.last.face == Face::Front { ghosts.behind } else { light.brightest };
            with.reflected(*px, polarised, body, &ghosts, |exit| sum += exit.power * weight(exit));
            sum
        };
        let places: Vec<f64> = grid(&with, FINE_GRID).par_iter().map(added).collect();
        let (largest, step) = extremes(&places, FINE_GRID);
        largest + step
    };

    // The largest of what the scene may be left with.
    let ways = [(false, false), (true, false), (false, true), (true, true)].into_iter();
    let ways = ways
        .filter(|(coated, made)| (!coated || effects.coating.is_some()) && (!made || effects.manufacture.is_some()));
    let grey = ways.map(|(coated, made)| one(coated, made)).fold(0.0, f64::max);
    Some(Bound { grey, px: light.moved_px(grey) })
}
