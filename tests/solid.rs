//! A designed prism as one piece of glass: is its body watertight, is it the prism, and which back does light leave through?

use biprism::Scene;
use biprism::effect::{Effects, Threshold};
use biprism::geom::Ray;
use biprism::io::solid::{write_ply, write_stl};
use biprism::scene;
use biprism::surface::face::Face;
use biprism::surface::solid::Solid;
use biprism::system::crossing::Crossing;
use biprism::system::{self, Side, System, solid::solid};
use glam::DVec2;
use std::collections::BTreeMap;
use std::path::Path;

/// The paper's scene with other keys of the prism and of its design.
fn paper(prism: &str, design: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/paper.toml");
    let text = std::fs::read_to_string(path).expect("it is there");
    let written = "[prism.design]\norder = \"x-then-y\"\ndegree = 5";
    assert!(text.contains(written));
    let text = text.replace(written, &format!("{prism}\n[prism.design]\nstep_px = 8.0\n{design}"));
    scene::parse(&text, "solid", None).unwrap_or_else(|problem| panic!("{problem}"))
}

fn built(scene: &Scene) -> System {
    system::build(scene).unwrap_or_else(|problem| panic!("{problem}"))
}

/// The march, and the exact prisms.
const DESIGNS: [&str; 4] = [
    "",
    "objective = \"epipolar\"\nsurface = \"revolved\"",
    "objective = \"toed-in\"\nsurface = \"revolved\"",
    "objective = \"toed-in\"",
];

/// Every edge is shared by two triangles of opposite sense, Euler's characteristic is that of a sphere, and the volume within is
/// positive and converges with the square of the cells.
#[test]
fn bodies_are_watertight() {
    for design in DESIGNS {
        let system = built(&paper("", design));
        let bodies = [16, 32, 64].map(|cells| solid(&system, cells).unwrap_or_else(|problem| panic!("{problem}")));
        for body in &bodies {
            let mut edges: BTreeMap<[u32; 2], usize> = BTreeMap::new();
            for &[a, b, c] in &body.triangles {
                for edge in [[a, b], [b, c], [c, a]] {
                    *edges.entry(edge).or_default() += 1;
                }
            }
            let paired = edges.iter().all(|(&[a, b], n)| *n == 1 && edges.get(&[b, a]) == Some(&1));
            let characteristic = body.points_mm.len() as i64 - (edges.len() / 2) as i64 + body.triangles.len() as i64;
            assert!(paired && characteristic == 2, "{design}: {characteristic}");
        }
        let volumes = bodies.map(|body| body.volume_mm3());
        println!("{design:?}: {volumes:?} mm^3");
        // Some 25 x 15 x 7.5 mm of glass; chords of 12.6 mm/16 stray from two surfaces whose curvatures are some 1/80 mm by
        // h^2/12 of these, and a quarter of that at half the cells.
        let [coarse, middle, fine] = volumes;
        let most = 25.0 * 15.0 * (12.6f64 / 16.0) * (12.6 / 16.0) / 12.0 * 2.0 * (2.0 / 80.0);
        assert!(fine > 2000.0 && fine < 4000.0, "{design}: {fine}");
        assert!((coarse - fine).abs() < most && (middle - fine).abs() < 0.25 * most, "{design}: {volumes:?} {most}");
    }
}

/// Light that crosses x = 0 leaves a solid prism through the other half's back, where that bounds the glass: on the surface, on
/// that half, and all other light as if it were not solid.
#[test]
fn light_leaves_through_the_back_that_bounds_the_glass() {
    let design = "objective = \"epipolar\"\nsurface = \"revolved\"";
    let (piece, ideal) = (built(&paper("", design)), built(&paper("solid = false", design)));
    let prism = piece.prism().expect("there is one");
    assert!(prism.is_solid() && !ideal.prism().expect("there is one").is_solid());
    let mut others = 0;
    for k in 0..2000 {
        let even = |step: f64| (f64::from(k) * step).fract();
        let px = DVec2::new(960.0 + 200.0 * (even(0.754_877_666) - 0.5), 1080.0 * even(0.569_840_291));
        let (path, end) = piece.path(px);
        let (out, side) = end.expect("it passes");
        let (came, leaves) = (path.points[0], path.points[1]);
        let ridge_to_back = ideal.path(px);
        if (leaves.x < 0.0) == (side == Side::Left) {
            assert_eq!((path, Ok((out, side))), ridge_to_back, "{px}");
            continue;
        }
        others += 1;
        // It is on the other half's back, nearer than on the continuation of its own.
        let on = |side: Side| {
            let ray = Ray { origin: came, direction: (leaves - came).normalize() };
            prism.surface(side, Face::Back).intersect(&ray, 1e-12).map(|hit| ray.at(hit.t_mm)).expect("it is there")
        };
        assert!((on(side.other()) - leaves).length() < 1e-10, "{px}");
        let own = ridge_to_back.0.points[1];
        assert!((on(side) - own).length() < 1e-10 && (own - leaves).length() > 0.0, "{px}");
    }
    assert!(others > 200, "{others}");
}

/// Columns that look through the other half's glass, as an independent study counted them: 32 on each side of the ridge of
/// the flat prism, whose one base makes that harmless, and 41 of the march and the exact one, to the column whose centre decides.
#[test]
fn columns_through_the_other_half_are_counted() {
    let of = |prism: &str, design: &str| Crossing::of(&built(&paper(prism, design))).expect("there is a prism");
    let flat =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/paper.toml")).expect("it is there");
    let flat = flat.replace("freeform", "flat").replace("[prism.design]\norder = \"x-then-y\"\ndegree = 5\n", "");
    let flat = Crossing::of(&built(&scene::parse(&flat, "flat", None).expect("it is flat"))).expect("there is a prism");
    let (march, exact) = (of("", ""), of("", DESIGNS[1]));
    println!("{flat:?} {march:?} {exact:?}");
    assert!(flat.harmless && !flat.solid && flat.columns == 2 * 32, "{flat:?}");
    assert!(!march.harmless && !march.solid && march.columns.abs_diff(2 * 41) <= 2, "{march:?}");
    assert!(!exact.harmless && exact.solid && exact.columns.abs_diff(2 * 41) <= 2, "{exact:?}");
    assert!(exact.words().expect("some do").contains("one piece of glass"));
    assert!(march.words().expect("some do").contains("solid = true"));
}

/// RMS and largest distance, in px, between what pixels see through a scene's prism and through its body of `cells` cells across a
/// half, read back from a file written by `write`. Pixels beside the ridge are left out, within four cells of 64 and where light crosses
/// x = 0, for the reader takes a crease of less than 1 deg for smooth.
fn read_back_px(own: &Scene, cells: usize, name: &str, write: fn(&Solid, &mut Vec<u8>)) -> [f64; 2] {
    let system = built(own);
    let body = solid(&system, cells).unwrap_or_else(|problem| panic!("{problem}"));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut bytes = Vec::new();
    write(&body, &mut bytes);
    std::fs::write(folder.path().join(name), bytes).expect("it is written");
    let text =
        std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/paper.toml")).expect("it is there");
    let (start, end) = (text.find("[prism]").expect("a prism"), text.find("# An odd").expect("a board"));
    let prism = format!("[prism]\nkind = \"mesh\"\nindex = 1.48\nbody = \"{name}\"\n");
    let text = format!("{}{prism}{}", &text[..start], &text[end..]);
    let again = scene::parse(&text, "again", Some(folder.path())).unwrap_or_else(|problem| panic!("{problem}"));
    let again = built(&again);
    let (mut squares, mut most, mut count) = (0.0, 0.0f64, 0.0);
    for k in 0..400 {
        let even = |step: f64| (f64::from(k) * step).fract();
        let off = 80.0 + 870.0 * even(0.754_877_666);
        let px = DVec2::new(960.0 + if k % 2 == 0 { off } else { -off }, 5.0 + 1070.0 * even(0.569_840_291));
        let footprint = system.footprint(px).expect("it passes");
        let seen = again.trace(px).unwrap_or_else(|fate| panic!("{px}: {fate:?}"));
        assert_eq!(seen.side, footprint.sight.side);
        let off = (footprint.jacobian.inverse() * (seen.board_mm - footprint.sight.board_mm)).length();
        (squares, most, count) = (squares + off * off, most.max(off), count + 1.0);
    }
    [(squares / count).sqrt(), most]
}

/// Read back as a body the prism is the same, to the square of its cells: normals between corners are off by h^2/8 of their second
/// derivatives, some 1e-4/mm^2 of these surfaces, h is 0.2 mm for 64 cells, and (n - 1) f = 3000 px a rad.
#[test]
fn a_body_that_is_read_back_is_the_same_prism() {
    let own = paper("", DESIGNS[1]);
    let ply = |solid: &Solid, out: &mut Vec<u8>| write_ply(solid, out).expect("memory takes it");
    let [coarse, fine] = [64, 128].map(|cells| read_back_px(&own, cells, "body.ply", ply));
    println!("PLY: 64 cells {coarse:?}, 128 cells {fine:?} px");
    assert!(fine[0] < 0.3 * coarse[0], "{coarse:?} {fine:?}");
    assert!(coarse[0] < 1.5e-3, "{coarse:?}");
    // Of f32 at z = 80 the last bit is 8e-6 mm, half of which is the rounding: some 3e-6 mm RMS across cells of 0.2 mm.
    let stl = |solid: &Solid, out: &mut Vec<u8>| write_stl(solid, out).expect("memory takes it");
    let [rms, most] = read_back_px(&own, 64, "body.stl", stl);
    println!("STL: 64 cells {rms} {most} px, 128 cells {:?}", read_back_px(&own, 128, "body.stl", stl));
    assert!(rms < 0.1, "{rms} {most}");
}

/// The command writes prism, polynomials and body, and what it writes is a scene's prism again.
#[test]
fn the_command_writes_the_surfaces_and_the_body() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let run = |args: &[&str]| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_biprism"));
        let output = command.current_dir(folder.path()).args(args).output().expect("it starts");
        (
            output.status.code(),
            String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr),
        )
    };
    let head =
        "name = \"small\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = 320\nheight_px = 180\npixel_pitch_um = 33.0\n";
    let board = "[board]\ncolumns = 21\nrows = 21\nsquare_mm = 20.0\nposition_mm = [0.0, 0.0, 1000.0]\n";
    let flat = "[prism]\nkind = \"flat\"\nindex = 1.48\nridge_distance_mm = 78.472\nthickness_mm = 8.545\n";
    let write = |name: &str, text: String| std::fs::write(folder.path().join(name), text).expect("it is written");
    write("scene.toml", format!("{head}{flat}{board}"));
    let design = ["design", "scene.toml", "--objective", "toed-in", "--surface", "revolved"];
    for body in ["body.stl", "body.ply"] {
        let (code, told) = run(&[&design[..], &["--solid", body, "--degree", "7", "--out", "."]].concat());
        assert!(code == Some(0) && told.contains(body), "{told}");
    }
    // Both prisms pass the same light, to what the polynomials leave.
    let seen = |name: &str| {
        let prism = std::fs::read_to_string(folder.path().join(name)).expect("it is there");
        write("again.toml", format!("{head}{prism}{board}"));
        let scene = scene::load(&folder.path().join("again.toml")).unwrap_or_else(|problem| panic!("{problem}"));
        assert!(scene.prism.is_solid(), "{name}");
        built(&scene).trace(DVec2::new(250.0, 20.0)).expect("it passes").board_mm
    };
    let (exact, polynomials) = (seen("prism.toml"), seen("prism_polynomial.toml"));
    // 1e-6 px of degree 7, at the border thrice that, of 33 um and 35 mm, at 1 m.
    assert!(exact != polynomials && (exact - polynomials).length() < 3e-6, "{exact} {polynomials}");
    let (code, told) = run(&[&design[..], &["--solid", "body.step"]].concat());
    assert!(code == Some(2) && told.contains("stl, ply or obj"), "{told}");
    let (code, told) = run(&["design", "scene.toml", "--surface", "revolved"]);
    assert!(code == Some(2) && told.contains("prism.design.surface"), "{told}");
}

/// Where two backs meet in an edge no bound is known of what a small move of the rays changes: no effect that moves them is left out.
#[test]
fn effects_that_move_rays_are_kept_beside_the_edge_of_the_backs() {
    for solid in [false, true] {
        let design = format!("{}\n[effect.manufacture]\nindex = 1e-12", DESIGNS[1]);
        let scene = paper(&format!("solid = {solid}"), &design);
        let auto = Some(Threshold { grey: Some(1e-3), px: Some(1e-3) });
        let scene = Scene { effects: Effects { auto, ..scene.effects.clone() }, ..scene };
        let system = built(&scene);
        assert_eq!(system.effects().manufacture.is_some(), solid, "{solid}");
    }
}
