//! Polynomials for optics programs: Optiland's files against Optiland (`tests/oracle/export.py`) and against the surfaces, and
//! OpticStudio's terms by an evaluator of its own.

use super::*;
use crate::command::text;
use biprism::surface::face::Face;
use biprism::surface::shape::Surface;
use biprism::system::Side;
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;
use std::fs;

/// A twin of the sum of c x^m y^n, by plain powers.
fn sum(terms: impl IntoIterator<Item = (usize, usize, f64)>, x: f64, y: f64) -> f64 {
    let power = |base: f64, n: usize| (0..n).fold(1.0, |p, _| p * base);
    terms.into_iter().map(|(m, n, c)| c * power(x, m) * power(y, n)).sum()
}

/// Even places of a rectangle.
fn places(min: DVec2, max: DVec2) -> impl Iterator<Item = DVec2> {
    let even = |k: usize, step: f64| (k as f64 * step).fract();
    (0..500).map(move |k| min + (max - min) * DVec2::new(even(k, 0.754_877_666), even(k, 0.569_840_291)))
}

/// Rays of both halves meet the board where Optiland says that those through the exported files do.
#[test]
fn optiland_traces_the_same_rays() {
    let table = fs::read_to_string(repository("tests/oracle/export_optiland.csv")).expect("the table is committed");
    let mut systems: BTreeMap<String, System> = BTreeMap::new();
    let mut count = 0;
    for line in table.lines().filter(|line| !line.starts_with('#')).skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let at = |k: usize| fields[k].parse::<f64>().expect("a number");
        let system = systems.entry(fields[0].to_owned()).or_insert_with(|| built(&case(fields[0])));
        let seen = system.trace(DVec2::new(at(2), at(3))).unwrap_or_else(|fate| panic!("{line}: {fate:?}"));
        assert_eq!(seen.side == Side::Left, fields[1] == "left", "{line}");
        let apart = seen.board_mm.distance(DVec2::new(at(4), at(5)));
        assert!(apart < 1e-6, "{line}: {apart:e} mm");
        count += 1;
    }
    assert_eq!(count, 5 * 2 * 9);
}

/// What is written today is what the table was made from: the polynomials of both halves are the surfaces, and what is around them is
/// where it is.
#[test]
fn optiland_files_hold_the_surfaces() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["prism_freeform", "prism_tilted"] {
        exported(name, "optiland", folder.path(), &[]);
        let system = built(&case(name));
        let prism = system.prism().expect("it has one");
        for (side, file) in [(Side::Left, "left.json"), (Side::Right, "right.json")] {
            let written = fs::read_to_string(folder.path().join(file)).expect("written");
            let lens: Value = serde_json::from_str(&written).expect("JSON");
            let surfaces = &lens["surface_group"]["surfaces"];
            for (k, face) in [(2, Face::Front), (3, Face::Back)] {
                let geometry = &surfaces[k]["geometry"];
                let cs = |key: &str| number(&geometry["cs"][key]);
                let rows = geometry["coefficients"].as_array().expect("rows");
                let terms: Vec<(usize, usize, f64)> = rows
                    .iter()
                    .enumerate()
                    .flat_map(|(m, row)| {
                        row.as_array().expect("a row").iter().enumerate().map(move |(n, c)| (m, n, number(c)))
                    })
                    .collect();
                let sign = if side == Side::Left { -1.0 } else { 1.0 };
                for at in places(DVec2::new(0.0, -6.0), DVec2::new(12.0, 6.0)) {
                    let at = at * DVec2::new(sign, 1.0);
                    let z = cs("z") + sum(terms.iter().copied(), at.x - cs("x"), at.y - cs("y"));
                    assert!(
                        (z - prism.surface(side, face).height_mm(at.x, at.y)).abs() < 1e-12,
                        "{name} {file} {k} {at}"
                    );
                }
            }
            assert_eq!([1, 2, 3].map(|k| number(&surfaces[k]["material_post"]["index"])), [1.0, 1.48, 1.0]);
            let board = prism.prism_from_world().point(DVec3::new(0.0, 0.0, 1000.0));
            let cs = &surfaces[4]["geometry"]["cs"];
            assert!(DVec3::new(number(&cs["x"]), number(&cs["y"]), number(&cs["z"])).distance(board) < 1e-9);
        }
    }
    // The image plane is turned as the board is.
    exported("board_tilted", "optiland", folder.path(), &[]);
    let written = fs::read_to_string(folder.path().join("right.json")).expect("written");
    let lens: Value = serde_json::from_str(&written).expect("JSON");
    for (key, degrees) in [("rx", 20.0f64), ("ry", -30.0), ("rz", 10.0)] {
        let turn = number(&lens["surface_group"]["surfaces"][4]["geometry"]["cs"][key]);
        assert!((turn - degrees.to_radians()).abs() < 1e-14, "{key}: {turn}");
    }
}

/// The parameters of a text: where each surface's vertex is, its radius, and its terms by the order that OpticStudio gives them.
fn parameters(text: &str, face: &str) -> (f64, f64, Vec<(usize, usize, f64)>) {
    let part = text.split(&format!("\n[{face}]\n")).nth(1).expect("its part").split("\n[").next().expect("a part");
    let vertex = part.lines().next().and_then(|line| line.split('\t').nth(1)).expect("a vertex");
    let values: BTreeMap<usize, f64> = part
        .lines()
        .filter_map(|line| {
            let mut fields = line.split('\t');
            Some((fields.next()?.parse().ok()?, fields.next()?.parse().ok()?))
        })
        .collect();
    // x, y, x^2, xy, y^2, x^3, x^2 y, ...
    let order = (1..=20usize).flat_map(|degree| (0..=degree).map(move |n| (degree - n, n)));
    let terms: Vec<_> = order.zip(15..).map_while(|((m, n), k)| Some((m, n, *values.get(&k)?))).collect();
    assert_eq!((values[&13], terms.len() + 2), (terms.len() as f64, values.len()));
    (vertex.parse().expect("a number"), values[&14], terms)
}

/// Evaluated by a twin, with y up, the terms are the surfaces to 1e-12 mm over all of the domain.
#[test]
fn extended_polynomials_are_the_surfaces() {
    let folder = tempfile::tempdir().expect("a folder");
    let odd = "[prism]\nkind = \"polynomial\"\nindex = 1.48\n[prism.front]\ncentre_mm = [6.0, 0.5]\nscale_mm = [6.0, 7.5]\n\
               domain_mm = [[-0.5, 13.0], [-7.0, 8.5]]\nterms = [[0, 0, 79.0], [1, 0, 0.9], [0, 1, 0.3], [2, 1, -0.02], [1, 3, 0.01], \
               [7, 0, 1e-4]]\n[prism.back]\ncentre_mm = [6.0, 0.0]\nscale_mm = [6.5, 7.0]\ndomain_mm = [[-1.0, 13.0], [-8.0, 8.0]]\n\
               terms = [[0, 0, 87.0]]\n";
    let odd = with_prism("prism_freeform", odd, folder.path());
    for scene in [case("prism_flat"), case("prism_epipolar"), odd] {
        let system = built(&scene);
        let prism = biprism::report::export::zemax_extended::ExtendedPrism::new(&system).expect("polynomials");
        let text = prism.text(&scene.name);
        for face in Face::ALL {
            let (vertex, radius, terms) = parameters(&text, ["front", "back"][face as usize]);
            let surface = system.prism().expect("it has one").surface(Side::Right, face);
            let (min, max) = match surface {
                Surface::Freeform(sheet) => (sheet.domain().min, sheet.domain().max),
                _ => (DVec2::new(-1.0, -8.0), DVec2::new(12.0, 8.0)),
            };
            for at in places(min, max) {
                let z = vertex + sum(terms.iter().copied(), at.x / radius, -at.y / radius);
                let off = (z - surface.height_mm(at.x, at.y)).abs();
                assert!(off < 1e-12, "{}, {face:?}, {at}: {off:e} mm", scene.name);
            }
        }
    }
}

/// What is no polynomial is refused with what to do, and leaves nothing behind.
#[test]
fn what_a_format_cannot_hold_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let refused = |name: &str, more: &[&str], words: &[&str]| {
        let path = repository(&format!("scenes/cases/{name}.toml")).display().to_string();
        let out: &[&str] = if more.contains(&"--out") { &[] } else { &["--out", "none"] };
        let done = biprism(folder.path(), &[&["export", path.as_str()], out, more].concat());
        let told = text(&done.stderr);
        assert_eq!(done.status.code(), Some(2), "{told}");
        assert!(words.iter().all(|word| told.contains(word)), "{more:?}: {told}");
        assert_eq!(fs::read_dir(folder.path()).expect("the folder").count(), 0, "{more:?}");
    };
    for format in ["optiland", "zemax-extended"] {
        refused("prism_revolved", &["--format", format], &["of revolution", format, "take zemax-grid or a solid"]);
        refused("prism_mesh", &["--format", format], &["are triangles", "take stl, ply or obj"]);
        refused("prism_none", &["--format", format], &["the scene has no prism", "a prism of two surfaces"]);
    }
    refused("prism_mesh", &["--format", "zemax-grid"], &["no exact derivatives", "take stl, ply or obj"]);
    refused("effect_telecentric", &["--format", "optiland"], &["telecentric", "another format"]);
    refused("prism_flat", &["--format", "optiland", "--tolerance-mm", "1"], &["strays from nothing", "leave it out"]);
    refused("prism_freeform", &["--format", "zemax-grid", "--tolerance-mm", "1e-16"], &["more than 1000000 points"]);
    refused("prism_freeform", &["--format", "stl", "--tolerance-mm", "1e-9"], &["4000000 triangles", "ask for more"]);
    refused("prism_flat", &["--format", "stl", "--out", "a.ply"], &["the extension is \"ply\"", "\"stl\""]);
    for bad in ["0", "-1", "nan", "thick"] {
        refused("prism_flat", &["--format", "stl", &format!("--tolerance-mm={bad}")], &["a number above 0"]);
    }
}
