//! A surface of triangles from a file: PLY, OBJ or STL.

use super::inputs;
use super::lines::TextLines;
use super::ply::{Ply, PlyRow};
use super::point_cloud::finite_point;
use super::stl;
use crate::error::Error;
use crate::surface::mesh::Triangles;
use crate::surface::normals::{corner_normals, normals_with_creases};
use crate::surface::weld::weld;
use glam::DVec3;
use std::io::{BufRead, BufReader};
use std::path::Path;

/// Most corners, and most triangles, of a file: about 600 MB in memory, with what orders them for rays.
pub const MAX_TRIANGLES: u64 = 4_000_000;

/// Largest magnitude of a vertex' coordinate: a kilometre, far above any prism and far below what an f32 can hold.
pub const MAX_COORDINATE_MM: f64 = 1e6;

/// How the triangles are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeshFormat {
    /// PLY 1.0, ascii or binary: the element `vertex` with x, y, z and, where they are known, the normal nx, ny, nz; then
    /// the element `face` with the list `vertex_indices`, of three corners each, or more where the face is
    /// plane and one of them sees all others.
    Ply,
    /// Wavefront OBJ: `v` and `f` lines. Its normals, textures, groups and materials are left aside.
    Obj,
    /// STL, ascii or binary. Corners at one place are made one corner; the normals of its facets are left aside.
    Stl,
}

/// The triangles of a file as they are written, before they are judged as a surface.
#[derive(Debug, Clone, PartialEq)]
pub struct RawMesh {
    /// Corners, in the file's unit.
    pub points: Vec<DVec3>,
    /// A unit normal at every corner, towards +z, where the file gives them.
    pub normals: Option<Vec<DVec3>>,
    /// The corners of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

/// The triangles of the file at `path`, in mm; the format follows from the extension (.ply, .obj, .stl). Faces of more
/// than three corners are cut from one that sees all others. Normals that the file does not give follow from the triangles; a corner on a
/// crease becomes several.
///
/// # Errors
/// A [`Error`] with file, line, value and rule when the file cannot be read, breaks its format, holds a number that is
/// not finite, names a corner that it has not, has no triangle or more than [`MAX_TRIANGLES`], goes beyond [`MAX_COORDINATE_MM`], or is
/// no graph over (x, y).
pub fn read_triangles(path: &Path) -> Result<Triangles, Error> {
    read_mesh(path)?.surface(&path.display().to_string())
}

/// [`read_triangles`] without what makes a surface of them.
///
/// # Errors
/// As [`read_triangles`], but for the last two.
pub fn read_mesh(path: &Path) -> Result<RawMesh, Error> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let format = match extension.as_str() {
        "ply" => MeshFormat::Ply,
        "obj" => MeshFormat::Obj,
        "stl" => MeshFormat::Stl,
        _ => {
            let rule = format!("the extension is {extension:?}, and a mesh's must be stl, ply or obj");
            let help = match extension.as_str() {
                "csv" | "xyz" | "txt" => "a polynomial is fitted to points by kind = \"point_cloud\"",
                _ => "export the surface as a mesh of triangles in one of these",
            };
            return Err(Error::new(path.display(), rule, help));
        }
    };
    let unreadable =
        |e| Error::new(path.display(), format!("cannot be read: {e}"), "check the path and its permissions");
    let file = inputs::open(path).map_err(unreadable)?;
    let bytes = file.metadata().map_err(unreadable)?.len();
    parse_mesh(&path.display().to_string(), format, BufReader::new(file), bytes)
}

/// [`read_triangles`] from any `input` of `bytes` bytes, called `name` in messages.
///
/// # Errors
/// As [`read_triangles`].
pub fn parse_triangles(name: &str, format: MeshFormat, input: impl BufRead, bytes: u64) -> Result<Triangles, Error> {
    parse_mesh(name, format, input, bytes)?.surface(name)
}

/// [`read_mesh`] from any `input` of `bytes` bytes, called `name` in messages.
///
/// # Errors
/// As [`read_mesh`].
pub fn parse_mesh(name: &str, format: MeshFormat, input: impl BufRead, bytes: u64) -> Result<RawMesh, Error> {
    let mut lines = TextLines { name, input, line: 0, taken: 0, limit: MAX_TRIANGLES };
    let (points, normals, triangles) = match format {
        MeshFormat::Ply => ply(&mut lines, bytes)?,
        MeshFormat::Obj => obj(&mut lines)?,
        MeshFormat::Stl => {
            let (points, triangles) = stl::read(lines, bytes)?;
            (points, None, triangles)
        }
    };
    if triangles.is_empty() {
        let help = "write the surface with its faces; points alone are a scene's `kind = \"point_cloud\"`";
        return Err(Error::new(name, "the file has no triangles", help));
    }
    Ok(RawMesh { points, normals, triangles })
}

impl RawMesh {
    /// The triangles as a surface, once their points are in mm; `name` is that of their file in messages.
    ///
    /// # Errors
    /// A [`Error`] where a point lies beyond [`MAX_COORDINATE_MM`], or the triangles are no graph over (x, y).
    pub fn surface(self, name: &str) -> Result<Triangles, Error> {
        let Self { points: mut points_mm, normals, mut triangles } = self;
        within_reach(name, &points_mm)?;
        let no_normal = |points_mm: &[DVec3], k: usize| {
            let rule = format!(
                "corner {} at {} has no normal: no triangle has it, or those that have it stand upright or fold back",
                k + 1,
                points_mm[k]
            );
            let help =
                "remove loose corners; a surface of a prism is a graph z(x, y), and a closed body is `body = \"...\"`";
            Error::new(name, rule, help)
        };
        if let Some(point_normals) = normals {
            return Ok(Triangles { points_mm, point_normals, triangles });
        }

        // Triangles with corners of their own at one place are one surface all the same.
        if has_twins(&points_mm) {
            corner_normals(&points_mm, &triangles).map_err(|k| no_normal(&points_mm, k))?;
            let corners: Vec<DVec3> = triangles.iter().flatten().map(|k| points_mm[*k as usize]).collect();
            (points_mm, triangles) = weld(&corners);
        }
        let point_normals =
            normals_with_creases(&mut points_mm, &mut triangles).map_err(|k| no_normal(&points_mm, k))?;
        Ok(Triangles { points_mm, point_normals, triangles })
    }
}

/// Whether two corners are at the very same place.
fn has_twins(points: &[DVec3]) -> bool {
    fn any_alike<T: Ord>(mut all: Vec<T>) -> bool {
        all.sort_unstable();
        all.windows(2).any(|pair| pair[0] == pair[1])
    }
    // One number of each place is put in order sooner; those of different places hardly ever agree.
    let bits = |p: &DVec3| p.to_array().map(f64::to_bits);
    let mixed = |[x, y, z]: [u64; 3]| x ^ y.rotate_left(21) ^ z.rotate_left(42);
    any_alike(points.iter().map(|p| mixed(bits(p))).collect()) && any_alike(points.iter().map(bits).collect())
}

/// Refuses corners beyond [`MAX_COORDINATE_MM`].
///
/// # Errors
/// A [`Error`] that names the first.
pub fn within_reach(name: &str, points_mm: &[DVec3]) -> Result<(), Error> {
    let Some(k) = points_mm.iter().position(|p| !p.abs().cmple(DVec3::splat(MAX_COORDINATE_MM)).all()) else {
        return Ok(());
    };
    let rule =
        format!("vertex {} is {:?}, and must be within {MAX_COORDINATE_MM:e} mm", k + 1, points_mm[k].to_array());
    Err(Error::new(name, rule, "give the surface in mm, near the camera's axis"))
}

type Parts = (Vec<DVec3>, Option<Vec<DVec3>>, Vec<[u32; 3]>);

fn ply<R: BufRead>(lines: &mut TextLines<R>, bytes: u64) -> Result<Parts, Error> {
    let mut ply = Ply::open(lines, bytes)?;
    let [x, y, z] = ply.columns(["x", "y", "z"]).unwrap_or_default();
    let normal_columns = ply.columns(["nx", "ny", "nz"]);
    let (mut points, mut normals, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    ply.rows(|ply, i, row| {
        let at = |columns: [usize; 3]| columns.map(|k| row.values[k]);
        points.push(finite_point(ply, i, at([x, y, z]))?);
        if let Some(columns) = normal_columns {
            let normal = DVec3::from_array(at(columns)).try_normalize().filter(|n| n.z != 0.0).ok_or_else(|| {
                let rule = format!("the normal of vertex {i} is {:?}, and must lean towards +z or -z", at(columns));
                ply.problem(rule, "correct the normal, or leave all normals out")
            })?;
            normals.push(normal * normal.z.signum());
        }
        Ok(())
    })?;
    let list = ply.columns(["vertex_indices"]).or(ply.columns(["vertex_index"]));
    match (ply.next_element(), list) {
        (Some(("face", _)), Some([column])) if ply.is_its_list(column) => {}
        _ => {
            let rule = "the element behind `vertex` must be `face`, with the one list `vertex_indices`";
            return Err(ply.problem(rule, "write the file again as a mesh of triangles"));
        }
    }
    ply.rows(|ply, i, PlyRow { list, .. }| {
        push(&mut triangles, list, &points).map_err(|rule| ply.problem(format!("face {i} {rule}"), FACE_HELP))?;
        few(&triangles).map_err(|rule| ply.problem(rule, THIN_OUT))
    })?;
    Ok((points, normal_columns.is_some().then_some(normals), triangles))
}

fn obj<R: BufRead>(lines: &mut TextLines<R>) -> Result<Parts, Error> {
    let (mut points, mut triangles, mut buffer) = (Vec::new(), Vec::new(), Vec::new());
    while let Some(line) = lines.next(&mut buffer)? {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let mut axis = |name: &str| {
                    let word = words.next().ok_or_else(|| {
                        lines.problem(format!("the vertex has no {name}"), "write `v x y z` in every line of a vertex")
                    })?;
                    lines.number(name, word)
                };
                let point = DVec3::new(axis("x")?, axis("y")?, axis("z")?);
                lines.push(&mut points, point)?;
            }
            Some("f") => {
                // Corners count from 1, or backwards from the last vertex so far; texture and normal follow a slash.
                let corner = |word: &str| match word.split('/').next().and_then(|v| v.parse::<i64>().ok()) {
                    Some(k) if k > 0 => Ok((k - 1) as f64),
                    Some(k) if k < 0 => Ok(points.len() as f64 + k as f64),
                    _ => Err(lines.problem(format!("the corner {word:?} is no number of a vertex"), FACE_HELP)),
                };
                let corners = words.map(corner).collect::<Result<Vec<f64>, Error>>()?;
                push(&mut triangles, &corners, &points)
                    .map_err(|rule| lines.problem(format!("the face {rule}"), FACE_HELP))?;
                few(&triangles).map_err(|rule| lines.problem(rule, THIN_OUT))?;
            }
            Some("vn" | "vt" | "vp" | "o" | "g" | "s" | "l" | "p" | "usemtl" | "mtllib") | None => {}
            Some(word) if word.starts_with('#') => {}
            Some(word) => {
                let rule = format!("the line begins with {word:?}, which a mesh of triangles does not have");
                return Err(lines.problem(rule, "export the surface as triangles, with `v` and `f` lines"));
            }
        }
    }
    Ok((points, None, triangles))
}

const FACE_HELP: &str = "a face names three or more different vertices of the file, in a plane, one of which sees all others: export the surface as triangles";

const THIN_OUT: &str = "thin the mesh out: a smooth surface needs far fewer";

/// That the triangles are no more than may be.
fn few(triangles: &[[u32; 3]]) -> Result<(), String> {
    if triangles.len() as u64 <= MAX_TRIANGLES {
        return Ok(());
    }
    Err(format!("the file has more than {MAX_TRIANGLES} triangles, which is the limit"))
}

/// Most corners of a face.
const MOST_CORNERS: usize = 64;

/// Appends a face, as triangles from a corner that sees all others; what is wrong with it, otherwise.
fn push(triangles: &mut Vec<[u32; 3]>, corners: &[f64], points: &[DVec3]) -> Result<(), String> {
    let known = |k: &f64| *k >= 0.0 && *k < points.len() as f64 && *k == k.trunc();
    if let Ok(three) = <&[f64; 3]>::try_from(corners)
        && three.iter().all(known)
        && has_area(three.map(|k| k as u32), points)
    {
        triangles.push(three.map(|k| k as u32));
        return Ok(());
    }
    if let Some(unknown) = corners.iter().find(|k| !known(k)) {
        return Err(format!("has the corner {unknown}, counted from 0, and the file has {} vertices", points.len()));
    }
    if !(3..=MOST_CORNERS).contains(&corners.len()) {
        return Err(format!("has {} corners, and must have 3 to {MOST_CORNERS}", corners.len()));
    }
    let named: Vec<u32> = corners.iter().map(|k| *k as u32).collect();
    if (1..named.len()).any(|k| named[..k].contains(&named[k])) {
        return Err("names a vertex twice".to_owned());
    }
    if named.len() > 4 && !is_plane(&named, points) {
        return Err(format!("has {} corners, and is not plane", named.len()));
    }
    // From a corner that sees all others: of a dented face of four that is the dent, or the corner across.
    let from = (0..named.len()).find(|first| is_fan(&named, *first, points));
    let Some(from) = from.or((named.len() == 3).then_some(0)) else {
        return Err(format!("has {} corners, and none that sees all others", named.len()));
    };
    let at = |k: usize| named[(from + k) % named.len()];
    triangles.extend((2..named.len()).map(|k| [at(0), at(k - 1), at(k)]));
    Ok(())
}

/// Whether a triangle has an area, as computed from its first corner; one that names a corner twice has none.
fn has_area(corners: [u32; 3], points: &[DVec3]) -> bool {
    let [a, b, c] = corners.map(|k| points[k as usize]);
    let double = (b - a).cross(c - a).length_squared();
    double > 0.0 && double.is_finite()
}

/// Whether the triangles from corner `first` of a face to its sides all turn one way and have an area, and turn once around.
fn is_fan(face: &[u32], first: usize, points: &[DVec3]) -> bool {
    let at = |k: usize| points[face[(first + k) % face.len()] as usize];
    let normals: Vec<DVec3> = (2..face.len()).map(|k| (at(k - 1) - at(0)).cross(at(k) - at(0))).collect();
    let sum: DVec3 = normals.iter().copied().sum();
    let size = sum.length();
    let angles: f64 = (2..face.len()).map(|k| (at(k - 1) - at(0)).angle_between(at(k) - at(0))).sum();
    normals.iter().all(|normal| normal.dot(sum) > 1e-9 * size * size) && angles < 2.0 * std::f64::consts::PI
}

/// Whether a face is plane, to some roundings of f32.
fn is_plane(face: &[u32], points: &[DVec3]) -> bool {
    let at = |k: usize| points[face[k % face.len()] as usize];
    let area = (2..face.len()).map(|k| (at(k - 1) - at(0)).cross(at(k) - at(0))).sum::<DVec3>();
    let size = area.length().sqrt();
    (1..face.len()).all(|k| ((at(k) - at(0)).dot(area) / area.length()).abs() <= 1e-5 * size)
}
