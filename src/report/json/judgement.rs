//! From results of `metrics` to the figures of a report: the one place that says which definition belongs to which key.

use super::cameras::Geometry;
use super::document::{Centre, Designed, Fitted, RowLaw, Stereo};
use super::figure::{Definition, Figure, Frame, Normaliser, Unit};
use crate::metrics::depth_error::DepthError;
use crate::metrics::epipolar::Summary;
use crate::metrics::pair_geometry::PairGeometry;
use crate::metrics::ray_bundle::{CommonPoint, PlaneDeviation, RayMisses};
use crate::metrics::reprojection::Parameter;
use crate::metrics::row_law::RowDeviation;
use crate::metrics::stereo::{DepthLaw, Disparity};
use crate::metrics::straightness::RowsAndColumns;
use crate::metrics::{Deviation, MeasuredAndTrue, homography};
use glam::DVec3;

/// Nearest and farthest depth of the board, in mm; `None` where it is unknown (a photograph).
pub type Depths = Option<[f64; 2]>;

/// Left against right: the disparities of corners at `board_mm`, the epipolar curves over `epipolar_mm`, and the law of
/// disparities over the same range.
pub fn stereo(
    disparity: &MeasuredAndTrue<Disparity>,
    board_mm: Depths,
    epipolar: &MeasuredAndTrue<Summary>,
    law: &MeasuredAndTrue<DepthLaw>,
    epipolar_mm: Depths,
) -> Stereo {
    let at_board = |normaliser| Definition { depths_mm: board_mm, ..Definition::px(normaliser) };
    let px = |normaliser| Definition { depths_mm: epipolar_mm, ..Definition::px(normaliser) };
    let rad = |normaliser| Definition { unit: Unit::Rad, ..px(normaliser) };
    Stereo {
        vertical_disparity_rms_px: at_board(Normaliser::Rms).figure(disparity, |d| (d.vertical_rms_px, d.n)),
        vertical_disparity_max_px: at_board(Normaliser::Max).figure(disparity, |d| (d.vertical_max_px, d.n)),
        vertical_disparity_mean_px: at_board(Normaliser::Mean).figure(disparity, |d| (d.vertical_mean_px, d.n)),
        opencv_average_epipolar_px: at_board(Normaliser::TwiceMeanAbs)
            .figure(disparity, |d| (d.opencv_average_px, d.n)),
        epipolar_slope_max_rad: rad(Normaliser::Max).figure(epipolar, |e| (e.slope_max_rad, e.curves)),
        epipolar_slope_mean_rad: rad(Normaliser::MeanAbs).figure(epipolar, |e| (e.slope_mean_abs_rad, e.curves)),
        epipolar_rise_max_px: px(Normaliser::Max).figure(epipolar, |e| (e.rise_max_px, e.curves)),
        epipolar_departure_rms_px: px(Normaliser::Rms).figure(epipolar, |e| (e.departure_rms_px, e.samples)),
        epipolar_departure_max_px: px(Normaliser::Max).figure(epipolar, |e| (e.departure_max_px, e.samples)),
        rectified_vertical_disparity_rms_px: None,
        rectified_vertical_disparity_max_px: None,
        depth_law_rms_px: px(Normaliser::Rms).figure(law, |l| (l.rms_px, l.n)),
        depth_error_rms_mm: None,
        depth_error_max_mm: None,
        depth_error_rms_percent: None,
        depth_error_max_percent: None,
    }
}

/// Against the designed virtual camera on its virtual image plane, by rays beyond the glass: Table 1 of the design
/// paper. Measured rays come from corners at several depths
/// ([`rays_from_depths`](crate::metrics::ray_bundle::rays_from_depths)).
pub(crate) fn designed_by_rays(found: &MeasuredAndTrue<PlaneDeviation>) -> Designed {
    designed(Frame::VirtualImagePlane, None, &found.then(|d| Ok(d.mm)), &found.then(|d| Ok(d.px)))
}

/// Against the designed virtual camera at the depth of a board: corners minus projected corners, in px and, by the
/// pixel pitch, in mm on the sensor. A ray that misses the centre but meets the board where it should is no error here.
pub(crate) fn designed_by_corners(found_px: &MeasuredAndTrue<Deviation>, pitch_mm: f64, board_mm: Depths) -> Designed {
    designed(Frame::RawHalf, board_mm, &found_px.then(|d| Ok(d.scaled(pitch_mm))), found_px)
}

fn designed(
    frame: Frame,
    depths_mm: Depths,
    mm: &MeasuredAndTrue<Deviation>,
    px: &MeasuredAndTrue<Deviation>,
) -> Designed {
    let in_mm = Definition { depths_mm, ..Definition::mm(Normaliser::MeanAbs, frame) };
    let in_px = |normaliser| Definition { frame, depths_mm, ..Definition::px(normaliser) };
    Designed {
        mean_abs_h_mm: in_mm.figure(mm, |d| (d.mean_abs.x, d.n)),
        mean_abs_v_mm: in_mm.figure(mm, |d| (d.mean_abs.y, d.n)),
        mean_abs_h_px: in_px(Normaliser::MeanAbs).figure(px, |d| (d.mean_abs.x, d.n)),
        mean_abs_v_px: in_px(Normaliser::MeanAbs).figure(px, |d| (d.mean_abs.y, d.n)),
        rms_px: in_px(Normaliser::Rms).figure(px, |d| (d.rms, d.n)),
        max_px: in_px(Normaliser::Max).figure(px, |d| (d.max, d.n)),
    }
}

/// Against a fitted pinhole, of which `free` was fitted. Both halves pooled: give the deviation of their joined
/// residuals.
pub fn fitted(free: &[Parameter], deviation: &MeasuredAndTrue<Deviation>, depths_mm: Depths) -> Fitted {
    let px = |normaliser| Definition { depths_mm, ..Definition::px(normaliser) };
    Fitted {
        free: free.iter().map(|p| p.name().to_owned()).collect(),
        rms_px: px(Normaliser::Rms).figure(deviation, |d| (d.rms, d.n)),
        max_px: px(Normaliser::Max).figure(deviation, |d| (d.max, d.n)),
    }
}

/// Against the designed camera after one homography of the half.
pub fn homography(deviation: &MeasuredAndTrue<Deviation>, depths_mm: Depths) -> Fitted {
    Fitted { free: homography::FREE.map(str::to_owned).to_vec(), ..fitted(&[], deviation, depths_mm) }
}

/// Against the row law, of which `free` was fitted: the rows as they are, and with their shift undone.
pub fn row_law(
    free: &[Parameter],
    raw: &MeasuredAndTrue<RowDeviation>,
    undone: &MeasuredAndTrue<RowDeviation>,
    depths_mm: Depths,
) -> RowLaw {
    let px = |normaliser| Definition { depths_mm, ..Definition::px(normaliser) };
    let rms = |found: &MeasuredAndTrue<RowDeviation>, axis: usize| {
        px(Normaliser::Rms).figure(found, |d| (d.rms_px[axis], d.n))
    };
    RowLaw {
        free: free.iter().map(|p| p.name().to_owned()).collect(),
        rms_u_px: rms(raw, 0),
        rms_v_px: rms(raw, 1),
        undone_rms_u_px: rms(undone, 0),
        undone_rms_v_px: rms(undone, 1),
        undone_max_px: px(Normaliser::Max).figure(undone, |d| (d.max_px, d.n)),
    }
}

/// The vertical disparity after one homography a half, RMS and largest, at the depth of the board.
pub fn rectified(found: &MeasuredAndTrue<Disparity>, depths_mm: Depths) -> [Figure; 2] {
    let px = |normaliser| Definition { depths_mm, ..Definition::px(normaliser) };
    [
        px(Normaliser::Rms).figure(found, |d| (d.vertical_rms_px, d.n)),
        px(Normaliser::Max).figure(found, |d| (d.vertical_max_px, d.n)),
    ]
}

/// `stereo` with the error of depth by the designed pair on the raw halves, at the depth of the board.
pub(crate) fn with_depth_error(stereo: Stereo, found: &MeasuredAndTrue<DepthError>, depths_mm: Depths) -> Stereo {
    let figure = |unit, normaliser, pick: fn(&DepthError) -> f64| {
        let definition = Definition { unit, depths_mm, ..Definition::px(normaliser) };
        Some(definition.figure(found, |error| (pick(error), error.n)))
    };
    Stereo {
        depth_error_rms_mm: figure(Unit::Mm, Normaliser::Rms, |error| error.rms_mm),
        depth_error_max_mm: figure(Unit::Mm, Normaliser::Max, |error| error.max_mm),
        depth_error_rms_percent: figure(Unit::Percent, Normaliser::Rms, |error| error.rms_percent),
        depth_error_max_percent: figure(Unit::Percent, Normaliser::Max, |error| error.max_percent),
        ..stereo
    }
}

/// RMS and largest distance from straight, of rows and columns together.
pub fn straightness(found: &MeasuredAndTrue<RowsAndColumns>) -> (Figure, Figure) {
    let rms = Definition::px(Normaliser::Rms).figure(found, |s| (s.both.rms_px, s.both.n));
    (rms, Definition::px(Normaliser::Max).figure(found, |s| (s.both.max_px, s.both.n)))
}

/// The rays against one centre: the best common point, and the designed one at `designed_mm`.
pub fn centre(
    designed_mm: DVec3,
    common: &MeasuredAndTrue<CommonPoint>,
    designed: &MeasuredAndTrue<RayMisses>,
) -> Centre {
    let mm = |normaliser| Definition::mm(normaliser, Frame::World);
    Centre {
        drift_mm: mm(Normaliser::Fit).figure(common, |c| ((c.point_mm - designed_mm).length(), c.misses.n)),
        miss_rms_mm: mm(Normaliser::Rms).figure(common, |c| (c.misses.rms_mm, c.misses.n)),
        designed_miss_rms_mm: mm(Normaliser::Rms).figure(designed, |m| (m.rms_mm, m.n)),
    }
}

/// What the cameras of the halves are to each other, by boards at these depths.
pub fn geometry(found: &MeasuredAndTrue<(PairGeometry, usize)>, depths_mm: Depths) -> Geometry {
    let fit = |unit| Definition { unit, depths_mm, ..Definition::mm(Normaliser::Fit, Frame::World) };
    Geometry {
        baseline_mm: fit(Unit::Mm).figure(found, |(g, n)| (g.baseline_mm, *n)),
        vergence_deg: fit(Unit::Deg).figure(found, |(g, n)| (g.vergence_deg, *n)),
        field_h_deg: fit(Unit::Deg).figure(found, |(g, n)| (g.field_deg.x, *n)),
        field_v_deg: fit(Unit::Deg).figure(found, |(g, n)| (g.field_deg.y, *n)),
        depth_per_px_mm: fit(Unit::Mm).figure(found, |(g, n)| (g.depth_per_px_mm, *n)),
    }
}
