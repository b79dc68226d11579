//! Creases of meshes: ridges and facets wherever they lie.

use super::bodies::{body, obj};
use super::*;
use biprism::accuracy::Level;
use biprism::render::{Outputs, render_wanted};

/// The flat prism whose glass is [`body`], somewhere else.
fn flat(place: &Place, moved: &str) -> Scene {
    let angle = libm::atan(0.2).to_degrees();
    let text =
        format!("kind = \"flat\"\nridge_distance_mm = 40.0\nthickness_mm = 7.0\nfacet_angle_deg = {angle:?}\n{moved}");
    scene::load(&place.scene(&text)).unwrap()
}

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
        for normals in ["smooth", "flat"] {
            let pose = format!("pose = {{ position_mm = [{x:?}, {y:?}, 0.0], tilt_deg = [0.0, 0.0, {tilt:?}] }}");
            let text = format!("kind = \"mesh\"\nnormals = \"{normals}\"\nbody = {{ file = \"body.obj\", {pose} }}");
            let scene = scene::load(&place.scene(&text)).unwrap();
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

/// Triangles that are too coarse for what they stand for are told; many facets leave pixels without promise, which are counted.
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
    let unpromised = |normals: &str| {
        let text = format!("kind = \"mesh\"\nnormals = \"{normals}\"\nfront = \"front.obj\"\nback = \"back.obj\"");
        render(&place.built(&text), &()).account.unpromised_pixels
    };
    assert_eq!(unpromised("smooth"), 0);
    assert!(unpromised("flat") > 1000);
    assert!(said(&place.run(&["render", "scene.toml", "--out", "a.png"]).stderr).contains("hold no promise"));
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
