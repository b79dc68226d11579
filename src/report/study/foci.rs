//! Field curvature as a sheet and figures.

use super::document::StudyFigure;
use crate::analysis::relay::field_curvature::Foci;
use crate::plot::axis::Scale;
use crate::plot::chart::{self, AxisInput, ChartInput, ChartSeries, Front, Look, Point};
use crate::report::sheet::{Cell, StudySheet};
use glam::DVec2;

/// The foci of one half of one prism.
#[derive(Debug, Clone)]
pub struct NamedFoci {
    /// The prism's name.
    pub prism: String,
    /// Its half: `left` or `right`.
    pub half: &'static str,
    /// z of the plane of O', or of that in focus, in mm.
    pub focus_mm: f64,
    /// Along the middle row and along the middle column.
    pub lines: [Vec<Foci>; 2],
}

/// The sheet.
pub fn sheet(all: &[NamedFoci]) -> StudySheet {
    let mut sheet = StudySheet::new(
        "field_curvature",
        "Foci over the field, from the plane in focus",
        &[
            ("prism", "the prism's name"),
            ("half", "the half of the prism"),
            ("u_px", "the pixel's place from the half image's middle along x, px"),
            ("v_px", "the same along y, px"),
            ("angle_deg", "angle of its ray to +z behind the prism, deg"),
            ("fan_u_mm", "where neighbours along u meet the ray: z from the plane in focus, mm"),
            ("fan_v_mm", "the same for neighbours along v, mm"),
            ("principal_1_mm", "the focal line nearer to the prism, by the wave front's curvature, mm"),
            ("principal_2_mm", "the other one, mm"),
            ("distortion_u_px", "where a pinhole sees the ray at infinity, less the pixel's place, along x, px"),
            ("distortion_v_px", "the same along y, px"),
        ],
    );
    for one in all {
        for at in one.lines.iter().flatten() {
            let from = |z: f64| z - one.focus_mm;
            let numbers = [at.from_middle_px.x, at.from_middle_px.y, at.angle_deg]
                .into_iter()
                .chain(at.fans_mm.map(from))
                .chain(at.principal_mm.map(from))
                .chain([at.distortion_px.x, at.distortion_px.y]);
            let lead = [Cell::from(one.prism.as_str()), one.half.into()];
            sheet.push(lead.into_iter().chain(numbers.map(Cell::from)).collect());
        }
    }
    sheet
}

/// A figure a half: the foci of both fans over both lines of the field.
pub fn figures(all: &[NamedFoci]) -> Vec<StudyFigure> {
    all.iter().map(figure).collect()
}

fn figure(one: &NamedFoci) -> StudyFigure {
    let along = |of: fn(DVec2) -> f64, line: usize, fan: usize| -> Vec<Point> {
        let point = |at: &Foci| Point::new(at.fans_mm[fan] - one.focus_mm, of(at.from_middle_px));
        one.lines[line].iter().map(point).collect()
    };
    let series = |name: &str, line: usize, fan: usize| ChartSeries {
        name: name.to_owned(),
        look: if fan == line { Look::Line } else { Look::DashedLine },
        points: along(if line == 0 { |px| px.x } else { |px| px.y }, line, fan),
        labels: Vec::new(),
    };
    let title = format!("Field curvature: {} prism, {} half", one.prism, one.half);
    let drawing = chart::draw(&ChartInput {
        title: title.clone(),
        note: "where close neighbours of a pixel's ray meet it; a pinhole has 0 everywhere".to_owned(),
        x: AxisInput { name: "focus from the plane of O′, mm".to_owned(), scale: Scale::Linear, range: None },
        y: AxisInput {
            name: "place in the half image, from its middle, px".to_owned(),
            scale: Scale::Linear,
            range: None,
        },
        series: vec![
            series("row, tangential", 0, 0),
            series("row, sagittal", 0, 1),
            series("column, sagittal", 1, 0),
            series("column, tangential", 1, 1),
        ],
        front: Front::None,
        size_px: [1400, 900],
    });
    StudyFigure { name: format!("field_curvature_{}_{}", one.prism, one.half), title, drawing }
}
