//! A telecentric lens in place of the pinhole.

use glam::DVec2;
use std::f64::consts::TAU;

/// An ideal lens with its pupils at infinity on both sides: chief rays run along the axis before it and behind it, so that
/// a thing is shown equally large at every distance, and every image position receives light under the same angles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Telecentric {
    /// Size of an image over that of its object.
    pub magnification: f64,
    /// Numerical aperture on the side of the objects: sine of the half-angle of the cone that each image position sees.
    pub na: f64,
    /// Distance from the camera's position to the plane that the lens shows sharp where no glass is in between, in mm.
    pub focus_mm: f64,
}

impl Telecentric {
    /// A direction of the cone as its sines along x and y, for a point of the unit square: equal areas of the square are
    /// equal areas of sines, which the aperture of an aplanatic lens (the sine condition) receives alike.
    pub fn sines(&self, unit: DVec2) -> DVec2 {
        let (sin, cos) = libm::sincos(TAU * unit.y);
        self.na * unit.x.sqrt() * DVec2::new(cos, sin)
    }

    /// The tangents of a direction, dx/dz and dy/dz, by its sines.
    pub fn tangents(sines: DVec2) -> DVec2 {
        sines / (1.0 - sines.length_squared()).sqrt()
    }

    /// Diameter of the circle on the board at `depth_mm` that one image position sees, in air, in mm.
    pub fn blur_mm(&self, depth_mm: f64) -> f64 {
        2.0 * Self::tangents(DVec2::new(self.na, 0.0)).x * (depth_mm - self.focus_mm).abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cone_is_filled_to_its_numerical_aperture() {
        let lens = Telecentric { magnification: 0.55, na: 0.09, focus_mm: 200.0 };
        assert_eq!(lens.sines(DVec2::ZERO), DVec2::ZERO);
        let rim = Telecentric::tangents(lens.sines(DVec2::new(1.0, 0.3)));
        assert!((libm::sin(libm::atan(rim.length())) - 0.09).abs() < 1e-16);
        assert!((lens.blur_mm(300.0) - 200.0 * libm::tan(libm::asin(0.09))).abs() < 1e-13);
    }
}
