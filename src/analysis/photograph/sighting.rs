//! A corner of a lattice as the rays that saw it.

use crate::analysis::half_image::HalfFrame;
use crate::geom::Ray;
use crate::system::{Board, InLight};
use crate::vision::{LatticeCorner, Polarity};
use glam::{DMat2, DVec2, IVec2};

/// How far beside a corner the rays pass that tell what a px is on the board, in px: a map that bends by 2e-4 of its slope a
/// px, as the most bent prism here does, changes by 5e-5 of it in between.
const BESIDE_PX: f64 = 0.25;

/// A corner, with its ray beyond the glass and two that pass beside it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sighting {
    /// Column and row in the lattice of its half.
    pub(super) index: IVec2,
    /// Which diagonal is bright, where the detector says.
    pub(super) polarity: Option<Polarity>,
    /// The ray through the corner.
    pub(super) ray: Ray,
    /// Rays through places beside it in x and in y, and how far these are, in px.
    beside: [(Ray, f64); 2],
}

impl Sighting {
    /// The corner `seen` in a half; `None` where its rays do not pass.
    pub(super) fn of(light: &InLight<'_>, frame: &HalfFrame, seen: &LatticeCorner) -> Option<Self> {
        let ray_at = |px: DVec2| light.exit_ray_through(frame.full(px), frame.side()).ok();
        let beside = |axis: DVec2| {
            [BESIDE_PX, -BESIDE_PX].into_iter().find_map(|step| Some((ray_at(seen.position_px + axis * step)?, step)))
        };
        Some(Self {
            index: IVec2::from_array(seen.index),
            polarity: seen.polarity,
            ray: ray_at(seen.position_px)?,
            beside: [beside(DVec2::X)?, beside(DVec2::Y)?],
        })
    }

    /// Where the corner's ray meets the plane of `board`, in mm in the board's frame.
    pub(super) fn met_mm(&self, board: &Board) -> Option<DVec2> {
        board.intersect(&self.ray).ok().map(|(at_mm, _)| at_mm)
    }

    /// How far the corner was found from where the picture has the point `point_mm` of `board`, in px: what lies between them
    /// on the board, by what a px is there.
    pub(super) fn residual_px(&self, board: &Board, point_mm: DVec2) -> Option<DVec2> {
        let met_mm = self.met_mm(board)?;
        let [x, y] = self.beside.each_ref().map(|(ray, step)| {
            let (at_mm, _) = board.intersect(ray).ok()?;
            Some((at_mm - met_mm) / *step)
        });
        let residual = DMat2::from_cols(x?, y?).inverse() * (met_mm - point_mm);
        residual.is_finite().then_some(residual)
    }
}
