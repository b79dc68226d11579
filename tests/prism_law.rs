//! Is a prism judged by the law that it is designed for?

use crate::command::{biprism, json, repository};
use crate::instruments;
use biprism::analysis::compare::{JudgeOptions, JudgedDesign, judge_design};
use biprism::analysis::half_image::{HalfFrame, row_shift, virtual_camera};
use biprism::effect::dispersion::Wavelength;
use biprism::metrics::{Deviation, MeasuredAndTrue};
use biprism::scene::{self, Scene};
use biprism::system::{Side, System};
use biprism::vision::half::Half;
use glam::{DVec2, DVec3};
use std::fs;

/// The design paper's prism by the exact design with polynomials of degree 9, each half by its own rear surface.
const EXACT: &str = "kind = \"freeform\"\nindex = 1.48\nridge_distance_mm = 78.472\nthickness_mm = 8.545\nsolid = false\n\
    [prism.design]\nobjective = \"epipolar\"\ndegree = 9\nstep_px = 8.0";
/// Glass that bends no ray, before which the camera is its own virtual camera: one centre, its axis the sensor's middle.
const NO_OPTICS: &str = "kind = \"flat\"\nindex = 1.0\nridge_distance_mm = 78.472\nthickness_mm = 8.545\nfacet_angle_deg = 5.0\n\
    [prism.law]\nf_mm = [35.0, 35.0]\nbaseline_mm = 0.0\nc_x_mm = -2.64";

fn judged(prism: &str) -> JudgedDesign {
    let scene = instruments::scene(960, 540, prism, instruments::BOARD);
    judge_design("one", scene, JudgeOptions { budget: false }, &()).unwrap_or_else(|problem| panic!("{problem}"))
}

fn rms(found: &MeasuredAndTrue<Deviation>) -> [f64; 2] {
    let numbers = found.numbers(|d| d.rms);
    [numbers.measured.expect("measured"), numbers.exact.expect("true")]
}

/// From corners that the detector found in rendered pictures at three depths, and truly.
#[test]
fn the_exact_prism_obeys_the_row_law_in_its_pictures() {
    let judgement = judged(EXACT).judgement;

    // No vertical disparity: to the 1e-5 px that the level promises where it is measured.
    let vertical = judgement.vertical_disparity_rms_px();
    println!("vertical disparity {vertical:?}");
    assert!(
        vertical.measured.is_some_and(|px| px < 1e-5) && vertical.exact.is_some_and(|px| px < 1e-8),
        "{vertical:?}"
    );

    // With kappa undone nothing is left; without, the row's own shift: its RMS about its mean, by which c_x and X move.
    let undone = judgement.pooled.rows_undone.numbers(|d| d.rms_px.max_element());
    assert!(undone.measured.is_some_and(|px| px < 2e-5) && undone.exact.is_some_and(|px| px < 1e-7), "{undone:?}");
    let raw = judgement.pooled.row_law.numbers(|d| d.rms_px.x);
    // kappa from 0 to 1.73/2 px at half the paper's resolution: a parabola's RMS about its mean is its height times sqrt(4/45).
    let kappa_px = 240.0 * (libm::hypot(1.0, 2.97 / 35.0) - 1.0);
    let expected = kappa_px * (4.0f64 / 45.0).sqrt();
    assert!(raw.exact.is_some_and(|px| (px / expected - 1.0).abs() < 0.2), "{raw:?} {expected}");

    // Its own design is what it is held against; one homography takes nothing of a bent row.
    let [_, designed] = rms(&judgement.pooled.at(1000.0).expect("a board").designed);
    let [_, homography] = rms(&judgement.pooled.homography);
    let [_, principal] = rms(&judgement.pooled.principal);
    assert!(designed < 1e-7, "{designed}");
    assert!(homography > 0.1 && principal > 0.1, "{homography} {principal}");
}

/// What `biprism design` writes states the law that it was designed for, and a scene with it is judged by that.
#[test]
fn a_written_design_states_its_law() {
    let folder = tempfile::tempdir().expect("a folder");
    let paper = fs::read_to_string(repository("scenes/paper.toml")).expect("it is there");
    let scene = paper
        .replace("order = \"x-then-y\"\ndegree = 5", "objective = \"epipolar\"\ndegree = 7\nstep_px = 8.0")
        .replace("width_px = 1920", "width_px = 480")
        .replace("height_px = 1080", "height_px = 270")
        .replace("pixel_pitch_um = 5.5", "pixel_pitch_um = 22.0");
    fs::write(folder.path().join("scene.toml"), &scene).expect("written");
    let found = json(&biprism(folder.path(), &["design", "scene.toml", "--json"]));
    let prism = fs::read_to_string(folder.path().join("out/prism.toml")).expect("written");
    assert!(prism.contains("\n[prism.law]\nf_mm = [35.0, 35.0]\nc_x_mm = 0.0\n"), "{prism}");
    // b, a quarter of the sensor's width, but for rounding.
    let kappa_mm = found["law"]["kappa_mm"].as_f64().expect("a number");
    assert!((kappa_mm - 2.64).abs() < 1e-15 && prism.contains(&format!("\nkappa_mm = {kappa_mm:?}\n")), "{prism}");

    // The verdict tells of the prism that has a row law what is left without it, and of the flat one nothing of the kind.
    let out = biprism(folder.path(), &["compare", "scene.toml", "--out", "compared"]);
    let told = String::from_utf8(out.stdout).expect("UTF-8");
    assert!(told.contains(" The freeform prism is a pinhole but for a known shift of each row"), "{told}");
    assert!(!told.contains("The flat prism is a pinhole"), "{told}");

    // Without its law it is held against a parallel pinhole, from which it differs by kappa.
    let (before, after) = scene.split_once("[prism]").expect("a prism");
    let board = &after[after.find("# An odd number").expect("a board")..];
    let read = |prism: &str| -> [f64; 2] {
        let text = format!("{before}{prism}\n{board}");
        let scene = scene::parse(&text, "written", None).unwrap_or_else(|problem| panic!("{problem}"));
        let judged = judge_design("one", scene, JudgeOptions { budget: false }, &()).unwrap_or_else(|p| panic!("{p}"));
        rms(&judged.judgement.pooled.at(1000.0).expect("a board").designed)
    };
    let [measured, exact] = read(&prism);
    // The row law of degree 7 holds to 1e-5 px of the full sensor.
    assert!(exact < 1e-5 && measured < 1e-4, "{measured} {exact}");
    let from = prism.find("[prism.law]").expect("a law");
    let end = prism.find("\n[prism.front]").expect("a front");
    let [_, assumed] = read(&format!("{}{}", &prism[..from], &prism[end..]));
    assert!(assumed > 0.05, "{assumed}");
}

/// What the main job sets beside the design paper's prisms: the exact one in the same instrument.
#[test]
fn the_exact_scene_is_the_paper_s_but_for_its_prism() {
    let [paper, exact] = ["paper", "exact"].map(|name| {
        scene::load(&repository(&format!("scenes/{name}.toml"))).unwrap_or_else(|problem| panic!("{problem}"))
    });
    assert_eq!((paper.camera, paper.board, &paper.analysis), (exact.camera, exact.board, &exact.analysis));
    let flat = |scene: &Scene| match scene.prism {
        scene::PrismSpec::Freeform(flat, settings) => (flat, settings.objective),
        _ => panic!("a designed prism"),
    };
    let [paper, exact] = [flat(&paper), flat(&exact)];
    assert_eq!(paper.0, exact.0);
    assert_eq!([paper.1, exact.1], [scene::Objective::March, scene::Objective::Epipolar]);
}

/// Every number of a law is used, for both halves alike.
#[test]
fn a_law_is_what_it_says() {
    let law = |prism: &str| {
        let system = instruments::built(&instruments::scene(960, 540, prism, instruments::BOARD));
        let frames = [Half::Left, Half::Right].map(|half| HalfFrame::new(&system, half));
        frames.map(|frame| (virtual_camera(&system, &frame).expect("a camera"), row_shift(&system, &frame)))
    };
    // The camera through nothing: it is what it is.
    let judgement = judged(NO_OPTICS).judgement;
    let [measured, exact] = rms(&judgement.pooled.at(1000.0).expect("a board").designed);
    assert!(exact < 1e-9 && measured < 1e-4, "{measured} {exact}");

    // Another law: turned outwards, 12 mm apart, 3 mm before the camera.
    let other = NO_OPTICS.replace(
        "f_mm = [35.0, 35.0]\nbaseline_mm = 0.0\nc_x_mm = -2.64",
        "f_mm = [34.0, 36.0]\nbaseline_mm = 12.0\nc_x_mm = 0.11\ncentre_z_mm = 3.0\ntau_deg = 2.0\nkappa_mm = 2.2",
    );
    let tau = 2.0f64.to_radians();
    for (k, (camera, rows)) in law(&other).into_iter().enumerate() {
        let mirror = [-1.0, 1.0][k];
        let on_axis = DVec3::new(mirror * (6.0 + 500.0 * libm::sin(tau)), 0.0, 3.0 + 500.0 * libm::cos(tau));
        let seen = camera.project(on_axis).expect("before it");
        // Its axis meets the image 0.11 mm, 10 px of 11 um, outside of the middle of the half.
        assert!((seen - DVec2::new(240.0 + 10.0 * mirror, 270.0)).length() < 1e-9, "{seen}");
        assert!((camera.focal_px - DVec2::new(34.0, 36.0) / 0.011).length() < 1e-9);
        let rows = rows.expect("a shift of the rows");
        let top = 200.0 * mirror * (libm::hypot(1.0, 2.97 / 36.0) - 1.0);
        assert!((rows.at(0.0) - top).abs() < 1e-12, "{} {top}", rows.at(0.0));
    }
    assert!(law(NO_OPTICS)[0].1.is_none());
}

#[test]
fn a_law_out_of_range_is_refused_with_its_place() {
    let refused = |law: &str| {
        let text = format!(
            "name = \"law\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = 960\nheight_px = 540\npixel_pitch_um = 11.0\n\
             [prism]\n{}\n[prism.law]\n{law}\n[board]\n{}\n",
            instruments::FLAT,
            instruments::BOARD
        );
        scene::parse(&text, "law.toml", None).expect_err("it is refused").to_string()
    };
    for (law, words) in [
        ("f_mm = [35.0, 0.0]\nbaseline_mm = 12.0", ["prism.law.f_mm[1]", "law.toml:13"]),
        ("baseline_mm = 12.0", ["f_mm", "law.toml:12"]),
        ("f_mm = [35.0, 35.0]\nbaseline_mm = 12.0\ntau_deg = 90.0", ["prism.law.tau_deg", "law.toml:15"]),
        ("f_mm = [35.0, 35.0]\nbaseline_mm = 12.0\nkapa_mm = 2.64", ["kappa_mm", "law.toml:15"]),
    ] {
        let found = refused(law);
        assert!(words.iter().all(|word| found.contains(word)), "{words:?}: {found}");
    }
    // Legal, but hardly meant: pixels in place of mm.
    let pixels = NO_OPTICS.replace("f_mm = [35.0, 35.0]", "f_mm = [3181.8, 3181.8]");
    let scene = instruments::scene(960, 540, &pixels, instruments::BOARD);
    let told = biprism::system::doubts(&scene, &instruments::built(&scene)).join("\n");
    assert!(told.contains("`prism.law.f_mm` has 3181.8") && told.contains("34.9998 of pixels"), "{told}");

    // The same of a scene that was made in code.
    let mut scene = instruments::scene(960, 540, NO_OPTICS, instruments::BOARD);
    let scene::PrismSpec::Flat(flat) = &mut scene.prism else { panic!("a flat prism") };
    flat.body.law.as_mut().expect("a law").focal_mm[1] = f64::NAN;
    assert!(scene.check().expect_err("it is refused").to_string().contains("prism.law.f_mm[1]"));
}

/// The instrument in light of another wavelength.
fn in_light(scene: &Scene, system: &System, wavelength_nm: f64) -> System {
    let body = scene.prism.body().expect("glass");
    let glass = body.glass.expect("its name");
    let index = |nm: f64| glass.index(nm).expect("within its range");
    let index_shift = index(wavelength_nm) - index(body.wavelength_nm);
    system.at_wavelength(&Wavelength { wavelength_nm, index_shift, weights: [1.0; 3] })
}

/// The planes through the baseline keep their rays in any light: no vertical disparity, near or far, from 400 to 700 nm.
#[test]
fn no_light_makes_vertical_disparity() {
    for (glass, index) in [("N-BK7", 1.5187), ("PMMA", 1.4938)] {
        let named = format!("glass = \"{glass}\"\nwavelength_nm = 546.1\nridge_distance_mm");
        let prism = EXACT.replace("index = 1.48", &format!("index = {index}")).replace("ridge_distance_mm", &named);
        let scene = instruments::scene(1920, 1080, &prism, instruments::BOARD);
        let system = instruments::built(&scene);
        let f = 35.0 / 0.0055;
        // The catalogue knows PMMA from 420 nm on.
        let shortest_nm = if glass == "PMMA" { 420.0 } else { 400.0 };
        for wavelength_nm in [shortest_nm, 450.0, 500.0, 546.1, 600.0, 650.0, 700.0] {
            let lit = in_light(&scene, &system, wavelength_nm);
            let (mut worst, mut moved) = (0.0f64, 0.0f64);
            for k in 0..21 * 21 {
                let at = DVec2::new(f64::from(k % 21), f64::from(k / 21)) / 20.0;
                let px = DVec2::new(960.0 * (1.0 + at.x), 1080.0 * at.y);
                let ray = lit.exit_ray_through(px, Side::Right).expect("it passes");
                let designed = system.exit_ray_through(px, Side::Right).expect("it passes");
                let slope = |r: &biprism::geom::Ray| r.direction.truncate() / r.direction.z;
                moved = moved.max((slope(&ray) - slope(&designed)).x.abs() * f);
                for inverse_mm in [1.0 / 300.0, 0.0] {
                    // v of what the ray sees at that distance, against the row that it was sent from.
                    let at_0 = ray.origin.y - slope(&ray).y * ray.origin.z;
                    let seen = (at_0 * inverse_mm + slope(&ray).y) * f;
                    worst = worst.max((seen - (px.y - 540.0)).abs());
                }
            }
            println!("{glass} {wavelength_nm} nm: v {worst:.1e} px, u moves by up to {moved:.2} px");
            assert!(worst < 1e-6, "{glass} {wavelength_nm} nm: {worst} px");
            assert!(wavelength_nm == 546.1 || moved > 0.5, "the light does change: {moved}");
        }
    }
}
