//! Pixels in which several triangles of a mesh are seen: cut along the sides of the triangles of front and back, and along the ridge, in
//! pieces, each of which is seen through one triangle of either.
//!
//! A triangle's plane goes on beyond its sides, and so do the normals that it blends. So what is seen through a pair of triangles is a
//! smooth map of the place all over the pixel, and how far within their sides that is, are smooth functions of it, whose zeros are the
//! sides: of the front straight lines, of the back nearly so. From the pair at the middle one goes on to those beyond its sides. Where
//! the pieces do not add up to the pixel, or something is not straight enough, it is quartered.

use super::pixel::square;
use super::pixel_mean::{Taylor2, mean_of_points};
use super::plan::Plan;
use super::truncation_error::in_px;
use super::work::Work;
use crate::num::simd::{Kernel, LANES, Lanes, widest};
use crate::prism::lanes::Rays;
use crate::prism::triangles::TrianglePair;
use crate::surface::face::Face;
use crate::system::{EightWithin, Side};
use crate::texture::Convex;
use glam::{DMat2, DVec2};

/// Triangles of a surface in a part of a pixel at most: of more, its quarters see fewer.
const MOST_TRIANGLES: usize = 32;
/// The side that is none of a triangle but the ridge.
const RIDGE: usize = 3;
/// A part's side is not divided below this, in px.
const SMALLEST_PX: f64 = 1.0 / 64.0;
/// What a border, and the expansion of a map, may stray by, as a share of the bend allowed.
const STRAY_SHARE: f64 = 0.25;
/// A polygon between the places that its corners see strays from the piece by as much as the map does along two of its sides at a
/// corner, and weighs what is within by as much again.
const STRAYS: f64 = 4.0;
/// The shares of the pieces may differ from one by this.
const ROUNDING: f64 = 1e-9;
/// Times that a piece is halved at most.
const MOST_HALVINGS: u32 = 12;
/// The most corners of a polygon whose mean is known.
const MOST_CORNERS: usize = 8;

/// The light of the pixel at `px`, all of which sees the board, given the triangles that its centre sees; `None` where triangles do not
/// tell it.
pub(super) fn pixel(plan: &Plan, px: DVec2, middle: TrianglePair, work: &mut Work) -> Option<f64> {
    if !plan.by_triangles || plan.steep {
        return None;
    }
    let whole = [DVec2::ZERO, DVec2::splat(0.5 * plan.active)];
    let light = pieces(plan, px, whole, middle, work).or_else(|| quarters(plan, px, whole, work))?;
    Some(light / (plan.active * plan.active))
}

/// The light of a square part of the pixel by its quarters, given by its centre (about `px`) and half its size, times its area.
fn quarters(plan: &Plan, px: DVec2, [centre, half]: [DVec2; 2], work: &mut Work) -> Option<f64> {
    if 2.0 * half.x <= SMALLEST_PX {
        return None;
    }
    let quarter = |at: DVec2, work: &mut Work| {
        let area = [centre + at * half, 0.5 * half];
        work.counts.rays += 1;
        let middle = plan.system.triangles_at(px + area[0]);
        middle.and_then(|middle| pieces(plan, px, area, middle, work)).or_else(|| quarters(plan, px, area, work))
    };
    square(0.5).into_iter().map(|at| quarter(at, work)).sum()
}

/// The same by the pieces of all pairs of triangles, given the pair that its centre sees.
fn pieces(plan: &Plan, px: DVec2, area: [DVec2; 2], seen: TrianglePair, work: &mut Work) -> Option<f64> {
    let [centre, half] = area;
    let outline = Convex::new(&square(1.0).map(|corner| centre + corner * half));
    let mut fronts = vec![seen];
    let (mut light, mut covered, mut next) = (0.0, 0.0, 0);
    while let Some(&TrianglePair { side, triangles: [triangle, seen_by] }) = fronts.get(next) {
        next += 1;
        let front = FrontView::new(plan, px, (side, triangle), area, work)?;
        let beyond_front = crossed(&outline, &front.sides);
        let on_front = cut(&outline, &front.sides, beyond_front);
        if on_front.area() <= 0.0 {
            continue;
        }

        // Take its pieces by the triangles of the back, from one to those beyond its sides; where nothing is seen by one, towards one
        // by which it is.
        let (mut backs, mut next_back, mut last_seen) = (vec![seen_by], 0, seen_by);
        while let Some(&back) = backs.get(next_back) {
            next_back += 1;
            let view = View::new(plan, &front, back, area, work)?;
            let beyond_back = crossed(&on_front, &view.sides);
            let piece = cut(&on_front, &view.sides, beyond_back);
            let go_on = |of: usize| {
                let beyond = plan.system.beyond(side, Face::Back, back, of);
                backs.extend(beyond.filter(|beyond| !backs.contains(beyond)));
            };
            if piece.area() > 0.0 {
                last_seen = back;
                covered += piece.area();
                light += view.light(plan, &piece, MOST_HALVINGS, work) * plan.throughput(px + middle(&piece));
                (0..4).filter(|&of| beyond_back[of]).for_each(go_on);
            } else {
                farthest_out(middle(&on_front), &view.sides).into_iter().for_each(go_on);
            }
            if backs.len() > MOST_TRIANGLES {
                return None;
            }
        }

        // Go on to the triangles of the front beyond its sides, and beyond the ridge to that of the same number.
        for of in (0..4).filter(|&of| beyond_front[of]) {
            let (side, triangle) = match of {
                RIDGE => (side.other(), triangle),
                _ => match plan.system.beyond(side, Face::Front, triangle, of) {
                    Some(beyond) => (side, beyond),
                    None => continue,
                },
            };
            if !fronts.iter().any(|known| (known.side, known.triangles[0]) == (side, triangle)) {
                fronts.push(TrianglePair { side, triangles: [triangle, last_seen] });
            }
        }
        if fronts.len() > MOST_TRIANGLES {
            return None;
        }
    }
    ((covered - outline.area()).abs() <= ROUNDING * outline.area()).then_some(light)
}

/// The middle of what is about a polygon.
fn middle(polygon: &Convex) -> DVec2 {
    let [low, high] = polygon.bounds();
    0.5 * (low + high)
}

/// What of a polygon is within these sides, of which it is within all but those that are told.
fn cut(polygon: &Convex, sides: &[Linear; 4], crossed: [bool; 4]) -> Convex {
    let mut kept = *polygon;
    for (side, _) in sides.iter().zip(crossed).filter(|(_, crossed)| *crossed) {
        kept = kept.cut(|p| side.at(p));
    }
    kept
}

/// Beyond which sides a part of the polygon is.
fn crossed(polygon: &Convex, sides: &[Linear; 4]) -> [bool; 4] {
    sides.map(|side| polygon.vertices().iter().any(|p| side.at(*p) < 0.0))
}

/// The side of a triangle beyond which a place is farthest.
fn farthest_out(place: DVec2, sides: &[Linear; 4]) -> Option<usize> {
    let out = |side: &usize| sides[*side].at(place) / sides[*side].slope.length();
    (0..RIDGE).min_by(|a, b| out(a).total_cmp(&out(b))).filter(|side| out(side) < 0.0)
}

/// The places of eight rays around a part of a pixel, row by row, by steps of half its sides from its middle.
const AROUND: [[f64; 2]; LANES] =
    [[-1.0, -1.0], [0.0, -1.0], [1.0, -1.0], [-1.0, 0.0], [1.0, 0.0], [-1.0, 1.0], [0.0, 1.0], [1.0, 1.0]];

/// What a smooth function is in the middle of eight places around a square, row by row, given what it is there: that of a polynomial
/// of them (the serendipity element of quadratic order), from which it strays by its term of fourth order in x^2 y^2 alone.
fn in_the_middle([nw, n, ne, w, e, sw, s, se]: [f64; LANES]) -> f64 {
    0.5 * ((n + s) + (w + e)) - 0.25 * ((nw + se) + (ne + sw))
}

/// What a part of a pixel sees in a triangle of the front.
struct FrontView {
    side: Side,
    /// How far within its sides, and right of the ridge or left of it, as linear functions of the place about the pixel's centre.
    sides: [Linear; 4],
    /// The rays in the glass behind it.
    inside: Rays,
}

impl FrontView {
    /// By eight rays; `None` where one of them does not pass it, or something is not straight enough.
    fn new(plan: &Plan, px: DVec2, (side, triangle): (Side, u32), area: [DVec2; 2], work: &mut Work) -> Option<Self> {
        work.counts.rays += LANES as u64;
        let [centre, half] = area;
        let places = AROUND.map(|around| px + (centre + half * DVec2::from_array(around)));
        let (inside, within) = plan.system.eight_behind_front(&places, side, triangle)?;
        Some(Self { side, sides: widest(Sides { within: &within, area, stray_px: stray_px(plan) })?, inside })
    }
}

/// What a border, and the expansion of a map, may stray by, in px.
fn stray_px(plan: &Plan) -> f64 {
    STRAY_SHARE * plan.system.accuracy().bend_px
}

/// What a part of a pixel sees through a pair of triangles.
struct View {
    /// How far within the sides of the back's, as linear functions of the place about the pixel's centre.
    sides: [Linear; 4],
    /// The middle of the part, about the pixel's centre.
    centre: DVec2,
    /// The map about it, in squares by px.
    map: Taylor2,
    inverse: DMat2,
}

impl View {
    /// By the eight rays behind the front's; `None` where one of them does not pass the back's, or something is not straight enough.
    fn new(plan: &Plan, front: &FrontView, back: u32, area: [DVec2; 2], work: &mut Work) -> Option<Self> {
        // Trace them, row by row.
        work.counts.rays += LANES as u64;
        let (seen_mm, within) = plan.system.eight_behind_back(&front.inside, front.side, back)?;
        let seen = seen_mm.map(|mm| mm * Lanes::splat(plan.pattern.squares_per_mm()));
        let sides = widest(Sides { within: &within, area, stray_px: stray_px(plan) })?;

        // Take the map by differences, and compare its expansion with the corners.
        let [centre, half] = area;
        let [nw, n, ne, w, e, sw, s, se] = std::array::from_fn(|k| DVec2::new(seen[0].0[k], seen[1].0[k]));
        let c = DVec2::from_array(seen.map(|of| in_the_middle(of.0)));
        let map = Taylor2 {
            seen: c,
            dx: (e - w) / (2.0 * half.x),
            dy: (s - n) / (2.0 * half.y),
            dxx: ((e + w) - 2.0 * c) / (half.x * half.x),
            dxy: ((se - sw) - (ne - nw)) / (4.0 * half.x * half.y),
            dyy: ((s + n) - 2.0 * c) / (half.y * half.y),
        };
        let inverse = DMat2::from_cols(map.dx, map.dy).inverse();
        let view = Self { sides, centre, map, inverse };
        let off_px = |(corner, seen): (DVec2, DVec2)| (inverse * (view.see(centre + corner * half) - seen)).length();
        let strays = || square(1.0).into_iter().zip([nw, ne, se, sw]).map(off_px);
        // NaN must not pass.
        strays().all(|off_px| off_px <= stray_px(plan)).then_some(view)
    }

    /// What a place about the pixel's centre sees, in squares.
    fn see(&self, place: DVec2) -> DVec2 {
        let (p, map) = (place - self.centre, &self.map);
        let bend = 0.5 * (map.dxx * (p.x * p.x) + map.dyy * (p.y * p.y)) + map.dxy * (p.x * p.y);
        map.seen + map.dx * p.x + map.dy * p.y + bend
    }

    /// The light over a piece, times its area: of one radiance, or by the polygon between the places that its corners see, halved until
    /// the map is straight enough in it.
    fn light(&self, plan: &Plan, piece: &Convex, halvings: u32, work: &mut Work) -> f64 {
        // Bound how far the map strays from a linear one.
        let [low, high] = piece.bounds();
        let (middle, size) = (0.5 * (low + high), high - low);
        let map = &self.map;
        let stray = 0.125
            * (map.dxx.abs() * (size.x * size.x)
                + map.dxy.abs() * (2.0 * size.x * size.y)
                + map.dyy.abs() * (size.y * size.y));

        // Find whether it sees one radiance.
        let face = plan.face();
        let mut seen = [DVec2::ZERO; 16];
        let vertices = piece.vertices();
        seen.iter_mut().zip(vertices).for_each(|(to, from)| *to = self.see(*from));
        let seen = &seen[..vertices.len()];
        let (least, most) = seen.iter().fold((seen[0], seen[0]), |(l, h), p| (l.min(*p), h.max(*p)));
        if let Some(value) = face.constant(0.5 * (least + most), 0.5 * (most - least) + stray) {
            return value * piece.area();
        }

        // Take the mean over the polygon, or go on with halves.
        let off_px = STRAYS * in_px(self.inverse.inverse(), stray);
        let straight = off_px <= plan.system.accuracy().bend_px;
        if (straight || halvings == 0) && seen.len() <= MOST_CORNERS {
            work.bend_px = work.bend_px.max(off_px);
            let mean = face.mean_over(seen);
            let mean = mean.unwrap_or_else(|| mean_of_points(&|c| face.radiance(c), seen, vertices));
            return mean * piece.area();
        }
        let across = if size.x >= size.y { DVec2::X } else { DVec2::Y };
        let halves = [across, -across].map(|way| piece.cut(|p| (p - middle).dot(way)));
        let halvings = halvings.saturating_sub(1);
        halves.iter().filter(|half| half.area() > 0.0).map(|half| self.light(plan, half, halvings, work)).sum()
    }
}

/// A linear function of the place.
#[derive(Debug, Clone, Copy)]
struct Linear {
    /// At the pixel's centre.
    value: f64,
    slope: DVec2,
}

impl Linear {
    #[inline(always)]
    fn at(&self, place: DVec2) -> f64 {
        self.value + self.slope.dot(place)
    }
}

/// Linear functions through values at the eight places around a part of a pixel; `None` where the zero of one would stray by more than
/// `stray_px` from theirs.
struct Sides<'a> {
    within: &'a EightWithin,
    area: [DVec2; 2],
    stray_px: f64,
}

impl Kernel for Sides<'_> {
    type Out = Option<[Linear; 4]>;

    #[inline(always)]
    fn run(self) -> Self::Out {
        let Self { within, area: [centre, half], stray_px } = self;
        let places = [0, 1].map(|axis| Lanes::of(|k| centre[axis] + half[axis] * AROUND[k][axis]));
        let mut sides = [Linear { value: 0.0, slope: DVec2::ZERO }; 4];
        for (side, values) in sides.iter_mut().zip(within) {
            let [_, n, _, w, e, _, s, _] = values.0;
            let slope = DVec2::new(e - w, s - n) / (2.0 * half);
            *side = Linear { value: in_the_middle(values.0) - slope.dot(centre), slope };
            let [x, y] = [0, 1].map(|axis| Lanes::splat(slope[axis]) * places[axis]);
            let stray = (Lanes::splat(side.value) + (x + y) - *values).abs().0.into_iter().fold(0.0, f64::max);
            // Where all is well within, or well beyond it, nothing is cut.
            let off = |sign: f64| values.0.iter().all(|value| sign * value > 2.0 * stray);
            if !(stray <= stray_px * slope.length() || off(1.0) || off(-1.0)) {
                return None;
            }
        }
        Some(sides)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a polynomial of third order it is the value there.
    #[test]
    fn the_middle_follows_from_what_is_around_it() {
        let cubic = |[x, y]: [f64; 2]| {
            0.3 + 2.0 * x - y + 0.7 * x * x + 1.1 * x * y - 0.4 * y * y + x * x * x - 3.0 * x * x * y + 0.5 * x * y * y
        };
        assert!((in_the_middle(AROUND.map(cubic)) - 0.3).abs() < 1e-15);
    }
}
