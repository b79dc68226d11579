//! The map along one row of a patch: polynomials of the column, with what is needed of their derivatives.

use super::draft::Steps;
use super::map::MapPatch;
use crate::num::chebyshev::MAX_DEGREE;
use crate::num::simd::Lanes;

/// Coefficients of a polynomial in s, by rising power.
type Line = [f64; MAX_DEGREE + 1];

/// The map along one row: u and v as polynomials in s, with their first and second derivatives by steps of a pixel's
/// active side down the picture.
pub(super) struct RowMap {
    degree: [usize; 2],
    value: [Line; 2],
    down: [Line; 2],
    down2: [Line; 2],
}

impl RowMap {
    #[inline(always)]
    pub(super) fn new(patch: &MapPatch, y: f64, active: f64) -> Self {
        let (t, step) = (patch.t(y), patch.steps().y * active);
        let mut row = Self {
            degree: [0, 1].map(|axis| patch.powers[axis].len() - 1),
            value: [[0.0; MAX_DEGREE + 1]; 2],
            down: [[0.0; MAX_DEGREE + 1]; 2],
            down2: [[0.0; MAX_DEGREE + 1]; 2],
        };
        for axis in 0..2 {
            for (k, powers) in patch.powers[axis].iter().enumerate() {
                let (mut p, mut p1, mut p2) = (0.0, 0.0, 0.0);
                for &c in powers.iter().rev() {
                    p2 = p2 * t + p1;
                    p1 = p1 * t + p;
                    p = p * t + c;
                }
                row.value[axis][k] = p;
                row.down[axis][k] = p1 * step;
                row.down2[axis][k] = 2.0 * p2 * (step * step);
            }
        }
        row
    }

    /// Value and derivative by s.
    #[inline(always)]
    pub(super) fn slope(&self, axis: usize, s: Lanes) -> [Lanes; 2] {
        let (mut p, mut p1) = (Lanes::splat(0.0), Lanes::splat(0.0));
        for &c in self.value[axis][..=self.degree[axis]].iter().rev() {
            p1 = p1 * s + p;
            p = p * s + Lanes::splat(c);
        }
        [p, p1]
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
