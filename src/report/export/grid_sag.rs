//! A surface as sag over a grid with its exact derivatives, for OpticStudio's surface and object of this name.

use super::half_surface::{designed, no, used};
use crate::error::Error;
use crate::geom::Rect;
use crate::io::grid_sag::{FEWEST, SagGrid, SagPoint};
use crate::num::poly2::Jet;
use crate::surface::face::Face;
use crate::surface::shape::Surface;
use crate::system::{Side, System};
use glam::DVec2;

/// Columns at first: enough for the polynomials that are fitted to what is read back.
const FIRST_COLUMNS: usize = 17;
/// Most points of a grid.
pub const MOST_POINTS: usize = 1_000_000;
/// Columns are made at most this many times as many at once.
const MOST_GROWTH: f64 = 4.0;

/// A surface of the right half over a grid: x as in the prism's frame, y the other way round, as y is up there, and z from the vertex.
#[derive(Debug, Clone)]
pub struct SampledSurface {
    /// Where the points are.
    pub grid: SagGrid,
    /// The points in the order of the file, z less that of the vertex; `None` where there is no surface.
    pub points: Vec<Option<SagPoint>>,
    /// z of the vertex in the prism's frame, in mm: that of the surface at the middle of the grid. Within a factor of 2 of it a
    /// difference of f64 is exact, and so is the sum that gives z back.
    pub vertex_mm: f64,
    /// How far the bicubic surface through values and derivatives is from the surface, in mm: the largest of what is found at the
    /// middles of all cells and of their sides.
    pub interpolation_mm: f64,
    /// The degree of a polynomial that a surface is; `None` of other surfaces.
    pub degree: Option<usize>,
}

impl SampledSurface {
    /// The surface `face` of the prism as it is meant to be, with as few points as keep the bicubic surface within `tolerance_mm`, or
    /// nearly: a polynomial over its domain, other surfaces over what the rays of the picture meet.
    ///
    /// # Errors
    /// Without a prism, where a ray on the way of the right half ends, of triangles, and where more than [`MOST_POINTS`] are needed.
    pub fn new(system: &System, face: Face, tolerance_mm: f64) -> Result<Self, Error> {
        let surface = designed(system)?.surface(Side::Right, face);
        let (outline, degree) = match surface {
            Surface::Freeform(sheet) => (sheet.domain(), Some(sheet.sag().degree())),
            Surface::Plane { .. } => (used(system)?[face as usize], Some(1)),
            Surface::Revolved(_) => (used(system)?[face as usize], None),
            _ => {
                let rule = "the prism's surfaces are triangles, which have no exact derivatives".to_owned();
                return Err(no(rule, "take stl, ply or obj, or fit polynomials with `kind = \"point_cloud\"`"));
            }
        };
        let mut columns = FIRST_COLUMNS;
        loop {
            let grid = grid_over(&outline, columns);
            if grid.points() > MOST_POINTS {
                let rule =
                    format!("for a tolerance of {tolerance_mm:e} mm it would need more than {MOST_POINTS} points");
                return Err(Error::new("--tolerance-mm", rule, "ask for more"));
            }
            let sampled = Self::over(surface, grid, degree)?;
            if sampled.interpolation_mm <= tolerance_mm {
                return Ok(sampled);
            }
            // A bicubic surface strays by the fourth power of its cells.
            let growth = 1.02 * (sampled.interpolation_mm / tolerance_mm).sqrt().sqrt();
            columns = (columns as f64 * growth.clamp(1.1, MOST_GROWTH)).ceil() as usize;
        }
    }

    fn over(surface: &Surface, grid: SagGrid, degree: Option<usize>) -> Result<Self, Error> {
        let middle = upright(surface, grid.middle_mm);
        let vertex_mm = middle.map(|jet| jet.value).ok_or_else(|| {
            let rule =
                format!("at the middle of what rays meet of the prism, {} mm, there is no surface", grid.middle_mm);
            no(rule, "run `biprism check` on the scene")
        })?;
        let jets: Vec<Option<Jet>> = grid.places().map(|at| upright(surface, at)).collect();
        let point = |jet: Jet| SagPoint { z: jet.value - vertex_mm, slope: DVec2::new(jet.dx, jet.dy), twist: jet.dxy };
        let interpolation_mm = interpolation_mm(surface, &grid, &jets);
        let points = jets.iter().map(|jet| jet.map(point)).collect();
        Ok(Self { grid, points, vertex_mm, interpolation_mm, degree })
    }
}

/// A grid over `outline` of the prism's frame, with steps as even as they come.
fn grid_over(outline: &Rect, columns: usize) -> SagGrid {
    let (size, middle) = (outline.size(), 0.5 * (outline.min + outline.max));
    let rows = (((columns - 1) as f64 * size.y / size.x).ceil() as usize + 1).max(FEWEST);
    let step_mm = size / DVec2::new((columns - 1) as f64, (rows - 1) as f64);
    SagGrid { size: [columns, rows], step_mm, middle_mm: DVec2::new(middle.x, 0.0 - middle.y) }
}

/// The surface over a place with y up.
fn upright(surface: &Surface, at: DVec2) -> Option<Jet> {
    let jet = surface.jet(at.x, -at.y)?;
    Some(Jet { dy: -jet.dy, dxy: -jet.dxy, ..jet })
}

/// See [`SampledSurface::interpolation_mm`].
fn interpolation_mm(surface: &Surface, grid: &SagGrid, jets: &[Option<Jet>]) -> f64 {
    let ([columns, rows], h) = (grid.size, grid.step_mm);
    let at = |i: usize, j: usize| jets[j * columns + i];
    let stray = |place: DVec2, z: f64| upright(surface, place).map_or(0.0, |jet| (jet.value - z).abs());
    // Take a cell by its upper left corner: y falls from row to row.
    let of_cell = |i: usize, j: usize| {
        let [a, b, c, d] = [at(i, j)?, at(i + 1, j)?, at(i, j + 1)?, at(i + 1, j + 1)?];
        let corner = grid.place(i, j);
        let along_x = |p: &Jet, q: &Jet| 0.5 * (p.value + q.value) + 0.125 * h.x * (p.dx - q.dx);
        let along_y = |p: &Jet, q: &Jet| 0.5 * (p.value + q.value) + 0.125 * h.y * (q.dy - p.dy);
        let slope_y = |p: &Jet, q: &Jet| 0.5 * (p.dy + q.dy) + 0.125 * h.x * (p.dxy - q.dxy);
        let (top, bottom) = (along_x(&a, &b), along_x(&c, &d));
        let middle = 0.5 * (top + bottom) + 0.125 * h.y * (slope_y(&c, &d) - slope_y(&a, &b));
        let strays = [
            stray(corner + DVec2::new(0.5 * h.x, 0.0), top),
            stray(corner - DVec2::new(0.0, 0.5 * h.y), along_y(&a, &c)),
            stray(corner + DVec2::new(0.5 * h.x, -0.5 * h.y), middle),
        ];
        Some(strays.into_iter().fold(0.0, f64::max))
    };
    let cells = (0..rows - 1).flat_map(|j| (0..columns - 1).map(move |i| (i, j)));
    cells.filter_map(|(i, j)| of_cell(i, j)).fold(0.0, f64::max)
}
