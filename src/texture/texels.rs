//! A picture on a plane, and its exact integral over a convex polygon.
//!
//! By Green's theorem the integral of f(u, v) over a polygon is that of F(u, v) dv along its outline, with F the integral of f
//! along u: sums along the rows, kept once. An edge is walked from line to line of the grid of texels; between two of them F is
//! a polynomial, of degree 1 along the edge where texels are of one value each, and 3 where values are interpolated, so that
//! the midpoint rule and Simpson's are exact. No texel within the polygon is looked at, however many there are.

use crate::raster::Raster;
use glam::DVec2;

/// The most texels of a picture on a plane: 384 MiB with the sums of its rows.
pub const MOST_TEXELS: usize = 1 << 25;

/// What lies between the middles of texels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TexelFilter {
    /// Each texel is a rectangle of one value.
    Nearest,
    /// Values are bilinear between the middles of texels, and go on evenly beyond the outermost.
    Linear,
}

/// A picture whose texel (i, j) covers `[i, i + 1) x [j, j + 1)`.
#[derive(Debug, Clone, PartialEq)]
pub struct Texels {
    picture: Raster<f32>,
    filter: TexelFilter,
    /// Integrals along each row, from its start to each line of the grid.
    sums: Raster<f64>,
}

impl Texels {
    /// The picture with the sums of its rows.
    pub fn new(picture: Raster<f32>, filter: TexelFilter) -> Self {
        let (width, height) = (picture.width(), picture.height());
        let value = |i: usize, j: usize| f64::from(picture.get(i, j));
        // The cells between the lines of the grid: texels, or the squares between their middles.
        let cells = match filter {
            TexelFilter::Nearest => width,
            TexelFilter::Linear => width + 1,
        };
        let mean = |c: usize, j: usize| match filter {
            TexelFilter::Nearest => value(c, j),
            TexelFilter::Linear => 0.5 * (value(c.saturating_sub(1), j) + value(c.min(width - 1), j)),
        };
        let mut sums = Raster::filled(cells + 1, height, 0.0);
        for j in 0..height {
            let row = sums.row_mut(j);
            for c in 0..cells {
                row[c + 1] = row[c] + mean(c, j);
            }
        }
        Self { picture, filter, sums }
    }

    /// Columns and rows.
    pub fn size(&self) -> DVec2 {
        DVec2::new(self.picture.width() as f64, self.picture.height() as f64)
    }

    /// The value at a place, in texels from the upper left corner.
    pub fn at(&self, place: DVec2) -> f64 {
        let value = |i: usize, j: usize| {
            f64::from(self.picture.get(i.min(self.picture.width() - 1), j.min(self.picture.height() - 1)))
        };
        match self.filter {
            TexelFilter::Nearest => value(place.x.max(0.0) as usize, place.y.max(0.0) as usize),
            TexelFilter::Linear => {
                let on_grid = (place + 0.5).max(DVec2::ZERO).min(self.size());
                let (i, j) = (on_grid.x as usize, on_grid.y as usize);
                let share = on_grid - DVec2::new(i as f64, j as f64);
                let (left, up) = (i.saturating_sub(1), j.saturating_sub(1));
                let row = |j: usize| value(left, j) + (value(i, j) - value(left, j)) * share.x;
                row(up) + (row(j) - row(up)) * share.y
            }
        }
    }

    /// The integral over a polygon that lies on the picture, in texels from its upper left corner: of the other sign where the outline
    /// goes round the other way.
    #[inline]
    pub fn integral(&self, outline: &[DVec2]) -> f64 {
        let Some(&last) = outline.last() else { return 0.0 };
        let mut from = last;
        let edges = outline.iter().map(|&to| (std::mem::replace(&mut from, to), to));
        edges.map(|(from, to)| self.edge(from, to)).sum()
    }

    /// The integral of F dv along an edge.
    #[inline]
    fn edge(&self, a: DVec2, b: DVec2) -> f64 {
        // Turn the edge to rise in v, and skip a level one: it adds nothing.
        let (from, to, sign) = if a.y <= b.y { (a, b, 1.0) } else { (b, a, -1.0) };
        if from.y == to.y {
            return 0.0;
        }
        let shift = if self.filter == TexelFilter::Linear { 0.5 } else { 0.0 };
        let (from, to) = (from + shift, to + shift);
        let step = to - from;

        // Walk from line to line of the grid.
        let mut across = Lines::new(from.x, step.x);
        let mut along = Lines::new(from.y, step.y);
        let (mut sum, mut t, mut p) = (0.0, 0.0, from);
        while t < 1.0 {
            t = across.t.min(along.t).min(1.0).max(t);
            let q = if t < 1.0 { from + step * t } else { to };
            let middle = 0.5 * (p + q);
            sum += match self.filter {
                TexelFilter::Nearest => self.nearest(middle),
                TexelFilter::Linear => self.simpson([p, middle, q]),
            } * (q.y - p.y);
            p = q;
            across.pass(t);
            along.pass(t);
        }
        sign * sum
    }

    /// F at a place on a texel of one value.
    #[inline]
    fn nearest(&self, at: DVec2) -> f64 {
        let cell = |v: f64, count: usize| (v.max(0.0) as usize).min(count - 1);
        let (i, j) = (cell(at.x, self.picture.width()), cell(at.y, self.picture.height()));
        self.sums.get(i, j) + f64::from(self.picture.get(i, j)) * (at.x - i as f64)
    }

    /// The mean of F along a line within one cell of interpolated values, given its start, its middle and its end.
    #[inline]
    fn simpson(&self, [p, middle, q]: [DVec2; 3]) -> f64 {
        // Find the cell, and the values at its corners.
        let (width, height) = (self.picture.width(), self.picture.height());
        let (c, r) = ((middle.x.max(0.0) as usize).min(width), (middle.y.max(0.0) as usize).min(height));
        let (left, right) = (c.saturating_sub(1), c.min(width - 1));
        let rows = [r.saturating_sub(1), r.min(height - 1)];
        let corner = rows.map(|j| [left, right].map(|i| f64::from(self.picture.get(i, j))));
        let start = rows.map(|j| self.sums.get(c, j));

        // Weigh F at the three places.
        let f = |at: DVec2| {
            let (s, t) = (at.x - c as f64, at.y - r as f64);
            let row = |k: usize| start[k] + s * (corner[k][0] + 0.5 * s * (corner[k][1] - corner[k][0]));
            row(0) + t * (row(1) - row(0))
        };
        (f(p) + 4.0 * f(middle) + f(q)) / 6.0
    }
}

/// The lines at whole numbers that a path along one axis crosses, in order; it starts at no less than 0 but for rounding.
struct Lines {
    from: f64,
    /// One over the length of the path.
    inverse: f64,
    /// The next line, the way to the one after it, and where the path meets it, as a share of it.
    next: f64,
    way: f64,
    t: f64,
}

impl Lines {
    #[inline]
    fn new(from: f64, step: f64) -> Self {
        // A cast cuts off what is behind the point.
        let whole = f64::from(from as u32);
        let next = if step > 0.0 || from <= whole { whole + step.signum() } else { whole };
        let inverse = 1.0 / step;
        let t = if step == 0.0 { f64::INFINITY } else { (next - from) * inverse };
        Self { from, inverse, next, way: step.signum(), t }
    }

    /// Goes on to the line behind `t`.
    #[inline(always)]
    fn pass(&mut self, t: f64) {
        if self.t <= t {
            self.next += self.way;
            self.t = (self.next - self.from) * self.inverse;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::Convex;

    /// Values that look random, the same on every run.
    fn picture(width: usize, height: usize) -> Raster<f32> {
        let value = |k: usize| (libm::sin(12.9898 * k as f64) * 43758.5453).fract().abs() as f32;
        Raster::from_data(width, height, (0..width * height).map(value).collect())
    }

    /// The mean over a parallelogram by 1024 x 1024 places of it.
    fn by_places(texels: &Texels, from: DVec2, right: DVec2, down: DVec2) -> f64 {
        const N: usize = 1024;
        let share = |k: usize| (k as f64 + 0.5) / N as f64;
        let places = (0..N * N).map(|k| texels.at(from + right * share(k % N) + down * share(k / N)));
        places.sum::<f64>() / (N * N) as f64
    }

    /// Parallelograms from a hundredth of a texel to the whole picture, at places that are the same on every run. Places at the
    /// middles of n x n parts of a pixel miss a straight edge by 1/2n of its length at most, and a smooth function by far less.
    #[test]
    fn the_mean_over_a_parallelogram_is_that_of_its_places() {
        for (filter, most) in [(TexelFilter::Nearest, 2e-3), (TexelFilter::Linear, 1e-5)] {
            let texels = Texels::new(picture(37, 23), filter);
            for k in 0..40 {
                let wave = |n: usize| libm::sin((k * n + n) as f64);
                let size = [0.01, 0.3, 1.0, 4.0, 9.0][k % 5];
                let (right, down) = (size * DVec2::new(wave(3), wave(5)), size * DVec2::new(wave(7), wave(11)));
                let middle = 0.5 * texels.size() + 4.0 * DVec2::new(2.0 * wave(13), 0.7 * wave(17));
                let from = (middle - 0.5 * (right + down)).clamp(DVec2::ZERO, texels.size());
                let outline = [from, from + right, from + right + down, from + down];
                let polygon = Convex::new(&outline).within(DVec2::ZERO, texels.size());
                if (polygon.area() - right.perp_dot(down).abs()).abs() > 1e-9 || polygon.area() < 1e-3 * size * size {
                    continue;
                }
                let mean = texels.integral(polygon.vertices()) / polygon.area();
                let expected = by_places(&texels, from, right, down);
                assert!((mean - expected).abs() < most, "{filter:?} {k}: {mean} {expected}");
            }
        }
    }

    /// Whole texels, and the whole picture, have the means of their values; bilinear ones have as well, but for the border.
    #[test]
    fn whole_texels_have_their_own_mean() {
        let own = picture(16, 9);
        let rect = |low: DVec2, high: DVec2| [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
        let all: f64 = own.data().iter().map(|v| f64::from(*v)).sum();
        let texels = Texels::new(own.clone(), TexelFilter::Nearest);
        assert!((texels.integral(&rect(DVec2::ZERO, texels.size())) - all).abs() < 1e-12);
        for (i, j) in [(0, 0), (7, 3), (15, 8)] {
            let low = DVec2::new(i as f64, j as f64);
            assert!((texels.integral(&rect(low, low + 1.0)) - f64::from(own.get(i, j))).abs() < 1e-13);
        }
        // Between the middles of four texels the mean is that of the four.
        let linear = Texels::new(own.clone(), TexelFilter::Linear);
        let four = [(4, 2), (5, 2), (4, 3), (5, 3)].map(|(i, j)| f64::from(own.get(i, j)));
        let between = linear.integral(&rect(DVec2::new(4.5, 2.5), DVec2::new(5.5, 3.5)));
        assert!((between - 0.25 * four.iter().sum::<f64>()).abs() < 1e-13);
        // Half a texel at the border is even outward.
        let corner = linear.integral(&rect(DVec2::ZERO, DVec2::splat(0.5)));
        assert!((corner - 0.25 * f64::from(own.get(0, 0))).abs() < 1e-14);
    }

    /// 2^14 texels in a row, and a polygon of a hundredth of one at its end.
    #[test]
    fn small_polygons_at_the_end_of_long_rows_keep_their_digits() {
        let texels = Texels::new(picture(1 << 14, 2), TexelFilter::Nearest);
        let low = DVec2::new(16383.4, 1.5);
        let outline = [low, low + DVec2::new(0.01, 0.0), low + 0.01, low + DVec2::new(0.0, 0.01)];
        let polygon = Convex::new(&outline);
        let mean = texels.integral(polygon.vertices()) / polygon.area();
        assert!((mean - texels.at(low)).abs() < 1e-8, "{mean} {}", texels.at(low));
    }
}
