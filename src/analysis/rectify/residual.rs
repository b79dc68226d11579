//! What the maps leave of a point that lies at another depth than theirs.

use super::rectifier::{GRID, Rectifier};
use crate::analysis::half_image::HalfFrame;
use crate::geom::Ray;
use crate::metrics::pair_residual::{PairResidual, SeenPoint};
use crate::metrics::{Deviation, Unmeasurable};
use crate::system::aim::Aimer;
use crate::system::{InLight, System};
use glam::DVec2;
use rayon::prelude::*;

/// What is left at one depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthResidual {
    /// The depth from the camera, in mm; infinite at infinity.
    pub depth_mm: f64,
    /// Where the rectified halves see points less where the pair of pinholes would, over a grid of both, in px.
    pub deviation: Result<Deviation, Unmeasurable>,
    /// The same of points that both halves see; `None` at infinity, and where there is none.
    pub pairs: Option<PairResidual>,
}

impl Rectifier {
    /// What the maps leave `depth_mm` from the camera, which may be infinite.
    ///
    /// The deviation of a ray from the pinhole is a constant of the ray times 1/Z - 1/Z0, Z0 the depth of the maps: between two
    /// depths it is nowhere larger than at both.
    pub fn residual(&self, depth_mm: f64) -> DepthResidual {
        let both = [0, 1].map(|k| self.rays[k].iter().map(move |ray| self.deviation_px(k, ray, depth_mm)));
        let residuals: Vec<DVec2> = both.into_iter().flatten().collect();
        DepthResidual { depth_mm, deviation: Deviation::of(&residuals), pairs: self.pairs(depth_mm) }
    }

    /// Where the rectified half `k` shows what `ray` meets at a depth, less where its pinhole would see that.
    fn deviation_px(&self, k: usize, ray: &Ray, depth_mm: f64) -> DVec2 {
        let camera = &self.pair.cameras()[k];
        let ray = ray.moved(&camera.camera_from_world);
        let ahead = self.centres_ahead_mm();
        let slope = ray.direction.truncate() / ray.direction.z;
        // Where the line of the ray passes the plane of the centre, from it.
        let beside_mm = ray.origin.truncate() - slope * ray.origin.z;
        beside_mm * ((self.depth_mm - ahead).recip() - (depth_mm - ahead).recip()) * camera.focal_px
    }

    /// What is left of points of both halves; `None` where there is none.
    pub(super) fn pairs(&self, depth_mm: f64) -> Option<PairResidual> {
        if depth_mm.is_infinite() {
            return None;
        }
        let there = self.before_plane(depth_mm);
        let (aimer, light) = (Aimer::new(&there), InLight::new(&self.at_plane));
        let places: Vec<(usize, usize)> = (0..GRID).flat_map(|j| (0..GRID).map(move |i| (i, j))).collect();
        let (left, depth) = (&self.pair.cameras()[0], depth_mm - self.centres_ahead_mm());
        let seen: Vec<SeenPoint> = places
            .into_par_iter()
            .filter_map(|(i, j)| {
                let image_px = self.frames[0].size_px * DVec2::new(i as f64, j as f64) / (GRID - 1) as f64;
                let point_mm = left.camera_from_world.inverse().point(left.at_depth(image_px, depth));
                let board_mm = there.board().local(point_mm).truncate();
                let [left, right] =
                    [0, 1].map(|k| self.shown_px(k, seen_px(&self.frames[k], &aimer, board_mm)?, &light));
                Some(SeenPoint { image_px: [left?, right?], point_mm })
            })
            .collect();
        PairResidual::of(&self.pair, &seen)
    }

    /// Where the rectified image `k` shows what the whole picture shows at `full_px`; `light` is that before the plane of the maps.
    pub fn shown_px(&self, k: usize, full_px: DVec2, light: &InLight<'_>) -> Option<DVec2> {
        let at_plane = light.trace(full_px).ok()?.board_mm;
        self.pair.cameras()[k].project(self.at_plane.board().world(at_plane))
    }

    /// The instrument before the plane at which the maps are right.
    pub fn at_plane(&self) -> &System {
        &self.at_plane
    }
}

/// Where in the whole picture the half of `frame` sees the place `board_mm` of the board that `aimer` aims at; `None` where it does
/// not.
pub(in crate::analysis) fn seen_px(frame: &HalfFrame, aimer: &Aimer<'_>, board_mm: DVec2) -> Option<DVec2> {
    let full_px = aimer.aim(board_mm, frame.side()).ok()?;
    (frame.contains(frame.own(full_px)) && aimer.sees(full_px, frame.side())).then_some(full_px)
}
