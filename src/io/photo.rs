//! Photographs: JPEG, BMP and PNM of other programs and cameras, through the `image` library, to linear light.

use super::metadata::{Metadata, checked_size};
use crate::error::Error;
use crate::raster::transfer::{Transfer, luminance};
use crate::raster::{MAX_PIXELS, MAX_SIDE_PX, Raster};
use image::{ColorType, DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use std::collections::BTreeMap;
use std::io::{BufRead, Seek};
use std::path::Path;

/// The format that a file's first bytes announce, if it is one of these.
pub(super) fn format(start: &[u8]) -> Option<ImageFormat> {
    let format = image::guess_format(start).ok()?;
    matches!(format, ImageFormat::Jpeg | ImageFormat::Bmp | ImageFormat::Pnm).then_some(format)
}

fn name(format: ImageFormat) -> &'static str {
    match format {
        ImageFormat::Jpeg => "JPEG",
        ImageFormat::Bmp => "BMP",
        _ => "PNM",
    }
}

/// The picture as linear light. None of these formats states its curve in a way that all programs keep, so the caller
/// must: sRGB for nearly every photograph.
pub(super) fn read_from(
    path: &Path,
    source: impl BufRead + Seek,
    format: ImageFormat,
    stated: Option<Transfer>,
) -> Result<(Raster<f32>, Metadata), Error> {
    let damaged = |error: image::ImageError| {
        let rule = format!("the {} cannot be read: {error}", name(format));
        Error::new(path.display(), rule, "check that the file is whole, or convert it to PNG")
    };
    let Some(transfer) = stated else {
        let rule = format!("a {} does not say how its values became of light", name(format));
        return Err(Error::new(path.display(), rule, "state it: --transfer srgb for a photograph, or linear"));
    };
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE_PX as u32);
    limits.max_image_height = Some(MAX_SIDE_PX as u32);
    // Four channels of two bytes.
    limits.max_alloc = Some(8 * MAX_PIXELS as u64);
    let mut reader = ImageReader::with_format(source, format);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(damaged)?;
    let size = decoder.dimensions();
    let (width, height) = checked_size(path, size.0 as usize, size.1 as usize)?;
    let colour = decoder.color_type();
    if colour.has_alpha() {
        let rule = "the picture has an opacity, which has no meaning for light";
        return Err(Error::new(path.display(), rule, "save it without opacity"));
    }
    let picture = DynamicImage::from_decoder(decoder).map_err(damaged)?;
    let light = |value: f32| transfer.decode(f64::from(value));
    let data = match picture {
        DynamicImage::ImageLuma8(_) | DynamicImage::ImageLuma16(_) => {
            picture.to_luma32f().into_raw().into_iter().map(|v| light(v) as f32).collect()
        }
        _ => {
            let mean = |p: &[f32; 3]| luminance(light(p[0]), light(p[1]), light(p[2])) as f32;
            picture.to_rgb32f().as_raw().as_chunks::<3>().0.iter().map(mean).collect()
        }
    };
    let metadata = Metadata {
        format: name(format),
        samples: format!("{} bit {}", 8 * colour.bytes_per_pixel() / colour.channel_count(), kind(colour)),
        transfer: transfer.name().to_owned(),
        transfer_source: "the caller".to_owned(),
        from_colour: colour.has_color(),
        pitch_mm: None,
        texts: BTreeMap::new(),
    };
    Ok((Raster::from_data(width, height, data), metadata))
}

fn kind(colour: ColorType) -> &'static str {
    if colour.has_color() { "RGB" } else { "grey" }
}
