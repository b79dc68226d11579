//! Height fields: surfaces as heights over a plane, and the intersection with those that are moved or have a figure
//! error.

use super::hit::Hit;
use super::polynomial::{MAX_STEPS, is_met};
use super::shape::Surface;
use crate::geom::{Pose, Ray};
use crate::num::poly2::Jet;
use crate::optics::fate::Fate;
use glam::{DVec2, DVec3};

/// From where a vertical ray starts towards a surface, in mm.
const FAR_BELOW_MM: f64 = -1e6;

impl Surface {
    /// This surface, moved from the frame in which it is given; `a_from_b` leads from there to where it is.
    #[must_use]
    pub fn moved(self, a_from_b: Pose) -> Self {
        Self::Moved { base: Box::new(self), poses: Box::new([a_from_b, a_from_b.inverse()]) }
    }

    /// z over (x, y), in mm, wherever the surface is given; 0 where it is not.
    pub fn height_mm(&self, x: f64, y: f64) -> f64 {
        let below = Ray { origin: DVec3::new(x, y, FAR_BELOW_MM), direction: DVec3::Z };
        let met = || self.intersect(&below, f64::INFINITY).map_or(0.0, |met| below.at(met.t_mm).z);
        self.jet(x, y).map_or_else(met, |jet| jet.value)
    }

    /// z over (x, y), in mm; beyond where the surface is given it goes on as straight as it ends there. `None` beside triangles, and of
    /// what is moved or out of figure.
    pub fn continued_mm(&self, x: f64, y: f64) -> Option<f64> {
        match self {
            Self::Plane { .. } => self.jet(x, y).map(|jet| jet.value),
            Self::Freeform(sheet) => {
                let domain = sheet.domain();
                let at = DVec2::new(if sheet.is_mirrored() { -x } else { x }, y);
                let end = at.clamp(domain.min, domain.max);
                let (z, dx, dy) = sheet.sag().gradient(end.x, end.y);
                Some(z + DVec2::new(dx, dy).dot(at - end))
            }
            Self::Revolved(part) => part.continued_mm(x, y),
            Self::Mesh { mesh, mirrored } => mesh.height_mm(if *mirrored { -x } else { x }, y),
            Self::Flawed { .. } | Self::Moved { .. } => None,
        }
    }

    /// z over (x, y) with its derivatives; `None` of surfaces that are not smooth heights over their frame, and beside a part of a
    /// surface of revolution.
    pub fn jet(&self, x: f64, y: f64) -> Option<Jet> {
        match self {
            Self::Plane { point, normal } => {
                let slope = -normal.truncate() / normal.z;
                let value = point.z + slope.dot(DVec2::new(x, y) - point.truncate());
                Some(Jet { value, dx: slope.x, dy: slope.y, dxx: 0.0, dxy: 0.0, dyy: 0.0 })
            }
            Self::Freeform(sheet) if sheet.is_mirrored() => {
                let jet = sheet.sag().jet(-x, y);
                Some(Jet { dx: -jet.dx, dxy: -jet.dxy, ..jet })
            }
            Self::Freeform(sheet) => Some(sheet.sag().jet(x, y)),
            Self::Flawed { base, flaw } => {
                let (a, b) = (base.jet(x, y)?, flaw.jet(x, y));
                Some(Jet {
                    value: a.value + b.value,
                    dx: a.dx + b.dx,
                    dy: a.dy + b.dy,
                    dxx: a.dxx + b.dxx,
                    dxy: a.dxy + b.dxy,
                    dyy: a.dyy + b.dyy,
                })
            }
            Self::Revolved(part) => part.jet_over(x, y),
            Self::Mesh { .. } | Self::Moved { .. } => None,
        }
    }

    /// Where a ray meets a surface out of figure: Newton's method on the height, from where the ray meets `base`, the
    /// surface as it should be.
    pub(super) fn intersect_by_height(&self, base: &Self, ray: &Ray, residual_mm: f64) -> Result<Hit, Fate> {
        let mut t = base.intersect(ray, residual_mm)?.t_mm;
        let mut previous = f64::INFINITY;
        for _ in 0..MAX_STEPS {
            let p = ray.at(t);
            let jet = self.jet(p.x, p.y).ok_or(Fate::Missed)?;
            let gap = p.z - jet.value;
            let step = gap / (ray.direction.z - jet.dx * ray.direction.x - jet.dy * ray.direction.y);
            if is_met(ray, t, p.z, gap, previous, residual_mm) {
                let t_mm = t - step;
                let normal = DVec3::new(-jet.dx, -jet.dy, 1.0).normalize();
                return if t_mm > 0.0 && t_mm.is_finite() {
                    Ok(Hit { t_mm, normal, part: 0 })
                } else {
                    Err(Fate::Missed)
                };
            }
            previous = gap.abs();
            t -= step;
        }
        Err(Fate::NotConverged)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Rect;
    use crate::num::poly2::Poly2;
    use crate::surface::figure_error::{FigureError, SurfaceWave, zernike};
    use crate::surface::shape::{PolynomialPatch, PolynomialSurface};
    use std::sync::Arc;

    fn sheet(mirrored: bool) -> Surface {
        let sag = Poly2::new(3, [6.0, 0.0], [6.0, 6.0], |m, n| match (m, n) {
            (0, 0) => 80.0,
            (1, 0) => 0.9,
            (2, 1) => 0.02,
            (0, 2) => 0.01,
            _ => 0.0,
        });
        let domain = Rect { min: DVec2::new(-2.0, -9.0), max: DVec2::new(14.0, 9.0) };
        Surface::Freeform(PolynomialSurface::new(&PolynomialPatch { sag, domain }, mirrored))
    }

    fn flawed(base: Surface) -> Surface {
        let sag = zernike(12.0, &[(2, 2, 2e-3), (3, -1, 1e-3)]).expect("terms");
        let waves = vec![SurfaceWave { amplitude_mm: 5e-4, rad_per_mm: DVec2::new(1.5, 0.7), phase_rad: 0.3 }];
        Surface::Flawed { base: Box::new(base), flaw: Arc::new(FigureError { sag, waves }) }
    }

    /// A ray that is met lies on the height there, and the normal is that of the height.
    #[test]
    fn flawed_surfaces_are_met_on_their_height() {
        for mirrored in [false, true] {
            let sign = if mirrored { -1.0 } else { 1.0 };
            let surface = flawed(sheet(mirrored));
            let mut met_count = 0;
            for k in 0..20 {
                let direction =
                    DVec3::new(sign * 0.1 * libm::sin(k as f64) + sign * 0.05, 0.05 * libm::cos(2.0 * k as f64), 1.0);
                let ray = Ray { origin: DVec3::new(sign * 0.5, 0.2, 1.0), direction: direction.normalize() };
                let Ok(met) = surface.intersect(&ray, 1e-12) else { continue };
                met_count += 1;
                let p = ray.at(met.t_mm);
                assert!((surface.height_mm(p.x, p.y) - p.z).abs() < 1e-12, "{k}");
                let h = 1e-5;
                let slope = DVec2::new(
                    surface.height_mm(p.x + h, p.y) - surface.height_mm(p.x - h, p.y),
                    surface.height_mm(p.x, p.y + h) - surface.height_mm(p.x, p.y - h),
                ) / (2.0 * h);
                // Rounding of 80 mm over 2e-5 mm.
                assert!((met.normal.truncate() / met.normal.z + slope).length() < 2e-9, "{k}");
            }
            // The sheet ends at x = -2, and three of the rays lean farther.
            assert_eq!(met_count, 17);
        }
    }

    /// A surface and its ray moved together meet where they did.
    #[test]
    fn moved_surfaces_are_met_where_they_are() {
        let pose = Pose::new(DVec3::new(0.3, -0.2, 1.0), DVec3::new(0.05, -0.1, 0.2));
        let ray = Ray { origin: DVec3::new(0.5, 0.2, 1.0), direction: DVec3::new(0.06, 0.02, 1.0).normalize() };
        let step = DVec3::new(0.1, -0.3, 0.02);
        for base in [sheet(false), flawed(sheet(false)), Surface::Plane { point: DVec3::Z * 80.0, normal: DVec3::Z }] {
            let met = base.intersect(&ray, 1e-12).expect("it is there");
            let turn = base.normal_change(&met, ray.at(met.t_mm), met.normal, step);
            let moved = base.clone().moved(pose);
            let there = ray.moved(&pose);
            let again = moved.intersect(&there, 1e-12).expect("it is there too");
            assert!((again.t_mm - met.t_mm).abs() < 1e-11);
            assert!((again.normal - pose.vector(met.normal)).length() < 1e-13);
            assert!((moved.tangent(&again) - pose.vector(base.tangent(&met))).length() < 1e-13);
            let turned = moved.normal_change(&again, there.at(again.t_mm), again.normal, pose.vector(step));
            assert!((turned - pose.vector(turn)).length() < 1e-13);
        }
    }

    /// How the normal turns along the surface, against the normals of two places.
    #[test]
    fn normals_of_flawed_surfaces_turn_by_their_second_derivatives() {
        let surface = flawed(sheet(true));
        let at = |x: f64, y: f64| {
            let ray = Ray { origin: DVec3::new(x, y, 0.0), direction: DVec3::Z };
            (ray, surface.intersect(&ray, 1e-13).expect("it is over the domain"))
        };
        let ((ray, here), h) = (at(-5.0, 1.0), 1e-5);
        let (_, a) = at(-5.0 + 0.6 * h, 1.0 - 0.8 * h);
        let (_, b) = at(-5.0 - 0.6 * h, 1.0 + 0.8 * h);
        let found = surface.normal_change(&here, ray.at(here.t_mm), here.normal, DVec3::new(0.6, -0.8, 0.0));
        assert!((found - (a.normal - b.normal) / (2.0 * h)).length() < 1e-9, "{found}");
    }
}
