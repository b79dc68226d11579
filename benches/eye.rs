//! What the measuring eye costs: `cargo bench --bench eye`, in ms of CPU time, best and median of 15 runs.
//!
//! A picture of 1920 x 1080 whose two halves show a bent board of 72 px squares each, some 200 corners to a half, is
//! measured on one thread: without noise, with noise, with blur and noise; candidates, growth and fit apart. Runs of all
//! are interleaved with those of a fixed kernel, whose multiple can be compared with that of another machine or hour.

#[path = "../tests/common/mod.rs"]
mod common;

use biprism::analysis::cost::calibration;
use biprism::raster::Raster;
use biprism::vision::half::{HalfImage, split};
use biprism::vision::{Settings, find_candidates, grow, measure};
use common::board::{Noise, Scene};
use glam::DVec2;
use std::hint::black_box;
use std::time::Instant;

/// Runs of each.
const RUNS: usize = 15;
/// Rays of one run of the calibration kernel.
const CALIBRATION_RAYS: usize = 1_000_000;
/// Name, blur in px, noise as a share of full scale.
const PICTURES: [(&str, f64, f64); 3] =
    [("sharp", 0.0, 0.0), ("sharp, 2 % noise", 0.0, 0.02), ("blur 0.7 px, 2 % noise", 0.7, 0.02)];

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

/// The ms of CPU time that `f` takes on this thread, where the system tells it (Linux), else of wall-clock time: a busy
/// machine must not make the eye look slow. And what it makes.
fn clock<T>(f: impl FnOnce() -> T) -> (f64, T) {
    let (start, cpu) = (Instant::now(), cpu_ms());
    let made = black_box(f());
    let ms = match cpu_ms().zip(cpu) {
        Some((end, start)) => end - start,
        None => start.elapsed().as_secs_f64() * 1e3,
    };
    (ms, made)
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

/// The times of candidates, growth and fit over both halves, in ms, and the corners.
fn run(halves: &[HalfImage<f32>; 2], settings: &Settings) -> ([f64; 3], usize) {
    let (mut ms, mut corners) = ([0.0; 3], 0);
    for half in halves {
        let (candidates, found_candidates) = clock(|| find_candidates(&half.image, None));
        let (growth, lattices) = clock(|| grow(&found_candidates, settings));
        let (fit, found) = clock(|| measure(&found_candidates, lattices, settings));
        ms.iter_mut().zip([candidates, growth, fit]).for_each(|(sum, one)| *sum += one);
        corners += found.corners.len();
    }
    (ms, corners)
}

/// Best and median.
fn spread(ms: impl Iterator<Item = f64>) -> [f64; 2] {
    let mut ms: Vec<f64> = ms.collect();
    ms.sort_by(f64::total_cmp);
    [ms[0], ms[ms.len() / 2]]
}

fn main() {
    // All on this thread, whose time is taken.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread();
    pool.build_global().expect("the pool is built once");
    let settings = Settings::default();
    let pictures = PICTURES.map(|(_, sigma_px, noise)| split(&picture(sigma_px, noise)));
    let mut yardstick = Vec::new();
    let mut runs: [Vec<([f64; 3], usize)>; PICTURES.len()] = Default::default();
    for _ in 0..RUNS {
        yardstick.push(clock(|| calibration(black_box(CALIBRATION_RAYS))).0);
        for (halves, runs) in pictures.iter().zip(&mut runs) {
            runs.push(run(halves, &settings));
        }
    }
    let [best, median] = spread(yardstick.into_iter());
    println!("{:34} {:>8} {:>8} {:>9}", "", "best ms", "median", "per calib");
    let print = |name: &str, [low, middle]: [f64; 2]| {
        println!("{name:34} {low:8.1} {middle:8.1} {:9.2}", middle / median);
    };
    print("calibration: plain f64 flat trace", [best, median]);
    for ((name, ..), runs) in PICTURES.iter().zip(&runs) {
        println!("{name}, {} corners", runs[0].1);
        for (k, part) in ["candidates", "growth", "fit"].into_iter().enumerate() {
            print(&format!("  {part}"), spread(runs.iter().map(|(ms, _)| ms[k])));
        }
        print("  all", spread(runs.iter().map(|(ms, _)| ms.iter().sum())));
    }
    println!("per calib: median over that of {CALIBRATION_RAYS} rays of the calibration kernel in the same run");
}
