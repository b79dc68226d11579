//! The clock.

use crate::progress::Observer;
use std::hint::black_box;

/// Rays of one run of the calibration kernel.
pub(super) const CALIBRATION_RAYS: usize = 200_000;

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
}

/// Threads on which wall time is CPU time: one.
pub(super) fn one_thread() -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a machine that runs this has a thread to give")
}

/// CPU time of this thread since some moment, in ms: what other programs take of the processor meanwhile is not in it, but
/// for what they do to its caches and its clock.
#[cfg(target_os = "linux")]
fn now_ms() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 * 1e3 + time.tv_nsec as f64 * 1e-6
}

/// Wall time, where the system is not asked for CPU time.
#[cfg(not(target_os = "linux"))]
fn now_ms() -> f64 {
    static START: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    START.get_or_init(std::time::Instant::now).elapsed().as_secs_f64() * 1e3
}

/// CPU time that `work` takes on this thread, in ms, and its result. Work that goes to other threads is not counted.
pub fn cpu_ms<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let start = now_ms();
    let result = work();
    (now_ms() - start, result)
}

/// CPU time of one run of the yardstick, in ms.
fn yardstick_ms() -> f64 {
    cpu_ms(|| black_box(calibration(black_box(CALIBRATION_RAYS)))).0
}

/// The times of something that was repeated.
#[derive(Debug, Clone, Default)]
pub(super) struct Taken {
    /// In ms.
    pub(super) ms: Vec<f64>,
    /// Of the yardstick, right before each, in ms.
    pub(super) yardstick_ms: Vec<f64>,
}

impl Taken {
    /// Runs `work` once more.
    pub(super) fn again<T>(&mut self, work: impl FnOnce() -> T) -> T {
        self.yardstick_ms.push(yardstick_ms());
        let (ms, result) = cpu_ms(work);
        self.ms.push(ms);
        result
    }

    /// The times, in ms, times `factor`.
    pub(super) fn spread_ms(&self, factor: f64) -> Spread {
        Spread::of(&self.ms.iter().map(|ms| factor * ms).collect::<Vec<f64>>())
    }

    /// The times as multiples of `rays` rays of the yardstick, each of the one right before it.
    pub(super) fn in_yardsticks(&self, rays: f64) -> Spread {
        let scale = CALIBRATION_RAYS as f64 / rays;
        let ratios: Vec<f64> = self.ms.iter().zip(&self.yardstick_ms).map(|(ms, yard)| scale * ms / yard).collect();
        Spread::of(&ratios)
    }
}

/// The yardstick itself, over all its runs: ns a ray.
pub(super) fn yardstick_ns(times: &[Taken]) -> Spread {
    let runs = times.iter().flat_map(|taken| &taken.yardstick_ms);
    Spread::of(&runs.map(|ms| 1e6 * ms / CALIBRATION_RAYS as f64).collect::<Vec<f64>>())
}

/// Jobs shorter than this are run once more, untimed, right before each timing.
const WARM_BELOW_MS: f64 = 200.0;

/// Something that is timed.
pub(super) type Job<'a> = Box<dyn Fn() + Sync + 'a>;

/// The times of all jobs, each taken once a repetition; those that have taken longer than `patience_s` altogether sit out.
/// `observer` hears how many jobs are done.
pub(super) fn interleaved(
    jobs: &[Job<'_>],
    repetitions: usize,
    patience_s: f64,
    observer: &dyn Observer,
) -> Vec<Taken> {
    let mut times = vec![Taken::default(); jobs.len()];
    for _ in 0..repetitions.max(1) {
        for (job, taken) in jobs.iter().zip(&mut times) {
            if taken.ms.iter().sum::<f64>() < 1e3 * patience_s {
                // What the job before left in the caches and gave back to the system is no part of this one.
                if taken.ms.iter().all(|ms| *ms < WARM_BELOW_MS) {
                    job();
                }
                taken.again(job);
            }
            observer.pixels(1);
        }
    }
    times
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
            let seen = system.trace(px).expect("in view").board_mm;
            seen.x + seen.y
        };
        let expected: f64 = (0..2000).map(look).sum();
        // SIN and COS are given to 1e-9, over 900 mm and 2000 rays.
        assert!((calibration(2000) - expected).abs() < 2000.0 * 900.0 * 2e-9, "{} {expected}", calibration(2000));
    }

    #[test]
    fn the_impatient_sits_out() {
        let slow = || {
            black_box(calibration(black_box(100 * CALIBRATION_RAYS)));
        };
        let jobs: Vec<Job> = vec![Box::new(slow), Box::new(|| ())];
        let times = interleaved(&jobs, 4, 0.05, &());
        assert_eq!((times[0].ms.len(), times[1].yardstick_ms.len()), (1, 4));
        let (time, ratio) = (times[0].spread_ms(1.0), times[0].in_yardsticks(CALIBRATION_RAYS as f64));
        assert!(time.min > 0.0 && time.min <= time.median && time.median <= time.p90);
        // A hundred yardsticks; half and twice leave room for a clock that changes its speed.
        assert!((50.0..200.0).contains(&ratio.median), "{ratio:?}");
    }
}
