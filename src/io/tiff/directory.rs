//! The directories of a TIFF file: its tags and their numbers.

use super::tags::Tag;
use crate::error::Error;
use crate::io::inputs::unreadable;
use std::collections::BTreeMap;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

/// Tags of one directory, at most; revision 6.0 names some 80.
const MOST_TAGS: u64 = 4096;

/// Whether a file that begins so is a TIFF: its byte order, then 42, or 43 of a BigTIFF.
pub(in crate::io) fn is_tiff(start: &[u8]) -> bool {
    matches!(start, [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..])
}

/// A file that is read, and how its numbers are written.
pub(super) struct TiffFile<'a, S> {
    pub(super) path: &'a Path,
    source: S,
    pub(super) bytes: u64,
    pub(super) big_endian: bool,
    /// Whether offsets and counts have 8 bytes.
    big: bool,
}

/// The tags of one picture.
pub(super) struct Directory {
    entries: BTreeMap<u16, TagNumbers>,
    /// Where the next one stands; 0 after the last.
    pub(super) next: u64,
}

/// Type and count of a tag's numbers, and they themselves where they fit in, else their place.
struct TagNumbers {
    kind: u16,
    count: u64,
    field: Vec<u8>,
}

impl<'a, S: Read + Seek> TiffFile<'a, S> {
    /// The file at `path` of so many bytes, and where its first directory stands.
    pub(super) fn open(path: &'a Path, source: S, bytes: u64) -> Result<(Self, u64), Error> {
        let mut file = Self { path, source, bytes, big_endian: false, big: false };
        let head = file.at(0, 8)?;
        file.big_endian = head[0] == b'M';
        file.big = head[2].max(head[3]) == 43;
        if !file.big {
            let first = file.number(&head[4..8]);
            return Ok((file, first));
        }
        if [file.number(&head[4..6]), file.number(&head[6..8])] != [8, 0] {
            return Err(file.damaged("its offsets must have 8 bytes".to_owned()));
        }
        let first = file.at(8, 8)?;
        let first = file.number(&first);
        Ok((file, first))
    }

    pub(super) fn damaged(&self, rule: String) -> Error {
        let rule = format!("the TIFF is damaged: {rule}");
        Error::new(self.path.display(), rule, "copy the file again, or export it anew")
    }

    pub(super) fn refused(&self, rule: String, help: &str) -> Error {
        Error::new(self.path.display(), rule, help)
    }

    /// So many bytes from a place on; the caller has bounded how many.
    pub(super) fn at(&mut self, offset: u64, length: usize) -> Result<Vec<u8>, Error> {
        if offset.checked_add(length as u64).is_none_or(|end| end > self.bytes) {
            let rule = format!("{length} bytes should stand from byte {offset} on, and the file has {}", self.bytes);
            return Err(self.damaged(rule));
        }
        let mut found = vec![0; length];
        let failed = |error: io::Error| unreadable(self.path, &error);
        self.source.seek(SeekFrom::Start(offset)).map_err(failed)?;
        self.source.read_exact(&mut found).map_err(failed)?;
        Ok(found)
    }

    /// At most 8 bytes as a number.
    fn number(&self, bytes: &[u8]) -> u64 {
        let put = |value: u64, &byte: &u8| value << 8 | u64::from(byte);
        if self.big_endian { bytes.iter().fold(0, put) } else { bytes.iter().rev().fold(0, put) }
    }

    /// The directory at a place.
    pub(super) fn directory(&mut self, offset: u64) -> Result<Directory, Error> {
        // Bytes of the count of tags, of a tag, and of an offset.
        let (count_bytes, entry_bytes, word) = if self.big { (8, 20, 8) } else { (2, 12, 4) };
        let count = self.at(offset, count_bytes)?;
        let count = self.number(&count);
        if count > MOST_TAGS {
            return Err(self.damaged(format!("a directory of {count} tags, and it may have {MOST_TAGS}")));
        }
        let entries_bytes = count as usize * entry_bytes;
        let bytes = self.at(offset + count_bytes as u64, entries_bytes + word)?;
        let mut entries = BTreeMap::new();
        for entry in bytes[..entries_bytes].chunks_exact(entry_bytes) {
            let tag = self.number(&entry[..2]) as u16;
            let kind = self.number(&entry[2..4]) as u16;
            let count = self.number(&entry[4..4 + word]);
            if entries.insert(tag, TagNumbers { kind, count, field: entry[4 + word..].to_vec() }).is_some() {
                return Err(self.damaged(format!("the tag {tag} is there twice")));
            }
        }
        Ok(Directory { entries, next: self.number(&bytes[entries_bytes..]) })
    }

    /// The whole numbers of a tag, of which there may be `most`; `None` where the directory has no such tag.
    pub(super) fn numbers(&mut self, directory: &Directory, tag: Tag, most: usize) -> Result<Option<Vec<u64>>, Error> {
        let Some(TagNumbers { kind, count, field }) = directory.entries.get(&tag.0) else { return Ok(None) };
        let width = match kind {
            1 => 1,
            3 => 2,
            4 => 4,
            16 => 8,
            _ => return Err(self.damaged(format!("the tag {tag} is of type {kind}, and must hold whole numbers"))),
        };
        if *count == 0 || *count > most as u64 {
            let rule = format!("the tag {tag} has {count} numbers, and must have 1 to {most}");
            return Err(self.damaged(rule));
        }
        let length = *count as usize * width;
        let bytes = match field.get(..length) {
            Some(inside) => inside.to_vec(),
            None => self.at(self.number(field), length)?,
        };
        Ok(Some(bytes.chunks_exact(width).map(|bytes| self.number(bytes)).collect()))
    }

    /// The one number of a tag, or what stands for it where it is missing.
    pub(super) fn one(&mut self, directory: &Directory, tag: Tag, default: u64) -> Result<u64, Error> {
        Ok(self.numbers(directory, tag, 1)?.map_or(default, |numbers| numbers[0]))
    }

    /// The one number that a tag gives for every sample of a pixel, or what stands for it where it is missing.
    pub(super) fn each(&mut self, directory: &Directory, tag: Tag, default: u64) -> Result<u64, Error> {
        let numbers = self.numbers(directory, tag, MOST_SAMPLES)?.unwrap_or_else(|| vec![default]);
        match numbers.iter().all(|number| *number == numbers[0]) {
            true => Ok(numbers[0]),
            false => {
                let rule = format!("the samples of a pixel differ in {tag}: {numbers:?}");
                Err(self.refused(rule, "export it with 16 bits in every sample"))
            }
        }
    }
}

impl Directory {
    /// Whether it has a tag.
    pub(super) fn has(&self, tag: Tag) -> bool {
        self.entries.contains_key(&tag.0)
    }
}

/// Samples of a pixel, at most: red, green, blue and an opacity.
pub(super) const MOST_SAMPLES: usize = 4;
