//! Do pictures survive their files, ours and those of other programs? And does a bad file end in a message?

use biprism::io::exr::{Channel, read_channels};
use biprism::io::read;
use biprism::io::{CurveSource, Metadata, Notes};
use biprism::io::{exr, png};
use biprism::raster::transfer::{Transfer, luminance};
use biprism::raster::{MAX_PIXELS, MAX_SIDE_PX, Raster};
use proptest::prelude::*;
use std::path::{Path, PathBuf};

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/pictures").join(name)
}

fn fixtures() -> Vec<PathBuf> {
    let folder = fixture("");
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|end| end == "png" || end == "exr"));
    paths.sort();
    paths
}

/// The sample that make.py puts at column i, row j, channel c, from 0 to 1.
fn value(depth: u32, i: usize, j: usize, c: usize) -> f64 {
    let scale = if depth == 16 { 257 } else { 1 };
    let levels = 1usize << depth;
    ((scale * (37 * i + 101 * j + 59 * c)) % levels) as f64 / (levels - 1) as f64
}

/// The 7 x 5 picture of a function of column and row.
fn picture(light: impl Fn(usize, usize) -> f64) -> Raster<f32> {
    Raster::from_data(7, 5, (0..35).map(|k| light(k % 7, k / 7) as f32).collect())
}

fn read_as(name: &str, stated: Option<Transfer>) -> (Raster<f32>, Metadata) {
    read(&fixture(name), stated).unwrap_or_else(|problem| panic!("{problem}"))
}

fn refusal(name: &str, stated: Option<Transfer>) -> String {
    let problem = read(&fixture(name), stated).unwrap_err();
    assert!(problem.place.ends_with(name) && !problem.help.is_empty());
    problem.rule
}

#[test]
fn png_of_any_depth_and_colour_becomes_linear_light() {
    for depth in [1, 2, 4, 8, 16] {
        let (found, metadata) = read_as(&format!("grey{depth}.png"), None);
        assert_eq!(found, picture(|i, j| value(depth, i, j, 0)), "{depth} bit");
        assert_eq!(metadata.samples, format!("{depth}-bit grey"));
        assert_eq!((metadata.transfer.as_str(), metadata.transfer_source.as_str()), ("linear", "gAMA chunk"));
    }
    assert_eq!(read_as("grey16_interlaced.png", None).0, read_as("grey16.png", None).0);

    let colour = |depth, i, j, curve: Transfer| {
        let light = |c| curve.decode(value(depth, i, j, c));
        luminance(light(0), light(1), light(2))
    };
    let (found, metadata) = read_as("rgb16.png", None);
    assert_eq!(found, picture(|i, j| colour(16, i, j, Transfer::Linear)));
    assert!(metadata.from_colour);
    for name in ["rgb8_srgb.png", "rgba8_opaque.png"] {
        let (found, metadata) = read_as(name, None);
        assert_eq!(found, picture(|i, j| colour(8, i, j, Transfer::Srgb)), "{name}");
        assert_eq!((metadata.transfer.as_str(), metadata.transfer_source.as_str()), ("sRGB", "sRGB chunk"));
    }
    let grey = picture(|i, j| Transfer::Srgb.decode(value(8, i, j, 0)));
    assert_eq!(read_as("greya8_opaque.png", None).0, grey);

    // Grey through three weights is grey to one rounding.
    let (found, metadata) = read_as("palette2.png", None);
    let expected = picture(|i, j| Transfer::Srgb.decode(value(2, i, j, 0)));
    assert_eq!(metadata.samples, "2-bit palette");
    for (a, b) in found.data().iter().zip(expected.data()) {
        assert!((a - b).abs() <= f32::EPSILON);
    }
}

#[test]
fn a_transfer_curve_is_never_guessed() {
    assert!(refusal("grey8_silent.png", None).contains("does not say"));
    assert!(refusal("rgb8_icc.png", None).contains("ICC"));
    assert!(refusal("grey8_cicp_pq.png", None).contains("transfer curve 16"));
    for name in ["grey8_silent.png", "grey8_cicp_pq.png"] {
        let (found, metadata) = read_as(name, Some(Transfer::Srgb));
        assert_eq!(found, picture(|i, j| Transfer::Srgb.decode(value(8, i, j, 0))), "{name}");
        assert_eq!(metadata.transfer_source, "stated by the caller");
    }
    assert_eq!(read_as("grey8_cicp_linear.png", None).0, picture(|i, j| value(8, i, j, 0)));

    let (found, metadata) = read_as("grey8_power.png", None);
    assert_eq!(found, picture(|i, j| libm::pow(value(8, i, j, 0), 1.0 / 0.45455)));
    assert_eq!(metadata.transfer, "power 2.2000");

    // A statement against the file's own chunk is refused, unless it is forced, and that is on record.
    let against = refusal("grey8.png", Some(Transfer::Srgb));
    assert!(against.contains("stated as sRGB") && against.contains("gAMA chunk says linear"), "{against}");
    let (found, metadata) = read(&fixture("grey8.png"), CurveSource::Forced(Transfer::Srgb)).unwrap();
    assert_eq!(found, picture(|i, j| Transfer::Srgb.decode(value(8, i, j, 0))));
    assert!(metadata.transfer_source.contains("against the gAMA chunk: linear"), "{}", metadata.transfer_source);
    assert!(refusal("y_half.exr", Some(Transfer::Srgb)).contains("linear light"));

    // Values without a curve may be taken as they are; those with one are light all the same, and a curve that is asked
    // for by a code of its own is not taken for none.
    let stored = |name: &str| read(&fixture(name), CurveSource::FileOrStored);
    for name in ["grey8_silent.png", "rgb8_icc.png"] {
        assert!(stored(name).unwrap().1.is_as_stored(), "{name}");
    }
    assert_eq!(stored("grey8_silent.png").unwrap().0, picture(|i, j| value(8, i, j, 0)));
    assert!(!stored("grey8_power.png").unwrap().1.is_as_stored());
    assert!(stored("grey8_cicp_pq.png").is_err());
}

#[test]
fn a_transparent_pixel_is_refused_with_its_place() {
    assert!(refusal("rgba8_transparent.png", None).contains("pixel (4, 3)"));
}

#[test]
fn exr_of_any_type_packing_and_layout_becomes_linear_light() {
    let eighths = |i: usize, j: usize, c: usize| value(8, i, j, c) * 255.0 / 256.0;
    for (name, samples) in
        [("y_half.exr", "f16 Y"), ("y_float.exr", "f32 Y"), ("y_tiled.exr", "f32 Y"), ("two_parts.exr", "f16 Y")]
    {
        let (found, metadata) = read_as(name, None);
        assert_eq!(found, picture(|i, j| eighths(i, j, 0)), "{name}");
        assert_eq!(metadata.samples, samples);
    }
    assert_eq!(read_as("y_uint.exr", Some(Transfer::Linear)).0, picture(|i, j| value(8, i, j, 0) * 255.0));
    let (found, metadata) = read_as("rgb_half.exr", None);
    assert_eq!(found, picture(|i, j| luminance(eighths(i, j, 0), eighths(i, j, 1), eighths(i, j, 2))));
    assert!(metadata.from_colour);

    let board = (0..1600).map(|k| 0.25 + 0.5 * ((k % 40 / 8 + k / 40 / 8) % 2) as f32).collect();
    let board = Raster::from_data(40, 40, board);
    for packing in ["rle", "zips", "zip", "piz", "pxr24"] {
        assert_eq!(read_as(&format!("board_{packing}.exr"), None).0, board, "{packing}");
    }
}

#[test]
fn exr_without_a_picture_of_light_says_what_it_has() {
    assert!(refusal("depth_only.exr", None).contains("it has Z"));
    assert!(refusal("not_finite.exr", None).contains("Y is inf at pixel (0, 0)"));
    assert!(refusal("y_window.exr", None).contains("7 x 5 px at (2, 1) of a view of 16 x 16 px at (0, 0)"));
    assert!(read_channels(&fixture("y_half.exr"), &["Y", "board.U"]).unwrap_err().rule.contains("it has Y"));
}

#[test]
fn sixteen_bit_grey_comes_back_to_the_last_bit() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("a.png");
    let notes = Notes { json: "{\"name\":\"Prüfbild 🎯\"}", pitch_mm: Some(0.0055) };
    for transfer in [Transfer::Linear, Transfer::Srgb] {
        let all = (0..65536).map(|k| transfer.decode(f64::from(k) / 65535.0) as f32).collect();
        let all = Raster::from_data(256, 256, all);
        assert_eq!(png::write_grey16(&path, &all, transfer, &notes).unwrap(), 0);
        let (back, metadata) = read(&path, None).unwrap();
        assert_eq!(back, all);
        assert_eq!(metadata.transfer, transfer.name());
        assert_eq!(metadata.texts["biprism"], notes.json);
        assert_eq!(metadata.texts["Software"], "biprism");
        assert!(metadata.texts["Transfer"].starts_with(transfer.name()));
        // Whole pixels in a metre: half of one in 181818.
        assert!((metadata.pitch_mm.unwrap() / 0.0055 - 1.0).abs() <= 0.5 / 181_818.0);
    }
}

#[test]
fn figures_are_opaque_srgb() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("a.png");
    let grey = Raster::from_data(2, 1, vec![0u8, 188]);
    png::write_rgb(&path, &grey.map(|v| [v; 3]), &Notes::default()).unwrap();
    let expected = Transfer::Srgb.decode(188.0 / 255.0);
    assert!((f64::from(read(&path, None).unwrap().0.get(1, 0)) - expected).abs() < 1e-7);
    png::write_rgba(&path, &grey.map(|v| [v, v, v, 255]), &Notes::default()).unwrap();
    assert!((f64::from(read(&path, None).unwrap().0.get(1, 0)) - expected).abs() < 1e-7);
}

#[test]
fn ground_truth_comes_back_to_the_last_bit() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("a.exr");
    let light = Raster::from_data(33, 20, (0..660).map(|k| k as f32 / 7.0).collect());
    let wild = vec![f32::NAN, f32::NEG_INFINITY, -0.0, f32::from_bits(1), f32::MAX];
    let wild = Raster::from_data(33, 20, wild.into_iter().cycle().take(660).collect());
    let classes = Raster::from_data(33, 20, (0..660u32).map(|k| k.wrapping_mul(2_654_435_761)).collect());
    let written =
        vec![Channel::f32("Y", light.clone()), Channel::f32("board.U", wild.clone()), Channel::u32("class", classes)];
    let notes = Notes { json: "{\"name\":\"Prüfbild\"}", pitch_mm: Some(0.0055) };
    exr::write(&path, written.clone(), &notes).unwrap();

    let back = read_channels(&path, &["class", "Y", "board.U"]).unwrap();
    assert_eq!((&back[0], &back[1]), (&written[2], &written[0]));
    let exr::ChannelSamples::F32(back_wild) = &back[2].samples else { panic!("f32 expected") };
    assert!(back_wild.data().iter().zip(wild.data()).all(|(a, b)| a.to_bits() == b.to_bits()));

    let (back, metadata) = read(&path, None).unwrap();
    assert_eq!(back, light);
    let json: serde_json::Value = serde_json::from_str(&metadata.texts["biprism"]).unwrap();
    assert_eq!(json["name"], "Prüfbild");
    assert!((metadata.pitch_mm.unwrap() / 0.0055 - 1.0).abs() < 1e-6);
}

#[test]
fn what_is_no_picture_is_refused() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("picture.png");
    let rule = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        read(&path, None).unwrap_err().rule
    };
    assert!(rule(b"").contains("is empty"));
    assert!(rule(b"GIF89a...").contains("PNG, OpenEXR, TIFF"));
    assert!(rule(b"\x89PNG\r\n\x1a\n").contains("damaged"));
    assert!(rule(b"\x76\x2f\x31\x01").contains("damaged"));
    assert!(read(&directory.path().join("none.png"), None).unwrap_err().rule.contains("cannot be read"));
    assert!(read(directory.path(), None).unwrap_err().rule.contains("directory"));
    // The content decides, not the name.
    std::fs::copy(fixture("y_half.exr"), &path).unwrap();
    assert_eq!(read(&path, None).unwrap().1.format, "EXR");
}

#[test]
fn an_exr_that_holds_a_line_twice_is_damaged() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("a.exr");
    let mut bytes = std::fs::read(fixture("y_half.exr")).unwrap();
    // Five lines of 7 f16 at the end, each after its number and its length. Line 1 says that it is line 0.
    let line = bytes.len() - 4 * (4 + 4 + 14);
    assert_eq!(bytes[line..line + 4], 1i32.to_le_bytes());
    bytes[line] = 0;
    std::fs::write(&path, bytes).unwrap();
    assert!(read(&path, None).unwrap_err().rule.contains("there twice"));
}

/// The size of a PNG's header changed, with the check sum made anew.
fn png_of_size(width: u32, height: u32) -> Vec<u8> {
    let mut bytes = std::fs::read(fixture("grey16.png")).unwrap();
    bytes[16..20].copy_from_slice(&width.to_be_bytes());
    bytes[20..24].copy_from_slice(&height.to_be_bytes());
    let mut crc = !0u32;
    for &byte in &bytes[12..29] {
        crc ^= u32::from(byte);
        for _ in 0..8 {
            crc = if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 };
        }
    }
    bytes[29..33].copy_from_slice(&(!crc).to_be_bytes());
    bytes
}

/// The data window of an EXR changed: its last column and row.
fn exr_of_size(width: i32, height: i32) -> Vec<u8> {
    let mut bytes = std::fs::read(fixture("y_half.exr")).unwrap();
    let name = b"dataWindow\0box2i\0";
    let start = bytes.windows(name.len()).position(|window| window == name).unwrap() + name.len() + 4;
    bytes[start + 8..start + 12].copy_from_slice(&(width - 1).to_le_bytes());
    bytes[start + 12..start + 16].copy_from_slice(&(height - 1).to_le_bytes());
    bytes
}

#[test]
fn size_limits_are_checked_before_memory_is_taken() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("a");
    let side = MAX_SIDE_PX as i32 + 1;
    let square = (MAX_PIXELS as f64).sqrt() as i32 + 1;
    for (width, height, rule) in [
        (side, 1, "at most 65535 pixels each way"),
        (1, side, "at most 65535 pixels each way"),
        (square, square, "at most 268435456 pixels"),
        (i32::MAX, i32::MAX, "at most 65535 pixels each way"),
    ] {
        for bytes in [png_of_size(width as u32, height as u32), exr_of_size(width, height)] {
            std::fs::write(&path, bytes).unwrap();
            let found = read(&path, None).unwrap_err().rule;
            assert!(found.contains(rule) || found.contains("window size"), "{width} x {height}: {found}");
        }
    }
    std::fs::write(&path, png_of_size(0, 5)).unwrap();
    assert!(read(&path, None).unwrap_err().rule.contains("Invalid image dimensions"));
}

#[test]
fn every_truncation_is_noticed() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("a");
    for whole in fixtures() {
        std::fs::copy(&whole, &path).unwrap();
        let file = std::fs::File::options().write(true).open(&path).unwrap();
        for length in (0..file.metadata().unwrap().len()).rev() {
            file.set_len(length).unwrap();
            assert!(read(&path, Some(Transfer::Linear)).is_err(), "{} cut to {length}", whole.display());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    /// A damaged file may still hold a picture, but it never ends in a panic or in values that are no numbers.
    #[test]
    fn a_damaged_file_ends_in_a_picture_or_a_problem(
        which: prop::sample::Index,
        changes in prop::collection::vec((any::<prop::sample::Index>(), change()), 1..6),
    ) {
        let paths = fixtures();
        let mut bytes = std::fs::read(which.get(&paths)).unwrap();
        for (at, change) in changes {
            let at = at.index(bytes.len());
            let end = bytes.len().min(at + change.len());
            bytes[at..end].copy_from_slice(&change[..end - at]);
        }
        let mut file = tempfile::NamedTempFile::new().unwrap();
        std::io::Write::write_all(&mut file, &bytes).unwrap();
        match read(file.path(), Some(Transfer::Linear)) {
            Ok((picture, _)) => prop_assert!(picture.data().iter().all(|value| value.is_finite())),
            Err(problem) => prop_assert!(!problem.rule.is_empty() && !problem.help.is_empty()),
        }
    }
}

/// One byte, or a number that sizes trip over.
fn change() -> impl Strategy<Value = Vec<u8>> {
    let extremes = prop::sample::select(vec![0, 1, -1, 0xffff, 0x1_0000, i32::MAX, i32::MIN]);
    prop_oneof![any::<u8>().prop_map(|byte| vec![byte]), extremes.prop_map(|value| value.to_le_bytes().to_vec())]
}

/// A photograph through the `image` library: the curve must be stated, and the light comes back to a level.
#[test]
fn jpeg_bmp_and_pnm_are_read_when_their_curve_is_stated() {
    let folder = tempfile::tempdir().unwrap();
    let grey = image::GrayImage::from_fn(64, 48, |x, _| image::Luma([if x < 32 { 40 } else { 200 }]));
    for (name, format, tolerance) in [("a.jpg", "JPEG", 3.0), ("a.bmp", "BMP", 0.0), ("a.pgm", "PNM", 0.0)] {
        let path = folder.path().join(name);
        grey.save(&path).unwrap();
        let silent = read(&path, None).unwrap_err();
        assert!(silent.help.contains("--transfer"), "{}", silent.help);
        let (picture, metadata) = read(&path, Some(Transfer::Srgb)).unwrap();
        assert_eq!((metadata.format, picture.width(), picture.height()), (format, 64, 48));
        for (x, level) in [(10, 40.0), (50, 200.0)] {
            let light = |level: f64| Transfer::Srgb.decode(level / 255.0);
            let (low, high) = (light(level - tolerance - 1e-3), light(level + tolerance + 1e-3));
            let seen = f64::from(picture.get(x, 20));
            assert!((low..high).contains(&seen), "{name}: {seen} outside {low}..{high}");
        }
        let whole = std::fs::read(&path).unwrap();
        std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
        let broken = read(&path, Some(Transfer::Srgb));
        assert!(broken.is_err(), "{name}: half a file is no picture");
    }
}

/// The light of pure red, green and blue, by hand (Rec. ITU-R BT.709), through each format that holds colours.
#[test]
fn colours_weigh_by_their_names() {
    let folder = tempfile::tempdir().unwrap();
    let weights = [0.2126, 0.7152, 0.0722];
    for (channel, weight) in weights.into_iter().enumerate() {
        let pure = |c: usize| if c == channel { 1.0 } else { 0.0 };
        let path = |ending: &str| folder.path().join(format!("{channel}.{ending}"));
        png::write_rgb(
            &path("png"),
            &Raster::filled(16, 16, [0, 1, 2].map(|c| 255 * pure(c) as u8)),
            &Notes::default(),
        )
        .unwrap();
        let plane = |c: usize| Raster::filled(16, 16, pure(c) as f32);
        let planes = ["R", "G", "B"].into_iter().enumerate().map(|(c, name)| Channel::f32(name, plane(c)));
        exr::write(&path("exr"), planes.collect(), &Notes::default()).unwrap();
        let photo = image::RgbImage::from_pixel(16, 16, image::Rgb([0, 1, 2].map(|c| 255 * pure(c) as u8)));
        photo.save(path("jpg")).unwrap();
        photo.save(path("bmp")).unwrap();
        // A JPEG keeps a pure colour to a few levels of 8 bits.
        for (ending, bound) in [("png", 1e-6), ("exr", 1e-6), ("bmp", 1e-6), ("jpg", 0.02)] {
            let (picture, _) = read(&path(ending), (ending != "exr").then_some(Transfer::Srgb))
                .unwrap_or_else(|problem| panic!("{problem}"));
            let found = f64::from(picture.get(8, 8));
            assert!((found - weight).abs() < bound, "channel {channel} of a {ending}: {found}, not {weight}");
        }
    }
}
