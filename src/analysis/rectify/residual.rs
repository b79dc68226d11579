//! What the maps leave of a point that lies at another depth than theirs.

use super::rectifier::{GRID, Rectifier};
use crate::geom::Ray;
use crate::metrics::{Deviation, Unmeasurable};
use crate::num::stats::{max_abs, rms};
use crate::system::aim::Aimer;
use crate::system::{InLight, System};
use glam::{DVec2, DVec3};
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

/// What is left of points that both halves see, in the rectified images.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairResidual {
    /// N, the count of points.
    pub n: usize,
    /// sqrt(sum (y_L - y_R)^2 / N), in px.
    pub vertical_rms_px: f64,
    /// Largest |y_L - y_R|, in px.
    pub vertical_max_px: f64,
    /// Largest error of x_L - x_R against f b/Z and its constant, in px.
    pub disparity_max_px: f64,
    /// Root mean square of the depth that the disparity says less the true one, in mm.
    pub depth_error_rms_mm: f64,
    /// The largest of these, in mm.
    pub depth_error_max_mm: f64,
    /// The same of the depth from the pair's centres, in %.
    pub depth_error_max_percent: f64,
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
        let seen: Vec<[DVec2; 2]> = places
            .into_par_iter()
            .filter_map(|(i, j)| {
                let image_px = self.frames[0].size_px * DVec2::new(i as f64, j as f64) / (GRID - 1) as f64;
                let world_mm = left.camera_from_world.inverse().point(left.at_depth(image_px, depth));
                let [left, right] = [0, 1].map(|k| self.shown_px(k, world_mm, (&aimer, &there), &light));
                Some([left?, right?])
            })
            .collect();
        (!seen.is_empty()).then(|| self.figures(&seen, depth))
    }

    /// Where the rectified image `k` shows a point of the plane in which the board of `there` is; `None` where the half does not see
    /// it.
    fn shown_px(
        &self,
        k: usize,
        world_mm: DVec3,
        (aimer, there): (&Aimer<'_>, &System),
        light: &InLight<'_>,
    ) -> Option<DVec2> {
        let frame = &self.frames[k];
        let full_px = aimer.aim(there.board().local(world_mm).truncate(), frame.side()).ok()?;
        if !(frame.contains(frame.own(full_px)) && aimer.sees(full_px, frame.side())) {
            return None;
        }
        let at_plane = light.trace(full_px).ok()?.board_mm;
        self.pair.cameras()[k].project(self.at_plane.board().world(at_plane))
    }

    /// The figures of points at `depth_mm` from the pair's centres.
    fn figures(&self, seen: &[[DVec2; 2]], depth_mm: f64) -> PairResidual {
        let vertical: Vec<f64> = seen.iter().map(|[left, right]| left.y - right.y).collect();
        let ideal = self.pair.focal_px().x * self.pair.baseline_mm() / depth_mm + self.pair.offset_px();
        let disparity = |[left, right]: &[DVec2; 2]| left.x - right.x;
        let errors_mm: Vec<f64> = seen.iter().map(|seen| self.pair.depth_mm(disparity(seen)) - depth_mm).collect();
        let largest_mm = max_abs(&errors_mm);
        PairResidual {
            n: seen.len(),
            vertical_rms_px: rms(&vertical),
            vertical_max_px: max_abs(&vertical),
            disparity_max_px: seen.iter().fold(0.0, |most: f64, seen| most.max((disparity(seen) - ideal).abs())),
            depth_error_rms_mm: rms(&errors_mm),
            depth_error_max_mm: largest_mm,
            depth_error_max_percent: 100.0 * largest_mm / depth_mm,
        }
    }
}
