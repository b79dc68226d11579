//! What an effect changes at most, from rays over a grid of the picture.
//!
//! Every bound is of one effect against the instrument without it. Where what is bounded is smooth, its extremes between the
//! rays of the grid are covered by the largest step from one ray to the next. With M the brightest radiance of the scene and C the
//! largest contrast in it:
//!
//! - Factors of light from g0 to g1 change a pixel by at most M |g1 - g0|. An edge is where pixels cross the middle of its
//!   two sides; a factor that changes by a share q from one pixel to the next moves it by q mean / (white - black) px.
//! - Where variants see points that are up to d px from those of the instrument itself, an edge moves by at most d px. It
//!   sweeps at most sqrt(2) d of a pixel, for no line through a pixel is longer than its diagonal; so a pixel changes by at
//!   most C sqrt(2) d for each line through it. The image of the ridge moves by a way of its own, and parts contents of any
//!   contrast; it is no edge of the board.
//! - A ground ridge that is d px wide takes at most sqrt(2) d of a pixel and M from that. A rim or a stop that is seen has no bound but M.
//! - Diffraction moves light by r px with a known distribution, and each part of it changes a pixel as a displacement by r.
//! - Ghosts add at most their power times the brightest thing to be seen.
//! - What changes pixels by up to g on both sides of an edge, which is a ramp over one pixel, moves it by at most
//!   2 g / (white - black) px.

use super::instrument::System;
use crate::effect::clipping::Clipping;
use crate::effect::diffraction::encircled_energy;
use crate::effect::{Bounding, EffectId, EffectRow, Effects, Variant};
use crate::prism::side::Side;
use crate::scene::{BoardSpec, Scene};
use glam::DVec2;
use rayon::prelude::*;
use std::f64::consts::SQRT_2;

/// Rays along the width and the height of the grid.
const GRID: [usize; 2] = [33, 17];
/// The same for ghosts, whose power has steps where one of them begins.
const FINE_GRID: [usize; 2] = [129, 65];
/// Rows in which the ridge's image is sought.
const ROWS: usize = 5;
/// Variants beyond this count are not looked through: their effect is kept.
const MOST_VARIANTS: usize = 2048;
/// Halvings of the width when a border is sought in a row.
const HALVINGS: usize = 40;
/// Places of the grid stay this far inside the picture, in px.
const INSET_PX: f64 = 1e-6;

/// What an effect changes at most.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Bound {
    /// Change of a pixel, of full scale 1.
    pub grey: f64,
    /// Move of an edge, in px.
    pub px: f64,
}

/// What an effect of `scene`, whose instrument without effects is `ideal`, changes at most; `None` where that is not known.
pub(super) fn bound(ideal: &System, scene: &Scene, row: &EffectRow) -> Option<Bound> {
    let effects = &scene.effects;
    // Another camera is another picture: what it sees is what the others change.
    let stands_on =
        |other: &EffectRow| other.id != row.id && (other.id == EffectId::Telecentric || row.needs == Some(other.id));
    let without = ideal.with_effects(&effects.only(stands_on));
    let with = ideal.with_effects(&effects.only(|other| other.id == row.id || stands_on(other)));
    let light = RadianceRange::of(&without);
    let found = match row.bounding {
        Bounding::Factors => Some(factors(&without, &with, light)),
        Bounding::Displacements => displacements(&without, &with, light),
        Bounding::Borders => borders(&without, ideal, scene, light),
        Bounding::Spread => spread(effects, light),
        Bounding::Added => added(&with, light),
        Bounding::Never(_) => None,
    };
    found.filter(|bound| bound.grey.is_finite() && bound.px.is_finite())
}

/// What the light of a scene has to do with changes of its picture.
#[derive(Clone, Copy)]
struct RadianceRange {
    brightest: f64,
    /// Between any two things.
    contrast: f64,
    /// Between the squares.
    edge: f64,
    /// Of the squares.
    mean: f64,
    /// Lines of the board through one pixel, at most.
    lines: f64,
    /// Whether the ridge of a prism may be seen as well: 1 or 0.
    ridge: f64,
}

impl RadianceRange {
    fn of(system: &System) -> Self {
        let board = &system.board().pattern;
        let all = [board.black, board.white, board.background];
        let (low, high) = all.iter().fold((f64::INFINITY, 0.0f64), |(low, high), v| (low.min(*v), high.max(*v)));
        let edge = (board.white - board.black).abs();
        let mean = 0.5 * (board.black + board.white);
        let ridge = if system.prism().is_some() { 1.0 } else { 0.0 };
        Self { brightest: high, contrast: high - low, edge, mean, lines: lines(system, board), ridge }
    }

    /// How far an edge between squares moves by what changes pixels by up to `grey`.
    fn moved_px(&self, grey: f64) -> f64 {
        if self.edge > 0.0 { 2.0 * grey / self.edge } else { 0.0 }
    }

    /// The change of a pixel where the board moves by up to `px` and the image of the ridge by up to `ridge_px`.
    fn moved_by(&self, px: f64, ridge_px: f64) -> f64 {
        self.contrast * (SQRT_2 * (self.lines * px + self.ridge * ridge_px)).min(1.0)
    }
}

/// Lines of the board through one pixel, at most: of each family one more than the lines' distances that a pixel is wide,
/// and on both sides of the ridge.
fn lines(system: &System, board: &BoardSpec) -> f64 {
    let margin = if board.margin_mm > 0.0 { board.margin_mm } else { f64::INFINITY };
    let distance_mm = board.square_mm.min(margin);
    let across = |px: &DVec2| {
        let Ok(footprint) = system.footprint(*px) else { return DVec2::ZERO };
        (footprint.jacobian.x_axis.abs() + footprint.jacobian.y_axis.abs()) / distance_mm
    };
    let spans: Vec<DVec2> = grid(system, GRID).par_iter().map(across).collect();
    let widest = |of: fn(&DVec2) -> f64| {
        let (largest, step) = extremes(&spans.iter().map(of).collect::<Vec<_>>(), GRID);
        (largest + step).floor() + 1.0
    };
    let families = widest(|span| span.x) + widest(|span| span.y);
    if system.prism().is_some() { 2.0 * families } else { families }
}

/// Places over the picture, row by row.
fn grid(system: &System, [columns, rows]: [usize; 2]) -> Vec<DVec2> {
    let [width, height] = system.camera().size_px().map(|n| n as f64);
    let place = |i: usize, n: usize, side: f64| (side * i as f64 / (n - 1) as f64).clamp(INSET_PX, side - INSET_PX);
    let row = |j: usize| (0..columns).map(move |i| DVec2::new(place(i, columns, width), place(j, rows, height)));
    (0..rows).flat_map(row).collect()
}

/// The largest of values on a grid, and the largest step between neighbours.
fn extremes(values: &[f64], [columns, _]: [usize; 2]) -> (f64, f64) {
    let largest = values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let step = |a: usize, b: usize| (values[a] - values[b]).abs();
    let across = (0..values.len()).filter(|k| k % columns > 0).map(|k| step(k, k - 1));
    let down = (columns..values.len()).map(|k| step(k, k - columns));
    (largest, across.chain(down).fold(0.0, f64::max))
}

fn factors(without: &System, with: &System, light: RadianceRange) -> Bound {
    let places = grid(with, GRID);
    let changes: Vec<f64> = places.par_iter().map(|px| with.throughput(*px) - without.throughput(*px)).collect();
    let (largest, step) = extremes(&changes, GRID);
    // The share by which the factor changes from one pixel to the next.
    let ratio = |px: DVec2| with.throughput(px) / without.throughput(px);
    let slope = |px: &DVec2| {
        let along = |step: DVec2| 0.5 * (ratio(*px + step) - ratio(*px - step));
        DVec2::new(along(DVec2::X), along(DVec2::Y)).length() / ratio(*px)
    };
    let (steepest, steps) = extremes(&places.par_iter().map(slope).collect::<Vec<_>>(), GRID);
    let px = if light.edge > 0.0 { (steepest + steps) * light.mean / light.edge } else { 0.0 };
    Bound { grey: light.brightest * (largest + step), px }
}

/// By how far all variants of `with` see from what `without` sees. `None` where rays end, so that it cannot be told.
fn displacements(without: &System, with: &System, light: RadianceRange) -> Option<Bound> {
    let systems: Vec<System> = variants(&with.effects)?.iter().map(|variant| with.variant(variant)).collect();
    let stray = |px: &DVec2| {
        let side = without.trace(*px).ok()?.side;
        let here = without.footprint_through(*px, side).ok()?;
        let back = here.jacobian.inverse();
        let stray = |system: &System| {
            let there = system.footprint_through(*px, side).ok()?;
            Some((back * (there.sight.board_mm - here.sight.board_mm)).length())
        };
        systems.iter().try_fold(0.0f64, |most, system| Some(most.max(stray(system)?)))
    };
    let strays = grid(without, GRID).par_iter().map(stray).collect::<Option<Vec<f64>>>()?;
    let (largest, step) = extremes(&strays, GRID);
    let ridges: Option<Vec<f64>> = systems.par_iter().map(|system| ridge_moved(without, system)).collect();
    let ridge_px = ridges?.into_iter().fold(0.0, f64::max);
    let px = largest + step;
    Some(Bound { grey: light.moved_by(px, ridge_px), px })
}

/// All variants that the picture may be the mean of; `None` where they are more than can be looked through in a moment.
fn variants(effects: &Effects) -> Option<Vec<Variant>> {
    let sets = effects.sets();
    let one = effects.variants(0);
    if one.len().saturating_mul(sets) > MOST_VARIANTS {
        return None;
    }
    Some((1..sets).fold(one, |mut all, set| {
        all.extend(effects.variants(set));
        all
    }))
}

/// Rows of the picture in which the ridge is sought.
fn rows(system: &System) -> impl Iterator<Item = f64> + use<> {
    let height = system.camera().size_px()[1] as f64;
    (0..ROWS).map(move |k| (height * k as f64 / (ROWS - 1) as f64).clamp(INSET_PX, height - INSET_PX))
}

/// How far the image of the ridge moves from one instrument to another, in px: 0 where neither shows it.
fn ridge_moved(a: &System, b: &System) -> Option<f64> {
    if a.prism.is_none() {
        return Some(0.0);
    }
    let moved = rows(a).map(|y| match (ridge(a, y)?, ridge(b, y)?) {
        (Some(a), Some(b)) => Some((a - b).abs()),
        (None, None) => Some(0.0),
        // It comes into the picture or leaves it.
        _ => None,
    });
    moved.collect::<Option<Vec<f64>>>().map(|moved| moved.into_iter().fold(0.0, f64::max))
}

/// Where the image of the ridge crosses a row: `None` where rays end, `Some(None)` where one side is seen all along.
fn ridge(system: &System, y: f64) -> Option<Option<f64>> {
    let width = system.camera().size_px()[0] as f64;
    let side = |x: f64| system.trace(DVec2::new(x, y)).ok().map(|sight| sight.side);
    let (mut a, mut b) = (INSET_PX, width - INSET_PX);
    let (left, right) = (side(a)?, side(b)?);
    if left == right {
        return Some(None);
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (a + b);
        if side(middle)? == left { a = middle } else { b = middle }
    }
    Some(Some(0.5 * (a + b)))
}

/// Rims and stops, with the pupil and all else that lets rays stray; a ground ridge by its width.
fn borders(without: &System, ideal: &System, scene: &Scene, light: RadianceRange) -> Option<Bound> {
    let clipping = scene.effects.clipping?;
    let others =
        scene.effects.only(|row| matches!(row.bounding, Bounding::Displacements) || row.id == EffectId::Telecentric);
    let rims = Clipping { chamfer_mm: 0.0, ..clipping };
    if !rims.is_nothing() {
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
    let px = chamfer_px(without, clipping.chamfer_mm)?;
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

/// Diffraction: the mean over its spread of what a displacement by so much does.
fn spread(effects: &Effects, light: RadianceRange) -> Option<Bound> {
    const STEPS: usize = 4096;
    let scale_px = effects.diffraction?.scale_px();
    // Beyond this radius a displacement changes all of a pixel, and light there counts in full.
    let far_px = 1.0 / ((light.lines + light.ridge) * SQRT_2);
    let share = |r_px: f64| encircled_energy(r_px / scale_px);
    let ring = |k: usize| {
        let (inner, outer) = (far_px * k as f64 / STEPS as f64, far_px * (k + 1) as f64 / STEPS as f64);
        (share(outer) - share(inner)) * light.moved_by(outer, outer)
    };
    let near: f64 = (0..STEPS).map(ring).sum();
    let grey = near + light.contrast * (1.0 - share(far_px));
    Some(Bound { grey, px: light.moved_px(grey) })
}

/// Ghosts: their power at each place of the grid, as if all of it came from the brightest thing. What is seen only between
/// two places of the grid, 1 / 128 of the picture's width apart, may be missed.
fn added(with: &System, light: RadianceRange) -> Option<Bound> {
    let ghosts = with.effects.ghosts?;
    let polarised = with.effects.fresnel?.light;
    let Some(body) = with.body() else { return Some(Bound { grey: 0.0, px: 0.0 }) };
    let power = |px: &DVec2| {
        let mut sum = 0.0;
        with.reflected(*px, polarised, body, &ghosts, |exit| sum += exit.power);
        sum
    };
    let powers: Vec<f64> = grid(with, FINE_GRID).par_iter().map(power).collect();
    let (largest, step) = extremes(&powers, FINE_GRID);
    let grey = (largest + step) * light.brightest.max(ghosts.behind);
    Some(Bound { grey, px: light.moved_px(grey) })
}
