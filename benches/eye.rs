//! What the measuring eye costs: `cargo bench --bench eye`, in ms of CPU time, best and median of 15 runs.
//!
//! A picture of 1920 x 1080 whose two halves show a bent board of 72 px squares each, some 200 corners to a half, is
//! measured on one thread: without noise, with noise, with blur and noise.

#[path = "../tests/common/mod.rs"]
mod common;

use biprism::raster::Raster;
use biprism::vision::half::{HalfImage, split};
use biprism::vision::{Settings, detect, grow, look, measure};
use common::board::{Noise, Scene};
use glam::DVec2;
use std::hint::black_box;
use std::time::Instant;

/// Runs of each part.
const RUNS: usize = 15;

fn picture(sigma_px: f64, noise: f64) -> Raster<f32> {
    let half = |shift: f64| Scene {
        sigma_px,
        bend_px: DVec2::new(6.0, 5.0),
        ..Scene::view(960, 1080, 72.0, 2.0, 4.0, DVec2::new(shift, -4.63))
    };
    let [left, right] = [half(3.25), half(11.4)].map(|scene| Noise::new(1).added(&scene.render(), noise));
    let rows = (0..1080).flat_map(|j| left.row(j).iter().chain(right.row(j)).copied().collect::<Vec<_>>());
    Raster::from_data(1920, 1080, rows.collect())
}

fn time(name: &str, halves: &[HalfImage<f32>; 2], part: impl Fn(&HalfImage<f32>) -> f64) {
    let mut runs: Vec<f64> = (0..RUNS).map(|_| halves.iter().map(&part).sum::<f64>()).collect();
    runs.sort_by(f64::total_cmp);
    println!("  {name:12} {:7.1} {:7.1}", runs[0], runs[RUNS / 2]);
}

/// The ms of CPU time that `f` takes on this thread, where the system tells it (Linux), else of wall-clock time: a busy
/// machine must not make the eye look slow.
fn clock<T>(f: impl FnOnce() -> T) -> f64 {
    let (start, cpu) = (Instant::now(), cpu_ms());
    black_box(f());
    match cpu_ms().zip(cpu) {
        Some((end, start)) => end - start,
        None => start.elapsed().as_secs_f64() * 1e3,
    }
}

/// CPU time of this thread so far, in ms.
fn cpu_ms() -> Option<f64> {
    #[cfg(target_os = "linux")]
    {
        let t = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
        Some(t.tv_sec as f64 * 1e3 + t.tv_nsec as f64 * 1e-6)
    }
    #[cfg(not(target_os = "linux"))]
    None
}

fn main() {
    // All on this thread, whose time is taken.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread();
    pool.build_global().expect("the pool is built once");
    let settings = Settings::default();
    for (name, sigma_px, noise) in
        [("sharp", 0.0, 0.0), ("sharp, 2 % noise", 0.0, 0.02), ("blur 0.7, 2 % noise", 0.7, 0.02)]
    {
        let halves = split(&picture(sigma_px, noise));
        let corners: usize = halves.iter().map(|half| detect(&half.image, None, &settings).corners.len()).sum();
        println!("{name}: {corners} corners           best  median ms");
        time("candidates", &halves, |half| clock(|| look(&half.image, None)));
        time("growth", &halves, |half| {
            let sight = look(&half.image, None);
            clock(|| grow(&sight, &settings))
        });
        time("fit", &halves, |half| {
            let sight = look(&half.image, None);
            let lattices = grow(&sight, &settings);
            clock(|| measure(&sight, lattices, &settings))
        });
        time("all", &halves, |half| clock(|| detect(&half.image, None, &settings)));
    }
}
