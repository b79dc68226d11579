//! Diffraction: evenly lit pixels share their light over the whole picture, and the cells of the others around them.

use super::accumulate::{light, make_symmetric, variants_of};
use super::band::Band;
use super::bands::render_part;
use super::film::{Film, Outputs};
use super::ground_truth::ground_truth;
use super::plan::Plan;
use super::region::Region;
use crate::accuracy::Accuracy;
use crate::effect::diffraction::{CellSpread, Diffraction, LightSpread};
use crate::effect::{Variant, merged};
use crate::optics::fate::Fate;
use crate::progress::{Observer, Scaled};
use crate::raster::{MAX_PIXELS, MAX_SIDE_PX, Raster};
use crate::system::System;
use glam::DVec2;
use rayon::prelude::*;
use std::ops::Range;

/// Pixels along the side of a tile whose cells are rendered together, or as many as make [`TILE_CELLS`] cells.
const TILE: usize = 16;
const TILE_CELLS: usize = 64;
/// Pixels whose light differs from that of their neighbours by less than this share of the contrast are taken as evenly lit.
const EVEN: f32 = 5e-4;
/// Where squares are smaller than this, in px, pixels may be alike and not be evenly lit.
const SMALL_SQUARE_PX: f64 = 2.0;
/// Variants whose plans are held at a time.
const PLANS: usize = 64;
/// A frame that the lens can do without makes the picture larger by this factor at most, or makes so many pixels of all passes.
const MOST_GROWTH: f64 = 1.5;
const FEW_PIXELS: usize = 1 << 18;
/// Places along each side of the picture where the smallest square is looked for.
const SQUARES: usize = 9;
/// Pixels between the places where the glass beyond the border is looked for.
const FRAME_STEP: usize = 8;

/// The light that the pixels of `system` collect behind a lens that diffracts; `wanted` and `observer` as in
/// [`super::render_wanted`].
pub(super) fn spread_light(system: &System, lens: &Diffraction, wanted: Outputs, observer: &dyn Observer) -> Film {
    let pixels: usize = system.camera().size_px().iter().product();

    // Render the light of pixels, and of those beyond the border where the glass is given there.
    let frame = frame_px(system);
    let framed = system.framed(frame);
    let [width, height] = framed.camera().size_px();
    let even = light(&framed, Outputs { truth: false }, &Scaled::new(observer, pixels / 2, width * height));

    // Spread it as if each of them were evenly lit.
    let spread = LightSpread::new(lens, system.effects().collecting_side(), cells(system));
    let colour = even.colour.as_ref().map(|colour| [0, 1, 2].map(|c| colour.map(|v| v[c])));
    let channels = std::iter::once(&even.radiance).chain(colour.iter().flatten());
    let mut sums: Vec<Raster<f64>> = channels.map(|channel| spread.pixels.spread(channel)).collect();

    // Add what the cells of the others make.
    let rest = Scaled::new(observer, pixels - pixels / 2, width * height);
    if let Some(cells) = &spread.cells {
        let variants = variants_of(&framed, &even.account);
        add_cells(&framed, (&even, &variants), (cells, frame.saturating_sub(cells.reach())), &mut sums, &rest);
    }
    if framed.effects().averages() && framed.receives_mirror_images() {
        sums.iter_mut().for_each(|sum| make_symmetric(sum, |a, b| 0.5 * (a + b)));
    }
    rest.pixels(width * height);

    // Neither rounding nor what cells are sharpened by makes light negative.
    let mut channels = sums.iter().map(|sum| sum.map(|v| v.max(0.0) as f32));
    let radiance = channels.next().expect("grey is a channel");
    let colour = <[_; 3]>::try_from(channels.collect::<Vec<_>>()).ok().map(merged);
    let light = Film { radiance, colour, ..even }.without_frame(frame);

    // Of a small pattern, take its share.
    let light = if spread.share < 1.0 { mixed(system, light, spread.share) } else { light };
    if !wanted.truth {
        return light;
    }
    let Film { class, board_mm, object, .. } = ground_truth(system);
    Film { class, board_mm, object, ..light }
}

/// The share of `spread` that a small pattern has, and for the rest the light of active squares without diffraction.
fn mixed(system: &System, spread: Film, share: f64) -> Film {
    let sharp = light(&system.without_diffraction(), Outputs { truth: false }, &());
    let mix = |a: f32, b: f32| (f64::from(a) * share + f64::from(b) * (1.0 - share)) as f32;
    let of = |a: &Raster<f32>, b: &Raster<f32>| {
        let values = a.data().iter().zip(b.data()).map(|(a, b)| mix(*a, *b));
        Raster::from_data(a.width(), a.height(), values.collect())
    };
    let of_colours = |(a, b): (&Raster<[f32; 3]>, &Raster<[f32; 3]>)| {
        let values = a.data().iter().zip(b.data()).map(|(a, b)| [0, 1, 2].map(|c| mix(a[c], b[c])));
        Raster::from_data(a.width(), a.height(), values.collect())
    };
    let colour = spread.colour.as_ref().zip(sharp.colour.as_ref()).map(of_colours);
    Film { radiance: of(&spread.radiance, &sharp.radiance), colour, ..spread }
}

/// Cells along each side of a pixel of `system`: 1 where nothing diffracts, or pixels do for it.
pub fn cells(system: &System) -> usize {
    let effects = system.effects();
    let Some(lens) = effects.diffracting() else { return 1 };

    // Look for the smallest squares.
    let size = DVec2::from_array(system.camera().size_px().map(|n| n as f64));
    let place = |k: usize| size * (DVec2::new((k % SQUARES) as f64, (k / SQUARES) as f64) + 0.5) / SQUARES as f64;
    let squares = (0..SQUARES * SQUARES).filter_map(|k| square_px(system, place(k)));
    lens.cells(effects.collecting_side(), squares.fold(f64::INFINITY, f64::min))
}

/// The side of the squares, or of what else is finest on the board, as seen at a place of the picture, in px.
fn square_px(system: &System, px: DVec2) -> Option<f64> {
    let footprint = system.footprint(px).ok()?;
    let step_mm = footprint.jacobian.x_axis.abs() + footprint.jacobian.y_axis.abs();
    Some(system.feature_mm() / step_mm.max_element())
}

/// Pixels to be rendered beyond the border: of all those whose light the lens brings into the picture as many as are given, and
/// as do not make it much larger.
pub fn frame_px(system: &System) -> usize {
    let [least, most] = system.effects().diffracting().map_or([0; 2], Diffraction::margins_px);
    let [width, height] = system.camera().size_px();
    let pixels = |frame: usize| (width + 2 * frame) * (height + 2 * frame);
    let effects = system.effects();
    let passes = if effects.averages() { effects.variants(0).len() * effects.sets() } else { 1 };
    let large = (FEW_PIXELS / passes.max(1)).max((MOST_GROWTH * pixels(0) as f64) as usize);
    let narrower = |frame: usize| if frame > least { least.max(3 * frame / 4) } else { frame / 2 };
    std::iter::successors(Some(most), |frame| Some(narrower(*frame)))
        .take_while(|frame| *frame > 0)
        .find(|frame| (*frame <= least || pixels(*frame) <= large) && is_given(system, *frame))
        .unwrap_or(0)
}

/// Whether the glass is given at the border of a frame, and the picture with it is not too large.
fn is_given(system: &System, frame: usize) -> bool {
    let [width, height] = system.camera().size_px().map(|n| n + 2 * frame);
    if width.max(height) > MAX_SIDE_PX || width * height > MAX_PIXELS {
        return false;
    }
    let framed = system.framed(frame);
    let (right, lower) = (width as f64, height as f64);
    let along = |length: usize| (0..=length.div_ceil(FRAME_STEP)).map(move |k| (k * FRAME_STEP).min(length) as f64);
    let mut border = along(width)
        .flat_map(|x| [DVec2::new(x, 0.0), DVec2::new(x, lower)])
        .chain(along(height).flat_map(|y| [DVec2::new(0.0, y), DVec2::new(right, y)]));
    !border.any(|px| framed.trace(px).is_err_and(|fate| fate == Fate::Missed))
}

/// Adds to `sums`, grey and the colours where there are some, what the cells of unevenly lit pixels differ by, but for those
/// within `beyond` px of the border.
pub(super) fn add_cells(
    system: &System,
    (even, variants): (&Film, &[(f64, Variant)]),
    (spread, beyond): (&CellSpread, usize),
    sums: &mut [Raster<f64>],
    observer: &dyn Observer,
) {
    // Choose the tiles.
    let cells = spread.cells();
    let side = TILE.max(TILE_CELLS.div_ceil(cells));
    let [width, height] = system.camera().size_px();
    let (darkest, brightest) = extremes(even.radiance.data().iter().copied());
    let least = EVEN * (brightest - darkest);
    let [columns, lines] = [width, height].map(|n| beyond..n - beyond);
    let tile = |x: usize, y: usize| Region { columns: x..columns.end.min(x + side), rows: y..lines.end.min(y + side) };
    let tiles_at = |y: usize| {
        let tiles = columns.clone().step_by(side).map(|x| tile(x, y));
        tiles.filter(|tile| is_uneven(system, even, tile, least)).collect()
    };
    let rows: Vec<Vec<Region>> = lines.clone().step_by(side).map(tiles_at).collect();

    // Render the cells by few variants at a time, each by a map for all its tiles.
    // A map to 1e-8 px serves every level: what cells leave out is far more.
    let standard = Accuracy { map_px: Accuracy::standard().map_px * cells as f64, ..Accuracy::standard() };
    let fine = system.sampled(cells).with_accuracy(standard);
    let parts = variants.len().div_ceil(PLANS);
    for few in variants.chunks(PLANS) {
        let instruments: Vec<System> = few.iter().map(|(_, variant)| fine.variant(variant)).collect();
        let passes: Vec<CellPass> = (instruments.par_iter().zip(few))
            .map(|(instrument, variant)| CellPass::new(instrument, cells, variant, sums.len()))
            .collect();
        for tiles in &rows {
            let added: Vec<Vec<Raster<f32>>> =
                tiles.par_iter().map(|tile| cells_of(&passes, tile, spread, least)).collect();
            for (tile, added) in tiles.iter().zip(added) {
                sums.iter_mut().zip(&added).for_each(|(sum, added)| add(sum, added, tile, spread.reach()));
            }
            observer.pixels(width * side / parts);
        }
    }
}

/// Whether the light may be uneven over some pixel of `tile`.
fn is_uneven(system: &System, even: &Film, tile: &Region, least: f32) -> bool {
    let picture = &even.radiance;
    let columns = tile.columns.start.saturating_sub(1)..picture.width().min(tile.columns.end + 1);
    let rows = tile.rows.start.saturating_sub(1)..picture.height().min(tile.rows.end + 1);
    let differs = |a: f32, b: f32| (a - b).abs() > least;
    let along = |j: usize| picture.row(j)[columns.clone()].windows(2).any(|pair| differs(pair[0], pair[1]));
    let down = |j: usize| {
        let (above, below) = (&picture.row(j - 1)[columns.clone()], &picture.row(j)[columns.clone()]);
        above.iter().zip(below).any(|(a, b)| differs(*a, *b))
    };
    rows.clone().any(along) || rows.clone().skip(1).any(down) || has_small_squares(system, tile)
}

/// Whether squares in the middle of `tile` are so small that pixels may be alike and not be evenly lit.
fn has_small_squares(system: &System, tile: &Region) -> bool {
    let middle = |range: &Range<usize>| 0.5 * (range.start + range.end) as f64;
    let square_px = square_px(system, DVec2::new(middle(&tile.columns), middle(&tile.rows)));
    square_px.is_some_and(|side| side < SMALL_SQUARE_PX)
}

/// One variant of the instrument, by its cells.
struct CellPass<'a> {
    plan: Plan<'a>,
    /// Its weights in grey and in the colours, where there are some.
    weights: Vec<f32>,
}

impl<'a> CellPass<'a> {
    fn new(instrument: &'a System, cells: usize, (share, variant): &(f64, Variant), channels: usize) -> Self {
        let colours = variant.colour.into_iter().flatten();
        let weights = std::iter::once(variant.grey).chain(colours).take(channels);
        Self {
            plan: Plan::of_parts(instrument, cells),
            weights: weights.map(|weight| (share * weight) as f32).collect(),
        }
    }
}

/// What the cells of `tile` add to it and to the pixels around it, in grey and in the colours.
fn cells_of(passes: &[CellPass], tile: &Region, spread: &CellSpread, least: f32) -> Vec<Raster<f32>> {
    // Render its cells.
    let (cells, reach) = (spread.cells(), spread.reach());
    let (columns, rows) = (tile.columns.len(), tile.rows.len());
    let width = columns * cells;
    let mut lights = vec![vec![0.0f32; width * rows * cells]; passes[0].weights.len()];
    let mut radiance = vec![0.0f32; width * rows * cells];
    for CellPass { plan, weights } in passes {
        radiance.fill(0.0);
        let (first_column, first_row) = (tile.columns.start * cells, tile.rows.start * cells);
        render_part(plan, &mut Band { width, first_column, first_row, radiance: &mut radiance, truth: None });
        for (light, weight) in lights.iter_mut().zip(weights) {
            light.iter_mut().zip(&radiance).for_each(|(light, value)| *light += weight * value);
        }
    }

    // Spread those of pixels that are not evenly lit.
    let side = 2 * reach + 1;
    let mut around = Vec::new();
    let spread_one = |(channel, light): (usize, &Vec<f32>)| {
        // These variants give a share of the light, which may be as uneven as all of it.
        let least = least * passes.iter().map(|pass| pass.weights[channel]).sum::<f32>();
        let mut out = Raster::filled(columns + 2 * reach, rows + 2 * reach, 0.0f32);
        for (j, i) in (0..rows).flat_map(|j| (0..columns).map(move |i| (j, i))) {
            let row = |k: usize| &light[(j * cells + k) * width + i * cells..][..cells];
            let (low, high) = extremes((0..cells).flat_map(|k| row(k).iter().copied()));
            if high - low <= least {
                continue;
            }
            spread.add(|column, line| row(line)[column], &mut around);
            for (line, from) in around.chunks(side).take(side).enumerate() {
                let to = &mut out.row_mut(j + line)[i..i + side];
                to.iter_mut().zip(from).for_each(|(to, from)| *to += from);
            }
        }
        out
    };
    lights.iter().enumerate().map(spread_one).collect()
}

/// Adds to `sum` what a tile adds to it and to the `reach` pixels around it; what falls beyond the border comes back from
/// there, as from the mirror image of the tile.
fn add(sum: &mut Raster<f64>, added: &Raster<f32>, tile: &Region, reach: usize) {
    let mirrored = |first: usize, k: usize, side: usize| {
        let place = (first as isize + k as isize - reach as isize).rem_euclid(2 * side as isize) as usize;
        if place < side { place } else { 2 * side - 1 - place }
    };
    let (width, height) = (sum.width(), sum.height());
    for k in 0..added.height() {
        let row = sum.row_mut(mirrored(tile.rows.start, k, height));
        for (i, value) in added.row(k).iter().enumerate() {
            row[mirrored(tile.columns.start, i, width)] += f64::from(*value);
        }
    }
}

fn extremes(values: impl Iterator<Item = f32>) -> (f32, f32) {
    values.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}
