//! Ordinary differential equations y' = f(t, y) in a few variables.
//!
//! A right-hand side may refuse a point by returning an error, which ends the integration and is handed on.

/// How to go from one value of t to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Integrator {
    /// One Euler step: error of order 1.
    Euler,
    /// One midpoint step: error of order 2.
    Midpoint,
    /// One step of the classical Runge-Kutta method: error of order 4.
    Rk4,
    /// As many Dormand-Prince 5(4) steps as keep the error estimate of each step below this value, in the unit of y.
    DormandPrince(f64),
}

/// Why an integration ended early.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OdeError<E> {
    /// The right-hand side refused a point.
    Refused(E),
    /// Adaptive steps fell below 1e-10 of the interval or were more than 10 000: the solution has a singularity, or the
    /// tolerance is below what rounding allows.
    NoProgress,
}

impl<E> From<E> for OdeError<E> {
    fn from(e: E) -> Self {
        Self::Refused(e)
    }
}

/// Smallest adaptive step, as a fraction of the interval.
const SMALLEST_STEP: f64 = 1e-10;

/// Most adaptive steps of an interval, rejected ones included.
const MOST_STEPS: usize = 10_000;

impl Integrator {
    /// y(t + h) from y(t) = `y`; h may be negative.
    ///
    /// # Errors
    /// [`OdeError`] when `f` refuses a point or an adaptive step shrinks to nothing.
    #[inline]
    pub fn advance<const N: usize, E>(
        self,
        f: &impl Fn(f64, [f64; N]) -> Result<[f64; N], E>,
        t: f64,
        y: [f64; N],
        h: f64,
    ) -> Result<[f64; N], OdeError<E>> {
        Ok(match self {
            Self::Euler => plus(y, [(h, f(t, y)?)]),
            Self::Midpoint => {
                let k1 = f(t, y)?;
                let k2 = f(t + 0.5 * h, plus(y, [(0.5 * h, k1)]))?;
                plus(y, [(h, k2)])
            }
            Self::Rk4 => rk4(f, t, y, h)?,
            Self::DormandPrince(tolerance) => dormand_prince(f, t, y, h, tolerance)?,
        })
    }
}

/// y + sum of factor times slope.
#[inline(always)]
fn plus<const N: usize, const K: usize>(mut y: [f64; N], slopes: [(f64, [f64; N]); K]) -> [f64; N] {
    for i in 0..N {
        let mut change = 0.0;
        for (factor, slope) in &slopes {
            change += factor * slope[i];
        }
        y[i] += change;
    }
    y
}

#[inline(always)]
fn rk4<const N: usize, E>(
    f: &impl Fn(f64, [f64; N]) -> Result<[f64; N], E>,
    t: f64,
    y: [f64; N],
    h: f64,
) -> Result<[f64; N], E> {
    let k1 = f(t, y)?;
    let k2 = f(t + 0.5 * h, plus(y, [(0.5 * h, k1)]))?;
    let k3 = f(t + 0.5 * h, plus(y, [(0.5 * h, k2)]))?;
    let k4 = f(t + h, plus(y, [(h, k3)]))?;
    Ok(plus(y, [(h / 6.0, k1), (h / 3.0, k2), (h / 3.0, k3), (h / 6.0, k4)]))
}

/// The embedded pair of Dormand and Prince (J. Comp. Appl. Math. 6 (1980) 19, table RK5(4)7M), continued with the result of
/// fifth order. The last slope of a step is the first of the next.
fn dormand_prince<const N: usize, E>(
    f: &impl Fn(f64, [f64; N]) -> Result<[f64; N], E>,
    t0: f64,
    y0: [f64; N],
    span: f64,
    tolerance: f64,
) -> Result<[f64; N], OdeError<E>> {
    let (mut done, mut y, mut step) = (0.0, y0, 1.0);
    let mut k1 = f(t0, y)?;
    // `done` and `step` are fractions of the span, so that the end is reached exactly.
    for _ in 0..MOST_STEPS {
        let last = done + step >= 1.0;
        if last {
            step = 1.0 - done;
        }
        let (next, k7, error) = dormand_prince_step(f, t0 + span * done, y, k1, span * step)?;
        if error <= tolerance {
            if last {
                return Ok(next);
            }
            (y, k1) = (next, k7);
            done += step;
        }
        // The error grows as the fifth power of the step; aim a little below the tolerance.
        let growth = 0.9 * libm::pow(tolerance / error.max(1e-300), 0.2);
        step *= growth.clamp(0.2, 5.0);
        if step.is_nan() || step < SMALLEST_STEP || !error.is_finite() {
            break;
        }
    }
    Err(OdeError::NoProgress)
}

/// One step of the pair from y(t) = `y` with slope `k1`: the result of fifth order, the slope there, and the largest
/// difference from the result of fourth order.
#[inline(always)]
fn dormand_prince_step<const N: usize, E>(
    f: &impl Fn(f64, [f64; N]) -> Result<[f64; N], E>,
    t: f64,
    y: [f64; N],
    k1: [f64; N],
    h: f64,
) -> Result<([f64; N], [f64; N], f64), E> {
    let k2 = f(t + h / 5.0, plus(y, [(h / 5.0, k1)]))?;
    let k3 = f(t + h * 3.0 / 10.0, plus(y, [(h * 3.0 / 40.0, k1), (h * 9.0 / 40.0, k2)]))?;
    let k4 = f(t + h * 4.0 / 5.0, plus(y, [(h * 44.0 / 45.0, k1), (h * -56.0 / 15.0, k2), (h * 32.0 / 9.0, k3)]))?;
    let k5 = f(
        t + h * 8.0 / 9.0,
        plus(
            y,
            [
                (h * 19372.0 / 6561.0, k1),
                (h * -25360.0 / 2187.0, k2),
                (h * 64448.0 / 6561.0, k3),
                (h * -212.0 / 729.0, k4),
            ],
        ),
    )?;
    let k6 = f(
        t + h,
        plus(
            y,
            [
                (h * 9017.0 / 3168.0, k1),
                (h * -355.0 / 33.0, k2),
                (h * 46732.0 / 5247.0, k3),
                (h * 49.0 / 176.0, k4),
                (h * -5103.0 / 18656.0, k5),
            ],
        ),
    )?;
    let next = plus(
        y,
        [
            (h * 35.0 / 384.0, k1),
            (h * 500.0 / 1113.0, k3),
            (h * 125.0 / 192.0, k4),
            (h * -2187.0 / 6784.0, k5),
            (h * 11.0 / 84.0, k6),
        ],
    );
    let k7 = f(t + h, next)?;
    let difference = plus(
        [0.0; N],
        [
            (h * 71.0 / 57600.0, k1),
            (h * -71.0 / 16695.0, k3),
            (h * 71.0 / 1920.0, k4),
            (h * -17253.0 / 339200.0, k5),
            (h * 22.0 / 525.0, k6),
            (-h / 40.0, k7),
        ],
    );
    // NaN must not look like a small error, hence no `f64::max`.
    let error = difference.iter().fold(0.0, |m: f64, d| if d.abs() <= m { m } else { d.abs() });
    Ok((next, k7, error))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    /// Its solution from [0, 1] at t = 0 is [tan t, 1/cos^2 t].
    fn tangent(t: f64, y: [f64; 2]) -> Result<[f64; 2], Infallible> {
        // The explicit t makes a wrong node of a tableau show.
        Ok([1.0 + y[0] * y[0], 2.0 * y[1] * libm::tan(t)])
    }

    fn exact(t: f64) -> [f64; 2] {
        let c = libm::cos(t);
        [libm::tan(t), 1.0 / (c * c)]
    }

    /// Error at t = 1 after `steps` equal steps.
    fn error(steps: usize, advance: impl Fn(f64, [f64; 2], f64) -> [f64; 2]) -> f64 {
        let h = 1.0 / steps as f64;
        let y = (0..steps).fold([0.0, 1.0], |y, i| advance(i as f64 * h, y, h));
        let e = exact(1.0);
        (y[0] - e[0]).abs().max((y[1] - e[1]).abs())
    }

    fn order(steps: usize, advance: impl Fn(f64, [f64; 2], f64) -> [f64; 2]) -> f64 {
        libm::log2(error(steps, &advance) / error(2 * steps, &advance))
    }

    #[test]
    fn fixed_steps_converge_with_their_orders() {
        for (integrator, expected) in [(Integrator::Euler, 1.0), (Integrator::Midpoint, 2.0), (Integrator::Rk4, 4.0)] {
            let found = order(200, |t, y, h| integrator.advance(&tangent, t, y, h).unwrap());
            assert!((found - expected).abs() < 0.05, "{integrator:?}: {found}");
        }
    }

    #[test]
    fn the_embedded_pair_has_orders_5_and_4() {
        let step = |t, y, h| dormand_prince_step(&tangent, t, y, tangent(t, y).unwrap(), h).unwrap();
        let fifth = order(100, |t, y, h| step(t, y, h).0);
        assert!((fifth - 5.0).abs() < 0.1, "{fifth}");
        // The estimate of one step is the local error of a method of order 4: it falls as h^5.
        let estimate = |h| step(0.5, exact(0.5), h).2;
        let local = libm::log2(estimate(0.02) / estimate(0.01));
        assert!((local - 5.0).abs() < 0.1, "{local}");
    }

    #[test]
    fn adaptive_steps_keep_to_the_tolerance_in_both_directions() {
        for tolerance in [1e-6, 1e-9, 1e-12] {
            let integrator = Integrator::DormandPrince(tolerance);
            let forth = integrator.advance(&tangent, 0.0, [0.0, 1.0], 1.4).unwrap();
            // The tolerance bounds each of some dozens of steps, and an error at t = 0 grows 1 + tan(1.4)^2 = 34.6 times on
            // the way: within three decades.
            let off = (forth[0] - exact(1.4)[0]).abs();
            assert!(off < 1e3 * tolerance && off > 0.0, "{tolerance}: {off}");
            let back = integrator.advance(&tangent, 1.4, exact(1.4), -1.4).unwrap();
            assert!(back[0].abs() < 1e3 * tolerance, "{tolerance}: {}", back[0]);
        }
    }

    #[test]
    fn a_singularity_or_no_tolerance_stops_the_adaptive_steps() {
        // tan has its pole at 1.5708; the solution grows without bound before the end at 2.
        let stop = Integrator::DormandPrince(1e-9).advance(&tangent, 0.0, [0.0, 1.0], 2.0);
        assert_eq!(stop, Err(OdeError::NoProgress));
        for tolerance in [0.0, -1.0, f64::NAN] {
            let stop = Integrator::DormandPrince(tolerance).advance(&tangent, 0.0, [0.0, 1.0], 1.0);
            assert_eq!(stop, Err(OdeError::NoProgress));
        }
    }

    #[test]
    fn a_refused_point_is_handed_on() {
        let wall = |_, y: [f64; 1]| if y[0] < 0.5 { Ok([1.0]) } else { Err("wall") };
        for integrator in [Integrator::Midpoint, Integrator::Rk4, Integrator::DormandPrince(1e-6)] {
            assert_eq!(integrator.advance(&wall, 0.0, [0.0], 1.0), Err(OdeError::Refused("wall")));
        }
    }

    #[test]
    fn a_constant_slope_is_exact() {
        let f = |_, _| Ok::<_, Infallible>([2.0]);
        for integrator in [Integrator::Euler, Integrator::Midpoint, Integrator::Rk4, Integrator::DormandPrince(1e-12)] {
            let y = integrator.advance(&f, 0.0, [1.0], 3.0).unwrap();
            assert!((y[0] - 7.0).abs() < 1e-14);
        }
    }
}
