//! A closed body of triangles to a file: STL or PLY, both binary, or OBJ.

use super::atomic::write_atomically;
use crate::error::Error;
use crate::surface::solid::Solid;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// How a body is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SolidFormat {
    /// [`write_stl`].
    Stl,
    /// [`write_ply`].
    Ply,
    /// [`write_obj`].
    Obj,
}

impl SolidFormat {
    /// The format that the ending of `path` names.
    ///
    /// # Errors
    /// Another ending.
    pub(crate) fn of(path: &Path) -> Result<Self, Error> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        match extension.as_str() {
            "stl" => Ok(Self::Stl),
            "ply" => Ok(Self::Ply),
            "obj" => Ok(Self::Obj),
            _ => Err(Error::new(
                path.display(),
                format!("the extension is {extension:?}, and a body's must be stl, ply or obj"),
                "name a .ply or a .obj, whose numbers are f64, or a .stl, whose numbers are f32",
            )),
        }
    }

    /// Writes `solid` to `path`, whole or not at all.
    ///
    /// # Errors
    /// As [`write_atomically`].
    pub(crate) fn write(self, path: &Path, solid: &Solid) -> Result<(), Error> {
        write_atomically(path, |out| match self {
            Self::Stl => write_stl(solid, out),
            Self::Ply => write_ply(solid, out),
            Self::Obj => write_obj(solid, out),
        })
    }
}

/// The header of a binary STL file.
const STL_HEADER: &[u8; 80] = b"biprism: a closed body of glass, mm, pinhole at the origin, +z to the scene     ";

/// The body as binary STL: 84 bytes, and 50 bytes a facet, whose corners and unit normal, outwards, are f32: of a coordinate z the
/// last bit is some 6e-8 z, so that normals between facets a length h wide are certain to about 1e-7 z / h. `out` is buffered here.
///
/// # Errors
/// Those of `out`; [`io::ErrorKind::InvalidInput`] of more facets than 32 bits count.
pub fn write_stl(solid: &Solid, out: impl Write) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    out.write_all(STL_HEADER)?;
    let count = u32::try_from(solid.triangles.len())
        .map_err(|_| io::Error::new(io::ErrorKind::InvalidInput, "more facets than STL can count"))?;
    out.write_all(&count.to_le_bytes())?;
    for triangle in &solid.triangles {
        let [a, b, c] = triangle.map(|k| solid.points_mm[k as usize]);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        for v in [normal, a, b, c] {
            for value in v.to_array() {
                out.write_all(&(value as f32).to_le_bytes())?;
            }
        }
        out.write_all(&[0; 2])?;
    }
    out.flush()
}

/// The body as PLY, binary, little-endian: vertices x, y, z in mm as double, and faces of three `vertex_indices`. `out` is
/// buffered here.
///
/// # Errors
/// Those of `out`.
pub fn write_ply(solid: &Solid, out: impl Write) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    writeln!(out, "ply\nformat binary_little_endian 1.0")?;
    writeln!(out, "comment biprism: a closed body of glass, mm, pinhole at the origin, +z to the scene, +y down")?;
    writeln!(out, "element vertex {}", solid.points_mm.len())?;
    for axis in ["x", "y", "z"] {
        writeln!(out, "property double {axis}")?;
    }
    writeln!(out, "element face {}\nproperty list uchar uint vertex_indices\nend_header", solid.triangles.len())?;
    for point in &solid.points_mm {
        for value in point.to_array() {
            out.write_all(&value.to_le_bytes())?;
        }
    }
    for triangle in &solid.triangles {
        out.write_all(&[3])?;
        for corner in triangle {
            out.write_all(&corner.to_le_bytes())?;
        }
    }
    out.flush()
}

/// The body as Wavefront OBJ, a text: `v x y z` in mm, each number such that it reads back as the same f64, and `f` with the numbers
/// of three corners from 1. `out` is buffered here.
///
/// # Errors
/// Those of `out`.
pub fn write_obj(solid: &Solid, out: impl Write) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    writeln!(out, "# biprism: a closed body of glass, mm, pinhole at the origin, +z to the scene, +y down")?;
    for p in &solid.points_mm {
        writeln!(out, "v {:?} {:?} {:?}", p.x, p.y, p.z)?;
    }
    for [a, b, c] in &solid.triangles {
        writeln!(out, "f {} {} {}", u64::from(*a) + 1, u64::from(*b) + 1, u64::from(*c) + 1)?;
    }
    out.flush()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::mesh::{MeshFormat, parse_mesh};
    use glam::DVec3;

    fn tetrahedron() -> Solid {
        let points_mm = vec![DVec3::ZERO, DVec3::new(0.1, 0.0, 78.3), DVec3::new(0.0, 1.0 / 3.0, 0.0), DVec3::Z];
        Solid { points_mm, triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]] }
    }

    #[test]
    fn what_is_written_is_read_again() {
        let solid = tetrahedron();
        let (mut ply, mut obj) = (Vec::new(), Vec::new());
        write_ply(&solid, &mut ply).expect("memory takes it");
        write_obj(&solid, &mut obj).expect("memory takes it");
        for (format, bytes) in [(MeshFormat::Ply, ply), (MeshFormat::Obj, obj)] {
            let read = parse_mesh("solid", format, &bytes[..], bytes.len() as u64).expect("it is of the format");
            assert_eq!((read.points, read.triangles), (solid.points_mm.clone(), solid.triangles.clone()));
        }

        let mut bytes = Vec::new();
        write_stl(&solid, &mut bytes).expect("memory takes it");
        assert_eq!(bytes.len(), 84 + 4 * 50);
        let read = parse_mesh("solid.stl", MeshFormat::Stl, &bytes[..], bytes.len() as u64).expect("it is STL");
        let corners = |points: &[DVec3], triangles: &[[u32; 3]]| -> Vec<DVec3> {
            triangles.iter().flatten().map(|k| points[*k as usize]).collect()
        };
        let wanted = corners(&solid.points_mm, &solid.triangles).into_iter().map(|p| p.as_vec3().as_dvec3());
        assert_eq!(corners(&read.points, &read.triangles), wanted.collect::<Vec<_>>());
    }
}
