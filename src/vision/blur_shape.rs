//! The blur of a picture: a Gaussian across each family of edges, and what it is beside that.
//!
//! An edge shows of a blur only its spread across the edge, which for every blur that is alike to both sides is even. Any such
//! spread is told by weights of pairs of narrow bumps at the same distance to both sides,
//!
//! ```text
//! E(d) = E_s(d) + sum_j w_j ((E_b(d - x_j) + E_b(d + x_j)) / 2 - E_s(d))
//! ```
//!
//! with the response E_s of a pixel to an edge under the Gaussian (`edge_spread`), the same E_b under a bump, and x_j = j
//! spacings. E is odd whatever the weights are, so that they move no edge, and linear in them.
//!
//! Where light is clipped or a curve is not the picture's an edge is not alike to its bright and its dark side. With d towards
//! bright that adds
//!
//! ```text
//! sum_j u_j (E_b(d - x_j - 1 spacing) - E_b(d + x_j + 1 spacing)) / 2
//! ```
//!
//! which is even. Where another edge crosses it bright and dark change sides, so that the corner's two sides stay alike and it does
//! not move.

use glam::DVec2;

/// Pairs of bumps.
pub(super) const BUMPS: usize = 10;
/// Their spacing is this share of the Gaussian's standard deviation and at least so many px: a pixel shows nothing finer.
const SPACING: (f64, f64) = (0.45, 0.35);
/// The standard deviation of a bump, in spacings.
const WIDTH: f64 = 0.8;
/// A bump's tail beyond this many of its standard deviations is dropped.
const TAIL: f64 = 4.5;

/// Weights of the bumps of one family of edges; all 0 is the Gaussian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BlurShape {
    /// From bump to bump.
    pub(super) spacing_px: f64,
    pub(super) weights: [f64; BUMPS],
    /// Weights of the pairs that are not alike to both sides; all 0 where edges do not lean.
    pub(super) uneven: [f64; BUMPS],
}

/// The blur of a picture across both families of lines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PictureBlur {
    /// The standard deviations of the Gaussians, in px.
    pub(super) sigma_px: [f64; 2],
    /// What it is beside them.
    pub(super) shapes: [BlurShape; 2],
    /// Half the way on which the picture moved under that blur, in px; 0 of none.
    pub(super) half_way_px: DVec2,
}

impl PictureBlur {
    /// Gaussians of these standard deviations, in px.
    pub(super) fn gaussian(sigma_px: [f64; 2]) -> Self {
        Self { sigma_px, shapes: sigma_px.map(BlurShape::gaussian), half_way_px: DVec2::ZERO }
    }

    /// One Gaussian for both families of edges, of these unit normals, and motion by `half_way_px` to both sides.
    pub(super) fn moved(sigma_px: f64, half_way_px: DVec2, normals: [DVec2; 2]) -> Self {
        let shapes = normals.map(|n| BlurShape::gaussian(moved_width_px(sigma_px, n.dot(half_way_px))));
        Self { sigma_px: [sigma_px; 2], shapes, half_way_px }
    }

    /// Whether the picture moved.
    pub(super) fn is_moved(&self) -> bool {
        self.half_way_px != DVec2::ZERO
    }

    /// How both blurs go together beyond an even one, given that of Gaussians: motion holds it itself.
    pub(super) fn skew(&self, of_gaussians: f64) -> f64 {
        if self.is_moved() { 0.0 } else { of_gaussians }
    }

    /// The standard deviation of the whole across any edge, at most, in px.
    pub(super) fn widest_px(&self) -> f64 {
        moved_width_px(self.sigma_px[0].max(self.sigma_px[1]), self.half_way_px.length())
    }
}

/// The standard deviation of a Gaussian of this one after a motion by `way` to both sides.
pub(super) fn moved_width_px(sigma_px: f64, way: f64) -> f64 {
    if way == 0.0 { sigma_px } else { (sigma_px * sigma_px + way * way / 3.0).sqrt() }
}

impl BlurShape {
    /// No bumps beside a Gaussian of this standard deviation, in px.
    fn gaussian(sigma_px: f64) -> Self {
        Self { spacing_px: SPACING.1.max(SPACING.0 * sigma_px), weights: [0.0; BUMPS], uneven: [0.0; BUMPS] }
    }

    /// Whether there is nothing beside the Gaussian.
    pub(super) fn is_gaussian(&self) -> bool {
        self.weights == [0.0; BUMPS] && self.is_even()
    }

    /// Whether it is alike to both sides of an edge.
    pub(super) fn is_even(&self) -> bool {
        self.uneven == [0.0; BUMPS]
    }

    /// The standard deviation of a bump, in px.
    pub(super) fn bump_px(&self) -> f64 {
        WIDTH * self.spacing_px
    }

    /// Beyond this distance from an edge, in px, there is nothing of the last bump; 0 where there is none.
    pub(super) fn reach_px(&self) -> f64 {
        if self.is_gaussian() { 0.0 } else { self.most_reach_px(self.is_even()) }
    }

    /// The same for any weights: of bumps that are alike to both sides of an edge, or not.
    pub(super) fn most_reach_px(&self, even: bool) -> f64 {
        (BUMPS - usize::from(even)) as f64 * self.spacing_px + TAIL * self.bump_px()
    }
}
