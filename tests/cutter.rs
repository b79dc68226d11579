//! Does a designed prism get the figures that a cutter asks for, as an independent program found them?

use crate::instruments;
use biprism::analysis::cutter::{self, CutterSheet, Floor, recalibrated_rss_px};
use biprism::design::{self, DesignInput};
use biprism::scene::{self, PrismSpec, Scene};
use std::path::Path;

/// The paper's scene with a prism of other settings.
fn scene(settings: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/paper.toml");
    let text = std::fs::read_to_string(path).expect("it is there");
    let text = text.replace("order = \"x-then-y\"\ndegree = 5", &format!("step_px = 8.0\n{settings}"));
    assert!(text.contains(settings));
    scene::parse(&text, "cutter", None).unwrap_or_else(|problem| panic!("{problem}"))
}

/// The scene of a design by itself.
fn designed(settings: &str) -> Scene {
    let scene = scene(settings);
    let input = DesignInput::of(&scene).expect("it is designed");
    let designed = design::freeform(&input).unwrap_or_else(|problem| panic!("{problem}"));
    cutter::of_design(&scene, &input.prism, &designed)
}

fn sheet(scene: &Scene) -> CutterSheet {
    cutter::sheet(scene, cutter::Z_MIN_MM).unwrap_or_else(|problem| panic!("{problem}"))
}

/// A figure of the independent program, to half of its last digit.
fn agrees(what: &str, found: f64, reference: f64, half_digit: f64) {
    println!("{what:40} {found:10.5} {reference:10.5}");
    assert!((found - reference).abs() <= 1.001 * half_digit, "{what}: {found}, and {reference} there");
}

/// The spot by the pupil of the independent program, 6 points at half the radius and 12 at the whole, whose mean square is 3/4 of
/// the radius' square where that of a filled pupil is 1/2: at the best focus these spots are astigmatic, and so linear in the pupil.
fn of_two_rings(filled_px: f64) -> f64 {
    filled_px * 1.5f64.sqrt()
}

#[test]
fn the_march_and_the_exact_prism_have_the_figures_of_the_independent_program() {
    for (settings, spot_px) in
        [("objective = \"march\"\ndegree = 5", 0.88), ("objective = \"epipolar\"\ndegree = 9", 0.87)]
    {
        println!("{settings}");
        let sheet = sheet(&designed(settings));
        let [front, back] = &sheet.surfaces;
        agrees("departure of the front, mm", front.departure_mm, 0.44, 0.005);
        agrees("departure of the rear, mm", back.departure_mm, 0.46, 0.005);
        let radius = |form: &cutter::SurfaceForm| form.radius_min_mm.expect("it is curved");
        agrees("smallest radius, mm", radius(front).min(radius(back)), 80.0, 1.0);
        // To a column: which rows are asked decides on the last one.
        agrees("columns that cross", sheet.glass.crossing_columns as f64, 41.0, 1.0);
        assert!(!sheet.glass.one_back);
        agrees("spot, px", of_two_rings(sheet.spot.best_rms_px), spot_px, 0.005);
        agrees("refocus, dpt", sheet.spot.refocus_dpt, -0.43, 0.01);
        assert!(!sheet.spot.stated && sheet.spot.f_number == 8.0 && sheet.spot.rms_px > sheet.spot.best_rms_px);
        println!("RSS {}", recalibrated_rss_px(&sheet.sensitivities));
    }
}

/// What the program by itself says of errors: of roll at 1 m, of the index over 0.3 m, 1 m and infinity.
#[test]
fn errors_of_manufacture_do_what_the_independent_program_found() {
    let exact = designed("objective = \"epipolar\"\ndegree = 9");
    let at = |depth_mm: f64| {
        let mut scene = exact.clone();
        scene.board.world_from_board.translation_mm.z = depth_mm;
        sheet(&scene).sensitivities
    };
    let depths = [300.0, 1000.0, 1e9].map(at);
    let of = |k: usize, name: &str| depths[k].iter().find(|one| one.error == name).expect("it is in the table");
    for one in &depths[1] {
        println!("{one:?}");
    }
    let pooled = |of: &dyn Fn(usize) -> f64| ((0..3).map(|k| of(k) * of(k)).sum::<f64>() / 3.0).sqrt();
    agrees("index 1e-3, u, px", pooled(&|k| of(k, "index 1e-3").raw_px.x), 0.87, 0.005);
    agrees("index 1e-3, v, px", pooled(&|k| of(k, "index 1e-3").raw_px.y), 0.0, 1e-6);
    agrees("roll about z 1', vertical, px", of(1, "prism, roll about z 1'").vertical_px, 0.26, 0.005);
    // It does not say at which distance: it grows from near to far.
    let rear = [0, 2].map(|k| of(k, "rear, roll about z 1'").vertical_px);
    println!("rear roll, near and far: {rear:?}");
    assert!(rear[0] < 0.115 && 0.115 < rear[1], "{rear:?}");
    // Turned as a whole about z a pair stays one: a calibration takes all but what the turn of its far ends bends.
    assert!(of(1, "prism, roll about z 1'").recalibrated_px < 0.01 * of(1, "prism, roll about z 1'").raw_px.length());
}

/// What is exact falls with the degree, what is not stays: the march's floor is kappa.
#[test]
fn a_floor_is_told_from_a_fit() {
    let left = |settings: &str| {
        cutter::residuals(&designed(settings), cutter::Z_MIN_MM).unwrap_or_else(|problem| panic!("{problem}"))
    };
    let [march, next] = [5, 7].map(|degree| left(&format!("objective = \"march\"\ndegree = {degree}")));
    let larger = |residuals: &[cutter::LawResidual; 2]| residuals.iter().map(|r| r.both_rms_px).fold(0.0, f64::max);
    // The paper's march, of which 0.81 px is kappa.
    agrees("march, RMS, px", larger(&march), 0.81, 0.01);
    assert!(Floor::of(7, larger(&march), &next).reached);
    let [five, seven, nine] = [5, 7, 9].map(|degree| left(&format!("objective = \"epipolar\"\ndegree = {degree}")));
    for (found, [most_u, most_v]) in [(&five, [5e-4, 1e-4]), (&seven, [1e-5, 1e-6]), (&nine, [1e-7, 1e-8])] {
        println!("{found:?}");
        assert!(found.iter().all(|r| r.rms_px.x < most_u && r.rms_px.y < most_v), "{found:?}");
    }
    assert!(!Floor::of(7, larger(&five), &seven).reached && !Floor::of(9, larger(&seven), &nine).reached);
}

/// A prism whose shape is known: planes.
#[test]
fn a_flat_prism_is_flat() {
    let law = "[prism.law]\nf_mm = [35.0, 35.0]\nbaseline_mm = 11.9788145";
    let flat = instruments::scene(1920, 1080, &format!("{}\n{law}", instruments::FLAT), instruments::BOARD);
    assert!(matches!(flat.prism, PrismSpec::Flat(_)));
    let sheet = sheet(&flat);
    for surface in &sheet.surfaces {
        assert!(surface.departure_mm < 1e-11 && surface.radius_min_mm.is_none(), "{surface:?}");
    }
    let [front, back] = sheet.surfaces.each_ref().map(|s| s.slope_max_deg);
    assert!((front - 8.85428).abs() < 5e-6 && back < 1e-9, "{front} {back}");
    // One base plane: what crosses x = 0 meets the same surface there.
    assert!(sheet.glass.one_back && sheet.glass.crossing_columns > 10, "{:?}", sheet.glass);
    assert!((sheet.glass.centre_mm - 8.545).abs() < 1e-12 && sheet.glass.edge_mm < 8.545, "{:?}", sheet.glass);
    agrees("flat, spot, px", of_two_rings(sheet.spot.best_rms_px), 0.22, 0.005);
}
