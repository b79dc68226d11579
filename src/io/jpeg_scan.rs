//! Whether the coded data of a JPEG file reach to the last block (ITU-T T.81, annexes B, F and G).
//!
//! Decoders fill up what is missing with grey, or take zeros for it, and a marker of the end is soon written behind half a picture. So
//! the codes of a baseline picture are counted block by block, without making a pixel of them. Of a progressive one every
//! coefficient must have been refined to its last bit; whether its last scan is whole shows in what a decoder makes of other bytes
//! behind it (`photo`).

/// Kinds of Huffman tables, and their numbers.
const TABLES: usize = 8;
/// Tables that are made of a file, at most.
const MOST_TABLES: usize = 1000;
/// Coefficients of a block.
const BLOCK: usize = 64;

/// The length in bits and the symbol of each code, by the 16 bits that begin with it; length 0 is no code.
type Codes = Vec<(u8, u8)>;

/// A component of the picture.
#[derive(Debug, Clone, Copy, Default)]
struct Component {
    id: u8,
    /// Blocks of a unit of an interleaved scan, across and down.
    factors: [usize; 2],
}

/// What the segments before a scan state.
#[derive(Debug, Default)]
struct Stated {
    progressive: bool,
    size: [usize; 2],
    components: Vec<Component>,
    tables: [Codes; TABLES],
    /// Tables that were made so far.
    made: usize,
    /// Units between two markers of restarts; 0 is none.
    restart: usize,
}

/// What the codes of a file say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Coded {
    /// The codes of all blocks are there; of a progressive file, scans of all bits of all coefficients. The file ends at this byte.
    Whole(usize),
    /// They end before.
    Cut,
    /// Arithmetic codes, or something that is not understood: the decoder has the word.
    Unknown,
}

/// Whether the coded data of a file reach to the end of its picture.
pub(super) fn coded(file: &[u8]) -> Coded {
    walk(file).unwrap_or(Coded::Unknown)
}

fn walk(file: &[u8]) -> Option<Coded> {
    let mut stated = Stated::default();
    // The bit from which on each coefficient of each component is still missing.
    let mut missing: Vec<[Option<u8>; BLOCK]> = Vec::new();
    let mut at = 2;
    loop {
        // Go to the next marker, and take its segment.
        at += file.get(at..)?.iter().position(|&b| b == 0xff)?;
        at += file.get(at..)?.iter().position(|&b| b != 0xff)?;
        let code = file[at];
        at += 1;
        if matches!(code, 0x00 | 0x01 | 0xd0..=0xd8) {
            continue;
        }
        if code == 0xd9 {
            let left = |blocks: &[Option<u8>; BLOCK]| blocks.iter().any(|bit| *bit != Some(0));
            return Some(if missing.iter().any(left) { Coded::Cut } else { Coded::Whole(at) });
        }
        let length = usize::from(u16::from_be_bytes(*file.get(at..)?.first_chunk()?));
        let segment = file.get(at + 2..at + length)?;
        at += length;
        match code {
            0xc0..=0xc2 => {
                stated.take_frame(segment, code == 0xc2)?;
                missing = vec![[None; BLOCK]; stated.components.len()];
            }
            0xc4 => stated.take_tables(segment)?,
            0xdd => stated.restart = usize::from(u16::from_be_bytes(*segment.first_chunk()?)),
            0xda => {
                let scan = Scan::new(&stated, segment)?;
                for part in &scan.parts {
                    missing[part.component][scan.first..=scan.last].fill(Some(scan.bit));
                }
                if !stated.progressive {
                    match scan.length(&stated, &file[at..]) {
                        Ok(length) => at += length,
                        Err(coded) => return Some(coded),
                    }
                }
            }
            // Other kinds of frames.
            0xc3 | 0xc5..=0xcf => return None,
            _ => {}
        }
    }
}

impl Stated {
    fn take_frame(&mut self, segment: &[u8], progressive: bool) -> Option<()> {
        let [_, h0, h1, w0, w1, count, rest @ ..] = segment else { return None };
        self.progressive = progressive;
        self.size = [u16::from_be_bytes([*w0, *w1]), u16::from_be_bytes([*h0, *h1])].map(usize::from);
        let parts = rest.as_chunks::<3>().0.iter().take(usize::from(*count));
        let component =
            |&[id, factors, _]: &[u8; 3]| Component { id, factors: [factors >> 4, factors & 15].map(usize::from) };
        self.components = parts.map(component).collect();
        let sane = |c: &Component| c.factors.iter().all(|f| (1..=4).contains(f));
        (self.size.iter().all(|s| *s > 0) && self.components.iter().all(sane)).then_some(())
    }

    fn take_tables(&mut self, mut segment: &[u8]) -> Option<()> {
        while let [kind, rest @ ..] = segment {
            let (counts, symbols) = rest.split_first_chunk::<16>()?;
            let number = usize::from(kind >> 4) * 4 + usize::from(kind & 15);
            let mut codes = vec![(0, 0); 1 << 16];
            let (mut code, mut used) = (0usize, 0);
            for (bits, &count) in (1u8..).zip(counts) {
                for _ in 0..count {
                    let first = code << (16 - bits);
                    codes.get_mut(first..first + (1 << (16 - bits)))?.fill((bits, *symbols.get(used)?));
                    used += 1;
                    code += 1;
                }
                code <<= 1;
            }
            *self.tables.get_mut(number)? = codes;
            self.made += 1;
            if self.made > MOST_TABLES {
                return None;
            }
            segment = &symbols[used..];
        }
        Some(())
    }
}

/// A component in a scan.
struct ScanPart {
    component: usize,
    /// Numbers of its tables.
    tables: [usize; 2],
}

/// One scan: which coefficients of which components follow, down to which bit.
struct Scan {
    parts: Vec<ScanPart>,
    first: usize,
    last: usize,
    bit: u8,
}

impl Scan {
    fn new(stated: &Stated, segment: &[u8]) -> Option<Self> {
        let (count, rest) = segment.split_first()?;
        let (parts, rest) = rest.split_at_checked(2 * usize::from(*count))?;
        let part = |&[id, tables]: &[u8; 2]| {
            let component = stated.components.iter().position(|c| c.id == id)?;
            Some(ScanPart { component, tables: [usize::from(tables >> 4) & 3, 4 + (usize::from(tables) & 3)] })
        };
        let parts = parts.as_chunks::<2>().0.iter().map(part).collect::<Option<Vec<_>>>()?;
        let [first, last, bits, ..] = rest else { return None };
        let [first, last] = if stated.progressive { [*first, *last] } else { [0, 63] }.map(usize::from);
        (first <= last && last < BLOCK && !parts.is_empty()).then_some(Self { parts, first, last, bit: bits & 15 })
    }

    /// How many bytes of `data` the blocks of a baseline scan take; [`Coded::Cut`] where they end before the last block, and `Unknown`
    /// where a table is missing.
    fn length(&self, stated: &Stated, data: &[u8]) -> Result<usize, Coded> {
        // Count the units, and the blocks of each.
        let most = |axis: usize| stated.components.iter().map(|c| c.factors[axis]).max().unwrap_or(1);
        let single = self.parts.len() == 1;
        let units = [0, 1].map(|axis| {
            let own = stated.components[self.parts[0].component].factors[axis];
            let size = stated.size[axis];
            if single { (size * own).div_ceil(most(axis)).div_ceil(8) } else { size.div_ceil(8 * most(axis)) }
        });
        let blocks = |part: &ScanPart| {
            if single { 1 } else { stated.components[part.component].factors.iter().product::<usize>() }
        };
        let tables = |part: &ScanPart| part.tables.map(|number| &stated.tables[number]);
        if self.parts.iter().flat_map(tables).any(Vec::is_empty) {
            return Err(Coded::Unknown);
        }

        // Go through their codes.
        let mut bits = Bits { data, at: 0, held: 0, count: 0 };
        for unit in 0..units[0] * units[1] {
            if stated.restart > 0 && unit > 0 && unit % stated.restart == 0 {
                bits.restart().ok_or(Coded::Cut)?;
            }
            for part in &self.parts {
                (0..blocks(part)).try_for_each(|_| bits.block(tables(part))).ok_or(Coded::Cut)?;
            }
        }
        Ok(bits.at)
    }
}

/// Reads coded data bit by bit, to the next marker.
struct Bits<'a> {
    data: &'a [u8],
    at: usize,
    held: u64,
    count: u32,
}

impl Bits<'_> {
    fn fill(&mut self) {
        while self.count <= 48 {
            let Some(&byte) = self.data.get(self.at) else { return };
            // A zero makes the 0xff before it a byte of the coded data.
            if byte == 0xff && self.data.get(self.at + 1) != Some(&0) {
                return;
            }
            self.at += if byte == 0xff { 2 } else { 1 };
            self.held = self.held << 8 | u64::from(byte);
            self.count += 8;
        }
    }

    fn skip(&mut self, count: u32) -> Option<()> {
        self.count = self.count.checked_sub(count)?;
        Some(())
    }

    /// The next symbol, and past the bits that belong to it.
    fn symbol(&mut self, codes: &Codes) -> Option<u8> {
        self.fill();
        let next = if self.count >= 16 { self.held >> (self.count - 16) } else { self.held << (16 - self.count) };
        let (length, symbol) = codes[(next & 0xffff) as usize];
        self.skip(if length == 0 { u32::MAX } else { length.into() })?;
        // Its lower half is the length of the value behind it: at most 15 bits, of which 17 and more are held.
        self.skip(u32::from(symbol & 15))?;
        Some(symbol)
    }

    /// Past the codes of a block.
    fn block(&mut self, [first, others]: [&Codes; 2]) -> Option<()> {
        self.symbol(first)?;
        let mut k = 1;
        while k < BLOCK {
            let symbol = self.symbol(others)?;
            match (symbol >> 4, symbol & 15) {
                (15, 0) => k += 16,
                (_, 0) => break,
                (zeros, _) => k += usize::from(zeros) + 1,
            }
        }
        Some(())
    }

    /// Past the marker of a restart.
    fn restart(&mut self) -> Option<()> {
        // No more than its padding is left before it: a marker stops the filling.
        self.fill();
        let from = self.data.get(self.at..)?;
        let filled = from.iter().take_while(|b| **b == 0xff).count();
        matches!((filled, from.get(filled)?), (1.., 0xd0..=0xd7)).then_some(())?;
        (self.at, self.held, self.count) = (self.at + filled + 1, 0, 0);
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::codecs::jpeg::JpegEncoder;

    #[test]
    fn a_picture_is_whole_to_its_last_byte_and_cut_at_any_before() {
        let pixels: Vec<u8> = (0..50 * 37 * 3).map(|k| ((k * 7919) % 251) as u8).collect();
        for (colour, channels) in [(image::ExtendedColorType::Rgb8, 3), (image::ExtendedColorType::L8, 1)] {
            let mut file = Vec::new();
            let data = &pixels[..50 * 37 * channels];
            JpegEncoder::new_with_quality(&mut file, 80).encode(data, 50, 37, colour).unwrap();
            assert_eq!(coded(&file), Coded::Whole(file.len()));
            let scan = file.windows(2).rposition(|w| w == [0xff, 0xda]).unwrap() + 14;
            for cut in (scan..file.len() - 4).step_by(7) {
                let ended = [&file[..cut], &[0xff, 0xd9]].concat();
                assert_eq!(coded(&ended), Coded::Cut, "{cut} of {}", file.len());
            }
        }
    }

    #[test]
    fn what_is_no_picture_is_not_understood() {
        for file in [&[][..], &[0xff, 0xd8], &[0xff, 0xd8, 0xff, 0xc0, 0, 3, 8], &[0xff, 0xd8, 0xff, 0xc9, 0, 2]] {
            assert_eq!(coded(file), Coded::Unknown);
        }
    }
}
