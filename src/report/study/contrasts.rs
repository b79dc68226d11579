//! The contrast (MTF) as sheets and figures.

use super::document::StudyFigure;
use crate::analysis::relay::mtf::Contrast;
use crate::analysis::relay::study::MtfStudy;
use crate::plot::axis::{Scale, significant};
use crate::plot::chart::{self, AxisInput, ChartInput, ChartSeries, Front, Look, Point};
use crate::plot::drawing::Drawing;
use crate::report::sheet::{Cell, StudySheet};

/// The contrast of one half of one prism.
#[derive(Debug, Clone)]
pub struct NamedContrasts {
    /// The prism's name.
    pub prism: String,
    /// Its half: `left` or `right`.
    pub half: &'static str,
    /// What was found.
    pub study: MtfStudy,
}

/// Columns of a contrast.
const CONTRAST: [(&str, &str); 6] = [
    ("frequency_per_mm", "in the image, cycles/mm"),
    ("perfect", "contrast of a perfect lens"),
    ("x", "contrast by diffraction of a pattern that varies along x"),
    ("y", "the same along y"),
    ("rays_x", "contrast by rays alone, along x"),
    ("rays_y", "the same along y"),
];

/// The sheets.
pub fn sheets(all: &[NamedContrasts]) -> Vec<StudySheet> {
    let lead = [("prism", "the prism's name"), ("half", "the half of the prism")];
    let of = |name, heading: &str, more: &[(&'static str, &'static str)]| {
        StudySheet::new(name, heading, &[&lead[..], more, &CONTRAST[..]].concat())
    };
    let mut curves = of(
        "mtf",
        "Contrast over frequency",
        &[("lens_is", "focused: on the plane in focus; best: where the spot is smallest about its centroid")],
    );
    let mut through = of("mtf_through_focus", "Contrast through focus", &[("focus_mm", "z of the plane in focus, mm")]);
    let mut field = of(
        "mtf_field",
        "Contrast over the field",
        &[("beside_x_mm", "where the object is, along x, mm"), ("beside_y_mm", "the same along y, mm")],
    );
    let mut waves = StudySheet::new(
        "wave_error",
        "Wave error over the pupil",
        &[
            lead[0],
            lead[1],
            (
                "rms_waves",
                "root mean square of the wave error from its mean and its tilt, which but moves the image, lens focused as asked, waves",
            ),
            ("left_waves", "what the series of the wave error leaves at other rays, waves"),
        ],
    );
    for one in all {
        let name = || [Cell::from(one.prism.as_str()), one.half.into()].into_iter();
        for (lens_is, curve) in [("focused", &one.study.focused), ("best", &one.study.best)] {
            curve.iter().for_each(|c| curves.push(name().chain([lens_is.into()]).chain(cells(c)).collect()));
        }
        for (focus_mm, c) in &one.study.through_focus {
            through.push(name().chain([(*focus_mm).into()]).chain(cells(c)).collect());
        }
        for (beside, c) in &one.study.field {
            field.push(name().chain([beside.x.into(), beside.y.into()]).chain(cells(c)).collect());
        }
        waves.push(name().chain([one.study.rms_waves.into(), one.study.left_waves.into()]).collect());
    }
    vec![waves, field, curves.detailed(), through.detailed()]
}

fn cells(contrast: &Contrast) -> impl Iterator<Item = Cell> {
    let Contrast { frequency_per_mm, perfect, diffraction: [x, y], geometric: [rays_x, rays_y] } = *contrast;
    [frequency_per_mm, perfect, x, y, rays_x, rays_y].map(Cell::from).into_iter()
}

/// The contrast over frequency and through focus.
pub fn figures(all: &[NamedContrasts]) -> Vec<StudyFigure> {
    let Some(first) = all.first() else { return Vec::new() };
    let mut curves = vec![ChartSeries {
        name: "a perfect lens".to_owned(),
        look: Look::DashedLine,
        points: first.study.focused.iter().map(|c| Point::new(c.frequency_per_mm, c.perfect)).collect(),
        labels: Vec::new(),
    }];
    let mut through = Vec::new();
    for one in all {
        for (k, axis) in ["x", "y"].into_iter().enumerate() {
            let named = |points: Vec<Point>| ChartSeries {
                name: format!("{}, {}, along {axis}", one.prism, one.half),
                look: Look::Line,
                points,
                labels: Vec::new(),
            };
            let over = |c: &Contrast| Point::new(c.frequency_per_mm, c.diffraction[k]);
            curves.push(named(one.study.focused.iter().map(over).collect()));
            let plane = |(z, c): &(f64, Contrast)| Point::new(*z, c.diffraction[k]);
            through.push(named(one.study.through_focus.iter().map(plane).collect()));
        }
    }
    let probe = significant(first.study.probe_per_mm, 3);
    vec![
        figure("mtf", "Contrast (MTF) by diffraction".to_owned(), "frequency in the image, cycles/mm", curves),
        figure(
            "mtf_through_focus",
            format!("Contrast through focus at {probe} cycles/mm"),
            "plane in focus: z, mm",
            through,
        ),
    ]
}

fn figure(name: &str, title: String, x: &str, series: Vec<ChartSeries>) -> StudyFigure {
    let drawing: Drawing = chart::draw(&ChartInput {
        title: title.clone(),
        note: String::new(),
        x: AxisInput { name: x.to_owned(), scale: Scale::Linear, range: None },
        y: AxisInput { name: "contrast".to_owned(), scale: Scale::Linear, range: Some([0.0, 1.0]) },
        series,
        front: Front::None,
        size_px: [1400, 800],
    });
    StudyFigure { name: name.to_owned(), title, drawing }
}
