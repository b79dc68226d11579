//! What a picture costs: `cargo bench --bench frames [-- --large]`.
//!
//! One table. Repetitions of all rows are interleaved, so that a busy minute of the machine falls on all of them; minimum
//! and median are of CPU time, that is wall time on one thread. The first row is a fixed kernel: a figure divided by the
//! kernel's can be compared with that of another machine, or of another hour. `--large` adds pictures of up to 64 Mpx.

use biprism::accuracy::Level;
use biprism::analysis::cost::calibration;
use biprism::render::{Wanted, render_wanted};
use biprism::scene::{self, Prism, Scene};
use biprism::system::{self, System};
use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

const REPETITIONS: usize = 15;
/// Rays of one run of the calibration kernel.
const CALIBRATION_RAYS: usize = 1_000_000;

struct Case {
    name: String,
    pixels: usize,
    threads: usize,
    run: Box<dyn Fn() -> u64>,
    ms: Vec<f64>,
    rays: u64,
}

fn main() {
    let large = std::env::args().any(|a| a == "--large");
    let paper = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/paper.toml");
    let freeform = scene::load(&paper).unwrap_or_else(|problem| panic!("{problem}"));
    let mut flat = freeform.clone();
    if let Prism::Freeform(biprism, _) = &freeform.prism {
        flat.prism = Prism::Flat(*biprism);
    }
    let mut cases = vec![Case {
        name: "calibration: plain f64 flat trace".to_owned(),
        pixels: CALIBRATION_RAYS,
        threads: 1,
        run: Box::new(|| {
            black_box(calibration(black_box(CALIBRATION_RAYS)));
            CALIBRATION_RAYS as u64
        }),
        ms: Vec::new(),
        rays: 0,
    }];
    for (name, scene) in [("flat", &flat), ("freeform", &freeform)] {
        for level in [Level::Draft, Level::Standard, Level::Exact] {
            for truth in [false, true] {
                let with = if truth { ", with ground truth" } else { "" };
                cases.push(case(format!("{name}, {}{with}", level.name()), scene, level, truth, 1));
            }
        }
    }
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    for level in [Level::Standard, Level::Exact] {
        cases.push(case(format!("freeform, {}, all cores (wall)", level.name()), &freeform, level, false, cores));
    }
    let sizes: &[f64] = if large { &[0.1, 0.5, 8.0, 32.0, 64.0] } else { &[0.1, 0.5, 8.0] };
    for megapixels in sizes {
        for level in [Level::Standard, Level::Exact] {
            if level == Level::Exact && *megapixels > 8.0 {
                continue;
            }
            let scene = resized(&flat, *megapixels);
            cases.push(case(format!("flat, {}, {megapixels} Mpx", level.name()), &scene, level, false, 1));
        }
    }
    measure(&mut cases);
    print(&mut cases);
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

fn case(name: String, scene: &Scene, level: Level, truth: bool, threads: usize) -> Case {
    let built = system::build(scene).unwrap_or_else(|problem| panic!("{problem}"));
    let system = System { accuracy: level.accuracy(), ..built };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
    let run = move || {
        let film = pool.install(|| render_wanted(&system, Wanted { truth }, &|_| ()));
        black_box(&film.radiance);
        film.counts.rays
    };
    let pixels = scene.camera.width_px * scene.camera.height_px;
    Case { name, pixels, threads, run: Box::new(run), ms: Vec::new(), rays: 0 }
}

fn measure(cases: &mut [Case]) {
    for _ in 0..REPETITIONS {
        for case in cases.iter_mut() {
            let start = Instant::now();
            case.rays = (case.run)();
            case.ms.push(start.elapsed().as_secs_f64() * 1e3);
        }
    }
}

fn print(cases: &mut [Case]) {
    println!(
        "{:44} {:>3} {:>9} {:>9} {:>9} {:>8} {:>9}",
        "", "thr", "min ms", "median ms", "ns/px", "Mray/s", "per calib"
    );
    let mut calibration_ns = 1.0;
    for (k, case) in cases.iter_mut().enumerate() {
        case.ms.sort_by(f64::total_cmp);
        let (min, median) = (case.ms[0], case.ms[case.ms.len() / 2]);
        let ns = min * 1e6 / case.pixels as f64;
        if k == 0 {
            calibration_ns = ns;
        }
        println!(
            "{:44} {:3} {min:9.2} {median:9.2} {ns:9.2} {:8.1} {:9.3}",
            case.name,
            case.threads,
            case.rays as f64 / min * 1e-3,
            ns / calibration_ns,
        );
    }
    println!(
        "per calib: ns a pixel over ns a ray of the calibration kernel; Mray/s: rays that were traced, over the whole time"
    );
}
