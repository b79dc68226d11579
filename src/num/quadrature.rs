//! Integrals as weighted sums.

/// The nodes in (0, 1) and weights of the rule of Gauss and Legendre with `n` nodes: exact for polynomials of degree
/// 2n - 1. Roots of the Legendre polynomial by Newton's method from Tricomi's estimate (Press et al., Numerical Recipes,
/// 4.6).
pub fn gauss_legendre(n: usize) -> Vec<[f64; 2]> {
    let mut rule = vec![[0.0; 2]; n];
    for i in 0..n.div_ceil(2) {
        let mut x = libm::cos(std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5));
        let mut slope = 1.0;
        // Newton's steps square the error of the estimate, about 1e-3: five leave nothing.
        for _ in 0..5 {
            let (mut p, mut before) = (1.0, 0.0);
            for k in 0..n {
                let k = k as f64;
                (p, before) = (((2.0 * k + 1.0) * x * p - k * before) / (k + 1.0), p);
            }
            slope = n as f64 * (x * p - before) / (x * x - 1.0);
            x -= p / slope;
        }
        let weight = 1.0 / ((1.0 - x * x) * slope * slope);
        rule[i] = [0.5 * (1.0 - x), weight];
        rule[n - 1 - i] = [0.5 * (1.0 + x), weight];
    }
    rule
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn monomials_up_to_twice_the_count_are_exact() {
        for n in [1, 2, 3, 8, 33, 200] {
            for power in [0, 1, n, 2 * n - 1] {
                let sum: f64 = gauss_legendre(n).iter().map(|[x, w]| w * libm::pow(*x, power as f64)).sum();
                // n terms of size up to 1/n, each rounded a few times.
                assert!((sum * (power as f64 + 1.0) - 1.0).abs() < 1e-13 * n as f64, "{n} {power}: {sum}");
            }
        }
    }
}
