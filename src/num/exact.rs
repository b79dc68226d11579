//! Floating-point operations that keep what ordinary rounding would lose.

/// a b as its rounded value and the rounding error: their sum is exact (Dekker 1971, "A floating-point technique for
/// extending the available precision"). Without a fused multiply-add, it has the same bits on every machine. Valid while
/// nothing overflows or underflows.
#[inline]
pub(crate) fn two_product(a: f64, b: f64) -> (f64, f64) {
    let p = a * b;
    let (ah, al) = split(a);
    let (bh, bl) = split(b);
    (p, ((ah * bh - p) + ah * bl + al * bh) + al * bl)
}

/// a + b as its rounded value and the rounding error: their sum is exact (Knuth, TAOCP 2, 4.2.2).
#[inline]
pub(crate) fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let s = a + b;
    let from_b = s - a;
    (s, (a - (s - from_b)) + (b - from_b))
}

/// The sum of `terms` as if added with four times the digits and rounded once (Ogita, Rump & Oishi, SIAM J. Sci. Comput.
/// 26 (2005) 1955, SumK).
pub fn sum<const N: usize>(mut terms: [f64; N]) -> f64 {
    for _ in 1..4 {
        for i in 1..N {
            (terms[i], terms[i - 1]) = two_sum(terms[i], terms[i - 1]);
        }
    }
    terms.iter().sum()
}

/// a as the sum of two numbers of 26 bits each (Veltkamp).
fn split(a: f64) -> (f64, f64) {
    let c = 134_217_729.0 * a;
    let high = c - (c - a);
    (high, a - high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sum_and_its_error_are_exact() {
        assert_eq!(two_sum(1.0, 1e-30), (1.0, 1e-30));
        assert_eq!(two_sum(1e-30, 1.0), (1.0, 1e-30));
        assert_eq!(two_sum(1.0, f64::EPSILON / 2.0), (1.0, f64::EPSILON / 2.0));
    }

    #[test]
    fn what_is_left_of_a_sum_keeps_its_digits() {
        let e = f64::EPSILON;
        assert_eq!(sum([1.0, -1.0 - e, e, e * e * e, 2.0 * e * e * e]), 3.0 * e * e * e);
        // With three times the digits nothing would be left.
        let e = 0.5 * f64::EPSILON;
        assert_eq!(sum([-1.25 * e, e * e, 1.0, e * e * e, -2.0, 1.25 * e, 1.0, -e * e]), e * e * e);
    }

    #[test]
    fn a_product_and_its_error_are_exact() {
        // (1 + e)(1 - e) = 1 - e^2, of which f64 keeps the 1.
        let e = f64::EPSILON;
        assert_eq!(two_product(1.0 + e, 1.0 - e), (1.0, -e * e));
    }
}
