//! Stereo without rectification, as a sheet and a figure.

use super::document::StudyFigure;
use crate::analysis::stereo_study::{StereoStudy, TreatedPlace};
use crate::metrics::pair_residual::PairResidual;
use crate::plot::axis::Scale;
use crate::plot::chart::{self, AxisInput, ChartInput, ChartSeries, Front, Look, Point};
use crate::report::sheet::{Cell, StudySheet};

/// Smaller errors of depth are drawn here, in %.
const LEAST_DRAWN_PERCENT: f64 = 1e-6;

/// What is left of one prism.
#[derive(Debug, Clone)]
pub struct NamedStereoStudy {
    /// The prism's name.
    pub prism: String,
    /// The study of it.
    pub study: StereoStudy,
}

/// What is left, and the pairs that depths are taken by.
pub fn sheets(all: &[NamedStereoStudy]) -> Vec<StudySheet> {
    vec![residuals(all), pairs(all)]
}

fn pairs(all: &[NamedStereoStudy]) -> StudySheet {
    let mut sheet = StudySheet::new(
        "stereo_pairs",
        "The pairs of pinholes that depths are taken by",
        &[
            ("prism", "the prism's name"),
            (
                "pair",
                "designed: the virtual cameras that the halves are designed to be; map: the pair of biprism rectify",
            ),
            ("focal_px", "focal length along x, px"),
            ("baseline_mm", "distance of the centres, mm"),
            ("offset_px", "x_L - x_R of a point at infinity, each from its half's own first column, px"),
            ("centres_ahead_mm", "how far the centres lie before the camera, along the axis of the pair, mm"),
        ],
    );
    for one in all {
        for (name, pair) in [("designed", &one.study.designed), ("map", &one.study.mapped)] {
            let numbers =
                [pair.focal_px().x, pair.baseline_mm(), pair.offset_px(), pair.ahead_of_mm(one.study.camera_mm)];
            let lead = [Cell::from(one.prism.as_str()), name.into()];
            sheet.push(lead.into_iter().chain(numbers.map(Cell::from)).collect());
        }
    }
    sheet
}

fn residuals(all: &[NamedStereoStudy]) -> StudySheet {
    let mut sheet = StudySheet::new(
        "stereo",
        "What each treatment leaves of points that both halves see",
        &[
            ("prism", "the prism's name"),
            (
                "treatment",
                "raw: the halves as they are; row shift: that of the prism's law undone; warp: a polynomial a half; map: of biprism rectify",
            ),
            ("depth_mm", "where the axis meets the plane, from the camera, mm"),
            ("tilt_deg", "turn of the plane about the vertical, deg"),
            ("points", "points that both halves see"),
            ("x_rms_px", "both halves from their pinholes along x, root mean square, px"),
            ("y_rms_px", "the same along y, px"),
            ("largest_px", "largest of these vectors, px"),
            ("vertical_rms_px", "vertical disparity, root mean square, px"),
            ("vertical_max_px", "vertical disparity, largest, px"),
            ("disparity_max_px", "disparity from f b/Z, largest, px"),
            ("depth_rms_mm", "depth of a perfect matcher less the true one, root mean square, mm"),
            ("depth_p50_percent", "half of these errors are at most this, % of the depth"),
            ("depth_p95_percent", "95 % of them are, % of the depth"),
            ("depth_max_percent", "the largest, % of the depth"),
        ],
    );
    for one in all {
        for TreatedPlace { treatment, place, residual } in &one.study.places {
            let of = |figure: fn(&PairResidual) -> f64| Cell::from(residual.as_ref().map(figure));
            sheet.push(vec![
                one.prism.as_str().into(),
                treatment.name().into(),
                place.depth_mm.into(),
                place.tilt_rad.to_degrees().into(),
                residual.map_or(0, |r| r.n).into(),
                of(|r| r.pinhole_rms_px.x),
                of(|r| r.pinhole_rms_px.y),
                of(|r| r.pinhole_max_px),
                of(|r| r.vertical_rms_px),
                of(|r| r.vertical_max_px),
                of(|r| r.disparity_max_px),
                of(|r| r.depth_error.rms_mm),
                of(|r| r.depth_error.quantiles_percent[0]),
                of(|r| r.depth_error.quantiles_percent[1]),
                of(|r| r.depth_error.max_percent),
            ]);
        }
    }
    sheet
}

/// The error of depth over depth, a line a prism and treatment.
pub fn figure(all: &[NamedStereoStudy]) -> StudyFigure {
    let mut series: Vec<ChartSeries> = Vec::new();
    for one in all {
        for TreatedPlace { treatment, place, residual } in one.study.places.iter().filter(|p| p.place.tilt_rad == 0.0) {
            let Some(residual) = residual else { continue };
            let percent = residual.depth_error.quantiles_percent[1].max(LEAST_DRAWN_PERCENT);
            let name = format!("{}, {}", one.prism, treatment.name());
            let point = Point::new(place.depth_mm, percent);
            match series.iter_mut().find(|s| s.name == name) {
                Some(found) => found.points.push(point),
                None => series.push(ChartSeries {
                    name,
                    look: Look::MarkersAndLine,
                    points: vec![point],
                    labels: Vec::new(),
                }),
            }
        }
    }
    series.iter_mut().for_each(|s| s.points.sort_by(|a, b| a.x.total_cmp(&b.x)));
    let depths = || all.iter().flat_map(|one| one.study.places.iter().map(|p| p.place.depth_mm));
    let range = [0.9 * depths().fold(f64::INFINITY, f64::min), 1.1 * depths().fold(0.0, f64::max)];
    let title = "Depth without rectification: the error of a perfect matcher".to_owned();
    let drawing = chart::draw(&ChartInput {
        title: title.clone(),
        note: format!("95 % of the points that both halves see; less than {LEAST_DRAWN_PERCENT:.0e} % is drawn there"),
        x: AxisInput { name: "depth from the camera, mm".to_owned(), scale: Scale::Log, range: Some(range) },
        y: AxisInput { name: "error of depth, %".to_owned(), scale: Scale::Log, range: None },
        series,
        front: Front::None,
        size_px: [1400, 900],
    });
    StudyFigure { name: "stereo".to_owned(), title, drawing }
}
