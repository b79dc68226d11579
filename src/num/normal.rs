//! The normal distribution.

use std::f64::consts::{SQRT_2, TAU};

/// The number below which a standard normal one lies with probability `p`, for 0 < p < 1.
///
/// Hastings' approximation for a start, right to 4.5e-4 (Abramowitz & Stegun, 26.2.23), then Halley's method on the error
/// function, which cubes the error in each step.
pub fn quantile(p: f64) -> f64 {
    // From the tail that p lies in, whose probabilities have all their digits.
    if p > 0.5 {
        return -quantile(1.0 - p);
    }
    let t = (-2.0 * libm::log(p)).sqrt();
    let below = 2.515_517 + t * (0.802_853 + t * 0.010_328);
    let mut x = below / (1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308))) - t;
    for _ in 0..3 {
        let below = 0.5 * libm::erfc(-x / SQRT_2);
        let density = libm::exp(-0.5 * x * x) / TAU.sqrt();
        let step = (below - p) / density;
        x -= step / (1.0 + 0.5 * x * step);
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        // Abramowitz & Stegun, table 26.5, and symmetry.
        for (p, x) in
            [(0.5, 0.0), (0.975, 1.959_963_984_540_054), (0.999, 3.090_232_306_167_814), (1e-6, -4.753_424_308_822_899)]
        {
            assert!((quantile(p) - x).abs() < 1e-14 * (1.0 + x.abs() / p.min(1.0 - p) * 1e-2), "{p}: {}", quantile(p));
            assert!((quantile(1.0 - p) + quantile(p)).abs() < 1e-9);
        }
    }

    #[test]
    fn the_error_function_brings_them_back() {
        for k in 1..2000 {
            let p = f64::from(k) / 2000.0;
            let back = 0.5 * libm::erfc(-quantile(p) / SQRT_2);
            assert!((back - p).abs() < 4.0 * f64::EPSILON, "{p}: {back}");
        }
        for tail in [1e-4, 1e-8, 1e-15] {
            let back = 0.5 * libm::erfc(-quantile(tail) / SQRT_2);
            assert!((back / tail - 1.0).abs() < 1e-13, "{tail}: {back}");
        }
    }
}
