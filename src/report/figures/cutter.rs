//! A designed prism as a picture: its profile, the sag of both surfaces and how far they depart from planes (the design paper's
//! Fig. 4(a)), and what it leaves of its law.

use crate::analysis::cutter::{CutterSheet, SurfaceForm};
use crate::geom::Rect;
use crate::num::stats;
use crate::plot::axis::{Scale, superscript};
use crate::plot::chart::{self, AxisInput, ChartInput, ChartSeries, Front, Look, Point};
use crate::plot::colour::Map;
use crate::plot::drawing::Drawing;
use crate::plot::field::{self, HeatMapInput};
use crate::raster::Raster;
use glam::{DVec2, DVec3};

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
        [
            surface_map(surface, format!("{name}: sag"), "z, mm", Map::Sequential, |p, _| p.z),
            surface_map(
                surface,
                format!("{name}: departure from its best plane"),
                "height above it, mm",
                Map::Diverging,
                |_, d| d,
            ),
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
    // A power of ten beside the unit leaves room between the numbers of the colour bar.
    let largest = stats::max_abs(&lengths);
    let power = if largest > 0.0 && largest < 0.01 { libm::floor(libm::log10(largest)) } else { 0.0 };
    let unit = if power == 0.0 { "px".to_owned() } else { format!("10{} px", superscript(power as i32)) };
    let scale = libm::pow(10.0, -power);
    field::draw_heat_map(&HeatMapInput {
        title: format!("left of the law {at}"),
        values: &Raster::from_data(map.side, map.side, lengths.iter().map(|px| px * scale).collect()),
        area: Rect { min: DVec2::ZERO, max: half_px },
        axes: ["u, px".to_owned(), "v, px".to_owned()],
        caption: format!("length of the error, {unit}"),
        map: Map::Sequential,
        width_px: COLUMN_PX,
    })
}

/// A value over the places where a surface is met, by the nearest of these; places that no ray meets are left out.
fn surface_map(surface: &SurfaceForm, title: String, caption: &str, map: Map, value: fn(DVec3, f64) -> f64) -> Drawing {
    let met = &surface.map;
    let places: Vec<DVec2> = met.at_mm.iter().map(|p| p.truncate()).collect();
    let first = Rect { min: places[0], max: places[0] };
    let area = places.iter().fold(first, |r, p| Rect { min: r.min.min(*p), max: r.max.max(*p) });
    let step = area.size() / (met.side - 1) as f64;
    let cell = |i: usize, j: usize| {
        let centre = area.min + area.size() * DVec2::new(i as f64 + 0.5, j as f64 + 0.5) / met.side as f64;
        let far = |p: &DVec2| ((*p - centre) / step).length();
        let (k, nearest) = places.iter().enumerate().min_by(|a, b| far(a.1).total_cmp(&far(b.1)))?;
        (far(nearest) < 1.0).then(|| value(met.at_mm[k], met.departures_mm[k]))
    };
    let values = (0..met.side * met.side).map(|k| cell(k % met.side, k / met.side).unwrap_or(f64::NAN)).collect();
    field::draw_heat_map(&HeatMapInput {
        title,
        values: &Raster::from_data(met.side, met.side, values),
        area,
        axes: ["x, mm".to_owned(), "y, mm".to_owned()],
        caption: caption.to_owned(),
        map,
        width_px: COLUMN_PX,
    })
}
