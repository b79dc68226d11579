//! What a prism is meant to make of a camera: the table `[prism.law]` as written and as checked.

use super::limits::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the right half of the picture is meant to be, in the prism's frame with the camera's pinhole O at its origin; the left
/// half is its mirror image in x = 0.
///
/// A point (X, Y, Z) is seen at (u, v) from the middle of the half image: with (x, y, z) = (X, Y, Z) - O', turned by `tau_rad`
/// about y, v = f_y y/z and u = f_x x/z + c_x + kappa(v), where kappa(v) = `kappa_mm` (sqrt(1 + v^2/f_y^2) - 1). Without kappa
/// it is a pinhole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PrismLaw {
    /// Focal lengths f_x and f_y, in mm on the sensor.
    pub focal_mm: [f64; 2],
    /// c_x, where the axis of the virtual camera meets the image, from the middle of the half image, in mm.
    pub c_x_mm: f64,
    /// Distance of the two centres O', which lie at y = 0 and x = half of it, either way, in mm.
    pub baseline_mm: f64,
    /// z of the centres O', in mm.
    pub centre_z_mm: f64,
    /// Turn of the virtual camera's axis from +z towards +x, in rad.
    pub tau_rad: f64,
    /// The amplitude of kappa, in mm; 0 of a pinhole.
    pub kappa_mm: f64,
}

/// What the halves of the picture are meant to be. Figures called designed are taken against it; left out, that is a camera
/// parallel to the real one, of its focal length, beside it on the central ray of each half, or what `prism.design` aims at.
/// The right half is stated, in the prism's frame with the camera's pinhole at its origin; the left one is its mirror image.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct LawFile {
    /// Focal lengths [f_x, f_y] along x and along y, in mm on the sensor.
    #[schemars(inner(range(min = SHORTEST_MM, max = LONGEST_MM)))]
    pub(super) f_mm: [f64; 2],
    /// Where the axis of the virtual camera meets the image, right of the middle of the half image, in mm on the sensor.
    #[serde(default)]
    #[schemars(range(min = -LONGEST_MM, max = LONGEST_MM))]
    pub(super) c_x_mm: f64,
    /// Distance of the centres of the two virtual cameras, in mm.
    #[schemars(range(min = -LONGEST_MM, max = LONGEST_MM))]
    pub(super) baseline_mm: f64,
    /// z of the centres of the virtual cameras, in mm; 0 is beside the real camera.
    #[serde(default)]
    #[schemars(range(min = -LONGEST_MM, max = LONGEST_MM))]
    pub(super) centre_z_mm: f64,
    /// Turn of the axis of the right virtual camera from +z towards +x, in deg.
    #[serde(default)]
    #[schemars(range(min = -FACET_DEG, max = FACET_DEG))]
    pub(super) tau_deg: f64,
    /// The amplitude b of the shift of each row of the right half to the right, b (sqrt(1 + v^2/f_y^2) - 1) at the height v, in
    /// mm on the sensor: a quarter of the sensor's width for a prism whose epipolar lines are the rows; 0 where the virtual
    /// camera is a pinhole.
    #[serde(default)]
    #[schemars(range(min = -LONGEST_MM, max = LONGEST_MM))]
    pub(super) kappa_mm: f64,
}

impl From<LawFile> for PrismLaw {
    fn from(file: LawFile) -> Self {
        Self {
            focal_mm: file.f_mm,
            c_x_mm: file.c_x_mm,
            baseline_mm: file.baseline_mm,
            centre_z_mm: file.centre_z_mm,
            tau_rad: file.tau_deg.to_radians(),
            kappa_mm: file.kappa_mm,
        }
    }
}

impl PrismLaw {
    /// The values by their keys in a scene file, in its units and order, but for `f_mm`, which is [`PrismLaw::focal_mm`] and comes
    /// before them.
    pub fn keys(&self) -> [(&'static str, f64); 5] {
        [
            ("c_x_mm", self.c_x_mm),
            ("baseline_mm", self.baseline_mm),
            ("centre_z_mm", self.centre_z_mm),
            ("tau_deg", self.tau_rad.to_degrees()),
            ("kappa_mm", self.kappa_mm),
        ]
    }
}
