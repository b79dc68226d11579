//! Pixels by the certified map, row by row: blocks within one square are filled, the other pixels are integrated over
//! the map's second-order Taylor expansion.

use super::band::Band;
use super::checkerboard::Checkerboard;
use super::draft::{self, BLOCK, Steps};
use super::map::MapPatch;
use super::pixel::{mean_or_subdivide, means_of};
use super::pixel_mean::PackedTaylor2;
use super::plan::Plan;
use super::steep;
use super::work::Work;
use crate::accuracy::Arithmetic;
use crate::num::chebyshev::MAX_DEGREE;
use crate::num::simd::{Kernel, LANES, Lanes, widest};
use glam::DVec2;
use std::ops::Range;

/// A patch is at least this wide.
pub(super) const LEAST_COLUMNS: usize = BLOCK;
const HALF_BLOCK: f64 = 0.5 * BLOCK as f64;
/// Rounding of positions, in squares.
const ROUNDING: f64 = 1e-9;

/// Renders the rows of `patch` that lie in `band`, which holds all its columns.
pub(super) fn render(plan: &Plan, patch: &MapPatch, band: &mut Band) -> Work {
    widest(PatchRows { plan, patch, band })
}

/// Coefficients of a polynomial in s, by rising power.
type Line = [f64; MAX_DEGREE + 1];

/// The map along one row: u and v as polynomials in s, with their first and second derivatives by steps of a pixel's
/// active side down the picture.
pub(super) struct RowMap {
    degree: [usize; 2],
    value: [Line; 2],
    down: [Line; 2],
    down2: [Line; 2],
}

impl RowMap {
    #[inline(always)]
    pub(super) fn new(patch: &MapPatch, y: f64, active: f64) -> Self {
        let (t, step) = (patch.t(y), patch.steps().y * active);
        let mut row = Self {
            degree: [0, 1].map(|axis| patch.powers[axis].len() - 1),
            value: [[0.0; MAX_DEGREE + 1]; 2],
            down: [[0.0; MAX_DEGREE + 1]; 2],
            down2: [[0.0; MAX_DEGREE + 1]; 2],
        };
        for axis in 0..2 {
            for (k, powers) in patch.powers[axis].iter().enumerate() {
                let (mut p, mut p1, mut p2) = (0.0, 0.0, 0.0);
                for &c in powers.iter().rev() {
                    p2 = p2 * t + p1;
                    p1 = p1 * t + p;
                    p = p * t + c;
                }
                row.value[axis][k] = p;
                row.down[axis][k] = p1 * step;
                row.down2[axis][k] = 2.0 * p2 * (step * step);
            }
        }
        row
    }

    /// Value and derivative by s.
    #[inline(always)]
    fn slope(&self, axis: usize, s: Lanes) -> [Lanes; 2] {
        let (mut p, mut p1) = (Lanes::splat(0.0), Lanes::splat(0.0));
        for &c in self.value[axis][..=self.degree[axis]].iter().rev() {
            p1 = p1 * s + p;
            p = p * s + Lanes::splat(c);
        }
        [p, p1]
    }

    /// Value and the derivatives ss, t, st and tt after s.
    #[inline(always)]
    pub(super) fn derivatives(&self, axis: usize, s: Lanes) -> [Lanes; 6] {
        let zero = Lanes::splat(0.0);
        let (mut p, mut p1, mut p2, mut q, mut q1, mut r) = (zero, zero, zero, zero, zero, zero);
        for k in (0..=self.degree[axis]).rev() {
            p2 = p2 * s + p1;
            p1 = p1 * s + p;
            p = p * s + Lanes::splat(self.value[axis][k]);
            q1 = q1 * s + q;
            q = q * s + Lanes::splat(self.down[axis][k]);
            r = r * s + Lanes::splat(self.down2[axis][k]);
        }
        [p, p1, p2 + p2, q, q1, r]
    }
}

impl RowMap {
    /// Derivatives down and twice to the right, in the picture's frame, at s.
    #[inline(always)]
    fn steps(&self, patch: &MapPatch, s: f64, active: f64) -> Steps {
        let step = patch.steps().x;
        let mut steps = Steps { down: [0.0; 2], bend: [0.0; 2] };
        for axis in 0..2 {
            let (mut p, mut p1, mut p2, mut down) = (0.0, 0.0, 0.0, 0.0);
            for k in (0..=self.degree[axis]).rev() {
                p2 = p2 * s + p1;
                p1 = p1 * s + p;
                p = p * s + self.value[axis][k];
                down = down * s + self.down[axis][k];
            }
            // u is counted to the left where the patch is turned over.
            let sign = if patch.flip && axis == 0 { -1.0 } else { 1.0 };
            steps.down[axis] = sign * down / active;
            steps.bend[axis] = sign * 2.0 * p2 * (step * step);
        }
        steps
    }
}

struct PatchRows<'a, 'b, 'c> {
    plan: &'a Plan<'a>,
    patch: &'a MapPatch,
    band: &'b mut Band<'c>,
}

impl Kernel for PatchRows<'_, '_, '_> {
    type Out = Work;

    #[inline(always)]
    fn run(self) -> Work {
        let Self { plan, patch, band } = self;
        let mut work = Work::default();

        // Find the rows of the patch in the band, and whether draft pixels keep to the bend allowed.
        let columns = patch.region.columns.clone();
        let rows = band.part_of(&patch.region).rows;
        let mut edge_pixels = Vec::new();
        let draft_px = draft_px(plan, patch);
        work.bend_px = draft_px.unwrap_or(0.0);
        let draft = draft_px.is_some();

        // Fill row by row: first the pixels off the lines of the pattern, then those on them.
        for j in rows {
            let y = j as f64 + 0.5;
            let row = RowMap::new(patch, y, plan.active);
            let start = band.at(columns.start, j);
            let span = start..start + columns.len();
            let out = &mut band.radiance[span.clone()];
            edge_pixels.clear();
            match plan.plate {
                _ if plan.truth_alone => (),
                None => work.counts.edge_pixels += constant_pixels(plan, patch, &row, draft, out, &mut edge_pixels),
                Some(_) => edge_pixels.extend(0..out.len() as u32),
            }
            edge_means(plan, patch, &row, y, out, &edge_pixels, &mut work);

            // Apply the throughput of transport effects.
            if plan.has_throughput && !plan.truth_alone {
                let first = DVec2::new(columns.start as f64 + 0.5, y);
                match &patch.throughput {
                    Some(powers) => throughput(patch, powers, y, out),
                    None => plan.attenuate_row(first, out, &mut work),
                }
                if plan.steep {
                    steep::row(plan, first, out, |_| true, &mut work);
                }
            }

            // Store the ground truth.
            if let Some(truth) = &mut band.truth {
                truth.class[span.clone()].fill(patch.class);
                board(plan, patch, &row, &mut truth.board_mm[span]);
            }
        }
        work
    }
}

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

/// The error of draft pixels of the patch, in px, where the level takes them and it is within the bound; a pixel's
/// footprint must be smaller than a square.
fn draft_px(plan: &Plan, patch: &MapPatch) -> Option<f64> {
    let small = patch.bounds.iter().all(|[x, y, _]| 0.5 * (x + y) < 0.49);
    let error_px = draft::error_px(patch.stray_px);
    let accuracy = plan.system.accuracy();
    let small = small && plan.plate.is_none();
    (accuracy.arithmetic == Arithmetic::Single && small && error_px <= accuracy.bend_px).then_some(error_px)
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

/// Fills the pixels of a block that lie within one square, and tells the others; u and v at its middle and their slopes are `map`.
#[inline(always)]
fn block_pixels(
    pattern: &Checkerboard,
    map: [[f64; 2]; 2],
    reach: [Lanes; 2],
    values: &mut [f32; BLOCK],
    edge: &mut impl FnMut(usize),
) {
    for i in (0..BLOCK).step_by(LANES) {
        let d = Lanes::of(|l| (i + l) as f64 + 0.5 - HALF_BLOCK);
        let centres = map.map(|[at, slope]| Lanes::splat(at) + Lanes::splat(slope) * d);
        let (value, constant) = pattern.squares(centres, reach).constant_off_lines(reach);
        value.store(&mut values[i..i + LANES]);
        if !constant.all() {
            (0..LANES).filter(|&l| constant.0[l] == 0).for_each(|l| edge(i + l));
        }
    }
}

/// Fills the pixels that no line of the pattern can touch, and lists the others; the draft fills also those that one
/// line crosses, and they are counted.
#[inline(always)]
fn constant_pixels(
    plan: &Plan,
    patch: &MapPatch,
    row: &RowMap,
    draft: bool,
    out: &mut [f32],
    edge_pixels: &mut Vec<u32>,
) -> u64 {
    // Bound how far a pixel and a block may see from their centres.
    let pattern = &plan.pattern;
    let mut lines = 0;
    let first_x = patch.region.columns.start as f64;
    let step = patch.steps().x;
    let pixel = patch.bounds.each_ref().map(reach_of_pixel);
    let block = patch.bounds.each_ref().map(reach_of_block);
    let sign = Lanes::splat(if patch.flip { -1.0 } else { 1.0 });

    let blocks = RowBlocks { pixels: out.len(), flip: patch.flip };
    for first in (0..blocks.count()).step_by(LANES) {
        // Evaluate the map at the middles of a packet of blocks.
        let middle = |k: usize| first_x + blocks.begin((first + k).min(blocks.count() - 1)) as f64 + HALF_BLOCK;
        let s = Lanes::of(|k| patch.s(middle(k)));
        let ([u, us], [v, vs]) = (row.slope(0, s), row.slope(1, s));
        // u and its slope in the picture's frame.
        let (u, ux, vx) = (u * sign, us * Lanes::splat(step), vs * sign * Lanes::splat(step));

        // Find the blocks that lie within one square.
        let (value, whole) = pattern.squares([u, v], block).constant_off_lines(block);
        let steps = draft.then(|| row.steps(patch, s.0[LANES / 2], plan.active));

        // Fill each block by the cheapest way that serves it.
        for k in 0..LANES.min(blocks.count() - first) {
            let (at, fresh) = (blocks.begin(first + k), blocks.fresh(first + k));
            let span = &mut out[at..at + BLOCK];

            // Fill a block of one square, or of one radiance off the squares: margin or background.
            let centre = DVec2::new(u.0[k], v.0[k]);
            let reach = DVec2::new(block[0].0[0], block[1].0[0]);
            let of_square = (whole.0[k] != 0).then_some(value.0[k]);
            if let Some(value) = of_square.or_else(|| pattern.constant(centre, reach)) {
                span.fill(value as f32);
                continue;
            }

            // Fill a block of squares by draft pixels, and list those that two lines cross.
            if let Some(steps) = &steps
                && let Some(square) = pattern.square(centre, reach)
            {
                let drafted = draft::block(&square, [ux.0[k], vx.0[k]], steps, plan.active);
                span[fresh.clone()].copy_from_slice(&drafted.value[fresh.clone()]);
                lines += drafted.lined[fresh.clone()].iter().map(|lined| u64::from(*lined)).sum::<u64>();
                edge_pixels.extend(fresh.filter(|&i| drafted.crossed[i]).map(|i| (at + i) as u32));
                continue;
            }

            // Fill the pixels that lie within one square, and list the others.
            let mut values = [0.0; BLOCK];
            let map = [[u.0[k], ux.0[k]], [v.0[k], vx.0[k]]];
            let mut edge = |i: usize| edge_pixels.extend(fresh.contains(&i).then_some((at + i) as u32));
            block_pixels(pattern, map, pixel, &mut values, &mut edge);
            span[fresh.clone()].copy_from_slice(&values[fresh]);
        }
    }
    lines
}

/// Integrates the pixels of `edge_pixels`, each by the Taylor expansion of the map at its centre.
#[inline(always)]
pub(super) fn edge_means(
    plan: &Plan,
    patch: &MapPatch,
    row: &RowMap,
    y: f64,
    out: &mut [f32],
    edge_pixels: &[u32],
    work: &mut Work,
) {
    let accuracy = plan.less(patch.truncation_px);
    // What a pixel sees of a Taylor expansion is its active square: steps of its side.
    let step = patch.steps().x * plan.active;
    let first_x = patch.region.columns.start as f64 + 0.5;
    for few in edge_pixels.chunks(LANES) {
        let at = |k: usize| first_x + f64::from(few[k.min(few.len() - 1)]);
        let s = Lanes::of(|k| patch.s(at(k)));
        let taylor = packed_taylor2(patch.flip, step, row.derivatives(0, s), row.derivatives(1, s));
        let means = means_of(plan, &taylor, &accuracy);
        for (k, &i) in few.iter().enumerate() {
            out[i as usize] = mean_or_subdivide(plan, DVec2::new(at(k), y), means[k], work) as f32;
        }
    }
}

/// Multiplies the pixels of a row by the polynomial of the throughput.
#[inline(always)]
fn throughput(patch: &MapPatch, powers: &[Vec<f64>], y: f64, out: &mut [f32]) {
    let t = patch.t(y);
    let mut line = [0.0; MAX_DEGREE + 1];
    for (c, row) in line.iter_mut().zip(powers) {
        *c = row.iter().rev().fold(0.0, |p, c| p * t + c);
    }
    let line = &line[..powers.len()];
    let first_x = patch.region.columns.start as f64 + 0.5;
    for (block, few) in out.chunks_mut(LANES).enumerate() {
        let s = Lanes::of(|k| patch.s(first_x + (block * LANES + k) as f64));
        let throughput = line.iter().rev().fold(Lanes::splat(0.0), |p, &c| p * s + Lanes::splat(c));
        for (value, throughput) in few.iter_mut().zip(throughput.0) {
            *value = (f64::from(*value) * throughput) as f32;
        }
    }
}

/// The Taylor expansions in the picture's frame, from u and v with their derivatives s, ss, t, st, tt (s by s, t by
/// px).
#[inline(always)]
pub(super) fn packed_taylor2(flip: bool, step: f64, u: [Lanes; 6], v: [Lanes; 6]) -> PackedTaylor2 {
    // Where x is counted to the left, u and every derivative by x change their signs.
    let f = Lanes::splat(if flip { -1.0 } else { 1.0 });
    let (step, step2) = (Lanes::splat(step), Lanes::splat(step * step));
    PackedTaylor2 {
        seen: [f * u[0], v[0]],
        dx: [step * u[1], f * step * v[1]],
        dy: [f * u[3], v[3]],
        dxx: [f * step2 * u[2], step2 * v[2]],
        dxy: [step * u[4], f * step * v[4]],
        dyy: [f * u[5], v[5]],
    }
}

/// What the centres of a row see, in mm.
#[inline(always)]
pub(super) fn board(plan: &Plan, patch: &MapPatch, row: &RowMap, out: &mut [[f32; 2]]) {
    let first_x = patch.region.columns.start as f64 + 0.5;
    let mm = 1.0 / plan.pattern.squares_per_mm();
    let sign = if patch.flip { -mm } else { mm };
    for (block, few) in out.chunks_mut(LANES).enumerate() {
        let s = Lanes::of(|k| patch.s(first_x + (block * LANES + k) as f64));
        let ([u, _], [v, _]) = (row.slope(0, s), row.slope(1, s));
        for (k, place) in few.iter_mut().enumerate() {
            *place = [(u.0[k] * sign) as f32, (v.0[k] * mm) as f32];
        }
    }
}
