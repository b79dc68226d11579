//! What a pixel without blur sees of two edges that cross in it.

use super::profile::Profile;
use glam::DVec2;

/// Half of what a pixel reaches over along a direction, in px.
#[inline(always)]
pub(super) fn half_extent(normal: DVec2) -> f64 {
    0.5 * (normal.x.abs() + normal.y.abs())
}

/// For sharp edges: the mean of the product over the pixel, less the product of the means.
pub(super) fn excess(normals: [DVec2; 2], distances: [f64; 2]) -> f64 {
    let beyond = |k: usize| distances[k].abs() >= half_extent(normals[k]);
    if beyond(0) || beyond(1) {
        return 0.0;
    }
    let share = |k: usize| 0.5 * (Profile::sharp(normals[k], distances[k]) + 1.0);
    4.0 * (common_area(normals, distances) - share(0) * share(1))
}

/// The area of the unit square around the origin where n.r + d > 0 for both edges.
fn common_area(normals: [DVec2; 2], distances: [f64; 2]) -> f64 {
    // Start from the unit square: each half-plane cuts at most one vertex more into a convex polygon.
    let mut polygon = [DVec2::ZERO; 8];
    let corners = [DVec2::new(-0.5, -0.5), DVec2::new(0.5, -0.5), DVec2::new(0.5, 0.5), DVec2::new(-0.5, 0.5)];
    polygon[..4].copy_from_slice(&corners);
    let mut count = 4;

    // Clip the polygon to each half-plane (Sutherland & Hodgman 1974).
    for (normal, distance) in normals.into_iter().zip(distances) {
        let source = polygon;
        let mut kept = 0;
        for k in 0..count {
            let (p, q) = (source[k], source[(k + 1) % count]);
            let (dp, dq) = (normal.dot(p) + distance, normal.dot(q) + distance);
            if dp > 0.0 {
                polygon[kept] = p;
                kept += 1;
            }
            if (dp > 0.0) != (dq > 0.0) {
                polygon[kept] = p.lerp(q, dp / (dp - dq));
                kept += 1;
            }
        }
        count = kept;
    }

    // Sum up its area.
    let twice: f64 = (0..count).map(|k| polygon[k].perp_dot(polygon[(k + 1) % count])).sum();
    0.5 * twice
}
