//! A designed prism as a picture: its profile, the sag of both surfaces and how far they depart from planes (the design paper's
//! Fig. 4(a)), and what it leaves of its law.

use super::surface_map::{self, SurfaceMapInput};
use crate::analysis::cutter::{CutterSheet, SurfaceForm};
use crate::geom::Rect;
use crate::plot::axis::Scale;
use crate::plot::chart::{self, AxisInput, ChartInput, ChartSeries, Front, Look, Point};
use crate::plot::colour::Map;
use crate::plot::drawing::Drawing;
use crate::plot::field::{self, HeatMapInput, HeatMapPlane};
use crate::raster::Raster;
use glam::DVec2;

/// Width of one of the three columns, in px.
const COLUMN_PX: u32 = 720;

/// The title of [`draw`].
pub fn title(scene: &str) -> String {
    format!("{scene}: the surfaces of the designed prism, right half")
}

/// The sheet as a figure; `half_px` is the size of a half image.
pub fn draw(sheet: &CutterSheet, half_px: DVec2) -> Drawing {
    let [front, back] = &sheet.surfaces;
    let maps = |surface: &SurfaceForm, name: &str| {
        let map = |title: String, caption: &str, map: Map, values: &[f64]| {
            surface_map::draw(&SurfaceMapInput { met: &surface.map, title, caption, map, values, width_px: COLUMN_PX })
        };
        let sag: Vec<f64> = surface.map.at_mm.iter().map(|p| p.z).collect();
        let departure = format!("{name}: departure from its best plane");
        [
            map(format!("{name}: sag"), "z, mm", Map::Sequential, &sag),
            map(departure, "height above it, mm", Map::Diverging, &surface.map.departures_mm),
        ]
    };
    let [front_sag, front_departure] = maps(front, "front");
    let [back_sag, back_departure] = maps(back, "rear");
    let columns =
        [[profile(front, back), residual(sheet, half_px)], [front_sag, back_sag], [front_departure, back_departure]];

    // Lay the columns side by side, the lower row below the tallest of the upper.
    let below = columns.iter().map(|column| column[0].height_px()).max().unwrap_or(0);
    let height = below + columns.iter().map(|column| column[1].height_px()).max().unwrap_or(0);
    let mut page = Drawing::new(3 * COLUMN_PX, height);
    for (k, [upper, lower]) in columns.iter().enumerate() {
        let left = f64::from(COLUMN_PX) * k as f64;
        page.embed(upper, DVec2::new(left, 0.0));
        page.embed(lower, DVec2::new(left, f64::from(below)));
    }
    page
}

/// z of both surfaces over x in the middle row.
fn profile(front: &SurfaceForm, back: &SurfaceForm) -> Drawing {
    let series = |name: &str, surface: &SurfaceForm| {
        let map = &surface.map;
        let middle = map.side / 2;
        let row = &map.at_mm[middle * map.side..(middle + 1) * map.side];
        ChartSeries {
            name: name.to_owned(),
            look: Look::Line,
            points: row.iter().map(|p| Point::new(p.x, p.z)).collect(),
            labels: Vec::new(),
        }
    };
    let axis = |name: &str| AxisInput { name: name.to_owned(), scale: Scale::Linear, range: None };
    chart::draw(&ChartInput {
        title: "profile in the plane y = 0".to_owned(),
        note: String::new(),
        x: axis("x, mm"),
        y: axis("z, mm"),
        series: vec![series("front", front), series("rear", back)],
        front: Front::None,
        size_px: [COLUMN_PX, COLUMN_PX],
    })
}

/// Length of the error vectors over the half image.
fn residual(sheet: &CutterSheet, half_px: DVec2) -> Drawing {
    let map = &sheet.worse_map;
    let worse = if sheet.residuals[0].both_rms_px > sheet.residuals[1].both_rms_px { 0 } else { 1 };
    let depth_mm = sheet.residuals[worse].depth_mm;
    let at = if depth_mm.is_finite() { format!("at {depth_mm} mm") } else { "at infinity".to_owned() };
    let lengths: Vec<f64> = map.errors_px.iter().map(|e| e.length()).collect();
    let (unit, scale) = surface_map::unit_for("px", &lengths);
    field::draw_heat_map(&HeatMapInput {
        title: format!("left of the law {at}"),
        values: &Raster::from_data(map.side, map.side, lengths.iter().map(|px| px * scale).collect()),
        area: Rect { min: DVec2::ZERO, max: half_px },
        plane: HeatMapPlane::Image,
        axes: ["u, px".to_owned(), "v, px".to_owned()],
        caption: format!("length of the error, {unit}"),
        map: Map::Sequential,
        width_px: COLUMN_PX,
    })
}
