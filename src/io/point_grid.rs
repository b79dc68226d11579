//! A grid of points of two surfaces to a file, as a table or for a viewer of point clouds.

use crate::geom::GridPoint;
use crate::surface::face::Face;
use std::io::{self, BufWriter, Write};

/// The columns of [`write_csv`].
pub const CSV_HEADER: &str = "u_px,v_px,front_x_mm,front_y_mm,front_z_mm,back_x_mm,back_y_mm,back_z_mm";

/// Both surfaces as comma-separated values: [`CSV_HEADER`], then one ray a line, row after row of the grid.
///
/// `u_px`, `v_px` are the pixel's offset from the centre of the right half image (the pixel position on a sensor of w x h
/// px is (3 w/4 + u, h/2 + v), with pixel centres at + 0.5); the points are in mm in the prism's frame. Every number
/// reads back as the same f64. `out` is buffered here.
///
/// # Errors
/// Those of `out`.
pub fn write_csv(points: impl Iterator<Item = GridPoint>, out: impl Write) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    writeln!(out, "{CSV_HEADER}")?;
    for p in points {
        let (a, b) = (p.front_mm, p.back_mm);
        writeln!(out, "{:?},{:?},{:?},{:?},{:?},{:?},{:?},{:?}", p.u_px, p.v_px, a.x, a.y, a.z, b.x, b.y, b.z)?;
    }
    out.flush()
}

/// One surface as PLY, binary, little-endian: one vertex a ray, row after row of the grid, with the properties x, y, z in mm
/// in the prism's frame, then u_px and v_px as in [`write_csv`], all of type double: 40 bytes a vertex. `out` is buffered
/// here. `columns` times `rows` points are written.
///
/// # Errors
/// Those of `out`; [`io::ErrorKind::InvalidInput`] when there are more or fewer points than the grid has.
pub fn write_ply(
    [columns, rows]: [usize; 2],
    points: impl Iterator<Item = GridPoint>,
    face: Face,
    out: impl Write,
) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    let name = match face {
        Face::Front => "front surface (faces the camera)",
        Face::Back => "back surface (faces the scene)",
    };
    writeln!(out, "ply\nformat binary_little_endian 1.0")?;
    writeln!(
        out,
        "comment biprism: {name} of the right half (x > 0), mm, pinhole at the origin, +z to the scene, +y down"
    )?;
    writeln!(out, "comment u_px, v_px: pixel offset from the centre of the right half image")?;
    writeln!(out, "comment {columns} columns x {rows} rows")?;
    writeln!(out, "element vertex {}", columns * rows)?;
    for property in ["x", "y", "z", "u_px", "v_px"] {
        writeln!(out, "property double {property}")?;
    }
    writeln!(out, "end_header")?;
    let mut written = 0;
    for point in points {
        let p = match face {
            Face::Front => point.front_mm,
            Face::Back => point.back_mm,
        };
        for value in [p.x, p.y, p.z, point.u_px, point.v_px] {
            out.write_all(&value.to_le_bytes())?;
        }
        written += 1;
    }
    if written != columns * rows {
        let words = format!("a grid of {columns} x {rows} points was given {written}");
        return Err(io::Error::new(io::ErrorKind::InvalidInput, words));
    }
    out.flush()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use glam::DVec3;

    /// Points of two curved surfaces, of coordinates with many digits.
    pub(in crate::io) fn small_grid() -> Vec<GridPoint> {
        let point = |k: usize| {
            let (u_px, v_px) = ((k % COLUMNS) as f64 - 12.0, (k / COLUMNS) as f64 - 15.0);
            let (x, y) = ((u_px + 12.0) / 3.0, v_px / 7.0);
            let at = |z: f64| DVec3::new(x * z / 35.0, y * z / 35.0, z);
            GridPoint { u_px, v_px, front_mm: at(78.0 + x / 9.0 + y * y / 99.0), back_mm: at(87.0 - y / 11.0) }
        };
        (0..COLUMNS * ROWS).map(point).collect()
    }

    /// Size of [`small_grid`].
    pub(in crate::io) const COLUMNS: usize = 25;
    pub(in crate::io) const ROWS: usize = 31;

    #[test]
    fn csv_holds_a_line_a_ray_with_named_columns() {
        let points = small_grid();
        let mut bytes = Vec::new();
        write_csv(points.iter().copied(), &mut bytes).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some(CSV_HEADER));
        for (line, p) in lines.by_ref().zip(&points) {
            let values: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
            let expected: Vec<f64> =
                [p.u_px, p.v_px].into_iter().chain(p.front_mm.to_array()).chain(p.back_mm.to_array()).collect();
            assert_eq!(values, expected);
        }
        assert_eq!(text.lines().count(), 1 + 25 * 31);
        assert!(text.lines().nth(1).unwrap().starts_with("-12.0,-15.0,0.0,"));
    }

    #[test]
    fn ply_is_as_long_as_its_header_says() {
        let points = small_grid();
        let mut bytes = Vec::new();
        write_ply([COLUMNS, ROWS], points.iter().copied(), Face::Back, &mut bytes).unwrap();
        let short = write_ply([COLUMNS, ROWS], points.iter().copied().skip(1), Face::Back, io::sink());
        assert_eq!(short.unwrap_err().kind(), io::ErrorKind::InvalidInput);
        let end = b"end_header\n";
        let body = bytes.windows(end.len()).position(|w| w == end).unwrap() + end.len();
        assert!(bytes.starts_with(b"ply\nformat binary_little_endian 1.0\n"));
        assert!(String::from_utf8_lossy(&bytes[..body]).contains("element vertex 775\n"));
        assert_eq!(bytes.len() - body, 775 * 40);
        let number = |i: usize| f64::from_le_bytes(bytes[body + 8 * i..][..8].try_into().unwrap());
        let p = points[1];
        assert_eq!([5, 6, 7, 8, 9].map(number), [p.back_mm.x, p.back_mm.y, p.back_mm.z, p.u_px, p.v_px]);
    }
}
