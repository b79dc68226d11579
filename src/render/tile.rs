//! Pixels by traced centre rays, tile by tile: the map about each centre is taken from differences of its neighbours.

use super::band::Band;
use super::border::{Nearby, border_pixel};
use super::centre_rays::Run;
use super::film::Class;
use super::kinks;
use super::pixel::{ended_ray_radiance, mean_or_subdivide, means_of, subdivided};
use super::pixel_mean::{PackedTaylor2, Taylor2};
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

/// Centres of the pixels of a tile and of those around it, row by row.
struct Centres {
    stride: usize,
    x_mm: Vec<f64>,
    y_mm: Vec<f64>,
    class: Vec<Class>,
    /// The triangles that each passes, where these tell what is seen; else of a prism with creases the facets.
    parts: Option<Vec<[u32; 2]>>,
}

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
            row[i as usize] = kinks::pixel(plan, place(i), work) as f32;
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
        if let Some(light) = triangles::pixel(plan, px, work) {
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

/// Traces the centres of `rect` and of one pixel around it, or the places `off` them, in px.
fn trace(plan: &Plan, rect: &Region, off: DVec2) -> Centres {
    let (stride, rows) = (rect.columns.len() + 2, rect.rows.len() + 2);
    let size = stride * rows + LANES + 1;
    let mut centres = Centres {
        stride,
        x_mm: vec![0.0; size],
        y_mm: vec![0.0; size],
        class: vec![Class::Missed; stride * rows],
        parts: None,
    };
    if plan.by_triangles || plan.creases != PartBorders::None {
        trace_with_parts(plan, rect, off, &mut centres);
        return centres;
    }
    for j in 0..rows {
        let start = first_place(rect, off) + DVec2::new(0.0, j as f64);
        let span = j * stride..(j + 1) * stride;
        let (x_mm, y_mm) = (&mut centres.x_mm[span.clone()], &mut centres.y_mm[span.clone()]);
        plan.centre_tracer.trace(start, Run { x_mm, y_mm, class: &mut centres.class[span] });
    }
    centres
}

/// The first of the places that are traced of a tile.
fn first_place(rect: &Region, off: DVec2) -> DVec2 {
    off + DVec2::new(rect.columns.start as f64 - 0.5, rect.rows.start as f64 - 0.5)
}

/// Traces all places of a tile ray by ray, with the parts of the surfaces that each ray passes.
fn trace_with_parts(plan: &Plan, rect: &Region, off: DVec2, centres: &mut Centres) {
    let (stride, count) = (centres.stride, centres.class.len());
    let part = |k: usize| {
        let place = first_place(rect, off) + DVec2::new((k % stride) as f64, (k / stride) as f64);
        let (sight, parts) = plan.system.trace_with_parts(place);
        match sight {
            Ok(sight) => {
                (centres.x_mm[k], centres.y_mm[k]) = (sight.board_mm.x, sight.board_mm.y);
                centres.class[k] = sight.side.into();
            }
            Err(fate) => centres.class[k] = fate.into(),
        }
        if plan.by_triangles { parts.triangles } else { parts.facets }
    };
    centres.parts = Some((0..count).map(part).collect());
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

impl Centres {
    /// Stores what `count` centres from `at` on see as the ground truth of the pixels of `band` from `start` on.
    fn store_truth(&self, at: usize, band: &mut Band, start: usize, count: usize) {
        let Some(truth) = &mut band.truth else { return };
        for i in 0..count {
            truth.class[start + i] = self.class[at + i];
            truth.board_mm[start + i] = [self.x_mm[at + i] as f32, self.y_mm[at + i] as f32];
        }
    }

    /// Stores what the centres of `rect` see as the ground truth of its pixels.
    fn store_all_truth(&self, rect: &Region, band: &mut Band) {
        for (j, y) in rect.rows.clone().enumerate() {
            let start = band.at(rect.columns.start, y);
            self.store_truth((j + 1) * self.stride + 1, band, start, rect.columns.len());
        }
    }

    /// How many see the board.
    fn lit(&self) -> usize {
        self.class.iter().filter(|class| class.side().is_some()).count()
    }

    /// Whether the eight neighbours of the centre of index `at` are of its class.
    fn is_amid_its_class(&self, at: usize) -> bool {
        let rows = [at - self.stride, at, at + self.stride];
        rows.iter().all(|&k| self.class[k - 1..=k + 1].iter().all(|c| *c == self.class[at]))
    }

    /// Whether it or one of its neighbours sees nothing of the board.
    fn is_beside_a_fate(&self, at: usize) -> bool {
        let rows = [at - self.stride, at, at + self.stride];
        rows.iter().any(|&k| self.class[k - 1..=k + 1].iter().any(|class| class.side().is_none()))
    }

    /// Whether one of its neighbours passes other parts of the same side.
    fn is_beside_other_parts(&self, at: usize) -> bool {
        let Some(parts) = &self.parts else { return false };
        let rows = [at - self.stride, at, at + self.stride];
        let differs = |other: usize| parts[other] != parts[at] && self.class[other] == self.class[at];
        rows.iter().any(|&k| (k - 1..=k + 1).any(differs))
    }

    /// Of the corners of pixels, by their top left ones: whether those of the pixel of index `at` pass several parts of a side.
    fn parts_differ(&self, at: usize) -> bool {
        let Some(parts) = &self.parts else { return false };
        [at + 1, at + self.stride, at + self.stride + 1]
            .iter()
            .any(|&k| parts[k] != parts[at] && self.class[k] == self.class[at])
    }

    /// Of the corners of pixels, by their top left ones: whether one of the pixel of index `at` is not of class `own`.
    fn differ_from(&self, own: Class, at: usize) -> bool {
        [at, at + 1, at + self.stride, at + self.stride + 1].iter().any(|&k| self.class[k] != own)
    }

    /// Whether it and its neighbours see through one side.
    fn is_amid_its_side(&self, at: usize) -> bool {
        self.class[at].side().is_some() && self.is_amid_its_class(at)
    }

    /// The map about the centre of index `at`, by differences of its neighbours; written so that mirror images have the
    /// same bits.
    #[inline(always)]
    fn taylor2(&self, at: usize, squares_per_mm: f64) -> Taylor2 {
        let see = |k: usize| DVec2::new(self.x_mm[k], self.y_mm[k]) * squares_per_mm;
        let [above, below] = [at - self.stride, at + self.stride];
        let seen = see(at);
        Taylor2 {
            seen,
            dx: 0.5 * (see(at + 1) - see(at - 1)),
            dy: 0.5 * (see(below) - see(above)),
            dxx: (see(at + 1) + see(at - 1)) - 2.0 * seen,
            dxy: 0.25 * ((see(below + 1) - see(below - 1)) - (see(above + 1) - see(above - 1))),
            dyy: (see(below) + see(above)) - 2.0 * seen,
        }
    }
}
