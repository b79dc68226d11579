//! Is the exact prism exact? Its rays by the program's own tracer, which shares nothing with the design.

use biprism::Scene;
use biprism::scene::{self, PrismSpec};
use biprism::system::{self, Side, System};
use glam::{DVec2, DVec3};
use std::path::Path;

/// The paper's scene with the exact prism, by polynomials of `degree`.
fn exact(degree: usize) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/paper.toml");
    let text = std::fs::read_to_string(path).expect("it is there");
    let settings = format!("objective = \"epipolar\"\nstep_px = 8.0\ndegree = {degree}");
    let text = text.replace("order = \"x-then-y\"\ndegree = 5", &settings);
    assert!(text.contains(&settings));
    scene::parse(&text, "exact", None).unwrap_or_else(|problem| panic!("{problem}"))
}

fn built(scene: &Scene) -> System {
    system::build(scene).unwrap_or_else(|problem| panic!("{problem}"))
}

/// Pixels of the right half, corners included, from the middle of the picture.
fn pixels() -> impl Iterator<Item = DVec2> {
    let along = |k: usize, n: usize| k as f64 / (n - 1) as f64;
    (0..21 * 21).map(move |k| DVec2::new(960.0 * along(k % 21, 21), 1080.0 * (along(k / 21, 21) - 0.5)))
}

/// Root mean squares over both halves of what a board at 1/`inverse_mm` sees, from the law of rows about O' = `centre` of the
/// right half, horizontal and vertical, in px.
fn off_law_px(system: &System, centre: DVec3, inverse_mm: f64) -> DVec2 {
    let (f, b) = (35.0 / 0.0055, 480.0);
    let (mut squares, mut count) = (DVec2::ZERO, 0.0);
    for (side, sign) in [(Side::Right, 1.0), (Side::Left, -1.0)] {
        for px in pixels() {
            let full = DVec2::new(960.0 + sign * px.x, 540.0 + px.y);
            let ray = system.exit_ray_through(full, side).expect("it passes");
            // From O', to the point of the ray at that distance; at infinity its direction.
            let origin =
                ray.origin - ray.direction * (ray.origin.z / ray.direction.z) - centre * DVec3::new(sign, 1.0, 1.0);
            let seen = (origin * inverse_mm + ray.direction / ray.direction.z).truncate() * f;
            let kappa = b * (libm::hypot(1.0, px.y / f) - 1.0);
            let law = DVec2::new(sign * (px.x - b - kappa), px.y);
            squares += (seen - law) * (seen - law);
            count += 1.0;
        }
    }
    (squares / count).map(f64::sqrt)
}

/// At both ends of the depths, from 0.3 m to infinity, for what is wrong between is linear in the inverse of the depth.
#[test]
fn every_ray_goes_where_the_law_of_rows_says() {
    // What least squares of the paper's size leave: each two degrees a hundredth.
    for (degree, [most_u, most_v]) in [(5, [5e-4, 1e-4]), (7, [1e-5, 1e-6]), (9, [1e-7, 1e-8])] {
        let scene = exact(degree);
        let system = built(&scene);
        let input = biprism::design::DesignInput::of(&scene).expect("it is designed");
        let centre = biprism::design(&input).expect("it exists").camera.centre_mm;
        for inverse_mm in [1.0 / 300.0, 0.0] {
            let off = off_law_px(&system, centre, inverse_mm);
            println!("degree {degree}, 1/{inverse_mm:.4} mm: u {:.1e}, v {:.1e} px RMS", off.x, off.y);
            assert!(off.x < most_u && off.y < most_v, "degree {degree}: {off}");
        }
    }
}

/// A ray stays in the plane that holds it and the baseline, whatever the index: the vertical disparity is 0 in every light.
#[test]
fn rays_stay_in_their_epipolar_planes_in_every_light() {
    let scene = exact(9);
    let designed = built(&scene);
    let PrismSpec::Freeform(flat, _) = &scene.prism else { panic!("it is designed") };
    for index in [flat.body.index, 1.46, 1.53] {
        let mut body = flat.body;
        body.index = index;
        // The surfaces that were designed, in another glass.
        let prism = designed_prism(&scene, body);
        let system = built(&Scene { prism, ..scene.clone() });
        for px in pixels() {
            let full = DVec2::new(960.0 + px.x, 540.0 + px.y);
            let ray = system.exit_ray_through(full, Side::Right).expect("it passes");
            let tangent = px.y * 0.0055 / 35.0;
            let leaves = (ray.direction.y - tangent * ray.direction.z) / ray.direction.z * 35.0 / 0.0055;
            let off_axis_mm = ray.origin.y - tangent * ray.origin.z;
            assert!(leaves.abs() < 1e-6 && off_axis_mm.abs() < 1e-8, "{index} {px}: {leaves} px, {off_axis_mm} mm");
        }
    }
    assert!(designed.exit_ray(DVec2::new(1440.0, 540.0)).is_ok());
}

/// The surfaces that are designed for `scene`, in the glass of `body`.
fn designed_prism(scene: &Scene, body: scene::GlassSpec) -> PrismSpec {
    let input = biprism::design::DesignInput::of(scene).expect("it is designed");
    let designed = biprism::design(&input).expect("it exists");
    PrismSpec::Polynomial(designed.prism(body))
}

/// What no prism can be is refused by name.
#[test]
fn a_prism_that_pinches_to_nothing_is_refused() {
    let scene = exact(5);
    let text = |thickness: f64| {
        format!(
            "name = \"thin\"\n[camera]\nfocal_length_mm = 8.0\nwidth_px = 1920\nheight_px = 1080\npixel_pitch_um = 5.5\n\
             [prism]\nkind = \"freeform\"\nindex = 1.48\nridge_distance_mm = 78.472\nthickness_mm = {thickness:?}\n\
             [prism.design]\nobjective = \"epipolar\"\n[board]\ncolumns = 41\nrows = 41\nsquare_mm = 10.0\n\
             position_mm = [0.0, 0.0, 1000.0]\n"
        )
    };
    let build = |text: &str| scene::parse(text, "thin", None).and_then(|scene| system::build(&scene).map(|_| ()));
    let words = build(&text(58.0)).expect_err("it pinches").to_string();
    assert!(words.contains("objective") && words.contains("epipolar"), "{words}");
    assert!(system::build(&scene).is_ok());
}
