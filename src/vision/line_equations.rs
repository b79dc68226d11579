//! Least squares over the powers of a polynomial along a line.

use nalgebra::SMatrix;

/// The highest power of a polynomial along a line.
pub(super) const MOST_POWER: usize = 8;
/// Its coefficients.
pub(super) const TERMS: usize = MOST_POWER + 1;

/// The normal equations of a line.
pub(super) struct LineEquations {
    normal: [[f64; TERMS]; TERMS],
    right: [f64; TERMS],
}

impl LineEquations {
    /// Of rows: the coefficients of all powers, and the value.
    pub(super) fn of(rows: &[([f64; TERMS], f64)]) -> Self {
        let mut sum = Self { normal: [[0.0; TERMS]; TERMS], right: [0.0; TERMS] };
        for (row, value) in rows {
            for i in 0..TERMS {
                sum.right[i] += row[i] * value;
                for j in 0..TERMS {
                    sum.normal[i][j] += row[i] * row[j];
                }
            }
        }
        sum
    }

    /// The coefficients of the least squares over the powers up to `power`, and the factor of the normal matrix; the others
    /// are 0.
    pub(super) fn solve(
        &self,
        power: usize,
    ) -> Option<([f64; TERMS], nalgebra::Cholesky<f64, nalgebra::Const<TERMS>>)> {
        let held = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
        let entry = |i: usize, j: usize| if i.max(j) <= power { self.normal[i][j] } else { held(i, j) };
        let normal = SMatrix::<f64, TERMS, TERMS>::from_fn(entry);
        let right = SMatrix::<f64, TERMS, 1>::from_fn(|i, _| if i <= power { self.right[i] } else { 0.0 });
        let factor = normal.cholesky()?;
        let solved = factor.solve(&right);
        Some((std::array::from_fn(|i| solved[i]), factor))
    }
}

/// 1, u, u^2, ..
pub(super) fn powers(u: f64) -> [f64; TERMS] {
    let mut powers = [1.0; TERMS];
    for k in 1..TERMS {
        powers[k] = powers[k - 1] * u;
    }
    powers
}

/// The derivatives of 1, u, u^2, .., of some order.
#[inline(always)]
pub(super) fn derivatives(powers: &[f64; TERMS], order: usize) -> [f64; TERMS] {
    let mut out = [0.0; TERMS];
    for k in order..TERMS {
        let mut factor = 1.0;
        for i in 0..order {
            factor *= (k - i) as f64;
        }
        out[k] = factor * powers[k - order];
    }
    out
}
