//! Least squares: linear, and non-linear by Levenberg-Marquardt, with the covariance of what was found.
//!
//! Column-scaled Jacobian, QR instead of normal equations, and steps taken on the problem's own state, so that a
//! rotation needs no global coordinates. After Moré, "The Levenberg-Marquardt algorithm: implementation and theory"
//! (1978), with multiplicative damping in place of the trust region.

use nalgebra::{DMatrix, DVector};

/// A matrix whose columns, each scaled to unit length, have singular values further apart than this is called
/// singular: solving with it would leave fewer than four digits of f64.
const SMALLEST_RECIPROCAL_CONDITION: f64 = 1e-12;

/// Damping above which no step can be told from rounding.
const LARGEST_DAMPING: f64 = 1e15;

/// When a search ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SearchSettings {
    /// Done when the undamped step would change the residuals by less than this (root mean square, unit of a residual).
    pub tolerance: f64,
    /// Steps tried, accepted or not, before giving up.
    pub max_iterations: usize,
}

impl Default for SearchSettings {
    /// For residuals in px: 1e-9 px is far below what a fit can mean and far above the rounding of positions.
    fn default() -> Self {
        Self { tolerance: 1e-9, max_iterations: 200 }
    }
}

/// The end of a search.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Minimum<S> {
    /// The state of least squares.
    pub state: S,
    /// Residuals there.
    pub residuals: DVector<f64>,
    /// Covariance of the step parameters at the minimum, (J^T J)^-1 |r|^2 / (m - p) for m residuals and p parameters:
    /// right when the residuals are independent noise of one variance. `None` when m = p leaves nothing to judge by.
    pub covariance: Option<DMatrix<f64>>,
    /// Steps tried.
    pub iterations: usize,
}

/// Why there is no minimum to report.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Failure {
    /// More parameters than residuals, or none at all.
    #[error("{residuals} residuals cannot determine {parameters} parameters")]
    TooFew {
        /// Count of residuals.
        residuals: usize,
        /// Count of parameters.
        parameters: usize,
    },
    /// The function could not be evaluated at the start, or was not finite there.
    #[error("the residuals at the start are not finite")]
    NoStart,
    /// Some combination of the parameters changes nothing.
    #[error("the data leave a combination of the parameters free (reciprocal condition {reciprocal_condition:.1e})")]
    Singular {
        /// Smallest over largest singular value of the column-scaled Jacobian.
        reciprocal_condition: f64,
    },
    /// Still moving after the last allowed step.
    #[error("no convergence after {iterations} steps")]
    NotConverged {
        /// Steps tried.
        iterations: usize,
    },
}

/// The x of least |A x - b|, for every column of `b`.
///
/// # Errors
/// [`Failure::TooFew`] when A has fewer rows than columns, [`Failure::NoStart`] when A or b is not finite,
/// [`Failure::Singular`] when the columns of A are not independent.
pub fn linear(a: &DMatrix<f64>, b: &DMatrix<f64>) -> Result<DMatrix<f64>, Failure> {
    if a.nrows() < a.ncols() || a.ncols() == 0 {
        return Err(Failure::TooFew { residuals: a.nrows(), parameters: a.ncols() });
    }
    if !a.iter().chain(b.iter()).all(|v| v.is_finite()) {
        return Err(Failure::NoStart);
    }
    let scale = column_norms(a);
    let factors = scaled(a, &scale).qr();
    let r = factors.r();
    independent(&r)?;
    let mut rhs = b.clone();
    factors.q_tr_mul(&mut rhs);
    let mut x = rhs.rows(0, a.ncols()).into_owned();
    let solved = r.solve_upper_triangular_mut(&mut x);
    debug_assert!(solved, "a full-rank triangle has no zero on its diagonal");
    x.row_iter_mut().zip(scale.iter()).for_each(|(mut row, s)| row /= *s);
    Ok(x)
}

/// Minimises |r(state)|^2 from `start`.
///
/// `evaluate` gives the residuals and their Jacobian with respect to the step parameters at zero step, or `None` where
/// the state makes no sense (such a step is refused). `step` moves a state by step parameters; `step(s, 0)` is `s`.
///
/// # Errors
/// See [`Failure`]. A minimum on which the data leave some direction free is [`Failure::Singular`], however small its
/// residuals.
pub(crate) fn levenberg_marquardt<S>(
    start: S,
    settings: SearchSettings,
    evaluate: impl Fn(&S) -> Option<(DVector<f64>, DMatrix<f64>)>,
    step: impl Fn(&S, &DVector<f64>) -> S,
) -> Result<Minimum<S>, Failure> {
    let finite = |r: &DVector<f64>, j: &DMatrix<f64>| r.iter().chain(j.iter()).all(|v| v.is_finite());
    let (mut residuals, mut jacobian) = evaluate(&start).filter(|(r, j)| finite(r, j)).ok_or(Failure::NoStart)?;
    let (m, p) = jacobian.shape();
    if m < p || p == 0 {
        return Err(Failure::TooFew { residuals: m, parameters: p });
    }
    let mut state = start;
    let mut scale = DVector::zeros(p);
    let mut damping = 1e-3;
    let mut iterations = 0;

    'jacobian: loop {
        // Factor the scaled Jacobian once; every damping then works on the p x p triangle.
        scale = scale.zip_map(&column_norms(&jacobian), f64::max);
        let factors = scaled(&jacobian, &scale).qr();
        let r = factors.r();
        let mut projected = residuals.clone();
        factors.q_tr_mul(&mut projected);
        let projected = projected.rows(0, p).into_owned();
        let cost = residuals.norm_squared();
        if projected.norm_squared() <= settings.tolerance * settings.tolerance * m as f64 {
            break;
        }

        // Try steps of growing damping until one pays.
        loop {
            if iterations == settings.max_iterations {
                return Err(Failure::NotConverged { iterations });
            }
            iterations += 1;
            let scaled_step = damped_step(&r, &projected, damping);
            let predicted = projected.norm_squared() - (&projected + &r * &scaled_step).norm_squared();
            let candidate = step(&state, &scaled_step.component_div(&scale));
            let evaluated = evaluate(&candidate).filter(|(r, j)| finite(r, j));
            if let Some((new_residuals, new_jacobian)) = evaluated.filter(|(r, _)| r.norm_squared() < cost) {
                (state, residuals, jacobian) = (candidate, new_residuals, new_jacobian);
                damping = (damping * 0.1).max(1e-12);
                continue 'jacobian;
            }
            // What the step promised is below the rounding of the cost itself: this is the bottom.
            if predicted <= 4.0 * f64::EPSILON * cost || damping > LARGEST_DAMPING {
                break 'jacobian;
            }
            damping *= 10.0;
        }
    }

    let scale = column_norms(&jacobian);
    let r = scaled(&jacobian, &scale).qr().r();
    independent(&r)?;
    Ok(Minimum { covariance: covariance(&r, &scale, &residuals), state, residuals, iterations })
}

/// The step h of least |R h + q|^2 + damping |h|^2.
fn damped_step(r: &DMatrix<f64>, projected: &DVector<f64>, damping: f64) -> DVector<f64> {
    let p = r.ncols();
    let mut stacked = DMatrix::zeros(2 * p, p);
    stacked.rows_mut(0, p).copy_from(r);
    stacked.rows_mut(p, p).fill_diagonal(damping.sqrt());
    let mut rhs = DVector::zeros(2 * p);
    rhs.rows_mut(0, p).copy_from(&-projected);
    let factors = stacked.qr();
    factors.q_tr_mul(&mut rhs);
    let mut h = rhs.rows(0, p).into_owned();
    // The damping keeps the diagonal away from zero.
    factors.r().solve_upper_triangular_mut(&mut h);
    h
}

/// The length of each column, 1 for a column of zeros.
fn column_norms(a: &DMatrix<f64>) -> DVector<f64> {
    DVector::from_iterator(a.ncols(), a.column_iter().map(|c| if c.norm() > 0.0 { c.norm() } else { 1.0 }))
}

fn scaled(a: &DMatrix<f64>, scale: &DVector<f64>) -> DMatrix<f64> {
    let mut b = a.clone();
    b.column_iter_mut().zip(scale.iter()).for_each(|(mut column, s)| column /= *s);
    b
}

fn independent(r: &DMatrix<f64>) -> Result<(), Failure> {
    let values = r.singular_values();
    let reciprocal_condition = values.min() / values.max();
    if reciprocal_condition > SMALLEST_RECIPROCAL_CONDITION {
        Ok(())
    } else {
        Err(Failure::Singular { reciprocal_condition: if values.max() > 0.0 { reciprocal_condition } else { 0.0 } })
    }
}

fn covariance(r: &DMatrix<f64>, scale: &DVector<f64>, residuals: &DVector<f64>) -> Option<DMatrix<f64>> {
    let (m, p) = (residuals.len(), r.ncols());
    let variance = if m > p { residuals.norm_squared() / (m - p) as f64 } else { return None };
    let mut inverse = DMatrix::identity(p, p);
    r.solve_upper_triangular_mut(&mut inverse);
    inverse.row_iter_mut().zip(scale.iter()).for_each(|(mut row, s)| row /= *s);
    Some(&inverse * inverse.transpose() * variance)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rosenbrock(x: &DVector<f64>) -> Option<(DVector<f64>, DMatrix<f64>)> {
        Some((
            DVector::from_vec(vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]]),
            DMatrix::from_row_slice(2, 2, &[-20.0 * x[0], 10.0, -1.0, 0.0]),
        ))
    }

    #[test]
    fn finds_the_bottom_of_rosenbrocks_valley() {
        let start = DVector::from_vec(vec![-1.2, 1.0]);
        let end = levenberg_marquardt(start, SearchSettings::default(), rosenbrock, |x, h| x + h).unwrap();
        assert!((end.state - DVector::from_vec(vec![1.0, 1.0])).norm() < 1e-8);
        assert_eq!(end.covariance, None, "two residuals for two parameters leave no variance to estimate");
    }

    #[test]
    fn covariance_of_a_straight_line_is_the_textbook_one() {
        // y = a + b x over x = 0..4 with residuals of known sum of squares.
        let x = [0.0, 1.0, 2.0, 3.0, 4.0];
        let y = [1.0, 3.5, 4.5, 7.5, 8.5];
        let design = DMatrix::from_fn(5, 2, |i, k| if k == 0 { 1.0 } else { x[i] });
        let evaluate = |s: &DVector<f64>| Some((&design * s - DVector::from_row_slice(&y), design.clone()));
        let end = levenberg_marquardt(DVector::zeros(2), SearchSettings::default(), evaluate, |s, h| s + h).unwrap();
        let (mean_x, mean_y, sxx) = (2.0, 5.0, 10.0);
        let b = x.iter().zip(y).map(|(x, y)| (x - mean_x) * (y - mean_y)).sum::<f64>() / sxx;
        let a = mean_y - b * mean_x;
        let s2 = x.iter().zip(y).map(|(x, y)| (y - a - b * x) * (y - a - b * x)).sum::<f64>() / 3.0;
        assert!((end.state[0] - a).abs() < 1e-9 && (end.state[1] - b).abs() < 1e-9);
        let c = end.covariance.unwrap();
        assert!((c[(1, 1)] - s2 / sxx).abs() < 1e-9);
        assert!((c[(0, 0)] - s2 * (0.2 + mean_x * mean_x / sxx)).abs() < 1e-9);
        assert!((c[(0, 1)] + s2 * mean_x / sxx).abs() < 1e-9);
        let by_qr = linear(&design, &DMatrix::from_row_slice(5, 1, &y)).unwrap();
        assert!((by_qr[(0, 0)] - a).abs() < 1e-13 && (by_qr[(1, 0)] - b).abs() < 1e-13);
    }

    #[test]
    fn parameters_of_very_different_size_do_not_look_singular() {
        let a = DMatrix::from_fn(6, 2, |i, k| if k == 0 { 1e-9 } else { 1e9 * i as f64 });
        let b = &a * DMatrix::from_row_slice(2, 1, &[3e9, -2e-9]);
        let x = linear(&a, &b).unwrap();
        assert!((x[(0, 0)] / 3e9 - 1.0).abs() < 1e-13 && (x[(1, 0)] / -2e-9 - 1.0).abs() < 1e-13);
    }

    #[test]
    fn a_free_direction_is_called_singular() {
        // Only the sum of the two parameters matters.
        let evaluate = |s: &DVector<f64>| {
            let sum = s[0] + s[1] - 1.0;
            Some((
                DVector::from_vec(vec![sum, 2.0 * sum, 3.0]),
                DMatrix::from_row_slice(3, 2, &[1., 1., 2., 2., 0., 0.]),
            ))
        };
        let end = levenberg_marquardt(DVector::zeros(2), SearchSettings::default(), evaluate, |s, h| s + h);
        assert!(matches!(end, Err(Failure::Singular { .. })), "{end:?}");
        let zeros = linear(&DMatrix::zeros(3, 2), &DMatrix::zeros(3, 1));
        assert_eq!(zeros, Err(Failure::Singular { reciprocal_condition: 0.0 }));
    }

    #[test]
    fn bad_input_is_named() {
        let nan = |_: &DVector<f64>| Some((DVector::from_element(2, f64::NAN), DMatrix::zeros(2, 1)));
        let few = |_: &DVector<f64>| Some((DVector::zeros(1), DMatrix::zeros(1, 2)));
        let add = |s: &DVector<f64>, h: &DVector<f64>| s + h;
        let end = levenberg_marquardt(DVector::zeros(1), SearchSettings::default(), nan, add);
        assert_eq!(end, Err(Failure::NoStart));
        let end = levenberg_marquardt(DVector::zeros(2), SearchSettings::default(), few, add);
        assert_eq!(end, Err(Failure::TooFew { residuals: 1, parameters: 2 }));
        let tired = SearchSettings { max_iterations: 3, ..SearchSettings::default() };
        let end = levenberg_marquardt(DVector::from_vec(vec![-1.2, 1.0]), tired, rosenbrock, add);
        assert_eq!(end, Err(Failure::NotConverged { iterations: 3 }));
    }
}
