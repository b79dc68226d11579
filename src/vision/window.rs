//! The window of a corner: the pixels that it is fitted to, sorted by the edges that they are near. Pixels far from
//! both edges depend only on the light and enter as twelve sums; pixels near one edge only make two strips; the few
//! near both are listed one by one.

use super::pixel_sums::{PixelSums, WindowFrame};
use super::strip::EdgeStrip;
use crate::num::simd::{Kernel, widest};
use crate::raster::Raster;
use glam::DVec2;
use std::ops::Range;

/// Pixels that room is made for before they are counted, at most, of each kind.
const MOST_ROOM: f64 = 4096.0;

/// One listed pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ListedPixel {
    /// Centre of the pixel from the window's centre, in px.
    pub(super) x: f64,
    /// Centre of the pixel from the window's centre, in px.
    pub(super) y: f64,
    /// Its radiance.
    pub(super) value: f64,
    /// The root of its weight.
    pub(super) root_weight: f64,
}

/// A corner's pixels.
#[derive(Debug, Clone, Default)]
pub(super) struct Window {
    /// Pixels near both edges.
    pub(super) listed: Vec<ListedPixel>,
    /// Pixels near the first edge only, and near the second only.
    pub(super) strips: [EdgeStrip; 2],
    /// The others, where the product of the two signed distances is positive, and where it is negative.
    pub(super) flat: [PixelSums; 2],
    /// The sum of the weights.
    pub(super) weight: f64,
    /// That sum over what an uncut window has.
    pub(super) visible: f64,
}

/// The points where |slope . r| < limit.
#[derive(Debug, Clone, Copy)]
struct EdgeBand {
    /// Its middle moves by this when y grows by 1.
    tilt: f64,
    /// Half its width along x; infinite where it is parallel to x.
    half_width: f64,
    /// Half its width along y, where it is parallel to x.
    half_height: f64,
}

impl EdgeBand {
    fn new(slope: DVec2, limit: f64) -> Self {
        if limit <= 0.0 {
            Self { tilt: 0.0, half_width: 0.0, half_height: 0.0 }
        } else if slope.x.abs() < 1e-9 {
            Self { tilt: 0.0, half_width: f64::INFINITY, half_height: limit / slope.y.abs() }
        } else {
            Self { tilt: -slope.y / slope.x, half_width: limit / slope.x.abs(), half_height: f64::INFINITY }
        }
    }

    /// The x of the band at `y`, low and high.
    #[inline(always)]
    fn at(&self, y: f64) -> [f64; 2] {
        if y.abs() >= self.half_height {
            return [0.0, 0.0];
        }
        let middle = self.tilt * y;
        [middle - self.half_width, middle + self.half_width]
    }
}

/// The borders of a window in the picture: its four sides, and the bands of its two edges.
struct WindowBorders<'a> {
    frame: &'a WindowFrame,
    /// Rows of the inverse of the steps: local coordinates are linear in x and y.
    rows: [DVec2; 2],
    /// Px per local unit, straight across the window's sides.
    px_per_unit: [f64; 2],
    /// Pixels beyond `outer` lie outside the window, those within `inner` wholly inside.
    outer: [EdgeBand; 2],
    inner: [EdgeBand; 2],
    /// Pixels near an edge.
    edges: [EdgeBand; 2],
}

impl<'a> WindowBorders<'a> {
    fn new(frame: &'a WindowFrame) -> Self {
        let inverse = frame.steps.inverse();
        let rows = [inverse.row(0), inverse.row(1)];
        let rates = rows.map(|r| r.length());
        let px_per_unit = rates.map(f64::recip);
        let sides = |margin: f64| [0, 1].map(|k| EdgeBand::new(rows[k], frame.half + margin * rates[k]));
        let (outer, inner) = (sides(0.5), sides(-0.5));
        let edges = [0, 1].map(|k| EdgeBand::new(frame.normals[k], frame.bands_px[k]));
        Self { frame, rows, px_per_unit, outer, inner, edges }
    }

    /// The pixels of a row of `width` whose centres lie in an open interval of x. (A cast cuts off what is below 0 and
    /// behind the point.)
    #[inline(always)]
    fn pixels(&self, width: usize, [low, high]: [f64; 2]) -> Range<usize> {
        let first = ((low + self.frame.centre.x + 0.5) as usize).min(width);
        let end = high + self.frame.centre.x - 0.5;
        let whole = end as usize;
        let end = whole.saturating_add(usize::from((whole as f64) < end));
        first..end.min(width).max(first)
    }

    /// The pixels of a row of `width` at `y` that lie in both bands.
    #[inline(always)]
    fn in_both(&self, width: usize, [a, b]: &[EdgeBand; 2], y: f64) -> Range<usize> {
        let (a, b) = (a.at(y), b.at(y));
        self.pixels(width, [a[0].max(b[0]), a[1].min(b[1])])
    }

    /// The weight of a pixel that a side of the window cuts.
    #[inline(always)]
    fn weight(&self, x: f64, y: f64) -> f64 {
        let depth = |k: usize| (self.frame.half - self.rows[k].dot(DVec2::new(x, y)).abs()) * self.px_per_unit[k] + 0.5;
        depth(0).min(depth(1)).clamp(0.0, 1.0)
    }
}

/// Gathers the window's pixels; those outside the picture and those that `valid` excludes do not count.
pub(super) fn gather(image: &Raster<f32>, valid: Option<&Raster<bool>>, frame: &WindowFrame) -> Window {
    widest(Gathering { image, valid, frame })
}

/// [`gather`]
struct Gathering<'a> {
    image: &'a Raster<f32>,
    valid: Option<&'a Raster<bool>>,
    frame: &'a WindowFrame,
}

impl Kernel for Gathering<'_> {
    type Out = Window;

    #[inline(always)]
    fn run(self) -> Window {
        // Gather row by row.
        let Self { image, valid, frame } = self;
        let mut window = Window::with_room(frame);
        let borders = WindowBorders::new(frame);
        let reach = frame.half * (frame.steps.x_axis.abs() + frame.steps.y_axis.abs()) + 2.0;
        let clamp = |v: f64, most: usize| v.clamp(0.0, most as f64) as usize;
        let first_row = clamp((frame.centre.y - reach.y).floor(), image.height());
        let last_row = clamp((frame.centre.y + reach.y).ceil(), image.height());
        for j in first_row..last_row {
            window.add_image_row(image, valid, &borders, j);
        }

        // Sum up the strips, and compare the weight with that of an uncut window.
        for strip in &mut window.strips {
            strip.finish();
        }
        let area = 4.0 * frame.half * frame.half * frame.steps.determinant().abs();
        window.visible = window.weight / area;
        window
    }
}

impl Window {
    /// No pixels, and room for about those of an uncut window.
    fn with_room(frame: &WindowFrame) -> Self {
        let WindowFrame { steps, bands_px, half, .. } = *frame;
        let side = 2.0 * half * steps.x_axis.length().max(steps.y_axis.length());
        let [first, second] = bands_px.map(|band| (2.0 * band).min(side));
        let room = |pixels: f64| pixels.min(MOST_ROOM) as usize;
        let strips = [first, second].map(|wide| EdgeStrip::with_room(room(wide * side)));
        Self { listed: Vec::with_capacity(room(first * second)), strips, ..Self::default() }
    }

    /// Without the pixels that are near no edge.
    pub(super) fn near_edges(self) -> Self {
        let flat: f64 = self.flat.iter().map(|sums| sums.moments[0]).sum();
        Self { flat: Default::default(), weight: self.weight - flat, ..self }
    }

    /// Adds the pixels of row `j` of the picture.
    #[inline(always)]
    fn add_image_row(&mut self, image: &Raster<f32>, valid: Option<&Raster<bool>>, borders: &WindowBorders, j: usize) {
        let frame = borders.frame;
        let y = j as f64 + 0.5 - frame.centre.y;

        // Find the runs of pixels in the window, wholly inside it, and near each edge.
        let outer = borders.in_both(image.width(), &borders.outer, y);
        if outer.is_empty() {
            return;
        }
        let inner = borders.in_both(image.width(), &borders.inner, y);
        let edges = borders.edges.map(|band| borders.pixels(image.width(), band.at(y)));

        // Cut the row where one of them begins or ends.
        let mut cuts = [
            outer.start,
            inner.start,
            inner.end,
            edges[0].start,
            edges[0].end,
            edges[1].start,
            edges[1].end,
            outer.end,
        ]
        .map(|i| i.clamp(outer.start, outer.end));
        sort_inner(&mut cuts);

        // Add the parts: whole ones at once, cut or masked ones pixel by pixel.
        for part in cuts.windows(2).map(|w| w[0]..w[1]).filter(|r| !r.is_empty()) {
            let i = part.start;
            let x = i as f64 + 0.5 - frame.centre.x;
            let side = frame.normals.map(|n| n.dot(DVec2::new(x, y)) > 0.0);
            let near = [0, 1].map(|k| edges[k].contains(&i));
            let whole = inner.contains(&i);
            let row = &image.row(j)[part];
            if whole && valid.is_none() {
                self.weight += row.len() as f64;
                self.add_run(near, side, row, [x, y]);
                continue;
            }
            for (k, &value) in row.iter().enumerate() {
                let x = x + k as f64;
                let counts = valid.is_none_or(|v| v.get(i + k, j));
                let weight = match counts {
                    false => 0.0,
                    true if whole => 1.0,
                    true => borders.weight(x, y),
                };
                if weight > 0.0 {
                    self.weight += weight;
                    self.add(near, side, [x, y, f64::from(value)], weight);
                }
            }
        }
    }

    /// Adds a pixel that is near some of the edges, on one side of each.
    #[inline(always)]
    fn add(&mut self, near: [bool; 2], side: [bool; 2], [x, y, value]: [f64; 3], weight: f64) {
        match near {
            [true, true] => self.listed.push(ListedPixel { x, y, value, root_weight: weight.sqrt() }),
            [true, false] => self.strips[0].push([x, y, value, weight, sign(side[1])]),
            [false, true] => self.strips[1].push([x, y, value, weight, sign(side[0])]),
            [false, false] => self.flat[usize::from(side[0] != side[1])].add(x, y, value, weight),
        }
    }

    /// Adds pixels of a row, all of weight 1, the first at `x`, `y`.
    #[inline(always)]
    fn add_run(&mut self, near: [bool; 2], side: [bool; 2], row: &[f32], [x, y]: [f64; 2]) {
        match near {
            [true, true] => {
                let listed =
                    |(k, &v): (usize, &f32)| ListedPixel { x: x + k as f64, y, value: v.into(), root_weight: 1.0 };
                self.listed.extend(row.iter().enumerate().map(listed));
            }
            [true, false] => self.strips[0].push_run(row, x, y, sign(side[1])),
            [false, true] => self.strips[1].push_run(row, x, y, sign(side[0])),
            [false, false] => self.flat[usize::from(side[0] != side[1])].add_row(row, x, y),
        }
    }
}

/// Sorts the six between the first and the last, which are so already and come in sorted pairs: by a network, since a branch at each
/// would be guessed wrong.
#[inline(always)]
fn sort_inner(cuts: &mut [usize; 8]) {
    const NETWORK: [[usize; 2]; 9] = [[1, 3], [2, 4], [3, 5], [4, 6], [1, 3], [2, 4], [2, 3], [4, 5], [3, 4]];
    for [a, b] in NETWORK {
        (cuts[a], cuts[b]) = (cuts[a].min(cuts[b]), cuts[a].max(cuts[b]));
    }
}

fn sign(positive: bool) -> f64 {
    if positive { 1.0 } else { -1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat2;

    fn frame(centre: DVec2) -> WindowFrame {
        let (sin, cos) = libm::sincos(0.3);
        WindowFrame {
            centre,
            steps: DMat2::from_cols(DVec2::new(cos, sin) * 22.0, DVec2::new(-sin, cos) * 20.0),
            normals: [DVec2::new(sin, -cos), DVec2::new(cos, sin)],
            bands_px: [1.5, 2.5],
            half: 0.45,
        }
    }

    fn picture() -> Raster<f32> {
        Raster::from_data(50, 60, (0..3000).map(|k| ((k * 7919) % 1009) as f32 / 1009.0).collect())
    }

    /// Every pixel sorted singly: listed pixels, those near one edge, and the sums, in the order of [`Window`].
    fn plain(image: &Raster<f32>, frame: &WindowFrame) -> (Vec<ListedPixel>, [Vec<[f64; 5]>; 2], [PixelSums; 2]) {
        let inverse = frame.steps.inverse();
        let (mut listed, mut strips, mut flat) = (Vec::new(), [Vec::new(), Vec::new()], [PixelSums::default(); 2]);
        for (j, i) in (0..image.height()).flat_map(|j| (0..image.width()).map(move |i| (j, i))) {
            let r = DVec2::new(i as f64 + 0.5, j as f64 + 0.5) - frame.centre;
            let local = inverse * r;
            let rates = [inverse.row(0).length(), inverse.row(1).length()];
            let depth = [0, 1].map(|k| (frame.half - local[k].abs()) / rates[k] + 0.5);
            let weight = depth[0].min(depth[1]).clamp(0.0, 1.0);
            let d = frame.normals.map(|n| n.dot(r));
            let value = f64::from(image.get(i, j));
            let near = [0, 1].map(|k| d[k].abs() < frame.bands_px[k]);
            match near {
                _ if weight <= 0.0 => {}
                [true, true] => listed.push(ListedPixel { x: r.x, y: r.y, value, root_weight: weight.sqrt() }),
                [true, false] => strips[0].push([r.x, r.y, value, weight, d[1].signum()]),
                [false, true] => strips[1].push([r.x, r.y, value, weight, d[0].signum()]),
                [false, false] => flat[usize::from((d[0] > 0.0) != (d[1] > 0.0))].add(r.x, r.y, value, weight),
            }
        }
        (listed, strips, flat)
    }

    #[test]
    fn runs_gather_what_single_pixels_do() {
        let image = picture();
        // Inside, and cut by two borders.
        for centre in [DVec2::new(25.3, 28.7), DVec2::new(4.1, 57.2)] {
            let frame = frame(centre);
            let window = gather(&image, None, &frame);
            let (listed, strips, flat) = plain(&image, &frame);
            assert_eq!(window.listed.len(), listed.len());
            for (a, b) in window.listed.iter().zip(&listed) {
                assert!((a.x - b.x).abs() + (a.y - b.y).abs() + (a.root_weight - b.root_weight).abs() < 1e-9);
            }
            for (a, b) in window.strips.iter().zip(&strips) {
                assert_eq!(a.pixels().count(), b.len());
                let apart = |k: usize, p: [f64; 5]| (0..5).map(|i| (p[i] - b[k][i]).abs()).fold(0.0, f64::max);
                assert!(a.pixels().enumerate().all(|(k, p)| apart(k, p) < 1e-9));
            }
            for (a, b) in window.flat.iter().zip(&flat) {
                let flatten =
                    |s: &PixelSums| s.moments.iter().chain(&s.light).chain([&s.square]).copied().collect::<Vec<_>>();
                for (a, b) in flatten(a).iter().zip(flatten(b)) {
                    assert!((a - b).abs() < 1e-8 * (1.0 + b.abs()), "{a} {b}");
                }
            }
            let masked = gather(&image, Some(&image.map(|_| true)), &frame);
            assert!((masked.weight - window.weight).abs() < 1e-9);
        }
    }

    #[test]
    fn the_weight_is_the_area_of_the_window_wherever_it_lies() {
        for k in 0..20 {
            let centre = DVec2::new(25.0 + 0.05 * f64::from(k), 28.0 + 0.031 * f64::from(k));
            // The one-pixel ramp integrates a straight side to a few parts in a thousand.
            assert!((gather(&picture(), None, &frame(centre)).visible - 1.0).abs() < 0.01);
        }
    }
}
