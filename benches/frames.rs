//! What a picture costs: `cargo bench --bench frames [-- --large]`.
//!
//! One table. Repetitions of all rows are interleaved, so that a busy minute of the machine falls on all of them. Times are
//! CPU times of one thread, but for the rows that say wall. The first row is a fixed kernel: a figure divided by the
//! kernel's, of the run right before it, can be compared with that of another machine, or of another hour. `--large` adds
//! pictures of up to 64 Mpx.

use biprism::accuracy::{Accuracy, Level};
use biprism::analysis::cost::{calibration, cpu_ms};
use biprism::effect::Effects;
use biprism::render::{Outputs, render_wanted};
use biprism::scene::{self, PrismSpec, Scene};
use biprism::system::{self, System};
use glam::DVec2;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::Instant;

const REPETITIONS: usize = 9;
/// A row is not repeated once it has taken this long altogether.
const PATIENCE_MS: f64 = 4000.0;
/// Rays of one run of the calibration kernel.
const CALIBRATION_RAYS: usize = 200_000;

struct Case {
    name: String,
    pixels: usize,
    /// Makes it and returns how many rays it took.
    work: Box<dyn Fn() -> u64 + Sync>,
    threads: usize,
    /// Whether the time that counts is that of the wall.
    wall: bool,
    ms: Vec<f64>,
    /// Of the kernel, right before each.
    calibration_ms: Vec<f64>,
    rays: u64,
}

fn main() {
    let large = std::env::args().any(|a| a == "--large");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let freeform = loaded(&root.join("scenes/paper.toml"));
    let mut flat = freeform.clone();
    if let PrismSpec::Freeform(biprism, _) = &freeform.prism {
        flat.prism = PrismSpec::Flat(*biprism);
    }
    let kernel = || {
        black_box(calibration(black_box(CALIBRATION_RAYS)));
        CALIBRATION_RAYS as u64
    };
    let mut cases = vec![Case::new("calibration: plain f64 flat trace", CALIBRATION_RAYS, kernel)];
    for (name, scene) in [("flat", &flat), ("degree 5", &freeform)] {
        cases.push(packets(format!("rays, {name}, packets"), scene));
        cases.push(single_rays(format!("rays, {name}, one by one"), scene));
    }
    for (name, scene) in [("flat", &flat), ("freeform", &freeform)] {
        for level in Level::ALL {
            for truth in [false, true] {
                let with = if truth { ", with ground truth" } else { "" };
                if level != Level::Reference || !truth {
                    cases.push(frame(format!("{name}, {}{with}", level.name()), scene, level.accuracy(), truth));
                }
            }
        }
    }
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    for level in [Level::Standard, Level::Exact] {
        for threads in [1, cores] {
            let name = format!("freeform, {}, wall, {threads} threads", level.name());
            cases.push(Case { threads, wall: true, ..frame(name, &freeform, level.accuracy(), false) });
        }
    }
    for path in effects(&root.join("scenes/cases")) {
        let scene = loaded(&path);
        let name = path.file_stem().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        let without = Scene { effects: Effects::default(), ..scene.clone() };
        for (with, scene) in [("on", &scene), ("off", &without)] {
            cases.push(frame(format!("{name}, {with}"), scene, Accuracy::standard(), false));
        }
    }
    let sizes: &[f64] = if large { &[0.1, 0.5, 2.0, 8.0, 32.0, 64.0] } else { &[0.1, 0.5, 2.0, 8.0] };
    for megapixels in sizes {
        for level in [Level::Draft, Level::Standard, Level::Exact] {
            let scene = resized(&flat, *megapixels);
            cases.push(frame(format!("flat, {}, {megapixels} Mpx", level.name()), &scene, level.accuracy(), false));
        }
    }
    measure(&mut cases);
    print(&mut cases);
}

fn loaded(path: &Path) -> Scene {
    scene::load(path).unwrap_or_else(|problem| panic!("{problem}"))
}

fn built(scene: &Scene, accuracy: Accuracy) -> System {
    let built = system::build(scene).unwrap_or_else(|problem| panic!("{problem}"));
    built.with_accuracy(accuracy)
}

/// The scenes of single effects, by name.
fn effects(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut paths: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    paths.retain(|path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("effect_")));
    paths.sort();
    paths
}

/// The scene on a sensor of the same size with another number of pixels, each way a multiple of 16.
fn resized(scene: &Scene, megapixels: f64) -> Scene {
    let mut scene = scene.clone();
    let camera = &mut scene.camera;
    let width_mm = camera.width_px as f64 * camera.pitch_mm;
    let scale = (megapixels * 1e6 / (camera.width_px * camera.height_px) as f64).sqrt();
    let size = |n: usize| ((n as f64 * scale / 16.0).round() as usize).max(1) * 16;
    (camera.width_px, camera.height_px) = (size(camera.width_px), size(camera.height_px));
    camera.pitch_mm = width_mm / camera.width_px as f64;
    scene
}

impl Case {
    fn new(name: impl Into<String>, pixels: usize, work: impl Fn() -> u64 + Sync + 'static) -> Self {
        Self {
            name: name.into(),
            pixels,
            work: Box::new(work),
            threads: 1,
            wall: false,
            ms: Vec::new(),
            calibration_ms: Vec::new(),
            rays: 0,
        }
    }
}

/// The picture of a scene.
fn frame(name: String, scene: &Scene, accuracy: Accuracy, truth: bool) -> Case {
    let system = built(scene, accuracy);
    Case::new(name, scene.camera.width_px * scene.camera.height_px, move || {
        let film = render_wanted(&system, Outputs { truth }, &());
        black_box(&film.radiance);
        film.counts.rays
    })
}

/// Every pixel's ray by packets, and next to nothing else: one white square fills the view.
fn packets(name: String, scene: &Scene) -> Case {
    let mut plain = scene.clone();
    (plain.board.columns, plain.board.rows, plain.board.square_mm) = (3, 3, 1e4);
    frame(name, &plain, Accuracy::exact(), false)
}

/// Every fourth pixel's ray each way, by the scalar trace.
fn single_rays(name: String, scene: &Scene) -> Case {
    let system = built(scene, Accuracy::exact());
    let [width, height] = system.camera().size_px().map(|n| n / 4);
    Case::new(name, width * height, move || {
        let px = |k: usize| DVec2::new((4 * (k % width)) as f64 + 0.5, (4 * (k / width)) as f64 + 0.5);
        let seen: f64 = (0..width * height).filter_map(|k| system.trace(px(k)).ok()).map(|s| s.board_mm.x).sum();
        black_box(seen);
        (width * height) as u64
    })
}

fn measure(cases: &mut [Case]) {
    let pools: Vec<rayon::ThreadPool> = cases
        .iter()
        .map(|case| rayon::ThreadPoolBuilder::new().num_threads(case.threads).build().expect("threads start"))
        .collect();
    for _ in 0..REPETITIONS {
        for (case, pool) in cases.iter_mut().zip(&pools) {
            if case.ms.iter().sum::<f64>() >= PATIENCE_MS {
                continue;
            }
            let kernel = || cpu_ms(|| black_box(calibration(black_box(CALIBRATION_RAYS)))).0;
            case.calibration_ms.push(pool.install(kernel));
            let work = &case.work;
            let (ms, rays) = if case.wall {
                let start = Instant::now();
                let rays = pool.install(work);
                (start.elapsed().as_secs_f64() * 1e3, rays)
            } else {
                pool.install(|| cpu_ms(work))
            };
            case.ms.push(ms);
            case.rays = rays;
        }
    }
}

fn print(cases: &mut [Case]) {
    println!(
        "{:42} {:>4} {:>9} {:>9} {:>9} {:>9} {:>8} {:>9}",
        "", "runs", "min ms", "median ms", "p90 ms", "ns/px", "Mray/s", "per calib"
    );
    for case in cases {
        let ratio = |(ms, kernel): (&f64, &f64)| (ms / case.pixels as f64) / (kernel / CALIBRATION_RAYS as f64);
        let mut ratios: Vec<f64> = case.ms.iter().zip(&case.calibration_ms).map(ratio).collect();
        ratios.sort_by(f64::total_cmp);
        case.ms.sort_by(f64::total_cmp);
        let n = case.ms.len();
        let (median, p90) = (case.ms[n / 2], case.ms[(9 * n / 10).min(n - 1)]);
        println!(
            "{:42} {n:4} {:9.3} {median:9.3} {p90:9.3} {:9.3} {:8.1} {:9.3}",
            case.name,
            case.ms[0],
            median * 1e6 / case.pixels as f64,
            case.rays as f64 / median * 1e-3,
            ratios[n / 2],
        );
    }
    println!(
        "ns/px, Mray/s: of the median, the latter of all rays that were traced; per calib: time of a pixel over that of a ray \
         of the calibration kernel run right before, median"
    );
}
