//! Tables of numbers from NPY files of NumPy, formats 1.0 to 3.0: f64, little-endian, row by row.

use super::inputs;
use crate::error::Error;
use std::io::{self, BufReader, Read};
use std::path::Path;

/// Longest header that is read, in bytes.
const MAX_HEADER: usize = 1 << 16;
/// Numbers that are read at once.
const PIECE: usize = 1 << 13;

/// The values of a table of at most `most` rows, each of `columns` numbers, one row behind the other.
///
/// # Errors
/// A file that cannot be read or is no NPY, values that are no `<f8` in C order, another number of columns, more rows, a number that
/// is not finite, and bytes that are not as many as the header says.
pub(crate) fn read_table(path: &Path, columns: usize, most: usize) -> Result<Vec<f64>, Error> {
    let refuse = |rule: String, help: &str| Error::new(path.display(), rule, help);
    let unreadable = |error: io::Error| {
        let rule = match error.kind() {
            io::ErrorKind::UnexpectedEof => "the file ends before its table does".to_owned(),
            _ => format!("cannot be read: {error}"),
        };
        refuse(rule, "check the file, its path and its permissions")
    };
    let mut file = BufReader::new(inputs::open(path).map_err(unreadable)?);

    // Read what the table is, and bound its size before memory is taken.
    let header = header(&mut file).map_err(unreadable)?;
    let text = header.ok_or_else(|| refuse("it is no NPY file".to_owned(), "write it with `np.save`"))?;
    let entry = |key: &str| text.split_once(&format!("'{key}':")).map_or("", |(_, rest)| rest.trim_start());
    if !entry("descr").starts_with("'<f8'") || !entry("fortran_order").starts_with("False") {
        let rule = format!("the array is not of '<f8' in C order: {}", text.trim());
        return Err(refuse(rule, "save `np.ascontiguousarray(a, dtype=\"<f8\")`"));
    }
    let shape = entry("shape").trim_start_matches('(').split_once(')').map_or("", |(inner, _)| inner);
    let shape: Vec<&str> = shape.split(',').map(str::trim).filter(|size| !size.is_empty()).collect();
    let rows = match shape[..] {
        [rows, width] if width == columns.to_string() => rows.parse::<usize>().ok(),
        _ => None,
    };
    let Some(rows) = rows else {
        let rule = format!("the array has the shape ({}), and must have (n, {columns})", shape.join(", "));
        return Err(refuse(rule, "save one row for each point"));
    };
    if rows > most {
        return Err(refuse(format!("there are more than {most} points"), "split the file"));
    }

    // Read the values in pieces, and no byte more.
    let mut values = Vec::with_capacity(rows * columns);
    let mut piece = vec![0; 8 * PIECE];
    while values.len() < rows * columns {
        let bytes = &mut piece[..8 * PIECE.min(rows * columns - values.len())];
        file.read_exact(bytes).map_err(unreadable)?;
        values.extend(bytes.as_chunks().0.iter().map(|value| f64::from_le_bytes(*value)));
    }
    if file.read(&mut [0]).map_err(unreadable)? > 0 {
        return Err(refuse("the file goes on behind its table".to_owned(), "write it with `np.save`"));
    }
    if let Some(k) = values.iter().position(|value| !value.is_finite()) {
        let rule = format!("[{}, {}] is {}, and must be a finite number", k / columns, k % columns, values[k]);
        return Err(refuse(rule, "leave the row out"));
    }
    Ok(values)
}

/// The text of the header; `None` where the file begins as no NPY does.
fn header(file: &mut impl Read) -> io::Result<Option<String>> {
    let mut magic = [0; 8];
    file.read_exact(&mut magic)?;
    let length = match magic {
        [0x93, b'N', b'U', b'M', b'P', b'Y', 1, 0] => {
            let mut bytes = [0; 2];
            file.read_exact(&mut bytes)?;
            usize::from(u16::from_le_bytes(bytes))
        }
        [0x93, b'N', b'U', b'M', b'P', b'Y', 2 | 3, 0] => {
            let mut bytes = [0; 4];
            file.read_exact(&mut bytes)?;
            u32::from_le_bytes(bytes) as usize
        }
        _ => return Ok(None),
    };
    if length > MAX_HEADER {
        return Ok(None);
    }
    let mut text = vec![0; length];
    file.read_exact(&mut text)?;
    Ok(String::from_utf8(text).ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file as NumPy writes it, with this header and these values.
    fn file(version: u8, header: &str, values: &[f64]) -> Vec<u8> {
        let mut bytes = b"\x93NUMPY".to_vec();
        bytes.extend([version, 0]);
        match version {
            1 => bytes.extend((header.len() as u16).to_le_bytes()),
            _ => bytes.extend((header.len() as u32).to_le_bytes()),
        }
        bytes.extend(header.as_bytes());
        bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        bytes
    }

    fn read(bytes: &[u8]) -> Result<Vec<f64>, Error> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.npy");
        std::fs::write(&path, bytes).unwrap();
        read_table(&path, 2, 3)
    }

    const SIX: [f64; 6] = [1.0, 2.0, 3.0, 4.0, 5.0, -6.5e-300];

    #[test]
    fn a_table_of_any_version_is_its_values() {
        let header = "{'descr': '<f8', 'fortran_order': False, 'shape': (3, 2), }          \n";
        for version in 1..=3 {
            assert_eq!(read(&file(version, header, &SIX)).unwrap(), SIX);
        }
        // Keys in another order, as the format allows.
        let other = "{'shape': (0, 2), 'descr': '<f8', 'fortran_order': False}\n";
        assert_eq!(read(&file(1, other, &[])).unwrap(), [0.0; 0]);
    }

    #[test]
    fn what_is_no_table_of_points_is_refused() {
        let of = |descr: &str, order: &str, shape: &str| {
            file(1, &format!("{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}\n"), &SIX)
        };
        for (bytes, said) in [
            (b"x_px,y_px\n1,2\n".to_vec(), "no NPY"),
            (b"\x93NUMPY\x01".to_vec(), "ends before"),
            (file(9, "", &SIX), "no NPY"),
            (of("'<f4'", "False", "(3, 2)"), "'<f8'"),
            (of("[('a', '<f8')]", "False", "(3, 2)"), "'<f8'"),
            (of("'<f8'", "True", "(3, 2)"), "C order"),
            (of("'<f8'", "False", "(6,)"), "shape (6)"),
            (of("'<f8'", "False", "(2, 3)"), "must have (n, 2)"),
            (of("'<f8'", "False", "(4, 2)"), "more than 3"),
            (of("'<f8'", "False", "(18446744073709551615, 2)"), "more than 3"),
            (of("'<f8'", "False", "(2, 2)"), "goes on"),
            (file(1, "{'descr': '<f8', 'fortran_order': False, 'shape': (3, 2)}", &SIX[..5]), "ends before"),
            (file(1, "{'descr': '<f8', 'fortran_order': False, 'shape': (1, 2)}", &[1.0, f64::NAN]), "[0, 1] is NaN"),
        ] {
            let problem = read(&bytes).unwrap_err();
            assert!(problem.rule.contains(said), "{said}: {}", problem.rule);
        }
    }
}
