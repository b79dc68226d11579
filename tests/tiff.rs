//! Do TIFF files of other programs become the light that they stand for, and is every other one refused with a sentence?

use biprism::io::{Metadata, read};
use biprism::raster::transfer::{Transfer, luminance};
use biprism::raster::{MAX_SIDE_PX, Raster};
use std::fs;
use std::path::{Path, PathBuf};

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/pictures/tiff").join(format!("{name}.tif"))
}

/// The sample that make.py puts at column i, row j, channel c, from 0 to 1.
fn value(depth: u32, i: usize, j: usize, c: usize) -> f64 {
    let scale = if depth == 16 { 257 } else { 1 };
    let levels = 1usize << depth;
    ((scale * (37 * i + 101 * j + 59 * c)) % levels) as f64 / (levels - 1) as f64
}

fn picture([width, height]: [usize; 2], light: impl Fn(usize, usize) -> f64) -> Raster<f32> {
    Raster::from_data(width, height, (0..width * height).map(|k| light(k % width, k / width) as f32).collect())
}

fn read_as(name: &str, stated: Transfer) -> (Raster<f32>, Metadata) {
    read(&fixture(name), Some(stated)).unwrap_or_else(|problem| panic!("{problem}"))
}

fn refusal(path: &Path) -> String {
    let problem = read(path, Some(Transfer::Linear)).unwrap_err();
    assert!(!problem.help.is_empty() && problem.place.contains(".tif"), "{problem}");
    problem.rule
}

const SMALL: [usize; 2] = [7, 5];

#[test]
fn grey_of_8_and_16_bits_in_both_byte_orders() {
    for transfer in [Transfer::Linear, Transfer::Srgb] {
        for name in ["grey8", "grey8_packbits", "grey8_lzw", "grey8_white_is_zero", "grey8_opaque", "grey8_thumbnail"] {
            let (found, metadata) = read_as(name, transfer);
            assert_eq!(found, picture(SMALL, |i, j| transfer.decode(value(8, i, j, 0))), "{name}");
            assert_eq!((metadata.format, metadata.samples.as_str()), ("TIFF", "8 bit grey"), "{name}");
            assert!(!metadata.from_colour && metadata.transfer == transfer.name());
        }
        for name in ["grey16_big_endian", "grey16_big_file"] {
            let (found, metadata) = read_as(name, transfer);
            assert_eq!(found, picture(SMALL, |i, j| transfer.decode(value(16, i, j, 0))), "{name}");
            assert_eq!(metadata.samples, "16 bit grey");
        }
    }
}

#[test]
fn colours_together_or_in_planes_plain_or_as_differences() {
    let colour = |depth, curve: Transfer| {
        picture(SMALL, |i, j| {
            let light = |c| curve.decode(value(depth, i, j, c));
            luminance(light(0), light(1), light(2))
        })
    };
    for (depth, names) in [
        (8, &["rgb8_deflate", "rgb8_differences", "rgb8_opaque"][..]),
        (16, &["rgb16_differences", "rgb16_differences_big_endian", "rgb16_planar"]),
    ] {
        for (name, transfer) in names.iter().flat_map(|name| [(name, Transfer::Linear), (name, Transfer::Srgb)]) {
            let (found, metadata) = read_as(name, transfer);
            assert_eq!(found, colour(depth, transfer), "{name}");
            assert!(metadata.from_colour && metadata.samples == format!("{depth} bit RGB"), "{name}");
        }
    }
}

#[test]
fn tiles_with_margins_of_either_layout() {
    let wide = [40, 36];
    assert_eq!(read_as("tiles_grey8", Transfer::Linear).0, picture(wide, |i, j| value(8, i, j, 0)));
    let colour = picture(wide, |i, j| luminance(value(16, i, j, 0), value(16, i, j, 1), value(16, i, j, 2)));
    for name in ["tiles_rgb16", "tiles_planar"] {
        assert_eq!(read_as(name, Transfer::Linear).0, colour, "{name}");
    }
}

#[test]
fn what_is_no_picture_of_light_is_refused_by_name() {
    for (name, rule) in [
        ("no_transparent", "pixel (4, 3) is transparent"),
        ("no_float", "floating-point numbers of 32 bits, and must be whole numbers of 8 or 16 bits"),
        ("no_signed", "signed numbers of 16 bits"),
        ("no_32_bits", "whole numbers of 32 bits"),
        ("no_bits", "whole numbers of 1 bits"),
        ("no_samples", "a pixel has 6 samples, and must have 3"),
        ("no_inks", "inks (CMYK)"),
        ("no_palette", "colours of a palette"),
        ("no_jpeg", "YCbCr"),
        ("no_pages", "holds more than one picture"),
        ("no_orientation", "is to be turned"),
    ] {
        let found = refusal(&fixture(name));
        assert!(found.contains(rule), "{name}: {found}");
    }
    let silent = read(&fixture("grey8"), None).unwrap_err();
    assert!(silent.rule.contains("does not say") && silent.help.contains("--transfer"), "{silent}");
}

/// A TIFF of tags with numbers of 32 bits, and so many bytes of pixels behind them, from `PIXELS` on.
fn file_of(tags: &[(u16, u32, u32)], pixels: usize) -> Vec<u8> {
    let mut bytes = b"II*\0\x08\0\0\0".to_vec();
    bytes.extend((tags.len() as u16).to_le_bytes());
    for (tag, count, value) in tags {
        bytes.extend(tag.to_le_bytes());
        bytes.extend(4u16.to_le_bytes());
        bytes.extend(count.to_le_bytes());
        bytes.extend(value.to_le_bytes());
    }
    bytes.resize(PIXELS as usize, 0);
    bytes.resize(PIXELS as usize + pixels, 7);
    bytes
}

const PIXELS: u32 = 1024;

/// The tags of a grey picture of 4 x 2 in one strip, with some replaced, added, or (count 0) taken out.
fn tags(changes: &[(u16, u32, u32)]) -> Vec<(u16, u32, u32)> {
    let mut tags = vec![
        (256, 1, 4),
        (257, 1, 2),
        (258, 1, 8),
        (259, 1, 1),
        (262, 1, 1),
        (273, 1, PIXELS),
        (277, 1, 1),
        (278, 1, 2),
        (279, 1, 8),
    ];
    for change in changes {
        tags.retain(|tag| tag.0 != change.0);
        if change.1 > 0 {
            tags.push(*change);
        }
    }
    tags
}

/// Every number of a header that could ask for much is refused by itself, long before there is memory for it.
#[test]
fn hostile_headers_are_refused_in_no_time() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.tif");
    let write = |changes: &[(u16, u32, u32)], pixels| fs::write(&path, file_of(&tags(changes), pixels)).unwrap();
    write(&[], 8);
    assert_eq!(read(&path, Some(Transfer::Linear)).unwrap().0.get(3, 1), (7.0 / 255.0) as f32);
    let many = u32::MAX;
    let side = MAX_SIDE_PX as u32;
    for (changes, rule) in [
        (&[(256, 1, 0)][..], "0 x 2, and must have at least one pixel"),
        (&[(257, 1, 0)], "4 x 0, and must have at least one pixel"),
        (&[(256, 1, many)], "at most 65535 pixels each way"),
        (&[(256, 1, side), (257, 1, side)], "at most 268435456 pixels"),
        (&[(256, 0, 0)], "it has no ImageWidth"),
        (&[(262, 0, 0)], "it has no PhotometricInterpretation"),
        (&[(273, 0, 0)], "it has no StripOffsets"),
        // 2^32 strips: by their list, and by rows of a strip that ask for more than are allowed.
        (&[(273, many, PIXELS)], "StripOffsets has 4294967295 numbers, and must have 1 to 1"),
        (&[(279, many, PIXELS)], "StripByteCounts has 4294967295 numbers"),
        (&[(278, 1, 0)], "no pixel"),
        (&[(322, 1, 1), (323, 1, 1), (256, 1, 2000), (257, 1, 2000)], "cut into 4000000 strips or tiles"),
        (&[(322, 1, many), (323, 1, 16)], "its tiles are 4294967295 x 16"),
        (&[(322, 1, 0), (323, 1, 16)], "no pixel"),
        (&[(322, 1, 65536), (323, 1, 65536), (324, 1, PIXELS), (325, 1, 8)], "MiB of memory; the limit is 1024 MiB"),
        (&[(258, 2, PIXELS - 4)], "the samples of a pixel differ"),
        (&[(277, 1, 5)], "a pixel has 5 samples"),
        (&[(277, 1, many)], "a pixel has 4294967295 samples"),
        (&[(262, 1, 2), (277, 1, 65535)], "a pixel has 65535 samples"),
        (&[(339, 1, 3)], "floating-point"),
        (&[(259, 1, 7)], "packed by method 7"),
        (&[(317, 1, 3)], "Predictor is 3"),
        (&[(284, 1, 9)], "PlanarConfiguration is 9"),
        (&[(279, 1, 7)], "unpacks to 7 bytes, and must have 8"),
        (&[(273, 1, PIXELS + 1)], "8 bytes should stand from byte 1025 on"),
        (&[(273, 1, many)], "8 bytes should stand from byte 4294967295 on"),
        (&[(256, 1, 8192), (257, 1, 8192), (278, 1, 8192)], "pixels of its kind need 67108864 or more"),
        (&[(259, 1, 8), (256, 1, 8192), (257, 1, 8192), (278, 1, 8192)], "pixels of its kind need 65028 or more"),
        (&[(259, 1, 8)], "cannot be unpacked"),
        (&[(259, 1, 5), (279, 1, 1)], "unpacks to 0 bytes"),
        (&[(259, 1, 32773), (279, 1, 2)], "unpacks to 1 bytes, and must have 8"),
    ] {
        write(changes, 8);
        let started = std::time::Instant::now();
        let found = refusal(&path);
        assert!(found.contains(rule), "{changes:?}: {found}");
        assert!(started.elapsed().as_secs() < 2, "{changes:?}: {:?}", started.elapsed());
    }
    // A tag twice, and a directory that is its own next one.
    let mut twice = tags(&[]);
    twice.push((256, 1, 4));
    fs::write(&path, file_of(&twice, 8)).unwrap();
    assert!(refusal(&path).contains("the tag 256 is there twice"));
    let mut circle = file_of(&tags(&[(254, 1, 0)]), 8);
    let next = 8 + 2 + 12 * 10;
    circle[next] = 8;
    fs::write(&path, circle).unwrap();
    assert!(refusal(&path).contains("more than one picture"));
}

/// A strip that many tags share is read as often as there are strips, and no farther than a strip can need.
#[test]
fn a_file_of_overlapping_strips_costs_what_its_pixels_cost() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.tif");
    // 8192 strips of one row of 16 px, each of which claims the 16 MiB behind the header.
    let rows = 8192u32;
    let place = PIXELS + 4 * rows;
    let list = tags(&[(256, 1, 16), (257, 1, rows), (278, 1, 1), (259, 1, 32773), (273, rows, PIXELS), (279, rows, 0)]);
    let mut bytes = file_of(&list, 0);
    let lengths = bytes.len() as u32 + 4 * rows;
    let field = bytes.windows(2).position(|pair| pair == 279u16.to_le_bytes()).unwrap() + 8;
    bytes[field..field + 4].copy_from_slice(&lengths.to_le_bytes());
    (0..rows).for_each(|_| bytes.extend((place + 4 * rows).to_le_bytes()));
    (0..rows).for_each(|_| bytes.extend((1u32 << 24).to_le_bytes()));
    bytes.resize(bytes.len() + (1 << 24), 0xf1);
    fs::write(&path, bytes).unwrap();
    let started = std::time::Instant::now();
    let (found, _) = read(&path, Some(Transfer::Linear)).unwrap_or_else(|problem| panic!("{problem}"));
    assert_eq!(found, Raster::filled(16, rows as usize, (241.0 / 255.0) as f32));
    // What they claim is 128 GiB, which no machine reads in that time.
    assert!(started.elapsed().as_secs() < 5, "{:?}", started.elapsed());
}

#[test]
fn every_truncation_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.tif");
    for name in ["grey8", "grey8_packbits", "grey16_big_endian", "rgb16_planar", "tiles_rgb16", "grey8_white_is_zero"] {
        let whole = fs::read(fixture(name)).unwrap();
        for length in (0..whole.len()).rev() {
            fs::write(&path, &whole[..length]).unwrap();
            assert!(read(&path, Some(Transfer::Linear)).is_err(), "{name} cut to {length} of {}", whole.len());
        }
    }
}
