//! A bundle of object-side rays against one centre of projection: the designed one, or the best there is.

use super::deviation::{Deviation, Unmeasurable, all_finite, at_least};
use super::observation::Observation;
use super::pinhole::Pinhole;
use super::pixel_map::{Correspondence, PixelMap};
use crate::geom::Ray;
use crate::num::stats::{max_abs, mean, rms};
use glam::{DVec2, DVec3};
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// A pixel and the line on which it sees the world, beyond all glass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelRay {
    /// The pixel position, in px from the half's own origin.
    pub image_px: DVec2,
    /// The line, in the world; it is extended backwards where a figure needs it.
    pub ray: Ray,
}

/// Where back-extended rays pierce a plane, against where the designed camera says: the design paper's "reprojection
/// error".
#[derive(Debug, Clone, PartialEq)]
pub struct PlaneDeviation {
    /// z of the plane in the designed camera's frame, in mm.
    pub plane_z_mm: f64,
    /// Pierced minus ideal for each sighting, in mm on the plane.
    pub residuals_mm: Vec<DVec2>,
    /// Sizes of these, in mm on the plane.
    pub mm: Deviation,
    /// Sizes of the same residuals seen from the designed centre, in px: residual times focal_px / |plane_z|.
    pub px: Deviation,
}

/// The deviation from the designed camera, without any fit, on the plane z = `plane_z_mm` of that camera's frame.
///
/// At z = f (un-inverted) and z = -f (where an inverted image would lie) a mm of residual is a mm on the sensor; at the
/// depth of a board it is a mm on the board. The design paper's Table 1 is taken at z = -f: over a uniform 33 x 33 grid
/// that includes the half's borders the flat prism gives 0.0604 mm and 0.0936 mm there, and 0.0305 and 0.1023 at +f.
///
/// # Errors
/// [`Unmeasurable::TooFew`] of none, [`Unmeasurable::NotFinite`], [`Unmeasurable::Parallel`] to the plane,
/// [`Unmeasurable::Degenerate`] for the plane z = 0, in which every ideal point is the centre itself.
pub fn on_plane(designed: &Pinhole, sightings: &[PixelRay], plane_z_mm: f64) -> Result<PlaneDeviation, Unmeasurable> {
    at_least("sightings", sightings.len(), 1)?;
    all_finite("sighting", sightings, |s| s.image_px.is_finite() && finite(&s.ray))?;
    if !plane_z_mm.is_finite() || plane_z_mm == 0.0 {
        return Err(Unmeasurable::Degenerate("a virtual image plane needs a finite distance from the centre"));
    }
    let residual = |(index, s): (usize, &PixelRay)| {
        let ray = s.ray.moved(&designed.camera_from_world);
        let t = (plane_z_mm - ray.origin.z) / ray.direction.z;
        let pierced = if t.is_finite() { ray.at(t) } else { return Err(Unmeasurable::Parallel { index }) };
        Ok((pierced - designed.at_depth(s.image_px, plane_z_mm)).truncate())
    };
    let residuals_mm = sightings.iter().enumerate().map(residual).collect::<Result<Vec<_>, _>>()?;
    let px_per_mm = designed.focal_px / plane_z_mm.abs();
    let residuals_px: Vec<DVec2> = residuals_mm.iter().map(|e| *e * px_per_mm).collect();
    let (mm, px) = (Deviation::of(&residuals_mm)?, Deviation::of(&residuals_px)?);
    Ok(PlaneDeviation { plane_z_mm, residuals_mm, mm, px })
}

/// How far rays pass by a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayMisses {
    /// N, the count of rays.
    pub n: usize,
    /// sqrt(sum d^2 / N) of the shortest distances, in mm.
    pub rms_mm: f64,
    /// Largest distance, in mm.
    pub max_mm: f64,
}

/// Shortest distances of the rays, taken as whole lines, from `point_mm`.
///
/// # Errors
/// [`Unmeasurable::TooFew`] of none, [`Unmeasurable::NotFinite`].
pub fn misses(rays: &[Ray], point_mm: DVec3) -> Result<RayMisses, Unmeasurable> {
    at_least("rays", rays.len(), 1)?;
    all_finite("ray", rays, |r| finite(r) && point_mm.is_finite())?;
    let distances: Vec<f64> = rays.iter().map(|r| off_line(r, point_mm).length()).collect();
    Ok(RayMisses { n: rays.len(), rms_mm: rms(&distances), max_mm: max_abs(&distances) })
}

/// The point nearest to all rays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommonPoint {
    /// Least sum of squared distances from the rays, taken as whole lines; in mm.
    pub point_mm: DVec3,
    /// The distances of the rays from it.
    pub misses: RayMisses,
}

/// The best common point of rays: the centre of projection they would have, and by how much they have none.
///
/// Its drift between bundles (the rays of two board depths) or from the designed centre is a difference of `point_mm`.
///
/// # Errors
/// [`Unmeasurable::TooFew`] below 2 rays, [`Unmeasurable::NotFinite`], [`Unmeasurable::Degenerate`] when all are
/// parallel.
pub(crate) fn common_point(rays: &[Ray]) -> Result<CommonPoint, Unmeasurable> {
    at_least("rays", rays.len(), 2)?;
    all_finite("ray", rays, finite)?;
    // Relative to the mean origin, so that a far world origin costs no digits.
    let n = rays.len() as f64;
    let pivot = rays[0].origin + rays.iter().map(|r| r.origin - rays[0].origin).sum::<DVec3>() / n;
    let mut normal = Matrix3::zeros();
    let mut rhs = DVec3::ZERO;
    for ray in rays {
        let d = ray.direction.to_array();
        normal += Matrix3::from_fn(|i, k| f64::from(u8::from(i == k)) - d[i] * d[k]);
        rhs -= off_line(ray, pivot);
    }
    // The smallest eigenvalue is the sum of squared angles about the mean direction. Below 1e-12 of the whole
    // (angles of 1e-6 rad) rounding decides the place along it.
    let eigen = SymmetricEigen::new(normal);
    if eigen.eigenvalues.min() <= 1e-12 * eigen.eigenvalues.max() {
        return Err(Unmeasurable::Degenerate("all rays are parallel, so no point is nearest"));
    }
    let parallel = Unmeasurable::Degenerate("all rays are parallel, so no point is nearest");
    let shift = normal.cholesky().ok_or(parallel)?.solve(&Vector3::from(rhs.to_array()));
    let point_mm = pivot + DVec3::new(shift[0], shift[1], shift[2]);
    Ok(CommonPoint { point_mm, misses: misses(rays, point_mm)? })
}

/// Where rays come nearest to an axis, measured along it (the design paper's Fig. 4b).
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct AxisCrossings {
    /// For each ray the place on the axis, in mm from the axis' origin along its direction; `None` for a ray parallel
    /// to it, such as the central one.
    pub along_mm: Vec<Option<f64>>,
    /// N, the count of rays that have one.
    pub n: usize,
    /// Mean of |along| over N: the figure's mean distance from O' to the crossings, in mm.
    pub mean_abs_mm: f64,
    /// Largest |along|, in mm.
    pub max_abs_mm: f64,
    /// sqrt(sum d^2 / N) of the distances between ray and axis there, in mm: skew rays cross nowhere.
    pub gap_rms_mm: f64,
}

/// Where the rays, taken as whole lines, come nearest to the axis (origin: the designed centre O').
///
/// A ray within 1e-9 rad of the axis' direction counts as parallel: its crossing would be rounding.
///
/// # Errors
/// [`Unmeasurable::TooFew`] when no ray is oblique to the axis, [`Unmeasurable::NotFinite`].
pub(crate) fn axis_crossings(rays: &[Ray], axis: &Ray) -> Result<AxisCrossings, Unmeasurable> {
    all_finite("ray", rays, |r| finite(r) && finite(axis))?;
    let crossing = |ray: &Ray| {
        // With both directions unit, minimise |axis(s) - ray(t)|^2.
        let normal = axis.direction.cross(ray.direction);
        let sine_squared = normal.length_squared();
        let offset = ray.origin - axis.origin;
        let along = offset.cross(ray.direction).dot(normal) / sine_squared;
        (sine_squared > 1e-18).then(|| (along, offset.dot(normal) / sine_squared.sqrt()))
    };
    let crossings: Vec<Option<(f64, f64)>> = rays.iter().map(crossing).collect();
    let (along, gaps): (Vec<f64>, Vec<f64>) = crossings.iter().flatten().copied().unzip();
    at_least("rays oblique to the axis", along.len(), 1)?;
    let magnitudes: Vec<f64> = along.iter().map(|a| a.abs()).collect();
    Ok(AxisCrossings {
        along_mm: crossings.iter().map(|c| c.map(|(along, _)| along)).collect(),
        n: along.len(),
        mean_abs_mm: mean(&magnitudes),
        max_abs_mm: max_abs(&along),
        gap_rms_mm: rms(&gaps),
    })
}

/// Object-side rays from corners only: a plane board at several depths, each a set of observations.
///
/// The map px -> board of each depth is interpolated (see [`PixelMap`]) and evaluated at every pixel of `image_px` that
/// all depths cover; the line of total least squares through a pixel's points, from the first depth towards the last,
/// is its ray.
///
/// # Errors
/// [`Unmeasurable::TooFew`] below 2 depths, or when no pixel is covered by all; [`Unmeasurable::Degenerate`] when a
/// pixel sees the same point at every depth; what [`PixelMap::fit`] refuses.
pub fn rays_from_depths(
    depths: &[Vec<Observation>],
    image_px: &[DVec2],
    degree: usize,
) -> Result<Vec<PixelRay>, Unmeasurable> {
    at_least("depths", depths.len(), 2)?;
    let fit = |observations: &Vec<Observation>, value: &dyn Fn(DVec3) -> DVec2| {
        let sample = |o: &Observation| Correspondence { image_px: o.image_px, value: value(o.point_mm) };
        PixelMap::fit(&observations.iter().map(sample).collect::<Vec<_>>(), degree)
    };
    // World x, y and z are all interpolated, so that the board may be tilted.
    let maps = depths
        .iter()
        .map(|o| Ok((fit(o, &|p| p.truncate())?, fit(o, &|p| DVec2::new(p.z, 0.0))?)))
        .collect::<Result<Vec<_>, Unmeasurable>>()?;
    let points = |px: &DVec2| {
        let seen = |(xy, z): &(PixelMap, PixelMap)| Some(xy.at(*px)?.extend(z.at(*px)?.x));
        maps.iter().map(seen).collect::<Option<Vec<DVec3>>>().map(|points| (*px, points))
    };
    let covered: Vec<_> = image_px.iter().filter_map(points).collect();
    at_least("pixels covered at every depth", covered.len(), 1)?;
    covered.into_iter().map(|(image_px, points)| Ok(PixelRay { image_px, ray: ray_through(&points)? })).collect()
}

/// The line of total least squares through points, pointing from the first towards the last.
fn ray_through(points: &[DVec3]) -> Result<Ray, Unmeasurable> {
    let origin = points[0] + points.iter().map(|p| *p - points[0]).sum::<DVec3>() / points.len() as f64;
    let mut scatter = Matrix3::zeros();
    for p in points {
        let d = (*p - origin).to_array();
        scatter += Matrix3::from_fn(|i, k| d[i] * d[k]);
    }
    let eigen = SymmetricEigen::new(scatter);
    let axis = eigen.eigenvectors.column(eigen.eigenvalues.imax());
    let axis = DVec3::new(axis[0], axis[1], axis[2]);
    let forward = axis.dot(points[points.len() - 1] - points[0]);
    if forward == 0.0 {
        return Err(Unmeasurable::Degenerate("a pixel sees the same point at every depth"));
    }
    Ok(Ray { origin, direction: axis * forward.signum() })
}

fn finite(ray: &Ray) -> bool {
    ray.origin.is_finite() && ray.direction.is_finite()
}

/// From the point of the ray's line nearest to `p`, to `p`.
fn off_line(ray: &Ray, p: DVec3) -> DVec3 {
    let d = p - ray.origin;
    d - ray.direction * ray.direction.dot(d)
}

#[cfg(test)]
#[path = "ray_bundle_tests.rs"]
mod tests;
