//! The prism of an instrument as one watertight body.

use super::instrument::System;
use super::tessellated::used_part;
use crate::error::Error;
use crate::geom::Rect;
use crate::prism::side::Side;
use crate::surface::face::Face;
use crate::surface::solid::Solid;
use glam::DVec2;

/// Cells of a body across one half, where nothing else is said: 0.1 mm of the design paper's prism.
pub const CELLS: usize = 128;
/// Most cells along y, for one across a half.
const MOST_ROWS: usize = 16;

/// The body of the prism as it is meant to be, in the prism's frame, with `cells` cells across each half: over the rectangle that
/// holds what the rays of the picture meet of front and back, where x >= 0 between those of the right half, where x < 0
/// between those of the left one, with upright walls. A surface that ends within that rectangle goes on as straight as it ends.
///
/// # Errors
/// An [`Error`] without a prism, of one that is a mesh already, where a ray on the way of the right half ends, or where
/// the glass pinches to nothing.
pub fn solid(system: &System, cells: usize) -> Result<Solid, Error> {
    let no = |rule: &str, help: &str| Error::new("the prism's body", rule.to_owned(), help.to_owned());
    let prism = system
        .designed
        .as_deref()
        .ok_or_else(|| no("the scene has no prism", "give the scene a prism of two surfaces"))?;
    let used = used_part(system).ok_or_else(|| {
        no("a ray of the right half ends before it has passed the prism", "run `biprism check` on the scene")
    })?;
    let reach = used.iter().fold(DVec2::ZERO, |most, part| most.max(part.max.abs()).max(part.min.abs()));
    let outline = Rect { min: -reach, max: reach };
    let rows = cells * (2.0 * reach.y / reach.x).round().clamp(1.0, MOST_ROWS as f64) as usize;
    let heights = |at: DVec2| {
        let side = if at.x < 0.0 { Side::Left } else { Side::Right };
        let [low, high] = Face::ALL.map(|face| prism.surface(side, face).continued_mm(at.x, at.y));
        Some([low?, high?])
    };
    Solid::between(outline, [2 * cells, rows], heights).map_err(|at| {
        let rule = format!(
            "over ({:.3}, {:.3}) mm its back does not lie behind its front, or one of them is not there",
            at.x, at.y
        );
        no(&rule, "use a thicker prism, or surfaces that are polynomials or of revolution")
    })
}
