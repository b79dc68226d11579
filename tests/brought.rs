//! What users bring: files too large or too short for what they announce, names that are inputs and outputs at once.

use biprism::io::read;
use biprism::raster::transfer::Transfer;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

const CAMERA: &str = "name = \"small\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = 64\nheight_px = 36\n\
    pixel_pitch_um = 165\n";
const FLAT: &str = "[prism]\nkind = \"flat\"\nindex = 1.48\nridge_distance_mm = 78.472\nthickness_mm = 8.545\n";
const BOARD: &str = "[board]\ncolumns = 21\nrows = 21\nsquare_mm = 20.0\nposition_mm = [0.0, 0.0, 1000.0]\n";

struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    /// A folder with a scene in it.
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        fs::write(folder.path().join("scene.toml"), format!("{CAMERA}{FLAT}{BOARD}")).expect("it is written");
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn run(&self, args: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_biprism"));
        command.current_dir(self.folder.path()).args(args).stdin(Stdio::null()).output().expect("the command starts")
    }

    /// The words of a run that must be refused.
    fn refused(&self, args: &[&str]) -> String {
        let output = self.run(args);
        let words = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{args:?}: {words}");
        assert!(words.contains("help") && !words.contains("panicked"), "{args:?}: {words}");
        words
    }
}

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

/// Cut anywhere, a JPEG lacks the marker of its end.
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

/// Nothing that a run has read is written over, whatever it is called; nor are two outputs one file.
#[test]
fn what_was_read_is_never_written_over() {
    let place = Place::new();
    let copy = |from: &str, to: &str| fs::copy(place.path(from), place.path(to)).expect("it is there");
    assert!(place.run(&["render", "scene.toml", "--out", "a.png", "--out", "a.exr"]).status.success());
    assert!(place.run(&["corners", "a.png", "--out", "a.csv"]).status.success());
    copy("scene.toml", "prism.toml");
    copy("scene.toml", "report.json");
    copy("scene.toml", "cost.csv");
    copy("scene.toml", "scene.png");
    fs::create_dir(place.path("sub")).expect("a folder");
    let mut inputs = vec!["scene.toml", "prism.toml", "report.json", "cost.csv", "scene.png", "a.csv"];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("../scene.toml", place.path("sub/flat.png")).expect("a link");
        std::os::unix::fs::symlink("scene.png", place.path("link.png")).expect("a link");
        fs::hard_link(place.path("scene.png"), place.path("hard.png")).expect("a link");
        inputs.extend(["sub/flat.png", "link.png", "hard.png"]);
    }
    let before: Vec<Vec<u8>> = inputs.iter().map(|name| fs::read(place.path(name)).expect("it is there")).collect();
    let mut cases = vec![
        vec!["design", "prism.toml", "--out", "."],
        vec!["compare", "report.json", "--out", "."],
        vec!["cost", "cost.csv", "--out", ".", "--quick"],
        vec!["render", "scene.png", "--out", "scene.png"],
        vec!["render", "scene.png", "--out", "sub/../scene.png"],
        vec!["corners", "a.csv", "--out", "a.csv"],
        vec!["corners", "a.csv", "--out", "./a.csv"],
    ];
    if cfg!(unix) {
        cases.push(vec!["compare", "scene.toml", "--out", "sub"]);
        cases.push(vec!["render", "scene.png", "--out", "link.png"]);
        cases.push(vec!["render", "link.png", "--out", "scene.png"]);
        cases.push(vec!["render", "scene.png", "--out", "hard.png"]);
    }
    for args in cases {
        let words = place.refused(&args);
        assert!(words.contains("was read in this run"), "{args:?}: {words}");
    }
    for (name, bytes) in inputs.iter().zip(before) {
        assert!(fs::read(place.path(name)).expect("it is there") == bytes, "{name} was touched");
    }
    for second in ["b.png", "./b.png", "sub/../b.png"] {
        let words = place.refused(&["render", "scene.toml", "--out", "b.png", "--out", second]);
        assert!(words.contains("twice"), "{words}");
    }
    assert!(!place.path("b.png").exists() && !place.path("comparison.png").exists());
}

/// The clouds of a scene are read as well as the scene.
#[test]
fn clouds_and_meshes_are_not_written_over() {
    let place = Place::new();
    let cloud: String = (0..400)
        .map(|k| {
            let (x, y) = (f64::from(k % 20) - 1.0, f64::from(k / 20) - 10.0);
            format!("{x} {y} {}\n", 80.0 + 0.15 * x)
        })
        .collect();
    fs::write(place.path("front.xyz"), &cloud).expect("it is written");
    let plane: String = (0..400).map(|k| format!("{} {} 90\n", k % 20 - 1, k / 20 - 10)).collect();
    fs::write(place.path("back.png.xyz"), plane).expect("it is written");
    let prism = "[prism]\nkind = \"point_cloud\"\nindex = 1.48\nfront = { file = \"front.xyz\", degree = 2 }\n\
                 back = { file = \"back.png.xyz\", degree = 2 }\n";
    fs::write(place.path("cloud.toml"), format!("{CAMERA}{prism}{BOARD}")).expect("it is written");
    // Through a link, for a picture's name ends otherwise.
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("front.xyz", place.path("picture.png")).expect("a link");
        let words = place.refused(&["render", "cloud.toml", "--out", "picture.png"]);
        assert!(words.contains("was read in this run"), "{words}");
        assert_eq!(fs::read_to_string(place.path("front.xyz")).expect("it is there"), cloud);
    }
    assert!(place.run(&["render", "cloud.toml", "--out", "other.png"]).status.success());
}

/// Goldens are read and rewritten by right; a case is not.
#[test]
fn goldens_may_be_rewritten() {
    let place = Place::new();
    fs::create_dir(place.path("cases")).expect("a folder");
    fs::rename(place.path("scene.toml"), place.path("cases/small.toml")).expect("moved");
    let update = || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_biprism"));
        command.current_dir(place.folder.path()).args(["golden", "cases"]).env("UPDATE_GOLDEN", "1").env_remove("CI");
        let output = command.output().expect("it starts");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    assert!(update().contains("1 updated"));
    let record = place.path("golden/small.json");
    let changed = fs::read_to_string(&record).expect("it is there").replace("missed", "mixed");
    fs::write(&record, changed).expect("it is written");
    assert!(update().contains("1 updated"));
    assert!(fs::read_to_string(&record).expect("it is there").contains("missed"));
}

/// What spreadsheets and editors of other systems make of a table.
#[test]
fn a_corner_file_may_have_a_byte_order_mark_and_other_line_ends() {
    let place = Place::new();
    assert!(place.run(&["render", "scene.toml", "--out", "a.png"]).status.success());
    for ending in ["csv", "json", "yml"] {
        let name = format!("a.{ending}");
        assert!(place.run(&["corners", "a.png", "--out", &name]).status.success());
        let plain = fs::read_to_string(place.path(&name)).expect("it is there");
        let changed = format!("b.{ending}");
        fs::write(place.path(&changed), format!("\u{feff}{}", plain.replace('\n', "\r\n"))).expect("it is written");
        let [before, after] = [&name, &changed].map(|name| place.run(&["corners", name]));
        assert!(after.status.success(), "{}", String::from_utf8_lossy(&after.stderr));
        assert_eq!(before.stdout, after.stdout, "{ending}");
    }
}

#[test]
fn a_place_in_a_corner_file_is_told_once() {
    let place = Place::new();
    let head = "# pixel centre: (i + 0.5, j + 0.5)\n";
    fs::write(place.path("a.csv"), format!("{head}half,column,row,x_px,y_px\nleft,0.5,0,1,1\n")).expect("written");
    let words = place.refused(&["corners", "a.csv"]);
    assert!(words.contains("--> a.csv:3:6\n"), "{words}");
    fs::write(place.path("a.json"), "{\n\"pixel_centre\": 3}").expect("written");
    let words = place.refused(&["corners", "a.json"]);
    assert!(words.contains("--> a.json:2:") && !words.contains("a.json:2:2:"), "{words}");
}

#[test]
fn a_folder_named_as_a_surface_is_told() {
    let place = Place::new();
    fs::create_dir(place.path("cloud.csv")).expect("a folder");
    let prism = "[prism]\nkind = \"point_cloud\"\nindex = 1.48\nfront = { file = \"cloud.csv\", degree = 2 }\n\
                 back = { file = \"cloud.csv\", degree = 2 }\n";
    fs::write(place.path("cloud.toml"), format!("{CAMERA}{prism}{BOARD}")).expect("it is written");
    let words = place.refused(&["check", "cloud.toml"]);
    assert!(words.contains("is a directory"), "{words}");
}

#[test]
fn computed_numbers_are_rounded_in_messages() {
    let place = Place::new();
    let near = BOARD.replace("1000.0]", "80.3]");
    fs::write(place.path("near.toml"), format!("{CAMERA}{FLAT}position_mm = [0.0, 0.0, 9.1]\n{near}"))
        .expect("written");
    let words = place.refused(&["check", "near.toml"]);
    let digits = words.split(|c: char| !c.is_ascii_digit()).map(str::len).max();
    assert!(words.contains("the glass ends at 87.017") && digits <= Some(9), "{words}");
}

/// A scene from standard input, for every verb that takes one; files that it names are beside the user.
#[test]
fn a_scene_may_come_from_stdin() {
    let place = Place::new();
    let scene = fs::read_to_string(place.path("scene.toml")).expect("it is there");
    let piped = |args: &[&str]| {
        use std::io::Write;
        let mut command = Command::new(env!("CARGO_BIN_EXE_biprism"));
        command.current_dir(place.folder.path()).args(args);
        let mut child =
            command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
        // A refusal may come before all is read.
        let _ = child.stdin.take().expect("a pipe").write_all(scene.as_bytes());
        child.wait_with_output().expect("it ends")
    };
    fs::write(place.path("points.csv"), "20,18\n").expect("it is written");
    assert!(place.run(&["render", "scene.toml", "--out", "a.png"]).status.success());
    for args in [
        &["check", "-"][..],
        &["render", "-", "--out", "new/b.png"],
        &["compare", "-", "--out", "out"],
        &["design", "-", "--out", "out"],
        &["trace", "-", "--points", "points.csv"],
        &["measure", "a.png", "--scene", "-"],
        &["cost", "-", "--quick", "--repetitions", "1"],
    ] {
        let output = piped(args);
        assert_eq!(output.status.code(), Some(0), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    }
    assert!(
        fs::read(place.path("new/b.png")).expect("its folder is made") == fs::read(place.path("a.png")).expect("it is")
    );
    let both = piped(&["trace", "-"]);
    assert!(both.status.code() == Some(2) && String::from_utf8_lossy(&both.stderr).contains("stdin"));
}

/// Where a ray is totally reflected, and on which side.
#[test]
fn a_totally_reflected_ray_is_followed_to_where_it_is() {
    let place = Place::new();
    // In the middle of the picture rays pass.
    let steep = FLAT.replace("thickness_mm = 8.545", "thickness_mm = 80.0\nfacet_angle_deg = -40.0");
    let steep = steep.replace("index = 1.48", "index = 2.4");
    fs::write(place.path("steep.toml"), format!("{CAMERA}{steep}{BOARD}")).expect("it is written");
    fs::write(place.path("points.csv"), "2,18\n62,18\n").expect("it is written");
    let output = place.run(&["trace", "steep.toml", "--points", "points.csv", "--json"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let rays: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    for (k, side) in ["left", "right"].into_iter().enumerate() {
        let ray = &rays[k];
        assert_eq!((&ray["fate"], &ray["side"]), (&"total_reflection".into(), &side.into()), "{ray}");
        assert_eq!(ray["reflected_at"], "back");
        // The base of the prism is the plane z = 158.472.
        assert!((ray["back_mm"][2].as_f64().expect("a place") - 158.472).abs() < 1e-9, "{ray}");
        assert!(ray["exit_direction"].is_null() && ray["inner_direction"].is_array());
    }
}
