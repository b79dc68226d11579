//! The model of a corner: two edges under a blur, in light that varies linearly.

use super::blur_shape::{BlurShape, moved_width_px};
use super::edge_spread::SHARP_PX;
use glam::DVec2;
use nalgebra::SVector;

/// Light, corner, directions, squares of the blurs: dE/ds = s E'' vanishes for a sharp picture, dE/ds^2 does not.
pub(super) const PARAMETERS: usize = 12;
/// How many of them are solved for when the blurs are held.
pub(super) const WITHOUT_BLUR: usize = 10;
/// How many of them are the light's.
pub(super) const LIGHT: usize = 6;
/// Where along an edge its turning is judged, in px from the corner.
pub(super) const ARM_PX: f64 = 10.0;

/// A model of a corner; positions from the window's centre.
#[derive(Debug, Clone, Copy)]
pub(super) struct Model {
    /// The corner, in px.
    pub(super) corner: DVec2,
    /// Angle of each edge's normal, in rad.
    pub(super) normal_rad: [f64; 2],
    /// Bend of each edge, in 1/px.
    pub(super) curvature: [f64; 2],
    /// Blur across each edge, in px.
    pub(super) sigma_px: [f64; 2],
    /// By how much the blurs across both edges go together, as a correlation, beyond those of a blur that is even all around: an
    /// elongated blur draws the crossing out along one diagonal.
    pub(super) skew: f64,
    /// What the blur is beside a Gaussian.
    pub(super) shapes: [BlurShape; 2],
    /// Half the way on which the picture moved under that blur, in px; 0 of none.
    pub(super) half_way_px: DVec2,
    /// By how many px each edge lies towards dark, both to one side: it is a step where the other one crosses it.
    pub(super) leans_px: [f64; 2],
    /// By what share of it this grows with each px along the edge.
    pub(super) lean_rates: [f64; 2],
    /// m0, mx, my, A0, Ax, Ay; with A0 = 0 a fit finds its own start.
    pub(super) light: [f64; LIGHT],
    /// Whether the light varies on the board, before the blur, or behind it.
    pub(super) light_is_blurred: bool,
}

impl Model {
    /// The unit normals of both edges.
    pub(super) fn normals(&self) -> [DVec2; 2] {
        self.normal_rad.map(|angle| {
            let (sin, cos) = libm::sincos(angle);
            DVec2::new(cos, sin)
        })
    }

    /// What each edge's lean adds to the distance from it on the positive side of the other edge, in px; behind that it is the
    /// opposite.
    pub(super) fn steps_px(&self) -> [f64; 2] {
        self.leans_px.map(|lean| if lean == 0.0 { 0.0 } else { lean * self.light[3].signum() })
    }

    /// The larger standard deviation of the whole blur across both edges, in px.
    pub(super) fn widest_px(&self) -> f64 {
        let normals = self.normals();
        let width = |k: usize| moved_width_px(self.sigma_px[k], self.half_way_px.dot(normals[k]));
        width(0).max(width(1))
    }

    /// The same model, with positions from its corner.
    pub(super) fn about_corner(&self) -> Self {
        let [m0, mx, my, a0, ax, ay] = self.light;
        let DVec2 { x, y } = self.corner;
        let light = [m0 + mx * x + my * y, mx, my, a0 + ax * x + ay * y, ax, ay];
        Self { corner: DVec2::ZERO, light, ..*self }
    }

    /// Adds a step, shortened where it would leave the range of the linear model; how far the corner moved, or an edge at
    /// [`ARM_PX`] from it, or how much a blur changed, in px.
    pub(super) fn advance(&mut self, step: &Right, effort: &Effort) -> f64 {
        self.light.iter_mut().zip(step.iter()).for_each(|(v, s)| *v += s);
        let shift = DVec2::new(step[6], step[7]).clamp_length_max(1.0);
        self.corner += shift;
        let mut moved = shift.length().max(ARM_PX * step[8].abs().max(step[9].abs()));
        for k in 0..2 {
            self.normal_rad[k] += step[8 + k].clamp(-0.2, 0.2);
            if effort.free_blur {
                let sigma = self.sigma_px[k];
                let square = sigma * sigma;
                let wanted = (square + step[10 + k].clamp(-0.9 * square, 3.0 * square + 0.01)).sqrt();
                self.sigma_px[k] = wanted.min(effort.most_sigma_px).max(SHARP_PX);
                moved = moved.max((self.sigma_px[k] - sigma).abs());
            }
        }
        moved
    }
}

/// What is solved for, and for how long.
#[derive(Debug, Clone, Copy)]
pub(super) struct Effort {
    /// Whether the two blurs are solved for.
    pub(super) free_blur: bool,
    /// Gauss-Newton steps at most.
    pub(super) steps: usize,
    /// Stop when a step of the corner, of the edges at [`ARM_PX`], and of free blurs is below this, in px.
    pub(super) tolerance_px: f64,
    /// The largest blur that is believed, in px.
    pub(super) most_sigma_px: f64,
}
pub(super) type Right = SVector<f64, PARAMETERS>;
