//! Corners as the YAML of OpenCV's `FileStorage`: for each view the matrices `<view>_corners` (two doubles a row, as
//! `calibrateCamera` takes them), `<view>_index`, and `<view>_quality` (variance of x, covariance, variance of y in px^2,
//! contrast, residual, polarity: 1 main, 0 anti).
//!
//! Read back: what is written here, and what OpenCV writes of the same matrices (numbers like `1.`, data over several
//! lines, single or double precision).

use super::pixel_centre::{PixelCentre, move_centre};
use super::rules::{HELP, MOST_CORNERS, OPENCV_CENTRE, broken, same_count, too_many};
use super::view::{CornerView, IndexOrigin, ListedCorner, Quality};
use crate::error::Error;
use crate::io::file_storage::{Entries, Fault, RawMatrix, YamlMap, number};
use crate::vision::Polarity;
use glam::{DMat2, DVec2};

const CENTRE_KEY: &str = "pixel_centre";
/// What indices count from; another program may leave it out.
const ORIGIN_KEY: &str = "index_origin";
/// How many corners all views have together; another program may leave it out.
const COUNT_KEY: &str = "corners";
/// Values of a row of `<view>_quality`.
const QUALITY: usize = 6;
/// Columns of a matrix, at most.
const MOST_COLUMNS: usize = 64;

pub(super) fn to_text(views: &[CornerView]) -> String {
    let count: usize = views.iter().map(|v| v.corners.len()).sum();
    // For every view or for none: a reader could not tell one that was lost from one that was not known.
    let full = views.iter().flat_map(|v| &v.corners).all(|c| c.quality.is_some());
    let mut map = YamlMap::default();
    map.string(CENTRE_KEY, OPENCV_CENTRE);
    if let Some(origin) = IndexOrigin::of_all(views) {
        map.string(ORIGIN_KEY, origin.name());
    }
    map.scalar(COUNT_KEY, &count.to_string());
    for view in views {
        let name = &view.name;
        let positions = view.corners.iter().map(|c| {
            let p = move_centre(c.position_px, PixelCentre::Half, PixelCentre::Whole);
            format!("{}, {}", number(p.x), number(p.y))
        });
        map.matrix(&format!("{name}_corners"), [view.corners.len(), 1], "2d", positions);
        let indices = view.corners.iter().map(|c| format!("{}, {}", c.index[0], c.index[1]));
        map.matrix(&format!("{name}_index"), [view.corners.len(), 1], "2i", indices);
        if full {
            let quality: Vec<Quality> = view.corners.iter().filter_map(|c| c.quality).collect();
            let rows = quality.iter().map(|q| {
                let v = q.covariance_px2;
                let main = f64::from(u8::from(q.polarity == Polarity::Main));
                let values: [f64; QUALITY] = [v.x_axis.x, v.x_axis.y, v.y_axis.y, q.contrast, q.residual, main];
                values.map(number).join(", ")
            });
            map.matrix(&format!("{name}_quality"), [quality.len(), 1], "6d", rows);
        }
    }
    map.file()
}

pub(super) fn parse(text: &str, place: &str) -> Result<Vec<CornerView>, Error> {
    let Entries { scalars, mut matrices } = Entries::of(text).map_err(|fault| fault.told(place, HELP))?;
    match scalars.get(CENTRE_KEY).map(|v| v.trim_matches('"')) {
        Some(OPENCV_CENTRE) => {}
        other => {
            let found = other.map_or("missing".to_owned(), |v| format!("{v:?}"));
            return Err(Error::new(
                place,
                format!("`{CENTRE_KEY}` is {found}, and must be {OPENCV_CENTRE:?}, OpenCV's own"),
                format!("add the line `{CENTRE_KEY}: \"{OPENCV_CENTRE}\"` if the positions come from OpenCV"),
            ));
        }
    }
    let names: Vec<String> =
        matrices.iter().filter_map(|matrix| Some(matrix.key.strip_suffix("_corners")?.to_owned())).collect();
    let stated = scalars.get(ORIGIN_KEY).map(|name| IndexOrigin::of(name.trim_matches('"')));
    let index_origin = stated.transpose().map_err(|rule| broken(place, rule))?;
    let with_origin = |name: String| Ok(CornerView { index_origin, ..view(name, &mut matrices, place)? });
    let views: Vec<CornerView> = names.into_iter().map(with_origin).collect::<Result<_, Error>>()?;
    // A file of our own that was cut at the end of a line may lack only the quality of its last view.
    let with_quality = |v: &&CornerView| v.corners.iter().any(|c| c.quality.is_some());
    let without = views.iter().find(|v| !v.corners.is_empty() && !with_quality(v));
    if let Some(view) = without.filter(|_| views.iter().any(|v| with_quality(&v))) {
        let rule = format!("`{}_quality` is missing, and must be there for each view or for none", view.name);
        return Err(broken(place, rule));
    }
    let count = match scalars.get(COUNT_KEY) {
        None => None,
        Some(digits) => Some(digits.parse().map_err(|_| {
            broken(place, format!("`{COUNT_KEY}` is {digits:?}, and must be a whole number from 0 on"))
        })?),
    };
    if views.is_empty() && count != Some(0) {
        return Err(broken(place, "no matrix is named `<view>_corners`, as in left_corners".to_owned()));
    }
    same_count(count, &views, place)?;
    Ok(views)
}

fn view(name: String, matrices: &mut Vec<RawMatrix>, place: &str) -> Result<CornerView, Error> {
    let mut take = |suffix: &str, channels: usize| -> Result<Option<Vec<f64>>, Error> {
        let key = format!("{name}_{suffix}");
        let Some(at) = matrices.iter().position(|matrix| matrix.key == key) else { return Ok(None) };
        values(&matrices.remove(at), channels, place).map(Some)
    };
    let missing =
        |suffix: &str| broken(place, format!("`{name}_{suffix}` is missing, and must be there for each view"));
    let corners = take("corners", 2)?.ok_or_else(|| missing("corners"))?;
    let index = take("index", 2)?.ok_or_else(|| missing("index"))?;
    let quality = take("quality", QUALITY)?;
    let count = corners.len() / 2;
    if index.len() / 2 != count || quality.as_ref().is_some_and(|q| q.len() / QUALITY != count) {
        let rule = format!("the matrices of the view {name:?} differ in rows, and must have one row a corner each");
        return Err(broken(place, rule));
    }
    let whole = |v: f64| {
        let i = v as i32;
        if f64::from(i) == v {
            Ok(i)
        } else {
            Err(broken(place, format!("an index is {v}, and must be a whole number")))
        }
    };
    let listed = (0..count).map(|k| {
        let quality = quality.as_ref().map(|q| {
            let q = &q[k * QUALITY..][..QUALITY];
            Quality {
                covariance_px2: DMat2::from_cols_array(&[q[0], q[1], q[1], q[2]]),
                contrast: q[3],
                residual: q[4],
                polarity: if q[5] == 0.0 { Polarity::Anti } else { Polarity::Main },
            }
        });
        let position = DVec2::new(corners[2 * k], corners[2 * k + 1]);
        Ok(ListedCorner {
            index: [whole(index[2 * k])?, whole(index[2 * k + 1])?],
            position_px: move_centre(position, PixelCentre::Whole, PixelCentre::Half),
            quality,
        })
    });
    Ok(CornerView::bare(name.clone(), listed.collect::<Result<_, _>>()?))
}

/// The values of a matrix of so many a row.
fn values(matrix: &RawMatrix, channels: usize, place: &str) -> Result<Vec<f64>, Error> {
    let told = |fault: Fault| fault.told(place, HELP);
    let size = matrix.size().map_err(told)?;
    let key = &matrix.key;
    if size.rows > MOST_CORNERS || size.columns > MOST_COLUMNS {
        return Err(matrix.fault(too_many(place).rule).told(place, "give the corners of one picture"));
    }
    if size.channels() != channels {
        let rule = format!("`{key}` has {} values a row, and must have {channels}", size.channels());
        return Err(matrix.fault(rule).told(place, HELP));
    }
    matrix.values(&size).map_err(told)
}
