//! What is legal and doubtful, and prisms that no light passes.

use super::bodies::{body, obj};
use super::*;

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
    has(&place.doubts(&with("front.csv", "b.csv")), &["coefficients"]);
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
    let told = place.refused("kind = \"mesh\"\nfront = \"solid.obj\"\nback = \"back.obj\"\nnormals = \"flat\"");
    assert!(told.contains("a closed body is `body = "), "{told}");
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
        render(&system, &()).radiance.data().to_vec()
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
