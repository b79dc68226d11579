//! Moments of the flat pixels of a window: weighted sums over pixels of one constant pattern value.

use glam::{DMat2, DVec2};

/// Where a window lies and how the two edges cross in it.
#[derive(Debug, Clone, Copy)]
pub(super) struct WindowFrame {
    /// The expected corner, in px.
    pub(super) centre: DVec2,
    /// The steps to the next corner along the column and the row direction, in px.
    pub(super) steps: DMat2,
    /// Unit normals of the edge along the columns' direction and of the one along the rows'.
    pub(super) normals: [DVec2; 2],
    /// Pixels nearer than this to an edge see it, in px.
    pub(super) bands_px: [f64; 2],
    /// Half the window, in steps. The weight falls from 1 to 0 over one pixel there, so that the window is a
    /// continuous function of its centre and does not lock to pixels.
    pub(super) half: f64,
}

/// Lanes of the sums along a row.
const LANES: usize = 4;

/// Weighted sums over pixels of one constant pattern value (1 or -1), with x, y from the window's centre.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct PixelSums {
    /// Of 1, x, y, x^2, xy, y^2.
    pub(super) moments: [f64; 6],
    /// Of I, I x, I y.
    pub(super) light: [f64; 3],
    /// Of I^2.
    pub(super) square: f64,
}

impl PixelSums {
    #[inline(always)]
    pub(super) fn add(&mut self, x: f64, y: f64, value: f64, weight: f64) {
        self.add_run(
            [weight, weight * x, weight * x * x],
            [weight * value, weight * value * x],
            weight * value * value,
            y,
        );
    }

    /// Adds pixels of one row: the sums of (1, x, x^2), of (I, I x) and of I^2.
    #[inline(always)]
    pub(super) fn add_run(&mut self, [n, x, xx]: [f64; 3], [i, ix]: [f64; 2], square: f64, y: f64) {
        for (sum, term) in self.moments.iter_mut().zip([n, x, n * y, xx, x * y, n * y * y]) {
            *sum += term;
        }
        for (sum, term) in self.light.iter_mut().zip([i, ix, i * y]) {
            *sum += term;
        }
        self.square += square;
    }

    /// Adds a row of pixels of weight 1, the first at `x`.
    #[inline(always)]
    pub(super) fn add_row(&mut self, row: &[f32], x: f64, y: f64) {
        // Sum up value, first moment and square in four lanes and in a fixed order: a plain sum could not use the
        // processor's lanes.
        let (mut light, mut first, mut square, mut place) =
            ([0.0; LANES], [0.0; LANES], [0.0; LANES], [0.0, 1.0, 2.0, 3.0]);
        let (chunks, rest) = row.as_chunks::<LANES>();
        for chunk in chunks {
            let values = chunk.map(f64::from);
            light = plus(light, values);
            first = plus(first, times(values, place));
            square = plus(square, times(values, values));
            place = plus(place, [LANES as f64; LANES]);
        }
        for (lane, &value) in rest.iter().enumerate() {
            let value = f64::from(value);
            light[lane] += value;
            first[lane] += value * place[lane];
            square[lane] += value * value;
        }

        // Move the first moment from the run's start to the window's centre.
        let sum = |v: [f64; LANES]| (v[0] + v[1]) + (v[2] + v[3]);
        let (light, first) = (sum(light), sum(first));
        let n = row.len() as f64;
        let middle = x + 0.5 * (n - 1.0);
        let moments = [n, n * middle, n * (middle * middle + (n * n - 1.0) / 12.0)];
        self.add_run(moments, [light, first + x * light], sum(square), y);
    }
}

/// Lane by lane.
#[inline(always)]
fn plus(mut a: [f64; LANES], b: [f64; LANES]) -> [f64; LANES] {
    a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
    a
}

/// Lane by lane.
#[inline(always)]
fn times(mut a: [f64; LANES], b: [f64; LANES]) -> [f64; LANES] {
    a.iter_mut().zip(b).for_each(|(a, b)| *a *= b);
    a
}
