//! The texture of a board in place of its squares, as it is written, and what it comes to.

use super::document::Document;
use super::limits::{LONGEST_MM, PATH_CHARS, SEED, SHORTEST_MM};
use super::model::BoardSpec;
use super::source::ValueSource;
use super::surface_files::find;
use super::texture_spec::{ImageSpec, TextureSpec};
use crate::error::Error;
use crate::io::{self, CurveSource};
use crate::raster::transfer::Transfer;
use crate::texture::{MOST_TEXELS, TexelFilter};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::sync::Arc;

#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum TextureFile {
    BuiltIn(BuiltInFile),
    Table(TextureTable),
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum BuiltInFile {
    Noise,
    Chart,
}

/// A texture with its own keys.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TextureTable {
    /// File of a picture, relative to the scene file: PNG, OpenEXR, TIFF, JPEG, BMP or PNM, of at most 33554432 pixels. Its light,
    /// of colours the luminance, is `black` where it is 0 and `white` where it is 1. It is sRGB where the file does not say.
    #[schemars(length(min = 1, max = PATH_CHARS))]
    pub(super) image: Option<String>,
    /// Width of the picture on the board, in mm; its pixels are square, and its middle is that of the squares. Left out, it is as
    /// wide as they are.
    #[schemars(range(min = SHORTEST_MM, max = LONGEST_MM))]
    pub(super) width_mm: Option<f64>,
    /// Whether each pixel of the picture is a square of one value, or values are interpolated between their middles.
    pub(super) interpolation: Option<InterpolationFile>,
    /// What the program makes itself, in place of `image`: noise to match by, or Siemens stars and slanted squares by turns, one a
    /// square of the board.
    pub(super) pattern: Option<BuiltInFile>,
    /// Names the noise: another one for every seed.
    #[schemars(range(min = 0, max = SEED))]
    pub(super) seed: Option<u32>,
    /// The shortest wavelength of the noise, in mm; most of it is four to twenty times as coarse. Left out, it is a tenth of a
    /// square.
    #[schemars(range(min = SHORTEST_MM, max = LONGEST_MM))]
    pub(super) finest_mm: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum InterpolationFile {
    Nearest,
    Linear,
}

/// The texture that `file`, the key `key`, describes on `board`; a picture is looked for in `folder`.
pub(super) fn texture(
    document: &Document,
    key: &str,
    file: &TextureFile,
    board: &BoardSpec,
    folder: Option<&Path>,
) -> Result<TextureSpec, Error> {
    let table = match file {
        TextureFile::BuiltIn(pattern) => return built_in(document, key, *pattern, None, board),
        TextureFile::Table(table) => table,
    };

    // Tell the two kinds apart, and refuse the keys of the other.
    let of_image = [("width_mm", table.width_mm.is_some()), ("interpolation", table.interpolation.is_some())];
    let of_noise = [("seed", table.seed.is_some()), ("finest_mm", table.finest_mm.is_some())];
    let idle = |keys: [(&'static str, bool); 2], why: &str| match keys.into_iter().find(|(_, given)| *given) {
        None => Ok(()),
        Some((name, _)) => {
            let rule = format!("`{key}.{name}` says nothing of {why}");
            Err(document.refuse(&format!("{key}.{name}"), rule, "take the key out"))
        }
    };
    match (&table.image, table.pattern) {
        (Some(name), None) => {
            idle(of_noise, "a picture: it is a key of `pattern = \"noise\"`")?;
            image(document, key, (name, table), board, folder)
        }
        (None, Some(pattern)) => {
            idle(of_image, "a built-in pattern, which covers the area of the squares")?;
            if pattern == BuiltInFile::Chart {
                idle(of_noise, "a chart")?;
            }
            built_in(document, key, pattern, Some(table), board)
        }
        (both, _) => {
            let rule = match both {
                Some(_) => format!("`{key}` has both `image` and `pattern`"),
                None => format!("`{key}` has neither `image` nor `pattern`"),
            };
            Err(document.refuse(key, rule, "give one of the two: a picture's file, or \"noise\" or \"chart\""))
        }
    }
}

fn built_in(
    document: &Document,
    key: &str,
    pattern: BuiltInFile,
    table: Option<&TextureTable>,
    board: &BoardSpec,
) -> Result<TextureSpec, Error> {
    if pattern == BuiltInFile::Chart {
        return Ok(TextureSpec::Chart);
    }
    let finest_mm =
        table.and_then(|table| table.finest_mm).unwrap_or_else(|| TextureSpec::usual_finest_mm(board.square_mm));
    let noise = TextureSpec::Noise { seed: table.and_then(|table| table.seed).unwrap_or(0), finest_mm };
    texels(document, key, &noise, board).map(|()| noise)
}

/// Refuses a noise of more texels than a texture may have.
pub(super) fn texels(source: &dyn ValueSource, key: &str, spec: &TextureSpec, board: &BoardSpec) -> Result<(), Error> {
    let TextureSpec::Noise { finest_mm, .. } = spec else { return Ok(()) };
    let [columns, rows] = TextureSpec::noise_texels(board.squares_mm(), *finest_mm);
    if columns * rows <= MOST_TEXELS as f64 {
        return Ok(());
    }
    let least_mm = finest_mm * (columns * rows / MOST_TEXELS as f64).sqrt() * 1.001;
    let rule = format!(
        "`{key}` is a noise with wavelengths down to {finest_mm} mm on {} x {} mm, which takes {:.3e} texels; the limit is \
         {MOST_TEXELS}",
        board.squares_mm().x,
        board.squares_mm().y,
        columns * rows
    );
    let help = format!("give `finest_mm` of {least_mm:.3} or more, or a smaller board");
    Err(source.refuse(&format!("{key}.finest_mm"), rule, &help))
}

fn image(
    document: &Document,
    key: &str,
    (name, table): (&str, &TextureTable),
    board: &BoardSpec,
    folder: Option<&Path>,
) -> Result<TextureSpec, Error> {
    let at = format!("{key}.image");
    let path = find(document, &at, name, folder)?;
    let (stored, metadata) = io::read(&path, CurveSource::FileOrStored)?;
    if stored.data().len() > MOST_TEXELS {
        let rule = format!(
            "`{at}` is {name:?}, which has {} x {} pixels; the limit is {MOST_TEXELS} in all",
            stored.width(),
            stored.height()
        );
        return Err(document.refuse(&at, rule, "cut out the part that is meant, or take fewer pixels"));
    }
    // A file that says nothing of its curve is taken as most pictures are.
    let light = match metadata.is_as_stored() {
        true => io::read(&path, CurveSource::Forced(Transfer::Srgb))?.0,
        false => stored,
    };
    if let Some(k) = light.data().iter().position(|v| *v < 0.0) {
        let (i, j) = (k % light.width(), k / light.width());
        let rule =
            format!("`{at}` is {name:?}, whose pixel ({i}, {j}) is {}, and light is not below 0", light.data()[k]);
        return Err(document.refuse(&at, rule, "give a picture without negative values"));
    }
    Ok(TextureSpec::Image(ImageSpec {
        file: name.to_owned(),
        light: Arc::new(light),
        width_mm: table.width_mm.unwrap_or(board.squares_mm().x),
        filter: match table.interpolation {
            Some(InterpolationFile::Linear) => TexelFilter::Linear,
            Some(InterpolationFile::Nearest) | None => TexelFilter::Nearest,
        },
    }))
}
