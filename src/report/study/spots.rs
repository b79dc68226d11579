//! The spot study as sheets and figures.

use super::document::StudyFigure;
use crate::analysis::relay::lens::RelayLens;
use crate::analysis::relay::spot::PencilSpot;
use crate::analysis::relay::study::SpotStudy;
use crate::geom::Rect;
use crate::plot::axis::{Scale, significant};
use crate::plot::chart::{self, AxisInput, ChartInput, ChartSeries, Front, Look, Point};
use crate::plot::colour::{ACCENT, GREY, INK, SERIES};
use crate::plot::drawing::{Drawing, Item, Stroke};
use crate::plot::text::{self, Align, Font};
use crate::report::sheet::{Cell, StudySheet};
use glam::DVec2;
use std::f64::consts::TAU;

/// The spots of one half of one prism.
#[derive(Debug, Clone)]
pub struct NamedSpots {
    /// The prism's name.
    pub prism: String,
    /// Its half: `left` or `right`.
    pub half: &'static str,
    /// What was found.
    pub study: SpotStudy,
}

/// The sheets.
pub fn sheets(lens: &RelayLens, all: &[NamedSpots]) -> Vec<StudySheet> {
    let um = 1e3 * lens.magnification;
    let name = |one: &NamedSpots| -> [Cell; 2] { [one.prism.as_str().into(), one.half.into()] };
    let mut spots = StudySheet::new(
        "spot",
        "Spot in the image of the relay lens",
        &[
            ("prism", "the prism's name"),
            ("half", "the half of the prism that the pencil goes through"),
            (
                "lens_is",
                "focused: on the plane in focus; best: where the spot is smallest about its centroid; half image: focused, and \
                 takes in the rays of the half image alone",
            ),
            ("focus_mm", "z of that plane in the world, mm"),
            ("rms_um", "root mean square distance from the centroid, times the magnification, um"),
            ("rms_about_chief_um", "the same from the chief ray, um"),
            ("radius_um", "largest distance from the chief ray, times the magnification, um"),
            (
                "beyond",
                "share of the pupil's rays that meet a surface beyond where it was given, where its formula goes on",
            ),
            ("airy_um", "radius of a perfect lens' first dark ring in the image: 0.61 lambda M / NA, um"),
        ],
    );
    let mut through = StudySheet::new(
        "spot_through_focus",
        "Through focus",
        &[
            ("prism", "the prism's name"),
            ("half", "the half of the prism"),
            ("focus_mm", "z of the plane in focus, mm"),
            ("rms_um", "root mean square distance from the centroid, um"),
        ],
    );
    let mut field = StudySheet::new(
        "spot_field",
        "Over the field",
        &[
            ("prism", "the prism's name"),
            ("half", "the half of the prism"),
            ("beside_x_mm", "where the object is, from the middle of the field along x, mm"),
            ("beside_y_mm", "the same along y, mm"),
            ("rms_um", "root mean square distance from the centroid, lens focused as asked, um"),
            ("best_focus_mm", "z of the plane in which that is smallest, mm"),
            ("best_rms_um", "the root mean square there, um"),
        ],
    );
    for one in all {
        let row = |lens_is: &str, spot: &PencilSpot, beyond: Cell| -> Vec<Cell> {
            let sizes = [spot.rms_mm, spot.rms_about_chief_mm, spot.radius_mm].map(|mm| Cell::from(um * mm));
            let lead = name(one).into_iter().chain([lens_is.into(), spot.focus_mm.into()]);
            lead.chain(sizes).chain([beyond, lens.airy_radius_um().into()]).collect()
        };
        spots.push(row("focused", &one.study.focused, one.study.beyond.into()));
        spots.push(row("best", &one.study.best, one.study.beyond.into()));
        if let Some(spot) = &one.study.half_image {
            spots.push(row("half image", spot, Cell::Nothing));
        }
        for [focus_mm, rms_mm] in &one.study.through_focus {
            through.push(name(one).into_iter().chain([(*focus_mm).into(), (um * rms_mm).into()]).collect());
        }
        for at in &one.study.field {
            let values = [at.beside_mm.x, at.beside_mm.y, um * at.rms_mm, at.best_focus_mm, um * at.best_rms_mm];
            field.push(name(one).into_iter().chain(values.map(Cell::from)).collect());
        }
    }
    vec![spots, field, through.detailed()]
}

/// The spot diagrams, and the spot through focus.
pub fn figures(lens: &RelayLens, all: &[NamedSpots]) -> Vec<StudyFigure> {
    let um = 1e3 * lens.magnification;
    let series = |one: &NamedSpots| ChartSeries {
        name: format!("{}, {}", one.prism, one.half),
        look: Look::Line,
        points: one.study.through_focus.iter().map(|[z, rms]| Point::new(*z, um * rms)).collect(),
        labels: Vec::new(),
    };
    let title = "The spot through focus".to_owned();
    let drawing = chart::draw(&ChartInput {
        title: title.clone(),
        note: String::new(),
        x: AxisInput { name: "plane in focus: z, mm".to_owned(), scale: Scale::Linear, range: None },
        y: AxisInput { name: "RMS radius of the spot, µm".to_owned(), scale: Scale::Log, range: None },
        series: all.iter().map(series).collect(),
        front: Front::None,
        size_px: [1400, 800],
    });
    let diagram = "Spot diagrams, with the first dark ring of a perfect lens".to_owned();
    vec![
        StudyFigure { name: "spot".to_owned(), title: diagram.clone(), drawing: diagrams(&diagram, lens, all) },
        StudyFigure { name: "spot_through_focus".to_owned(), title, drawing },
    ]
}

/// A row a half: the spot as focused, and the smallest, each to its own scale.
fn diagrams(title: &str, lens: &RelayLens, all: &[NamedSpots]) -> Drawing {
    const EM: f64 = 15.0;
    const SIDE: f64 = 420.0;
    let (bold, plain) = (Font::bold(EM), Font::regular(EM));
    let width = 2.0 * SIDE + 5.0 * EM;
    let mut drawing = Drawing::new(width as u32, 1);
    drawing.text(title, Font::bold(1.2 * EM), INK, DVec2::new(EM, 2.0 * EM), Align::Start);
    let mut y = 3.0 * EM;
    for (k, one) in all.iter().enumerate() {
        y += 2.0 * EM;
        let name = format!("{}, {} half", one.prism, one.half);
        drawing.text(text::shortened(&name, bold, width - 2.0 * EM), bold, INK, DVec2::new(EM, y), Align::Start);
        y += EM;
        for (column, (words, spot)) in
            [("focused", &one.study.focused), ("smallest", &one.study.best)].into_iter().enumerate()
        {
            let min = DVec2::new(EM + column as f64 * (SIDE + 3.0 * EM), y).round();
            let area = Rect { min, max: min + SIDE };
            draw_spot(&mut drawing, &area, spot, lens, SERIES[k % SERIES.len()]);
            let um = 1e3 * lens.magnification;
            let size = format!(
                "{words}: z = {} mm, RMS {} µm, radius {} µm",
                significant(spot.focus_mm, 3),
                significant(um * spot.rms_mm, 3),
                significant(um * spot.radius_mm, 3)
            );
            let below = DVec2::new(min.x, area.max.y + 1.4 * EM);
            drawing.text(text::shortened(&size, plain, SIDE + 2.0 * EM), plain, INK, below, Align::Start);
        }
        y += SIDE + 2.5 * EM;
    }
    drawing.with_height(libm::ceil(y) as u32)
}

fn draw_spot(
    drawing: &mut Drawing,
    area: &Rect,
    spot: &PencilSpot,
    lens: &RelayLens,
    colour: crate::plot::colour::Rgb,
) {
    let um = 1e3 * lens.magnification;
    let middle = 0.5 * (area.min + area.max);
    let reach = 1.15 * (um * spot.radius_mm).max(lens.airy_radius_um());
    let scale = 0.5 * area.size().x / reach;
    drawing.frame(area, Stroke::solid(GREY, 1.0));
    for point in &spot.points_mm {
        drawing.push(Item::Disc(middle + *point * (um * scale), 1.6, colour));
    }
    let ring: Vec<DVec2> = (0..=96)
        .map(|k| TAU * f64::from(k) / 96.0)
        .map(|t| middle + lens.airy_radius_um() * scale * DVec2::new(libm::cos(t), libm::sin(t)))
        .collect();
    drawing.line_within(area, &ring, Stroke::solid(ACCENT, 1.5));

    // A bar of a round length tells the scale.
    let length = crate::plot::axis::round_below(0.5 * reach);
    let at = area.min + DVec2::new(10.0, area.size().y - 12.0);
    drawing.line(at, at + DVec2::new(length * scale, 0.0), Stroke::solid(INK, 2.0));
    let words = format!("{} µm", significant(length, 1));
    drawing.text(words, Font::regular(13.0), INK, at - DVec2::new(0.0, 6.0), Align::Start);
}
