//! Local polynomial interpolation of the marched points: what a design would do if its surfaces went through the points
//! themselves, before any polynomial is fitted to all of them.
//!
//! Over the grid both surfaces are smooth functions of column and row; six points each way make a local polynomial that is
//! exact to the sixth order of their distance. It gives place and normal. Of a fine grid every n-th point is taken: the
//! rounding of a point turns the normal by as much as its neighbours are near.

use super::point_grid::PointGrid;
use crate::geom::Ray;
use crate::optics::fate::Fate;
use crate::surface::face::Face;
use crate::surface::hit::Hit;
use glam::{DMat2, DVec2, DVec3};

/// Points each way in a local polynomial.
const POINTS: usize = 6;
/// Distances between the points of local polynomials that a grid is at least divided into: over a hundredth of a surface
/// that bends once or twice the sixth order is below 1e-12 of its bend.
const DISTANCES: usize = 100;
/// Newton's method gives up after this many steps; from the start that the design gives it needs 3.
const MOST_STEPS: usize = 12;
/// It is done when a step is below this many steps of the grid: the rounding of a place among a million points.
const STEP: f64 = 1e-9;
/// A ray may leave the grid by this many of its steps: real rays stray from the designed ones by less than one.
const OVERHANG: f64 = 8.0;

/// Both surfaces of the right half (x > 0), in the prism's frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Marched<'a> {
    cloud: &'a PointGrid,
    /// Columns and rows between the points of a local polynomial.
    strides: [usize; 2],
}

impl<'a> Marched<'a> {
    /// The surfaces through the points of `cloud`; `None` where its grid has fewer than six columns or rows.
    pub(crate) fn new(cloud: &'a PointGrid) -> Option<Self> {
        let strides = [cloud.columns(), cloud.rows()].map(|count| (count / DISTANCES).max(1));
        (cloud.columns().min(cloud.rows()) >= POINTS).then_some(Self { cloud, strides })
    }

    /// Where a ray meets the front or the back surface; of the left half, when `mirrored`.
    ///
    /// # Errors
    /// [`Fate::Missed`] beyond the grid, [`Fate::NotConverged`] where no place is found.
    pub(crate) fn intersect(&self, face: Face, ray: &Ray, mirrored: bool) -> Result<Hit, Fate> {
        let flip = |v: DVec3| if mirrored { DVec3::new(-v.x, v.y, v.z) } else { v };
        let ray = Ray { origin: flip(ray.origin), direction: flip(ray.direction) };
        let across = ray.direction.any_orthonormal_pair();
        let mut place = self.start(face, &ray);
        for _ in 0..MOST_STEPS {
            let [point, by_column, by_row] = self.local(face, place)?;
            let gap = point - ray.origin;
            let flat = |v: DVec3| DVec2::new(across.0.dot(v), across.1.dot(v));
            let step = DMat2::from_cols(flat(by_column), flat(by_row)).inverse() * flat(gap);
            if !step.is_finite() {
                return Err(Fate::NotConverged);
            }
            place -= step;
            if step.abs().max_element() < STEP {
                let [point, by_column, by_row] = self.local(face, place)?;
                let t_mm = (point - ray.origin).dot(ray.direction);
                return Ok(Hit { t_mm, normal: flip(by_column.cross(by_row).normalize()), part: 0 });
            }
        }
        Err(Fate::NotConverged)
    }

    /// Column and row where the designed ray nearest to `ray` meets the surface.
    fn start(&self, face: Face, ray: &Ray) -> DVec2 {
        let cloud = self.cloud;
        let camera = &cloud.camera;
        // The front is seen from the pinhole, the back from the virtual camera.
        let (eye, aside, depth) = match face {
            Face::Front => (DVec3::ZERO, camera.half_centre_mm, camera.front_mm.z),
            Face::Back => (camera.centre_mm, 0.0, camera.back_mm.z),
        };
        let point = ray.at((depth - ray.origin.z) / ray.direction.z) - eye;
        let offset_mm = point.truncate() / point.z * camera.focal_length_mm - DVec2::new(aside, 0.0);
        let first = DVec2::new(cloud.u_px[0], cloud.v_px[0]);
        (offset_mm / cloud.pitch_mm - first) / DVec2::from_array(cloud.spacing_px())
    }

    /// The point at a column and a row that need not be whole, and its derivatives by both.
    fn local(&self, face: Face, place: DVec2) -> Result<[DVec3; 3], Fate> {
        let size = [self.cloud.columns(), self.cloud.rows()];
        let last = DVec2::new((size[0] - 1) as f64, (size[1] - 1) as f64);
        if !(place.cmpge(DVec2::splat(-OVERHANG)).all() && place.cmple(last + OVERHANG).all()) {
            return Err(Fate::Missed);
        }
        // The place in the middle of its points, as far as the grid goes.
        let strides = self.strides;
        let first = [0, 1].map(|k| {
            let reach = (POINTS - 1) * strides[k];
            ((place[k] - 0.5 * reach as f64).round().max(0.0) as usize).min(size[k] - 1 - reach)
        });
        let [columns, rows] = [0, 1].map(|k| lagrange((place[k] - first[k] as f64) / strides[k] as f64));
        let mut sum = [DVec3::ZERO; 3];
        for (i, (column, by_column)) in columns.into_iter().enumerate() {
            for (j, (row, by_row)) in rows.into_iter().enumerate() {
                let point = self.cloud.at(first[0] + i * strides[0], first[1] + j * strides[1]);
                let point = match face {
                    Face::Front => point.front_mm,
                    Face::Back => point.back_mm,
                };
                sum[0] += point * (column * row);
                sum[1] += point * (by_column * row);
                sum[2] += point * (column * by_row);
            }
        }
        Ok([sum[0], sum[1] / strides[0] as f64, sum[2] / strides[1] as f64])
    }
}

/// The weights of values at 0, 1, .. in the polynomial through them at `t`, and in its derivative.
fn lagrange(t: f64) -> [(f64, f64); POINTS] {
    std::array::from_fn(|i| {
        let others = || (0..POINTS).filter(move |&k| k != i);
        let over: f64 = others().map(|k| i as f64 - k as f64).product();
        let value: f64 = others().map(|k| t - k as f64).product();
        let slope: f64 =
            others().map(|left_out| others().filter(|&k| k != left_out).map(|k| t - k as f64).product::<f64>()).sum();
        (value / over, slope / over)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_of_fifth_order_is_itself() {
        let f = |t: f64| 1.0 + t * (2.0 - t * (0.5 - t * (0.1 + t * (0.03 - 0.002 * t))));
        let slope = |t: f64| (f(t + 1e-6) - f(t - 1e-6)) / 2e-6;
        for t in [-1.3, 0.0, 2.5, 2.7, 5.0, 6.1] {
            let weights = lagrange(t);
            let value: f64 = weights.iter().enumerate().map(|(k, w)| w.0 * f(k as f64)).sum();
            let by: f64 = weights.iter().enumerate().map(|(k, w)| w.1 * f(k as f64)).sum();
            assert!((value - f(t)).abs() < 1e-12 && (by - slope(t)).abs() < 1e-7, "{t}");
        }
    }

    /// A ray from the pinhole meets the front at its own marched point, and one from the virtual camera the back.
    #[test]
    fn designed_rays_meet_the_marched_points() {
        let cloud = crate::design::freeform::tests::small_cloud();
        let marched = Marched::new(&cloud).unwrap();
        for point in cloud.points().step_by(7) {
            let front = Ray { origin: DVec3::ZERO, direction: point.front_mm.normalize() };
            let aim = point.back_mm - cloud.camera.centre_mm;
            let back = Ray { origin: cloud.camera.centre_mm, direction: aim.normalize() };
            for mirrored in [false, true] {
                for (face, ray, seen) in [(Face::Front, front, point.front_mm), (Face::Back, back, point.back_mm)] {
                    let flip = |v: DVec3| if mirrored { DVec3::new(-v.x, v.y, v.z) } else { v };
                    let ray = Ray { origin: flip(ray.origin), direction: flip(ray.direction) };
                    let met = marched.intersect(face, &ray, mirrored).unwrap();
                    assert!(ray.at(met.t_mm).distance(flip(seen)) < 1e-9, "{face:?} {mirrored}");
                    assert!((met.normal.length() - 1.0).abs() < 1e-12);
                }
            }
        }
        let beside = Ray { origin: DVec3::ZERO, direction: DVec3::new(-0.5, 0.0, 1.0).normalize() };
        assert_eq!(marched.intersect(Face::Front, &beside, false), Err(Fate::Missed));
    }
}
