//! The pixels of a row of the map that no line of the pattern can touch, block by block.

use super::checkerboard::Checkerboard;
use super::draft::{self, BLOCK};
use super::map::MapPatch;
use super::plan::Plan;
use super::row_map::RowMap;
use crate::num::simd::{LANES, Lanes, Mask};
use glam::DVec2;
use std::ops::Range;

const HALF_BLOCK: f64 = 0.5 * BLOCK as f64;
/// Rounding of positions, in squares.
const ROUNDING: f64 = 1e-9;
/// Packets of a block.
const PACKETS: usize = BLOCK / LANES;
/// How far the pixels of a block lie from its middle, in px.
const OFF_MIDDLE: [f64; BLOCK] = {
    let (mut off, mut i) = ([0.0; BLOCK], 0);
    while i < BLOCK {
        off[i] = i as f64 + 0.5 - HALF_BLOCK;
        i += 1;
    }
    off
};

/// How far what a pixel sees may be along one axis from where its centre is told to see, given the bounds of the map: half
/// its footprint, and the bend of the map, which is taken as straight from the middle of a block to its ends.
#[inline(always)]
fn reach_of_pixel([x, y, xx]: &[f64; 3]) -> Lanes {
    Lanes::splat(0.5 * (x + y) + 0.5 * xx * HALF_BLOCK * HALF_BLOCK + ROUNDING)
}

/// How far what a block sees may be from what its middle sees.
#[inline(always)]
fn reach_of_block([x, y, _]: &[f64; 3]) -> Lanes {
    Lanes::splat(HALF_BLOCK * x + 0.5 * y + ROUNDING)
}

/// The blocks of a row, counted from the picture's axis outward, so that mirror images are cut alike.
#[derive(Clone, Copy)]
struct RowBlocks {
    /// Pixels of the row: a block of them or more.
    pixels: usize,
    /// Whether the axis is at the row's end.
    flip: bool,
}

impl RowBlocks {
    #[inline(always)]
    fn count(self) -> usize {
        self.pixels.div_ceil(BLOCK)
    }

    /// The first pixel of block `b`; the last block ends with the row.
    #[inline(always)]
    fn begin(self, b: usize) -> usize {
        let outward = (b * BLOCK).min(self.pixels - BLOCK);
        if self.flip { self.pixels - BLOCK - outward } else { outward }
    }

    /// Those of its pixels that it does not share with the block before.
    #[inline(always)]
    fn fresh(self, b: usize) -> Range<usize> {
        let shared = BLOCK - (self.pixels - b * BLOCK).min(BLOCK);
        if self.flip { 0..BLOCK - shared } else { shared..BLOCK }
    }
}

/// The map of a block: u and v at its middle, with their slopes to the right.
#[derive(Clone, Copy)]
struct BlockMap {
    at: [f64; 2],
    slope: [f64; 2],
    /// Along either axis, whether no line of the pattern touches the block, and whether the number of its square is odd then.
    quiet: [bool; 2],
    odd: [Mask; 2],
}

impl BlockMap {
    /// Of a packet of pixels, `off` from the block's middle, whose square along an axis is odd, and which no line across it touches.
    #[inline(always)]
    fn along(&self, pattern: &Checkerboard, axis: usize, off: Lanes, reach: [Lanes; 2]) -> [Mask; 2] {
        let along =
            pattern.along(axis, Lanes::splat(self.at[axis]) + Lanes::splat(self.slope[axis]) * off, reach[axis]);
        [along.odd, along.off_lines(reach[axis])]
    }

    /// What the middles of its pixels see, and which of them lie within one square.
    #[inline(always)]
    fn values(&self, pattern: &Checkerboard, reach: [Lanes; 2]) -> ([f32; BLOCK], [Mask; PACKETS]) {
        let (mut out, mut constant) = ([0.0; BLOCK], [Mask::splat(false); PACKETS]);
        for (k, constant) in constant.iter_mut().enumerate() {
            let first = k * LANES;
            let off = Lanes::load(&OFF_MIDDLE[first..]);
            // Along a quiet axis all pixels lie in the square of the block.
            let (mut odd, mut off_lines) = (self.odd, Mask::splat(true));
            for axis in (0..2).filter(|&axis| !self.quiet[axis]) {
                let [own, off] = self.along(pattern, axis, off, reach);
                (odd[axis], off_lines) = (own, off_lines & off);
            }
            pattern.of_squares(odd).store(&mut out[first..first + LANES]);
            *constant = off_lines;
        }
        (out, constant)
    }
}

/// Lists the pixels of a block whose first is `at`, of those it does not share with the block before, that are not constant.
#[inline(always)]
fn list_others(constant: &[Mask; PACKETS], fresh: &Range<usize>, at: usize, edge_pixels: &mut Vec<u32>) {
    let (mut list, mut count) = ([0; BLOCK], 0);
    for (k, constant) in constant.iter().enumerate().filter(|(_, constant)| !constant.all()) {
        for (l, constant) in constant.0.iter().enumerate() {
            let i = k * LANES + l;
            list[count % BLOCK] = (at + i) as u32;
            count += usize::from(*constant == 0 && fresh.contains(&i));
        }
    }
    edge_pixels.extend_from_slice(&list[..count]);
}

/// Stores the pixels of a block that it does not share with the block before: nearly always all, of which the compiler then knows the
/// number.
#[inline(always)]
fn store(values: &[f32; BLOCK], fresh: &Range<usize>, span: &mut [f32]) {
    if fresh.len() == BLOCK {
        span.copy_from_slice(values);
    } else {
        span[fresh.clone()].copy_from_slice(&values[fresh.clone()]);
    }
}

/// Fills the pixels that no line of the pattern can touch, and lists the others; the draft fills also those that one
/// line crosses, and they are counted.
#[inline(always)]
pub(super) fn constant_pixels(
    plan: &Plan,
    patch: &MapPatch,
    row: &RowMap,
    draft: bool,
    out: &mut [f32],
    edge_pixels: &mut Vec<u32>,
) -> u64 {
    // Bound how far a pixel and a block may see from their centres.
    let (pattern, mut lines) = (&plan.pattern, 0);
    let (first_x, step) = (patch.region.columns.start as f64, patch.steps().x);
    let pixel = patch.bounds.each_ref().map(reach_of_pixel);
    let block = patch.bounds.each_ref().map(reach_of_block);
    let sign = Lanes::splat(if patch.flip { -1.0 } else { 1.0 });

    let blocks = RowBlocks { pixels: out.len(), flip: patch.flip };
    for first in (0..blocks.count()).step_by(LANES) {
        // Evaluate the map at the middles of a packet of blocks.
        let middle = |k: usize| first_x + blocks.begin((first + k).min(blocks.count() - 1)) as f64 + HALF_BLOCK;
        let s = Lanes::of(|k| patch.s(middle(k)));
        let [[u, us], [v, vs]] = row.slopes(s);
        // u and its slope in the picture's frame.
        let (u, ux, vx) = (u * sign, us * Lanes::splat(step), vs * sign * Lanes::splat(step));

        // Find the blocks that lie within one square, or within one along an axis.
        let along = [pattern.along(0, u, block[0]), pattern.along(1, v, block[1])];
        let value = pattern.of_squares(along.map(|along| along.odd));
        let quiet = [0, 1].map(|axis| along[axis].off_lines(block[axis]));
        let steps = draft.then(|| row.steps(patch, s.0[LANES / 2], plan.active));

        // Fill each block by the cheapest way that serves it.
        for k in 0..LANES.min(blocks.count() - first) {
            let (at, fresh) = (blocks.begin(first + k), blocks.fresh(first + k));
            let span = &mut out[at..at + BLOCK];

            // Fill a block of one square, or of one radiance off the squares: margin or background.
            let (centre, reach) = (DVec2::new(u.0[k], v.0[k]), DVec2::new(block[0].0[0], block[1].0[0]));
            let of_square = (quiet[0].0[k] & quiet[1].0[k] != 0).then_some(value.0[k]);
            if let Some(value) = of_square.or_else(|| pattern.constant(centre, reach)) {
                span.fill(value as f32);
                continue;
            }

            // Fill a block of squares by draft pixels, and list those that two lines cross.
            if let Some(steps) = &steps
                && let Some(square) = pattern.square(centre, reach)
            {
                let drafted = draft::block(&square, [ux.0[k], vx.0[k]], steps, plan.active);
                store(&drafted.value, &fresh, span);
                lines += drafted.lined[fresh.clone()].iter().map(|lined| u64::from(*lined)).sum::<u64>();
                edge_pixels.extend(fresh.filter(|&i| drafted.crossed[i]).map(|i| (at + i) as u32));
                continue;
            }

            // Fill the pixels that lie within one square, and list the others.
            let odd = [0, 1].map(|axis| Mask([along[axis].odd.0[k]; LANES]));
            let quiet = quiet.map(|quiet| quiet.0[k] != 0);
            let map = BlockMap { at: [u.0[k], v.0[k]], slope: [ux.0[k], vx.0[k]], quiet, odd };
            let (values, constant) = map.values(pattern, pixel);
            store(&values, &fresh, span);
            list_others(&constant, &fresh, at, edge_pixels);
        }
    }
    lines
}
