//! A line reader that knows its line number.

use super::inputs::not_utf8;
use crate::error::Error;
use glam::DVec3;
use std::fmt::Display;
use std::io::{BufRead, Read};

/// Longest line of a text, and of a header, in bytes.
pub(super) const MAX_LINE: u64 = 4096;

/// A text read line by line, which knows where it is.
pub(super) struct TextLines<'a, R> {
    /// The file, in messages.
    pub(super) name: &'a str,
    /// What has not been read yet.
    pub(super) input: R,
    /// The line read last, from 1.
    pub(super) line: usize,
    /// Bytes of the lines read.
    pub(super) taken: u64,
    /// Most points.
    pub(super) limit: u64,
}

impl<R: BufRead> TextLines<'_, R> {
    /// The next line without its end, in `buffer`; `None` at the end of the input.
    pub(super) fn next<'b>(&mut self, buffer: &'b mut Vec<u8>) -> Result<Option<&'b str>, Error> {
        buffer.clear();
        self.line += 1;
        let read = (&mut self.input).take(MAX_LINE).read_until(b'\n', buffer);
        let read =
            read.map_err(|e| self.problem(format!("cannot be read: {e}"), "check the file and its disk"))? as u64;
        self.taken += read;
        if read == 0 {
            return Ok(None);
        }
        if read == MAX_LINE && buffer.last() != Some(&b'\n') {
            return Err(self.problem(
                format!("the line has {MAX_LINE} bytes or more, and must have fewer"),
                "check that the file is a text of one point a line, and that its lines end with LF or CR LF",
            ));
        }
        let text =
            std::str::from_utf8(buffer).map_err(|_| not_utf8(format_args!("{}:{}", self.name, self.line), buffer))?;
        Ok(Some(text.trim_end().trim_start_matches('\u{feff}')))
    }

    /// A problem at the line read last.
    pub(super) fn problem(&self, rule: impl Into<String>, help: impl Into<String>) -> Error {
        Error::new(format_args!("{}:{}", self.name, self.line), rule, help)
    }

    /// `value` as a finite number; `what` names it.
    pub(super) fn number(&self, what: impl Display, value: &str) -> Result<f64, Error> {
        value.parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(|| {
            self.problem(format!("{what} is {value:?}, and must be a finite number"), "correct or remove the line")
        })
    }

    /// One more point, within the limit.
    pub(super) fn push(&self, points: &mut Vec<DVec3>, point: DVec3) -> Result<(), Error> {
        if points.len() as u64 == self.limit {
            return Err(self.problem(
                format!("the file has more than {} points, which is the limit", self.limit),
                "thin the cloud out: a surface of some dozen coefficients needs far fewer",
            ));
        }
        points.push(point);
        Ok(())
    }
}
