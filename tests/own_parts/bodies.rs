//! Closed bodies, and STL files.

use super::*;

/// A box of glass with the facet of the tests' flat prism on its lower side, over x in `low`..16; quads of two triangles.
pub(super) fn body(low: f64) -> Vec<[DVec3; 3]> {
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

pub(super) fn ascii_stl(triangles: &[[DVec3; 3]]) -> String {
    let facets = triangles.iter().map(|t| {
        let corners = t.iter().fold(String::new(), |s, p| s + &format!("      vertex {:?} {:?} {:?}\n", p.x, p.y, p.z));
        format!("  facet normal 0 0 0\n    outer loop\n{corners}    endloop\n  endfacet\n")
    });
    format!("solid glass\n{}endsolid glass\n", facets.collect::<String>())
}

/// Binary, though it begins with the word of the ascii ones, as some programs write it.
pub(super) fn binary_stl(triangles: &[[DVec3; 3]]) -> Vec<u8> {
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

pub(super) fn obj(triangles: &[[DVec3; 3]]) -> String {
    let corners = triangles.iter().flatten().map(|p| format!("v {:?} {:?} {:?}\n", p.x, p.y, p.z)).collect::<String>();
    corners
        + &(0..triangles.len()).map(|k| format!("f {} {} {}\n", 3 * k + 1, 3 * k + 2, 3 * k + 3)).collect::<String>()
}

/// The same prism as two polynomials.
pub(super) fn as_polynomials(place: &Place) -> System {
    let domain = "centre_mm = [0, 0]\nscale_mm = [1, 1]\ndomain_mm = [[-2, 16], [-12, 12]]";
    place.built(&format!(
        "kind = \"polynomial\"\n[prism.front]\n{domain}\nterms = [[0, 0, 40], [1, 0, 0.2]]\n[prism.back]\n{domain}\nterms = [[0, 0, 47]]"
    ))
}

#[test]
fn a_closed_body_is_a_prism() {
    let place = Place::new();
    let wanted = as_polynomials(&place);
    let picture = render(&wanted, &());
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
        let seen = render(&place.built("kind = \"mesh\"\nbody = { file = \"c.obj\", unit = \"mm\" }"), &());
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
