//! Edge strips: the pixels near one edge only, and the sums over them that the corner fit needs.
//!
//! There the pattern is p = sign E(d), with the sign of the other edge, and the derivatives of the model by corner and
//! direction are combinations of two columns: T = A sign E'(d), and T t with t the way along the edge. So the normal
//! equations of a strip follow from some thirty sums, taken over many pixels at a time.

use super::column::{CHUNK, Column};
use super::corner_model::Model;
#[cfg(test)]
use super::edge_spread::{Edge, EdgeShape};
use super::pixel_sums::PixelSums;
use super::profile::Profile;
use crate::num::simd::{Kernel, widest};
use glam::DVec2;

/// Lanes of a sum.
const LANES: usize = 4;

const ONE: Column = [1.0; CHUNK];

/// Pixels near one edge, in chunks.
#[derive(Debug, Clone, Default)]
pub(super) struct EdgeStrip {
    /// x and y of the centres from the window's centre in px, value, weight, and on which side of the other edge: 1 or -1.
    /// The last chunk ends with weights of 0.
    chunks: Vec<[Column; 5]>,
    /// Pixels in the last chunk.
    last: usize,
    /// What does not depend on the model.
    pub(super) sums: PixelSums,
}

impl EdgeStrip {
    /// No pixels, and room for so many.
    pub(super) fn with_room(pixels: usize) -> Self {
        Self { chunks: Vec::with_capacity(pixels.div_ceil(CHUNK)), ..Self::default() }
    }

    /// The last chunk, with room for a pixel.
    #[inline(always)]
    fn room(&mut self) -> &mut [Column; 5] {
        if self.last == CHUNK || self.chunks.is_empty() {
            self.chunks.push([[0.0; CHUNK]; 5]);
            self.last = 0;
        }
        self.chunks.last_mut().expect("one was pushed where there was none")
    }

    /// Adds a pixel.
    #[inline(always)]
    pub(super) fn push(&mut self, pixel: [f64; 5]) {
        let place = if self.last == CHUNK { 0 } else { self.last };
        for (column, value) in self.room().iter_mut().zip(pixel) {
            column[place] = value;
        }
        self.last += 1;
    }

    /// Adds pixels of a row, all of weight 1, the first at `x`, `y`.
    #[inline(always)]
    pub(super) fn push_run(&mut self, row: &[f32], x: f64, y: f64, sign: f64) {
        let mut done = 0;
        while done < row.len() {
            let first = if self.last == CHUNK { 0 } else { self.last };
            let count = (row.len() - done).min(CHUNK - first);
            let places = first..first + count;
            let [xs, ys, values, weights, signs] = self.room();
            for (k, x_place) in xs[places.clone()].iter_mut().enumerate() {
                *x_place = x + (done + k) as f64;
            }
            ys[places.clone()].fill(y);
            for (place, &value) in values[places.clone()].iter_mut().zip(&row[done..]) {
                *place = f64::from(value);
            }
            weights[places.clone()].fill(1.0);
            signs[places].fill(sign);
            self.last = first + count;
            done += count;
        }
    }

    /// Sums up what does not depend on the model, when all pixels are there.
    #[inline(always)]
    pub(super) fn finish(&mut self) {
        let (mut moments, mut light, mut square) = ([NONE; 6], [NONE; 3], [NONE; 1]);
        for [x, y, value, weight, _] in &self.chunks {
            let (wx, wy, lit) = (product(weight, x), product(weight, y), product(weight, value));
            add(&mut moments[..3], weight, [&ONE, x, y]);
            add(&mut moments[3..5], &wx, [x, y]);
            add(&mut moments[5..], &wy, [y]);
            add(&mut light, &lit, [&ONE, x, y]);
            add(&mut square, &lit, [value]);
        }
        self.sums = PixelSums { moments: moments.map(total), light: light.map(total), square: total(square[0]) };
    }

    /// Its pixels, some at a time; of those beyond the last the weights are 0.
    pub(super) fn chunks(&self) -> &[[Column; 5]] {
        &self.chunks
    }

    /// x, y, value, weight and sign of each pixel.
    #[cfg(test)]
    pub(super) fn pixels(&self) -> impl Iterator<Item = [f64; 5]> + '_ {
        let all = self.chunks.iter().flat_map(|chunk| (0..CHUNK).map(|k| [0, 1, 2, 3, 4].map(|i| chunk[i][k])));
        all.take((self.chunks.len() * CHUNK + self.last).saturating_sub(CHUNK))
    }
}

/// One edge of a model, as a strip sees it.
#[derive(Debug)]
pub(super) struct EdgeModel<'a> {
    pub(super) profile: &'a Profile,
    /// Unit normal and unit tangent.
    pub(super) normal: DVec2,
    pub(super) tangent: DVec2,
    /// In 1/px.
    pub(super) curvature: f64,
    /// Added to every distance, in px.
    pub(super) shift_px: f64,
    /// Added to it on the positive side of the other edge, and taken away on the negative one, in px.
    pub(super) step_px: f64,
    /// By what share of it this grows with each px along the edge.
    pub(super) step_rate: f64,
    /// On which side of it the model is bright where the other edge's distance is positive, 1 or -1, and 0 where the profile is
    /// alike to both sides.
    pub(super) bright: f64,
    /// Whether the blur is solved for.
    pub(super) free_blur: bool,
}

impl EdgeModel<'_> {
    /// The response at a distance, on a side of the other edge: 1 or -1.
    #[cfg(test)]
    pub(super) fn response(&self, distance: f64, sign: f64) -> Edge {
        if self.bright == 0.0 { self.profile.at(distance) } else { self.profile.towards(distance, self.bright * sign) }
    }

    /// The responses at many distances on their sides of the other edge, as of [`Self::response`]: E, its slopes and its bends.
    #[inline(always)]
    pub(super) fn responses(&self, distances: &Column, signs: &Column) -> [Column; 3] {
        if self.bright == 0.0 {
            return self.profile.at_all(distances);
        }
        let (mut bright, mut towards) = ([0.0; CHUNK], [0.0; CHUNK]);
        for i in 0..CHUNK {
            bright[i] = self.bright * signs[i];
            towards[i] = bright[i] * distances[i];
        }
        let [values, slopes, bends] = self.profile.at_all(&towards);
        [product(&bright, &values), slopes, product(&bright, &bends)]
    }

    /// The ways along the edge of some pixels from the corner, and their signed distances from the edge on their sides of the other.
    #[inline(always)]
    pub(super) fn along_and_distances(&self, [x, y, sign]: [&Column; 3], corner: DVec2) -> [Column; 2] {
        let (mut along, mut distance) = ([0.0; CHUNK], [0.0; CHUNK]);
        for i in 0..CHUNK {
            let (dx, dy) = (x[i] - corner.x, y[i] - corner.y);
            let t = self.tangent.x * dx + self.tangent.y * dy;
            along[i] = t;
            let shift = self.shift_px + self.step_px * sign[i] * (1.0 + self.step_rate * t);
            distance[i] = self.normal.x * dx + self.normal.y * dy + 0.5 * self.curvature * t * t + shift;
        }
        [along, distance]
    }
}

/// Of some pixels near one edge only: their distances from it, A on their side of the other edge, and what a model leaves, picture less
/// model.
#[inline(always)]
pub(super) fn left_of([x, y, value, _, sign]: &[Column; 5], model: &Model, edge: &EdgeModel<'_>) -> [Column; 3] {
    let [_, distance] = edge.along_and_distances([x, y, sign], model.corner);
    let [response, _, _] = edge.responses(&distance, sign);
    let [m0, mx, my, a0, ax, ay] = model.light;
    let (mut contrast, mut left) = ([0.0; CHUNK], [0.0; CHUNK]);
    for i in 0..CHUNK {
        contrast[i] = (a0 + ax * x[i] + ay * y[i]) * sign[i];
        left[i] = value[i] - (m0 + mx * x[i] + my * y[i]) - contrast[i] * response[i];
    }
    [distance, contrast, left]
}

/// Weighted sums over a strip: E with its sign; T = A sign E', T t, and A sign E'' / 2 for the square of the blur; g = 1,
/// x, y.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct StripSums {
    /// E (1, x, y, x^2, xy, y^2)
    pub(super) edge: [f64; 6],
    /// E^2 (1, x, y, x^2, xy, y^2)
    pub(super) edge_squared: [f64; 6],
    /// E I (1, x, y)
    pub(super) edge_light: [f64; 3],
    /// T_k (g, E g, I)
    pub(super) turns: [[f64; 7]; 3],
    /// T_0 T_0, T_0 T_1, T_1 T_1, then T_2 with T_0, T_1, T_2
    pub(super) squares: [f64; 6],
}

/// The sums over a strip at a model.
pub(super) fn strip_sums(strip: &EdgeStrip, model: &Model, edge: &EdgeModel<'_>) -> StripSums {
    widest(Summation { strip, model, edge })
}

/// [`strip_sums`]
struct Summation<'a> {
    strip: &'a EdgeStrip,
    model: &'a Model,
    edge: &'a EdgeModel<'a>,
}

impl Kernel for Summation<'_> {
    type Out = StripSums;

    #[inline(always)]
    fn run(self) -> StripSums {
        let mut sums = LaneSums::default();
        for pixels in &self.strip.chunks {
            sums.add_chunk(pixels, self.model, self.edge);
        }
        StripSums {
            edge: sums.edge.map(total),
            edge_squared: sums.edge_squared.map(total),
            edge_light: sums.edge_light.map(total),
            turns: sums.turns.map(|turn| turn.map(total)),
            squares: sums.squares.map(total),
        }
    }
}

/// A sum, in lanes.
type LaneSum = [f64; LANES];

const NONE: LaneSum = [0.0; LANES];

#[inline(always)]
fn total(sum: LaneSum) -> f64 {
    (sum[0] + sum[2]) + (sum[1] + sum[3])
}

/// [`StripSums`] in lanes.
#[derive(Default)]
struct LaneSums {
    edge: [LaneSum; 6],
    edge_squared: [LaneSum; 6],
    edge_light: [LaneSum; 3],
    turns: [[LaneSum; 7]; 3],
    squares: [LaneSum; 6],
}

#[inline(always)]
pub(super) fn product(a: &Column, b: &Column) -> Column {
    let mut out = [0.0; CHUNK];
    for i in 0..CHUNK {
        out[i] = a[i] * b[i];
    }
    out
}

/// Adds to each sum the products of `a` with each of `by`.
#[inline(always)]
fn add<const N: usize>(sums: &mut [LaneSum], a: &Column, by: [&Column; N]) {
    let mut own: [LaneSum; N] = std::array::from_fn(|k| sums[k]);
    for i in (0..CHUNK).step_by(LANES) {
        for k in 0..N {
            for lane in 0..LANES {
                own[k][lane] += a[i + lane] * by[k][i + lane];
            }
        }
    }
    sums[..N].copy_from_slice(&own);
}

impl LaneSums {
    #[inline(always)]
    fn add_chunk(&mut self, [x, y, value, weight, sign]: &[Column; 5], model: &Model, edge: &EdgeModel<'_>) {
        // Measure the distance to the edge, and the way along it.
        let [along, distance] = edge.along_and_distances([x, y, sign], model.corner);

        // Evaluate the edge response, give it the sign of the other edge, and form the column T of the model's derivatives.
        let [mut e, slope, bend] = edge.responses(&distance, sign);
        let [_, _, _, a0, ax, ay] = model.light;
        let (mut contrast, mut turn) = ([0.0; CHUNK], [0.0; CHUNK]);
        for i in 0..CHUNK {
            e[i] *= sign[i];
            contrast[i] = (a0 + ax * x[i] + ay * y[i]) * sign[i];
            turn[i] = contrast[i] * slope[i];
        }

        // Sum up the moments of the pattern.
        let (xx, xy, yy) = (product(x, x), product(x, y), product(y, y));
        let weighted = product(&e, weight);
        add(&mut self.edge, &weighted, [&ONE, x, y, &xx, &xy, &yy]);
        add(&mut self.edge_squared, &product(&weighted, &e), [&ONE, x, y, &xx, &xy, &yy]);
        add(&mut self.edge_light, &product(&weighted, value), [&ONE, x, y]);

        // Sum up the products of T and T t with the light and the pattern, and with each other.
        let far = product(&turn, &along);
        let pixels = [x, y, value, &e];
        let (near_weighted, far_weighted) = (product(&turn, weight), product(&far, weight));
        self.add_turn(0, &near_weighted, pixels);
        self.add_turn(1, &far_weighted, pixels);
        add(&mut self.squares[..2], &near_weighted, [&turn, &far]);
        add(&mut self.squares[2..3], &far_weighted, [&far]);

        // Sum up the products of the blur's column.
        if edge.free_blur {
            let mut column = [0.0; CHUNK];
            for i in 0..CHUNK {
                column[i] = 0.5 * contrast[i] * bend[i];
            }
            let weighted = product(&column, weight);
            self.add_turn(2, &weighted, pixels);
            add(&mut self.squares[3..], &weighted, [&turn, &far, &column]);
        }
    }

    /// Adds the products of a weighted column with the light and the pattern.
    #[inline(always)]
    fn add_turn(&mut self, k: usize, weighted: &Column, [x, y, value, e]: [&Column; 4]) {
        add(&mut self.turns[k][..3], weighted, [&ONE, x, y]);
        add(&mut self.turns[k][3..6], &product(weighted, e), [&ONE, x, y]);
        add(&mut self.turns[k][6..], weighted, [value]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::blur_shape::PictureBlur;

    #[test]
    fn pixels_that_go_through_together_see_the_edge_as_each_alone() {
        let mut shape = PictureBlur::gaussian([1.0; 2]).shapes[0];
        shape.uneven[1] = -0.3;
        let normal = DVec2::new(0.8, 0.6);
        let profile = Profile::shaped(EdgeShape::new(normal, 1.0), &shape);
        let distances: Column = std::array::from_fn(|i| (i as f64 - 15.5) * 0.21);
        let signs: Column = std::array::from_fn(|i| if i % 3 == 0 { 1.0 } else { -1.0 });
        for bright in [-1.0, 0.0, 1.0] {
            let edge = EdgeModel {
                profile: &profile,
                normal,
                tangent: normal.perp(),
                curvature: 0.0,
                shift_px: 0.0,
                step_px: 0.0,
                step_rate: 0.0,
                bright,
                free_blur: false,
            };
            let [values, slopes, bends] = edge.responses(&distances, &signs);
            for i in 0..CHUNK {
                let Edge { value, slope, bend } = edge.response(distances[i], signs[i]);
                assert_eq!([values[i], slopes[i], bends[i]], [value, slope, bend], "{bright} {i}");
            }
        }
    }
}
