//! A corner and the lattice around it: what a fit starts from.

use super::blur_shape::PictureBlur;
use super::candidates::Candidates;
use super::corner_model::Model;
use super::curvature::LatticeLine;
use super::edge_spread::EdgeShape;
use super::pixel_sums::WindowFrame;
use super::settings::UnevenLight;
use super::window::{Window, gather};
use glam::{DMat2, DVec2};

/// Half a window is at most so many px and so many blurs on the mean: its error under noise falls with the root of its size only, and
/// what it costs grows with the square.
const MOST_HALF_PX: f64 = 40.0;
const MOST_HALF_BLURS: f64 = 6.0;

/// The lattice around one corner.
#[derive(Debug, Clone, Copy)]
pub(super) struct CornerSite {
    pub(super) centre: DVec2,
    pub(super) steps: DMat2,
    pub(super) lines: [LatticeLine; 2],
    /// The light as the last fit found it, or zeros.
    pub(super) light: [f64; 6],
    /// By how many px the edges along both lines lie towards dark.
    pub(super) leans_px: [f64; 2],
    /// By what share of it this grows with each px along the line.
    pub(super) lean_rates: [f64; 2],
    /// By how much the blurs go together beyond an even blur's ([`Model::skew`]).
    pub(super) skew: f64,
    /// Whether the squares hold marks.
    pub(super) marked: bool,
    /// How far the corner would move when the new bends took the place of those that it was fitted with, in px, and its
    /// standard deviation; `None` where it was not fitted.
    pub(super) due_px: Option<[f64; 2]>,
}

impl CornerSite {
    pub(super) fn step_px(&self) -> f64 {
        self.steps.x_axis.length().min(self.steps.y_axis.length())
    }

    /// The same site under a blur of another [`Model::skew`].
    pub(super) fn skewed(&self, skew: f64) -> Self {
        Self { skew, ..*self }
    }

    /// Half the window, in steps: the share that is asked for, but no more px than are of use.
    pub(super) fn half(&self, share: f64, blur: &PictureBlur) -> f64 {
        let most_px = MOST_HALF_PX.max(MOST_HALF_BLURS * blur.widest_px());
        share.min(most_px / self.steps.determinant().abs().sqrt())
    }

    /// The unit normals of both lines.
    pub(super) fn normals(&self) -> [DVec2; 2] {
        self.lines.map(|l| DVec2::new(l.tangent.y, -l.tangent.x))
    }

    /// The cosine of both normals.
    pub(super) fn cosine(&self) -> f64 {
        self.normals()[0].dot(self.normals()[1])
    }

    /// The narrowest distance between parallel lines.
    pub(super) fn spacing_px(&self) -> f64 {
        self.steps.determinant().abs() / self.steps.x_axis.length().max(self.steps.y_axis.length())
    }

    pub(super) fn model(&self, blur: &PictureBlur, light: UnevenLight) -> Model {
        let normal = |line: &LatticeLine| libm::atan2(-line.tangent.x, line.tangent.y);
        Model {
            corner: DVec2::ZERO,
            normal_rad: [normal(&self.lines[0]), normal(&self.lines[1])],
            curvature: self.lines.map(|l| l.curvature),
            sigma_px: blur.sigma_px,
            shapes: blur.shapes,
            skew: blur.skew(self.skew),
            half_way_px: blur.half_way_px,
            leans_px: self.leans_px,
            lean_rates: self.lean_rates,
            light: self.light,
            light_is_blurred: light == UnevenLight::OnBoard,
        }
    }

    /// Its pixels in a frame; of squares with marks only those near the edges.
    pub(super) fn window(&self, candidates: &Candidates<'_>, frame: &WindowFrame) -> Window {
        let window = gather(candidates.image, candidates.valid.as_ref(), frame);
        if self.marked { window.near_edges() } else { window }
    }

    pub(super) fn frame(&self, blur: &PictureBlur, half: f64, margin_px: f64) -> WindowFrame {
        self.frame_reaching(blur, half, margin_px, blur.shapes.map(|shape| shape.reach_px()))
    }

    /// The frame of a window whose edges are seen so many px beside their Gaussians.
    pub(super) fn frame_reaching(
        &self,
        blur: &PictureBlur,
        half: f64,
        margin_px: f64,
        beside_px: [f64; 2],
    ) -> WindowFrame {
        let normals = self.normals();
        // The farthest point of the window, for the bend of the edges in it.
        let far = half * (self.steps.x_axis.abs() + self.steps.y_axis.abs()).length();
        let bands_px = [0, 1].map(|k| {
            let bend = 0.5 * self.lines[k].curvature.abs() * far * far;
            // A line without corners on both sides may point a few degrees off.
            let turn = if self.lines[k].corners < 3 { 0.15 * far } else { 0.0 };
            let reach = EdgeShape::moved(normals[k], blur.sigma_px[k], blur.half_way_px).reach_under(beside_px[k]);
            reach + bend + turn + self.leans_px[k].abs() + margin_px
        });
        WindowFrame { centre: self.centre, steps: self.steps, normals, bands_px, half }
    }
}
