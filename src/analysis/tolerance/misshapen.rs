//! Surfaces out of shape: another radius of curvature, another angle.

use crate::geom::Pose;
use crate::num::poly2::Poly2;
use crate::surface::mesh::Triangles;
use crate::surface::shape::{PolynomialPatch, RevolvedPatch, RevolvedSurface, Surface};
use glam::DVec3;

/// The surface with a mean radius of curvature at its centre that is `change_mm` larger; the paraboloid that makes the difference
/// is added about that centre.
pub(super) fn with_radius(patch: &PolynomialPatch, change_mm: f64) -> PolynomialPatch {
    let [x0, y0] = patch.sag.centre();
    let mean = mean_curvature(patch);
    let bend = if mean == 0.0 { 0.0 } else { 1.0 / (1.0 / mean + change_mm) - mean };
    let [sx, sy] = patch.sag.scale();
    let degree = patch.sag.degree().max(2);
    let old: Vec<(usize, usize, f64)> = patch.sag.terms().collect();
    let sag = Poly2::new(degree, [x0, y0], [sx, sy], |m, n| {
        let own = old.iter().find(|term| (term.0, term.1) == (m, n)).map_or(0.0, |term| term.2);
        own + match (m, n) {
            (2, 0) => 0.5 * bend * sx * sx,
            (0, 2) => 0.5 * bend * sy * sy,
            _ => 0.0,
        }
    });
    PolynomialPatch { sag, domain: patch.domain }
}

/// Half the sum of the second derivatives of z by x and y at the centre, in 1/mm: the curvature of the paraboloid that follows the
/// surface there.
fn mean_curvature(patch: &PolynomialPatch) -> f64 {
    let [x0, y0] = patch.sag.centre();
    let jet = patch.sag.jet(x0, y0);
    0.5 * (jet.dxx + jet.dyy)
}

/// The facet turned by `angle_rad` about the ridge x = 0 in small angles: its slope along x is that of an angle larger by so much at the
/// centre.
pub(super) fn steeper(patch: &PolynomialPatch, angle_rad: f64) -> PolynomialPatch {
    let ([x0, y0], [sx, sy]) = (patch.sag.centre(), patch.sag.scale());
    let slope = patch.sag.jet(x0, y0).dx;
    let more = libm::tan(libm::atan(slope) + angle_rad) - slope;
    let old: Vec<(usize, usize, f64)> = patch.sag.terms().collect();
    let sag = Poly2::new(patch.sag.degree().max(1), [x0, y0], [sx, sy], |m, n| {
        let own = old.iter().find(|term| (term.0, term.1) == (m, n)).map_or(0.0, |term| term.2);
        own + match (m, n) {
            (0, 0) => more * x0,
            (1, 0) => more * sx,
            _ => 0.0,
        }
    });
    PolynomialPatch { sag, domain: patch.domain }
}

/// The part of a surface of revolution turned by `angle_rad` about the line along y in which it meets x = 0, so that it is steeper.
pub(super) fn turned_patch(patch: &RevolvedPatch, angle_rad: f64) -> RevolvedPatch {
    let surface = Surface::Revolved(Box::new(RevolvedSurface::new(patch, false)));
    let ridge = DVec3::new(0.0, 0.0, surface.continued_mm(0.0, 0.0).unwrap_or_else(|| surface.height_mm(0.0, 0.0)));
    let turn = about(ridge, angle_rad);
    RevolvedPatch { point_mm: turn.point(patch.point_mm), axis: turn.vector(patch.axis), ..patch.clone() }
}

/// Triangles turned by `angle_rad` about the line along y through the corner that is nearest to x = 0, so that a right half is steeper.
pub(super) fn turned_triangles(triangles: &Triangles, angle_rad: f64) -> Triangles {
    let nearest = triangles.points_mm.iter().min_by(|a, b| a.x.abs().total_cmp(&b.x.abs()));
    let turn = about(nearest.map_or(DVec3::ZERO, |p| DVec3::new(0.0, 0.0, p.z)), angle_rad);
    Triangles {
        points_mm: triangles.points_mm.iter().map(|p| turn.point(*p)).collect(),
        point_normals: triangles.point_normals.iter().map(|n| turn.vector(*n)).collect(),
        triangles: triangles.triangles.clone(),
    }
}

/// The turn about the line along y through `point_mm` by which z grows with x.
fn about(point_mm: DVec3, angle_rad: f64) -> Pose {
    let turn = Pose::new(DVec3::ZERO, DVec3::new(0.0, -angle_rad, 0.0));
    Pose { translation_mm: point_mm - turn.vector(point_mm), ..turn }
}
