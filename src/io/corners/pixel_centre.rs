//! Where the centre of a pixel lies, in our convention and in OpenCV's.

use glam::DVec2;

/// Where the centre of pixel (i, j) lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PixelCentre {
    /// At (i + 0.5, j + 0.5): ours.
    Half,
    /// At (i, j): OpenCV's.
    Whole,
}

/// A position in px given in one convention, in another.
pub fn move_centre(position_px: DVec2, from: PixelCentre, to: PixelCentre) -> DVec2 {
    match (from, to) {
        (PixelCentre::Half, PixelCentre::Whole) => position_px - 0.5,
        (PixelCentre::Whole, PixelCentre::Half) => position_px + 0.5,
        _ => position_px,
    }
}
