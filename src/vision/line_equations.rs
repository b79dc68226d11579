//! Least squares over the powers of a polynomial along a line.

/// The highest power of a polynomial along a line.
pub(super) const MOST_POWER: usize = 8;
/// Its coefficients.
pub(super) const TERMS: usize = MOST_POWER + 1;
/// A pivot below this share of what it was is rounding.
const LEAST_PIVOT: f64 = 1e-14;

/// The normal equations of a line, factored: the part that belongs to the lower powers is the factor of these alone.
pub(super) struct LineEquations {
    /// The factor of Cholesky, its lower triangle.
    factor: [[f64; TERMS]; TERMS],
    /// Its inverse times the right side.
    forward: [f64; TERMS],
    /// So many coefficients are determined.
    terms: usize,
}

impl LineEquations {
    /// Of rows: the coefficients of all powers, and the value; up to a highest power.
    pub(super) fn of(rows: &[([f64; TERMS], f64)], power: usize) -> Self {
        // Sum up the lower triangle.
        let (mut normal, mut right) = ([[0.0; TERMS]; TERMS], [0.0; TERMS]);
        for (row, value) in rows {
            for i in 0..=power {
                right[i] += row[i] * value;
                for j in 0..=i {
                    normal[i][j] += row[i] * row[j];
                }
            }
        }

        // Factor it row by row, as far as it goes.
        let mut own = Self { factor: normal, forward: [0.0; TERMS], terms: 0 };
        for i in 0..=power {
            for j in 0..=i {
                let (of_i, of_j) = (own.factor[i], own.factor[j]);
                let known: f64 = (0..j).map(|k| of_i[k] * of_j[k]).sum();
                let rest = normal[i][j] - known;
                if i == j && (rest.is_nan() || rest <= LEAST_PIVOT * normal[i][i]) {
                    return own;
                }
                own.factor[i][j] = if i == j { rest.sqrt() } else { rest / of_j[j] };
            }
            let known: f64 = (0..i).map(|k| own.factor[i][k] * own.forward[k]).sum();
            own.forward[i] = (right[i] - known) / own.factor[i][i];
            own.terms = i + 1;
        }
        own
    }

    /// The coefficients of the least squares over the powers up to `power`; the others are 0.
    pub(super) fn solve(&self, power: usize) -> Option<[f64; TERMS]> {
        let mut solved = [0.0; TERMS];
        for i in (0..=power).rev() {
            let known: f64 = (i + 1..=power).map(|k| self.factor[k][i] * solved[k]).sum();
            solved[i] = (self.forward[i] - known) / self.factor[i][i];
        }
        (power < self.terms).then_some(solved)
    }

    /// The variance of the sum of the coefficients up to `power`, each times its number in `by`.
    pub(super) fn variance(&self, power: usize, by: &[f64; TERMS]) -> f64 {
        let mut forward = [0.0; TERMS];
        for i in 0..=power {
            let known: f64 = (0..i).map(|k| self.factor[i][k] * forward[k]).sum();
            forward[i] = (by[i] - known) / self.factor[i][i];
        }
        forward.iter().map(|v| v * v).sum()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_power_is_solved_for_as_if_it_were_the_highest() {
        // Values of a polynomial of degree 8 at twelve places: lower powers leave some of it.
        let rows: Vec<_> = (0..12)
            .map(|i| {
                let powers = powers(f64::from(i) / 5.5 - 1.0);
                (powers, powers.iter().enumerate().map(|(k, p)| p / (1.0 + k as f64)).sum::<f64>())
            })
            .collect();
        let all = LineEquations::of(&rows, MOST_POWER);
        for power in 2..=MOST_POWER {
            let (own, c) = (LineEquations::of(&rows, power), all.solve(power).unwrap());
            assert_eq!(own.solve(power).unwrap(), c);
            // What is left stands at right angles to every power.
            for k in 0..=power {
                let left =
                    |(row, value): &([f64; TERMS], f64)| value - row.iter().zip(&c).map(|(a, b)| a * b).sum::<f64>();
                assert!(rows.iter().map(|row| row.0[k] * left(row)).sum::<f64>().abs() < 1e-9, "{power} {k}");
            }
            // The variance of one coefficient is that of its row of the inverse.
            let mut by = [0.0; TERMS];
            by[power] = 1.0;
            let factor = all.factor[power][power];
            assert!((all.variance(power, &by) * factor * factor - 1.0).abs() < 1e-12);
        }
        assert!(
            all.solve(MOST_POWER).unwrap().iter().enumerate().all(|(k, c)| (c * (1.0 + k as f64) - 1.0).abs() < 1e-6)
        );
    }
}
