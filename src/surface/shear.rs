//! The watertight test of a ray and a triangle (Woop, Benthin & Wald, "Watertight Ray/Triangle Intersection", 2013).

use glam::DVec3;

/// The axes of the watertight test: the one along which the ray runs most comes last.
pub(super) struct ShearAxes {
    order: [usize; 3],
    /// Shears that bring the ray onto its last axis.
    shear: DVec3,
}

impl ShearAxes {
    pub(super) fn new(direction: DVec3) -> Self {
        let d = direction.to_array();
        let last = (0..3).max_by(|&i, &k| d[i].abs().total_cmp(&d[k].abs())).unwrap_or(2);
        let order = [(last + 1) % 3, (last + 2) % 3, last];
        let shear = DVec3::new(d[order[0]] / d[last], d[order[1]] / d[last], 1.0 / d[last]);
        Self { order, shear }
    }

    /// Distance, and the weights of the corners, where the ray from `origin` meets the triangle, on its border included.
    #[inline]
    pub(super) fn intersect(&self, origin: DVec3, corners: [DVec3; 3]) -> Option<(f64, [f64; 3])> {
        let [i, j, k] = self.order;
        let q = corners.map(|p| {
            let v = (p - origin).to_array();
            [v[i] - self.shear.x * v[k], v[j] - self.shear.y * v[k], self.shear.z * v[k]]
        });
        let u = q[2][0] * q[1][1] - q[2][1] * q[1][0];
        let v = q[0][0] * q[2][1] - q[0][1] * q[2][0];
        let w = q[1][0] * q[0][1] - q[1][1] * q[0][0];
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let sum = u + v + w;
        if sum == 0.0 {
            return None;
        }
        Some(((u * q[0][2] + v * q[1][2] + w * q[2][2]) / sum, [u / sum, v / sum, w / sum]))
    }
}
