//! The surfaces of prisms as sheets and figures.

use super::document::StudyFigure;
use crate::analysis::cutter::{SurfaceForm, SurfaceMap};
use crate::analysis::surface_fits::{DegreeFit, DegreeFits};
use crate::plot::axis::Scale;
use crate::plot::chart::{self, AxisInput, ChartInput, ChartSeries, Front, Look, Point};
use crate::plot::colour::{INK, Map};
use crate::plot::drawing::Drawing;
use crate::plot::text::{Align, Font};
use crate::report::figures::surface_map::{self, SurfaceMapInput};
use crate::report::sheet::{Cell, StudySheet};
use crate::surface::face::Face;
use glam::DVec2;

/// Values of a map below this are roundings of a plane, in mm, and are drawn as 0: some of a length of 100 mm.
const ROUNDING_MM: f64 = 1e-12;
/// Width of one map, in px.
const COLUMN_PX: u32 = 560;
/// Room above the maps for the heading, in px.
const HEADING_PX: f64 = 60.0;

/// The surfaces of one half of one prism.
#[derive(Debug, Clone)]
pub struct NamedSurfaces {
    /// The prism's name.
    pub prism: String,
    /// Its half: `left` or `right`.
    pub half: &'static str,
    /// The front and the back.
    pub surfaces: [SurfaceForm; 2],
}

/// The fits of one prism.
#[derive(Debug, Clone)]
pub struct NamedFits {
    /// The prism's name.
    pub prism: String,
    /// Over the degree.
    pub fits: DegreeFits,
}

/// `front` or `back`.
fn word(face: Face) -> &'static str {
    if face == Face::Front { "front" } else { "back" }
}

const LEAD: [(&str, &str); 3] =
    [("prism", "the prism's name"), ("half", "the half of the prism"), ("surface", "front or back")];

/// The sizes, what the fits leave, and every place.
pub fn sheets(all: &[NamedSurfaces], fits: &[NamedFits]) -> Vec<StudySheet> {
    let sizes = [
        ("places", "of 41 x 41 rays of the half image that pass"),
        ("sag_mm", "highest less lowest z, mm"),
        ("departure_mm", "highest less lowest height along z above the plane of least squares, mm"),
        ("from_sphere_mm", "the same along the radius above the sphere of least squares, mm"),
        ("slope_max_deg", "largest angle of the normal to the z axis, deg"),
        ("radius_min_mm", "smallest radius of curvature; nothing of a plane, mm"),
        ("curvature_max_per_mm", "largest principal curvature, above 0 where the surface bends towards +z, 1/mm"),
        ("curvature_min_per_mm", "smallest principal curvature, 1/mm"),
    ];
    let places = [
        ("x_mm", "where a ray of the half image meets the surface, in the prism's frame, mm"),
        ("y_mm", "the same, mm"),
        ("z_mm", "the same: the sag, mm"),
        ("departure_mm", "height along z above the plane of least squares, mm"),
        ("from_sphere_mm", "height along the radius above the sphere of least squares, mm"),
        ("slope_deg", "angle of the normal to the z axis, deg"),
        ("curvature_1_per_mm", "the larger principal curvature, 1/mm"),
        ("curvature_2_per_mm", "the smaller one, 1/mm"),
    ];
    let mut table = StudySheet::new(
        "surface",
        "Surfaces over the places that the rays of the half image meet",
        &[&LEAD[..], &sizes[..]].concat(),
    );
    let mut map = StudySheet::new("surface_map", "Every place", &[&LEAD[..], &places[..]].concat());
    for one in all {
        for (face, form) in Face::ALL.into_iter().zip(&one.surfaces) {
            let lead = || [Cell::from(one.prism.as_str()), one.half.into(), word(face).into()].into_iter();
            table.push(lead().chain(sizes_of(form)).collect());
            let at = &form.map;
            for (k, p) in at.at_mm.iter().enumerate() {
                let [first, second] = at.curvatures_per_mm[k];
                let values =
                    [p.x, p.y, p.z, at.departures_mm[k], at.from_sphere_mm[k], at.slopes_deg[k], first, second];
                map.push(lead().chain(values.map(Cell::from)).collect());
            }
        }
    }
    vec![table, fit_sheet(fits), map.detailed()]
}

fn sizes_of(form: &SurfaceForm) -> [Cell; 8] {
    let of = |values: &mut dyn Iterator<Item = f64>| {
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
    };
    let [low, high] = of(&mut form.map.at_mm.iter().map(|p| p.z));
    let [least, most] = of(&mut form.map.curvatures_per_mm.iter().flatten().copied());
    [
        form.map.at_mm.len().into(),
        (high - low).into(),
        form.departure_mm.into(),
        form.from_sphere_mm.into(),
        form.slope_max_deg.into(),
        form.radius_min_mm.into(),
        most.into(),
        least.into(),
    ]
}

fn fit_sheet(all: &[NamedFits]) -> StudySheet {
    let mut sheet = StudySheet::new(
        "surface_fits",
        "What polynomials leave of the points that the surfaces are fitted to",
        &[
            ("prism", "the prism's name"),
            ("surface", "front or back"),
            ("degree", "total degree of the polynomial"),
            ("own", "whether the prism has this one: yes or no"),
            ("coefficients", "that are fitted"),
            ("points", "that they are fitted to"),
            ("rms_mm", "root mean square of the residuals along z, mm"),
            ("max_mm", "largest residual along z, mm"),
            ("not_fitted", "why the prism has no fit"),
        ],
    );
    for one in all {
        match &one.fits {
            DegreeFits::Fitted(fits) => fits.iter().for_each(|fit| sheet.push(fit_row(&one.prism, fit))),
            DegreeFits::NotFitted(why) => {
                let nothing = std::iter::repeat_n(Cell::Nothing, 7);
                sheet.push([one.prism.as_str().into()].into_iter().chain(nothing).chain([(*why).into()]).collect());
            }
        }
    }
    sheet
}

fn fit_row(prism: &str, fit: &DegreeFit) -> Vec<Cell> {
    let DegreeFit { face, degree, own, coefficients, points, rms_mm, max_mm } = *fit;
    let own = if own { "yes" } else { "no" };
    let counts = [prism.into(), word(face).into(), degree.into(), own.into(), coefficients.into(), points.into()];
    counts.into_iter().chain([rms_mm.into(), max_mm.into(), Cell::Nothing]).collect()
}

/// A figure a half, and the residuals over the degree where a prism is fitted.
pub fn figures(all: &[NamedSurfaces], fits: &[NamedFits]) -> Vec<StudyFigure> {
    all.iter().map(maps).chain(residuals(fits)).collect()
}

/// A row of maps a surface.
fn maps(one: &NamedSurfaces) -> StudyFigure {
    let title = format!("Surfaces: {} prism, {} half", one.prism, one.half);
    let rows: Vec<Vec<Drawing>> =
        Face::ALL.into_iter().zip(&one.surfaces).map(|(face, form)| row(word(face), &form.map)).collect();
    let tallest = |row: &[Drawing]| row.iter().map(Drawing::height_px).max().unwrap_or(0);
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0) as u32;
    let height = HEADING_PX as u32 + rows.iter().map(|row| tallest(row)).sum::<u32>();
    let mut page = Drawing::new(columns * COLUMN_PX, height);
    page.text(title.as_str(), Font::bold(26.0), INK, DVec2::new(20.0, 0.7 * HEADING_PX), Align::Start);
    let mut top = HEADING_PX;
    for row in &rows {
        for (k, map) in row.iter().enumerate() {
            page.embed(map, DVec2::new(f64::from(COLUMN_PX) * k as f64, top));
        }
        top += f64::from(tallest(row));
    }
    StudyFigure { name: format!("surface_{}_{}", one.prism, one.half), title, drawing: page }
}

fn row(name: &str, met: &SurfaceMap) -> Vec<Drawing> {
    let map = |what: &str, colour: &str, unit: &str, map: Map, values: Vec<f64>| {
        let values: Vec<f64> = values.into_iter().map(|v| if v.abs() < ROUNDING_MM { 0.0 } else { v }).collect();
        let (unit, scale) = surface_map::unit_for(unit, &values);
        let values: Vec<f64> = values.iter().map(|v| v * scale).collect();
        surface_map::draw(&SurfaceMapInput {
            met,
            title: format!("{name}: {what}"),
            caption: &format!("{colour}, {unit}"),
            map,
            values: &values,
            width_px: COLUMN_PX,
        })
    };
    let mean_per_m = met.curvatures_per_mm.iter().map(|[a, b]| 500.0 * (a + b)).collect();
    vec![
        map("sag", "z", "mm", Map::Sequential, met.at_mm.iter().map(|p| p.z).collect()),
        map("from its best plane", "height above it", "mm", Map::Diverging, met.departures_mm.clone()),
        map("from its best sphere", "height above it", "mm", Map::Diverging, met.from_sphere_mm.clone()),
        map("slope", "angle of the normal to z", "deg", Map::Sequential, met.slopes_deg.clone()),
        map("curvature", "mean curvature", "1/m", Map::Sequential, mean_per_m),
    ]
}

fn residuals(all: &[NamedFits]) -> Option<StudyFigure> {
    let mut series = Vec::new();
    for one in all {
        let DegreeFits::Fitted(fits) = &one.fits else { continue };
        for face in Face::ALL {
            for (size, look) in [("RMS", Look::MarkersAndLine), ("largest", Look::DashedLine)] {
                let value = |fit: &DegreeFit| if size == "RMS" { fit.rms_mm } else { fit.max_mm };
                let own = fits.iter().filter(|fit| fit.face == face);
                series.push(ChartSeries {
                    name: format!("{}, {}, {size}", one.prism, word(face)),
                    look,
                    points: own.map(|fit| Point::new(fit.degree as f64, value(fit))).collect(),
                    labels: Vec::new(),
                });
            }
        }
    }
    if series.is_empty() {
        return None;
    }
    let title = "What polynomials leave of the points of a surface".to_owned();
    let drawing = chart::draw(&ChartInput {
        title: title.clone(),
        note: String::new(),
        x: AxisInput { name: "total degree".to_owned(), scale: Scale::Linear, range: None },
        y: AxisInput { name: "residual along z, mm".to_owned(), scale: Scale::Log, range: None },
        series,
        front: Front::None,
        size_px: [1400, 800],
    });
    Some(StudyFigure { name: "surface_fits".to_owned(), title, drawing })
}
