//! The two cameras that a pair is used as: pinholes fitted to the corners of all depths.

use super::pinhole::{CENTRE_ONLY, designed_pinhole, observations_of_all};
use crate::analysis::view::BoardView;
use crate::metrics::MeasuredAndTrue;
use crate::metrics::pair_geometry::PairGeometry;
use crate::metrics::reprojection::{self, ALL, Parameter, PinholeFit};

/// The cameras of the left and the right half, in the half's own px.
#[derive(Debug, Clone)]
pub struct CameraFigures {
    /// What was fitted of each; everything else is as designed.
    pub free: &'static [Parameter],
    /// The cameras, with what the fit leaves.
    pub fits: [MeasuredAndTrue<PinholeFit>; 2],
    /// What they are to each other, and the count of corners behind it; the resolution in depth is that at the middle of the
    /// scene's own board.
    pub geometry: MeasuredAndTrue<(PairGeometry, usize)>,
}

/// The cameras by the boards at all depths (`asked`): pose, both focal lengths and the principal point, or, where there is one
/// depth, which does not tell these apart, the centre alone.
pub(super) fn camera_figures(own: &BoardView, asked: &[&BoardView]) -> CameraFigures {
    let free: &'static [Parameter] = if asked.len() > 1 { &ALL } else { &CENTRE_ONLY };
    let fits = [0, 1].map(|k| match designed_pinhole(own, k) {
        Ok(camera) => {
            MeasuredAndTrue::of_sides(observations_of_all(asked, k), |seen| reprojection::fit(&camera, free, &seen))
        }
        Err(reason) => MeasuredAndTrue::neither(reason),
    });
    let point_mm = own.board.pattern.world_from_board.translation_mm;
    let size_px = own.halves[0].frame.size_px;
    let pair = |left: &PinholeFit, right: &PinholeFit| {
        let geometry = PairGeometry::of([&left.pinhole, &right.pinhole], size_px, point_mm)?;
        Ok((geometry, left.deviation.n + right.deviation.n))
    };
    CameraFigures { free, geometry: fits[0].with(&fits[1], pair), fits }
}
