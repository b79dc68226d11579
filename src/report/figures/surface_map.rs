//! A value over the places where a surface is met, as colours.

use crate::analysis::cutter::SurfaceMap;
use crate::geom::Rect;
use crate::num::stats;
use crate::plot::axis::superscript;
use crate::plot::colour::Map;
use crate::plot::drawing::Drawing;
use crate::plot::field::{self, HeatMapInput, HeatMapPlane};
use crate::raster::Raster;
use glam::DVec2;

/// A value over a surface.
#[derive(Debug, Clone)]
pub struct SurfaceMapInput<'a> {
    /// Where the surface is met.
    pub met: &'a SurfaceMap,
    /// Heading.
    pub title: String,
    /// What the colour means, with its unit.
    pub caption: &'a str,
    /// The colours.
    pub map: Map,
    /// The value at each of the places.
    pub values: &'a [f64],
    /// Width in px.
    pub width_px: u32,
}

/// Each place of the drawing has the value of the nearest one where the surface is met; places that no ray meets are left out.
pub fn draw(input: &SurfaceMapInput) -> Drawing {
    let side = input.met.side;
    let places: Vec<DVec2> = input.met.at_mm.iter().map(|p| p.truncate()).collect();
    let first = Rect { min: places[0], max: places[0] };
    let area = places.iter().fold(first, |r, p| Rect { min: r.min.min(*p), max: r.max.max(*p) });
    let step = area.size() / (side - 1) as f64;
    let cell = |i: usize, j: usize| {
        let centre = area.min + area.size() * DVec2::new(i as f64 + 0.5, j as f64 + 0.5) / side as f64;
        let far = |p: &DVec2| ((*p - centre) / step).length();
        let (k, nearest) = places.iter().enumerate().min_by(|a, b| far(a.1).total_cmp(&far(b.1)))?;
        (far(nearest) < 1.0).then(|| input.values[k])
    };
    let values = (0..side * side).map(|k| cell(k % side, k / side).unwrap_or(f64::NAN)).collect();
    field::draw_heat_map(&HeatMapInput {
        title: input.title.clone(),
        values: &Raster::from_data(side, side, values),
        area,
        plane: HeatMapPlane::Image,
        axes: ["x, mm".to_owned(), "y, mm".to_owned()],
        caption: input.caption.to_owned(),
        map: input.map,
        width_px: input.width_px,
    })
}

/// The unit of small values with a power of ten before it, which leaves room between the numbers of a colour bar, and what the
/// values are multiplied by.
pub(crate) fn unit_for(unit: &str, values: &[f64]) -> (String, f64) {
    let largest = stats::max_abs(values);
    let power = if largest > 0.0 && largest < 0.01 { libm::floor(libm::log10(largest)) } else { 0.0 };
    let named = if power == 0.0 { unit.to_owned() } else { format!("10{} {unit}", superscript(power as i32)) };
    (named, libm::pow(10.0, -power))
}
