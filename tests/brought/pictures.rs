//! Pictures that users bring: too large, too short, damaged, and of every kind.

use super::Place;
use biprism::io::read;
use biprism::raster::transfer::Transfer;
use std::fs;
use std::path::Path;
use std::process::Command;

/// A BMP of 8 bits a pixel with a palette of 256 greys, packed by run lengths where `rle`.
fn bmp([width, height]: [i32; 2], rle: bool, pixels: &[u8]) -> Vec<u8> {
    let mut file = b"BM".to_vec();
    file.extend([0; 8]);
    file.extend((54u32 + 1024).to_le_bytes());
    file.extend(40u32.to_le_bytes());
    file.extend(width.to_le_bytes());
    file.extend(height.to_le_bytes());
    file.extend([1, 0, 8, 0]);
    file.extend(u32::from(rle).to_le_bytes());
    file.extend([0; 20]);
    file.extend((0..=255).flat_map(|v| [v, v, v, 0]));
    file.extend(pixels);
    file
}

/// A PNG of zeros, of 8 bits grey.
fn png_of_zeros(path: &Path, side: u32) {
    use std::io::Write;
    let file = fs::File::create(path).expect("it is made");
    let mut encoder = png::Encoder::new(std::io::BufWriter::new(file), side, side);
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header().expect("it is written");
    let mut rows = writer.stream_writer().expect("it is written");
    let row = vec![0; side as usize];
    (0..side).for_each(|_| rows.write_all(&row).expect("it is written"));
    rows.finish().expect("it is written");
}

/// The header is asked before memory is taken: with less than the picture would need, a sentence about the picture comes and
/// none about memory that is not to be had.
#[cfg(target_os = "linux")]
#[test]
fn a_picture_beyond_the_limit_of_memory_takes_none() {
    let place = Place::new();
    png_of_zeros(&place.path("zeros.png"), 16384);
    assert!(fs::metadata(place.path("zeros.png")).expect("it is there").len() < 2_000_000);
    fs::write(place.path("rle.bmp"), bmp([9000, 9000], true, &[0, 1])).expect("it is written");
    fs::write(place.path("long.bmp"), bmp([9000, 9000], false, &[0; 1000])).expect("it is written");
    fs::write(place.path("short.pgm"), "P5 20000 10000 255\n").expect("it is written");
    fs::write(place.path("text.ppm"), "P3 12000 9000 255\n1 2 3").expect("it is written");
    fs::write(place.path("wide.pgm"), "P5 65535 4096 65535\n1").expect("it is written");
    for (name, word) in [
        ("zeros.png", "the limit is 1024 MiB"),
        ("rle.bmp", "need"),
        ("long.bmp", "need"),
        ("short.pgm", "need"),
        ("text.ppm", "need"),
        ("wide.pgm", "the limit is 1024 MiB"),
    ] {
        let script = format!(
            "ulimit -v 700000; RAYON_NUM_THREADS=2 exec {} corners {name} --transfer linear",
            env!("CARGO_BIN_EXE_biprism")
        );
        let output =
            Command::new("sh").current_dir(place.folder.path()).args(["-c", &script]).output().expect("a shell");
        let words = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && words.contains(word), "{name}: {words}");
    }
}

/// What the packing of a format cannot hold is not there.
#[test]
fn a_file_too_short_for_its_pixels_is_refused() {
    let place = Place::new();
    let needs = |name: &str, bytes: &[u8]| {
        fs::write(place.path(name), bytes).expect("it is written");
        let told = read(&place.path(name), Some(Transfer::Linear)).expect_err(name);
        assert!(told.rule.contains("need"), "{name}: {told}");
    };
    needs("a.bmp", &bmp([300, 100], false, &[7; 300 * 100 - 4]));
    needs("b.bmp", &bmp([300, 100], true, &[200; 100 * 4 - 2]));
    needs("c.pgm", b"P5\n4 4\n255\n123456789012345");
    needs("d.pbm", b"P4 17 2\n12345");
    needs("e.pbm", b"P1 4 4\n0101 0101 010");
    needs("f.ppm", b"P6 3 2 65535\n123456789012345678901234567890");
    // As long as it must be, all are read.
    fs::write(place.path("a.bmp"), bmp([300, 100], false, &[7; 300 * 100])).expect("it is written");
    assert!(read(&place.path("a.bmp"), Some(Transfer::Linear)).is_ok());
    let row: Vec<u8> = [255, 200, 45, 100, 0, 0].into();
    fs::write(place.path("b.bmp"), bmp([300, 2], true, &row.repeat(2))).expect("it is written");
    let (picture, _) = read(&place.path("b.bmp"), Some(Transfer::Linear)).expect("whole");
    assert_eq!((picture.get(254, 0), picture.get(299, 1)), (200.0 / 255.0, 100.0 / 255.0));
}

/// Cut anywhere, a JPEG lacks the marker of its end; where one is written behind what is left, the picture is still not whole.
#[test]
fn a_jpeg_that_is_cut_off_is_damaged() {
    let place = Place::new();
    let path = place.path("a.jpg");
    image::GrayImage::from_fn(64, 48, |x, y| image::Luma([(x * 3 + y) as u8])).save(&path).expect("it is written");
    let whole = fs::read(&path).expect("it is there");
    assert!(read(&path, Some(Transfer::Srgb)).is_ok());
    // What a camera appends to its pictures is no fault.
    fs::write(&path, [&whole[..], b"trailer"].concat()).expect("it is written");
    assert!(read(&path, Some(Transfer::Srgb)).is_ok());
    for length in (2..whole.len() - 1).step_by(7) {
        fs::write(&path, &whole[..length]).expect("it is written");
        let told = read(&path, Some(Transfer::Srgb)).expect_err("it is cut").rule;
        assert!(told.contains("damaged") || told.contains("bytes"), "{length} of {}: {told}", whole.len());
    }
    for length in (2..whole.len() - 4).step_by(7) {
        fs::write(&path, [&whole[..length], b"\xff\xd9"].concat()).expect("it is written");
        assert!(read(&path, Some(Transfer::Srgb)).is_err(), "{length} of {}", whole.len());
    }
}

/// Netpbm's formats, by their definitions: values over the brightest, bits that are dark where they are 1.
#[test]
fn every_kind_of_pnm_gives_its_light() {
    let place = Place::new();
    let path = place.path("a.pnm");
    let read_bytes = |bytes: &[u8]| {
        fs::write(&path, bytes).expect("it is written");
        read(&path, Some(Transfer::Linear)).map(|(picture, _)| picture.data().to_vec())
    };
    let grey = vec![0.0, 0.25, 0.5, 1.0];
    for bytes in [
        &b"P5 2 2 4\n\x00\x01\x02\x04"[..],
        b"P5\n# a remark\n2 # another\n2\n4\n\x00\x01\x02\x04 and more",
        b"P2 2 2 4\n0 1\n2\n\n4",
        b"P7\nWIDTH 2\nHEIGHT 2\nDEPTH 1\nMAXVAL 4\nTUPLTYPE GRAYSCALE\nENDHDR\n\x00\x01\x02\x04",
        b"P5 2 2 400\n\x00\x00\x00\x64\x00\xc8\x01\x90",
    ] {
        assert_eq!(read_bytes(bytes).expect("it is right"), grey, "{:?}", String::from_utf8_lossy(bytes));
    }
    assert_eq!(read_bytes(b"P4 3 2\n\x40\xa0").expect("it is right"), [1.0, 0.0, 1.0, 0.0, 1.0, 0.0]);
    assert_eq!(read_bytes(b"P1 3 2\n010\n1 0 1").expect("it is right"), [1.0, 0.0, 1.0, 0.0, 1.0, 0.0]);
    // White is 1, to the rounding of the luminance's weights.
    let colours = read_bytes(b"P6 2 1 255\n\xff\xff\xff\x00\x00\x00").expect("it is right");
    assert!((colours[0] - 1.0).abs() < 1e-6 && colours[1] == 0.0, "{colours:?}");
    assert_eq!(read_bytes(b"P3 2 1 9\n9 9 9 0 0 0").expect("it is right"), colours);
    for (bytes, word) in [
        (&b"P5 2 2 4\n\x00\x01\x05\x04"[..], "pixel (0, 1) is 5"),
        (b"P2 2 2 4\n0 1 2 7", "pixel (1, 1) is 7"),
        (b"P2 2 2 4\n0 1 2 x", "0x78"),
        (b"P2 2 2 99999\n0 1 2 3", "99999"),
        (b"P2 2 2 0\n0 0 0 0", "within 1"),
        (b"P5 0 2 255\n", "at least one pixel"),
        (b"P5 -2 2 255\n", "whole number"),
        (b"P7\nWIDTH 2\nHEIGHT 2\nDEPTH 2\nMAXVAL 4\nTUPLTYPE GRAYSCALE_ALPHA\nENDHDR\n", "opacity"),
        (b"P7\nWIDTH 2\nWIDTH 2\nENDHDR\n", "twice"),
        (b"P7\nWIDTH 2\nENDHDR\n", "must give"),
    ] {
        let told = read_bytes(bytes).expect_err("it is wrong").rule;
        assert!(told.contains(word), "{}: {told}", String::from_utf8_lossy(bytes));
    }
}

/// A text that unpacks without end is not unpacked.
#[test]
fn a_text_that_is_a_bomb_stays_packed() {
    let place = Place::new();
    let path = place.path("a.png");
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2, 2);
    encoder.set_source_gamma(png::ScaledFloat::from_scaled(100_000));
    encoder.add_ztxt_chunk("bomb".to_owned(), "x".repeat(3 << 20)).expect("it is memory");
    encoder.add_ztxt_chunk("words".to_owned(), "y".repeat(1 << 10)).expect("it is memory");
    encoder.write_header().expect("it is memory").write_image_data(&[0; 4]).expect("it is memory");
    fs::write(&path, bytes).expect("it is written");
    let (_, metadata) = read(&path, None).expect("a picture");
    assert!(metadata.texts.contains_key("words") && !metadata.texts.contains_key("bomb"));
}
