//! Creases of meshes: ridges and facets wherever they lie.

use super::bodies::{body, obj};
use super::*;
use biprism::accuracy::Level;
use biprism::render::{Film, Outputs, render_wanted};

/// The flat prism whose glass is [`body`], somewhere else.
fn flat(place: &Place, moved: &str) -> Scene {
    let angle = libm::atan(0.2).to_degrees();
    let text =
        format!("kind = \"flat\"\nridge_distance_mm = 40.0\nthickness_mm = 7.0\nfacet_angle_deg = {angle:?}\n{moved}");
    scene::load(&place.scene(&text)).unwrap()
}

/// A rim that clips nothing: with one the triangles alone do not tell what is seen, and borders are followed by their rays.
const WIDE: &str = "[effect.clipping]\nrim = { sides_mm = [80.0, 80.0] }";

/// The same surfaces with their ridge aside, aslant or tilted are the same prism, by smooth normals and by flat ones, and every
/// level keeps its promise in the pixels on the ridge.
#[test]
fn a_body_is_right_wherever_its_ridge_lies() {
    let place = Place::new();
    place.write("body.obj", obj(&body(-16.0)));
    for (offset, tilt) in [([2.0, 0.0], 0.0), ([-1.3, 0.4], 0.0), ([0.0, 0.0], 7.0), ([0.7, -0.2], -31.0)] {
        let [x, y] = offset;
        let moved = format!("position_mm = [{x:?}, {y:?}, 0.0]\ntilt_deg = [0.0, 0.0, {tilt:?}]");
        let expected = built(&flat(&place, &moved));
        for (normals, more) in [("smooth", ""), ("flat", ""), ("smooth", WIDE), ("flat", WIDE)] {
            let pose = format!("pose = {{ position_mm = [{x:?}, {y:?}, 0.0], tilt_deg = [0.0, 0.0, {tilt:?}] }}");
            let text = format!("kind = \"mesh\"\nnormals = \"{normals}\"\nbody = {{ file = \"body.obj\", {pose} }}");
            let scene = scene::load(&place.scene_with(&text, more)).unwrap();
            let found = built(&scene);
            let doubts = system::doubts(&scene, &found);
            assert!(doubts.iter().all(|doubt| !doubt.contains("lean")), "{doubts:?}");
            for k in 0..400u32 {
                let share = |alpha: f64| (f64::from(k) * alpha).fract();
                let px = DVec2::new(96.0 * share(0.754_877_666), 80.0 * share(0.569_840_291));
                let [a, b] = [&expected, &found].map(|system| system.trace(px).map(|sight| sight.board_mm));
                let same = a.is_ok() && a.unwrap().distance(b.unwrap()) < 1e-9;
                assert!(same || a.is_err() && b.is_err(), "{offset:?} {tilt} {normals} {px}: {a:?} {b:?}");
            }
            for level in [Level::Draft, Level::Standard, Level::Exact] {
                let [a, b] = [&expected, &found].map(|system| {
                    render_wanted(&system.clone().with_accuracy(level.accuracy()), Outputs { truth: false }, &())
                });
                assert_eq!(b.account.unpromised_pixels, 0, "{offset:?} {tilt} {normals} {level:?}");
                // Each keeps a line to its promise, which a pixel takes over its diagonal at most.
                let pairs = a.radiance.data().iter().zip(b.radiance.data());
                let most = pairs.map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max);
                let promised = 2.0 * std::f64::consts::SQRT_2 * level.accuracy().promise_px + 1e-6;
                assert!(most <= promised, "{offset:?} {tilt} {normals} {level:?}: {most}");
            }
        }
    }
}

/// A dome over the tests' right half by `cells` x `cells` squares, as OBJ with corners of its own for every triangle.
fn dome(cells: usize) -> String {
    let at = |i: usize, j: usize| {
        let [x, y] = [-1.0 + 17.0 * i as f64 / cells as f64, -12.0 + 24.0 * j as f64 / cells as f64];
        DVec3::new(x, y, front(x, y, 0.0))
    };
    let squares = (0..cells * cells).map(|k| (k % cells, k / cells));
    let triangles = squares.flat_map(|(i, j)| {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    obj(&triangles.collect::<Vec<_>>())
}

/// Triangles that are too coarse for what they stand for are told; many facets, where triangles alone do not tell what is seen, leave
/// pixels without promise, which are counted.
#[test]
fn coarse_triangles_and_many_facets_are_told() {
    let place = Place::new();
    let plane: Vec<_> = body(-16.0).into_iter().filter(|t| t.iter().all(|p| p.z > 46.0)).collect();
    place.write("back.obj", obj(&plane));
    for (cells, lean) in [(2, true), (60, false)] {
        place.write("front.obj", dome(cells));
        let mesh = "kind = \"mesh\"\nfront = \"front.obj\"\nback = \"back.obj\"";
        let doubts = place.doubts(mesh);
        assert_eq!(doubts.iter().any(|doubt| doubt.contains("lean up to")), lean, "{cells}: {doubts:?}");
        assert!(place.doubts(&format!("{mesh}\nnormals = \"flat\"")).iter().all(|doubt| !doubt.contains("lean")));
    }
    place.write("front.obj", dome(24));
    let unpromised = |normals: &str, more: &str| {
        let text = format!("kind = \"mesh\"\nnormals = \"{normals}\"\nfront = \"front.obj\"\nback = \"back.obj\"");
        let scene = scene::load(&place.scene_with(&text, more)).unwrap();
        render(&built(&scene), &()).account.unpromised_pixels
    };
    assert!(100 * unpromised("smooth", "") < 96 * 80);
    assert_eq!(unpromised("flat", ""), 0);
    assert!(unpromised("flat", WIDE) > 1000);
    assert!(said(&place.run(&["render", "scene.toml", "--out", "a.png"]).stderr).contains("hold no promise"));
}

/// The picture of a prism of two meshes, on `size` pixels `pitch_um` wide about the middle of the tests' picture.
fn film(place: &Place, normals: &str, ([width, height], pitch_um): ([usize; 2], f64), level: Level) -> Film {
    let path =
        place.scene(&format!("kind = \"mesh\"\nnormals = \"{normals}\"\nfront = \"front.obj\"\nback = \"back.obj\""));
    let sensor = format!("width_px = {width}\nheight_px = {height}\npixel_pitch_um = {pitch_um:?}");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, text.replace("width_px = 96\nheight_px = 80\npixel_pitch_um = 88.0", &sensor)).unwrap();
    let system = built(&scene::load(&path).unwrap()).with_accuracy(level.accuracy());
    render_wanted(&system, Outputs { truth: false }, &())
}

/// How many pixels of two pictures differ by more than `most`.
fn differing(a: &Film, b: &Film, most: f64) -> usize {
    let pairs = a.radiance.data().iter().zip(b.radiance.data());
    pairs.filter(|(a, b)| f64::from((*a - *b).abs()) > most).count()
}

/// At the side of every triangle that is not even the map has a kink by smooth normals, and jumps by flat ones: pixels are cut along
/// them, or counted.
#[test]
fn kinks_of_smooth_normals_keep_the_promise_or_are_counted() {
    let place = Place::new();
    let plane: Vec<_> = body(-16.0).into_iter().filter(|t| t.iter().all(|p| p.z > 46.0)).collect();
    place.write("back.obj", obj(&plane));
    // Six rows about the middle: the reference takes long.
    let size = ([40, 6], 110.0);
    for (cells, normals) in [(5, "smooth"), (16, "smooth"), (5, "flat"), (16, "flat")] {
        place.write("front.obj", dome(cells));
        let reference = film(&place, normals, size, Level::Reference);
        for level in [Level::Draft, Level::Exact] {
            let found = film(&place, normals, size, level);
            let promised = std::f64::consts::SQRT_2 * level.accuracy().promise_px + 1e-6;
            let (wrong, told) = (differing(&found, &reference, promised), found.account.unpromised_pixels);
            println!("{cells} {normals}, {level:?}: {wrong} pixels off by more than {promised:.1e}, {told} told");
            assert!(wrong as u64 <= told, "{cells} {normals} {level:?}: {wrong} of {told}");
            assert!(told as usize <= found.radiance.data().len() / 100, "{cells} {normals} {level:?}: {told}");
        }
    }
}

/// What lies between the rays that check a patch of the map is seen: dents a few pixels wide, by flat and by smooth normals.
#[test]
fn dents_between_the_rays_of_a_patch_are_seen() {
    let place = Place::new();
    let plane: Vec<_> = body(-16.0).into_iter().filter(|t| t.iter().all(|p| p.z > 46.0)).collect();
    place.write("back.obj", obj(&plane));
    for k in 0..3u32 {
        // A square of 0.1 mm in the facet, and a corner in its middle that lies 0.4 um deeper: less than makes a crease. The
        // squares around it keep the normals of the others even.
        let middle = DVec2::new(3.1 + 1.7 * f64::from(k), -2.3 + 1.9 * f64::from(k));
        let at = |x: f64, y: f64| DVec3::new(x, y, 40.0 + 0.2 * x);
        let around = |m: f64| [m - 0.1, m - 0.05, m + 0.05, m + 0.1];
        let ([xa, xb, xc, xd], [ya, yb, yc, yd]) = (around(middle.x), around(middle.y));
        let xs = [-1.0, xa, xb, xc, xd, 16.0];
        let ys = [-12.0, ya, yb, yc, yd, 12.0];
        let mut triangles = Vec::new();
        for (i, j) in (0..25).map(|n| (n % 5, n / 5)) {
            let corners = [at(xs[i], ys[j]), at(xs[i + 1], ys[j]), at(xs[i + 1], ys[j + 1]), at(xs[i], ys[j + 1])];
            let deep = at(middle.x, middle.y) + DVec3::Z * 0.0004;
            let [a, b, c, d] = corners;
            match (i, j) {
                (2, 2) => triangles.extend((0..4).map(|n| [corners[n], corners[(n + 1) % 4], deep])),
                _ => triangles.extend([[a, b, c], [a, c, d]]),
            }
        }
        place.write("front.obj", obj(&triangles));
        let [standard, exact] =
            [Level::Standard, Level::Exact].map(|level| film(&place, "smooth", ([480, 400], 17.6), level));
        let promised = 2.0 * std::f64::consts::SQRT_2 * Level::Standard.accuracy().promise_px + 1e-6;
        let (wrong, told) = (differing(&standard, &exact, promised), standard.account.unpromised_pixels);
        assert!(wrong as u64 <= told && told < 20, "dent {k}: {wrong} of {told}");
    }
}

/// Faces of many corners are taken where they are plane and convex, and refused where they are not.
#[test]
fn faces_of_many_corners_are_cut_into_triangles() {
    let corners = "v 0 -12 47\nv 16 -12 47\nv 18 0 47\nv 16 12 47\nv 0 12 47\n";
    let parse = |text: &str| parse_mesh("a.obj", MeshFormat::Obj, text.as_bytes(), text.len() as u64);
    let mesh = parse(&format!("{corners}f 1 2 3 4 5\n")).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
    // From the dent, whichever corner is named first; and from a corner whose neighbours are not in a line with it.
    let dented = corners.replace("18 0", "3 0");
    for face in ["1 2 3 4 5", "3 4 5 1 2", "5 1 2 3 4"] {
        let mut found = parse(&format!("{dented}f {face}\n")).unwrap().triangles;
        assert!(found.iter().all(|triangle| triangle[0] == 2), "{found:?}");
        found.sort_unstable();
        assert_eq!(found, [[2, 0, 1], [2, 3, 4], [2, 4, 0]]);
    }
    let quad = "v 0 -12 47\nv 16 -12 47\nv 3 0 47\nv 0 12 47\n";
    for face in ["1 2 3 4", "2 3 4 1"] {
        let found = parse(&format!("{quad}f {face}\n")).unwrap().triangles;
        assert!(found.iter().all(|t| t.contains(&0) && t.contains(&2)), "{found:?}");
    }
    let level = "v 0 -12 47\nv 8 -12 47\nv 16 -12 47\nv 16 12 47\nv 0 12 47\n";
    assert!(parse(&format!("{level}f 1 2 3 4 5\n")).unwrap().triangles.iter().all(|t| *t != [0, 1, 2]));
    let bent = corners.replace("18 0 47", "18 0 47.05");
    let crossed = "v 0 -12 47\nv 16 12 47\nv 16 -12 47\nv 0 12 47\n";
    for (text, face, words) in
        [(&bent[..], "1 2 3 4 5", "is not plane"), (crossed, "1 2 3 4", "none that sees all others")]
    {
        let refused = parse(&format!("{text}f {face}\n")).unwrap_err().to_string();
        assert!(refused.contains(words), "{refused}");
    }
}
