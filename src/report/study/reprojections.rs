//! Reprojection errors as sheets and as a field of arrows.

use super::document::StudyFigure;
use crate::analysis::reprojection_study::ReprojectionErrors;
use crate::geom::Rect;
use crate::num::stats::max_abs;
use crate::plot::axis::round_below;
use crate::plot::field::{Arrow, QuiverInput, QuiverPanel, draw_quiver};
use crate::report::sheet::{Cell, StudySheet};
use glam::DVec2;

/// The errors of one half of one prism.
#[derive(Debug, Clone)]
pub struct NamedReprojections {
    /// The prism's name.
    pub prism: String,
    /// Its half: `left` or `right`.
    pub half: &'static str,
    /// Columns and rows of the half image.
    pub size_px: DVec2,
    /// A plane each.
    pub planes: Vec<ReprojectionErrors>,
}

const LEAD: [(&str, &str); 3] = [
    ("prism", "the prism's name"),
    ("half", "the half of the prism"),
    ("plane_mm", "z of the plane in the virtual camera's frame; the inverted virtual image lies at -f, mm"),
];

/// The sizes, and every error.
pub fn sheets(all: &[NamedReprojections]) -> Vec<StudySheet> {
    let sizes = [
        ("rays", "rays of the grid that pass"),
        ("horizontal_mm", "mean of the horizontal part's magnitude, on the plane, mm"),
        ("vertical_mm", "the same of the vertical part, mm"),
        ("average_mm", "the mean of the two, mm"),
        ("rms_mm", "root mean square length, mm"),
        ("largest_mm", "largest length, mm"),
        ("horizontal_px", "the horizontal part seen from the virtual camera, px"),
        ("vertical_px", "the vertical part seen from there, px"),
        ("rms_px", "root mean square length seen from there, px"),
        ("largest_px", "largest length seen from there, px"),
    ];
    let vectors = [
        ("x_px", "place of the ray in the half image, px"),
        ("y_px", "the same down, px"),
        ("error_x_mm", "pierced less ideal, on the plane, mm"),
        ("error_y_mm", "the same down, mm"),
    ];
    let mut table = StudySheet::new("reprojection", "Reprojection errors", &[&LEAD[..], &sizes[..]].concat());
    let mut field = StudySheet::new("reprojection_vectors", "Error of every ray", &[&LEAD[..], &vectors[..]].concat());
    for one in all {
        for plane in &one.planes {
            let lead = || [Cell::from(one.prism.as_str()), one.half.into(), plane.plane_mm.into()].into_iter();
            let (mm, px) = (&plane.deviation.mm, &plane.deviation.px);
            let average = 0.5 * (mm.mean_abs.x + mm.mean_abs.y);
            let numbers = [
                [mm.mean_abs.x, mm.mean_abs.y, average, mm.rms, mm.max].to_vec(),
                [px.mean_abs.x, px.mean_abs.y, px.rms, px.max].to_vec(),
            ];
            table.push(lead().chain([mm.n.into()]).chain(numbers.concat().into_iter().map(Cell::from)).collect());
            for (place, error) in plane.places_px.iter().zip(&plane.deviation.residuals_mm) {
                field.push(lead().chain([place.x, place.y, error.x, error.y].map(Cell::from)).collect());
            }
        }
    }
    vec![table, field.detailed()]
}

/// A figure a plane, with a panel for each of the first four halves; of a grid of more than 45 rays a side, not all arrows.
pub fn figures(all: &[NamedReprojections]) -> Vec<StudyFigure> {
    let planes = all.first().map_or(0, |one| one.planes.len());
    (0..planes).map(|k| figure(all, k)).collect()
}

fn figure(all: &[NamedReprojections], plane: usize) -> StudyFigure {
    let size_px = all[0].size_px;
    let panel = |one: &NamedReprojections| {
        let errors = &one.planes[plane];
        let px_per_mm = errors.deviation.px.max / errors.deviation.mm.max.max(f64::MIN_POSITIVE);
        let side = (errors.places_px.len() as f64).sqrt().round().max(1.0) as usize;
        let every = side.div_ceil(45);
        let shown = |k: &usize| (k / side).is_multiple_of(every) && (k % side).is_multiple_of(every);
        let arrow = |k: usize| Arrow { at: errors.places_px[k], error: errors.deviation.residuals_mm[k] * px_per_mm };
        let arrows: Vec<Arrow> = (0..errors.places_px.len()).filter(shown).map(arrow).collect();
        // The longest arrow is as long as the way to its neighbour.
        let lengths: Vec<f64> = arrows.iter().map(|a| a.error.length()).collect();
        let step = size_px.min_element() * every as f64 / side.max(2) as f64;
        let gain = round_below(step / max_abs(&lengths).max(f64::MIN_POSITIVE));
        QuiverPanel { name: format!("{} prism, {} half", one.prism, one.half), arrows, gain }
    };
    let plane_mm = all[0].planes[plane].plane_mm;
    let place = if plane_mm < 0.0 { "the virtual image".to_owned() } else { format!("z = {plane_mm} mm") };
    let title = format!("Reprojection errors in the plane of {place}");
    let drawing = draw_quiver(&QuiverInput {
        title: title.clone(),
        // Room for the arrows of the border.
        area: Rect { min: DVec2::ZERO, max: size_px }.grown(0.04 * size_px.max_element()),
        unit: "px".to_owned(),
        panels: all.iter().take(4).map(panel).collect(),
        width_px: 1800,
    });
    let name = if plane == 0 { "reprojection".to_owned() } else { format!("reprojection_{plane}") };
    StudyFigure { name, title, drawing }
}
