//! Sag over a grid as optics programs have it: Zemax grid sag files, `.DAT` of a sequential surface and `.GRD` of an object.
//!
//! Line 1 is `nx ny delx dely unitflag xdec ydec`: columns and rows (5 or more), their steps, the unit (0 mm, 1 cm, 2 in, 3 m), and
//! where the middle of the grid lies. Then a line a point, `z dz/dx dz/dy d2z/dxdy nodata`: the first is the upper left one
//! (-x, +y), the next its neighbour to the right, and rows go down. Derivatives that are all 0 ask the program to take
//! differences; `nodata` 1 is a point without a value (OpticStudio, Help, "Grid Sag").

use super::lines::TextLines;
use crate::error::Error;
use glam::{DVec2, DVec3};
use std::io::{self, BufRead, BufWriter, Write};

/// Fewest columns, and fewest rows.
pub const FEWEST: usize = 5;
/// mm a unit, by the unit flag.
const UNITS_MM: [f64; 4] = [1.0, 10.0, 25.4, 1000.0];
/// What to do about a file that is broken.
const AGAIN: &str =
    "export the surface again as grid sag: `nx ny delx dely unitflag xdec ydec`, then nx ny lines of a point";

/// Where the points of a grid are, x to the right and y up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SagGrid {
    /// Columns and rows.
    pub size: [usize; 2],
    /// From column to column and from row to row, in mm.
    pub step_mm: DVec2,
    /// The middle of the grid.
    pub middle_mm: DVec2,
}

/// The surface at a point of a grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SagPoint {
    /// Sag, in mm.
    pub z: f64,
    /// dz/dx, dz/dy.
    pub slope: DVec2,
    /// d2z/dxdy, in 1/mm.
    pub twist: f64,
}

impl SagGrid {
    /// Count of points.
    pub fn points(&self) -> usize {
        self.size[0] * self.size[1]
    }

    /// The place of the point in column `i` from the left and row `j` from the top, in mm.
    pub fn place(&self, i: usize, j: usize) -> DVec2 {
        let from_middle = |k: usize, n: usize| k as f64 - 0.5 * (n - 1) as f64;
        let [across, down] = [from_middle(i, self.size[0]), from_middle(j, self.size[1])];
        self.middle_mm + self.step_mm * DVec2::new(across, -down)
    }

    /// The places of all points, in the order of a file.
    pub fn places(&self) -> impl Iterator<Item = DVec2> + '_ {
        (0..self.size[1]).flat_map(move |j| (0..self.size[0]).map(move |i| self.place(i, j)))
    }
}

/// Writes the `points` over `grid`, in the order of [`SagGrid::places`], in mm; `None` is a point without a value. Every number reads
/// back as the same f64. `out` is buffered here.
///
/// # Errors
/// Those of `out`.
pub(crate) fn write_grid_sag(grid: &SagGrid, points: &[Option<SagPoint>], out: impl Write) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    let ([nx, ny], step, middle) = (grid.size, grid.step_mm, grid.middle_mm);
    writeln!(out, "{nx} {ny} {:?} {:?} 0 {:?} {:?}", step.x, step.y, middle.x, middle.y)?;
    for point in points {
        match point {
            Some(SagPoint { z, slope, twist }) => writeln!(out, "{z:?} {:?} {:?} {twist:?} 0", slope.x, slope.y)?,
            None => writeln!(out, "0 0 0 0 1")?,
        }
    }
    out.flush()
}

/// The points of a grid sag file that have a value, in mm, x to the right, y up, in the order of the file. Derivatives are not asked
/// for: the columns behind z may be left out. Lines that begin with `!` or `#` are comments.
pub(super) fn read<R: BufRead>(lines: &mut TextLines<R>) -> Result<Vec<DVec3>, Error> {
    let mut buffer = Vec::new();
    let first = next(lines, &mut buffer)?.unwrap_or_default();
    let (grid, unit_mm) = header(lines, &first)?;
    let mut points = Vec::new();
    for (k, place) in grid.places().enumerate() {
        let Some(line) = next(lines, &mut buffer)? else {
            let rule = format!("the file ends after {k} points, and its grid has {}", grid.points());
            return Err(lines.problem(rule, AGAIN));
        };
        if let Some(z) = sag(lines, &line)? {
            let point = place.extend(z) * unit_mm;
            if !point.is_finite() {
                return Err(lines.problem(format!("the point is {point} mm, and must be finite"), AGAIN));
            }
            points.push(point);
        }
    }
    if next(lines, &mut buffer)?.is_some() {
        let rule = format!("there are more lines than the {} points of the grid", grid.points());
        return Err(lines.problem(rule, AGAIN));
    }
    if points.is_empty() {
        return Err(lines.problem(format!("all {} points have nodata 1, and none a value", grid.points()), AGAIN));
    }
    Ok(points)
}

/// The next line that says something.
fn next<R: BufRead>(lines: &mut TextLines<R>, buffer: &mut Vec<u8>) -> Result<Option<String>, Error> {
    while let Some(line) = lines.next(buffer)? {
        let line = line.trim();
        if !line.is_empty() && !line.starts_with(['!', '#']) {
            return Ok(Some(line.to_owned()));
        }
    }
    Ok(None)
}

/// The grid in the file's unit, and mm a unit.
fn header<R: BufRead>(lines: &TextLines<R>, text: &str) -> Result<(SagGrid, f64), Error> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let [nx, ny, delx, dely, unit, xdec, ydec] = words[..] else {
        let rule =
            format!("the first line has {} values, and must have 7: nx ny delx dely unitflag xdec ydec", words.len());
        return Err(lines.problem(rule, AGAIN));
    };
    let count = |name: &str, word: &str| {
        word.parse().ok().filter(|n: &u64| *n >= FEWEST as u64).ok_or_else(|| {
            let rule = format!("{name} is {word:?}, and must be a whole number from {FEWEST} on");
            lines.problem(rule, AGAIN)
        })
    };
    let step = |name: &str, word: &str| {
        let step = lines.number(name, word)?;
        let rule = || format!("{name} is {step}, and must be above 0");
        if step > 0.0 { Ok(step) } else { Err(lines.problem(rule(), AGAIN)) }
    };
    let (nx, ny) = (count("nx", nx)?, count("ny", ny)?);
    if nx.checked_mul(ny).is_none_or(|points| points > lines.limit) {
        let rule = format!("the grid has {nx} x {ny} points, and the limit is {}", lines.limit);
        let help = "thin the grid out: a surface of some dozen coefficients needs far fewer";
        return Err(lines.problem(rule, help));
    }
    let unit_mm = unit.parse().ok().and_then(|flag: usize| UNITS_MM.get(flag)).ok_or_else(|| {
        let rule = format!("the unit flag is {unit:?}, and must be 0 (mm), 1 (cm), 2 (in) or 3 (m)");
        lines.problem(rule, AGAIN)
    })?;
    let step_mm = DVec2::new(step("delx", delx)?, step("dely", dely)?);
    let middle_mm = DVec2::new(lines.number("xdec", xdec)?, lines.number("ydec", ydec)?);
    Ok((SagGrid { size: [nx as usize, ny as usize], step_mm, middle_mm }, *unit_mm))
}

/// z of a line, in the file's unit; `None` where it has no value.
fn sag<R: BufRead>(lines: &TextLines<R>, line: &str) -> Result<Option<f64>, Error> {
    let names = ["z", "dz/dx", "dz/dy", "d2z/dxdy", "nodata"];
    let words: Vec<&str> = line.split_whitespace().collect();
    if words.len() > names.len() {
        let rule = format!("the line has {} values, and has at most 5: {}", words.len(), names.join(" "));
        return Err(lines.problem(rule, AGAIN));
    }
    if ![1, 4, 5].contains(&words.len()) {
        let rule = format!(
            "the line has {} values, and must have z alone, the derivatives too, or all 5: {}",
            words.len(),
            names.join(" ")
        );
        return Err(lines.problem(rule, AGAIN));
    }
    // A point without a value may hold anything.
    if words.get(4).is_some_and(|flag| flag.parse() == Ok(1.0)) {
        return Ok(None);
    }
    let numbers = names.into_iter().zip(&words).map(|(name, word)| lines.number(name, word));
    let numbers = numbers.collect::<Result<Vec<f64>, Error>>()?;
    match numbers.get(4) {
        None | Some(0.0) => Ok(numbers.first().copied()),
        Some(flag) => Err(lines.problem(format!("nodata is {flag}, and must be 0 or 1"), AGAIN)),
    }
}

#[cfg(test)]
#[path = "grid_sag_tests.rs"]
mod tests;
