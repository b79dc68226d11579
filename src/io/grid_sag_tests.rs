//! Grid sag that is read back, whose orientation is that of a plane aslant, and files that are wrong.

use super::*;
use crate::io::point_cloud::{PointFormat, parse_points};
use crate::surface::face::Face;

fn parse(text: &str) -> Result<Vec<DVec3>, Error> {
    parse_points("sag.dat", PointFormat::GridSag, text.as_bytes(), text.len() as u64, Face::Front)
}

/// A file of a plane that rises by 1 a column to the right and by 10 a row up, whose middle is 100.
fn plane(unit: usize) -> String {
    let z = |i: i32, j: i32| 100 + (i - 2) + 10 * (3 - j);
    let rows: String = (0..7).flat_map(|j| (0..5).map(move |i| format!("{} 0 0 0 0\n", z(i, j)))).collect();
    format!("! by hand\r\n5 7 2.0 0.5 {unit} 0.25 -3\n{rows}")
}

#[test]
fn a_plane_aslant_is_the_right_way_up_in_every_unit() {
    for (unit, mm) in [(0, 1.0), (1, 10.0), (2, 25.4), (3, 1000.0)] {
        let points = parse(&plane(unit)).unwrap();
        assert_eq!(points.len(), 35);
        // The upper left one first, then its right neighbour; the lower right one last.
        assert_eq!(points[0], DVec3::new(0.25 - 4.0, -3.0 + 1.5, 128.0) * mm);
        assert_eq!(points[1], DVec3::new(0.25 - 2.0, -3.0 + 1.5, 129.0) * mm);
        assert_eq!(points[34], DVec3::new(0.25 + 4.0, -3.0 - 1.5, 72.0) * mm);
        for p in points {
            let height = 100.0 + (p.x / mm - 0.25) / 2.0 + 10.0 * (p.y / mm + 3.0) / 0.5;
            assert!((p.z / mm - height).abs() < 1e-12, "{p}");
        }
    }
}

#[test]
fn what_is_written_reads_back_bit_for_bit() {
    let grid = SagGrid { size: [6, 9], step_mm: DVec2::new(1.0 / 3.0, 0.1), middle_mm: DVec2::new(6.1, -0.7) };
    let point = |(k, at): (usize, DVec2)| {
        let z = -1.0 / 7.0 + at.x * at.y / 3.0;
        (k % 11 != 4).then_some(SagPoint { z, slope: DVec2::new(at.y / 3.0, at.x / 3.0), twist: 1.0 / 3.0 })
    };
    let points: Vec<_> = grid.places().enumerate().map(point).collect();
    let mut bytes = Vec::new();
    write_grid_sag(&grid, &points, &mut bytes).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    let expected: Vec<DVec3> = grid.places().zip(&points).filter_map(|(at, p)| Some(at.extend((*p)?.z))).collect();
    assert_eq!(parse(&text).unwrap(), expected);
    // Slopes are d/dx and d/dy of the same x and y, and the flag is the last.
    let lines: Vec<Vec<f64>> =
        text.lines().skip(1).map(|line| line.split(' ').map(|v| v.parse().unwrap()).collect()).collect();
    let [here, right, down] = [&lines[0], &lines[1], &lines[6]];
    assert!((right[0] - here[0] - here[1] * grid.step_mm.x).abs() < 1e-12);
    assert!((here[0] - down[0] - here[2] * grid.step_mm.y).abs() < 1e-12);
    assert!((right[2] - here[2] - here[3] * grid.step_mm.x).abs() < 1e-12);
    assert!(lines.iter().enumerate().all(|(k, line)| line[4] == f64::from(u8::from(k % 11 == 4))));
}

#[test]
fn what_is_wrong_is_told_with_its_line() {
    let good = plane(0);
    let with = |from: &str, to: &str| parse(&good.replacen(from, to, 1)).unwrap_err();
    let told = |error: Error, line: usize, words: &str| {
        assert!(error.place == format!("sag.dat:{line}") && error.rule.contains(words), "{error}");
    };
    told(with("5 7", "4 7"), 2, "nx is \"4\", and must be a whole number from 5 on");
    told(with("5 7", "5 7.5"), 2, "ny is \"7.5\"");
    told(with("5 7", "4000 4000"), 2, "the limit is 10000000");
    told(with("5 7", "9223372036854775807 9223372036854775807"), 2, "the limit is 10000000");
    told(with("0.5 0", "0 0"), 2, "dely is 0, and must be above 0");
    told(with("0.5 0", "0.5 4"), 2, "the unit flag is \"4\"");
    told(with(" -3\n", "\n"), 2, "has 6 values, and must have 7");
    told(with("128 0 0 0 0", "128 0 0 0 2"), 3, "nodata is 2");
    told(with("128 0", "nan 0"), 3, "z is \"nan\", and must be a finite number");
    told(with("129 0", "129 0 0"), 4, "has 6 values, and has at most 5");
    told(with("72 0 0 0 0\n", ""), 37, "ends after 34 points, and its grid has 35");
    told(with("72 0 0 0 0\n", "72\n73\n"), 38, "more lines than the 35 points");
    told(parse(&plane(3).replacen("128 0", "1e308 0", 1)).unwrap_err(), 3, "must be finite");
    told(parse("").unwrap_err(), 1, "has 0 values, and must have 7");
}
