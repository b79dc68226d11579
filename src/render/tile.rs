//! The pixels of a region, each centre traced.

use super::border::border_pixel;
use super::cover::{Cover, Jet, Jets, cover, mean_of_points};
use super::looks::Run;
use super::plan::{Plan, Region};
use super::{Band, Class, Work, settled};
use crate::num::simd::{Kernel, LANES, Lanes, widest};
use glam::DVec2;

/// Columns traced at a time: as many as keep the centres of a band within a second-level cache.
const TILE_COLUMNS: usize = 256;

/// Below so many lit centres of a tile with dark ones, corners of pixels are asked as well: what is lit may lie between the
/// centres.
const FEW_LIT: usize = 64;

/// Centres of the pixels of a tile and of those around it, row by row.
struct Centres {
    stride: usize,
    x_mm: Vec<f64>,
    y_mm: Vec<f64>,
    class: Vec<Class>,
}

/// Renders the part of `region` that lies in `band`, which holds all its rows.
pub(super) fn render(plan: &Plan, region: &Region, band: &mut Band) -> Work {
    let mut work = Work::default();
    if region.rows.is_empty() {
        return work;
    }
    for first in region.columns.clone().step_by(TILE_COLUMNS) {
        let columns = first..region.columns.end.min(first + TILE_COLUMNS);
        tile(plan, &Region { columns, rows: region.rows.clone() }, band, &mut work);
    }
    work
}

fn tile(plan: &Plan, rect: &Region, band: &mut Band, work: &mut Work) {
    let centres = trace(plan, rect, DVec2::ZERO);
    work.counts.rays += centres.class.len() as u64;
    let stride = centres.stride;
    let first = centres.class[0];
    let one_side = first.side().is_some() && centres.class.iter().all(|c| *c == first);
    let few_lit =
        || centres.class.iter().filter(|class| class.side().is_some()).count() < FEW_LIT.min(centres.class.len());
    let corners = (!one_side && few_lit()).then(|| trace(plan, rect, DVec2::splat(-0.5)));
    work.counts.rays += corners.as_ref().map_or(0, |corners| corners.class.len() as u64);
    let (mut special, mut border) = (Vec::new(), Vec::new());
    for (j, y) in rect.rows.clone().enumerate() {
        let at = (j + 1) * stride + 1;
        let start = (y - band.first_row) * band.width + rect.columns.start;
        let row = &mut band.radiance[start..start + rect.columns.len()];
        let start_px = DVec2::new(rect.columns.start as f64 + 0.5, y as f64 + 0.5);
        special.clear();
        border.clear();
        if !one_side {
            border.extend((0..row.len() as u32).filter(|&i| !centres.is_amid_its_side(at + i as usize)));
        }
        widest(Plain { plan, centres: &centres, at, row, special: &mut special });
        special.retain(|i| border.binary_search(i).is_err());
        widest(Edges { plan, centres: &centres, at, start: start_px, row, special: &special, work });
        if plan.gained {
            plan.gain_row(start_px, row, work);
        }
        for &i in &border {
            let px = start_px + DVec2::new(f64::from(i), 0.0);
            let at = at + i as usize;
            let cornered = corners.as_ref().is_some_and(|corners| corners.differ_from(centres.class[at], at));
            row[i as usize] = pixel(plan, px, &centres, at, cornered, work) as f32;
        }
        if let Some(truth) = &mut band.truth {
            for i in 0..rect.columns.len() {
                truth.class[start + i] = centres.class[at + i];
                truth.board_mm[start + i] = [centres.x_mm[at + i] as f32, centres.y_mm[at + i] as f32];
            }
        }
    }
}

/// Traces the centres of `rect` and of one pixel around it, or the places `off` them, in px.
fn trace(plan: &Plan, rect: &Region, off: DVec2) -> Centres {
    let (stride, rows) = (rect.columns.len() + 2, rect.rows.len() + 2);
    let size = stride * rows + LANES + 1;
    let mut centres =
        Centres { stride, x_mm: vec![0.0; size], y_mm: vec![0.0; size], class: vec![Class::Missed; stride * rows] };
    for j in 0..rows {
        let start = off + DVec2::new(rect.columns.start as f64 - 0.5, (rect.rows.start + j) as f64 - 0.5);
        let span = j * stride..(j + 1) * stride;
        let (x_mm, y_mm) = (&mut centres.x_mm[span.clone()], &mut centres.y_mm[span.clone()]);
        plan.looker.look(start, Run { x_mm, y_mm, class: &mut centres.class[span] });
    }
    centres
}

/// A kernel that fills the pixels of a row that no line of the pattern can touch, and lists the others;
/// all see through one side.
struct Plain<'a> {
    plan: &'a Plan<'a>,
    centres: &'a Centres,
    at: usize,
    row: &'a mut [f32],
    special: &'a mut Vec<u32>,
}

impl Kernel for Plain<'_> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let Self { plan, centres, at, row, special } = self;
        let scale = Lanes::splat(plan.pattern.squares_per_mm());
        let n = row.len();
        for first in (0..n).step_by(LANES) {
            let (x_mm, reach_x) = around(&centres.x_mm, at + first, centres.stride);
            let (y_mm, reach_y) = around(&centres.y_mm, at + first, centres.stride);
            let reach = [reach_x * scale, reach_y * scale];
            let (value, plain) = plan.pattern.squares([x_mm * scale, y_mm * scale], reach).plain(reach);
            value.store(&mut row[first..]);
            if !plain.all() {
                for k in 0..LANES.min(n - first) {
                    if plain.0[k] == 0 {
                        special.push((first + k) as u32);
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

/// A kernel that covers the listed pixels of a row, all of which see through one side.
struct Edges<'a> {
    plan: &'a Plan<'a>,
    centres: &'a Centres,
    at: usize,
    /// The centre of the row's first pixel.
    start: DVec2,
    row: &'a mut [f32],
    special: &'a [u32],
    work: &'a mut Work,
}

impl Kernel for Edges<'_> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let Self { plan, centres, at, start, row, special, work } = self;
        let accuracy = plan.less(plan.third_px);
        for few in special.chunks(LANES) {
            let jet = |i: u32| centres.jet(at + i as usize, plan.pattern.squares_per_mm()).by_steps_of(plan.active);
            let mut jets = Jets::splat(&jet(few[0]));
            for (k, &i) in few.iter().enumerate().skip(1) {
                jets.set_lane(k, &jet(i));
            }
            let covers = cover(&plan.pattern, &jets, &accuracy);
            for (k, &i) in few.iter().enumerate() {
                row[i as usize] = settle(plan, start + DVec2::new(f64::from(i), 0.0), covers[k], work) as f32;
            }
        }
    }
}

/// The light that the pixel at `px` receives, whose centre is that of index `at`; `cornered` where one of its corners is
/// known to be of another class.
fn pixel(plan: &Plan, px: DVec2, centres: &Centres, at: usize, cornered: bool, work: &mut Work) -> f64 {
    let own = centres.class[at];
    if cornered || !centres.is_amid_its_class(at) {
        return border_pixel(plan, px, own, centres.is_beside_a_fate(at), work);
    }
    if own.side().is_none() {
        return dark(plan, own) * plan.gain(px);
    }
    let jet = centres.jet(at, plan.pattern.squares_per_mm()).by_steps_of(plan.active);
    whole_pixel(plan, px, &jet, work) * plan.gain(px)
}

impl Centres {
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
    fn jet(&self, at: usize, squares_per_mm: f64) -> Jet {
        let see = |k: usize| DVec2::new(self.x_mm[k], self.y_mm[k]) * squares_per_mm;
        let [above, below] = [at - self.stride, at + self.stride];
        let seen = see(at);
        Jet {
            seen,
            dx: 0.5 * (see(at + 1) - see(at - 1)),
            dy: 0.5 * (see(below) - see(above)),
            dxx: (see(at + 1) + see(at - 1)) - 2.0 * seen,
            dxy: 0.25 * ((see(below + 1) - see(below - 1)) - (see(above + 1) - see(above - 1))),
            dyy: (see(below) + see(above)) - 2.0 * seen,
        }
    }
}

/// A pixel that sees the board through one side all over.
pub(super) fn whole_pixel(plan: &Plan, px: DVec2, jet: &Jet, work: &mut Work) -> f64 {
    settle(plan, px, cover(&plan.pattern, &Jets::splat(jet), &plan.less(plan.third_px))[0], work)
}

/// The radiance of the pixel at `px` that was covered so; traced in parts where its jet does not tell it.
#[inline(always)]
pub(super) fn settle(plan: &Plan, px: DVec2, covered: Cover, work: &mut Work) -> f64 {
    match covered {
        Cover::Plain(value) => value,
        Cover::Edge { value, parts, off_px } => {
            work.counts.edge_pixels += 1;
            work.counts.divided_pixels += u64::from(parts > 1);
            work.counts.capped_pixels += u64::from(off_px > plan.system.accuracy.bend_px);
            work.bend_px = work.bend_px.max(off_px);
            value
        }
        Cover::TooBent => {
            work.counts.edge_pixels += 1;
            settled::divided(plan, px, work)
        }
    }
}

/// The mean over n x n parts of the active square of the pixel at `px`, each traced, and multiplied by `gain` of its
/// place. Mirror images are summed in pairs.
pub(super) fn mean_of_parts(plan: &Plan, px: DVec2, n: u32, gain: impl Fn(DVec2) -> f64, work: &mut Work) -> f64 {
    let share = 1.0 / f64::from(n);
    let side = plan.active * share;
    let outline = square(0.5 * side);
    let place = |k: u32| (f64::from(2 * k + 1) - f64::from(n)) * (0.5 * side);
    let mut sum = 0.0;
    for j in 0..n {
        let mut part = |i: u32| {
            let at = px + DVec2::new(place(i), place(j));
            part(plan, at, &outline, work) * gain(at)
        };
        for i in 0..n / 2 {
            sum += part(i) + part(n - 1 - i);
        }
        if n % 2 == 1 {
            sum += part(n / 2);
        }
    }
    sum * (share * share)
}

/// A square about the origin, of side 2 `half`.
pub(super) fn square(half: f64) -> [DVec2; 4] {
    [DVec2::new(-half, -half), DVec2::new(half, -half), DVec2::new(half, half), DVec2::new(-half, half)]
}

/// The mean radiance over `outline` (about `px`, in px), by the tangent of the map at `px`.
pub(super) fn part(plan: &Plan, px: DVec2, outline: &[DVec2], work: &mut Work) -> f64 {
    work.counts.rays += 1;
    let footprint = match plan.system.footprint(px) {
        Ok(footprint) => footprint,
        Err(fate) => return dark(plan, fate.into()),
    };
    let scale = plan.pattern.squares_per_mm();
    // At the critical angle itself the map has no derivative.
    if !footprint.jacobian.is_finite() {
        return plan.pattern.at(footprint.sight.board_mm);
    }
    let mut polygon = [DVec2::ZERO; MAX_VERTICES];
    for (corner, p) in polygon.iter_mut().zip(outline) {
        *corner = (footprint.sight.board_mm + footprint.jacobian * *p) * scale;
    }
    let polygon = &polygon[..outline.len()];
    plan.pattern.mean_over(polygon).unwrap_or_else(|| mean_of_points(&plan.pattern, polygon, outline))
}

/// What a ray brings that never reaches the board: nothing from within the glass, the surroundings from past the board.
pub(super) fn dark(plan: &Plan, class: Class) -> f64 {
    if class == Class::PastBoard { plan.pattern.background() } else { 0.0 }
}

/// Corners of a pixel, and at most two cuts.
const MAX_VERTICES: usize = 8;
