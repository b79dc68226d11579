//! Point clouds that are read back, and files that are wrong in every way we could think of.

use super::*;
use crate::io::point_grid::tests::{COLUMNS, ROWS, small_grid};
use crate::io::point_grid::{write_csv, write_ply};
use proptest::prelude::*;

fn parse(format: PointFormat, bytes: &[u8]) -> Result<Vec<DVec3>, Error> {
    parse_points("cloud", format, bytes, bytes.len() as u64, Face::Front)
}

fn ply_text(format: &str, count: &str, properties: &str, body: &[u8]) -> Vec<u8> {
    let header = format!(
        "ply\r\nformat {format} 1.0\r\ncomment by hand\r\nelement vertex {count}\r\n{properties}end_header\r\n"
    );
    [header.as_bytes(), body].concat()
}

const XYZ: &str = "property float x\nproperty float y\nproperty float z\n";

#[test]
fn a_written_cloud_reads_back_bit_for_bit() {
    let points = small_grid();
    for face in [Face::Front, Face::Back] {
        let expected: Vec<_> = points
            .iter()
            .map(|p| match face {
                Face::Front => p.front_mm,
                Face::Back => p.back_mm,
            })
            .collect();
        let (mut csv, mut ply) = (Vec::new(), Vec::new());
        write_csv(points.iter().copied(), &mut csv).unwrap();
        write_ply([COLUMNS, ROWS], points.iter().copied(), face, &mut ply).unwrap();
        let read = |format, bytes: &[u8]| parse_points("cloud", format, bytes, bytes.len() as u64, face).unwrap();
        assert_eq!(read(PointFormat::Csv, &csv), expected);
        assert_eq!(read(PointFormat::Ply, &ply), expected);
    }
}

#[test]
fn a_file_is_read_by_its_extension() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("points.XYZ");
    std::fs::write(&path, "1 2 3\n").unwrap();
    assert_eq!(read_points(&path, Face::Front).unwrap(), [DVec3::new(1.0, 2.0, 3.0)]);
    assert!(read_points(&folder.path().join("points.stl"), Face::Front).unwrap_err().rule.contains("\"stl\""));
    assert!(read_points(&folder.path().join("none.csv"), Face::Front).unwrap_err().rule.contains("cannot be read"));
}

#[test]
fn texts_by_other_hands_are_read() {
    let expected = [DVec3::new(1.0, -2.0, 3e-3), DVec3::new(4.0, 5.0, 6.0)];
    let xyz = "# by hand\n1 -2\t3e-3 extra\n\n  4,5 , 6\n";
    assert_eq!(parse(PointFormat::Xyz, xyz.as_bytes()).unwrap(), expected);
    let csv = "\u{feff}z, \"X\",name,y_mm\r\n3e-3,1,a,-2\r\n6,4,b,5";
    assert_eq!(parse(PointFormat::Csv, csv.as_bytes()).unwrap(), expected);
    let ascii = ply_text("ascii", "2", XYZ, b"1 -2 0.003\n4 5 6");
    assert_eq!(parse(PointFormat::Ply, &ascii).unwrap(), expected);
    assert_eq!(parse(PointFormat::Xyz, b"").unwrap(), []);
}

#[test]
fn ply_bodies_of_either_byte_order_and_any_type_are_read() {
    // Properties before, between and after, and faces after the vertices.
    let properties = "property uchar red\nproperty short z\nproperty double x\nproperty int8 q\nproperty float32 y\n\
                      element face 1\nproperty list uchar int vertex_indices\n";
    let vertex = |little: bool| {
        let (z, x, y) = (-300_i16, 1.1_f64, 2.5_f32);
        let (z, x, y) = if little {
            (z.to_le_bytes(), x.to_le_bytes(), y.to_le_bytes())
        } else {
            (z.to_be_bytes(), x.to_be_bytes(), y.to_be_bytes())
        };
        [&[9], &z[..], &x[..], &[7], &y[..], &[3, 0, 0, 0, 0]].concat()
    };
    for (format, little) in [("binary_little_endian", true), ("binary_big_endian", false)] {
        let file = ply_text(format, "1", properties, &vertex(little));
        assert_eq!(parse(PointFormat::Ply, &file).unwrap(), [DVec3::new(1.1, 2.5, -300.0)]);
    }
}

#[test]
fn a_wrong_text_is_a_problem_with_line_value_and_rule() {
    let long = format!("1 2 {}\n", "3".repeat(5000));
    let cases: [(PointFormat, &[u8], &str, &str); 10] = [
        (PointFormat::Xyz, b"1 2 3\n4 5\n", "cloud:2", "\"4 5\""),
        (PointFormat::Xyz, b"1 2 3\n\n1 2 nan\n", "cloud:3", "z is \"nan\""),
        (PointFormat::Xyz, b"1 2 1e999\n", "cloud:1", "z is \"1e999\""),
        (PointFormat::Xyz, b"1 2 3\n\xff\xfe\n", "cloud:2", "UTF-8"),
        (PointFormat::Xyz, long.as_bytes(), "cloud:1", "4096"),
        (PointFormat::Csv, b"", "cloud:1", "x_mm"),
        (PointFormat::Csv, b"1,2,3\n4,5,6\n", "cloud:1", "x_mm"),
        (PointFormat::Csv, b"x,y,z\n1,2,3\n1,2\n", "cloud:3", "2 values"),
        (PointFormat::Csv, b"x,y,z\n1,two,3\n", "cloud:2", "y is \"two\""),
        (PointFormat::Csv, b"x,y\n1,2\n", "cloud:1", "z_mm"),
    ];
    for (format, bytes, place, rule) in cases {
        let problem = parse(format, bytes).unwrap_err();
        assert_eq!(problem.place, place, "{problem:?}");
        assert!(problem.rule.contains(rule), "{problem:?}");
        assert!(!problem.help.is_empty());
    }
}

#[test]
fn a_wrong_ply_is_a_problem_before_memory_is_taken() {
    let le = "binary_little_endian";
    let nan = [f32::NAN; 3].map(f32::to_le_bytes).concat();
    let cases = [
        (ply_text(le, "10000000", XYZ, &[0; 24]), "need 120000000 bytes"),
        (ply_text("ascii", "10000000", XYZ, b"1 2 3\n"), "need 59999999 bytes"),
        (ply_text(le, "10000001", XYZ, &[0; 24]), "within 0 .. 10000000"),
        (ply_text(le, "99999999999999999999999", XYZ, &[0; 24]), "within 0 .. 10000000"),
        (ply_text(le, "-1", XYZ, &[0; 24]), "\"-1\""),
        (ply_text(le, "2", XYZ, &[0; 23]), "need 24 bytes"),
        (ply_text("ascii", "2", XYZ, b"1.0000000 2 3"), "ends after 1 of 2"),
        (ply_text("ascii", "1", XYZ, b"1 2 3 4"), "4 values"),
        (ply_text("ascii", "1", XYZ, b"1 2 inf"), "\"inf\""),
        (ply_text(le, "1", XYZ, &nan), "must be finite"),
        (ply_text("binary_middle_endian", "1", XYZ, &[0; 12]), "format"),
        (ply_text(le, "1", "property float x\nproperty float y\n", &[0; 8]), "x, y and z"),
        (ply_text(le, "1", "property half x\n", &[0; 8]), "\"half\""),
        (ply_text(le, "1", "property list uchar int x\n", &[0; 8]), "not understood"),
        (b"ply\nformat ascii 1.0\nelement face 1\nend_header\n".to_vec(), "\"face\""),
        (b"ply\nformat ascii 1.0\nelement vertex 1\n".to_vec(), "does not end"),
        (["ply\n", &"comment\n".repeat(2000)].concat().into_bytes(), "does not end"),
        (b"solid\n".to_vec(), "not `ply`"),
    ];
    for (file, rule) in cases {
        let problem = parse(PointFormat::Ply, &file).unwrap_err();
        assert!(problem.rule.contains(rule), "{rule}: {problem:?}");
    }
}

#[test]
fn more_points_than_the_limit_are_refused() {
    let at_most =
        |limit, format, bytes: &[u8]| parse_at_most(limit, "cloud", format, bytes, bytes.len() as u64, Face::Front);
    let csv = b"x,y,z\n1,2,3\n1,2,3\n1,2,3\n";
    let ply = ply_text("ascii", "3", XYZ, b"1 2 3\n1 2 3\n1 2 3\n");
    let cases =
        [(PointFormat::Xyz, &b"1 2 3\n1 2 3\n1 2 3\n"[..], 3), (PointFormat::Csv, csv, 4), (PointFormat::Ply, &ply, 4)];
    for (format, bytes, line) in cases {
        assert_eq!(at_most(3, format, bytes).unwrap().len(), 3);
        assert_eq!(at_most(2, format, bytes).unwrap_err().place, format!("cloud:{line}"));
    }
}

proptest! {
    #[test]
    fn no_bytes_make_it_panic(bytes in proptest::collection::vec(any::<u8>(), 0..300), head in 0..3usize) {
        let head = [&b""[..], b"ply\nformat ascii 1.0\nelement vertex 3\n", b"x,y,z\n"][head];
        let file = [head, &bytes].concat();
        for format in [PointFormat::Csv, PointFormat::Ply, PointFormat::Xyz] {
            let _ = parse(format, &file);
        }
    }

    /// Pieces of files in any order reach further into the readers than bytes do.
    #[test]
    fn no_pieces_make_it_panic(pieces in proptest::collection::vec(proptest::sample::select(vec![
        "1", "-2.5", "1e999", "nan", ",", ",", " ", "\n", "\n", "\r", "\"", "x,y,z\n", "z,x,y,n\n", "#", "ply\n", "format ascii 1.0\n",
        "format binary_little_endian 1.0\n", "element vertex 2\n", "property float x\n", "property double y\n", "property uchar z\n",
        "end_header\n", "front", "back", "\u{feff}",
    ]), 0..40), head in 0..4usize) {
        let file = [["", "x,y,z\n", "front_x_mm,front_y_mm,front_z_mm\n", "ply\nformat ascii 1.0\n"][head], &pieces.concat()].concat();
        for format in [PointFormat::Csv, PointFormat::Ply, PointFormat::Xyz] {
            let _ = parse(format, file.as_bytes());
        }
    }
}

/// A file of the other kind of surface is sent there, and not to another name.
#[test]
fn points_and_triangles_are_sent_to_their_own_kind() {
    for (name, help) in [("a.stl", "kind = \"mesh\""), ("a.obj", "kind = \"mesh\""), ("a.step", "as CSV")] {
        let told = read_points(Path::new(name), Face::Front).unwrap_err();
        assert!(told.help.contains(help) && !told.help.contains("rename"), "{told}");
    }
    for (name, help) in [("a.csv", "kind = \"point_cloud\""), ("a.step", "export the surface as a mesh")] {
        let told = crate::io::mesh::read_mesh(Path::new(name)).unwrap_err();
        assert!(told.help.contains(help), "{told}");
    }
}
