//! Small 8-bit pictures as the bytes of a file that stands inside another one, such as a page.

use super::png::srgb_levels16;
use crate::raster::Raster;
use ::png::{BitDepth, ColorType, Compression, Encoder, EncodingError, Filter, SrgbRenderingIntent};
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder};

/// Linear light, 0 black to 1 white and clamped to that, as the nearest 8-bit levels of sRGB; what is not a number is black.
pub(crate) fn srgb8(light: &Raster<f32>) -> Raster<u8> {
    let levels = srgb_levels16(light.data());
    let eight = |pair: &[u8]| (u32::from(u16::from_be_bytes([pair[0], pair[1]])) * 255 + 32767) / 65535;
    let data = levels.chunks_exact(2).map(|pair| eight(pair) as u8).collect();
    Raster::from_data(light.width(), light.height(), data)
}

/// The bytes of a PNG of grey levels of sRGB; `None` of a picture without pixels, or of too many for the format.
pub(crate) fn png_bytes(grey: &Raster<u8>) -> Option<Vec<u8>> {
    // Much of a picture of a board is of two levels in runs, and each row like the one above.
    encoded([grey.width(), grey.height()], ColorType::Grayscale, Filter::Up, grey.data())
}

/// The same of red, green and blue.
pub(crate) fn rgb_png_bytes(colours: &Raster<[u8; 3]>) -> Option<Vec<u8>> {
    // A figure is of a few colours in runs, which differences between pixels would break.
    let data = colours.data().as_flattened();
    encoded([colours.width(), colours.height()], ColorType::Rgb, Filter::NoFilter, data)
}

fn encoded(size_px: [usize; 2], color: ColorType, filter: Filter, samples: &[u8]) -> Option<Vec<u8>> {
    let [Ok(width), Ok(height)] = size_px.map(u32::try_from) else { return None };
    let mut bytes = Vec::new();
    let mut encode = || -> Result<(), EncodingError> {
        let mut encoder = Encoder::new(&mut bytes, width, height);
        encoder.set_color(color);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_compression(Compression::Balanced);
        encoder.set_filter(filter);
        encoder.set_source_srgb(SrgbRenderingIntent::RelativeColorimetric);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(samples)?;
        writer.finish()
    };
    encode().ok()?;
    Some(bytes)
}

/// The bytes of a JPEG of grey levels of sRGB, with a loss that `quality` (1 to 100) tells; `None` of a picture that the format
/// does not hold.
pub(crate) fn jpeg_bytes(grey: &Raster<u8>, quality: u8) -> Option<Vec<u8>> {
    let size = [grey.width(), grey.height()].map(u32::try_from);
    let [Ok(width), Ok(height)] = size else { return None };
    let mut bytes = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut bytes, quality);
    encoder.write_image(grey.data(), width, height, ExtendedColorType::L8).ok()?;
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_those_of_srgb_and_a_png_holds_them() {
        let light = Raster::from_data(3, 2, vec![0.0, 1.0, 0.5, 0.215_861, f32::NAN, 2.0]);
        let grey = srgb8(&light);
        assert_eq!(grey.data(), [0, 255, 188, 128, 0, 255]);
        let bytes = png_bytes(&grey).unwrap();
        let mut reader = ::png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
        let mut back = vec![0; 6];
        reader.next_frame(&mut back).unwrap();
        assert_eq!(back, grey.data());
        assert!(png_bytes(&Raster::from_data(0, 0, Vec::new())).is_none());
    }

    #[test]
    fn a_jpeg_loses_less_at_a_higher_quality() {
        let noisy =
            Raster::from_data(64, 64, (0..4096u32).map(|k| (k.wrapping_mul(2_654_435_761) >> 24) as u8).collect());
        let of = |quality: u8| {
            let bytes = jpeg_bytes(&noisy, quality).unwrap();
            let back = image::load_from_memory_with_format(&bytes, image::ImageFormat::Jpeg).unwrap().into_luma8();
            let off = |(a, b): (&u8, &u8)| f64::from(a.abs_diff(*b));
            (bytes.len(), back.as_raw().iter().zip(noisy.data()).map(off).sum::<f64>() / 4096.0)
        };
        let [coarse, fine] = [of(30), of(95)];
        assert!(coarse.0 < fine.0 && fine.1 < 4.0 && coarse.1 > 2.0 * fine.1, "{coarse:?} {fine:?}");
    }
}
