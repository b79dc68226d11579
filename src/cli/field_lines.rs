//! Lines of fields between commas, in a file or from standard input.

use super::files;
use crate::error::Error;
use crate::io::inputs;
use std::fmt::{Display, Formatter};
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

/// Which line of which file.
#[derive(Debug, Clone, Copy)]
pub(super) struct LinePlace<'a> {
    file: &'a str,
    number: usize,
}

impl Display for LinePlace<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}", self.file, self.number)
    }
}

/// Longest line that is read, in bytes.
const MAX_LINE: u64 = 4096;

/// Calls `use_line` with the place and the fields of each line of the file at `path`, or of standard input, that is neither blank, a
/// comment nor the heading, whose first column is one of `headings`.
///
/// # Errors
/// A file that cannot be read or is no text, a line that is too long, and what `use_line` refuses.
pub(super) fn each_line(
    path: &Path,
    headings: &[&str],
    mut use_line: impl FnMut(LinePlace<'_>, &[&str]) -> Result<(), Error>,
) -> Result<(), Error> {
    let name = files::shown(path);
    let unreadable =
        |e: std::io::Error| Error::new(&name, format!("cannot be read: {e}"), "check the path and its permissions");
    let mut input: Box<dyn BufRead> = if files::is_stdin(path) {
        Box::new(BufReader::new(std::io::stdin()))
    } else {
        Box::new(BufReader::new(inputs::open(path).map_err(unreadable)?))
    };
    let mut line = Vec::new();
    for number in 1.. {
        line.clear();
        let read = (&mut input).take(MAX_LINE).read_until(b'\n', &mut line).map_err(unreadable)?;
        let place = LinePlace { file: &name, number };
        if read == 0 {
            return Ok(());
        }
        if read as u64 == MAX_LINE {
            let rule = format!("the line has {MAX_LINE} bytes or more, and must have fewer");
            return Err(Error::new(place, rule, "give one point a line"));
        }
        let text = str::from_utf8(&line).map_err(|_| inputs::not_utf8(place, &line))?;
        let text = text.trim().trim_start_matches('\u{feff}');
        let fields: Vec<&str> = text.split(',').map(str::trim).collect();
        let heading = number == 1 && headings.contains(&fields[0]);
        if !(text.is_empty() || text.starts_with('#') || heading) {
            use_line(place, &fields)?;
        }
    }
    Ok(())
}

/// The field as a finite number.
pub(super) fn number(place: LinePlace<'_>, name: &str, field: &str) -> Result<f64, Error> {
    field.parse().ok().filter(|v: &f64| v.is_finite()).ok_or_else(|| {
        Error::new(place, format!("`{name}` is {field:?}, and must be a finite number"), "write it as 960.5")
    })
}
