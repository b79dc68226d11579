//! Corners as comma-separated values: a line that names the convention, a line with their count (which another program
//! may leave out), a line of column names, a line a corner.

use super::rules::{CENTRE, MOST_CORNERS, MOST_VIEWS, same_count, too_many};
use super::view::{CornerView, IndexOrigin, ListedCorner, Quality, polarity_name, polarity_of};
use crate::error::Error;
use glam::{DMat2, DVec2};
use std::fmt::Write;
use std::ops::Range;

/// What must be known of a corner.
const HEADER: &str = "half,column,row,x_px,y_px";
/// What may be known besides.
const QUALITY: &str = ",var_x_px2,cov_xy_px2,var_y_px2,contrast,residual,polarity";
/// Begins the line that names the convention.
const COMMENT: &str = "# pixel centre: ";
/// Begins the line that says what columns and rows count from.
const ORIGIN: &str = "# index origin: ";
/// Begins the line that says how many corners follow.
const COUNT: &str = "# corners: ";

pub(super) fn to_text(views: &[CornerView]) -> String {
    let full = views.iter().flat_map(|v| &v.corners).all(|c| c.quality.is_some());
    let count: usize = views.iter().map(|v| v.corners.len()).sum();
    let origin = IndexOrigin::of_all(views).map_or(String::new(), |origin| format!("{ORIGIN}{}\n", origin.name()));
    let mut text = format!("{COMMENT}{CENTRE}\n{origin}{COUNT}{count}\n{HEADER}{}\n", if full { QUALITY } else { "" });
    for (view, corner) in views.iter().flat_map(|v| v.corners.iter().map(move |c| (v, c))) {
        let p = corner.position_px;
        // Writing to a String cannot fail.
        let _ = write!(text, "{},{},{},{:?},{:?}", view.name, corner.index[0], corner.index[1], p.x, p.y);
        if let (true, Some(q)) = (full, &corner.quality) {
            let v = q.covariance_px2;
            let _ = write!(
                text,
                ",{:?},{:?},{:?},{:?},{:?},{}",
                v.x_axis.x,
                v.x_axis.y,
                v.y_axis.y,
                q.contrast,
                q.residual,
                polarity_name(q.polarity)
            );
        }
        text.push('\n');
    }
    text
}

/// A part of the text with its place in it.
struct CsvField<'a> {
    text: &'a str,
    span: Range<usize>,
}

struct Source<'a> {
    text: &'a str,
    place: &'a str,
}

impl Source<'_> {
    fn problem(&self, span: Range<usize>, rule: impl Into<String>, help: impl Into<String>) -> Error {
        Error::new(self.place, rule, help).at(self.text, span)
    }

    fn number<T: std::str::FromStr>(&self, field: &CsvField<'_>, name: &str, what: &str) -> Result<T, Error> {
        field.text.parse().map_err(|_| {
            self.problem(
                field.span.clone(),
                format!("`{name}` is {:?}, and must be {what}", field.text),
                "write the number with a point, without a unit",
            )
        })
    }
}

pub(super) fn parse(text: &str, place: &str) -> Result<Vec<CornerView>, Error> {
    let source = Source { text, place };
    let mut lines = lines(text);
    check_centre(&source, lines.next().unwrap_or(CsvField { text: "", span: 0..0 }))?;
    let end = || CsvField { text: "", span: text.len()..text.len() };
    let mut header = lines.next().unwrap_or_else(end);
    let index_origin = match header.text.strip_prefix(ORIGIN) {
        None => None,
        Some(name) => {
            let help = "write one of them, or leave the line out";
            let origin = IndexOrigin::of(name).map_err(|rule| source.problem(header.span.clone(), rule, help))?;
            header = lines.next().unwrap_or_else(end);
            Some(origin)
        }
    };
    let count = match header.text.strip_prefix(COUNT) {
        None => None,
        Some(digits) => {
            let count = CsvField { text: digits, span: header.span.clone() };
            let count = source.number::<usize>(&count, "corners", "a whole number from 0 on")?;
            header = lines.next().unwrap_or_else(end);
            Some(count)
        }
    };
    let full = header.text.strip_prefix(HEADER) == Some(QUALITY);
    if !full && header.text != HEADER {
        return Err(source.problem(
            header.span,
            format!(
                "the columns are {:?}, and must be \"{HEADER}\", all of \"{QUALITY}\" after them or none",
                header.text
            ),
            "name the columns in the line above the first corner, in this order",
        ));
    }
    let mut views: Vec<CornerView> = Vec::new();
    for (count, line) in lines.filter(|l| !l.text.is_empty()).enumerate() {
        if count == MOST_CORNERS {
            return Err(too_many(place));
        }
        let (name, corner) = corner(&source, &line, full)?;
        match views.iter().position(|v| v.name == name) {
            Some(k) => views[k].corners.push(corner),
            None if views.len() == MOST_VIEWS => {
                return Err(source.problem(
                    line.span,
                    format!("this is view number {}, and a file holds at most {MOST_VIEWS}", MOST_VIEWS + 1),
                    "give the corners of one picture",
                ));
            }
            None => views.push(CornerView { index_origin, ..CornerView::bare(name, vec![corner]) }),
        }
    }
    same_count(count, &views, place)?;
    if !text.ends_with('\n') {
        let last = text.rfind('\n').map_or(0, |k| k + 1);
        let rule = "the last line has no end, as that of a file that was cut has none";
        return Err(source.problem(last..text.len(), rule, "end it with a line break if the file is whole"));
    }
    Ok(views)
}

/// The first line must name the convention of the positions.
fn check_centre(source: &Source<'_>, first: CsvField<'_>) -> Result<(), Error> {
    let stated = first.text.strip_prefix(COMMENT);
    if stated != Some(CENTRE) {
        let rule = match stated {
            Some(other) => format!("the pixel centre is {other:?}, and must be {CENTRE:?}"),
            None => format!("the first line is {:?}, and must name where a pixel's centre lies", first.text),
        };
        let help = format!("begin the file with \"{COMMENT}{CENTRE}\", with positions in that convention");
        return Err(source.problem(first.span, rule, help));
    }
    Ok(())
}

/// The lines without their ends.
fn lines(text: &str) -> impl Iterator<Item = CsvField<'_>> {
    text.split_inclusive('\n').scan(0, |end, line| {
        let start = *end;
        *end += line.len();
        let text = line.trim_end_matches(['\n', '\r']);
        Some(CsvField { text, span: start..start + text.len() })
    })
}

fn corner(source: &Source<'_>, line: &CsvField<'_>, full: bool) -> Result<(String, ListedCorner), Error> {
    let mut start = line.span.start;
    let fields: Vec<CsvField<'_>> = line
        .text
        .split(',')
        .map(|text| {
            let span = start..start + text.len();
            start = span.end + 1;
            CsvField { text, span }
        })
        .collect();
    let wanted = if full { 11 } else { 5 };
    if fields.len() != wanted {
        return Err(source.problem(
            line.span.clone(),
            format!("the line has {} values, and must have {wanted}, as the columns are named", fields.len()),
            "write one value for each column, separated by commas",
        ));
    }
    let real = |k: usize, name: &str| source.number::<f64>(&fields[k], name, "a number");
    let whole = |k: usize, name: &str| source.number::<i32>(&fields[k], name, "a whole number");
    let quality = if full {
        let polarity = polarity_of(fields[10].text).ok_or_else(|| {
            source.problem(
                fields[10].span.clone(),
                format!("`polarity` is {:?}, and must be main or anti", fields[10].text),
                "say which diagonal of the corner is bright",
            )
        })?;
        let (xx, xy, yy) = (real(5, "var_x_px2")?, real(6, "cov_xy_px2")?, real(7, "var_y_px2")?);
        Some(Quality {
            covariance_px2: DMat2::from_cols_array(&[xx, xy, xy, yy]),
            contrast: real(8, "contrast")?,
            residual: real(9, "residual")?,
            polarity,
        })
    } else {
        None
    };
    let corner = ListedCorner {
        index: [whole(1, "column")?, whole(2, "row")?],
        position_px: DVec2::new(real(3, "x_px")?, real(4, "y_px")?),
        quality,
    };
    Ok((fields[0].text.to_owned(), corner))
}
