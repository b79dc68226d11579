//! What the plane of the board shows: the checkerboard, or a plate with a texture.

use super::checkerboard::Checkerboard;
use super::plan::Plan;
use crate::geom::Ray;
use crate::system::System;
use crate::texture::Plate;
use glam::DVec2;

/// The radiance of the board's plane, in squares of the checkerboard from its centre also where it shows a texture.
#[derive(Debug, Clone, Copy)]
pub(super) struct BoardFace<'a> {
    pattern: Checkerboard,
    plate: Option<&'a Plate>,
}

impl<'a> BoardFace<'a> {
    /// That of the board of `system`.
    pub(super) fn new(system: &'a System) -> Self {
        Self { pattern: Checkerboard::new(&system.board().pattern), plate: system.plate() }
    }

    /// Squares per mm.
    pub(super) fn squares_per_mm(&self) -> f64 {
        self.pattern.squares_per_mm()
    }

    /// Radiance around the plate.
    pub(super) fn background(&self) -> f64 {
        self.pattern.background()
    }

    /// [`Checkerboard::constant`]; of a texture nothing is known to be the same.
    pub(super) fn constant(&self, c: DVec2, r: DVec2) -> Option<f64> {
        if self.plate.is_none() { self.pattern.constant(c, r) } else { None }
    }

    /// [`Checkerboard::mean_over`], of a convex polygon of up to 8 vertices.
    pub(super) fn mean_over(&self, polygon: &[DVec2]) -> Option<f64> {
        let Some(plate) = self.plate else { return self.pattern.mean_over(polygon) };
        let mm = 1.0 / self.pattern.squares_per_mm();
        let mut polygon_mm = [DVec2::ZERO; 8];
        polygon_mm.iter_mut().zip(polygon).for_each(|(to, from)| *to = *from * mm);
        plate.mean_over(&polygon_mm[..polygon.len()])
    }

    /// The radiance at `c`.
    pub(super) fn radiance(&self, c: DVec2) -> f64 {
        match self.plate {
            None => self.pattern.radiance(c),
            Some(plate) => plate.at(c / self.pattern.squares_per_mm()),
        }
    }

    /// The radiance at a point of the board, in mm in its frame.
    pub(super) fn at(&self, board_mm: DVec2) -> f64 {
        self.plate.map_or_else(|| self.pattern.at(board_mm), |plate| plate.at(board_mm))
    }
}

/// What the board and each object of `system` show, in this order.
pub(super) fn faces(system: &System) -> Vec<BoardFace<'_>> {
    std::iter::once(system).chain(system.layers()).map(BoardFace::new).collect()
}

/// The radiance that a ray behind the prism sees, given the [`faces`].
pub(super) fn point_radiance(system: &System, faces: &[BoardFace], ray: &Ray) -> f64 {
    system.nearest(ray).map_or(faces[0].background(), |(object, mm, _)| faces[object].at(mm))
}

impl<'a> Plan<'a> {
    /// What the plane of the board shows.
    pub(super) fn face(&self) -> BoardFace<'a> {
        BoardFace { pattern: self.pattern, plate: self.plate }
    }
}
