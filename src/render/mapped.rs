//! Pixels by the certified map, row by row: blocks within one square are filled, the other pixels are integrated over
//! the map's second-order Taylor expansion.

use super::band::Band;
use super::draft::{self, BLOCK};
use super::map::MapPatch;
use super::map_blocks::constant_pixels;
use super::pixel::{mean_or_subdivide, means_of};
use super::pixel_mean::PackedTaylor2;
use super::plan::Plan;
use super::row_map::RowMap;
use super::steep;
use super::work::Work;
use crate::accuracy::Arithmetic;
use crate::num::chebyshev::MAX_DEGREE;
use crate::num::simd::{Kernel, LANES, Lanes, widest};
use glam::DVec2;

/// A patch is at least this wide.
pub(super) const LEAST_COLUMNS: usize = BLOCK;

/// Renders the rows of `patch` that lie in `band`, which holds all its columns.
pub(super) fn render(plan: &Plan, patch: &MapPatch, band: &mut Band) -> Work {
    widest(PatchRows { plan, patch, band })
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
        let mut maps = [RowMap::none(); LANES];
        for (r, j) in rows.enumerate() {
            if r.is_multiple_of(LANES) {
                RowMap::fill(&mut maps, patch, j, plan.active);
            }
            let (row, y) = (&maps[r % LANES], j as f64 + 0.5);
            let start = band.at(columns.start, j);
            let span = start..start + columns.len();
            let out = &mut band.radiance[span.clone()];
            edge_pixels.clear();
            match plan.plate {
                _ if plan.truth_alone => (),
                None => work.counts.edge_pixels += constant_pixels(plan, patch, row, draft, out, &mut edge_pixels),
                Some(_) => edge_pixels.extend(0..out.len() as u32),
            }
            edge_means(plan, patch, row, y, out, &edge_pixels, &mut work);

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
                board(plan, patch, row, &mut truth.board_mm[span]);
            }
        }
        work
    }
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
        let [[u, _], [v, _]] = row.slopes(s);
        for (k, place) in few.iter_mut().enumerate() {
            *place = [(u.0[k] * sign) as f32, (v.0[k] * mm) as f32];
        }
    }
}
