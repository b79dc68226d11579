//! The prism of an instrument as one watertight body.

use super::instrument::System;
use super::tessellated::{used_part, within_margin};
use crate::error::Error;
use crate::geom::Rect;
use crate::prism::biprism::Prism;
use crate::prism::side::Side;
use crate::surface::face::Face;
use crate::surface::shape::Surface;
use crate::surface::solid::Solid;
use glam::DVec2;
use rayon::prelude::*;

/// Cells of a body across one half, where nothing else is said: 0.1 mm of the design paper's prism.
pub const CELLS: usize = 128;
/// Most cells along y, for one across a half.
const MOST_ROWS: usize = 16;
/// Most triangles of a body: as many as are read back.
pub const MOST_TRIANGLES: usize = 4_000_000;
/// Cells are made at most this many times as many at once, for a coarse body says little of a fine one.
const MOST_GROWTH: f64 = 16.0;
/// A body of triangles is looked for at so many places along each side of its outline.
const PLACES: usize = 17;
/// The outline of triangles is smaller than they are by this share, so that rounding takes no place beyond their border.
const INSIDE: f64 = 1e-9;

/// A body cut to within a tolerance.
#[derive(Debug, Clone)]
pub struct CutBody {
    /// The body.
    pub solid: Solid,
    /// How far along z a triangle of it lies from the surface, in mm: the largest of what is found at the middles of all triangles
    /// and of their sides. A quadratic surface is nowhere farther by more than a tenth of that.
    pub chord_mm: f64,
}

/// What a body is cut from.
struct Blank<'a> {
    prism: &'a Prism,
    outline: Rect,
}

/// The body of the prism as it is meant to be, in the prism's frame, with `cells` cells across each half: over the rectangle that
/// holds what the rays of the picture meet of front and back, where x >= 0 between those of the right half, where x < 0
/// between those of the left one, with upright walls. A surface that ends within that rectangle goes on as straight as it ends. Of
/// triangles it is the rectangle that front and back fill, or what rays of the right half meet where they fill none.
///
/// # Errors
/// An [`Error`] without a prism, where a ray on the way of the right half ends, or where the glass pinches to nothing.
pub fn solid(system: &System, cells: usize) -> Result<Solid, Error> {
    Blank::of(system)?.cut(cells)
}

/// [`solid`] with as few cells as keep within `tolerance_mm`, or nearly: see [`CutBody::chord_mm`].
///
/// # Errors
/// As [`solid`], and where it would have more than [`MOST_TRIANGLES`].
pub(crate) fn solid_within(system: &System, tolerance_mm: f64) -> Result<CutBody, Error> {
    let blank = Blank::of(system)?;
    let (mut cells, mut coarser) = (1, f64::NAN);
    loop {
        if blank.triangles(cells) > MOST_TRIANGLES {
            let rule = format!(
                "for a tolerance of {tolerance_mm:e} mm it would have more than {MOST_TRIANGLES} triangles, which is the most"
            );
            let help = format!("ask for more: fewer triangles already kept to {coarser:.1e} mm");
            return Err(Error::new("--tolerance-mm", rule, help));
        }
        let solid = blank.cut(cells)?;
        let chord_mm = blank.chord_mm(&solid, cells);
        if chord_mm <= tolerance_mm {
            return Ok(CutBody { solid, chord_mm });
        }
        // A chord strays by the square of its length, of a crease by its length.
        coarser = chord_mm;
        let growth = (1.02 * (chord_mm / tolerance_mm).sqrt()).clamp(1.1, MOST_GROWTH);
        cells = (cells as f64 * growth).ceil() as usize;
    }
}

impl<'a> Blank<'a> {
    fn of(system: &'a System) -> Result<Self, Error> {
        let prism =
            system.designed().ok_or_else(|| no("the scene has no prism", "give the scene a prism of two surfaces"))?;
        if let Some(outline) = filled(prism) {
            return Ok(Self { prism, outline });
        }
        let used = used_part(system).ok_or_else(|| {
            no("a ray of the right half ends before it has passed the prism", "run `biprism check` on the scene")
        })?;
        let is_mesh = Face::ALL.iter().any(|face| matches!(prism.surface(Side::Right, *face), Surface::Mesh { .. }));
        let used = if is_mesh { used.map(|part| within_margin(&part)) } else { used };
        let reach = used.iter().fold(DVec2::ZERO, |most, part| most.max(part.max.abs()).max(part.min.abs()));
        Ok(Self { prism, outline: Rect { min: -reach, max: reach } })
    }

    /// Cells along y for `cells` across one half.
    fn rows(&self, cells: usize) -> usize {
        let size = self.outline.size();
        cells * (2.0 * size.y / size.x).round().clamp(1.0, MOST_ROWS as f64) as usize
    }

    fn triangles(&self, cells: usize) -> usize {
        let rows = self.rows(cells);
        8 * cells * rows + 4 * (2 * cells + rows)
    }

    fn height_mm(&self, face: Face, at: DVec2) -> Option<f64> {
        height_of_mm(self.prism, if at.x < 0.0 { Side::Left } else { Side::Right }, face, at)
    }

    fn cut(&self, cells: usize) -> Result<Solid, Error> {
        let heights = |at: DVec2| Some([self.height_mm(Face::Front, at)?, self.height_mm(Face::Back, at)?]);
        Solid::between(self.outline, [2 * cells, self.rows(cells)], heights).map_err(|at| {
            let rule = format!(
                "over ({:.3}, {:.3}) mm its back does not lie behind its front, or one of them is not there",
                at.x, at.y
            );
            no(&rule, "use a thicker prism, or surfaces that are polynomials or of revolution")
        })
    }

    /// How far the two sheets of a body that was cut here stray from their surfaces: see [`CutBody::chord_mm`].
    fn chord_mm(&self, solid: &Solid, cells: usize) -> f64 {
        let sheet = 4 * cells * self.rows(cells);
        let off = |(k, triangle): (usize, &[u32; 3])| {
            let face = if k < sheet { Face::Front } else { Face::Back };
            let [a, b, c] = triangle.map(|corner| solid.points_mm[corner as usize]);
            let places = [0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a), (a + b + c) / 3.0];
            let strays = places.map(|p| self.height_mm(face, p.truncate()).map_or(0.0, |z| (z - p.z).abs()));
            strays.into_iter().fold(0.0, f64::max)
        };
        solid.triangles[..2 * sheet].par_iter().enumerate().map(off).reduce(|| 0.0, f64::max)
    }
}

fn no(rule: &str, help: &str) -> Error {
    Error::new("the prism's body", rule.to_owned(), help.to_owned())
}

fn height_of_mm(prism: &Prism, side: Side, face: Face, at: DVec2) -> Option<f64> {
    prism.surface(side, face).continued_mm(at.x, at.y)
}

/// The rectangle over which a prism of triangles has front and back, as far to both sides of x = 0; `None` of other prisms, and
/// where triangles fill none.
fn filled(prism: &Prism) -> Option<Rect> {
    let mut outline = Rect { min: DVec2::NEG_INFINITY, max: DVec2::INFINITY };
    for side in [Side::Left, Side::Right] {
        for face in Face::ALL {
            let Surface::Mesh { mesh, mirrored } = prism.surface(side, face) else { return None };
            let own = mesh.extent();
            // The mirror image of the right half reaches as far.
            let beside = if side == Side::Left && !mirrored { -own.min.x } else { own.max.x };
            outline.max = outline.max.min(DVec2::new(beside, own.max.y));
            outline.min = outline.min.max(DVec2::new(-beside, own.min.y));
        }
    }
    let reach = outline.max.x.min(-outline.min.x) * (1.0 - INSIDE);
    let inside = INSIDE * (outline.max.y - outline.min.y);
    let outline =
        Rect { min: DVec2::new(-reach, outline.min.y + inside), max: DVec2::new(reach, outline.max.y - inside) };
    let share = |k: usize| k as f64 / (PLACES - 1) as f64;
    let mut places = (0..PLACES * PLACES).map(|k| DVec2::new(share(k % PLACES), share(k / PLACES)));
    let is_there = |place: DVec2| {
        let at = outline.min + place * outline.size();
        let side = if at.x < 0.0 { Side::Left } else { Side::Right };
        Face::ALL.iter().all(|face| height_of_mm(prism, side, *face, at).is_some())
    };
    places.all(is_there).then_some(outline)
}
