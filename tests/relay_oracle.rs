//! Pencils of rays, their chief rays and their spots against Optiland's (`tests/oracle/relay.py`).

use biprism::analysis::relay::pencil::{Pencil, PencilRay, at_plane};
use biprism::analysis::relay::spot::PencilSpot;
use biprism::scene;
use biprism::system::{self, Side, System};
use glam::{DVec2, DVec3};
use std::fmt::Write;
use std::path::Path;

/// Lengths agree to this, in mm: the table's rays are 220 mm long, and some ten roundings of that are 3e-13 mm.
const LENGTH_MM: f64 = 1e-11;
/// Directions agree to this: some hundred roundings.
const DIRECTION: f64 = 1e-13;
/// Places in the plane of the spot, up to 112 mm beyond the surface, agree to this, in mm.
const PLANE_MM: f64 = LENGTH_MM + 112.0 * DIRECTION;
/// Sizes of spots agree to this part of themselves: the smallest is 1.3e-3 mm, of rays that agree to 1e-12 mm.
const SPOT: f64 = 1e-9;

/// The lines of a table, each with its fields.
fn rows(name: &str) -> Vec<Vec<String>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/oracle").join(name);
    let text = std::fs::read_to_string(path).expect("the table is committed");
    let rows = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    rows.map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn number(row: &[String], k: usize) -> f64 {
    row[k].parse().unwrap_or_else(|_| panic!("field {k} of {row:?}"))
}

fn built(prism: &str) -> System {
    let text = format!(
        "name = \"oracle\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = 1920\nheight_px = 1080\npixel_pitch_um = 5.5\n\
         {prism}\n[board]\ncolumns = 41\nrows = 41\nsquare_mm = 10.0\nposition_mm = [0.0, 0.0, 1000.0]\n"
    );
    let scene = scene::parse(&text, "oracle", None).unwrap_or_else(|problem| panic!("{problem}"));
    system::build(&scene).unwrap_or_else(|problem| panic!("{problem}"))
}

/// `kind = "polynomial"` of two surfaces, each by its terms [m, n, c] in mm.
fn polynomial(index: f64, front: &str, back: &str) -> String {
    let surface = |name: &str, terms: &str| {
        format!(
            "[prism.{name}]\ncentre_mm = [0.0, 0.0]\nscale_mm = [10.0, 10.0]\n\
             domain_mm = [[-30.0, 30.0], [-30.0, 30.0]]\nterms = [{terms}]\n"
        )
    };
    format!("[prism]\nkind = \"polynomial\"\nindex = {index:?}\n{}{}", surface("front", front), surface("back", back))
}

/// z = vertex + R - sqrt(R^2 - x^2 - y^2) to degree 20, in units of 10 mm across: of the next power 1e-16 mm are left at 8.7 mm
/// from the axis for a radius of 45 mm.
fn sphere(vertex_mm: f64, radius_mm: f64) -> String {
    let mut text = format!("[0, 0, {vertex_mm:?}]");
    // 1 - sqrt(1 - s) = sum of b_k s^k with b_1 = 1/2, b_k = b_(k-1) (2k - 3)/(2k).
    let (mut series, mut scale) = (1.0, radius_mm);
    for k in 1..=10u32 {
        series *= if k == 1 { 0.5 } else { f64::from(2 * k - 3) / f64::from(2 * k) };
        scale *= 100.0 / (radius_mm * radius_mm);
        // (x^2 + y^2)^k by the binomial coefficients.
        let mut binomial = 1.0;
        for j in 0..=k {
            let _ = write!(text, ", [{}, {}, {:?}]", 2 * (k - j), 2 * j, series * scale * binomial);
            binomial *= f64::from(k - j) / f64::from(j + 1);
        }
    }
    text
}

/// The plate of the table: the planes through z = 60 and z = 76 mm, whose normal is +z turned by -15 deg about x and then by 25 deg
/// about y.
fn plate() -> String {
    let (a, b) = (15f64.to_radians(), 25f64.to_radians());
    let normal = DVec3::new(libm::cos(a) * libm::sin(b), libm::sin(a), libm::cos(a) * libm::cos(b));
    let slope = -normal.truncate() / normal.z * 10.0;
    let plane = |z: f64| format!("[0, 0, {z:?}], [1, 0, {:?}], [0, 1, {:?}]", slope.x, slope.y);
    polynomial(1.62, &plane(60.0), &plane(76.0))
}

fn instrument(case: &str) -> System {
    match case {
        "lens" | "lens_beside" => built(&polynomial(1.5168, &sphere(80.0, 60.0), &sphere(89.0, -45.0))),
        "plate" => built(&plate()),
        "flat" => built("[prism]\nkind = \"flat\"\nindex = 1.48\nridge_distance_mm = 78.472\nthickness_mm = 8.545"),
        "freeform" => {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/oracle/prism.toml");
            built(&std::fs::read_to_string(path).expect("it is committed"))
        }
        _ => panic!("no case {case}"),
    }
}

/// The ray of a line of the table, held against it.
fn held(pencil: &Pencil, row: &[String], plane_mm: f64) -> PencilRay {
    let at = |k: usize| number(row, k);
    let ray = pencil.at(DVec2::new(at(4), at(5))).unwrap_or_else(|fate| panic!("{row:?} {fate:?}"));
    let off_mm = ray.exit.origin.distance(DVec3::new(at(6), at(7), at(8)));
    let turned = ray.exit.direction.distance(DVec3::new(at(9), at(10), at(11)));
    let longer_mm = (ray.optical_path_mm - at(12)).abs();
    let beside_mm = at_plane(&ray.exit, plane_mm).distance(DVec2::new(at(13), at(14)));
    assert!(
        off_mm < LENGTH_MM && turned < DIRECTION && longer_mm < LENGTH_MM && beside_mm < PLANE_MM,
        "{row:?}: {off_mm:e} {turned:e} {longer_mm:e} {beside_mm:e}"
    );
    ray
}

#[test]
fn chief_rays_and_spots_are_optiland_s() {
    let rays = rows("relay_rays.csv");
    let mut held_rays = 0;
    for spot in rows("relay_spots.csv") {
        let (case, plane_mm) = (spot[0].as_str(), number(&spot, 1));
        let system = instrument(case);
        let prism = system.prism().expect("it has one").continued();
        let own = |role: &'static str| rays.iter().filter(move |row| row[0] == case && row[1] == role);
        let first = own("chief").next().expect("a chief ray");
        let source = DVec3::new(number(first, 2), number(first, 3), 0.0);
        let pencil = Pencil::new(&system, &prism, Side::Right, source);
        let chief = held(&pencil, first, plane_mm).exit;
        let pupil: Vec<PencilRay> = own("pupil").map(|row| held(&pencil, row, plane_mm)).collect();
        held_rays += pupil.len();
        let found = PencilSpot::new(&pupil, &chief, plane_mm);
        for (k, found) in [found.rms_mm, found.rms_about_chief_mm, found.radius_mm].into_iter().enumerate() {
            let wanted = number(&spot, k + 2);
            println!("{case}: {found} mm for {wanted}, off by {:.1e} of it", found / wanted - 1.0);
            assert!((found / wanted - 1.0).abs() < SPOT, "{case}: {found} for {wanted}");
        }
    }
    assert_eq!(held_rays, 3 * 61 + 2 * 49);
}
