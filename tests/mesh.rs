//! Is a prism of triangles the prism that was tessellated?

use crate::instruments::{BOARD, FLAT, FREEFORM, built, scene as parsed};
use biprism::effect::Variant;
use biprism::io::mesh::{MeshFormat, parse_triangles};
use biprism::render::render;
use biprism::scene;
use biprism::surface::face::Face;
use biprism::surface::mesh::Triangles;
use biprism::surface::shape::Surface;
use biprism::system::{Side, System};
use glam::{DMat2, DVec2, DVec3};
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// The triangles as text of PLY, with normals where asked.
fn ply(t: &Triangles, normals: bool) -> String {
    let mut text = format!("ply\nformat ascii 1.0\nelement vertex {}\n", t.points_mm.len());
    for name in ["x", "y", "z", "nx", "ny", "nz"].into_iter().take(if normals { 6 } else { 3 }) {
        let _ = writeln!(text, "property double {name}");
    }
    let _ = writeln!(text, "element face {}\nproperty list uchar uint vertex_indices\nend_header", t.triangles.len());
    for (p, n) in t.points_mm.iter().zip(&t.point_normals) {
        let _ = match normals {
            true => writeln!(text, "{:?} {:?} {:?} {:?} {:?} {:?}", p.x, p.y, p.z, n.x, n.y, n.z),
            false => writeln!(text, "{:?} {:?} {:?}", p.x, p.y, p.z),
        };
    }
    for [a, b, c] in &t.triangles {
        let _ = writeln!(text, "3 {a} {b} {c}");
    }
    text
}

/// The right half of a surface of `system`, tessellated over what the paper's sensor sees of it.
fn tessellated(system: &System, face: Face, cells: usize) -> Triangles {
    let domain = biprism::geom::Rect { min: DVec2::new(-1.0, -8.0), max: DVec2::new(14.6, 8.0) };
    let prism = system.prism().expect("the scene has a prism");
    Triangles::over(domain, cells, |x, y| match prism.surface(Side::Right, face) {
        Surface::Plane { point, normal } => {
            (point.z - (normal.x * (x - point.x) + normal.y * (y - point.y)) / normal.z, *normal)
        }
        Surface::Freeform(sheet) => {
            let (z, zx, zy) = sheet.sag().gradient(x, y);
            (z, DVec3::new(-zx, -zy, 1.0).normalize())
        }
        _ => panic!("the prism has planes or sheets"),
    })
}

/// The instrument of `prism` with its surfaces tessellated, through files and the front door.
fn meshed(folder: &Path, prism: &str, cells: usize, kind: &str, normals: bool) -> System {
    let smooth = built(&parsed(480, 270, prism, BOARD));
    for (face, name) in Face::ALL.into_iter().zip(["front.ply", "back.ply"]) {
        fs::write(folder.join(name), ply(&tessellated(&smooth, face, cells), normals)).expect("it is written");
    }
    let text = format!(
        "name = \"mesh\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = 480\nheight_px = 270\npixel_pitch_um = 22.0\n\
         [prism]\nkind = \"mesh\"\nindex = 1.48\nfront = \"front.ply\"\nback = \"back.ply\"\nnormals = \"{kind}\"\n\
         [board]\n{BOARD}\n"
    );
    built(&scene::parse(&text, "mesh", Some(folder)).unwrap_or_else(|problem| panic!("{problem}")))
}

/// Places all over the picture, none of them on an edge of the triangles.
fn places() -> impl Iterator<Item = DVec2> {
    (0..400).map(|k| {
        let (a, b) = (f64::from(k) * 0.754_877_666, f64::from(k) * 0.569_840_291);
        DVec2::new(480.0 * a.fract(), 270.0 * b.fract())
    })
}

/// The largest difference of what the two instruments see, in px.
fn shift_px(a: &System, b: &System) -> f64 {
    places().fold(0.0, |worst: f64, px| {
        let [a, b] = [a, b].map(|s| s.footprint(px).unwrap_or_else(|fate| panic!("{px}: {fate:?}")));
        assert_eq!(a.sight.side, b.sight.side);
        worst.max((a.jacobian.inverse() * (b.sight.board_mm - a.sight.board_mm)).length())
    })
}

/// A plane is the same plane in triangles, whichever normals refract and whether the file gives them.
#[test]
fn plane_facets_as_triangles_are_plane_facets() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let flat = built(&parsed(480, 270, FLAT, BOARD));
    let picture = render(&flat, &());
    for (kind, normals) in [("smooth", true), ("smooth", false), ("flat", false)] {
        let mesh = meshed(folder.path(), FLAT, 9, kind, normals);
        // Some ten roundings of lengths near 1000 mm, over 0.6 mm a pixel.
        let shift = shift_px(&flat, &mesh);
        assert!(shift < 1e-11, "{kind}: {shift:e} px");
        let film = render(&mesh, &());
        let pairs = film.radiance.data().iter().zip(picture.radiance.data());
        let off = pairs.fold(0.0f32, |worst, (a, b)| worst.max((a - b).abs()));
        // The bend bound of the standard level, 5e-6 px, times a contrast of 0.8, and the rounding of f32.
        assert!(off < 1e-5, "{kind}: {off:e}");
    }
}

/// Linear pieces err by the square of their size, in height as in the slope between given normals.
#[test]
fn a_smooth_mesh_converges_to_the_freeform_with_second_order() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let freeform = built(&parsed(480, 270, FREEFORM, BOARD));
    let shifts = [16, 32, 64].map(|cells| shift_px(&freeform, &meshed(folder.path(), FREEFORM, cells, "smooth", true)));
    println!("shifts of 16, 32 and 64 cells a side: {shifts:?} px");
    for pair in shifts.windows(2) {
        assert!(pair[1] < 0.35 * pair[0] && pair[1] > 0.15 * pair[0], "{shifts:?}");
    }
}

#[test]
fn the_footprint_is_the_derivative_of_what_is_seen() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let smooth = meshed(folder.path(), FREEFORM, 7, "smooth", true);
    let slopes = [DVec2::new(0.09, -0.04), DVec2::new(-0.06, 0.05)];
    let rough = smooth.variant(&Variant { pupil: DVec2::ZERO, slopes, wave: None, grey: 1.0, colour: None });
    [smooth, rough].iter().for_each(footprints_are_derivatives);
}

fn footprints_are_derivatives(mesh: &System) {
    let (mut inside, step) = (0, 1e-4);
    for px in places() {
        let see = |by: DVec2| mesh.trace(px + by).expect("all rays pass").board_mm;
        let column = |by: DVec2| (see(by) - see(-by)) / (2.0 * step);
        let measured = DMat2::from_cols(column(DVec2::new(step, 0.0)), column(DVec2::new(0.0, step)));
        let error = (mesh.footprint(px).expect("all rays pass").jacobian - measured).abs();
        let worst = error.x_axis.max(error.y_axis).max_element();
        // A place within a step of an edge of the triangles has two derivatives; there are few.
        inside += usize::from(worst < 1e-6);
    }
    assert!(inside >= 395, "{inside} of 400");
}

#[test]
fn a_wrong_mesh_is_a_problem() {
    let head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\nproperty double z\n";
    let face = "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 80\n1 0 80\n0 1 80\n";
    let with = |face: &str, row: &str| format!("{head}{face}{row}\n");
    let cases = [
        (with("end_header\n0 0 80\n1 0 80\n0 1 80", ""), "must be `face`"),
        (with(face, "3 0 1 3"), "has the corner 3"),
        (with(face, "3 0 1 -1"), "has the corner -1"),
        (with(face, "3 0 1 1"), "names a vertex twice"),
        (with(face, "2 0 1"), "has 2 corners"),
        (with(face, "5 0 1 2 0 1"), "names a vertex twice"),
        (with(face, "3 0 1"), "has 3 values, and must have 4"),
        (with(face, "3 0 1 2 9"), "has 5 values, and must have 4"),
        (with(face, "1e300 0 1 2"), "and must have"),
        (with(&face.replace("face 1", "face 0"), ""), "no triangles"),
        (with(&face.replace("face 1", "face 2"), "3 0 1 2"), "ends after 1 of 2"),
        (with(&face.replace("face 1", "face 4000001"), ""), "within 0 .. 4000000"),
        (with(&face.replace("0 1 80", "2 0 81"), "3 0 1 2"), "has no normal"),
    ];
    for (text, rule) in cases {
        let parsed = parse_triangles("mesh", MeshFormat::Ply, text.as_bytes(), text.len() as u64);
        let problem = parsed.expect_err(rule);
        assert!(problem.rule.contains(rule), "{rule}: {problem:?}");
    }
    for (text, rule) in [
        ("v 0 0\n", "no z"),
        ("v 0 0 nan\n", "\"nan\""),
        ("v 0 0 80\nv 0 1e80 80\nv 1 0 80\nf 1 2 3\n", "vertex 2 is [0.0, 1e80, 80.0], and must be within 1e6 mm"),
        ("v 0 0 80\nf 1 2 3\n", "has the corner 1, counted from 0"),
        ("f 0 1 2\n", "\"0\""),
        ("curv 1\n", "\"curv\""),
        ("v 0 0 80\n", "no triangles"),
    ] {
        let problem = parse_triangles("mesh", MeshFormat::Obj, text.as_bytes(), text.len() as u64).expect_err(rule);
        assert!(problem.rule.contains(rule), "{rule}: {problem:?}");
    }
    let quad = "o q\nv 0 0 80\nv 1 0 80\nv 1 1 80\nv 0 1 80\nvn 0 0 1\nf -4//1 -3//1 -2//1 -1//1\n";
    let read = parse_triangles("mesh", MeshFormat::Obj, quad.as_bytes(), quad.len() as u64).expect("it is right");
    assert_eq!((read.triangles, read.point_normals), (vec![[0, 1, 2], [0, 2, 3]], vec![DVec3::Z; 4]));
}
