//! The tiling of the sensor: rectangles that the certified map stands for, and the rest, whose every pixel is traced.

use super::centre_rays::{CentreTracer, trace_scalar};
use super::film::Class;
use super::map::{BORDER_STEP, INSET_PX, MapPatch};
use super::region::Region;
use super::seam_map::{SIDES, SeamMap};
use crate::effect::Hook;
use crate::surface::shape::Surface;
use crate::system::{Prism, Side, System, Way};
use glam::DVec2;
use std::ops::Range;

/// The sensor, or its right half, as certified patches and regions to be traced.
#[derive(Debug, Default)]
pub(super) struct Tiling {
    pub(super) patches: Vec<MapPatch>,
    /// The columns that seams between ways through the glass pass through, where maps stand for them.
    pub(super) seams: Vec<SeamMap>,
    pub(super) traced: Vec<Region>,
    /// Rays that it took.
    pub(super) rays: u64,
    /// Patches have at least this many pixels along each side.
    pub(super) smallest_px: usize,
}

/// Patches have at least this many pixels along each side: smaller ones are traced for less than their fit costs.
const SMALLEST_PX: usize = 64;
/// A seam that slants over more columns than this share of the width is left to the division of patches.
const MOST_SLANT: usize = 8;
/// The border of the light that looks through the other half's glass is found to this, in px.
const SEAM_PX: f64 = 0.01;
/// Parts between the rows in which a seam is sought that the lens may bend.
const ROWS_OF_A_BENT_SEAM: usize = 16;

/// Divides the columns from `first` on into patches whose error is within the level's bound, and the rest; the smallest of
/// them are `grain` times as large as in a plain picture.
pub(super) fn certify(system: &System, first: usize, grain: usize) -> Tiling {
    let [width, height] = system.camera().size_px();
    let tracer = CentreTracer::new(system, true);
    let mut tiling = Tiling { smallest_px: SMALLEST_PX * grain, ..Tiling::default() };
    let rows = 0..height;
    let creased = system.most_parts() != [1; 2];
    let seam = match (creased, system.is_creased_by_halves_alone()) {
        (false, _) => seam(system, &mut tiling.rays),
        (true, true) => solid_seam(system, &mut tiling.rays),
        (true, false) => None,
    };
    match seam.filter(|seam| seam.len() <= width / MOST_SLANT) {
        // A facet, or a kink, may lie between the rays that check a patch.
        None if creased => tiling.trace(Region { columns: first..width, rows }),
        Some(seam) if seam.end > first => {
            let regions = [first..seam.start.max(first), seam.start.max(first)..seam.end, seam.end..width];
            for (k, columns) in regions.into_iter().enumerate() {
                let region = Region { columns, rows: rows.clone() };
                match k {
                    1 if creased => tiling.cross_solid(&tracer, &seam, region),
                    1 => tiling.cross(&tracer, region, SIDES, false),
                    _ => tiling.divide(&tracer, region),
                }
            }
        }
        _ => tiling.divide(&tracer, Region { columns: first..width, rows }),
    }
    tiling
}

impl Tiling {
    fn trace(&mut self, region: Region) {
        if !region.columns.is_empty() && !region.rows.is_empty() {
            self.traced.push(region);
        }
    }

    /// Fits the region that a seam between these ways passes through, or leaves it to be traced.
    fn cross(&mut self, tracer: &CentreTracer, region: Region, ways: [Way; 2], copied: bool) {
        match SeamMap::fit(tracer, &region, ways, copied, &mut self.rays) {
            Some(seam) => self.seams.push(seam),
            None => self.trace(region),
        }
    }

    /// The same of the region, a part of `columns`, in which light looks through the other half's glass of a solid prism: on both sides
    /// of the ridge of its front it leaves through the backs of both halves.
    fn cross_solid(&mut self, tracer: &CentreTracer, columns: &Range<usize>, region: Region) {
        let system = tracer.system();
        // Surfaces of revolution do not go on beyond the ridge.
        let goes_on = |surface: &Surface| !matches!(surface, Surface::Revolved(_));
        let all_go_on = |prism: &Prism| prism.sides.iter().flatten().all(goes_on);
        let can_be = system.prism().is_some_and(|prism| prism.is_ideal() && all_go_on(prism));
        if !can_be || region.columns.is_empty() {
            return self.trace(region);
        }
        let Some(front) = seam(system, &mut self.rays) else { return self.trace(region) };
        // Where the ridge of the front runs between two columns, so do the ways.
        let [before, after] = if front.is_empty() {
            [front.start; 2]
        } else {
            [columns.start.midpoint(front.start), front.end.midpoint(columns.end)]
        };
        let way = |front: Side, back: Side| Way { front, back };
        let (left, right) = (Side::Left, Side::Right);
        let parts = [
            (columns.start..before, [way(left, left), way(left, right)]),
            (before..after, [way(left, right), way(right, left)]),
            (after..columns.end, [way(right, left), way(right, right)]),
        ];
        let copied = region.columns.start > columns.start;
        for (columns, ways) in parts {
            let start = columns.start.max(region.columns.start);
            let part = Region { columns: start..columns.end.max(start), rows: region.rows.clone() };
            if !part.columns.is_empty() {
                self.cross(tracer, part, ways, copied);
            }
        }
    }

    /// Fits the region, or divides it along its longer side, counted from the picture's axis outward, until it can be.
    fn divide(&mut self, tracer: &CentreTracer, region: Region) {
        let system = tracer.system();
        // Leave small regions to be traced.
        let (columns, rows) = (region.columns.len(), region.rows.len());
        if columns < self.smallest_px || rows < self.smallest_px {
            return self.trace(region);
        }

        // Fit a region that is small enough, whose border nothing clips.
        if columns.max(rows) <= system.accuracy().patch_px
            && passes_all_along(system, &region, &mut self.rays)
            && let Some(mut patch) = MapPatch::fit(tracer, &region, &mut self.rays)
        {
            if system.effects().act_by(Hook::Transport) {
                patch.throughput = patch.fit_throughput(system, &mut self.rays);
            }
            return self.patches.push(patch);
        }

        // Divide any other along its longer side.
        let Region { columns, rows } = region;
        let halves = if columns.len() >= rows.len() {
            let near = columns.len() / 2;
            let left = 2 * columns.end <= system.camera().size_px()[0] + 1;
            let middle = if left { columns.end - near } else { columns.start + near };
            [(columns.start..middle, rows.clone()), (middle..columns.end, rows)]
        } else {
            let middle = rows.start + rows.len() / 2;
            [(columns.clone(), rows.start..middle), (columns, middle..rows.end)]
        };

        // Go on with both halves.
        for (columns, rows) in halves {
            self.divide(tracer, Region { columns, rows });
        }
    }
}

/// Whether nothing clips a ray along the border of `region`: every sample of the margin there is greater than the
/// margin bends between two of them, so that a rim that only just crosses the border is not overlooked.
fn passes_all_along(system: &System, region: &Region, rays: &mut u64) -> bool {
    if !system.clips() {
        return true;
    }
    let low = DVec2::new(region.columns.start as f64, region.rows.start as f64) + INSET_PX;
    let high = DVec2::new(region.columns.end as f64, region.rows.end as f64) - INSET_PX;
    let corners = [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
    (0..4).all(|k| {
        let (from, to) = (corners[k], corners[(k + 1) % 4]);
        let steps = (from.distance(to) / BORDER_STEP as f64).ceil().max(4.0) as usize;
        *rays += steps as u64 + 1;
        let margin = |i: usize| system.margin_mm(from.lerp(to, i as f64 / steps as f64));
        let margins: Vec<f64> = (0..=steps).map(margin).collect();
        let bends = margins.windows(3).map(|m| (m[0] + m[2] - 2.0 * m[1]).abs());
        // A parabola strays from its chords by an eighth of its second difference; margins have kinks at corners.
        let bend = bends.fold(0.0, f64::max);
        margins.iter().all(|m| *m > bend || *m == f64::INFINITY)
    })
}

/// The columns in which light looks through the other half's glass of a solid prism, and those of the seam between them. `None` where a
/// row does not begin with such light of the left half that does not, and end with such of the right one.
fn solid_seam(system: &System, rays: &mut u64) -> Option<Range<usize>> {
    let [width, height] = system.camera().size_px().map(|n| n as f64);
    let mut ends = [Vec::new(), Vec::new()];
    for k in 0..=ROWS_OF_A_BENT_SEAM {
        let y = (height * k as f64 / ROWS_OF_A_BENT_SEAM as f64).clamp(INSET_PX, height - INSET_PX);
        for side in Side::ALL {
            // From where the row begins or ends towards its middle, to the last place of the half that leaves through its own back.
            let mut own = |x: f64| {
                *rays += 2;
                let px = DVec2::new(x, y);
                trace_scalar(system, px).1 == side.into() && system.leaves_by_back_of(px, side)
            };
            let (mut inside, mut beyond) = (INSET_PX, width - INSET_PX);
            if side == Side::Right {
                (inside, beyond) = (beyond, inside);
            }
            if !own(inside) || own(beyond) {
                return None;
            }
            while (beyond - inside).abs() > SEAM_PX {
                let middle = 0.5 * (inside + beyond);
                if own(middle) { inside = middle } else { beyond = middle }
            }
            ends[side as usize].push(inside);
        }
    }
    // A parabola strays from its chords by an eighth of its second difference; what bends otherwise gets as much again.
    let spare = |places: &[f64]| {
        let bends = places.windows(3).map(|x| (x[0] + x[2] - 2.0 * x[1]).abs());
        SEAM_PX + 0.25 * bends.fold(0.0, f64::max)
    };
    let [left, right] = &ends;
    let low = left.iter().copied().fold(f64::INFINITY, f64::min) - spare(left);
    let high = right.iter().copied().fold(f64::NEG_INFINITY, f64::max) + spare(right);
    Some(low.max(0.0).floor() as usize..high.min(width).ceil() as usize)
}

/// The columns that the seam between the sides passes through, in the picture's first, middle and last row, and in rows between
/// where the lens may bend it: none where it runs between two columns. `None` where a row does not begin left and end right of
/// it.
fn seam(system: &System, rays: &mut u64) -> Option<Range<usize>> {
    let [width, height] = system.camera().size_px().map(|n| n as f64);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let parts = if system.camera().keeps_lines() { 2 } else { ROWS_OF_A_BENT_SEAM };
    let mut places = Vec::with_capacity(parts + 1);
    for k in 0..=parts {
        let y = (height * k as f64 / parts as f64).clamp(INSET_PX, height - INSET_PX);
        let (mut a, mut b) = (INSET_PX, width - INSET_PX);
        let mut class = |x: f64| {
            *rays += 1;
            trace_scalar(system, DVec2::new(x, y)).1
        };
        if class(a) != Class::Left || class(b) != Class::Right {
            return None;
        }
        while b - a > 0.5 * INSET_PX {
            let middle = 0.5 * (a + b);
            if class(middle) == Class::Left { a = middle } else { b = middle }
        }
        (low, high) = (low.min(a), high.max(b));
        places.push(a);
    }
    if !system.camera().keeps_lines() {
        // A parabola strays from its chords by an eighth of its second difference; what bends otherwise gets as much again.
        let bends = places.windows(3).map(|x| (x[0] + x[2] - 2.0 * x[1]).abs());
        let spare = 0.25 * bends.fold(0.0, f64::max);
        (low, high) = ((low - spare).max(INSET_PX), (high + spare).min(width - INSET_PX));
    }
    // A seam within the inset of a border between columns is on it.
    let start = (low + 2.0 * INSET_PX).floor() as usize;
    let end = (high - 2.0 * INSET_PX).ceil() as usize;
    Some(start.min(end)..end)
}
