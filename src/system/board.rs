//! The board: a checkerboard on a plane of known radiance.

use crate::geom::{Pose, Ray};
use crate::num::simd::{Lanes, Mask};
use crate::optics::fate::Fate;
use crate::prism::lanes::Rays;
use crate::scene;
use glam::{DVec2, DVec3};

/// A checkerboard in its place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Board {
    /// The board as the scene states it.
    pub pattern: scene::BoardSpec,
    board_from_world: Pose,
}

impl Board {
    /// The board of a scene.
    pub fn new(board: &scene::BoardSpec) -> Self {
        Self { pattern: *board, board_from_world: board.world_from_board.inverse() }
    }

    /// The plane's unit normal, in the world.
    #[inline(always)]
    pub fn normal(&self) -> DVec3 {
        self.pattern.world_from_board.rotation.z_axis
    }

    /// A world vector in the plane of the board, in the board's frame.
    #[inline(always)]
    pub fn vector(&self, v: DVec3) -> DVec2 {
        let v = self.board_from_world.vector(v);
        DVec2::new(v.x, v.y)
    }

    /// A world point in the board's frame, in mm; z is the height above the plane.
    pub fn local(&self, world_mm: DVec3) -> DVec3 {
        self.board_from_world.point(world_mm)
    }

    /// The world position of a board position, in mm.
    pub fn world(&self, board_mm: DVec2) -> DVec3 {
        self.pattern.world_from_board.point(DVec3::new(board_mm.x, board_mm.y, 0.0))
    }

    /// Where the ray meets the plane of the board, in mm in the board's frame, and the distance to it, in mm.
    #[inline(always)]
    pub fn intersect(&self, ray: &Ray) -> Result<(DVec2, f64), Fate> {
        let r = ray.moved(&self.board_from_world);
        let t = -r.origin.z / r.direction.z;
        let seen = DVec2::new(r.origin.x + r.direction.x * t, r.origin.y + r.direction.y * t);
        // A ray nearly along the plane may meet it farther away than numbers reach.
        if t > 0.0 && seen.is_finite() { Ok((seen, t)) } else { Err(Fate::PastBoard) }
    }

    /// Where a packet of rays meets the plane of the board, with the bits of [`Board::intersect`]; false where one does not.
    #[inline(always)]
    pub fn intersect_all(&self, rays: &Rays) -> ([Lanes; 2], Mask) {
        let r = rays.moved(&self.board_from_world);
        let t = -r.origin.z / r.direction.z;
        let met = Lanes::splat(0.0).lt(t) & t.lt(Lanes::splat(f64::INFINITY));
        ([r.origin.x + r.direction.x * t, r.origin.y + r.direction.y * t], met)
    }

    /// Inner corners in x and y: one less than squares.
    pub fn inner_corners(&self) -> [usize; 2] {
        [self.pattern.columns - 1, self.pattern.rows - 1]
    }

    /// The inner corner (column, row), counted from the top left, in mm in the board's frame; whole numbers are corners,
    /// -1 and the count of inner corners are the rim of the squares.
    pub fn corner_at(&self, column: f64, row: f64) -> DVec2 {
        let b = &self.pattern;
        DVec2::new(column + 1.0 - 0.5 * b.columns as f64, row + 1.0 - 0.5 * b.rows as f64) * b.square_mm
    }

    /// Depth of an inner corner along z from `camera_z_mm`, in mm.
    pub fn corner_depth_mm(&self, [column, row]: [i32; 2], camera_z_mm: f64) -> f64 {
        self.world(self.corner_at(f64::from(column), f64::from(row))).z - camera_z_mm
    }
}
