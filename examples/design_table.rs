//! What prisms can be had for other cameras and baselines: each objective by least squares, its residual or why it is refused.
//!
//! `cargo run --release --example design_table` takes some minutes for its 4 cameras, 4 baselines and 8 designs of degree 7;
//! words after `--` keep the rows that have one of them in their names.

use biprism::design::{DesignInput, DesignedLaw};
use biprism::scene;
use std::time::Instant;

/// Name, focal length in mm, columns, rows, pitch in um.
const CAMERAS: [(&str, f64, usize, usize, f64); 4] = [
    ("paper", 35.0, 1920, 1080, 5.5),
    ("f50", 50.0, 1920, 1080, 5.5),
    ("f16", 16.0, 2448, 2048, 3.45),
    ("f8", 8.0, 1920, 1080, 5.5),
];
const BASELINES_MM: [f64; 4] = [6.0, 12.0, 30.0, 60.0];
const DESIGNS: [(&str, &str); 8] = [
    ("epipolar", "rear = \"even\""),
    ("epipolar", "rear = \"own\""),
    ("toed-in", "rear = \"own\""),
    ("toed-in", "rear = \"even\""),
    ("toed-in", "rear = \"flat\""),
    ("pinhole", "square = false"),
    ("pinhole", "square = true"),
    ("depth", "depth_mm = 1000.0"),
];
const INDEX: f64 = 1.48;
/// The paper's thickness, in mm: of prisms for longer baselines, their sag and this share more of it, and a border.
const LEAST_MM: f64 = 8.545;
const SPARE: f64 = 1.3;
const BORDER_MM: f64 = 2.0;

/// The thickness that lets the outermost ray of the middle row through the flat prism with a border to spare.
fn thickness_mm(focal_length_mm: f64, half_centre_mm: f64, baseline_mm: f64) -> f64 {
    let tangent = half_centre_mm / focal_length_mm;
    let delta = libm::atan(tangent);
    let facet = libm::sin(delta) / (INDEX - libm::cos(delta));
    let ridge_mm = 0.5 * baseline_mm / tangent * (1.0 - tangent * facet);
    let sag_mm = ridge_mm / (1.0 - 2.0 * tangent * facet) - ridge_mm;
    (SPARE * sag_mm + BORDER_MM).max(LEAST_MM)
}

/// What is achieved, in words.
fn row(text: &str) -> String {
    let made = scene::parse(text, "table", None)
        .and_then(|scene| biprism::design(&DesignInput::of(&scene).expect("its prism is designed")));
    let met = match made.map(|design| design.met) {
        Err(problem) => return format!("refused: {}", problem.rule),
        Ok(None) => return "a ray of the half image does not pass".to_owned(),
        Ok(Some(met)) => met,
    };
    let DesignedLaw { focal_mm: [fx, fy], centre_x_mm, eye_mm, toe_rad, .. } = met.law;
    let floor = if met.floor_reached { ", a floor" } else { "" };
    format!(
        "{:.1e} px RMS, {:.1e} at most{floor}; f {fx:.3} {fy:.3}, c_x {centre_x_mm:.3}, z {:.3}, toe {:.3} deg",
        met.rms_px(),
        met.max_px(),
        eye_mm[2],
        toe_rad.to_degrees()
    )
}

fn main() {
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    for (camera, f_mm, columns, rows, pitch_um) in CAMERAS {
        let half_centre_mm = columns as f64 * pitch_um * 1e-3 / 4.0;
        for baseline_mm in BASELINES_MM {
            let thickness_mm = thickness_mm(f_mm, half_centre_mm, baseline_mm);
            for (objective, key) in DESIGNS {
                let name = format!("{camera} {baseline_mm} mm {objective} {key}");
                if !wanted.is_empty() && !wanted.iter().any(|word| name.contains(word)) {
                    continue;
                }
                let text = format!(
                    "name = \"table\"\n[camera]\nfocal_length_mm = {f_mm:?}\nwidth_px = {columns}\nheight_px = {rows}\n\
                     pixel_pitch_um = {pitch_um:?}\n[prism]\nkind = \"freeform\"\nindex = {INDEX}\nridge_distance_mm = 80.0\n\
                     thickness_mm = {thickness_mm:?}\n[prism.design]\nobjective = \"{objective}\"\n{key}\ndegree = 7\n\
                     step_px = 32.0\nbaseline_mm = {baseline_mm:?}\n[board]\ncolumns = 41\nrows = 41\nsquare_mm = 10.0\n\
                     position_mm = [0.0, 0.0, 1000.0]\n"
                );
                let started = Instant::now();
                let told = row(&text);
                println!("{name:<44} {:5.2} s  {told}", started.elapsed().as_secs_f64());
            }
        }
    }
}
