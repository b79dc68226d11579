//! Do the prisms of least squares meet their laws? Their rays by the program's own tracer, which shares nothing with the search.

use biprism::Scene;
use biprism::design::{DesignInput, DesignedLaw};
use biprism::scene;
use biprism::system::{self, Side};
use glam::{DVec2, DVec3};
use std::path::Path;

/// The paper's scene with these keys in `[prism.design]`, each half by its own surfaces, as the search has them: what of the picture
/// looks through the other half's glass is another matter.
fn designed(keys: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/paper.toml");
    let text = std::fs::read_to_string(path).expect("it is there");
    let settings = format!("step_px = 8.0\n{keys}");
    let text = text.replace(
        "[prism.design]\norder = \"x-then-y\"\ndegree = 5",
        &format!("solid = false\n[prism.design]\n{settings}"),
    );
    assert!(text.contains(&settings) && text.contains("solid = false"));
    scene::parse(&text, "designed", None).unwrap_or_else(|problem| panic!("{problem}"))
}

fn law_of(scene: &Scene) -> DesignedLaw {
    let input = DesignInput::of(scene).expect("it is designed");
    let design = biprism::design(&input).unwrap_or_else(|problem| panic!("{problem}"));
    design.met.expect("every ray passes").law
}

/// Where the camera of `law` sees what lies in the direction `w` from its centre, in mm from the middle of the right half image
/// of the paper's camera, for the row `v_mm`.
fn seen_mm(law: &DesignedLaw, w: DVec3, v_mm: f64) -> DVec2 {
    let (sin, cos) = libm::sincos(law.toe_rad);
    let turned = DVec3::new(cos * w.x + sin * w.z, w.y, cos * w.z - sin * w.x);
    let [fx, fy] = law.focal_mm;
    let kappa = if law.rows { (2.64 + law.centre_x_mm) * (libm::hypot(1.0, v_mm / fy) - 1.0) } else { 0.0 };
    DVec2::new(fx * turned.x / turned.z + law.centre_x_mm + kappa, fy * turned.y / turned.z)
}

/// Root mean square of what both halves miss the law by, over 41 x 41 pixels of each, of a board at 1/`inverse_mm`, in px.
fn missed_px(scene: &Scene, law: &DesignedLaw, inverse_mm: f64) -> f64 {
    let system = system::build(scene).unwrap_or_else(|problem| panic!("{problem}"));
    let share = |k: usize| k as f64 / 40.0;
    let mut squares = 0.0;
    for (side, sign) in [(Side::Right, 1.0), (Side::Left, -1.0)] {
        for k in 0..41 * 41 {
            let px = DVec2::new(960.0 * share(k % 41), 1080.0 * (share(k / 41) - 0.5));
            let ray = system.exit_ray_through(DVec2::new(960.0 + sign * px.x, 540.0 + px.y), side).expect("it passes");
            // In the mirror, the left half is the right one.
            let mirror = DVec3::new(sign, 1.0, 1.0);
            let (origin, direction) = (ray.origin * mirror, ray.direction * mirror);
            // The point at that depth from O', but for a factor that no direction has; at infinity the direction itself.
            let start = origin - direction * (origin.z / direction.z);
            let w = (start - DVec3::from_array(law.eye_mm)) * inverse_mm + direction / direction.z;
            let v_mm = px.y * 0.0055;
            let off = seen_mm(law, w, v_mm) / 0.0055 - (px - DVec2::new(480.0, 0.0));
            squares += off.length_squared();
        }
    }
    (squares / (2.0 * 41.0 * 41.0)).sqrt()
}

/// Both ends of the depths, from 0.3 m to infinity: what is missed between is linear in 1/(Z - z).
fn worst_px(keys: &str) -> f64 {
    let scene = designed(keys);
    let law = law_of(&scene);
    let worst =
        [1.0 / 300.0, 0.0].map(|inverse_mm| missed_px(&scene, &law, inverse_mm)).into_iter().fold(0.0, f64::max);
    println!("{keys:?}: {worst:.1e} px RMS, {law:?}");
    worst
}

/// What an independent study reached, with room for the order of its sums; each two degrees more of an exact prism gain two
/// orders of magnitude.
#[test]
fn one_rear_surface_keeps_epipolar_lines() {
    for (degree, most) in [(5, 3e-4), (7, 1e-5)] {
        let worst = worst_px(&format!("objective = \"epipolar\"\nrear = \"even\"\ndegree = {degree}"));
        assert!(worst < most, "degree {degree}: {worst:e}");
    }
}

#[test]
fn an_axis_that_may_turn_leaves_an_exact_pinhole() {
    for (degree, rear, most) in [(5, "own", 2e-4), (7, "own", 2e-6), (5, "flat", 0.008)] {
        let worst = worst_px(&format!("objective = \"toed-in\"\nrear = \"{rear}\"\ndegree = {degree}"));
        assert!(worst < most, "degree {degree}, {rear}: {worst:e}");
    }
}

/// A parallel pinhole has a floor: of two focal lengths, and of one.
#[test]
fn a_parallel_pinhole_comes_down_to_its_floor() {
    for (degree, square, most) in
        [(5, false, 6e-3), (7, false, 5e-4), (9, false, 3e-4), (5, true, 0.02), (7, true, 0.012)]
    {
        let worst = worst_px(&format!("objective = \"pinhole\"\nsquare = {square}\ndegree = {degree}"));
        assert!(worst < most, "degree {degree}, square {square}: {worst:e}");
    }
}

#[test]
fn one_depth_is_met() {
    for (degree, most) in [(5, 3e-4), (7, 5e-6)] {
        let scene = designed(&format!("objective = \"depth\"\ndegree = {degree}"));
        let law = law_of(&scene);
        let worst = missed_px(&scene, &law, 1e-3);
        println!("depth {degree}: {worst:.1e} px RMS");
        assert!(worst < most, "degree {degree}: {worst:e}");
        assert!(law.focal_mm == [35.0, 35.0] && law.centre_x_mm == 0.0 && law.toe_rad == 0.0, "{law:?}");
    }
}

/// The words of the error of a scene with these keys, by reading or by building it.
fn refused(keys: &str, change: impl Fn(String) -> String) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/paper.toml");
    let text = std::fs::read_to_string(path).expect("it is there");
    let text = change(text.replace("order = \"x-then-y\"\ndegree = 5", &format!("step_px = 8.0\n{keys}")));
    let problem = scene::parse(&text, "refused", None).and_then(|scene| system::build(&scene)).map(|_| ());
    problem.expect_err(keys).to_string()
}

/// What an objective cannot have is refused by the names of its keys, with the floor that remains and what to write instead.
#[test]
fn what_cannot_be_had_is_refused_by_name() {
    let own = |text: String| text;
    for (keys, words) in [
        ("objective = \"pinhole\"\nrear = \"even\"", ["\"pinhole\"", "\"even\"", "a floor of 0.0", "toed-in"]),
        ("objective = \"depth\"\nrear = \"flat\"", ["\"depth\"", "\"flat\"", "a floor of ", "rear = \"own\""]),
        ("objective = \"epipolar\"\nrear = \"flat\"", ["\"epipolar\"", "\"flat\"", "a floor of ", "rear = \"even\""]),
        ("rear = \"even\"", ["prism.design.rear", "march", "epipolar", "leave `rear` out"]),
        (
            "objective = \"toed-in\"\nsquare = true",
            ["prism.design.square", "other than", "pinhole", "leave `square` out"],
        ),
        ("objective = \"toed-in\"\nspot_weight = 0.1", ["prism.design.spot_weight", "0.1", "aperture", "f-number"]),
        ("objective = \"toed-in\"\ndegree = 1", ["\"toed-in\"", "degree", "px RMS", "raise `prism.design.degree`"]),
    ] {
        let told = refused(keys, own);
        assert!(words.iter().all(|word| told.contains(word)), "{keys}: {told}");
    }
    // A facet of this angle turns the central ray outwards by more than the baseline.
    let flatter = |text: String| text.replace("[prism.design]", "facet_angle_deg = 8.0\n[prism.design]");
    let told = refused("baseline_mm = 0.01", flatter);
    let words = ["prism.design.baseline_mm", "0.01", "ridge", "prism.ridge_distance_mm"];
    assert!(words.iter().all(|word| told.contains(word)), "{told}");
    // The glass ends before the edge of the picture.
    let thin = |text: String| text.replace("thickness_mm = 8.545", "thickness_mm = 1.5");
    let told = refused("objective = \"toed-in\"", thin);
    assert!(told.contains("thick"), "{told}");
}

/// The virtual cameras are as far apart as was asked for, and the law is met there too.
#[test]
fn a_baseline_moves_the_ridge() {
    for facet in ["", "facet_angle_deg = 9.3\n"] {
        let keys = "objective = \"epipolar\"\nrear = \"even\"\ndegree = 7\nbaseline_mm = 20.0";
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/paper.toml");
        let text = std::fs::read_to_string(path).expect("it is there");
        let text = text.replace("order = \"x-then-y\"\ndegree = 5", &format!("step_px = 8.0\n{keys}"));
        let text = text.replace("[prism.design]", &format!("{facet}[prism.design]"));
        let scene = scene::parse(&text, "apart", None).unwrap_or_else(|problem| panic!("{problem}"));
        let law = law_of(&scene);
        assert!((law.eye_mm[0] - 10.0).abs() < 1e-12, "{facet}: {law:?}");
        // Of a longer baseline the residual is larger, far below a hundredth of the flat prism's.
        let missed = missed_px(&scene, &law, 0.0);
        assert!(missed < 1e-3, "{facet}: {missed:e}");
    }
}

/// The same bits for any number of threads.
#[test]
fn threads_do_not_change_a_bit() {
    let scene = designed("objective = \"toed-in\"\nrear = \"even\"\ndegree = 5");
    let input = DesignInput::of(&scene).expect("it is designed");
    let by = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads are there");
        pool.install(|| biprism::design(&input).unwrap_or_else(|problem| panic!("{problem}")))
    };
    assert!(by(1) == by(3));
}

/// A weight on spots makes them smaller, and what the law loses stays within what the weight allows: the merit of the search
/// without spots, with these counted, is no better.
#[test]
fn a_weight_on_spots_makes_them_smaller() {
    let weight = 0.01;
    for (keys, most) in
        [("objective = \"toed-in\"\ndegree = 5", 0.5), ("objective = \"epipolar\"\nrear = \"even\"\ndegree = 7", 1.0)]
    {
        let met = |weight: f64| {
            let keys = format!("{keys}\naperture = 8.0\nspot_weight = {weight:?}");
            let input = DesignInput::of(&designed(&keys)).expect("it is designed");
            biprism::design(&input).unwrap_or_else(|problem| panic!("{problem}")).met.expect("every ray passes")
        };
        let (free, weighed) = (met(0.0), met(weight));
        let spot = |met: &biprism::design::MetLaw| met.spot.expect("it has an aperture").rms_px;
        println!(
            "{:.3} px and {:.1e}; {:.3} px and {:.1e}",
            spot(&free),
            free.rms_px(),
            spot(&weighed),
            weighed.rms_px()
        );
        assert!(spot(&weighed) < most * spot(&free), "{keys}: {} {}", spot(&weighed), spot(&free));
        // What it is weighed against is given up for no more than it gains.
        let merit = |met: &biprism::design::MetLaw| libm::hypot(met.rms_px(), weight * spot(met));
        assert!(merit(&weighed) < merit(&free), "{keys}: {} {}", merit(&weighed), merit(&free));
    }
}
