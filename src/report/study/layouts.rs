//! The layout of an instrument as a drawing to scale.

use super::document::StudyFigure;
use crate::analysis::layout::{InstrumentLayout, RayWay};
use crate::geom::Rect;
use crate::plot::colour::{GREY, INK, Rgb, SERIES};
use crate::plot::plan::{self, PlanLine, PlanPanel};
use crate::report::sheet::{Cell, StudySheet};
use crate::surface::face::Face;
use crate::system::Side;
use glam::{DVec2, DVec3};

/// The layout of one prism's instrument.
#[derive(Debug, Clone)]
pub struct NamedLayout {
    /// The prism's name.
    pub prism: String,
    /// What is drawn.
    pub layout: InstrumentLayout,
}

/// The points of all rays that are drawn.
pub fn sheet(all: &[NamedLayout]) -> StudySheet {
    let mut sheet = StudySheet::new(
        "layout",
        "Points of the rays that are drawn",
        &[
            ("prism", "the prism's name"),
            ("view", "above: rays of the middle row; side: rays of the halves' middle columns"),
            ("ray", "number of the ray in this view"),
            ("side", "the half of the prism that it passes"),
            ("x_mm", "in the world, mm"),
            ("y_mm", "in the world, mm"),
            ("z_mm", "in the world, mm"),
        ],
    );
    for one in all {
        for (view, ways) in ["above", "side"].into_iter().zip(&one.layout.ways) {
            for (ray, way) in ways.iter().enumerate() {
                let side = way.side.map_or(Cell::Nothing, |side| Cell::from(word(side)));
                for p in &way.points_mm {
                    let lead = [one.prism.as_str().into(), view.into(), ray.into(), side.clone()];
                    sheet.push(lead.into_iter().chain(p.to_array().map(Cell::from)).collect());
                }
            }
        }
    }
    sheet.detailed()
}

fn word(side: Side) -> &'static str {
    if side == Side::Left { "left" } else { "right" }
}

/// A figure a prism.
pub fn figures(all: &[NamedLayout]) -> Vec<StudyFigure> {
    all.iter().map(figure).collect()
}

fn figure(one: &NamedLayout) -> StudyFigure {
    let title = format!("Layout: {} prism", one.prism);
    let near = |plane: usize| {
        let surfaces = one.layout.surfaces[plane].iter().flat_map(|line| &line.points_mm);
        let rays = one.layout.ways[plane].iter().flat_map(|way| way.points_mm.iter().take(1));
        bounds(surfaces.chain(rays).map(|p| flat(*p, plane)), 0.12)
    };
    let whole = bounds(everything(&one.layout).map(|p| flat(p, 0)), 0.04);
    let panels = [
        PlanPanel { words: Vec::new(), ..panel(&one.layout, 0, "from above, to the board", whole) },
        panel(&one.layout, 0, "from above, near the prism", near(0)),
        panel(&one.layout, 1, "from the side, near the prism (middle columns)", near(1)),
    ];
    StudyFigure { name: format!("layout_{}", one.prism), drawing: plan::draw(&title, &panels, 1800), title }
}

fn everything(layout: &InstrumentLayout) -> impl Iterator<Item = DVec3> + '_ {
    let rays = layout.ways.iter().flatten().flat_map(|way| way.points_mm.iter().copied());
    rays.chain(layout.board_mm)
}

/// From above z runs right and x up; from the side y runs down, as in the picture.
fn flat(p: DVec3, plane: usize) -> DVec2 {
    if plane == 0 { DVec2::new(p.z, p.x) } else { DVec2::new(p.z, -p.y) }
}

fn bounds(points: impl Iterator<Item = DVec2>, spare: f64) -> Rect {
    let (mut min, mut max) = (DVec2::splat(f64::INFINITY), DVec2::splat(f64::NEG_INFINITY));
    points.for_each(|p| (min, max) = (min.min(p), max.max(p)));
    let room = spare * (max - min).max_element();
    Rect { min: min - room, max: max + room }
}

fn panel(layout: &InstrumentLayout, plane: usize, name: &str, area: Rect) -> PlanPanel {
    let colour = |way: &RayWay| -> Rgb {
        match way.side {
            Some(Side::Left) => SERIES[0],
            Some(Side::Right) => SERIES[1],
            None => GREY,
        }
    };
    let line = |points: Vec<DVec2>, colour: Rgb, weight: f64| PlanLine { points, colour, weight, dashed: false };
    let mut lines: Vec<PlanLine> = layout.ways[plane]
        .iter()
        .map(|way| line(way.points_mm.iter().map(|p| flat(*p, plane)).collect(), colour(way), 1.0))
        .collect();

    // Draw the rays back to where they seem to come from.
    for way in &layout.ways[plane] {
        if let [.., a, b] = way.points_mm[..]
            && way.points_mm.len() > 3
        {
            let t = (layout.camera_mm.z - a.z) / (b.z - a.z);
            let back = vec![flat(a, plane), flat(a + (b - a) * t, plane)];
            lines.push(PlanLine { points: back, colour: colour(way), weight: 0.8, dashed: true });
        }
    }
    let mut words = vec![(flat(layout.camera_mm, plane), "O".to_owned())];
    for surface in &layout.surfaces[plane] {
        let points: Vec<DVec2> = surface.points_mm.iter().map(|p| flat(*p, plane)).collect();
        if let Some(last) = points.last().filter(|_| plane == 0 && surface.side == Side::Right) {
            let face = if surface.face == Face::Front { "front" } else { "back" };
            words.push((*last, face.to_owned()));
        }
        lines.push(line(points, INK, 2.2));
    }
    let [a, b, c, d] = layout.board_mm.map(|p| flat(p, plane));
    lines.push(line(vec![a, b, c, d, a], INK, 2.2));
    words.push((if plane == 0 { b } else { a }, "board".to_owned()));
    let axes = [if plane == 0 { "x" } else { "−y (up)" }].map(|name| format!("{name}, mm"));
    PlanPanel { name: name.to_owned(), area, axes: ["z, mm".to_owned(), axes[0].clone()], lines, words }
}
