//! Tables of records, and planes of f32, to NPY files, format 1.0 of NumPy: a header that is a Python dictionary, then the values, little-endian.

use super::atomic::write_atomically;
use crate::error::Error;
use crate::raster::Raster;
use std::io::{self, Write};
use std::path::Path;

/// The first bytes of every NPY file of format 1.0.
const MAGIC: [u8; 8] = *b"\x93NUMPY\x01\x00";

/// The records begin at a multiple of this many bytes.
const ALIGNMENT: usize = 64;

/// A field of a record, packed behind the one before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NpyField {
    /// So many f64; of one a plain number.
    F64(&'static str, usize),
    /// One u32.
    U32(&'static str),
}

impl NpyField {
    /// Its bytes in a record.
    pub const fn bytes(self) -> usize {
        match self {
            Self::F64(_, count) => 8 * count,
            Self::U32(_) => 4,
        }
    }

    /// As NumPy describes it.
    fn described(self) -> String {
        match self {
            Self::F64(name, 1) => format!("('{name}', '<f8')"),
            Self::F64(name, count) => format!("('{name}', '<f8', ({count},))"),
            Self::U32(name) => format!("('{name}', '<u4')"),
        }
    }
}

/// The header of an array of records of this shape.
fn header(fields: &[NpyField], shape: &[usize]) -> Vec<u8> {
    let fields: Vec<String> = fields.iter().map(|field| field.described()).collect();
    header_of(&format!("[{}]", fields.join(", ")), shape)
}

/// The header of an array of this shape whose values are described so.
fn header_of(described: &str, shape: &[usize]) -> Vec<u8> {
    let sizes: Vec<String> = shape.iter().map(ToString::to_string).collect();
    // A tuple of one has a comma behind it.
    let sizes = sizes.join(", ") + if shape.len() == 1 { "," } else { "" };
    let text = format!("{{'descr': {described}, 'fortran_order': False, 'shape': ({sizes}), }}");
    // The magic bytes, the length in two bytes, the text, blanks, and a line's end.
    let whole = (MAGIC.len() + 2 + text.len() + 1).next_multiple_of(ALIGNMENT);
    let length = u16::try_from(whole - MAGIC.len() - 2).expect("a dictionary of a few fields");
    let mut bytes = MAGIC.to_vec();
    bytes.extend(length.to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes.resize(whole - 1, b' ');
    bytes.push(b'\n');
    bytes
}

/// Writes an array of records of this `shape`, (rows, columns) or as many as there are, which come in `parts`, one behind the other,
/// row by row. It is never held
/// as a whole.
///
/// # Errors
/// Those of [`write_atomically`], and parts that are not the whole table.
pub(crate) fn write_parts(
    path: &Path,
    fields: &[NpyField],
    shape: &[usize],
    parts: impl Iterator<Item = Vec<u8>>,
) -> Result<(), Error> {
    let record: usize = fields.iter().map(|field| field.bytes()).sum();
    write_atomically(path, |out| {
        out.write_all(&header(fields, shape))?;
        let mut left = record * shape.iter().product::<usize>();
        for part in parts {
            left = left.checked_sub(part.len()).ok_or_else(|| io::Error::other("more records than the table has"))?;
            out.write_all(&part)?;
        }
        if left == 0 { Ok(()) } else { Err(io::Error::other("the records end before the table")) }
    })
}

/// Writes a plane as an array of f32 of its rows and columns.
///
/// # Errors
/// Those of [`write_atomically`].
pub(crate) fn write_plane(path: &Path, plane: &Raster<f32>) -> Result<(), Error> {
    write_atomically(path, |out| {
        out.write_all(&header_of("'<f4'", &[plane.height(), plane.width()]))?;
        (0..plane.height()).try_for_each(|j| {
            let row: Vec<u8> = plane.row(j).iter().flat_map(|value| value.to_le_bytes()).collect();
            out.write_all(&row)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const FIELDS: [NpyField; 2] = [NpyField::F64("board_mm", 2), NpyField::U32("class")];

    /// The header by the letter of the format: magic, length, a dictionary, blanks to 64 bytes, a line's end.
    #[test]
    fn the_header_is_that_of_the_format() {
        let bytes = header(&FIELDS, &[3, 12]);
        assert_eq!(bytes[..8], [0x93, b'N', b'U', b'M', b'P', b'Y', 1, 0]);
        let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        assert!(bytes.len() == 10 + length && bytes.len().is_multiple_of(64) && bytes.last() == Some(&b'\n'));
        let text = str::from_utf8(&bytes[10..]).unwrap();
        let expected =
            "{'descr': [('board_mm', '<f8', (2,)), ('class', '<u4')], 'fortran_order': False, 'shape': (3, 12), }";
        assert_eq!(text.trim_end(), expected);
        // A text that fills up its block to the last byte, and others.
        for columns in [1, 100, 10_000, 1_000_000, usize::MAX] {
            assert!(header(&FIELDS, &[columns, columns]).len().is_multiple_of(64));
        }
    }

    #[test]
    fn a_plane_is_its_rows() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npy");
        write_plane(&path, &Raster::from_data(3, 2, vec![0.5f32, -1.0, 2.0, 3.0, 4.0, 1e-30])).unwrap();
        let bytes = std::fs::read(path).unwrap();
        let head = bytes.len() - 24;
        assert!(head.is_multiple_of(64));
        let text = str::from_utf8(&bytes[10..head]).unwrap();
        assert_eq!(text.trim_end(), "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }");
        let values: Vec<f32> = bytes[head..].chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
        assert_eq!(values, [0.5, -1.0, 2.0, 3.0, 4.0, 1e-30]);
    }

    #[test]
    fn a_table_is_whole_or_not_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npy");
        for sizes in [&[20, 60][..], &[100, 1], &[]] {
            let parts = sizes.iter().map(|bytes| vec![0; *bytes]);
            write_parts(&path, &FIELDS, &[1, 5], parts).unwrap_err();
            assert!(!path.exists());
        }
        write_parts(&path, &FIELDS, &[1, 5], [vec![1; 40], vec![2; 60]].into_iter()).unwrap();
        let bytes = std::fs::read(path).unwrap();
        assert!(bytes.ends_with(&[2; 60]) && bytes.len() == header(&FIELDS, &[1, 5]).len() + 100);
    }
}
