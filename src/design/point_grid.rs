//! The point grid: points of both surfaces over a grid of pixel positions, the result of the march.

use super::designed_law::DesignedLaw;
use super::slope::optical_path_mm;
use super::virtual_camera::VirtualCamera;
use crate::geom::GridPoint;
use crate::scene::MarchOrder;
use glam::DVec3;
use rayon::prelude::*;

/// Where the ray of a pixel goes behind the prism, as if it came from O'.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum TargetLaw {
    /// As through a pinhole whose axis is parallel to that of the camera.
    Pinhole,
    /// The same but for a shift of each row: see [`super::revolved`].
    Rows,
    /// Along the direction before the prism, stretched along a unit vector.
    Stretched {
        /// That vector.
        axis: DVec3,
        /// How many times as long.
        by: f64,
    },
    /// By a law of its own.
    Designed(DesignedLaw),
}

impl TargetLaw {
    /// The direction, scaled to z = 1, of the pixel at (`u_mm`, `v_mm`) from the half image's centre.
    pub(super) fn direction(self, camera: &VirtualCamera, u_mm: f64, v_mm: f64) -> DVec3 {
        match self {
            Self::Pinhole => camera.virtual_direction(u_mm, v_mm),
            Self::Rows => {
                let tilt = libm::hypot(1.0, v_mm / camera.focal_length_mm);
                let kappa = camera.half_centre_mm * (tilt - 1.0);
                camera.virtual_direction(u_mm - kappa, v_mm)
            }
            Self::Stretched { axis, by } => {
                let before = camera.outer_direction(u_mm, v_mm);
                let behind = before + axis * ((by - 1.0) * before.dot(axis));
                behind / behind.z
            }
            Self::Designed(law) => {
                let [x, y] = law.direction(camera.half_centre_mm, [u_mm, v_mm]);
                DVec3::new(x, y, 1.0)
            }
        }
    }
}

/// The two surfaces of the right half (x > 0) on a grid of pixel positions: the point cloud of the paper.
#[derive(Debug, Clone, PartialEq)]
pub struct PointGrid {
    /// The camera that the grid belongs to.
    pub(super) camera: VirtualCamera,
    /// Side of a pixel.
    pub(super) pitch_mm: f64,
    /// Which march came first.
    pub(super) order: MarchOrder,
    /// Where its rays go.
    pub(super) law: TargetLaw,
    /// Columns, from the left, and rows, from the top.
    pub(super) u_px: Vec<f64>,
    pub(super) v_px: Vec<f64>,
    /// [p_z, p'_z] line after line; a line runs along the second march of `order`.
    pub(super) z_mm: Vec<[f64; 2]>,
}

impl PointGrid {
    /// Columns of the grid: an odd number, with the half image's centre in the middle.
    pub fn columns(&self) -> usize {
        self.u_px.len()
    }

    /// Rows of the grid, as [`PointGrid::columns`].
    pub fn rows(&self) -> usize {
        self.v_px.len()
    }

    /// Points of the grid.
    pub fn len(&self) -> usize {
        self.z_mm.len()
    }

    /// Whether the grid has no point, which [`crate::design::march::march`] never returns.
    pub fn is_empty(&self) -> bool {
        self.z_mm.is_empty()
    }

    /// Distance between neighbours of the grid along u and v, in px.
    pub fn spacing_px(&self) -> [f64; 2] {
        [self.u_px[1] - self.u_px[0], self.v_px[1] - self.v_px[0]]
    }

    /// The point of a column and a row.
    ///
    /// # Panics
    /// When the column or the row is outside the grid.
    pub fn at(&self, column: usize, row: usize) -> GridPoint {
        assert!(column < self.columns() && row < self.rows(), "({column}, {row}) is outside the grid");
        match self.order {
            MarchOrder::XThenY => self.nth(column * self.rows() + row),
            MarchOrder::YThenX => self.nth(row * self.columns() + column),
        }
    }

    /// Every point, row after row from the top, each from the left.
    pub fn points(&self) -> impl Iterator<Item = GridPoint> + '_ {
        (0..self.rows()).flat_map(move |row| (0..self.columns()).map(move |column| self.at(column, row)))
    }

    /// The points P of the front surface, in the order of the march.
    pub fn front_mm(&self) -> Vec<DVec3> {
        (0..self.len()).into_par_iter().map(|i| self.nth(i).front_mm).collect()
    }

    /// The points P' of the back surface, in the order of the march.
    pub fn back_mm(&self) -> Vec<DVec3> {
        (0..self.len()).into_par_iter().map(|i| self.nth(i).back_mm).collect()
    }

    /// Smallest and largest optical path |OP| + k |PP'| - |P'O'| over the grid, in mm. Exact slopes keep it constant, so
    /// the difference is the error of the integration.
    pub fn optical_path_range_mm(&self) -> [f64; 2] {
        (0..self.len())
            .into_par_iter()
            .map(|i| {
                let point = self.nth(i);
                let path = optical_path_mm(&self.camera, point.front_mm, point.back_mm);
                [path, path]
            })
            // Minimum and maximum do not depend on the order of the reduction.
            .reduce(|| [f64::INFINITY, f64::NEG_INFINITY], |a, b| [a[0].min(b[0]), a[1].max(b[1])])
    }

    /// What each point counts in a mean over the half image, in the order of the march: Simpson's rule in columns and rows, of
    /// which there are odd numbers, evenly apart. Their mean is 1.
    pub(super) fn weights(&self) -> Vec<f64> {
        let (across, along) = match self.order {
            MarchOrder::XThenY => (self.columns(), self.rows()),
            MarchOrder::YThenX => (self.rows(), self.columns()),
        };
        let along = simpson(along);
        simpson(across).into_iter().flat_map(|line| along.iter().map(move |point| line * point)).collect()
    }

    fn nth(&self, i: usize) -> GridPoint {
        let (column, row) = match self.order {
            MarchOrder::XThenY => (i / self.rows(), i % self.rows()),
            MarchOrder::YThenX => (i % self.columns(), i / self.columns()),
        };
        let (u_px, v_px) = (self.u_px[column], self.v_px[row]);
        let (u_mm, v_mm) = (u_px * self.pitch_mm, v_px * self.pitch_mm);
        let [front_z, back_z] = self.z_mm[i];
        let depth = back_z - self.camera.centre_mm.z;
        GridPoint {
            u_px,
            v_px,
            front_mm: self.camera.outer_direction(u_mm, v_mm) * front_z,
            back_mm: self.camera.centre_mm + self.law.direction(&self.camera, u_mm, v_mm) * depth,
        }
    }
}

/// The weights of Simpson's rule at an odd `count` of places evenly apart, of mean 1.
fn simpson(count: usize) -> Vec<f64> {
    let third = count as f64 / (3.0 * (count - 1) as f64);
    let weight = |k: usize| match k {
        0 => third,
        k if k + 1 == count => third,
        k => third * if k % 2 == 1 { 4.0 } else { 2.0 },
    };
    (0..count).map(weight).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Simpson's rule is exact to the third degree.
    #[test]
    fn the_weights_integrate_cubics() {
        for count in [3, 5, 11, 61] {
            let weights = simpson(count);
            for (power, mean) in [(0, 1.0), (1, 0.5), (2, 1.0 / 3.0), (3, 0.25)] {
                let value = |k: usize| (0..power).map(|_| k as f64 / (count - 1) as f64).product::<f64>();
                let found = weights.iter().enumerate().map(|(k, weight)| weight * value(k)).sum::<f64>() / count as f64;
                assert!((found - mean).abs() < 1e-14, "{count} places, power {power}: {found}");
            }
        }
    }
}
