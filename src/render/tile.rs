//! Pixels by traced centre rays, tile by tile: the map about each centre is taken from differences of its neighbours.

use super::band::Band;
use super::border::{Nearby, border_pixel};
use super::centres::{Centres, trace};
use super::kinks;
use super::pixel::{ended_ray_radiance, mean_or_subdivide, means_of, subdivided};
use super::pixel_mean::PackedTaylor2;
use super::plan::{PartBorders, Plan};
use super::region::Region;
use super::steep;
use super::triangles;
use super::work::Work;
use crate::num::simd::{Kernel, LANES, Lanes, widest};
use glam::DVec2;
use std::ops::Range;

/// Columns traced at a time: as many as keep the centres of a band within a second-level cache.
const TILE_COLUMNS: usize = 256;

/// With so few lit centres in a tile that has dark ones, corners of pixels are traced as well: what is lit may lie between
/// the centres.
const FEW_LIT: usize = 64;

/// Renders the part of `region` that lies in `band`, which holds all its rows.
pub(super) fn render(plan: &Plan, region: &Region, band: &mut Band) -> Work {
    let mut work = Work::default();
    if region.rows.is_empty() || region.columns.is_empty() {
        return work;
    }
    for first in region.columns.clone().step_by(TILE_COLUMNS) {
        let columns = first..region.columns.end.min(first + TILE_COLUMNS);
        tile(plan, &Region { columns, rows: region.rows.clone() }, band, &mut work);
    }
    work
}

fn tile(plan: &Plan, rect: &Region, band: &mut Band, work: &mut Work) {
    // Trace the centres of the tile and of one pixel around it.
    let centres = trace(plan, rect, DVec2::ZERO);
    work.counts.rays += centres.class.len() as u64;
    if plan.truth_alone {
        return centres.store_all_truth(rect, band);
    }
    let stride = centres.stride;
    let first = centres.class[0];
    let one_side = first.side().is_some() && centres.class.iter().all(|c| *c == first);

    // Where few centres are lit, trace the corners too; where there are few at all, light may pass between both.
    let few_lit = || centres.lit() < FEW_LIT.min(centres.class.len());
    // A facet may have a notch between the centres, a triangle has none.
    let notched = plan.creases == PartBorders::Few && !plan.by_triangles;
    let corners = ((!one_side && few_lit()) || notched).then(|| trace(plan, rect, DVec2::splat(-0.5)));
    work.counts.rays += corners.as_ref().map_or(0, |corners| corners.class.len() as u64);

    // Fill row by row.
    let (mut edge_pixels, mut border) = (Vec::new(), Vec::new());
    for (j, y) in rect.rows.clone().enumerate() {
        let at = (j + 1) * stride + 1;
        let start = band.at(rect.columns.start, y);
        let row = &mut band.radiance[start..start + rect.columns.len()];
        let start_px = DVec2::new(rect.columns.start as f64 + 0.5, y as f64 + 0.5);
        edge_pixels.clear();
        border.clear();

        // List the pixels beside a border.
        let between = corners.as_ref().filter(|_| notched);
        work.counts.unpromised_pixels +=
            list_borders(plan, &centres, between, at..at + row.len(), one_side, &mut border);

        // Fill the pixels within one square, then integrate those on lines of the pattern.
        constant_pixels(plan, &centres, at, row, &mut edge_pixels);
        edge_pixels.retain(|i| border.binary_search(i).is_err());
        let kinked = kinked_pixels(plan, &centres, at, start_px, &mut edge_pixels, work);
        widest(EdgePixels { plan, centres: &centres, at, start: start_px, row, edge_pixels: &edge_pixels, work });

        // Apply the throughput of transport effects.
        if plan.has_throughput {
            plan.attenuate_row(start_px, row, work);
            if plan.steep {
                let plain = |i| border.binary_search(&i).is_err() && kinked.binary_search(&i).is_err();
                steep::row(plan, start_px, row, plain, work);
            }
        }

        // Integrate the pixels with a kink and those beside a border one by one.
        let place = |i: u32| start_px + DVec2::new(f64::from(i), 0.0);
        for &i in &kinked {
            row[i as usize] = kinks::pixel(plan, place(i), centres.triangles(at + i as usize), work) as f32;
        }
        for &i in &border {
            let cornered =
                corners.as_ref().is_some_and(|c| c.differ_from(centres.class[at + i as usize], at + i as usize));
            row[i as usize] = beside_border(plan, place(i), &centres, at + i as usize, cornered, work) as f32;
        }

        centres.store_truth(at, band, start, rect.columns.len());
    }
}

/// Lists the pixels of a row beside a border, of `centres` with the indices `span`, and counts those on more creases than are followed.
/// `between` are the corners, where creases may lie between the centres.
fn list_borders(
    plan: &Plan,
    centres: &Centres,
    between: Option<&Centres>,
    span: Range<usize>,
    one_side: bool,
    border: &mut Vec<u32>,
) -> u64 {
    let creased = |k: usize| centres.is_beside_other_parts(k) || between.is_some_and(|corners| corners.parts_differ(k));
    let follows = plan.follows_creases();
    if !one_side || follows {
        let beside = |k: &usize| !centres.is_amid_its_side(*k) || (follows && creased(*k));
        border.extend(span.clone().filter(beside).map(|k| (k - span.start) as u32));
    }
    if plan.creases != PartBorders::Many || follows {
        return 0;
    }
    span.filter(|k| creased(*k)).count() as u64
}

/// Fills the pixels of a row that are of one radiance, and lists the others: of a texture all.
fn constant_pixels(plan: &Plan, centres: &Centres, at: usize, row: &mut [f32], edge_pixels: &mut Vec<u32>) {
    match plan.plate {
        None => widest(ConstantPixels { plan, centres, at, row, edge_pixels }),
        Some(_) => edge_pixels.extend(0..row.len() as u32),
    }
}

/// Takes those out of the listed pixels of a row, whose first is at `start_px` and has the index `at`, whose expansion does not
/// hold for the kinks of the map.
fn kinked_pixels(
    plan: &Plan,
    centres: &Centres,
    at: usize,
    start_px: DVec2,
    edge_pixels: &mut Vec<u32>,
    work: &mut Work,
) -> Vec<u32> {
    if plan.kinks == PartBorders::None {
        return Vec::new();
    }
    let place = |i: &u32| start_px + DVec2::new(f64::from(*i), 0.0);
    let taylor = |i: &u32| centres.taylor2(at + *i as usize, plan.pattern.squares_per_mm());
    edge_pixels.extract_if(.., |i| !kinks::holds(plan, place(i), &taylor(i), work)).collect()
}

/// The radiance of the pixel at `px`, whose centre has the index `at` and has a border beside it; `cornered` where its own
/// corners tell of one.
fn beside_border(plan: &Plan, px: DVec2, centres: &Centres, at: usize, cornered: bool, work: &mut Work) -> f64 {
    let own = centres.class[at];
    if plan.by_triangles && !centres.is_beside_a_fate(at) {
        if let Some(light) = centres.triangles(at).and_then(|middle| triangles::pixel(plan, px, middle, work)) {
            work.counts.edge_pixels += 1;
            return light;
        }
        if plan.creases == PartBorders::Many {
            work.counts.unpromised_pixels += 1;
            return subdivided(plan, px, work) * plan.throughput(px);
        }
    }
    let creased = [plan.creases, plan.kinks].contains(&PartBorders::Few) && own.side().is_some();
    let nearby = match (plan.few_pixels, centres.is_beside_a_fate(at)) {
        (_, false) if creased => Nearby::Border,
        (_, false) => Nearby::Ridge,
        (false, true) => Nearby::Border,
        (true, true) => Nearby::Anything,
    };
    if cornered || creased || nearby == Nearby::Anything || !centres.is_amid_its_class(at) {
        border_pixel(plan, px, own, nearby, work)
    } else {
        ended_ray_radiance(plan, own) * plan.throughput(px)
    }
}

/// A kernel that fills the pixels of a row that no line of the pattern can touch, and lists the others;
/// all see through one side.
struct ConstantPixels<'a> {
    plan: &'a Plan<'a>,
    centres: &'a Centres,
    at: usize,
    row: &'a mut [f32],
    edge_pixels: &'a mut Vec<u32>,
}

impl Kernel for ConstantPixels<'_> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let Self { plan, centres, at, row, edge_pixels } = self;
        let scale = Lanes::splat(plan.pattern.squares_per_mm());
        let n = row.len();
        for first in (0..n).step_by(LANES) {
            let (x_mm, reach_x) = around(&centres.x_mm, at + first, centres.stride);
            let (y_mm, reach_y) = around(&centres.y_mm, at + first, centres.stride);
            let reach = [reach_x * scale, reach_y * scale];
            let (value, constant) = plan.pattern.squares([x_mm * scale, y_mm * scale], reach).constant_off_lines(reach);
            value.store(&mut row[first..]);
            if !constant.all() {
                for k in 0..LANES.min(n - first) {
                    if constant.0[k] == 0 {
                        edge_pixels.push((first + k) as u32);
                    }
                }
            }
        }
    }
}

/// A packet of values from `at` on, and how far their pixels reach from them by differences of their neighbours: half a step
/// each way, and the second differences, of which a pixel holds an eighth (of the mixed one, a quarter). Reads may go up to
/// a packet beyond the row: the buffers end with that many more.
#[inline(always)]
fn around(v: &[f64], at: usize, stride: usize) -> (Lanes, Lanes) {
    let half = Lanes::splat(0.5);
    let own = Lanes::load(&v[at..]);
    let (left, right) = (Lanes::load(&v[at - 1..]), Lanes::load(&v[at + 1..]));
    let (above, below) = (Lanes::load(&v[at - stride..]), Lanes::load(&v[at + stride..]));
    let (above_left, above_right) = (Lanes::load(&v[at - stride - 1..]), Lanes::load(&v[at - stride + 1..]));
    let (below_left, below_right) = (Lanes::load(&v[at + stride - 1..]), Lanes::load(&v[at + stride + 1..]));
    let mixed = half * ((below_right - below_left) - (above_right - above_left)).abs();
    let bend = (left + right - (own + own)).abs() + (above + below - (own + own)).abs() + mixed;
    (own, half * (half * ((right - left).abs() + (below - above).abs())) + bend)
}

/// A kernel that integrates the listed pixels of a row, all of which see through one side.
struct EdgePixels<'a> {
    plan: &'a Plan<'a>,
    centres: &'a Centres,
    at: usize,
    /// The centre of the row's first pixel.
    start: DVec2,
    row: &'a mut [f32],
    edge_pixels: &'a [u32],
    work: &'a mut Work,
}

impl Kernel for EdgePixels<'_> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let Self { plan, centres, at, start, row, edge_pixels, work } = self;
        let accuracy = plan.less(plan.truncation_px);
        for few in edge_pixels.chunks(LANES) {
            let taylor =
                |i: u32| centres.taylor2(at + i as usize, plan.pattern.squares_per_mm()).by_steps_of(plan.active);
            let mut packed = PackedTaylor2::splat(&taylor(few[0]));
            for (k, &i) in few.iter().enumerate().skip(1) {
                packed.set_lane(k, &taylor(i));
            }
            let means = means_of(plan, &packed, &accuracy);
            for (k, &i) in few.iter().enumerate() {
                row[i as usize] = mean_or_subdivide(plan, start + DVec2::new(f64::from(i), 0.0), means[k], work) as f32;
            }
        }
    }
}
