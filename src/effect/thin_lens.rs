//! A thin lens of finite aperture in place of the pinhole.

use glam::DVec2;
use std::f64::consts::TAU;

/// A thin lens at the place of the pinhole, in focus at one distance in air.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThinLens {
    /// Distance from the lens to the plane that it shows sharp where no glass is in between, in mm.
    pub focus_mm: f64,
    /// Focal length of the lens, in mm.
    pub focal_mm: f64,
    /// Radius of the aperture, in mm: that of its corners where it has some.
    pub radius_mm: f64,
    /// Shape of the aperture.
    pub aperture: Aperture,
}

/// The shape of an aperture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Aperture {
    /// A disk.
    Circle,
    /// A regular polygon.
    Polygon {
        /// Count of its sides, at least 3.
        blades: usize,
        /// Direction of its first corner, from +x to +y, in rad.
        rotation_rad: f64,
    },
}

impl Aperture {
    /// Into how many equal parts of a full turn it may be cut that are all alike: as few as that, but more than one.
    pub(super) fn turns(self) -> usize {
        match self {
            Self::Polygon { blades, .. } => (2..blades).find(|n| blades.is_multiple_of(*n)).unwrap_or(blades),
            Self::Circle => 2,
        }
    }

    /// Whether it is its own mirror image in the plane x = 0.
    pub(super) fn is_mirror_symmetric(self) -> bool {
        match self {
            // The mirror image of a corner at angle a is at pi - a.
            Self::Polygon { blades, rotation_rad } => {
                let steps = (0.5 * TAU - 2.0 * rotation_rad) * blades as f64 / TAU;
                (steps - steps.round()).abs() < 1e-9
            }
            Self::Circle => true,
        }
    }
}

impl ThinLens {
    /// The lens whose image of the plane at `focus_mm` lies `image_mm` behind it, with an aperture of 1 / `f_number` of its
    /// focal length: 1/f = 1/focus + 1/image.
    pub fn new(f_number: f64, focus_mm: f64, aperture: Aperture, image_mm: f64) -> Self {
        let focal_mm = 1.0 / (1.0 / focus_mm + 1.0 / image_mm);
        Self { focus_mm, focal_mm, radius_mm: 0.5 * focal_mm / f_number, aperture }
    }

    /// Whether it is a pinhole.
    pub fn is_nothing(&self) -> bool {
        self.radius_mm == 0.0
    }

    /// The point of the aperture that belongs to a point of the unit square, equal areas to equal areas, in mm.
    pub fn pupil_mm(&self, unit: DVec2) -> DVec2 {
        let radius = self.radius_mm * unit.x.sqrt();
        match self.aperture {
            Aperture::Circle => radius * direction(TAU * unit.y),
            // A triangle from the centre to each side: across it the square root keeps areas, along the side nothing
            // is needed.
            Aperture::Polygon { blades, rotation_rad } => {
                let along = unit.y * blades as f64;
                let corner = |k: f64| direction(rotation_rad + TAU * k / blades as f64);
                let side = along.floor();
                radius * corner(side).lerp(corner(side + 1.0), along - side)
            }
        }
    }

    /// Diameter of the blur circle of a point at `depth_mm` in air, on the sensor `image_mm` behind the lens, in mm:
    /// D image |1/focus - 1/depth|, for a circular aperture of diameter D.
    pub fn blur_mm(&self, depth_mm: f64, image_mm: f64) -> f64 {
        2.0 * self.radius_mm * image_mm * (1.0 / self.focus_mm - 1.0 / depth_mm).abs()
    }
}

fn direction(angle_rad: f64) -> DVec2 {
    let (sin, cos) = libm::sincos(angle_rad);
    DVec2::new(cos, sin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::effects::Effects;
    use crate::effect::{Lens, Quadrature};

    fn points(aperture: Aperture, n: usize) -> Vec<DVec2> {
        let lens = ThinLens { focus_mm: 1000.0, focal_mm: 35.0, radius_mm: 2.0, aperture };
        let quadrature = Quadrature { points: n, ..Quadrature::default() };
        let effects = Effects { lens: Lens::Thin(lens), quadrature, ..Effects::default() };
        effects.variants(0).iter().map(|variant| variant.pupil).collect()
    }

    /// The second moment about an axis: r^2 / 4 of a disk, r^2 (2 + cos(2 pi / n)) / 12 of a regular polygon of n sides
    /// with corners at r; the same about every axis.
    #[test]
    fn apertures_are_filled_evenly() {
        let hexagon = Aperture::Polygon { blades: 6, rotation_rad: 0.3 };
        let square = Aperture::Polygon { blades: 4, rotation_rad: 0.0 };
        let triangle = Aperture::Polygon { blades: 3, rotation_rad: 1.0 };
        let apertures = [(Aperture::Circle, 1.0), (hexagon, 2.5 / 3.0), (square, 2.0 / 3.0), (triangle, 0.5)];
        for (aperture, moment) in apertures {
            let points = points(aperture, 4096);
            let n = points.len();
            let mean = |f: &dyn Fn(&DVec2) -> f64| points.iter().map(f).sum::<f64>() / n as f64;
            // A set of n even points is off by some 1/n.
            let bound = 20.0 / n as f64;
            assert!(mean(&|p| p.x).abs() < bound && mean(&|p| p.y).abs() < bound, "{aperture:?}");
            assert!((mean(&|p| p.x * p.x) - moment).abs() < bound, "{aperture:?} {}", mean(&|p| p.x * p.x));
            assert!((mean(&|p| p.y * p.y) - moment).abs() < bound, "{aperture:?} {}", mean(&|p| p.y * p.y));
            assert!(mean(&|p| p.x * p.y).abs() < bound, "{aperture:?}");
            assert!(points.iter().all(|p| p.length() <= 2.0));
        }
    }

    #[test]
    fn the_lens_images_its_focus_plane_onto_the_sensor() {
        let lens = ThinLens::new(2.8, 700.0, Aperture::Circle, 35.0);
        assert!((lens.focal_mm - 700.0 * 35.0 / 735.0).abs() < 1e-13);
        assert_eq!(lens.blur_mm(700.0, 35.0), 0.0);
        assert!(ThinLens::new(f64::INFINITY, 700.0, Aperture::Circle, 35.0).is_nothing());
    }
}
