//! The prism as built: out of place, of another thickness and index, its surfaces out of figure.

use crate::geom::Pose;
use crate::surface::figure_error::FigureError;
use glam::DVec3;

/// Errors of a prism. The design, the angle of the facets included, is that of the ideal one.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Manufacture {
    /// Of the whole prism, about the middle of its front.
    pub prism: Displacement,
    /// Of the front, both facets, about its middle.
    pub front: SurfaceError,
    /// Of the back, about its middle.
    pub back: SurfaceError,
    /// What the glass is too thick by, in mm.
    pub thickness_mm: f64,
    /// What its refractive index is too large by.
    pub index: f64,
}

/// A displacement from the right place.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Displacement {
    /// Shift along the axes of the prism's frame, in mm.
    pub decentre_mm: DVec3,
    /// Turn about the fixed x, then y, then z axis, in rad.
    pub tilt_rad: DVec3,
}

/// Errors of a surface.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SurfaceError {
    /// Its place.
    pub place: Displacement,
    /// Its figure, in the frame of the prism.
    pub figure: Option<FigureError>,
}

impl Manufacture {
    /// Whether the prism is as it should be.
    pub fn is_nothing(&self) -> bool {
        let right = |error: &SurfaceError| {
            error.place.is_nothing() && error.figure.as_ref().is_none_or(FigureError::is_nothing)
        };
        self.prism.is_nothing()
            && right(&self.front)
            && right(&self.back)
            && self.thickness_mm == 0.0
            && self.index == 0.0
    }

    /// How far rays may stray on the surfaces, in mm, from where they meet those of the right prism, whose surfaces reach
    /// `reach_mm` from its axis, with a way of `way_mm` through the glass. Rays are taken to be less than 45 deg aslant.
    pub fn stray_mm(&self, reach_mm: f64, way_mm: f64) -> f64 {
        // A chord is no longer than the turn, nor than twice the arm; a turn of the front bends rays on their way as well.
        let moved = |place: &Displacement, arm_mm: f64| {
            place.decentre_mm.length() + arm_mm * place.tilt_rad.abs().element_sum().min(2.0)
        };
        moved(&self.prism, reach_mm + way_mm)
            + moved(&self.front.place, reach_mm + way_mm)
            + moved(&self.back.place, reach_mm)
            + self.thickness_mm.abs()
            + way_mm * self.index.abs()
    }
}

impl Displacement {
    /// Whether nothing is displaced.
    pub fn is_nothing(&self) -> bool {
        *self == Self::default()
    }

    /// The motion about `pivot_mm`.
    pub fn about(&self, pivot_mm: DVec3) -> Pose {
        let turn = Pose::new(DVec3::ZERO, self.tilt_rad);
        Pose { translation_mm: pivot_mm + self.decentre_mm - turn.vector(pivot_mm), ..turn }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_displacement_turns_about_its_pivot() {
        let pivot = DVec3::new(0.0, 0.0, 80.0);
        let moved = Displacement { decentre_mm: DVec3::new(0.1, 0.0, 0.0), tilt_rad: DVec3::new(0.0, 0.01, 0.0) };
        let pose = moved.about(pivot);
        assert!((pose.point(pivot) - (pivot + DVec3::new(0.1, 0.0, 0.0))).length() < 1e-13);
        // About +y, +x goes to -z.
        let end = pose.point(pivot + DVec3::X) - pose.point(pivot);
        assert!((end - DVec3::new(libm::cos(0.01), 0.0, -libm::sin(0.01))).length() < 1e-13);
        assert!(Manufacture::default().is_nothing());
        assert!(!Manufacture { prism: moved, ..Manufacture::default() }.is_nothing());
    }
}
