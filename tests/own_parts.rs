//! What users bring as surfaces: point clouds, meshes and closed bodies, right or refused with the next step.

#![allow(clippy::unwrap_used, reason = "a test fails by a panic")]

use biprism::io::mesh::{MeshFormat, parse_mesh};
use biprism::render::render;
use biprism::scene::{self, Scene};
use biprism::system::{self, System};
use glam::{DVec2, DVec3};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The front of the tests: a facet with a little of every power, odd ones of y included where `odd` is not 0.
fn front(x: f64, y: f64, odd: f64) -> f64 {
    40.0 + 0.2 * x - 2e-3 * x * x + 1e-3 * y * y + 3e-5 * x * x * x - 2e-6 * x * y * y * y * y
        + odd * y * (1.0 + 0.01 * x)
}

fn back(x: f64, y: f64) -> f64 {
    46.0 + 1e-3 * x + 2e-4 * y * y
}

/// Points of a surface over x in `xs`, y in -12..12, as CSV.
fn csv(xs: [f64; 2], z: impl Fn(f64, f64) -> f64) -> String {
    points(xs)
        .map(|p| (p.x, p.y, z(p.x, p.y)))
        .fold("x,y,z\n".to_owned(), |text, (x, y, z)| text + &format!("{x:?},{y:?},{z:?}\n"))
}

fn points([low, high]: [f64; 2]) -> impl Iterator<Item = DVec2> {
    let along = |k: usize, low: f64, high: f64, n: usize| low + (high - low) * k as f64 / (n - 1) as f64;
    (0..23 * 19).map(move |k| DVec2::new(along(k % 23, low, high, 23), along(k / 23, -12.0, 12.0, 19)))
}

const RIGHT: [f64; 2] = [-1.0, 16.0];

struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    /// A scene with this `[prism]` table, on a sensor of 96 x 80 px.
    fn scene(&self, prism: &str) -> PathBuf {
        self.scene_with(prism, "")
    }

    fn scene_with(&self, prism: &str, more: &str) -> PathBuf {
        let text = format!(
            "name = \"own\"\n[camera]\nfocal_length_mm = 25.0\nwidth_px = 96\nheight_px = 80\npixel_pitch_um = 88.0\n\
             [prism]\nindex = 1.5168\n{prism}\n[board]\ncolumns = 21\nrows = 15\nsquare_mm = 12.0\n\
             position_mm = [0.0, 0.0, 600.0]\n{more}\n"
        );
        let path = self.path().join("scene.toml");
        fs::write(&path, text).unwrap();
        path
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.path().join(name), bytes).unwrap();
    }

    fn run(&self, args: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_biprism")).current_dir(self.path()).args(args).output().unwrap()
    }

    /// The instrument of a prism, and what `check` says of it in words.
    fn built(&self, prism: &str) -> System {
        built(&scene::load(&self.scene(prism)).unwrap_or_else(|problem| panic!("{problem}")))
    }

    /// The doubts of a prism that can be.
    fn doubts(&self, prism: &str) -> Vec<String> {
        let scene = scene::load(&self.scene(prism)).unwrap_or_else(|problem| panic!("{problem}"));
        system::doubts(&scene, &built(&scene))
    }

    /// What is said of a prism that cannot be.
    fn refused(&self, prism: &str) -> String {
        let problem = scene::load(&self.scene(prism)).and_then(|scene| system::build(&scene).map(|_| ()));
        let words = problem.expect_err(prism).to_string();
        let out = self.run(&["check", "scene.toml"]);
        assert_eq!(out.status.code(), Some(2), "{}", said(&out.stderr));
        words
    }
}

fn said(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn built(scene: &Scene) -> System {
    system::build(scene).unwrap_or_else(|problem| panic!("{problem}"))
}

fn clouds(front: &str, back: &str) -> String {
    format!("kind = \"point_cloud\"\nfront = {{ {front} }}\nback = {{ {back} }}")
}

const FRONT: &str = "file = \"front.csv\", degree = 5";
const BACK: &str = "file = \"back.csv\", degree = 2";

/// A place with the two clouds of the tests.
fn good() -> Place {
    let place = Place::new();
    place.write("front.csv", csv(RIGHT, |x, y| front(x, y, 0.0)));
    place.write("back.csv", csv(RIGHT, back));
    place
}

/// The farthest that what the two instruments see is apart, in mm on the board.
fn apart_mm(a: &System, b: &System) -> f64 {
    let places = (0..300).map(|k| {
        DVec2::new(96.0 * (f64::from(k) * 0.754_877_666).fract(), 80.0 * (f64::from(k) * 0.569_840_291).fract())
    });
    places.fold(0.0, |worst: f64, px| {
        let [a, b] = [a, b].map(|s| s.trace(px).unwrap_or_else(|fate| panic!("{px}: {fate:?}")));
        assert_eq!(a.side, b.side);
        worst.max(a.board_mm.distance(b.board_mm))
    })
}

#[test]
fn clouds_keep_the_odd_powers_of_y() {
    let place = good();
    let untilted = place.built(&clouds(FRONT, BACK));
    let tilt = 0.02;
    place.write("back.csv", csv(RIGHT, |x, y| back(x, y) + tilt * y));
    let tilted = place.built(&clouds(FRONT, BACK));
    assert!(apart_mm(&untilted, &tilted) > 4.0, "a tilt of 20 mrad moves what is seen by about 5.7 mm");
    let domain = "centre_mm = [0, 0]\nscale_mm = [1, 1]\ndomain_mm = [[-1.3, 16.3], [-12.4, 12.4]]";
    let polynomial = place.built(&format!(
        "kind = \"polynomial\"\n[prism.front]\n{domain}\nterms = [[0, 0, 40], [1, 0, 0.2], [2, 0, -2e-3], [0, 2, 1e-3], \
         [3, 0, 3e-5], [1, 4, -2e-6]]\n[prism.back]\n{domain}\nterms = [[0, 0, 46], [1, 0, 1e-3], [0, 2, 2e-4], [0, 1, {tilt}]]"
    ));
    // Rounding of points near 46 mm through a fit of condition 1e3 or so.
    assert!(apart_mm(&polynomial, &tilted) < 1e-9, "{:e}", apart_mm(&polynomial, &tilted));
    // The front may be tilted as well, and a cloud that is said to be symmetric is held to it.
    place.write("front.csv", csv(RIGHT, |x, y| front(x, y, 0.01)));
    place.built(&clouds(FRONT, BACK));
    let words = place.refused(&clouds(&format!("{FRONT}, symmetric = true"), BACK));
    assert!(words.contains("`prism.front` (front.csv)") && words.contains("leave `symmetric` out"), "{words}");
    place.write("front.csv", csv(RIGHT, |x, y| front(x, y, 0.0)));
    let even = place.built(&clouds(&format!("{FRONT}, symmetric = true"), BACK));
    assert!(apart_mm(&even, &tilted) < 1e-9);
}

#[test]
fn what_a_fit_leaves_is_shown_everywhere() {
    let place = good();
    let low = clouds("file = \"front.csv\", degree = 2, max_residual_mm = 0.5", BACK);
    let scene = scene::load(&place.scene(&low)).unwrap();
    let rough = built(&scene);
    let right = place.built(&clouds(FRONT, BACK));
    place.scene(&low);
    let check = place.run(&["check", "scene.toml"]);
    assert!(check.status.success());
    let words = said(&check.stdout);
    assert!(
        words.contains("fit     front: degree 2 through 437 points leaves RMS") && words.contains("fit     back"),
        "{words}"
    );
    let json: Value = serde_json::from_slice(&place.run(&["check", "scene.toml", "--json"]).stdout).unwrap();
    let fit = &json["surface_fits"]["front"];
    let number = |key: &str| fit[key].as_f64().unwrap_or_else(|| panic!("{key}: {fit}"));
    assert!(number("max_mm") > number("rms_mm") && number("rms_mm") > 1e-3 && number("max_px") > 0.0);
    // Where the worst point is, the fit is off by the largest residual.
    let worst = fit["worst_mm"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect::<Vec<_>>();
    assert!((worst[2] - front(worst[0], worst[1], 0.0)).abs() < 1e-12);
    // What two degrees more would move is about what the right degree moves.
    let moved = (0..192).map(|k| DVec2::new(0.5 + f64::from(k % 16) * 6.0, 0.5 + f64::from(k / 16) * 6.5)).fold(
        0.0,
        |worst: f64, px| {
            let Ok(here) = rough.footprint(px) else { return worst };
            let there = right.footprint(px).unwrap().sight.board_mm;
            worst.max((here.jacobian.inverse() * (there - here.sight.board_mm)).length())
        },
    );
    let ratio = number("finer_px") / moved;
    assert!(moved > 0.1 && ratio > 0.3 && ratio < 3.0, "{moved} {}", number("finer_px"));
    let render = place.run(&["render", "scene.toml", "--out", "a.png", "--out", "a.exr"]);
    assert!(said(&render.stderr).contains("fit of the front: degree 2"), "{}", said(&render.stderr));
    let measure = place.run(&["measure", "a.exr", "--scene", "scene.toml", "--json"]);
    let report: Value = serde_json::from_slice(&measure.stdout).unwrap_or_else(|_| panic!("{}", said(&measure.stderr)));
    assert_eq!(report["designs"][0]["surface_fits"]["front"]["max_mm"], fit["max_mm"]);
}

/// A sag that is higher by r moves what is seen by `max_px` of a residual of r.
#[test]
fn the_px_of_a_sag_are_those_of_the_ray() {
    let place = good();
    let system = place.built(&clouds(FRONT, BACK));
    let scene = scene::load(&place.path().join("scene.toml")).unwrap();
    let [front, _] = biprism::analysis::fit_shift::fit_shifts(&scene, &system).unwrap();
    let at = front.residuals.worst_mm;
    place.write("front.csv", csv(RIGHT, |x, y| self::front(x, y, 0.0) + 0.01));
    let raised = place.built(&clouds(FRONT, BACK));
    let px = (0..96 * 80).map(|k| DVec2::new(0.5 + f64::from(k % 96), 0.5 + f64::from(k / 96)));
    let near = px.min_by(|a, b| {
        let far = |px: &DVec2| system.path(*px).0.points[0].truncate().abs().distance(DVec2::new(at.x, at.y.abs()));
        far(a).total_cmp(&far(b))
    });
    let here = system.footprint(near.unwrap()).unwrap();
    let moved =
        (here.jacobian.inverse() * (raised.trace(near.unwrap()).unwrap().board_mm - here.sight.board_mm)).length();
    let told = front.px_per_mm.unwrap() * 0.01;
    // The grid of rays is 1/20 of the picture, over which the deviation changes by a few percent.
    assert!((told / moved - 1.0).abs() < 0.2, "{told} {moved}");
}

#[test]
fn clouds_that_do_not_fit_are_refused_with_what_is_wrong() {
    let place = good();
    // A degree that is too low.
    let words = place.refused(&clouds("file = \"front.csv\", degree = 2", BACK));
    assert!(
        words.contains("lies") && words.contains("`max_residual_mm` is 0.001") && words.contains("write `degree = 5`"),
        "{words}"
    );
    // Two points far off, by their numbers and places.
    let text = csv(RIGHT, |x, y| front(x, y, 0.0));
    let spoilt: Vec<String> = text
        .lines()
        .enumerate()
        .map(|(k, line)| {
            let [x, y, z] = [0, 1, 2].map(|i| line.split(',').nth(i).unwrap().to_owned());
            match k {
                100 => format!("{x},{y},{}", z.parse::<f64>().unwrap() + 0.05),
                200 => format!("{x},{y},900"),
                _ => line.to_owned(),
            }
        })
        .collect();
    place.write("spoilt.csv", spoilt.join("\n"));
    let words = place.refused(&clouds("file = \"spoilt.csv\", degree = 5", BACK));
    assert!(
        words.contains("without 2 outliers the rest fits: point 200 at") && words.contains("point 100 at"),
        "{words}"
    );
    assert!(words.contains("remove them from the file, or write `max_residual_mm = "), "{words}");
    // Noise has no cure but a larger tolerance, and what is offered is enough.
    let noise = |x: f64, y: f64| 0.05 * (1e4 * libm::sin(12.9898 * x + 78.233 * y)).fract();
    place.write("noisy.csv", csv(RIGHT, |x, y| front(x, y, 0.0) + noise(x, y)));
    let words = place.refused(&clouds("file = \"noisy.csv\", degree = 5", BACK));
    let offered =
        words.split("`max_residual_mm = ").nth(1).unwrap_or_else(|| panic!("{words}")).split('`').next().unwrap();
    place.built(&clouds(&format!("file = \"noisy.csv\", degree = 5, max_residual_mm = {offered}"), BACK));
    // Both facets, and a ridge somewhere else.
    place.write("whole.csv", csv([-16.0, 16.0], |x, y| front(x.abs(), y, 0.0)));
    let words = place.refused(&clouds("file = \"whole.csv\", degree = 5", BACK));
    assert!(words.contains("kink at x = 0") && words.contains("the right half only"), "{words}");
    place.write("whole.csv", csv([0.0, 32.0], |x, y| front((x - 15.0).abs(), y, 0.0)));
    let words = place.refused(&clouds("file = \"whole.csv\", degree = 5", BACK));
    assert!(words.contains("a kink near x = 15") && words.contains("`offset_mm = [-15"), "{words}");
    // Front and back in one file.
    let both = csv(RIGHT, |x, y| front(x, y, 0.0)) + csv(RIGHT, back).trim_start_matches("x,y,z\n");
    place.write("both.csv", both);
    let words = place.refused(&clouds("file = \"both.csv\", degree = 5", BACK));
    assert!(words.contains("two sheets") && words.contains("a file each"), "{words}");
}

#[test]
fn units_and_frames_of_a_cloud_are_brought_to_the_prism() {
    let place = good();
    let plain = place.built(&clouds(FRONT, BACK));
    let moved = |name: &str, key: &str, change: &dyn Fn(DVec3) -> DVec3| {
        let text = points(RIGHT).map(|p| change(p.extend(front(p.x, p.y, 0.0))));
        place.write(name, text.fold("x,y,z\n".to_owned(), |t, p| t + &format!("{:?},{:?},{:?}\n", p.x, p.y, p.z)));
        let same = place.built(&clouds(&format!("file = \"{name}\", degree = 5, {key}"), BACK));
        let apart = apart_mm(&plain, &same);
        assert!(apart < 1e-8, "{key}: {apart:e}");
    };
    moved("m.csv", "unit = \"m\"", &|p| p / 1000.0);
    moved("um.csv", "unit = \"um\"", &|p| p * 1000.0);
    moved("in.csv", "unit = \"in\"", &|p| p / 25.4);
    moved("vertex.csv", "offset_mm = [0, 0, 40]", &|p| p - DVec3::Z * 40.0);
    moved("left.csv", "flip = \"x\"", &|p| DVec3::new(-p.x, p.y, p.z));
    // Lens programs count sag towards the camera, each from its vertex, some in metres.
    moved("z.csv", "unit = \"m\", flip = [\"z\"], offset_mm = [0, 0, 40]", &|p| {
        DVec3::new(p.x, p.y, 40.0 - p.z) / 1000.0
    });
    // The pose comes last: tilted about the origin of the surface, then moved.
    let pose = biprism::geom::Pose::new(DVec3::new(0.5, -1.0, 40.0), DVec3::new(0.0, 0.0, 0.1));
    moved(
        "pose.csv",
        &format!(
            "flip = \"y\", offset_mm = [0, 0, -2], pose = {{ position_mm = [0.5, -1, 40], tilt_deg = [0, 0, {:?}] }}",
            0.1f64.to_degrees()
        ),
        &|p| {
            let own = pose.inverse().point(p) + DVec3::Z * 2.0;
            DVec3::new(own.x, -own.y, own.z)
        },
    );
}

/// A box of glass with the facet of the tests' flat prism on its lower side, over x in `low`..16; quads of two triangles.
fn body(low: f64) -> Vec<[DVec3; 3]> {
    let facet = |x: f64| 40.0 + 0.2 * x.abs();
    let columns: Vec<f64> = if low < 0.0 { vec![low, 0.0, 16.0] } else { vec![low, 16.0] };
    let mut triangles = Vec::new();
    let mut quad = |a: DVec3, b: DVec3, c: DVec3, d: DVec3| triangles.extend([[a, b, c], [a, c, d]]);
    let at = |x: f64, y: f64, top: bool| DVec3::new(x, y, if top { 47.0 } else { facet(x) });
    for pair in columns.windows(2) {
        let [p, q] = [pair[0], pair[1]];
        quad(at(p, -12.0, false), at(p, 12.0, false), at(q, 12.0, false), at(q, -12.0, false));
        quad(at(p, -12.0, true), at(q, -12.0, true), at(q, 12.0, true), at(p, 12.0, true));
        quad(at(p, -12.0, false), at(q, -12.0, false), at(q, -12.0, true), at(p, -12.0, true));
        quad(at(p, 12.0, false), at(p, 12.0, true), at(q, 12.0, true), at(q, 12.0, false));
    }
    let (first, last) = (columns[0], 16.0);
    quad(at(first, -12.0, false), at(first, -12.0, true), at(first, 12.0, true), at(first, 12.0, false));
    quad(at(last, -12.0, false), at(last, 12.0, false), at(last, 12.0, true), at(last, -12.0, true));
    triangles
}

fn ascii_stl(triangles: &[[DVec3; 3]]) -> String {
    let facets = triangles.iter().map(|t| {
        let corners = t.iter().fold(String::new(), |s, p| s + &format!("      vertex {:?} {:?} {:?}\n", p.x, p.y, p.z));
        format!("  facet normal 0 0 0\n    outer loop\n{corners}    endloop\n  endfacet\n")
    });
    format!("solid glass\n{}endsolid glass\n", facets.collect::<String>())
}

/// Binary, though it begins with the word of the ascii ones, as some programs write it.
fn binary_stl(triangles: &[[DVec3; 3]]) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes[..5].copy_from_slice(b"solid");
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for t in triangles {
        bytes.extend([0; 12]);
        t.iter().flat_map(|p| p.to_array()).for_each(|v| bytes.extend((v as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn obj(triangles: &[[DVec3; 3]]) -> String {
    let corners = triangles.iter().flatten().map(|p| format!("v {:?} {:?} {:?}\n", p.x, p.y, p.z)).collect::<String>();
    corners
        + &(0..triangles.len()).map(|k| format!("f {} {} {}\n", 3 * k + 1, 3 * k + 2, 3 * k + 3)).collect::<String>()
}

/// The same prism as two polynomials.
fn as_polynomials(place: &Place) -> System {
    let domain = "centre_mm = [0, 0]\nscale_mm = [1, 1]\ndomain_mm = [[-2, 16], [-12, 12]]";
    place.built(&format!(
        "kind = \"polynomial\"\n[prism.front]\n{domain}\nterms = [[0, 0, 40], [1, 0, 0.2]]\n[prism.back]\n{domain}\nterms = [[0, 0, 47]]"
    ))
}

#[test]
fn a_closed_body_is_a_prism() {
    let place = Place::new();
    let wanted = as_polynomials(&place);
    let picture = render(&wanted, &|_| ());
    for (low, halves) in [(0.0, "the left one is its mirror image"), (-16.0, "spans both halves")] {
        let body = body(low);
        // Wound the other way round it is the same glass.
        let turned: Vec<_> = body.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
        place.write("a.stl", ascii_stl(&body));
        place.write("b.stl", binary_stl(&turned));
        place.write("c.obj", obj(&body));
        for file in ["a.stl", "b.stl", "c.obj"] {
            let prism = format!("kind = \"mesh\"\nbody = \"{file}\"");
            let apart = apart_mm(&wanted, &place.built(&prism));
            // f32 keeps 47 mm to 4e-6 mm; that tilts a surface of 16 mm by 3e-7 rad, and 550 mm lie behind it.
            assert!(apart < if file == "b.stl" { 3e-4 } else { 1e-10 }, "{file}, {low}: {apart:e}");
            let doubts = place.doubts(&prism);
            assert!(
                doubts.len() == 1 && doubts[0].contains("is a closed body") && doubts[0].contains(halves),
                "{doubts:?}"
            );
        }
        let seen = render(&place.built("kind = \"mesh\"\nbody = { file = \"c.obj\", unit = \"mm\" }"), &|_| ());
        let off =
            picture.radiance.data().iter().zip(seen.radiance.data()).fold(0.0f32, |w, (a, b)| w.max((a - b).abs()));
        assert!(off < 1e-5, "{low}: {off}");
        let check = place.run(&["render", "scene.toml", "--out", "a.png"]);
        assert!(check.status.success() && said(&check.stderr).contains("note: `prism.body` is a closed body"));
    }
}

/// A body whose halves differ is used as it is: the right half agrees with a symmetric one, the left does not.
#[test]
fn an_asymmetric_body_has_two_halves_of_its_own() {
    let place = Place::new();
    let wanted = as_polynomials(&place);
    let lowered = |p: DVec3| if p.x < 0.0 && p.z < 46.9 { p - DVec3::Z } else { p };
    let body: Vec<_> = body(-16.0).into_iter().map(|t| t.map(lowered)).collect();
    place.write("a.obj", obj(&body));
    let system = place.built("kind = \"mesh\"\nbody = \"a.obj\"");
    let apart = |px: DVec2| system.trace(px).unwrap().board_mm.distance(wanted.trace(px).unwrap().board_mm);
    assert!(apart(DVec2::new(70.0, 30.0)) < 1e-10 && apart(DVec2::new(26.0, 30.0)) > 1.0);
    assert!(!system.is_mirror_symmetric());
}

#[test]
fn bodies_that_are_none_are_refused() {
    let place = Place::new();
    let refused = |triangles: &[[DVec3; 3]]| {
        place.write("a.obj", obj(triangles));
        place.refused("kind = \"mesh\"\nbody = \"a.obj\"")
    };
    let whole = body(0.0);
    assert!(refused(&whole[..2]).contains("it is open"));
    let twice: Vec<_> = whole.iter().copied().chain(whole.iter().map(|t| t.map(|p| p + DVec3::Z * 20.0))).collect();
    assert!(refused(&twice).contains("more than two sheets"));
    place.write("a.obj", obj(&whole));
    for (prism, words) in [
        ("kind = \"mesh\"\nbody = \"a.obj\"\nfront = \"a.obj\"", "stands beside `prism.body`"),
        ("kind = \"mesh\"\nfront = \"a.obj\"", "`prism.back` is missing"),
        ("kind = \"mesh\"", "`prism.front` is missing"),
        ("kind = \"mesh\"\nbody = { file = \"b.obj\" }", "`prism.body.file` is \"b.obj\""),
        ("kind = \"mesh\"\nbody = \".\"", "is a directory"),
        ("kind = \"mesh\"\nbody = \"a.obj\"\nflip = \"x\"", "`prism.flip` is not a key"),
        ("kind = \"mesh\"\nbody = { file = \"a.obj\", flip = [\"x\", \"w\"] }", "`prism.body.flip[1]` is \"w\""),
        ("kind = \"mesh\"\nbody = { file = \"a.obj\", unit = \"cm\" }", "`prism.body.unit` is \"cm\""),
        ("kind = \"mesh\"\nbody = { file = \"a.obj\", unti = \"mm\" }", "`prism.body.unti`"),
    ] {
        assert!(place.refused(prism).contains(words), "{prism}: {}", place.refused(prism));
    }
}

#[test]
fn stl_files_are_read_or_refused() {
    let triangles = body(-16.0);
    let read = |bytes: &[u8]| parse_mesh("test", MeshFormat::Stl, bytes, bytes.len() as u64);
    let ascii = read(ascii_stl(&triangles).as_bytes()).unwrap();
    let binary = read(&binary_stl(&triangles)).unwrap();
    // 12 places, whatever the number of facets that name them.
    assert_eq!((ascii.points.len(), ascii.triangles.len()), (12, triangles.len()));
    assert_eq!(ascii.triangles, binary.triangles);
    let text = ascii_stl(&triangles);
    let whole = binary_stl(&triangles);
    let mut many = whole.clone();
    many[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    let mut nan = whole.clone();
    nan[96..100].copy_from_slice(&f32::NAN.to_le_bytes());
    for (bytes, words) in [
        (text.replacen("vertex", "vertx", 1).into_bytes(), "\"vertx\""),
        (text.replacen("vertex 0", "vertex zero", 1).into_bytes(), "finite number"),
        (text.replacen("endsolid", "", 1).into_bytes(), ""),
        (text.as_bytes()[..text.len() / 2].to_vec(), ""),
        (whole[..whole.len() - 7].to_vec(), "facets need"),
        (many, "4294967295 facets need"),
        (nan, "corner 1 of facet 1"),
        (whole[..40].to_vec(), ""),
        (b"solid\nendsolid\n".to_vec(), "no triangles"),
        (Vec::new(), ""),
    ] {
        let problem = read(&bytes).expect_err(words);
        assert!(problem.rule.contains(words) && !problem.help.is_empty(), "{words}: {problem}");
    }
    // As a front and a back of their own.
    let place = Place::new();
    let part =
        |keep: &dyn Fn(&DVec3) -> bool| triangles.iter().filter(|t| t.iter().all(keep)).copied().collect::<Vec<_>>();
    place.write("front.stl", binary_stl(&part(&|p| p.x >= 0.0 && p.z < 46.0)));
    place.write("back.stl", ascii_stl(&part(&|p| p.z > 46.0)));
    let system = place.built("kind = \"mesh\"\nfront = \"front.stl\"\nback = \"back.stl\"");
    assert!(apart_mm(&system, &as_polynomials(&place)) < 3e-4);
}

#[test]
fn doubtful_surfaces_are_told_with_what_to_write() {
    let place = good();
    assert_eq!(place.doubts(&clouds(FRONT, BACK)), Vec::<String>::new());
    let scaled = |name: &str, by: f64, z: &dyn Fn(f64, f64) -> f64| {
        let text = points(RIGHT).map(|p| p.extend(z(p.x, p.y)) * by);
        place.write(name, text.fold("x,y,z\n".to_owned(), |t, p| t + &format!("{:?},{:?},{:?}\n", p.x, p.y, p.z)));
    };
    let facet = |x: f64, y: f64| front(x, y, 0.0);
    let has = |doubts: &[String], words: &[&str]| {
        for word in words {
            assert!(doubts.iter().any(|doubt| doubt.contains(word)), "{word}: {doubts:#?}");
        }
    };
    let with = |front: &str, back: &str| {
        clouds(&format!("file = \"{front}\", degree = 5"), &format!("file = \"{back}\", degree = 2"))
    };
    // Metres and inches read as mm.
    scaled("f.csv", 1e-3, &facet);
    scaled("b.csv", 1e-3, &back);
    has(
        &place.doubts(&with("f.csv", "b.csv")),
        &["mm wide", "`unit = \"m\"`", "mm thin", "nearer than the focal length"],
    );
    scaled("f.csv", 1.0 / 25.4, &facet);
    scaled("b.csv", 1.0 / 25.4, &back);
    has(&place.doubts(&with("f.csv", "b.csv")), &["nearer than the focal length", "\"in\""]);
    // The glass behind the board.
    scaled("f.csv", 1e3, &facet);
    scaled("b.csv", 1e3, &back);
    has(&place.doubts(&with("f.csv", "b.csv")), &["`unit = \"um\"`", "behind the board"]);
    // Thin glass.
    place.write("b.csv", csv(RIGHT, |x, y| facet(x, y) + 0.05));
    has(&place.doubts(&with("front.csv", "b.csv").replace("degree = 2", "degree = 5")), &["mm thin"]);
    // Little more than the points that a fit needs.
    let text = csv(RIGHT, back);
    place.write("b.csv", text.lines().step_by(37).collect::<Vec<_>>().join("\n"));
    has(
        &place.doubts(&with("front.csv", "b.csv")),
        &["12 points for 6 coefficients"].map(|_| "coefficients").as_slice(),
    );
    // A whole front of triangles; a whole plane back is as good as its half.
    let whole: Vec<_> = body(-16.0).into_iter().filter(|t| t.iter().all(|p| p.z < 46.0)).collect();
    let plane: Vec<_> = body(-16.0).into_iter().filter(|t| t.iter().all(|p| p.z > 46.0)).collect();
    place.write("front.obj", obj(&whole));
    place.write("back.obj", obj(&plane));
    let doubts = place.doubts("kind = \"mesh\"\nfront = \"front.obj\"\nback = \"back.obj\"\nnormals = \"flat\"");
    has(&doubts, &["over both halves"]);
    assert_eq!(doubts.len(), 1, "{doubts:?}");
    // A closed body as front.
    place.write("solid.obj", obj(&body(0.0)));
    let doubts = place.doubts("kind = \"mesh\"\nfront = \"solid.obj\"\nback = \"back.obj\"\nnormals = \"flat\"");
    has(&doubts, &["`prism.front` is a closed body", "write `body = "]);
    // Two sheets.
    let two: Vec<_> = whole.iter().copied().chain(whole.iter().map(|t| t.map(|p| p + DVec3::Z))).collect();
    place.write("two.obj", obj(&two));
    has(
        &place.doubts("kind = \"mesh\"\nfront = \"two.obj\"\nback = \"back.obj\"\nnormals = \"flat\""),
        &["two sheets over one (x, y)"],
    );
    // `check` and `render` tell them, and end well.
    for args in [&["check", "scene.toml"][..], &["render", "scene.toml", "--out", "a.png"]] {
        let out = place.run(args);
        assert_eq!(out.status.code(), Some(0));
        assert!(said(&out.stderr).contains("note: `prism.front` has two sheets"), "{}", said(&out.stderr));
    }
    let json: Value = serde_json::from_slice(&place.run(&["check", "scene.toml", "--json"]).stdout).unwrap();
    assert!(json["doubts"].as_array().unwrap().len() >= 2);
}

#[test]
fn prisms_without_light_are_refused_with_their_fates() {
    let place = good();
    let none = "no ray of the picture passes the prism: of 384 rays";
    let refused = |prism: &str, words: &[&str]| {
        let told = place.refused(prism);
        for word in words.iter().chain(&[none]) {
            assert!(told.contains(word), "{prism}: {word}: {told}");
        }
    };
    // From its own vertex, behind the camera, the left half, front and back swapped, aside.
    place.write("vertex.csv", csv(RIGHT, |x, y| front(x, y, 0.0) - 40.0));
    refused(&clouds("file = \"vertex.csv\", degree = 5", BACK), &["100.0 % missed", "`offset_mm = [0, 0, D]`"]);
    refused(&clouds(&format!("{FRONT}, flip = \"z\""), BACK), &["behind the pinhole", "`flip = \"z\"`"]);
    let left = [FRONT, BACK].map(|cloud| format!("{cloud}, flip = \"x\", offset_mm = [-2, 0, 0]"));
    refused(&clouds(&left[0], &left[1]), &["is the left half", "`flip = \"x\"`"]);
    refused(&clouds("file = \"back.csv\", degree = 5", "file = \"front.csv\", degree = 5"), &["the other way round"]);
    refused(&(clouds(FRONT, BACK) + "\nposition_mm = [60, 0, 0]"), &["the front is at x", "`prism.position_mm`"]);
    place.write("a.obj", obj(&body(0.0)));
    refused("kind = \"mesh\"\nbody = { file = \"a.obj\", offset_mm = [100, 0, 0] }", &["missed"]);
    let domain = "centre_mm = [0, 0]\nscale_mm = [1, 1]\ndomain_mm = [[-1, 16], [-12, 12]]";
    let polynomial = |index: f64| {
        format!(
            "kind = \"polynomial\"\n[prism.front]\n{domain}\nterms = [[0, 0, 40]]\n[prism.back]\n{domain}\nterms = [[0, 0, 50], [1, 0, 1.0]]"
        )
        .replace("kind", &format!("outer_index = {index}\nkind"))
    };
    refused(&polynomial(0.3), &["total_reflection", "a smaller index"]);
    refused(
        "kind = \"freeform\"\nridge_distance_mm = 40.0\nthickness_mm = 20.0\nposition_mm = [60, 0, 0]\ndesign = { step_px = 4 }",
        &["missed", "move the prism into the way of the rays"],
    );
}

#[test]
fn prisms_that_lose_some_rays_say_how_many() {
    let place = good();
    place.write("front.csv", csv([-1.0, 6.0], |x, y| front(x, y, 0.0)));
    let doubts = place.doubts(&clouds(FRONT, BACK));
    assert!(doubts.iter().any(|d| d.contains("% of the rays pass the prism") && d.contains("% missed")), "{doubts:?}");
    let doubts =
        place.doubts("kind = \"flat\"\nridge_distance_mm = 40.0\nthickness_mm = 20.0\nposition_mm = [40.0, 0.0, 0.0]");
    assert!(
        doubts.iter().any(|d| d.contains("no ray passes the right half") || d.contains("no ray passes the left half")),
        "{doubts:?}"
    );
}

#[test]
fn an_exported_prism_is_the_designed_one_with_a_lens_too() {
    let place = Place::new();
    let lens = "[effect.thin_lens]\nf_number = 4.0\nfocus_mm = 600.0\n[effect.roughness]\nback_slope_deg = 0.3\n[quadrature]\npoints = 16";
    let freeform = "kind = \"freeform\"\nridge_distance_mm = 40.0\nthickness_mm = 8.0\ndesign = { step_px = 2.0 }";
    let designed = scene::load(&place.scene_with(freeform, lens)).unwrap();
    let out = place.run(&["design", "scene.toml", "--out", "."]);
    assert!(out.status.success(), "{}", said(&out.stderr));
    let prism = fs::read_to_string(place.path().join("prism.toml")).unwrap();
    let index = "index = 1.5168\n";
    let text = prism.replacen("[prism]\n", "", 1).replacen(index, "", 1);
    let exported = scene::load(&place.scene_with(&text, lens)).unwrap();
    let pictures = [&designed, &exported].map(|scene| {
        let system = built(scene);
        assert_eq!(system::doubts(scene, &system), Vec::<String>::new());
        render(&system, &|_| ()).radiance.data().to_vec()
    });
    assert!(pictures[0] == pictures[1], "the same bits");
    // One that was designed for the pinhole alone says that the beam leaves it.
    place.scene(freeform);
    assert!(place.run(&["design", "scene.toml", "--out", "."]).status.success());
    let prism = fs::read_to_string(place.path().join("prism.toml")).unwrap();
    let text = prism.replacen("[prism]\n", "", 1).replacen(index, "", 1);
    let narrow = scene::load(&place.scene_with(&text, lens)).unwrap();
    let doubts = system::doubts(&narrow, &built(&narrow));
    assert!(
        doubts.iter().any(|d| d.contains("the beam leaves the prism's surfaces") && d.contains("% missed")),
        "{doubts:?}"
    );
    for args in [&["check", "scene.toml"][..], &["render", "scene.toml", "--out", "a.png"]] {
        assert!(said(&place.run(args).stderr).contains("the beam leaves the prism's surfaces"));
    }
}
