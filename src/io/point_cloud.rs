//! A point cloud from a file: CSV with named columns, PLY, XYZ, or grid sag.

use super::grid_sag;
use super::inputs;
use super::lines::TextLines;
use super::ply::Ply;
use crate::error::Error;
use crate::surface::face::Face;
use glam::DVec3;
use std::io::{BufRead, BufReader};
use std::path::Path;

/// Most points of a file: 240 MB in memory.
pub const MAX_POINTS: u64 = 10_000_000;

/// How the points are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PointFormat {
    /// Comma-separated values below a line of column names: `x_mm`, `y_mm`, `z_mm` or `x`, `y`, `z`, or those of
    /// [`crate::io::point_grid::CSV_HEADER`]. Other columns are ignored.
    Csv,
    /// PLY 1.0, ascii or binary. The first element is `vertex`, with x, y and z among its scalar properties.
    Ply,
    /// x y z in the first three columns of every line, between blanks, tabs or commas.
    Xyz,
    /// Sag over a grid, in mm: [`crate::io::grid_sag`].
    GridSag,
}

/// The points of the file at `path`, in mm, in its order; the format follows from the extension (.csv, .ply, .xyz, .txt, .dat, .grd). A
/// CSV that holds both surfaces of a design gives those of `face`.
///
/// # Errors
/// A [`Error`] with file, line, value and rule when the file cannot be read, breaks its format, holds a number that is not
/// finite, or has more than [`MAX_POINTS`].
pub fn read_points(path: &Path, face: Face) -> Result<Vec<DVec3>, Error> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let format = match extension.as_str() {
        "csv" => PointFormat::Csv,
        "ply" => PointFormat::Ply,
        "xyz" | "txt" => PointFormat::Xyz,
        "dat" | "grd" => PointFormat::GridSag,
        _ => {
            let rule =
                format!("the extension is {extension:?}, and a point cloud's must be csv, ply, xyz, txt, dat or grd");
            let help = match extension.as_str() {
                "stl" | "obj" => "its triangles are read as they are by kind = \"mesh\"",
                _ => "save the points as CSV with the columns x_mm,y_mm,z_mm, or as XYZ",
            };
            return Err(Error::new(path.display(), rule, help));
        }
    };
    let unreadable =
        |e| Error::new(path.display(), format!("cannot be read: {e}"), "check the path and its permissions");
    let file = inputs::open(path).map_err(unreadable)?;
    let bytes = file.metadata().map_err(unreadable)?.len();
    parse_points(&path.display().to_string(), format, BufReader::new(file), bytes, face)
}

/// [`read_points`] from any `input` of `bytes` bytes, called `name` in messages.
///
/// # Errors
/// As [`read_points`].
pub fn parse_points(
    name: &str,
    format: PointFormat,
    input: impl BufRead,
    bytes: u64,
    face: Face,
) -> Result<Vec<DVec3>, Error> {
    parse_at_most(MAX_POINTS, name, format, input, bytes, face)
}

/// [`parse_points`] with a limit other than [`MAX_POINTS`].
fn parse_at_most(
    limit: u64,
    name: &str,
    format: PointFormat,
    input: impl BufRead,
    bytes: u64,
    face: Face,
) -> Result<Vec<DVec3>, Error> {
    let mut lines = TextLines { name, input, line: 0, taken: 0, limit };
    match format {
        PointFormat::Csv => csv(&mut lines, face),
        PointFormat::Xyz => xyz(&mut lines),
        PointFormat::Ply => ply_points(&mut lines, bytes),
        PointFormat::GridSag => grid_sag::read(&mut lines),
    }
}

fn csv<R: BufRead>(lines: &mut TextLines<R>, face: Face) -> Result<Vec<DVec3>, Error> {
    let mut buffer = Vec::new();
    let header = lines.next(&mut buffer)?.unwrap_or_default();
    let names: Vec<String> = header.split(',').map(|n| n.trim().trim_matches('"').to_lowercase()).collect();
    let name = match face {
        Face::Front => "front",
        Face::Back => "back",
    };
    let column = |axis: &str| {
        let spelled = [format!("{axis}_mm"), axis.to_owned(), format!("{name}_{axis}_mm")];
        names.iter().position(|n| spelled.contains(n))
    };
    let (Some(x), Some(y), Some(z)) = (column("x"), column("y"), column("z")) else {
        return Err(lines.problem(
            format!("the columns are {names:?}, and must include x_mm, y_mm and z_mm"),
            "name the columns in the first line; a file of bare numbers has the extension .xyz",
        ));
    };
    let mut points = Vec::new();
    while let Some(line) = lines.next(&mut buffer)? {
        if line.is_empty() {
            continue;
        }
        let values: Vec<&str> = line.split(',').map(str::trim).collect();
        if values.len() != names.len() {
            return Err(lines.problem(
                format!("the line has {} values, and must have {}, one a column", values.len(), names.len()),
                "correct or remove the line",
            ));
        }
        let value = |i: usize| lines.number(&names[i], values[i]);
        let point = DVec3::new(value(x)?, value(y)?, value(z)?);
        lines.push(&mut points, point)?;
    }
    Ok(points)
}

fn xyz<R: BufRead>(lines: &mut TextLines<R>) -> Result<Vec<DVec3>, Error> {
    let (mut points, mut buffer) = (Vec::new(), Vec::new());
    while let Some(line) = lines.next(&mut buffer)? {
        if line.trim_start().starts_with('#') || line.trim().is_empty() {
            continue;
        }
        let separator = |c: char| c == ',' || c.is_whitespace();
        let mut values = line.split(separator).filter(|v| !v.is_empty());
        let (Some(x), Some(y), Some(z)) = (values.next(), values.next(), values.next()) else {
            return Err(lines.problem(
                format!("the line is {line:?}, and must have at least 3 values: x y z"),
                "correct or remove the line; comments begin with #",
            ));
        };
        let point = DVec3::new(lines.number("x", x)?, lines.number("y", y)?, lines.number("z", z)?);
        lines.push(&mut points, point)?;
    }
    Ok(points)
}

fn ply_points<R: BufRead>(lines: &mut TextLines<R>, bytes: u64) -> Result<Vec<DVec3>, Error> {
    let mut ply = Ply::open(lines, bytes)?;
    let (_, count) = ply.next_element().unwrap_or_default();
    let [x, y, z] = ply.columns(["x", "y", "z"]).unwrap_or_default();
    let mut points = Vec::new();
    ply.rows(|ply, i, row| {
        // By now the file is known to be long enough for as many.
        points.reserve(if i == 1 { count as usize } else { 0 });
        points.push(finite_point(ply, i, [row.values[x], row.values[y], row.values[z]])?);
        Ok(())
    })?;
    Ok(points)
}

/// A vertex of a PLY file, the `i`-th of it.
pub(super) fn finite_point<R: BufRead>(ply: &Ply<R>, i: u64, xyz: [f64; 3]) -> Result<DVec3, Error> {
    let point = DVec3::from_array(xyz);
    if point.is_finite() {
        return Ok(point);
    }
    Err(ply.problem(format!("vertex {i} is {point}, and must be finite"), "remove or correct the vertex"))
}

#[cfg(test)]
#[path = "point_cloud_tests.rs"]
mod tests;
