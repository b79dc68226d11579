//! The map along one row of a patch: polynomials of the column, with what is needed of their derivatives.

use super::draft::Steps;
use super::map::MapPatch;
use crate::num::chebyshev::MAX_DEGREE;
use crate::num::simd::{LANES, Lanes};

/// Coefficients of a polynomial in s, by rising power.
type Line = [f64; MAX_DEGREE + 1];

/// The map along one row: u and v as polynomials in s, with their first and second derivatives by steps of a pixel's
/// active side down the picture.
#[derive(Clone, Copy)]
pub(super) struct RowMap {
    degree: [usize; 2],
    value: [Line; 2],
    down: [Line; 2],
    down2: [Line; 2],
}

/// A polynomial at t, its derivative and half its second derivative.
#[inline(always)]
fn value_and_derivatives(powers: &[f64], t: Lanes) -> [Lanes; 3] {
    let zero = Lanes::splat(0.0);
    let (mut p, mut p1, mut p2) = (zero, zero, zero);
    for &c in powers.iter().rev() {
        p2 = p2 * t + p1;
        p1 = p1 * t + p;
        p = p * t + Lanes::splat(c);
    }
    [p, p1, p2]
}

impl RowMap {
    /// That of no row.
    pub(super) fn none() -> Self {
        let line = [[0.0; MAX_DEGREE + 1]; 2];
        Self { degree: [0; 2], value: line, down: line, down2: line }
    }

    /// Makes of maps of `patch`, or of none, those along rows `first`, `first` + 1, ...
    #[inline(always)]
    pub(super) fn fill(maps: &mut [Self; LANES], patch: &MapPatch, first: usize, active: f64) {
        let t = Lanes::of(|r| patch.t((first + r) as f64 + 0.5));
        let step = patch.steps().y * active;
        let [two, step, step2] = [2.0, step, step * step].map(Lanes::splat);
        for axis in 0..2 {
            maps.iter_mut().for_each(|map| map.degree[axis] = patch.powers[axis].len() - 1);
            for (k, powers) in patch.powers[axis].iter().enumerate() {
                let [p, down, down2] = value_and_derivatives(powers, t);
                let (down, down2) = (down * step, two * down2 * step2);
                for (r, map) in maps.iter_mut().enumerate() {
                    (map.value[axis][k], map.down[axis][k], map.down2[axis][k]) = (p.0[r], down.0[r], down2.0[r]);
                }
            }
        }
    }

    /// u and v, each with its derivative by s.
    #[inline(always)]
    pub(super) fn slopes(&self, s: Lanes) -> [[Lanes; 2]; 2] {
        let zero = Lanes::splat(0.0);
        let (mut u, mut us, mut v, mut vs) = (zero, zero, zero, zero);
        // Both at once, since each step waits for the one before; coefficients beyond a degree are 0.
        for k in (0..=self.degree[0].max(self.degree[1])).rev() {
            (us, vs) = (us * s + u, vs * s + v);
            (u, v) = (u * s + Lanes::splat(self.value[0][k]), v * s + Lanes::splat(self.value[1][k]));
        }
        [[u, us], [v, vs]]
    }

    /// Value and the derivatives ss, t, st and tt after s.
    #[inline(always)]
    pub(super) fn derivatives(&self, axis: usize, s: Lanes) -> [Lanes; 6] {
        let zero = Lanes::splat(0.0);
        let (mut p, mut p1, mut p2, mut q, mut q1, mut r) = (zero, zero, zero, zero, zero, zero);
        for k in (0..=self.degree[axis]).rev() {
            p2 = p2 * s + p1;
            p1 = p1 * s + p;
            p = p * s + Lanes::splat(self.value[axis][k]);
            q1 = q1 * s + q;
            q = q * s + Lanes::splat(self.down[axis][k]);
            r = r * s + Lanes::splat(self.down2[axis][k]);
        }
        [p, p1, p2 + p2, q, q1, r]
    }

    /// Derivatives down and twice to the right, in the picture's frame, at s.
    #[inline(always)]
    pub(super) fn steps(&self, patch: &MapPatch, s: f64, active: f64) -> Steps {
        let step = patch.steps().x;
        let mut steps = Steps { down: [0.0; 2], bend: [0.0; 2] };
        for axis in 0..2 {
            let (mut p, mut p1, mut p2, mut down) = (0.0, 0.0, 0.0, 0.0);
            for k in (0..=self.degree[axis]).rev() {
                p2 = p2 * s + p1;
                p1 = p1 * s + p;
                p = p * s + self.value[axis][k];
                down = down * s + self.down[axis][k];
            }
            // u is counted to the left where the patch is turned over.
            let sign = if patch.flip && axis == 0 { -1.0 } else { 1.0 };
            steps.down[axis] = sign * down / active;
            steps.bend[axis] = sign * 2.0 * p2 * (step * step);
        }
        steps
    }
}
