//! The vertices and faces of a PLY file: ascii, or binary of either byte order.

use super::lines::TextLines;
use crate::error::Error;
use std::io::BufRead;

/// Most items of a list: of a face, its corners.
const MAX_LIST: f64 = 255.0;
/// Most lines of a header.
const MAX_HEADER_LINES: usize = 1000;
/// What to do about a file that ends too early.
const CUT_SHORT: &str = "the file is cut short, or its header is wrong: write it again";

/// How the body of a PLY file is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PlyEncoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// A scalar type of PLY.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// Appends the numbers that `bytes` hold.
    fn append(self, bytes: &[u8], encoding: PlyEncoding, out: &mut Vec<f64>) {
        fn each<const N: usize>(bytes: &[u8], encoding: PlyEncoding, out: &mut Vec<f64>, value: fn([u8; N]) -> f64) {
            out.extend(bytes.as_chunks().0.iter().map(|bytes| {
                let mut bytes = *bytes;
                if encoding == PlyEncoding::BigEndian {
                    bytes.reverse();
                }
                value(bytes)
            }));
        }
        match self {
            Self::I8 => each(bytes, encoding, out, |bytes| f64::from(i8::from_le_bytes(bytes))),
            Self::U8 => each(bytes, encoding, out, |[byte]| f64::from(byte)),
            Self::I16 => each(bytes, encoding, out, |bytes| f64::from(i16::from_le_bytes(bytes))),
            Self::U16 => each(bytes, encoding, out, |bytes| f64::from(u16::from_le_bytes(bytes))),
            Self::I32 => each(bytes, encoding, out, |bytes| f64::from(i32::from_le_bytes(bytes))),
            Self::U32 => each(bytes, encoding, out, |bytes| f64::from(u32::from_le_bytes(bytes))),
            Self::F32 => each(bytes, encoding, out, |bytes| f64::from(f32::from_le_bytes(bytes))),
            Self::F64 => each(bytes, encoding, out, f64::from_le_bytes),
        }
    }

    /// Reads `count` numbers, and appends them.
    fn read(
        self,
        count: usize,
        input: &mut impl BufRead,
        encoding: PlyEncoding,
        out: &mut Vec<f64>,
    ) -> std::io::Result<()> {
        // Take them where they are buffered; a buffer that cannot be filled says why when it is read from.
        let size = count * self.bytes();
        if let Some(bytes) = input.fill_buf().unwrap_or_default().get(..size) {
            self.append(bytes, encoding, out);
            input.consume(size);
            return Ok(());
        }

        // Read them one by one: what is not there ends the file, and takes no memory.
        let mut bytes = [0; 8];
        let own = &mut bytes[..self.bytes()];
        for _ in 0..count {
            input.read_exact(own)?;
            self.append(own, encoding, out);
        }
        Ok(())
    }
}

/// What a property holds: one number, or a count and as many numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PropertyKind {
    Scalar(Scalar),
    List { count: Scalar, item: Scalar },
}

/// An element of the header.
#[derive(Debug)]
struct Element {
    name: String,
    count: u64,
    properties: Vec<(String, PropertyKind)>,
}

impl Element {
    fn position(&self, name: &str) -> Option<usize> {
        self.properties.iter().position(|(own, _)| own == name)
    }

    /// Bytes that all rows need at the least. In ascii every value has a digit and a blank or an end of line, but for
    /// the last.
    fn least_bytes(&self, encoding: PlyEncoding) -> u64 {
        let row = self.properties.iter().map(|(_, kind)| match (encoding, kind) {
            (PlyEncoding::Ascii, _) => 2,
            (_, PropertyKind::Scalar(s) | PropertyKind::List { count: s, .. }) => s.bytes() as u64,
        });
        let all = self.count.saturating_mul(row.sum());
        if encoding == PlyEncoding::Ascii { all.saturating_sub(1) } else { all }
    }
}

/// A PLY file whose header has been read.
pub(super) struct Ply<'a, 'b, R> {
    lines: &'a mut TextLines<'b, R>,
    encoding: PlyEncoding,
    elements: Vec<Element>,
    /// Bytes of the file.
    bytes: u64,
    /// Elements whose rows have been read.
    done: usize,
}

/// One row of an element: its numbers in the header's order (a list gives its length), and the items of its list.
#[derive(Debug, Default)]
pub(super) struct PlyRow {
    pub(super) values: Vec<f64>,
    pub(super) list: Vec<f64>,
}

impl<'a, 'b, R: BufRead> Ply<'a, 'b, R> {
    /// Reads the header of a file of `bytes` bytes.
    ///
    /// # Errors
    /// A [`Error`] with the line.
    pub(super) fn open(lines: &'a mut TextLines<'b, R>, bytes: u64) -> Result<Self, Error> {
        let (encoding, elements) = read_header(lines)?;
        Ok(Self { lines, encoding, elements, bytes, done: 0 })
    }

    /// The element whose rows come next: its name and count.
    pub(super) fn next_element(&self) -> Option<(&str, u64)> {
        self.elements.get(self.done).map(|e| (e.name.as_str(), e.count))
    }

    /// Where the next element has these properties; all or none.
    pub(super) fn columns<const N: usize>(&self, names: [&str; N]) -> Option<[usize; N]> {
        let element = self.elements.get(self.done)?;
        let found = names.map(|name| element.position(name));
        found.iter().all(Option::is_some).then(|| found.map(Option::unwrap_or_default))
    }

    /// Whether property `column` of the next element is its only list.
    pub(super) fn is_its_list(&self, column: usize) -> bool {
        let is_list = |kind: &PropertyKind| matches!(kind, PropertyKind::List { .. });
        let properties = self.elements.get(self.done).map_or(&[][..], |e| &e.properties);
        properties.iter().enumerate().all(|(k, (_, kind))| is_list(kind) == (k == column))
    }

    /// A problem with what was read last.
    pub(super) fn problem(&self, rule: impl Into<String>, help: impl Into<String>) -> Error {
        if self.encoding == PlyEncoding::Ascii {
            return self.lines.problem(rule, help);
        }
        Error::new(self.lines.name, rule, help)
    }

    /// Gives the next element's rows to `each`, with their numbers from 1. The header's count is checked against the
    /// file's size before the first, so `each` may take memory for all.
    ///
    /// # Errors
    /// A [`Error`] with the line, or the number of the row in a binary body; and those of `each`.
    pub(super) fn rows(&mut self, mut each: impl FnMut(&Self, u64, &PlyRow) -> Result<(), Error>) -> Result<(), Error> {
        let (count, needed, name, kinds) = {
            let element = &self.elements[self.done];
            let kinds: Vec<PropertyKind> = element.properties.iter().map(|p| p.1).collect();
            (element.count, element.least_bytes(self.encoding), element.name.clone(), kinds)
        };
        let left = self.bytes.saturating_sub(self.lines.taken);
        if needed > left {
            let plural = if name == "vertex" { "vertices" } else { "rows of an element" };
            let rule =
                format!("{count} {plural} need {needed} bytes or more after the header, and the file has {left}");
            return Err(self.lines.problem(rule, CUT_SHORT));
        }
        let (mut row, mut buffer) = (PlyRow::default(), Vec::new());
        for i in 1..=count {
            row.values.clear();
            row.list.clear();
            match self.encoding {
                PlyEncoding::Ascii => self.text_row(&kinds, &name, [i, count], &mut buffer, &mut row)?,
                _ => self.binary_row(&kinds, &mut row).map_err(|e| {
                    let rule = format!("{name} {i} of {count} cannot be read: {e}");
                    Error::new(self.lines.name, rule, CUT_SHORT)
                })?,
            }
            each(self, i, &row)?;
        }
        self.done += 1;
        Ok(())
    }

    fn text_row(
        &mut self,
        kinds: &[PropertyKind],
        name: &str,
        [i, count]: [u64; 2],
        buffer: &mut Vec<u8>,
        row: &mut PlyRow,
    ) -> Result<(), Error> {
        let Some(line) = self.lines.next(buffer)? else {
            let rule = format!("the file ends after {} of {count} rows of {name:?}", i - 1);
            return Err(self.lines.problem(rule, CUT_SHORT));
        };
        let given = line.split_whitespace().count();
        let mut words = line.split_whitespace();
        let lines = &self.lines;
        let mut wanted = kinds.len();
        let mut number = |wanted: usize| {
            let word = words.next().ok_or_else(|| {
                let rule = format!("the {name} has {given} values, and must have {wanted}");
                lines.problem(rule, "correct the line, or the properties in the header")
            })?;
            lines.number("a value", word)
        };
        for kind in kinds {
            let value = number(wanted)?;
            row.values.push(value);
            if let PropertyKind::List { .. } = kind {
                // No more items than the line has words.
                wanted += if value > 0.0 { (value as usize).min(given + 1) } else { 0 };
                while (row.list.len() as f64) < value {
                    row.list.push(number(wanted)?);
                }
            }
        }
        if words.next().is_some() {
            let rule = format!("the {name} has {given} values, and must have {wanted}");
            return Err(lines.problem(rule, "correct the line, or the properties in the header"));
        }
        Ok(())
    }

    fn binary_row(&mut self, kinds: &[PropertyKind], row: &mut PlyRow) -> std::io::Result<()> {
        let (input, encoding) = (&mut self.lines.input, self.encoding);
        let are_alike = |a: &PropertyKind, b: &PropertyKind| a == b && matches!(a, PropertyKind::Scalar(_));
        for alike in kinds.chunk_by(are_alike) {
            match alike[0] {
                PropertyKind::Scalar(scalar) => scalar.read(alike.len(), input, encoding, &mut row.values)?,
                PropertyKind::List { count, item } => {
                    count.read(1, input, encoding, &mut row.values)?;
                    let length = row.values.last().copied().unwrap_or_default();
                    if length > MAX_LIST {
                        let rule = format!("its list has {length} items, and may have {MAX_LIST}");
                        return Err(std::io::Error::new(std::io::ErrorKind::InvalidData, rule));
                    }
                    // A length may be any number of its type: as many as are below it.
                    let items = length.max(0.0).ceil() as usize;
                    item.read(items.saturating_sub(row.list.len()), input, encoding, &mut row.list)?;
                }
            }
        }
        Ok(())
    }
}

fn read_header<R: BufRead>(lines: &mut TextLines<R>) -> Result<(PlyEncoding, Vec<Element>), Error> {
    let mut buffer = Vec::new();
    if lines.next(&mut buffer)? != Some("ply") {
        return Err(lines.problem("the first line is not `ply`", "check the file's format and extension"));
    }
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    while lines.line < MAX_HEADER_LINES {
        let Some(line) = lines.next(&mut buffer)? else { break };
        let words: Vec<&str> = line.split_whitespace().collect();
        let unknown_type = |kind: &str, name: &str| {
            lines.problem(format!("the type of {name:?} is {kind:?}, which PLY does not have"), "use float or double")
        };
        match words[..] {
            ["format", name, "1.0"] => {
                encoding = match name {
                    "ascii" => Some(PlyEncoding::Ascii),
                    "binary_little_endian" => Some(PlyEncoding::LittleEndian),
                    "binary_big_endian" => Some(PlyEncoding::BigEndian),
                    _ => None,
                };
            }
            ["comment" | "obj_info", ..] => {}
            ["element", name, value] => elements.push(element(lines, elements.is_empty(), name, value)?),
            ["property", "list", count, item, name] if elements.len() > 1 => {
                let count = Scalar::named(count).ok_or_else(|| unknown_type(count, name))?;
                let item = Scalar::named(item).ok_or_else(|| unknown_type(item, name))?;
                if let Some(element) = elements.last_mut() {
                    element.properties.push((name.to_owned(), PropertyKind::List { count, item }));
                }
            }
            ["property", kind, name] if !elements.is_empty() => {
                let scalar = Scalar::named(kind).ok_or_else(|| unknown_type(kind, name))?;
                if let Some(element) = elements.last_mut() {
                    element.properties.push((name.to_owned(), PropertyKind::Scalar(scalar)));
                }
            }
            ["end_header"] => return complete_header(lines, encoding, elements),
            _ => {
                return Err(lines.problem(
                    format!("the header line {:?} is not understood", words.join(" ")),
                    "write the vertices with scalar properties only, in PLY 1.0",
                ));
            }
        }
    }
    Err(lines.problem(
        format!("the header does not end within {MAX_HEADER_LINES} lines"),
        "check the file's format and extension",
    ))
}

/// The element that a header line names; the `first` must be the vertices.
fn element<R: BufRead>(lines: &TextLines<R>, first: bool, name: &str, value: &str) -> Result<Element, Error> {
    if first && name != "vertex" {
        return Err(lines.problem(
            format!("the first element is {name:?}, and must be \"vertex\""),
            "write the vertices before all else, as most programs do",
        ));
    }
    let within = |n: &u64| *n <= lines.limit;
    let count = value.parse().ok().filter(within).ok_or_else(|| {
        let plural = if name == "vertex" { "vertices" } else { name };
        lines.problem(
            format!("the count of {plural} is {value:?}, and must be within 0 .. {}", lines.limit),
            "thin it out: a smooth surface needs far fewer",
        )
    })?;
    Ok(Element { name: name.to_owned(), count, properties: Vec::new() })
}

/// The header at its end, if it names an encoding and vertices of x, y and z.
fn complete_header<R: BufRead>(
    lines: &TextLines<R>,
    encoding: Option<PlyEncoding>,
    elements: Vec<Element>,
) -> Result<(PlyEncoding, Vec<Element>), Error> {
    let vertices = elements.first();
    let has = |axis: &str| vertices.is_some_and(|v| v.position(axis).is_some());
    match encoding {
        Some(encoding) if ["x", "y", "z"].into_iter().all(has) => Ok((encoding, elements)),
        _ => Err(lines.problem(
            "the header must give a format (ascii or binary), `element vertex` and its properties x, y and z",
            "write the file again as a point cloud or a mesh of x, y, z",
        )),
    }
}
