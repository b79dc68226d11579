//! Pictures inside a page.

use crate::io::embedded_picture::{jpeg_bytes, png_bytes, srgb8};
use crate::plot::picture;
use crate::raster::Raster;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;

/// Bytes that the pictures of a page take together at most, before they are written as text, which takes a third more.
const BUDGET: usize = 900_000;
/// Pixels of a picture of a page at most.
const MOST_PIXELS: usize = 8_000_000;
/// Qualities of JPEG that are tried where a picture without loss is too large, best first.
const QUALITIES: [u8; 5] = [95, 88, 78, 65, 45];

/// A picture inside a page.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub(super) struct PictureData {
    /// The file, as an address.
    address: String,
    /// The quality where it is a JPEG; otherwise every 8-bit level is right.
    jpeg_quality: Option<u8>,
    /// Pixels that are drawn as one, along each side.
    step: usize,
}

/// `light` (linear, 1 is white) as 8-bit sRGB, one picture of `count` in its page; `None` of one without pixels.
pub(super) fn picture_data(light: &Raster<f32>, count: usize) -> Option<PictureData> {
    let pixels = light.width() * light.height();
    if pixels == 0 {
        return None;
    }
    let first = (1..).find(|step| pixels / (step * step) <= MOST_PIXELS)?;
    // Take the best quality that fits, and fewer pixels where none does.
    (first..).find_map(|step| {
        let small = light.width() / step < 2 || light.height() / step < 2;
        attempt(light, step, BUDGET / count.max(1))
            .or_else(|| small.then(|| attempt(light, step, usize::MAX)).flatten())
    })
}

/// The picture with `step` x `step` pixels as one, where some quality takes no more than `most` bytes.
fn attempt(light: &Raster<f32>, step: usize, most: usize) -> Option<PictureData> {
    let reduced =
        (step > 1).then(|| picture::area_averaged(light, light.width().div_ceil(step), light.height().div_ceil(step)));
    let levels = srgb8(reduced.as_ref().unwrap_or(light));
    let address = |kind: &str, bytes: &[u8]| format!("data:image/{kind};base64,{}", STANDARD.encode(bytes));
    let whole = png_bytes(&levels)?;
    if whole.len() <= most {
        return Some(PictureData { address: address("png", &whole), jpeg_quality: None, step });
    }
    QUALITIES.into_iter().find_map(|quality| {
        let bytes = jpeg_bytes(&levels, quality)?;
        let fits = bytes.len() <= most;
        fits.then(|| PictureData { address: address("jpeg", &bytes), jpeg_quality: Some(quality), step })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_board_is_kept_without_loss_and_noise_within_the_budget() {
        let board = Raster::from_data(400, 300, (0..120_000).map(|k| f32::from(u8::from(k / 20 % 2 == 0))).collect());
        let kept = picture_data(&board, 3).unwrap();
        assert!(kept.jpeg_quality.is_none() && kept.address.starts_with("data:image/png;base64,iVBOR"));
        let noise = |k: u32| {
            let mixed = (k ^ (k >> 7)).wrapping_mul(2_654_435_761);
            ((mixed ^ (mixed >> 15)).wrapping_mul(2_246_822_519) >> 8) as f32 / 16_777_216.0
        };
        let noisy = Raster::from_data(1920, 1080, (0..1920 * 1080).map(noise).collect());
        let squeezed = picture_data(&noisy, 3).unwrap();
        assert!(squeezed.jpeg_quality.is_some() && squeezed.address.len() < BUDGET / 2, "{}", squeezed.address.len());
        let eighth = picture_data(&noisy, 8).unwrap();
        assert!(eighth.step > 1 && eighth.address.len() < BUDGET / 5, "{}", eighth.address.len());
        assert!(picture_data(&Raster::from_data(0, 0, Vec::new()), 1).is_none());
    }
}
