//! The bytes of a strip or tile, unpacked.

use crate::io::memory::MOST_EXPANSION;
use flate2::read::ZlibDecoder;
use std::io::Read;
use weezl::{BitOrder, LzwStatus};

/// How a file packs its samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Packing {
    /// As they are.
    None,
    /// Codes of 9 to 12 bits (revision 6.0, section 13).
    Lzw,
    /// Zlib's streams (Adobe's technical note 3).
    Deflate,
    /// Run lengths (section 9).
    PackBits,
}

impl Packing {
    /// Bytes that one packed byte becomes at most.
    ///
    /// LZW: a code of 12 bits stands for at most as many bytes as there are codes, 4096 less the 256 of single bytes and the
    /// two that are no text, and one: 3839 bytes by 1.5. PackBits: two bytes for 128 equal ones.
    pub(super) fn most_expansion(self) -> u64 {
        match self {
            Self::None => 1,
            Self::Lzw => 2560,
            Self::Deflate => MOST_EXPANSION,
            Self::PackBits => 64,
        }
    }

    /// Bytes that so many may take when they are packed by any sane program: LZW's codes of 12 bits for single bytes are 1.5
    /// times as long. What stands behind is not read, so that a file of overlapping strips costs no more than one without.
    pub(super) fn most_packed(self, unpacked: usize) -> usize {
        match self {
            Self::None => unpacked,
            _ => unpacked.saturating_mul(2).saturating_add(1024),
        }
    }

    /// Unpacks so many bytes.
    pub(super) fn unpack(self, packed: Vec<u8>, length: usize) -> Result<Vec<u8>, String> {
        let short = |found: usize| format!("a strip or tile unpacks to {found} bytes, and must have {length}");
        let mut out = vec![0; length];
        let found = match self {
            Self::None => return if packed.len() == length { Ok(packed) } else { Err(short(packed.len())) },
            Self::Deflate => {
                let read = ZlibDecoder::new(&packed[..]).read_exact(&mut out);
                return read.map(|()| out).map_err(|error| format!("a strip or tile cannot be unpacked: {error}"));
            }
            Self::Lzw => lzw(&packed, &mut out)?,
            Self::PackBits => pack_bits(&packed, &mut out),
        };
        if found == length { Ok(out) } else { Err(short(found)) }
    }
}

/// Returns how many bytes of `out` are filled.
fn lzw(packed: &[u8], out: &mut [u8]) -> Result<usize, String> {
    let mut decoder = weezl::decode::Decoder::with_tiff_size_switch(BitOrder::Msb, 8);
    let (mut read, mut filled) = (0, 0);
    while filled < out.len() {
        let step = decoder.decode_bytes(&packed[read..], &mut out[filled..]);
        (read, filled) = (read + step.consumed_in, filled + step.consumed_out);
        match step.status {
            Ok(LzwStatus::Ok) => {}
            Ok(LzwStatus::Done | LzwStatus::NoProgress) => break,
            Err(error) => return Err(format!("a strip or tile cannot be unpacked: {error}")),
        }
    }
    Ok(filled)
}

/// Returns how many bytes of `out` are filled.
fn pack_bits(mut packed: &[u8], out: &mut [u8]) -> usize {
    let mut filled = 0;
    while let Some((&head, rest)) = packed.split_first() {
        let left = out.len() - filled;
        match head.cast_signed() {
            literal @ 0.. => {
                let count = (literal as usize + 1).min(rest.len());
                let taken = count.min(left);
                out[filled..filled + taken].copy_from_slice(&rest[..taken]);
                filled += taken;
                packed = &rest[count..];
            }
            // Nothing, by the specification.
            i8::MIN => packed = rest,
            run => {
                let Some((&byte, behind)) = rest.split_first() else { break };
                let count = (1 - isize::from(run)).unsigned_abs().min(left);
                out[filled..filled + count].fill(byte);
                filled += count;
                packed = behind;
            }
        }
        if filled == out.len() {
            break;
        }
    }
    filled
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of the specification, section 9.
    #[test]
    fn run_lengths_of_the_specification() {
        let packed = [0xfe, 0xaa, 0x02, 0x80, 0x00, 0x2a, 0xfd, 0xaa, 0x03, 0x80, 0x00, 0x2a, 0x22, 0xf7, 0xaa];
        let mut expected = vec![0xaa; 3];
        expected.extend([0x80, 0x00, 0x2a]);
        expected.extend([0xaa; 4]);
        expected.extend([0x80, 0x00, 0x2a, 0x22]);
        expected.extend([0xaa; 10]);
        assert_eq!(Packing::PackBits.unpack(packed.to_vec(), 24).unwrap(), expected);
        assert!(Packing::PackBits.unpack(packed[..14].to_vec(), 24).is_err());
        assert!(Packing::PackBits.unpack(vec![0x80; 9], 1).is_err());
    }

    /// Black alone, with no clear code but the first, is what expands most.
    #[test]
    fn no_lzw_expands_more_than_is_told() {
        let plain = vec![0u8; 20_000_000];
        let packed = weezl::encode::Encoder::with_tiff_size_switch(BitOrder::Msb, 8).encode(&plain).unwrap();
        assert!((plain.len() as u64) < packed.len() as u64 * Packing::Lzw.most_expansion());
        assert_eq!(Packing::Lzw.unpack(packed, plain.len()).unwrap(), plain);
    }
}
