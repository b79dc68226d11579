//! The clock.

use std::time::Instant;

/// Rays of one run of the calibration kernel.
pub(super) const CALIBRATION_RAYS: usize = 500_000;

/// How long something took, over its repetitions.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Spread {
    /// The shortest.
    pub min: f64,
    /// The median.
    pub median: f64,
    /// Nine of ten took less.
    pub p90: f64,
    /// Repetitions.
    pub n: usize,
}

impl Spread {
    /// Of at least one time.
    pub(super) fn of(times: &[f64]) -> Self {
        let quantile = |q: f64| crate::num::stats::quantile(times, q).unwrap_or(f64::NAN);
        Self { min: quantile(0.0), median: quantile(0.5), p90: quantile(0.9), n: times.len() }
    }

    /// In another unit.
    pub(super) fn scaled(self, factor: f64) -> Self {
        Self { min: self.min * factor, median: self.median * factor, p90: self.p90 * factor, n: self.n }
    }
}

/// Threads on which wall time is CPU time: one.
pub(super) fn one_thread() -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a machine that runs this has a thread to give")
}

/// How long `work` takes, in ms, and its result.
pub(super) fn timed<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let start = Instant::now();
    let result = work();
    (start.elapsed().as_secs_f64() * 1e3, result)
}

/// The times of all `makers` in ms, each taken once a repetition; those that have taken longer than `patience_s`
/// altogether sit out.
pub(super) fn interleaved(makers: &[Box<dyn Fn() + Sync + '_>], repetitions: usize, patience_s: f64) -> Vec<Spread> {
    let mut times = vec![Vec::new(); makers.len()];
    for _ in 0..repetitions.max(1) {
        for (maker, taken) in makers.iter().zip(&mut times) {
            if taken.iter().sum::<f64>() < 1e3 * patience_s {
                taken.push(timed(maker).0);
            }
        }
    }
    times.iter().map(|t| Spread::of(t)).collect()
}

/// The yardstick: `rays` rays of plain scalar code through the flat biprism of the design paper to a board 1 m away, in
/// f64, without the code of this program. Returns the sum of where they land, so that nothing is left out.
pub fn calibration(rays: usize) -> f64 {
    const INDEX: f64 = 1.48;
    // sin and cos of the facet's angle, 8.85428 deg.
    const SIN: f64 = 0.153_921_980;
    const COS: f64 = 0.988_083_005;
    let mut sum = 0.0;
    for k in 0..rays {
        // Field tangents over the right half of the sensor.
        let (i, j) = ((k % 960) as f64 + 0.5, ((k / 960) % 1080) as f64 - 539.5);
        let (tx, ty) = (i * (0.0055 / 35.0), j * (0.0055 / 35.0));
        let length = (tx * tx + ty * ty + 1.0).sqrt();
        let (x, y, z) = (tx / length, ty / length, 1.0 / length);
        // The facet through (0, 0, 78.472) of normal (-SIN, 0, COS).
        let along = COS * z - SIN * x;
        let t = 78.472 * COS / along;
        let (px, py, pz) = (x * t, y * t, z * t);
        let eta = 1.0 / INDEX;
        let gamma = (1.0 - eta * eta * (1.0 - along * along)).sqrt() - eta * along;
        let (x, y, z) = (eta * x - gamma * SIN, eta * y, eta * z + gamma * COS);
        // The base at z = 87.017, then the board.
        let t = (87.017 - pz) / z;
        let (px, py) = (px + x * t, py + y * t);
        let gamma = (1.0 - INDEX * INDEX * (1.0 - z * z)).sqrt();
        let t = (1000.0 - 87.017) / gamma;
        sum += (px + INDEX * x * t) + (py + INDEX * y * t);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The yardstick is a trace: it lands where the simulator lands.
    #[test]
    fn the_yardstick_traces_the_papers_flat_prism() {
        let text = "name = \"flat\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = 1920\nheight_px = 1080\n\
             pixel_pitch_um = 5.5\n[prism]\nkind = \"flat\"\nindex = 1.48\nridge_distance_mm = 78.472\n\
             thickness_mm = 8.545\nfacet_angle_deg = 8.85428\n\
             [board]\ncolumns = 41\nrows = 41\nsquare_mm = 10.0\nposition_mm = [0.0, 0.0, 1000.0]\n";
        let scene = crate::scene::parse(text, "test", None).expect("a right scene");
        let system = crate::system::build(&scene).expect("it can be built");
        let look = |k: usize| {
            let px = glam::DVec2::new(960.5 + (k % 960) as f64, 0.5 + (k / 960) as f64);
            let seen = system.look(px).expect("in view").board_mm;
            seen.x + seen.y
        };
        let expected: f64 = (0..2000).map(look).sum();
        // SIN and COS are given to 1e-9, over 900 mm and 2000 rays.
        assert!((calibration(2000) - expected).abs() < 2000.0 * 900.0 * 2e-9, "{} {expected}", calibration(2000));
    }

    #[test]
    fn the_impatient_sits_out() {
        let slow = || std::thread::sleep(std::time::Duration::from_millis(3));
        let makers: Vec<Box<dyn Fn() + Sync>> = vec![Box::new(slow), Box::new(|| ())];
        let times = interleaved(&makers, 4, 0.002);
        assert_eq!((times[0].n, times[1].n), (1, 4));
        assert!(times[0].min >= 3.0 && times[0].median <= times[0].p90);
    }
}
