//! Does a prism as it was made show what its errors say?

use crate::instruments::{BOARD, FLAT, FREEFORM, built, scene};
use biprism::effect::manufacture::{Displacement, SurfaceError};
use biprism::effect::thin_lens::Aperture;
use biprism::effect::{Effects, Lens, Manufacture, Quadrature, Roughness, ThinLens, Variant};
use biprism::geom::Ray;
use biprism::render::{Class, render};
use biprism::scene::Scene;
use biprism::surface::face::Face;
use biprism::surface::figure_error::{FigureError, SurfaceWave, zernike};
use biprism::system::{Side, System};
use glam::{DVec2, DVec3};

const INDEX: f64 = 1.48;

fn flat(keys: &str) -> Scene {
    scene(160, 90, &format!("{FLAT}\n{keys}"), BOARD)
}

fn made(scene: &Scene, errors: Manufacture) -> System {
    let effects = Effects { manufacture: Some(errors), ..Effects::default() };
    built(&Scene { effects, ..scene.clone() })
}

fn places() -> impl Iterator<Item = DVec2> {
    (0..9).flat_map(|j| (0..16).map(move |i| DVec2::new(5.0 + 10.0 * f64::from(i), 5.0 + 10.0 * f64::from(j))))
}

/// Both see the same everywhere, to `mm` on the board.
fn agree(a: &System, b: &System, mm: f64) {
    for px in places() {
        let (a, b) = (a.trace(px).unwrap(), b.trace(px).unwrap());
        assert!(a.side == b.side && (a.board_mm - b.board_mm).length() <= mm, "{px}: {a:?} {b:?}");
    }
}

/// A whole prism out of place is the prism that a scene puts there; and thickness and index are those of the scene.
#[test]
fn errors_of_the_whole_are_those_of_another_scene() {
    let angle = "facet_angle_deg = 8";
    let (decentre_mm, tilt_rad) = (DVec3::new(0.3, -0.2, 0.5), DVec3::new(0.01, -0.02, 0.03));
    let moved = Displacement { decentre_mm, tilt_rad };
    // The scene turns about the origin of the prism's frame, an error about the ridge: R (p - q) + q + d.
    let pivot = DVec3::new(0.0, 0.0, 78.472);
    let turn = biprism::geom::Pose::new(DVec3::ZERO, tilt_rad);
    let at = pivot + decentre_mm - turn.vector(pivot);
    let tilt = tilt_rad.map(f64::to_degrees);
    let placed = flat(&format!(
        "{angle}\nposition_mm = [{:?}, {:?}, {:?}]\ntilt_deg = [{:?}, {:?}, {:?}]",
        at.x, at.y, at.z, tilt.x, tilt.y, tilt.z
    ));
    // Roundings of metres, through two more rotations.
    agree(&made(&flat(angle), Manufacture { prism: moved, ..Manufacture::default() }), &built(&placed), 1e-10);

    let thick = flat(angle);
    let mut thicker = thick.clone();
    let mut denser = thick.clone();
    if let biprism::scene::PrismSpec::Flat(prism) = &mut thicker.prism {
        prism.thickness_mm += 0.25;
    }
    if let biprism::scene::PrismSpec::Flat(prism) = &mut denser.prism {
        prism.body.index += 1e-3;
    }
    agree(&made(&thick, Manufacture { thickness_mm: 0.25, ..Manufacture::default() }), &built(&thicker), 1e-10);
    agree(&made(&thick, Manufacture { index: 1e-3, ..Manufacture::default() }), &built(&denser), 0.0);
}

/// The facets of a design are those of the ideal glass: an error of the index does not design another prism.
#[test]
fn errors_do_not_change_the_design() {
    let (given, with_error) =
        (built(&flat("")), made(&flat(""), Manufacture { index: 0.01, ..Manufacture::default() }));
    let (given, with_error) = (given.prism().unwrap(), with_error.prism().unwrap());
    assert_eq!(given.surface(Side::Right, Face::Front), with_error.surface(Side::Right, Face::Front));
    assert!(given.indices()[1] + 0.01 == with_error.indices()[1]);
}

/// Snell's law with the normal towards the light, written for this test: n1 (i x N) = n2 (t x N).
fn snell(i: DVec3, normal: DVec3, n1: f64, n2: f64) -> DVec3 {
    let normal = if normal.dot(i) > 0.0 { normal } else { -normal };
    let along = i - normal * normal.dot(i);
    let across = along * (n1 / n2);
    across + normal * (1.0 - across.length_squared()).sqrt()
}

/// A ray through two planes, each by a point and a normal.
fn through(ray: &Ray, planes: [(DVec3, DVec3); 2]) -> Ray {
    let [a, b] = planes;
    let intersect = |ray: &Ray, (point, normal): (DVec3, DVec3)| {
        ray.origin + ray.direction * ((point - ray.origin).dot(normal) / ray.direction.dot(normal))
    };
    let inside = Ray { origin: intersect(ray, a), direction: snell(ray.direction, a.1, 1.0, INDEX) };
    Ray { origin: intersect(&inside, b), direction: snell(inside.direction, b.1, INDEX, 1.0) }
}

/// Front and back, each out of place by itself, against planes turned by hand.
#[test]
fn surfaces_out_of_place_are_turned_planes() {
    let ideal = flat("facet_angle_deg = 8");
    let front = Displacement { decentre_mm: DVec3::new(0.2, 0.1, -0.1), tilt_rad: DVec3::new(0.004, 0.006, -0.01) };
    let back = Displacement { decentre_mm: DVec3::new(-0.1, 0.3, 0.2), tilt_rad: DVec3::new(-0.008, 0.003, 0.02) };
    let error = |place| SurfaceError { place, figure: None };
    let errors = Manufacture { front: error(front), back: error(back), thickness_mm: 0.1, ..Manufacture::default() };
    let system = made(&ideal, errors);
    let ridge = DVec3::new(0.0, 0.0, 78.472);
    let base = DVec3::new(0.0, 0.0, 78.472 + 8.545);
    let turned = |place: &Displacement, v: DVec3| biprism::geom::Pose::new(DVec3::ZERO, place.tilt_rad).vector(v);
    let (sin, cos) = libm::sincos(8.0f64.to_radians());
    for px in places() {
        let ray = system.camera().ray(px);
        let (out, side) = system.exit_ray(px).unwrap();
        let sign = if side == biprism::system::Side::Right { 1.0 } else { -1.0 };
        let facet = turned(&front, DVec3::new(-sign * sin, 0.0, cos));
        let planes =
            [(ridge + front.decentre_mm, facet), (base + back.decentre_mm + DVec3::Z * 0.1, turned(&back, DVec3::Z))];
        let expected = through(&ray, planes);
        assert!((out.direction - expected.direction).length() < 1e-14, "{px}");
        assert!((out.origin - expected.origin).length() < 1e-12, "{px}");
        // The ridge goes with the front: a ray belongs to the side of the ridge that it meets.
        let met = ray.at((planes[0].0 - ray.origin).dot(facet) / ray.direction.dot(facet));
        let across = turned(&front, DVec3::X).dot(met - planes[0].0);
        assert!(across * sign >= -1e-12, "{px}: {across}");
    }
}

/// An error of figure bends rays as its slope says: by (n - 1) times the slope at the back of a plate, to first order.
#[test]
fn errors_of_figure_bend_rays_by_their_slopes() {
    let plate = flat("facet_angle_deg = 0");
    let ideal = built(&plate);
    let wave = SurfaceWave { amplitude_mm: 2e-4, rad_per_mm: DVec2::new(1.2, -0.7), phase_rad: 0.5 };
    let terms = zernike(12.0, &[(2, 0, 1e-3), (3, 1, -5e-4), (2, -2, 5e-4)]).unwrap();
    let nothing = zernike(1.0, &[]).unwrap();
    for flaw in [FigureError { sag: terms, waves: vec![] }, FigureError { sag: nothing, waves: vec![wave] }] {
        let back = SurfaceError { figure: Some(flaw.clone()), ..SurfaceError::default() };
        let system = made(&plate, Manufacture { back, ..Manufacture::default() });
        for px in places() {
            let ((a, _), (b, _)) = (ideal.exit_ray(px).unwrap(), system.exit_ray(px).unwrap());
            let slope = |ray: &Ray| ray.direction.truncate() / ray.direction.z;
            let h = 1e-4;
            let height = |d: DVec2| flaw.jet(b.origin.x + d.x, b.origin.y + d.y).value;
            let gradient =
                DVec2::new(height(DVec2::X * h) - height(DVec2::X * -h), height(DVec2::Y * h) - height(DVec2::Y * -h))
                    / (2.0 * h);
            let expected = (INDEX - 1.0) * gradient;
            let found = slope(&b) - slope(&a);
            // Rays up to 0.17 rad off the normal: the square of that, and its like for the slopes themselves.
            assert!((found - expected).length() < 0.1 * expected.length() + 1e-9, "{px}: {found} {expected}");
            // On the axis it is exact to the square of the slope.
            if (px - DVec2::new(80.0, 45.0)).length() < 8.0 {
                assert!((found - expected).length() < 1e-3 * expected.length() + 1e-9, "{px}: {found} {expected}");
            }
        }
    }
}

/// The footprint at every place is the derivative of the looks.
fn footprints_are_derivatives(system: &System) {
    for px in places() {
        let h = 1e-4;
        let look = |d: DVec2| system.trace(px + d).unwrap().board_mm;
        let found = system.footprint(px).unwrap().jacobian;
        let x = (look(DVec2::X * h) - look(DVec2::X * -h)) / (2.0 * h);
        let y = (look(DVec2::Y * h) - look(DVec2::Y * -h)) / (2.0 * h);
        // Rounding of 200 mm over 2e-4 px, and third derivatives of waves: 3e-8.
        assert!((found.x_axis - x).length() < 1e-6 && (found.y_axis - y).length() < 1e-6, "{px}: {found} {x} {y}");
    }
}

/// The derivative of the picture of a flawed and moved prism is that of its looks, and so it is of a rough one: what aims
/// and exact pixels stand on.
#[test]
fn footprints_of_flawed_and_rough_prisms_are_derivatives() {
    let wave = SurfaceWave { amplitude_mm: 2e-4, rad_per_mm: DVec2::new(1.2, -0.7), phase_rad: 0.5 };
    let flaw = FigureError { sag: zernike(12.0, &[(2, 2, 1e-3)]).unwrap(), waves: vec![wave] };
    let place = Displacement { decentre_mm: DVec3::new(0.1, 0.2, 0.0), tilt_rad: DVec3::new(0.01, 0.004, 0.0) };
    let surface = SurfaceError { place, figure: Some(flaw) };
    let errors = Manufacture { front: surface.clone(), back: surface, ..Manufacture::default() };
    for prism in [FLAT, FREEFORM] {
        let system = made(&scene(160, 90, prism, BOARD), errors.clone());
        footprints_are_derivatives(&system);
        let slopes = [DVec2::new(0.09, -0.04), DVec2::new(-0.06, 0.05)];
        let rough = Variant { pupil: DVec2::ZERO, slopes, wave: None, grey: 1.0, colour: None };
        footprints_are_derivatives(&system.variant(&rough));
        footprints_are_derivatives(&built(&scene(160, 90, prism, BOARD)).variant(&rough));
    }
}

/// All levels see the same through a prism with every error; the map finds a way, and nothing is lost at its rim.
#[test]
fn made_prisms_look_alike_at_every_level() {
    use biprism::accuracy::Level;
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cases/effect_manufacture.toml");
    let scene = biprism::scene::load(std::path::Path::new(path)).unwrap_or_else(|problem| panic!("{problem}"));
    let system = built(&scene);
    let by = |level: Level| render(&system.with_accuracy(level.accuracy()), &());
    let [standard, exact] = [Level::Standard, Level::Exact].map(by);
    assert!(standard.class == exact.class);
    assert!(exact.class.as_ref().unwrap().data().iter().all(|class| matches!(class, Class::Left | Class::Right)));
    for (a, b) in standard.radiance.data().iter().zip(exact.radiance.data()) {
        // As in the tests of the map: differences of neighbours on these coarse pixels.
        assert!((a - b).abs() < 1e-5, "{a} {b}");
    }
}

/// An edge seen through a rough back is the normal distribution of (n - 1) slope times the distance to the board, and one
/// through a rough front that and (1 - 1/n) slope times the thickness: both to first order, at normal incidence.
#[test]
fn a_rough_surface_blurs_by_its_slopes() {
    let board = "columns = 2\nrows = 1\nsquare_mm = 2000.0\nposition_mm = [0.0, 0.0, 1000.0]\nmargin_mm = 0";
    let plain = scene(192, 10, &format!("{FLAT}\nfacet_angle_deg = 0"), board);
    let quadrature = Quadrature { points: 1024, ..Quadrature::default() };
    let mm_per_px = built(&plain).footprint(DVec2::new(96.5, 5.0)).unwrap().jacobian.x_axis.x;
    let away = 1000.0 - 78.472 - 8.545;
    for (slope, reach) in
        [([0.0, 0.01], (INDEX - 1.0) * away), ([0.01, 0.0], (INDEX - 1.0) * away + (1.0 - 1.0 / INDEX) * 8.545)]
    {
        let effects = Effects { roughness: Some(Roughness { slope }), quadrature, ..Effects::default() };
        let film = render(&built(&Scene { effects, ..plain.clone() }), &());
        let sigma_px = 0.01 * reach / mm_per_px;
        assert!(sigma_px > 2.0);
        // The integral of the normal distribution: x P(x) + p(x).
        let integral = |x: f64| {
            let below = 0.5 * libm::erfc(-x / std::f64::consts::SQRT_2);
            x * below + libm::exp(-0.5 * x * x) / std::f64::consts::TAU.sqrt()
        };
        for (i, value) in film.radiance.row(5).iter().enumerate() {
            let place = |x: f64| (x - 96.0) / sigma_px;
            let white = (integral(place(i as f64 + 1.0)) - integral(place(i as f64))) * sigma_px;
            // log(n) / n of the even points; and the second order of the slopes and of a field of 0.02 rad.
            let bound = 0.8 * (libm::log(1024.0) / 1024.0 + 1e-3);
            assert!((f64::from(*value) - (0.05 + 0.8 * white)).abs() < bound, "{slope:?} {i}: {value} {white}");
        }
    }
}

/// Before a board that is white as far as one sees, every pixel is white unless rays end: a designed prism has glass for all
/// the rays that slopes, errors and an aperture turn away from those it was designed by.
#[test]
fn a_designed_prism_has_glass_for_rays_that_stray() {
    let board =
        "columns = 9\nrows = 9\nsquare_mm = 10\nposition_mm = [0, 0, 1000]\nblack = 1\nwhite = 1\nbackground = 1";
    let short = "kind = \"freeform\"\nindex = 1.5\nridge_distance_mm = 50\nthickness_mm = 8";
    let replicates = |replicates| Quadrature { points: 16, replicates, ..Quadrature::default() };
    let rough = |front_deg: f64, quadrature| Effects {
        roughness: Some(Roughness { slope: [front_deg, 2.0].map(|deg| libm::tan(deg.to_radians())) }),
        quadrature,
        ..Effects::default()
    };
    let made = |errors| Effects { manufacture: Some(errors), ..Effects::default() };
    let turned =
        |deg: [f64; 3]| Displacement { tilt_rad: DVec3::from(deg.map(f64::to_radians)), ..Displacement::default() };
    let place = |deg| SurfaceError { place: turned(deg), figure: None };
    let lens = ThinLens::new(8.0, 900.0, Aperture::Circle, 35.0);
    let cases = [
        ("rough", rough(5.0, replicates(1))),
        ("rough, random sets", rough(5.0, replicates(4))),
        ("rougher", rough(10.0, replicates(1))),
        ("rough before a lens", Effects { lens: Lens::Thin(lens), ..rough(5.0, replicates(1)) }),
        ("tilted", made(Manufacture { prism: turned([2.0, -1.0, 5.0]), ..Manufacture::default() })),
        ("front", made(Manufacture { front: place([1.0, 2.0, 3.0]), ..Manufacture::default() })),
        ("back", made(Manufacture { back: place([1.0, 2.0, -3.0]), ..Manufacture::default() })),
        ("thick", made(Manufacture { thickness_mm: 3.0, ..Manufacture::default() })),
        ("light", made(Manufacture { index: -0.2, ..Manufacture::default() })),
    ];
    for (prism, (what, effects)) in
        [FREEFORM, short].iter().flat_map(|prism| cases.iter().map(move |case| (prism, case)))
    {
        let film = render(&built(&Scene { effects: effects.clone(), ..scene(64, 36, prism, board) }), &());
        let darkest = film.radiance.data().iter().copied().fold(f32::INFINITY, f32::min);
        // Each pass rounds a pixel to f32, and so does their mean.
        assert!(1.0 - darkest <= 2.0 * f32::EPSILON, "{what}: {darkest} with {prism}");
    }
}
