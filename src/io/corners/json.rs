//! Corners as JSON.

use super::rules::{CENTRE, MOST_CORNERS, MOST_VIEWS, broken, too_many};
use super::view::{
    BlurEllipse, CornerView, IndexOrigin, ListedCorner, Quality, TransferFound, polarity_name, polarity_of,
};
use crate::error::Error;
use glam::{DMat2, DVec2};
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::collections::BTreeMap;
use std::fmt;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    pixel_centre: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    index_origin: Option<String>,
    halves: Vec<ViewFile>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ViewFile {
    half: String,
    corners: Vec<Entry>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty", deserialize_with = "few_reasons")]
    rejected: BTreeMap<String, usize>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    blur_px: Option<[f64; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    elongated_blur: Option<BlurEllipse>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    lean_px: Option<f64>,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    marked_squares: bool,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    transfer: Option<TransferFound>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    index: [i32; 2],
    position_px: [f64; 2],
    #[serde(default, skip_serializing_if = "Option::is_none")]
    covariance_px2: Option<[[f64; 2]; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    contrast: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    residual: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    polarity: Option<String>,
}

/// Reasons for which corners of a view were turned down, at most.
const MOST_REASONS: usize = 1000;

/// The counts by reason, of which no more are taken than [`MOST_REASONS`].
fn few_reasons<'de, D: Deserializer<'de>>(deserializer: D) -> Result<BTreeMap<String, usize>, D::Error> {
    struct Reasons;
    impl<'de> Visitor<'de> for Reasons {
        type Value = BTreeMap<String, usize>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(f, "at most {MOST_REASONS} reasons with their counts")
        }

        fn visit_map<A: MapAccess<'de>>(self, mut access: A) -> Result<Self::Value, A::Error> {
            let mut found = BTreeMap::new();
            while let Some((reason, count)) = access.next_entry()? {
                found.insert(reason, count);
                if found.len() > MOST_REASONS {
                    return Err(serde::de::Error::invalid_length(found.len(), &self));
                }
            }
            Ok(found)
        }
    }
    deserializer.deserialize_map(Reasons)
}

pub(super) fn to_text(views: &[CornerView]) -> String {
    let entry = |c: &ListedCorner| Entry {
        index: c.index,
        position_px: c.position_px.to_array(),
        covariance_px2: c.quality.map(|q| q.covariance_px2.to_cols_array_2d()),
        contrast: c.quality.map(|q| q.contrast),
        residual: c.quality.map(|q| q.residual),
        polarity: c.quality.map(|q| polarity_name(q.polarity).to_owned()),
    };
    let half = |v: &CornerView| ViewFile {
        half: v.name.clone(),
        corners: v.corners.iter().map(entry).collect(),
        rejected: v.rejected.iter().cloned().collect(),
        blur_px: v.blur_px,
        elongated_blur: v.elongated_blur,
        lean_px: v.lean_px,
        marked_squares: v.marked_squares,
        transfer: v.transfer.clone(),
    };
    let file = File {
        pixel_centre: CENTRE.to_owned(),
        index_origin: IndexOrigin::of_all(views).map(|origin| origin.name().to_owned()),
        halves: views.iter().map(half).collect(),
    };
    let text = serde_json::to_string_pretty(&file).expect("names and numbers can be written as JSON");
    text + "\n"
}

pub(super) fn parse(text: &str, place: &str) -> Result<Vec<CornerView>, Error> {
    // A brace a corner, a view, its reasons, its blur and its curve, and the file: asked before there is memory for them.
    if text.bytes().filter(|&b| b == b'{').count() > MOST_CORNERS + 4 * MOST_VIEWS + 1 {
        return Err(too_many(place));
    }
    let file: File = serde_json::from_str(text).map_err(|error| {
        let line = text.split_inclusive('\n').take(error.line().saturating_sub(1)).map(str::len).sum::<usize>();
        // The byte that serde_json names may lie inside a letter.
        let boundary = |from: usize| (from..=text.len()).find(|&i| text.is_char_boundary(i)).unwrap_or(text.len());
        let at = boundary(line + error.column().saturating_sub(1));
        let end = boundary(at + 1);
        Error::new(
            place,
            format!("this is not the JSON of a corner file: {error}"),
            "compare the file with one that `biprism corners --json` writes",
        )
        .at(text, at..end)
    })?;
    if file.pixel_centre != CENTRE {
        return Err(Error::new(
            place,
            format!("`pixel_centre` is {:?}, and must be {CENTRE:?}", file.pixel_centre),
            "convert the positions to that convention, and say so",
        ));
    }
    if file.halves.iter().map(|h| h.corners.len()).sum::<usize>() > MOST_CORNERS {
        return Err(too_many(place));
    }
    let index_origin = file.index_origin.map(|name| IndexOrigin::of(&name)).transpose();
    let index_origin = index_origin.map_err(|rule| broken(place, rule))?;
    file.halves
        .into_iter()
        .map(|half| {
            let name = half.half;
            let corners = half.corners.into_iter().map(|e| listed(e, &name, place)).collect::<Result<_, _>>()?;
            Ok(CornerView {
                name,
                index_origin,
                corners,
                rejected: half.rejected.into_iter().collect(),
                blur_px: half.blur_px,
                elongated_blur: half.elongated_blur,
                lean_px: half.lean_px,
                marked_squares: half.marked_squares,
                transfer: half.transfer,
            })
        })
        .collect()
}

fn listed(entry: Entry, view: &str, place: &str) -> Result<ListedCorner, Error> {
    let [i, j] = entry.index;
    let at = format!("corner ({i}, {j}) of the view {view:?}");
    let quality = match (entry.covariance_px2, entry.contrast, entry.residual, entry.polarity) {
        (Some(covariance), Some(contrast), Some(residual), Some(polarity)) => {
            let polarity = polarity_of(&polarity).ok_or_else(|| {
                broken(place, format!("{at} has the polarity {polarity:?}, and must have main or anti"))
            })?;
            let covariance_px2 = DMat2::from_cols_array_2d(&covariance);
            Some(Quality { covariance_px2, contrast, residual, polarity })
        }
        (None, None, None, None) => None,
        _ => {
            let rule = "and must have all of covariance_px2, contrast, residual and polarity, or none";
            return Err(broken(place, format!("{at} has some, {rule}")));
        }
    };
    Ok(ListedCorner { index: entry.index, position_px: DVec2::from_array(entry.position_px), quality })
}
