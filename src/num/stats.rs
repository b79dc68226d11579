//! Mean, root mean square and quantiles, summed in a fixed order.

/// The mean; 0 of nothing.
pub fn mean(values: &[f64]) -> f64 {
    if values.is_empty() { 0.0 } else { values.iter().sum::<f64>() / values.len() as f64 }
}

/// The root of the mean square; 0 of nothing.
pub fn rms(values: &[f64]) -> f64 {
    if values.is_empty() { 0.0 } else { (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt() }
}

/// The largest magnitude; 0 of nothing.
pub fn max_abs(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m: f64, v| m.max(v.abs()))
}

/// The `q`-quantile (0..=1) by linear interpolation between order statistics; `None` of nothing.
pub fn quantile(values: &[f64], q: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    let place = q.clamp(0.0, 1.0) * last as f64;
    let below = place.floor() as usize;
    let above = (below + 1).min(last);
    Some(sorted[below] + (sorted[above] - sorted[below]) * (place - below as f64))
}

/// The number that a standard normal one exceeds with the given probability, below 1/2 and above 1e-300.
pub fn normal_beyond(probability: f64) -> f64 {
    let (mut low, mut high) = (0.0, 40.0);
    // Each step halves the interval: 2^-60 of 40.
    for _ in 0..60 {
        let middle: f64 = 0.5 * (low + high);
        let tail = 0.5 * libm::erfc(middle / std::f64::consts::SQRT_2);
        if tail > probability { low = middle } else { high = middle }
    }
    low
}

/// The number that Student's t of `freedom` degrees exceeds as seldom as a standard normal one exceeds `z` (M.
/// Abramowitz, I. Stegun, Handbook of Mathematical Functions, 26.7.5, to the third term).
pub(crate) fn student_beyond(z: f64, freedom: f64) -> f64 {
    let s = z * z;
    let terms =
        [(s + 1.0) / 4.0, ((5.0 * s + 16.0) * s + 3.0) / 96.0, (((3.0 * s + 19.0) * s + 17.0) * s - 15.0) / 384.0];
    z * (1.0 + (terms[0] + (terms[1] + terms[2] / freedom) / freedom) / freedom)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tables 26.1 and 26.10 of Abramowitz and Stegun.
    #[test]
    fn tails_agree_with_printed_tables() {
        for (probability, z) in [(0.5, 0.0), (0.025, 1.959_963_984_540_054), (2.866_515_718_8e-7, 5.0)] {
            assert!((normal_beyond(probability) - z).abs() < 1e-9, "{probability}");
        }
        // Student's t beyond which 0.5 % and 0.05 % lie; the expansion stops at freedom^-3.
        for (probability, freedom, t) in [(0.005, 30.0, 2.750), (0.005, 120.0, 2.617), (0.0005, 60.0, 3.460)] {
            assert!((student_beyond(normal_beyond(probability), freedom) - t).abs() < 6e-4, "{probability} {freedom}");
        }
    }

    #[test]
    fn median_of_an_even_count_lies_between_the_middle_two() {
        assert_eq!(quantile(&[4.0, 1.0, 3.0, 2.0], 0.5), Some(2.5));
        assert_eq!(quantile(&[], 0.5), None);
    }

    #[test]
    fn rms_of_three_and_four() {
        assert!((rms(&[3.0, -4.0]) - 12.5f64.sqrt()).abs() < 1e-15);
    }
}
