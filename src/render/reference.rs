//! The reference renderer: adaptive subdivision and polygon clipping, slow and simple, to judge the other levels. It
//! shares with them the tracing of single rays and nothing else: neither differentials nor the coverage in closed form,
//! neither a map nor mirror images.
//!
//! A pixel that may hold a line of the pattern, the ridge or the border of a fate is divided in four, and so is each
//! part again, until the map in it strays from a linear one by less than the level's bound: that is measured at the
//! middles of its sides and at its own. Then each part is two triangles on which the map is taken as linear, clipped to
//! the squares of the board one by one (Sutherland & Hodgman 1974). A line lies within what the map strays from its
//! place, and that is stated as the error.

use super::band::Band;
use super::centre_rays::trace_scalar;
use super::film::Class;
use super::passage::Passage;
use super::plan::{PartBorders, Plan};
use super::work::Work;
use crate::scene::BoardSpec;
use crate::system::System;
use glam::{DMat2, DVec2};

/// Halvings of a triangle's side when the place is sought where one passage ends: the side is 1/64 of a pixel, so to 1e-10 px.
const BORDER_HALVINGS: u32 = 28;
/// A part of several passages is divided until its side is this share of a pixel's: in smaller ones a border with a radius of
/// R px takes less than 2e-5 / R of a pixel more than a straight line.
const BORDER_SHARE: f64 = 1.0 / 64.0;
/// The same in a picture of few pixels, where a radius may be as small as a pixel: 2e-6 / R.
const FINE_BORDER_SHARE: f64 = 1.0 / 256.0;
/// A border within a triangle may stray from straight by this share of its length.
const STRAY_SHARE: f64 = 1.0 / 64.0;
/// A triangle of several passages is taken by its vertices when its area is below this, in px^2.
const SMALLEST_AREA: f64 = 1.0 / (1u64 << 25) as f64;
/// A pixel under or beside a border is divided at least until its parts' sides are this share of its own.
const BESIDE_SHARE: f64 = 1.0 / 16.0;
/// Columns or rows of squares that a triangle is clipped to; one that holds more is taken by its middle.
const MOST_STRIPS: usize = 256;

/// A traced place.
#[derive(Debug, Clone, Copy)]
struct TracedPoint {
    /// In the picture, in px.
    px: DVec2,
    /// What became of its ray.
    passage: Passage,
    /// What it sees, in squares from the top left corner of the squares.
    seen: DVec2,
}

/// The renderer of one band.
struct ReferenceRenderer<'a> {
    plan: &'a Plan<'a>,
    system: &'a System,
    board: &'a BoardSpec,
    rays: u64,
    /// How far the map strays from what was taken for it, at most, in px.
    stray_px: f64,
    /// Pixels of which some part would have to be divided further than is allowed.
    capped: bool,
    /// Parts with a longer side are divided even where their corners and their centre see one radiance, in px.
    largest_constant_px: f64,
}

/// Renders all columns of `band`.
pub(super) fn render(plan: &Plan, band: &mut Band) -> Work {
    let mut reference = ReferenceRenderer {
        plan,
        system: plan.system,
        board: &plan.system.board().pattern,
        rays: 0,
        stray_px: 0.0,
        capped: false,
        largest_constant_px: f64::INFINITY,
    };
    let mut work = Work::default();

    // Trace the centres of the band and of one pixel around it.
    let stride = band.width + 2;
    let centres: Vec<TracedPoint> = (0..stride * (band.radiance.len() / band.width + 2))
        .map(|k| DVec2::new((k % stride) as f64 - 0.5, (band.first_row + k / stride) as f64 - 0.5))
        .map(|px| reference.place(px))
        .collect();

    let some_dark = centres.iter().any(|centre| centre.passage.class.side().is_none());

    // Integrate pixel by pixel; beside a border light may pass between the corners of a pixel and its centre.
    for at in 0..band.radiance.len() {
        let (i, j) = (at % band.width, at / band.width);
        let centre = centres[(j + 1) * stride + i + 1];
        let beside = (plan.few_pixels && some_dark)
            || (0..9).any(|k| !centres[(j + k / 3) * stride + i + k % 3].passage.joins(&centre.passage));
        reference.largest_constant_px = if beside { BESIDE_SHARE * plan.active } else { f64::INFINITY };
        band.radiance[at] = reference.pixel(&centre, &mut work) as f32;
        if let Some(truth) = &mut band.truth {
            let (seen_mm, class) = trace_scalar(plan.system, centre.px);
            truth.class[at] = class;
            truth.board_mm[at] = [seen_mm.x as f32, seen_mm.y as f32];
        }
    }
    work.counts.rays += reference.rays;
    work.bend_px = reference.stray_px;
    work
}

impl ReferenceRenderer<'_> {
    fn place(&mut self, px: DVec2) -> TracedPoint {
        self.rays += 1;
        let (seen_mm, class) = trace_scalar(self.system, px);
        let count = DVec2::new(self.board.columns as f64, self.board.rows as f64);
        let passage = Passage::of(self.plan, px, class);
        TracedPoint { px, passage, seen: seen_mm / self.board.square_mm + 0.5 * count }
    }

    /// The mean of the light that the active square of the pixel receives whose centre is `centre`.
    fn pixel(&mut self, centre: &TracedPoint, work: &mut Work) -> f64 {
        let start = centre.px - 0.5 * self.plan.active;
        let corners = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y].map(|c| self.place(start + c * self.plan.active));
        if corners.iter().any(|c| !c.passage.joins(&centre.passage)) {
            self.largest_constant_px = BESIDE_SHARE * self.plan.active;
        }
        if self.plan.active <= self.largest_constant_px
            && let Some(value) = self.constant(&corners, centre)
        {
            return value;
        }
        work.counts.edge_pixels += 1;
        work.counts.cut_pixels += u64::from(corners.iter().any(|c| !c.passage.joins(&centre.passage)));
        self.capped = false;
        let sum = self.divided(corners, self.plan.active);
        work.counts.capped_pixels += u64::from(self.capped);
        sum / (self.plan.active * self.plan.active)
    }

    /// The integral over a square part of a pixel with the given corners, clockwise from the top left.
    fn part(&mut self, [a, b, c, d]: [TracedPoint; 4], side: f64) -> f64 {
        // Integrate a part of one radiance at once.
        if side <= self.largest_constant_px
            && let Some(light) = self.constant(&[a, b, c, d], &middle(&[a, b, c, d]))
            && (self.largest_constant_px.is_infinite() || self.is_amid_its_passage(&a, side))
        {
            return side * side * light;
        }
        self.divided([a, b, c, d], side)
    }

    /// The same of a part that is not constant, or whose centre says so though its corners do not.
    fn divided(&mut self, [a, b, c, d]: [TracedPoint; 4], side: f64) -> f64 {
        // Trace the middles of its sides and its own.
        let between = |x: &TracedPoint, y: &TracedPoint| 0.5 * (x.px + y.px);
        let [top, right, bottom, left] = [(a, b), (b, c), (c, d), (d, a)].map(|(x, y)| self.place(between(&x, &y)));
        let centre = self.place(between(&a, &c));
        let one_passage = [a, b, c, d, top, right, bottom, left].iter().all(|p| p.passage == centre.passage);

        // Find whether the map may be taken as linear in its quarters.
        let kinks_between = self.plan.kinks != PartBorders::None && side > BESIDE_SHARE * self.plan.active;
        let linear = if side > self.largest_constant_px || kinks_between {
            false
        } else if one_passage {
            // Measure how far the middles are seen from the means of the corners, in px by way of d seen / d px.
            let map = DMat2::from_cols(b.seen - a.seen, d.seen - a.seen) * (1.0 / side);
            let off = |p: &TracedPoint, x: &TracedPoint, y: &TracedPoint| {
                (map.inverse() * (p.seen - 0.5 * (x.seen + y.seen))).length()
            };
            let most = off(&top, &a, &b).max(off(&right, &b, &c)).max(off(&bottom, &c, &d)).max(off(&left, &d, &a));
            // In a quarter of the part the map strays a quarter as far.
            let stray_px = 0.25 * most.max(off(&centre, &a, &c)).max(off(&centre, &b, &d));

            // Stop when it strays by less than the bend allowed, or at the deepest division.
            let accuracy = &self.system.accuracy();
            let close = stray_px <= accuracy.bend_px;
            let capped = !close && 2.0 * self.plan.active > f64::from(accuracy.max_division) * side;
            if close || capped {
                self.stray_px = self.stray_px.max(stray_px);
            }
            self.capped |= capped;
            close || capped
        } else {
            let share = if self.plan.few_pixels { FINE_BORDER_SHARE } else { BORDER_SHARE };
            side <= share * self.plan.active
        };

        // Integrate the quarters, as two triangles each or divided again.
        let quarters =
            [[a, top, centre, left], [top, b, right, centre], [centre, right, c, bottom], [left, centre, bottom, d]];
        let quarter = |q: [TracedPoint; 4]| {
            if linear {
                self.triangle([q[0], q[1], q[2]]) + self.triangle([q[0], q[2], q[3]])
            } else {
                self.part(q, 0.5 * side)
            }
        };
        quarters.map(quarter).iter().sum()
    }

    /// Whether the middles of the eight squares around a part, whose top left corner is given, have its passage: the corner of a
    /// border that reaches into it is wider there.
    fn is_amid_its_passage(&mut self, corner: &TracedPoint, side: f64) -> bool {
        let middle = |k: i32| corner.px + side * DVec2::new(f64::from(k % 3) - 0.5, f64::from(k / 3) - 0.5);
        (0..9).all(|k| self.place(middle(k)).passage.joins(&corner.passage))
    }

    /// The light of a pixel or a part that is the same all over: its corners and its centre see one colour, and so does a
    /// rectangle around what they see that is half as large again.
    fn constant(&self, corners: &[TracedPoint; 4], centre: &TracedPoint) -> Option<f64> {
        if corners.iter().any(|c| !c.passage.joins(&centre.passage)) {
            return None;
        }
        if centre.passage.class.side().is_none() {
            return Some(self.light(centre));
        }
        if self.plan.plate.is_some() {
            return None;
        }
        let low = corners.iter().fold(centre.seen, |low, c| low.min(c.seen));
        let high = corners.iter().fold(centre.seen, |high, c| high.max(c.seen));
        // Beyond a kink it may be seen farther out.
        let kinked = corners.iter().any(|c| c.passage != centre.passage);
        let margin = if kinked { 3.0 } else { 0.25 } * (high - low);
        let whole = (0..2).all(|axis| self.lines(axis, low - margin, high + margin).is_empty());
        whole.then(|| self.light(centre))
    }

    /// The lines of the pattern across `axis` between `low` and `high`: of the squares and of the plate's rim.
    fn lines(&self, axis: usize, low: DVec2, high: DVec2) -> Vec<f64> {
        let count = [self.board.columns, self.board.rows][axis] as f64;
        let margin = self.board.margin_mm / self.board.square_mm;
        let (low, high) = (low[axis], high[axis]);
        let first = low.ceil().clamp(0.0, count + 1.0);
        let last = high.floor().clamp(-1.0, count);
        let squares = (0..=(last - first).max(-1.0) as i64).filter(|_| last >= first).map(|k| first + k as f64);
        let rim = [-margin, count + margin].into_iter().filter(|_| margin > 0.0);
        let mut lines: Vec<f64> =
            squares.take(MOST_STRIPS + 1).chain(rim).filter(|line| (low..=high).contains(line)).collect();
        lines.sort_by(f64::total_cmp);
        lines
    }

    /// What a place sees, in mm in the board's frame.
    fn mm(&self, place: &TracedPoint) -> DVec2 {
        (place.seen - 0.5 * DVec2::new(self.board.columns as f64, self.board.rows as f64)) * self.board.square_mm
    }

    /// The radiance at a place.
    fn radiance(&self, place: &TracedPoint) -> f64 {
        let board = self.board;
        let count = DVec2::new(board.columns as f64, board.rows as f64);
        let outside = (place.seen - count).max(-place.seen).max_element();
        match place.passage.class {
            Class::Left | Class::Right if self.plan.plate.is_some() => self.plan.face().at(self.mm(place)),
            Class::Left | Class::Right if outside > board.margin_mm / board.square_mm => board.background,
            Class::Left | Class::Right if outside > 0.0 => board.white,
            Class::Left | Class::Right => {
                // The top left square is black.
                let cell = place.seen.floor();
                if (cell.x + cell.y).rem_euclid(2.0) == 0.0 { board.black } else { board.white }
            }
            Class::PastBoard => board.background,
            Class::Missed | Class::TotalReflection | Class::NotConverged | Class::Clipped => 0.0,
        }
    }

    /// What the pixel receives from a place: its radiance, or what transport effects leave of it.
    fn light(&self, place: &TracedPoint) -> f64 {
        self.radiance(place) * self.plan.throughput(place.px)
    }

    /// The integral over a triangle, cut in two where a border passes through it.
    fn triangle(&mut self, [a, b, c]: [TracedPoint; 3]) -> f64 {
        if a.passage == b.passage && b.passage == c.passage {
            return self.whole_triangle(&[a, b, c]);
        }
        let one_apart = [[a, b, c], [b, c, a], [c, a, b]].into_iter().find(|[_, x, y]| x.passage == y.passage);
        let Some([lone, x, y]) = one_apart else { return self.of_several(&[a, b, c]) };
        let ([near_x, far_x], [near_y, far_y]) = (self.border(lone, x), self.border(lone, y));
        if !self.is_straight([&near_x, &near_y], &lone, far_x.passage) {
            return self.of_several(&[a, b, c]);
        }
        let apart = self.whole_triangle(&[lone, near_x, near_y]);
        if far_x.passage == x.passage && far_y.passage == y.passage {
            return apart + self.whole_triangle(&[far_x, x, y]) + self.whole_triangle(&[far_x, y, far_y]);
        }

        // Or a strip of a third passage lies between.
        let ([begin_x, last_x], [begin_y, last_y]) = (self.border(x, lone), self.border(y, lone));
        let third = [last_x, far_y, last_y].iter().all(|place| place.passage == far_x.passage);
        if !third || !self.is_straight([&begin_x, &begin_y], &x, far_x.passage) {
            return self.of_several(&[a, b, c]);
        }
        let strip = self.whole_triangle(&[far_x, last_x, last_y]) + self.whole_triangle(&[far_x, last_y, far_y]);
        apart + strip + self.whole_triangle(&[begin_x, x, y]) + self.whole_triangle(&[begin_x, y, begin_y])
    }

    /// Whether the border between two places is no corner: beside its middle the passage is that of `own`, a vertex of the
    /// triangle, and `beyond` on the other side. What strays less takes less than 1/128 of the border's square.
    fn is_straight(&mut self, [from, to]: [&TracedPoint; 2], own: &TracedPoint, beyond: Passage) -> bool {
        let (middle, chord) = (0.5 * (from.px + to.px), to.px - from.px);
        if chord.length_squared() < SMALLEST_AREA {
            return true;
        }
        let across = chord.perp() * STRAY_SHARE;
        let inward = if across.dot(own.px - middle) < 0.0 { -across } else { across };
        let known = |passage: Passage| passage == own.passage || passage == beyond;
        let [inside, outside] = [middle + inward, middle - inward].map(|px| self.place(px).passage);
        // A third passage is found by the borders of the other sides.
        (inside == own.passage || !known(inside)) && (outside == beyond || !known(outside))
    }

    /// The places between `a` and `b` where the passage of `a` ends: the last of it, and the first after it.
    fn border(&mut self, a: TracedPoint, b: TracedPoint) -> [TracedPoint; 2] {
        let (mut near, mut far) = (a, b);
        for _ in 0..BORDER_HALVINGS {
            let middle = self.place(0.5 * (near.px + far.px));
            if middle.passage == a.passage { near = middle } else { far = middle }
        }
        [near, far]
    }

    /// The integral over a triangle of several passages: of the four that the middles of its sides make of it, and of a small
    /// one by its vertices alone.
    fn of_several(&mut self, [a, b, c]: &[TracedPoint; 3]) -> f64 {
        if area(&[*a, *b, *c]) < SMALLEST_AREA {
            return area(&[*a, *b, *c]) * [a, b, c].map(|vertex| self.light(vertex)).iter().sum::<f64>() / 3.0;
        }
        let [d, e, f] = [(a, b), (b, c), (c, a)].map(|(x, y)| self.place(0.5 * (x.px + y.px)));
        [[*a, d, f], [d, *b, e], [f, e, *c], [d, e, f]].map(|quarter| self.triangle(quarter)).iter().sum()
    }

    /// The integral over a triangle of one passage, on which the map is linear.
    fn whole_triangle(&self, vertices: &[TracedPoint; 3]) -> f64 {
        let low = vertices[0].seen.min(vertices[1].seen).min(vertices[2].seen);
        let high = vertices[0].seen.max(vertices[1].seen).max(vertices[2].seen);
        if vertices[0].passage.class.side().is_none() {
            return area(vertices) * self.light(&vertices[0]);
        }
        if let Some(plate) = self.plan.plate {
            let mm = vertices.map(|p| self.mm(&p));
            let mean = plate.mean_over(&mm).unwrap_or_else(|| plate.at(self.mm(&middle(vertices))));
            return area(vertices) * mean * self.plan.throughput(middle(vertices).px);
        }
        let lines = [self.lines(0, low, high), self.lines(1, low, high)];
        if lines.iter().any(|l| l.len() > MOST_STRIPS) {
            return area(vertices) * self.light(&middle(vertices));
        }
        let mut sum = 0.0;
        for column in strips(vertices, 0, &lines[0]) {
            for cell in strips(&column, 1, &lines[1]) {
                if !cell.is_empty() {
                    sum += area(&cell) * self.light(&middle(&cell));
                }
            }
        }
        sum
    }
}

/// The convex polygon in pieces, between one line across `axis` and the next.
fn strips(polygon: &[TracedPoint], axis: usize, lines: &[f64]) -> Vec<Vec<TracedPoint>> {
    let mut pieces = Vec::with_capacity(lines.len() + 1);
    let mut rest = polygon.to_vec();
    for &line in lines {
        pieces.push(clipped(&rest, |p| line - p.seen[axis]));
        rest = clipped(&rest, |p| p.seen[axis] - line);
    }
    pieces.push(rest);
    pieces
}

/// The part of the polygon where `inside`, which is linear on it, is not below zero.
fn clipped(polygon: &[TracedPoint], inside: impl Fn(&TracedPoint) -> f64) -> Vec<TracedPoint> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (k, a) in polygon.iter().enumerate() {
        let b = &polygon[(k + 1) % polygon.len()];
        let (here, there) = (inside(a), inside(b));
        if here >= 0.0 {
            kept.push(*a);
        }
        if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
            let t = here / (here - there);
            kept.push(TracedPoint { px: a.px.lerp(b.px, t), seen: a.seen.lerp(b.seen, t), passage: a.passage });
        }
    }
    kept
}

/// The area of a polygon in the picture, in px^2.
fn area(polygon: &[TracedPoint]) -> f64 {
    let from = polygon[0].px;
    let pairs = polygon.windows(2);
    0.5 * pairs.map(|pair| (pair[0].px - from).perp_dot(pair[1].px - from)).sum::<f64>().abs()
}

/// The mean of the vertices.
fn middle(polygon: &[TracedPoint]) -> TracedPoint {
    let n = polygon.len() as f64;
    let mean = |of: fn(&TracedPoint) -> DVec2| polygon.iter().map(of).sum::<DVec2>() / n;
    TracedPoint { px: mean(|p| p.px), seen: mean(|p| p.seen), passage: polygon[0].passage }
}
