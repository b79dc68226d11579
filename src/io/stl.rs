//! The facets of an STL file: ascii or binary.

use super::lines::TextLines;
use crate::error::Error;
use crate::surface::weld::weld;
use glam::DVec3;
use std::io::{BufRead, Read};

/// Bytes of the header of a binary file, and of the count of facets behind it.
const HEAD: usize = 84;
/// Bytes of a facet in a binary file: normal and three corners as f32, and two bytes that mean nothing.
const FACET: u64 = 50;
/// What to do about a file that is broken.
const AGAIN: &str = "export the body again as STL, binary or ascii";

/// The facets with corners at one place made one; facets without area, which exporters leave, are dropped.
pub(super) fn read<R: BufRead>(lines: TextLines<R>, bytes: u64) -> Result<(Vec<DVec3>, Vec<[u32; 3]>), Error> {
    let TextLines { name, mut input, limit, .. } = lines;
    let mut head = Vec::new();
    let unreadable =
        |e: std::io::Error| Error::new(name, format!("cannot be read: {e}"), "check the file and its disk");
    (&mut input).take(HEAD as u64).read_to_end(&mut head).map_err(unreadable)?;
    let count = head.get(HEAD - 4..).and_then(|c| c.try_into().ok()).map_or(0, |c| u64::from(u32::from_le_bytes(c)));
    // Some binary files begin with the word of the ascii ones, so that their length decides, or bytes that no text has.
    let no_text = |b: &u8| (b.is_ascii_control() && !b.is_ascii_whitespace()) || *b >= 0xf8;
    let is_text = head.trim_ascii_start().starts_with(b"solid")
        && bytes != HEAD as u64 + FACET * count
        && !head.iter().any(no_text);
    let corners = if is_text {
        let input = std::io::Cursor::new(head).chain(input);
        text(TextLines { name, input, line: 0, taken: 0, limit })?
    } else {
        if head.len() < HEAD || count * FACET > bytes.saturating_sub(HEAD as u64) {
            let rule = format!("{count} facets need {} bytes, and the file has {bytes}", HEAD as u64 + FACET * count);
            return Err(Error::new(name, rule, AGAIN));
        }
        if count > limit {
            let rule = format!("the file has {count} facets, and the limit is {limit}");
            return Err(Error::new(name, rule, "thin the mesh out: a smooth surface needs far fewer"));
        }
        binary(name, input, count)?
    };
    Ok(weld(&corners))
}

/// The corners of all facets, three after three.
fn binary(name: &str, mut input: impl Read, count: u64) -> Result<Vec<DVec3>, Error> {
    let mut corners = Vec::with_capacity(3 * count as usize);
    let mut facet = [0; FACET as usize];
    for i in 1..=count {
        input
            .read_exact(&mut facet)
            .map_err(|e| Error::new(name, format!("facet {i} of {count} cannot be read: {e}"), AGAIN))?;
        let number = |k: usize| f32::from_le_bytes([facet[k], facet[k + 1], facet[k + 2], facet[k + 3]]);
        for corner in 1..4 {
            let at = [0, 1, 2].map(|axis| f64::from(number(12 * corner + 4 * axis)));
            if !at.iter().all(|v| v.is_finite()) {
                let rule = format!("corner {corner} of facet {i} is {at:?}, and must be finite");
                return Err(Error::new(name, rule, AGAIN));
            }
            corners.push(DVec3::from_array(at));
        }
    }
    Ok(corners)
}

/// The corners of all facets, three after three.
fn text<R: BufRead>(mut lines: TextLines<R>) -> Result<Vec<DVec3>, Error> {
    let (mut corners, mut buffer) = (Vec::new(), Vec::new());
    let mut ended = false;
    while let Some(line) = lines.next(&mut buffer)? {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("vertex") => {
                let mut axis = |name: &str| {
                    let word = words.next().ok_or_else(|| {
                        lines.problem(format!("the vertex has no {name}"), "write `vertex x y z` for every corner")
                    })?;
                    lines.number(name, word)
                };
                corners.push(DVec3::new(axis("x")?, axis("y")?, axis("z")?));
                if corners.len() as u64 > 3 * lines.limit {
                    let rule = format!("the file has more than {} facets, which is the limit", lines.limit);
                    return Err(lines.problem(rule, "thin the mesh out: a smooth surface needs far fewer"));
                }
            }
            Some("endloop") if corners.len() % 3 != 0 || corners.is_empty() => {
                return Err(lines.problem("the facet has not three corners", AGAIN));
            }
            Some("endsolid") => ended = true,
            Some("solid" | "facet" | "outer" | "endloop" | "endfacet") | None => {}
            Some(word) => {
                let rule = format!("the line begins with {:?}, which an STL file does not have", short(word));
                return Err(lines.problem(rule, AGAIN));
            }
        }
    }
    if !ended || corners.len() % 3 != 0 {
        return Err(lines.problem("the file ends before `endsolid`", AGAIN));
    }
    Ok(corners)
}

/// The first characters of a word.
fn short(word: &str) -> String {
    word.chars().take(20).collect()
}
