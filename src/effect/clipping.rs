//! What keeps rays from passing: the rim of the prism, a ridge that is not sharp, and a stop before the lens.

use crate::surface::face::Face;
use glam::{DVec2, DVec3};

/// Everything that clips rays. Light that meets it is lost.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Clipping {
    /// The rim of the prism, the same on front and back.
    pub outline: Option<Outline>,
    /// Width of the ground or bevelled strip in place of the ridge, across it, in mm.
    pub chamfer_mm: f64,
    /// A round opening before the camera, about its axis.
    pub stop: Option<Stop>,
}

/// The rim of a prism, about the z axis of its frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outline {
    /// A rectangle with its sides along x and y.
    Rectangle {
        /// Half its width and height, in mm.
        half_mm: DVec2,
    },
    /// A circle.
    Circle {
        /// Its radius, in mm.
        radius_mm: f64,
    },
}

/// A round opening.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    /// Distance along z from the camera's position, in mm.
    pub distance_mm: f64,
    /// Its radius, in mm.
    pub radius_mm: f64,
}

impl Clipping {
    /// Whether it lets everything pass.
    pub fn is_nothing(&self) -> bool {
        self.outline.is_none() && self.chamfer_mm == 0.0 && self.stop.is_none()
    }

    /// How far a point of the front or the back, in the prism's frame, is inside what lets light pass, in mm;
    /// negative outside.
    pub fn margin_mm(&self, face: Face, at_mm: DVec3) -> f64 {
        let inside = match self.outline {
            None => f64::INFINITY,
            Some(Outline::Rectangle { half_mm }) => (half_mm - at_mm.truncate().abs()).min_element(),
            Some(Outline::Circle { radius_mm }) => radius_mm - at_mm.truncate().length(),
        };
        if face == Face::Front && self.chamfer_mm > 0.0 {
            inside.min(at_mm.x.abs() - 0.5 * self.chamfer_mm)
        } else {
            inside
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn margins_are_distances_to_the_rim() {
        let rectangle = Some(Outline::Rectangle { half_mm: DVec2::new(10.0, 5.0) });
        let clipping = Clipping { outline: rectangle, chamfer_mm: 1.0, stop: None };
        assert_eq!(clipping.margin_mm(Face::Front, DVec3::new(3.0, 1.0, 80.0)), 2.5);
        assert_eq!(clipping.margin_mm(Face::Back, DVec3::new(3.0, 1.0, 80.0)), 4.0);
        assert_eq!(clipping.margin_mm(Face::Back, DVec3::new(-12.0, 1.0, 80.0)), -2.0);
        assert_eq!(clipping.margin_mm(Face::Front, DVec3::new(-0.25, 1.0, 80.0)), -0.25);
        let circle = Clipping { outline: Some(Outline::Circle { radius_mm: 5.0 }), ..Clipping::default() };
        assert_eq!(circle.margin_mm(Face::Front, DVec3::new(3.0, 4.0, 80.0)), 0.0);
        assert!(
            Clipping::default().is_nothing()
                && Clipping::default().margin_mm(Face::Front, DVec3::ZERO) == f64::INFINITY
        );
    }
}
