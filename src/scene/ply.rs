//! The vertices of a PLY file: ascii, or binary of either byte order.

use super::cloud::Lines;
use crate::problem::Problem;
use glam::DVec3;
use std::io::BufRead;

/// Most lines of a header.
const MAX_HEADER_LINES: usize = 1000;

/// How the body of a PLY file is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Encoding {
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

    /// The number that begins `bytes`, which are little-endian.
    fn value(self, bytes: [u8; 8]) -> f64 {
        let [a, b, c, d, ..] = bytes;
        match self {
            Self::I8 => f64::from(i8::from_le_bytes([a])),
            Self::U8 => f64::from(a),
            Self::I16 => f64::from(i16::from_le_bytes([a, b])),
            Self::U16 => f64::from(u16::from_le_bytes([a, b])),
            Self::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Self::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Self::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Self::F64 => f64::from_le_bytes(bytes),
        }
    }
}

/// What a PLY header says of its vertices.
struct Header {
    encoding: Encoding,
    count: u64,
    /// Type and offset in bytes of every property of a vertex.
    properties: Vec<(Scalar, usize)>,
    /// Which properties are x, y and z.
    xyz: [usize; 3],
    /// Bytes of a vertex in a binary body.
    stride: usize,
}

/// The vertices of a PLY file of `bytes` bytes. The header's count is checked against that before memory is taken.
///
/// # Errors
/// A [`Problem`] with the line, or the number of the vertex in a binary body.
pub(super) fn read<R: BufRead>(lines: &mut Lines<R>, bytes: u64) -> Result<Vec<DVec3>, Problem> {
    let header = read_header(lines)?;
    // In ascii every value has a digit and a blank or an end of line, but for the last.
    let needed = match header.encoding {
        Encoding::Ascii => (2 * header.count * header.properties.len() as u64).saturating_sub(1),
        _ => header.count * header.stride as u64,
    };
    let left = bytes.saturating_sub(lines.taken);
    if needed > left {
        return Err(lines.problem(
            format!("{} vertices need {needed} bytes or more after the header, and the file has {left}", header.count),
            "the file is cut short, or its header is wrong: write it again",
        ));
    }
    let mut points = Vec::with_capacity(header.count as usize);
    if header.encoding == Encoding::Ascii {
        let mut buffer = Vec::new();
        for i in 0..header.count {
            let Some(line) = lines.next(&mut buffer)? else {
                return Err(lines.problem(
                    format!("the file ends after {i} of {} vertices", header.count),
                    "the file is cut short, or its header is wrong: write it again",
                ));
            };
            let values: Vec<&str> = line.split_whitespace().collect();
            if values.len() != header.properties.len() {
                return Err(lines.problem(
                    format!("the vertex has {} values, and must have {}", values.len(), header.properties.len()),
                    "correct the line, or the properties in the header",
                ));
            }
            let [x, y, z] = header.xyz.map(|i| lines.number("a coordinate", values[i]));
            points.push(DVec3::new(x?, y?, z?));
        }
        return Ok(points);
    }
    let mut vertex = vec![0; header.stride];
    for i in 0..header.count {
        lines.input.read_exact(&mut vertex).map_err(|e| {
            let rule = format!("vertex {} of {} cannot be read: {e}", i + 1, header.count);
            Problem::new(lines.name, rule, "the file is cut short, or its header is wrong: write it again")
        })?;
        let point = DVec3::from_array(header.xyz.map(|axis| {
            let (scalar, offset) = header.properties[axis];
            let mut first = [0; 8];
            first[..scalar.bytes()].copy_from_slice(&vertex[offset..offset + scalar.bytes()]);
            if header.encoding == Encoding::BigEndian {
                first[..scalar.bytes()].reverse();
            }
            scalar.value(first)
        }));
        if !point.is_finite() {
            let rule = format!("vertex {} is {point}, and must be finite", i + 1);
            return Err(Problem::new(lines.name, rule, "remove the vertex from the cloud"));
        }
        points.push(point);
    }
    Ok(points)
}

fn read_header<R: BufRead>(lines: &mut Lines<R>) -> Result<Header, Problem> {
    let mut buffer = Vec::new();
    if lines.next(&mut buffer)? != Some("ply") {
        return Err(lines.problem("the first line is not `ply`", "check the file's format and extension"));
    }
    let (mut encoding, mut count) = (None, None);
    let (mut names, mut properties, mut stride) = (Vec::new(), Vec::new(), 0);
    // Whether the properties that follow are those of the vertices, which come first.
    let mut in_vertex = false;
    while lines.line < MAX_HEADER_LINES {
        let Some(line) = lines.next(&mut buffer)? else { break };
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["format", name, "1.0"] => {
                encoding = match name {
                    "ascii" => Some(Encoding::Ascii),
                    "binary_little_endian" => Some(Encoding::LittleEndian),
                    "binary_big_endian" => Some(Encoding::BigEndian),
                    _ => None,
                };
            }
            ["comment" | "obj_info", ..] => {}
            ["element", "vertex", value] if count.is_none() => {
                let within = |n: &u64| *n <= lines.limit;
                count = Some(value.parse().ok().filter(within).ok_or_else(|| {
                    lines.problem(
                        format!("the count of vertices is {value:?}, and must be within 0 .. {}", lines.limit),
                        "thin the cloud out: a surface of some dozen coefficients needs far fewer",
                    )
                })?);
                in_vertex = true;
            }
            ["element", name, _] if count.is_none() => {
                return Err(lines.problem(
                    format!("the first element is {name:?}, and must be \"vertex\""),
                    "write the vertices before all else, as most programs do",
                ));
            }
            ["element", _, _] => in_vertex = false,
            ["property", kind, name] if in_vertex => {
                let Some(scalar) = Scalar::named(kind) else {
                    return Err(lines.problem(
                        format!("the type of {name:?} is {kind:?}, which PLY does not have"),
                        "use float or double",
                    ));
                };
                names.push(name.to_owned());
                properties.push((scalar, stride));
                stride += scalar.bytes();
            }
            ["property", ..] if !in_vertex => {}
            ["end_header"] => {
                let axis = |axis: &str| names.iter().position(|n| n == axis);
                let (Some(encoding), Some(count), Some(x), Some(y), Some(z)) =
                    (encoding, count, axis("x"), axis("y"), axis("z"))
                else {
                    return Err(lines.problem(
                        "the header must give a format (ascii or binary), `element vertex` and its properties x, y and z",
                        "write the file again as a point cloud of x, y, z",
                    ));
                };
                return Ok(Header { encoding, count, properties, xyz: [x, y, z], stride });
            }
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
