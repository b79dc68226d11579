//! Is the exact prism exact? Its rays by the program's own tracer, which shares nothing with the design.

use biprism::Scene;
use biprism::optics::polarisation::PolarisationState;
use biprism::scene::{self, PrismSpec};
use biprism::system::{self, Side, System};
use glam::{DVec2, DVec3};
use std::path::Path;

/// The paper's scene with a prism by `settings`, the keys of its `[prism.design]`. Its two surfaces are the idealised ones: each
/// half's back goes on beyond x = 0.
fn designed_by(settings: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/paper.toml");
    let text = std::fs::read_to_string(path).expect("it is there");
    let written = "[prism.design]\norder = \"x-then-y\"\ndegree = 5";
    assert!(text.contains(written));
    let text = text.replace(written, &format!("solid = false\n[prism.design]\nstep_px = 8.0\n{settings}"));
    scene::parse(&text, "exact", None).unwrap_or_else(|problem| panic!("{problem}"))
}

/// The paper's scene with the exact prism, by polynomials of `degree`.
fn exact(degree: usize) -> Scene {
    designed_by(&format!("objective = \"epipolar\"\ndegree = {degree}"))
}

/// Where O' of the right half is.
fn centre_of(scene: &Scene) -> DVec3 {
    let input = biprism::design::DesignInput::of(scene).expect("it is designed");
    biprism::design(&input).expect("it exists").camera.centre_mm
}

fn built(scene: &Scene) -> System {
    system::build(scene).unwrap_or_else(|problem| panic!("{problem}"))
}

/// Pixels of the right half, corners included, from the middle of the picture.
fn pixels() -> impl Iterator<Item = DVec2> {
    let along = |k: usize, n: usize| k as f64 / (n - 1) as f64;
    (0..21 * 21).map(move |k| DVec2::new(960.0 * along(k % 21, 21), 1080.0 * (along(k / 21, 21) - 0.5)))
}

/// Root mean squares over both halves of what a board at 1/`inverse_mm` sees, from the direction that `law` gives a pixel of the
/// right half about its O' = `centre`, horizontal and vertical, in px of the camera.
fn off_law_px(system: &System, centre: DVec3, inverse_mm: f64, law: impl Fn(DVec2) -> DVec2) -> DVec2 {
    let f = 35.0 / 0.0055;
    let (mut squares, mut count) = (DVec2::ZERO, 0.0);
    for (side, sign) in [(Side::Right, 1.0), (Side::Left, -1.0)] {
        for px in pixels() {
            let full = DVec2::new(960.0 + sign * px.x, 540.0 + px.y);
            let ray = system.exit_ray_through(full, side).expect("it passes");
            // From O', to the point of the ray at that distance; at infinity its direction.
            let start = ray.origin - centre * DVec3::new(sign, 1.0, 1.0);
            let origin = start - ray.direction * (start.z / ray.direction.z);
            let seen = (origin * inverse_mm + ray.direction / ray.direction.z).truncate() * f;
            let off = seen - law(px) * DVec2::new(sign, 1.0);
            squares += off * off;
            count += 1.0;
        }
    }
    (squares / count).map(f64::sqrt)
}

/// The law of rows: a pinhole but for a shift of each row.
fn rows(px: DVec2) -> DVec2 {
    let (f, b) = (35.0 / 0.0055, 480.0);
    DVec2::new(px.x - b - b * (libm::hypot(1.0, px.y / f) - 1.0), px.y)
}

/// The direction, scaled to z = 1, that the exact pinhole of a toed-in prism gives a pixel: before the prism it is (px + b, f), and the
/// component along the line from O to O' is stretched m times: a linear map, so that straight lines stay straight.
fn turned_pinhole(px: DVec2, centre: DVec3, m: f64) -> DVec2 {
    let f = 35.0 / 0.0055;
    let e = centre.normalize();
    let before = DVec3::new(px.x, px.y, f);
    let behind = before + e * ((m - 1.0) * before.dot(e));
    behind.truncate() / behind.z * f
}

/// m of a toed-in prism, from one ray, that through the middle of the right half: behind it runs along (g_x, g_z), so that
/// (before + k e) has that slope for one k, which is (m - 1) before . e.
fn stretch_of(system: &System, centre: DVec3) -> f64 {
    let ray = system.exit_ray(DVec2::new(1440.0, 540.0)).expect("it passes").0;
    let (e, before, slope) =
        (centre.normalize(), DVec3::new(480.0, 0.0, 35.0 / 0.0055), ray.direction.x / ray.direction.z);
    1.0 + (slope * before.z - before.x) / (e.x - slope * e.z) / before.dot(e)
}

/// Both ends of the depths, from 0.3 m to infinity, for what is wrong between is linear in the inverse of the depth.
const ENDS_MM: [f64; 2] = [1.0 / 300.0, 0.0];

#[test]
fn every_ray_goes_where_the_law_of_rows_says() {
    // What least squares of the paper's size leave: each two degrees a hundredth.
    for (degree, [most_u, most_v]) in [(5, [5e-4, 1e-4]), (7, [1e-5, 1e-6]), (9, [1e-7, 1e-8])] {
        let scene = exact(degree);
        let (system, centre) = (built(&scene), centre_of(&scene));
        for inverse_mm in ENDS_MM {
            let off = off_law_px(&system, centre, inverse_mm, rows);
            println!("epipolar, degree {degree}, 1/{inverse_mm:.4} mm: u {:.1e}, v {:.1e} px RMS", off.x, off.y);
            assert!(off.x < most_u && off.y < most_v, "degree {degree}: {off}");
        }
    }
}

/// The surfaces of revolution themselves: v by symmetry, to the rounding of a ray; u to what the series of their profiles
/// leaves.
#[test]
fn surfaces_of_revolution_are_exact() {
    let scene = designed_by("objective = \"epipolar\"\nsurface = \"revolved\"");
    let (system, centre) = (built(&scene), centre_of(&scene));
    for inverse_mm in ENDS_MM {
        let off = off_law_px(&system, centre, inverse_mm, rows);
        println!("epipolar, revolved, 1/{inverse_mm:.4} mm: u {:.1e}, v {:.1e} px RMS", off.x, off.y);
        assert!(off.x < 1e-8 && off.y < 1e-12, "{off}");
    }
    for z in ["", "virtual_camera_z_mm = -20.0", "virtual_camera_z_mm = 9.0"] {
        let scene = designed_by(&format!("objective = \"toed-in\"\nsurface = \"revolved\"\n{z}"));
        let (system, centre) = (built(&scene), centre_of(&scene));
        let m = stretch_of(&system, centre);
        for inverse_mm in ENDS_MM {
            let off = off_law_px(&system, centre, inverse_mm, |px| turned_pinhole(px, centre, m));
            println!(
                "toed-in at {:.3}, revolved, 1/{inverse_mm:.4} mm: u {:.1e}, v {:.1e} px RMS",
                centre.z, off.x, off.y
            );
            assert!(off.max_element() < 1e-8, "{z}: {off}");
        }
    }
}

/// Polynomials through them leave a hundredth each two degrees.
#[test]
fn toed_in_polynomials_are_pinholes() {
    for (degree, most) in [(5, 2e-4), (7, 2e-6)] {
        let scene = designed_by(&format!("objective = \"toed-in\"\ndegree = {degree}"));
        let (system, centre) = (built(&scene), centre_of(&scene));
        let m = stretch_of(&system, centre);
        for inverse_mm in ENDS_MM {
            let off = off_law_px(&system, centre, inverse_mm, |px| turned_pinhole(px, centre, m));
            println!("toed-in, degree {degree}, 1/{inverse_mm:.4} mm: u {:.1e}, v {:.1e} px RMS", off.x, off.y);
            assert!(off.length() < most, "degree {degree}: {off}");
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

/// Errors of manufacture and reflections of surfaces of revolution are those of polynomials of degree 9 through them.
#[test]
fn errors_and_ghosts_are_those_of_the_polynomials() {
    let effects = "[effect.fresnel]\n[effect.ghosts]\n[effect.manufacture]\nthickness_mm = 0.02\nindex = 1e-4\n\
                   [effect.manufacture.front]\ndecentre_mm = [0.02, -0.01, 0.0]\ntilt_deg = [0.02, -0.03, 0.05]\n\
                   zernike = { radius_mm = 16.0, terms = [[2, 2, 0.5], [3, -1, 0.3]] }\n[effect.manufacture.back]\n\
                   waves = [{ amplitude_um = 0.05, period_mm = 3.0 }]\n";
    for objective in ["epipolar", "toed-in"] {
        let made = |surface: &str| {
            let keys = format!("objective = \"{objective}\"\nsurface = \"{surface}\"\ndegree = 9\n{effects}");
            built(&designed_by(&keys))
        };
        let [exact, fitted] = ["revolved", "polynomial"].map(made);
        let (mut exits, mut bounced) = (0, 0);
        for px in pixels().step_by(7) {
            // Away from ridge and rim, where reflected light may end at the one and not at the other.
            let full = DVec2::new(1150.0 + 0.6 * px.x, 540.0 + 0.6 * px.y);
            let [(a, _), (b, _)] = [&exact, &fitted].map(|system| system.exit_ray(full).expect("it passes"));
            // What the polynomials leave is 1e-7 px, of 6400 px a rad, and 1e-9 mm.
            assert!((a.direction - b.direction).length() < 1e-10 && (a.origin - b.origin).length() < 1e-7, "{full}");
            let ghosts = exact.effects().ghosts.expect("the scene has them");
            let all = [&exact, &fitted].map(|system| {
                let mut all = Vec::new();
                let body = system.body().expect("there is glass");
                system.reflected(full, PolarisationState::Unpolarised, body, &ghosts, |exit| all.push(*exit));
                all
            });
            let [a, b] = &all;
            for a in a {
                // Where the one has glass beyond the other's rim, the one has light that the other has not.
                let Some(b) = b.iter().find(|b| b.route == a.route) else { continue };
                exits += 1;
                bounced = bounced.max(a.bounces);
                assert!((a.power - b.power).abs() < 1e-9, "{full}: {a:?} {b:?}");
                assert!((a.ray.direction - b.ray.direction).length() < 1e-8, "{full}: {a:?} {b:?}");
            }
        }
        assert!(exits > 100 && bounced >= 2, "{exits} {bounced}");
    }
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
