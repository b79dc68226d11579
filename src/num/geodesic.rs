//! Non-linear least squares by Levenberg's and Marquardt's method with geodesic acceleration.
//!
//! Where a valley of the merit is narrow and bent, steps along its tangent soon climb its walls. The second derivative of the
//! residuals along the step bends the step with the valley (Transtrum & Sethna, "Improvements to the Levenberg-Marquardt algorithm
//! for nonlinear least-squares minimization", arXiv:1201.5885). The steps are solved by QR of the Jacobian, its columns scaled to
//! unit length, so that the condition is not squared.

use nalgebra::{DMatrix, DVector};

/// A step is taken only where half the acceleration is less than this share of the velocity (Transtrum & Sethna: 0.75).
const MOST_BEND: f64 = 0.75;
/// Damping at the start, of a matrix with columns of unit length.
const FIRST_DAMPING: f64 = 1e-2;
/// Damping below which it is of no effect, and above which no step can be told from rounding.
const DAMPING: [f64; 2] = [1e-14, 1e12];
/// The damping falls at most to this share after a good step (Nielsen, "Damping parameter in Marquardt's method", 1999).
const MOST_FALL: f64 = 0.2;
/// The search is done after so many steps on end that gain less than the wanted share.
const POOR_STEPS: usize = 4;

/// What is minimised.
pub trait Merit {
    /// The residuals at `x`; `None` where it makes no sense.
    fn residuals(&self, x: &DVector<f64>) -> Option<DVector<f64>>;
    /// The residuals and their derivatives by every unknown.
    fn jacobian(&self, x: &DVector<f64>) -> Option<(DVector<f64>, DMatrix<f64>)>;
    /// The second derivative of the residuals along the line from `x` towards `x + direction`.
    fn bend(&self, x: &DVector<f64>, direction: &DVector<f64>) -> Option<DVector<f64>>;
}

/// When a search ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Patience {
    /// Steps, at most.
    pub steps: usize,
    /// The share of the merit that a step must gain for the search to go on.
    pub gain: f64,
}

/// Where a search ended.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Valley {
    /// The unknowns.
    pub x: DVector<f64>,
    /// Square root of the sum of squares of the residuals.
    pub norm: f64,
    /// Steps taken.
    pub steps: usize,
}

/// The equations of one Jacobian, factored.
struct Factored {
    scale: DVector<f64>,
    triangle: DMatrix<f64>,
    factors: nalgebra::linalg::QR<f64, nalgebra::Dyn, nalgebra::Dyn>,
}

impl Factored {
    fn new(mut jacobian: DMatrix<f64>) -> Self {
        let norms = jacobian.column_iter().map(|c| if c.norm() > 0.0 { c.norm() } else { 1.0 });
        let scale = DVector::from_iterator(jacobian.ncols(), norms);
        jacobian.column_iter_mut().zip(scale.iter()).for_each(|(mut column, s)| column /= *s);
        let factors = jacobian.qr();
        Self { scale, triangle: factors.r(), factors }
    }

    /// Q^T r.
    fn projected(&self, residuals: &DVector<f64>) -> DVector<f64> {
        let mut all = residuals.clone();
        self.factors.q_tr_mul(&mut all);
        all.rows(0, self.triangle.ncols()).into_owned()
    }

    /// The triangle with `damping` below it.
    fn damped(&self, damping: f64) -> nalgebra::linalg::QR<f64, nalgebra::Dyn, nalgebra::Dyn> {
        let p = self.triangle.ncols();
        let mut stacked = DMatrix::zeros(2 * p, p);
        stacked.rows_mut(0, p).copy_from(&self.triangle);
        stacked.rows_mut(p, p).fill_diagonal(damping.sqrt());
        stacked.qr()
    }
}

/// The scaled h of least |R h + q|^2 + damping |h|^2.
fn solved(damped: &nalgebra::linalg::QR<f64, nalgebra::Dyn, nalgebra::Dyn>, projected: &DVector<f64>) -> DVector<f64> {
    let p = projected.len();
    let mut rhs = DVector::zeros(2 * p);
    rhs.rows_mut(0, p).copy_from(&-projected);
    damped.q_tr_mul(&mut rhs);
    let mut h = rhs.rows(0, p).into_owned();
    // The damping keeps the diagonal away from zero.
    damped.r().solve_upper_triangular_mut(&mut h);
    h
}

/// Descends from `start`; `None` where the merit makes no sense there.
pub(crate) fn descend(merit: &impl Merit, start: DVector<f64>, patience: Patience) -> Option<Valley> {
    let finite = |r: &DVector<f64>| r.iter().all(|v| v.is_finite());
    let (mut x, mut damping, mut poor, mut steps) = (start, FIRST_DAMPING, 0, 0);
    let (mut residuals, jacobian) = merit.jacobian(&x).filter(|(r, _)| finite(r))?;
    let mut factored = Factored::new(jacobian);
    let mut cost = residuals.norm_squared();
    while steps < patience.steps && poor < POOR_STEPS && cost > 0.0 {
        // Try steps, each shorter than the one before, until one descends.
        let projected = factored.projected(&residuals);
        let mut growth = 2.0;
        let taken = loop {
            let damped = factored.damped(damping);
            let velocity = solved(&damped, &projected);
            let next = bent_step(merit, &x, &factored, &damped, &velocity).and_then(|step| {
                let next = &x + step;
                merit.residuals(&next).filter(|r| finite(r) && r.norm_squared() < cost).map(|r| (next, r))
            });
            if let Some((next, r)) = next {
                break Some((next, r, velocity));
            }
            damping *= growth;
            growth *= 2.0;
            if damping > DAMPING[1] {
                break None;
            }
        };
        let Some((next, r, velocity)) = taken else { break };

        // Damp the next one less where this one gained what the linear model promised.
        let next_cost = r.norm_squared();
        let promised = projected.norm_squared() - (&projected + &factored.triangle * velocity).norm_squared();
        let ratio = 2.0 * (cost - next_cost) / promised.max(f64::MIN_POSITIVE) - 1.0;
        damping = (damping * (1.0 - ratio * ratio * ratio).max(MOST_FALL)).max(DAMPING[0]);

        // Go there.
        poor = if cost - next_cost < patience.gain * cost { poor + 1 } else { 0 };
        let (r, jacobian) = merit.jacobian(&next)?;
        (x, cost, residuals, factored) = (next, next_cost, r, Factored::new(jacobian));
        steps += 1;
    }
    Some(Valley { x, norm: cost.sqrt(), steps })
}

/// velocity + acceleration/2, unscaled; `None` where the valley bends too much for it.
fn bent_step(
    merit: &impl Merit,
    x: &DVector<f64>,
    factored: &Factored,
    damped: &nalgebra::linalg::QR<f64, nalgebra::Dyn, nalgebra::Dyn>,
    velocity: &DVector<f64>,
) -> Option<DVector<f64>> {
    let bend = merit.bend(x, &velocity.component_div(&factored.scale))?;
    let acceleration = solved(damped, &factored.projected(&bend));
    let straight = 2.0 * acceleration.norm() <= MOST_BEND * velocity.norm();
    straight.then(|| (velocity + 0.5 * acceleration).component_div(&factored.scale))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rosenbrock's valley with walls a thousand times as steep; a share of its bend is told.
    struct Banana(f64);

    impl Merit for Banana {
        fn residuals(&self, x: &DVector<f64>) -> Option<DVector<f64>> {
            Some(DVector::from_vec(vec![1e4 * (x[1] - x[0] * x[0]), 1.0 - x[0]]))
        }

        fn jacobian(&self, x: &DVector<f64>) -> Option<(DVector<f64>, DMatrix<f64>)> {
            let slopes = DMatrix::from_row_slice(2, 2, &[-2e4 * x[0], 1e4, -1.0, 0.0]);
            self.residuals(x).map(|r| (r, slopes))
        }

        fn bend(&self, _: &DVector<f64>, d: &DVector<f64>) -> Option<DVector<f64>> {
            Some(DVector::from_vec(vec![-2e4 * self.0 * d[0] * d[0], 0.0]))
        }
    }

    /// The bent step follows the valley to its end, where twice as many steps along tangents have hardly left the start.
    #[test]
    fn a_bent_valley_is_followed() {
        let start = || DVector::from_vec(vec![-1.2, 1.0]);
        let end = descend(&Banana(1.0), start(), Patience { steps: 200, gain: 1e-12 }).unwrap();
        assert!(end.norm < 1e-12 && (end.x[0] - 1.0).abs() < 1e-12, "{end:?}");
        let straight = descend(&Banana(0.0), start(), Patience { steps: 400, gain: 1e-12 }).unwrap();
        assert!(straight.norm > 0.5, "{straight:?}");
    }
}
