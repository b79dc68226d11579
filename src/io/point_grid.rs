//! The point cloud of a design to a file, as a table or for a viewer of point clouds.

use crate::design::point_grid::PointGrid;
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
pub fn write_csv(cloud: &PointGrid, out: impl Write) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    writeln!(out, "{CSV_HEADER}")?;
    for p in cloud.points() {
        let (a, b) = (p.front_mm, p.back_mm);
        writeln!(out, "{:?},{:?},{:?},{:?},{:?},{:?},{:?},{:?}", p.u_px, p.v_px, a.x, a.y, a.z, b.x, b.y, b.z)?;
    }
    out.flush()
}

/// One surface as PLY, binary, little-endian: one vertex a ray, row after row of the grid, with the properties x, y, z in mm
/// in the prism's frame, then u_px and v_px as in [`write_csv`], all of type double: 40 bytes a vertex. `out` is buffered
/// here.
///
/// # Errors
/// Those of `out`.
pub fn write_ply(cloud: &PointGrid, face: Face, out: impl Write) -> io::Result<()> {
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
    writeln!(out, "comment {} columns x {} rows", cloud.columns(), cloud.rows())?;
    writeln!(out, "element vertex {}", cloud.len())?;
    for property in ["x", "y", "z", "u_px", "v_px"] {
        writeln!(out, "property double {property}")?;
    }
    writeln!(out, "end_header")?;
    for point in cloud.points() {
        let p = match face {
            Face::Front => point.front_mm,
            Face::Back => point.back_mm,
        };
        for value in [p.x, p.y, p.z, point.u_px, point.v_px] {
            out.write_all(&value.to_le_bytes())?;
        }
    }
    out.flush()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::design::{DesignInput, freeform};
    use crate::scene::{BiprismSpec, CameraSpec, DesignSettings, GlassSpec, MarchOrder, Method};
    use glam::DVec3;

    /// The paper's design on a sensor of few, large pixels.
    pub(crate) fn small_cloud() -> PointGrid {
        let camera = CameraSpec {
            position_mm: DVec3::ZERO,
            focal_length_mm: 35.0,
            width_px: 48,
            height_px: 30,
            pitch_mm: 0.0055 * 40.0,
        };
        let prism = BiprismSpec {
            body: GlassSpec::new(1.48, 1.0),
            ridge_distance_mm: 78.472,
            thickness_mm: 8.545,
            facet_angle_rad: None,
        };
        let settings = DesignSettings { order: MarchOrder::XThenY, degree: 5, method: Method::Rk4, step_px: 1.0 };
        freeform(&DesignInput { camera, prism, settings, virtual_camera_z_mm: 0.0 }).unwrap().cloud
    }

    #[test]
    fn csv_holds_a_line_a_ray_with_named_columns() {
        let cloud = small_cloud();
        let mut bytes = Vec::new();
        write_csv(&cloud, &mut bytes).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some(CSV_HEADER));
        for (line, p) in lines.by_ref().zip(cloud.points()) {
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
        let cloud = small_cloud();
        let mut bytes = Vec::new();
        write_ply(&cloud, Face::Back, &mut bytes).unwrap();
        let end = b"end_header\n";
        let body = bytes.windows(end.len()).position(|w| w == end).unwrap() + end.len();
        assert!(bytes.starts_with(b"ply\nformat binary_little_endian 1.0\n"));
        assert!(String::from_utf8_lossy(&bytes[..body]).contains("element vertex 775\n"));
        assert_eq!(bytes.len() - body, 775 * 40);
        let number = |i: usize| f64::from_le_bytes(bytes[body + 8 * i..][..8].try_into().unwrap());
        let p = cloud.at(1, 0);
        assert_eq!([5, 6, 7, 8, 9].map(number), [p.back_mm.x, p.back_mm.y, p.back_mm.z, p.u_px, p.v_px]);
    }
}
