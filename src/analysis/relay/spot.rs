//! The spot: where the rays of one point meet the plane in focus.

use super::pencil::{PencilRay, at_plane};
use crate::geom::Ray;
use glam::DVec2;

/// The size of a spot in the plane that is in focus on the side of the prism, in mm there: times the magnification it is that of
/// the image.
#[derive(Debug, Clone, PartialEq)]
pub struct PencilSpot {
    /// The plane, in mm along z of the world.
    pub focus_mm: f64,
    /// Root mean square distance from the centroid.
    pub rms_mm: f64,
    /// The same from the chief ray.
    pub rms_about_chief_mm: f64,
    /// The largest distance from the chief ray.
    pub radius_mm: f64,
    /// Where the rays meet the plane, from the chief ray's place on.
    pub points_mm: Vec<DVec2>,
}

impl PencilSpot {
    /// The spot of `rays` in the plane `focus_mm`, with the `chief` ray.
    pub fn new(rays: &[PencilRay], chief: &Ray, focus_mm: f64) -> Self {
        let middle = at_plane(chief, focus_mm);
        let points_mm: Vec<DVec2> = rays.iter().map(|ray| at_plane(&ray.exit, focus_mm) - middle).collect();
        let count = points_mm.len().max(1) as f64;
        let centroid = points_mm.iter().sum::<DVec2>() / count;
        let about = |place: DVec2| (points_mm.iter().map(|p| p.distance_squared(place)).sum::<f64>() / count).sqrt();
        Self {
            focus_mm,
            rms_mm: about(centroid),
            rms_about_chief_mm: about(DVec2::ZERO),
            radius_mm: points_mm.iter().map(|p| p.length()).fold(0.0, f64::max),
            points_mm,
        }
    }
}

/// The plane, along z of the world, in which the spot about its centroid is smallest; `None` of parallel rays.
///
/// A ray meets the plane z at X + z s: the mean square about the centroid is a parabola of z, with its least value at
/// -(cov(x, s_x) + cov(y, s_y)) / (var s_x + var s_y).
pub fn best_focus_mm(rays: &[PencilRay]) -> Option<f64> {
    // Measure from the mean place of the rays' ends, where the differences are of the spot's size and do not cancel.
    let count = rays.len() as f64;
    let from = rays.iter().map(|ray| ray.exit.origin.z).sum::<f64>() / count;
    let lines: Vec<[DVec2; 2]> = rays
        .iter()
        .map(|ray| [at_plane(&ray.exit, from), ray.exit.direction.truncate() / ray.exit.direction.z])
        .collect();
    let mean = |of: &dyn Fn(&[DVec2; 2]) -> DVec2| lines.iter().map(of).sum::<DVec2>() / count;
    let middle = [mean(&|line| line[0]), mean(&|line| line[1])];
    let (mut along, mut spread) = (0.0, 0.0);
    for [place, slope] in &lines {
        along += (*place - middle[0]).dot(*slope - middle[1]);
        spread += (*slope - middle[1]).length_squared();
    }
    (spread > 0.0).then(|| from - along / spread)
}
