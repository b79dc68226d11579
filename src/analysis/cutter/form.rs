//! The shape of a prism's surfaces where the rays of the picture meet them, and its glass.

use super::bench::{Bench, Meeting, Meetings, passed, places, ray};
use super::residual::PLACES;
use super::sphere;
use crate::error::Error;
use crate::num::lsq;
use crate::surface::face::Face;
use crate::system::{Side, System};
use glam::{DVec2, DVec3};
use nalgebra::DMatrix;

/// Curvatures below this are those of a plane, in 1/mm: a sag of 1e-8 mm over 10 mm.
const FLAT_PER_MM: f64 = 1e-9;
/// Heights of the right and of the left back that agree to this belong to one surface, in mm.
const ONE_SURFACE_MM: f64 = 1e-9;

/// The shape of one surface of a half, over the places that its rays meet.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceForm {
    /// Highest less lowest height above the plane of least squares, along z, in mm.
    pub departure_mm: f64,
    /// The same above the sphere of least squares, along its radius, in mm.
    pub from_sphere_mm: f64,
    /// Largest angle of the normal to the z axis, in deg.
    pub slope_max_deg: f64,
    /// Smallest radius of curvature, in mm; `None` of a plane.
    pub radius_min_mm: Option<f64>,
    /// Where it is met.
    pub map: SurfaceMap,
}

/// Heights of a surface where the rays of a grid of pixels meet it.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceMap {
    /// Columns, and rows, of the grid.
    pub side: usize,
    /// The places that are met, row by row, in the prism's frame, in mm.
    pub at_mm: Vec<DVec3>,
    /// Their heights above the plane of least squares, along z, in mm.
    pub departures_mm: Vec<f64>,
    /// Their heights above the sphere of least squares, along its radius towards +z, in mm.
    pub from_sphere_mm: Vec<f64>,
    /// Angles of the normal to the z axis, in deg.
    pub slopes_deg: Vec<f64>,
    /// The principal curvatures, the larger first, in 1/mm; above 0 where the surface bends towards +z.
    pub curvatures_per_mm: Vec<[f64; 2]>,
}

/// The glass of the right half.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GlassForm {
    /// Thickness along z at x = y = 0, in mm.
    pub centre_mm: f64,
    /// Least thickness along z over all that the rays meet, in mm: at the edge of the used part.
    pub edge_mm: f64,
    /// Columns of pixels of a half next to the ridge some of whose rays leave the glass beyond x = 0.
    pub crossing_columns: usize,
    /// Whether they find the same surface there: the backs of both halves are one.
    pub one_back: bool,
}

/// The front and the back of the half on `side`, over the places that those rays of its half image meet that pass them.
///
/// # Errors
/// When there is no prism, or no ray passes it.
pub fn surfaces(system: &System, side: Side) -> Result<[SurfaceForm; 2], Error> {
    let all: Vec<_> = places(system, PLACES).into_iter().map(|place_px| meetings(system, side, place_px)).collect();
    let ended = all.iter().find_map(|met| met.as_ref().err().cloned());
    let met: Vec<[Meeting; 2]> = all.into_iter().flatten().collect();
    if let Some(why) = ended.filter(|_| met.is_empty()) {
        return Err(why);
    }
    let [front, back] = [0, 1].map(|face| surface(&met.iter().map(|met| met[face]).collect::<Vec<_>>()));
    Ok([front?, back?])
}

/// The front, the back and the glass.
pub(super) fn form(bench: &Bench<'_>) -> Result<([SurfaceForm; 2], GlassForm), Error> {
    let right = &bench.halves[1];
    let mut met = [Vec::new(), Vec::new()];
    for place_px in bench.places(PLACES) {
        let [front, back] = meetings(bench.system, Side::Right, place_px)?;
        met[0].push(front);
        met[1].push(back);
    }
    let [front, back] = met.each_ref().map(|met| surface(met));
    let prism = bench.prism()?;
    let [height_of_front, height_of_back] =
        [Face::Front, Face::Back].map(|face| prism.surface(right.frame.side(), face));
    let thickness_mm = |p: DVec2| height_of_back.height_mm(p.x, p.y) - height_of_front.height_mm(p.x, p.y);
    // Beyond x = 0 the glass of this half ends.
    let own = met.iter().flatten().map(|m| m.at_mm.truncate()).filter(|p| p.x >= 0.0);
    let (crossing_columns, apart_mm) = crossing(bench)?;
    let glass = GlassForm {
        centre_mm: thickness_mm(DVec2::ZERO),
        edge_mm: own.map(thickness_mm).fold(f64::INFINITY, f64::min),
        crossing_columns,
        one_back: apart_mm <= ONE_SURFACE_MM,
    };
    Ok(([front?, back?], glass))
}

/// Where the ray at a place of a half meets the front and the back.
fn meetings(system: &System, side: Side, place_px: DVec2) -> Result<[Meeting; 2], Error> {
    let mut found = Meetings::default();
    passed(system, &ray(system, side, place_px), side, &mut found)?;
    Ok([found.0[0], found.0[1]])
}

/// How many columns of pixels of the right half have rays that leave the glass left of x = 0, in the first, the middle or the
/// last row, and how far the backs of the two halves are apart there.
fn crossing(bench: &Bench<'_>) -> Result<(usize, f64), Error> {
    let [width, height] = bench.system.camera().size_px();
    let rows = [0.5, 0.5 * height as f64, height as f64 - 0.5];
    let backs = [Side::Left, Side::Right].map(|side| bench.prism().map(|prism| prism.surface(side, Face::Back)));
    let [left, right] = backs;
    let (left, right) = (left?, right?);
    let (mut columns, mut apart_mm) = (0, 0.0f64);
    for column in 0..width / 2 {
        let mut crosses = false;
        for row in rows {
            let [_, back] = meetings(bench.system, Side::Right, DVec2::new(column as f64 + 0.5, row))?;
            if back.at_mm.x < 0.0 {
                crosses = true;
                let [x, y, _] = back.at_mm.to_array();
                apart_mm = apart_mm.max((right.height_mm(x, y) - left.height_mm(x, y)).abs());
            }
        }
        if !crosses {
            break;
        }
        columns += 1;
    }
    Ok((columns, apart_mm))
}

fn surface(met: &[Meeting]) -> Result<SurfaceForm, Error> {
    let singular =
        |why: lsq::Failure| Error::new("the prism", format!("no plane fits a surface: {why}"), "give a wider field");
    let fit = |columns: &DMatrix<f64>, values: &dyn Fn(DVec3) -> f64| {
        let values = DMatrix::from_fn(met.len(), 1, |i, _| values(met[i].at_mm));
        lsq::linear(columns, &values).map(|found| (&values - columns * &found, found))
    };
    let range = |values: &[f64]| {
        let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
        high - low
    };

    // Take the heights above the plane z = a + b x + c y.
    let plane = DMatrix::from_fn(met.len(), 3, |i, k| [1.0, met[i].at_mm.x, met[i].at_mm.y][k]);
    let (above, plane_found) = fit(&plane, &|p| p.z).map_err(singular)?;
    let departures_mm = above.as_slice().to_vec();
    let departure_mm = range(&departures_mm);

    // Take the distances from the sphere.
    let at_mm: Vec<DVec3> = met.iter().map(|m| m.at_mm).collect();
    let slope = DVec2::new(plane_found[1], plane_found[2]);
    let from_sphere_mm = sphere::heights_above(&at_mm, slope).map_err(singular)?;
    let largest = |of: fn(&Meeting) -> f64| met.iter().map(of).fold(0.0, f64::max);
    let curvature_per_mm = largest(|m| m.curvatures_per_mm[0].abs().max(m.curvatures_per_mm[1].abs()));
    Ok(SurfaceForm {
        departure_mm,
        from_sphere_mm: range(&from_sphere_mm),
        slope_max_deg: largest(|m| m.slope_rad).to_degrees(),
        radius_min_mm: (curvature_per_mm > FLAT_PER_MM).then(|| 1.0 / curvature_per_mm),
        map: SurfaceMap {
            side: PLACES,
            at_mm,
            departures_mm,
            from_sphere_mm,
            slopes_deg: met.iter().map(|m| m.slope_rad.to_degrees()).collect(),
            curvatures_per_mm: met.iter().map(|m| m.curvatures_per_mm).collect(),
        },
    })
}
