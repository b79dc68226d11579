//! Is the truth of a picture as NPY what `trace` says of every pixel's centre, to the last bit, and does NumPy read it?

use crate::command::{biprism, json, text, with_input};
use biprism::io::exr::{ChannelSamples, read_channels};
use std::fs;
use std::path::Path;
use std::process::Command;

const SIZE: [usize; 2] = [36, 22];

/// A scene whose picture has every class that a prism of two polynomials, a rim and a short board give.
fn scene(prism: &str, effects: &str) -> String {
    let [width, height] = SIZE;
    format!(
        "name = \"small\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = {width}\nheight_px = {height}\n\
         pixel_pitch_um = 290.0\n[prism]\n{prism}\n[board]\ncolumns = 7\nrows = 7\nsquare_mm = 30.0\n\
         tilt_deg = [87.0, 2.0, 3.0]\nposition_mm = [7.0, 0.0, 700.0]\n{effects}\n"
    )
}

const FLAT: &str = "kind = \"flat\"\nridge_distance_mm = 78.472\nthickness_mm = 8.545\nindex = 1.5168\nglass = \"N-BK7\"\n\
                    wavelength_nm = 587.5618";

/// The records of a table, and its header without the blanks.
fn records(path: &Path) -> (String, Vec<([f64; 2], u32)>) {
    let bytes = fs::read(path).expect("it was written");
    assert_eq!(bytes[..8], *b"\x93NUMPY\x01\x00");
    let length = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let header = str::from_utf8(&bytes[10..length]).expect("text").trim_end().to_owned();
    let record = |bytes: &[u8]| {
        let number = |k: usize| f64::from_le_bytes(*bytes[8 * k..].first_chunk().expect("8 bytes"));
        ([number(0), number(1)], u32::from_le_bytes(*bytes[16..].first_chunk().expect("4 bytes")))
    };
    assert_eq!((bytes.len() - length) % 20, 0);
    (header, bytes[length..].chunks_exact(20).map(record).collect())
}

#[test]
fn the_table_has_what_trace_says_of_pixel_centres() {
    let [width, height] = SIZE;
    let folder = tempfile::tempdir().expect("a folder");
    let line = "[effect.clipping]\nchamfer_mm = 0.3\n[effect.clipping.rim]\nsides_mm = [30.0, 12.0]\n";
    let band = "[effect.dispersion]\nlines_nm = [486.1327, 587.5618]\npowers = [1.0, 2.0]\n";
    let names = ["left", "right", "missed", "total_reflection", "not_converged", "past_board", "clipped"];
    let mut classes = [0; 7];
    for (prism, effects) in [(FLAT, ""), (FLAT, line), (FLAT, band), ("kind = \"none\"", "")] {
        fs::write(folder.path().join("scene.toml"), scene(prism, effects)).expect("written");
        let outs = ["render", "scene.toml", "--out", "a.npy", "--out", "a.exr", "--out", "a.png", "--out", "b.NPY"];
        let done = biprism(folder.path(), &outs);
        assert!(done.status.success(), "{}", text(&done.stderr));
        let (header, found) = records(&folder.path().join("a.npy"));
        let shape = format!("'shape': ({height}, {width}), }}");
        assert_eq!(
            header,
            format!("{{'descr': [('board_mm', '<f8', (2,)), ('class', '<u4')], 'fortran_order': False, {shape}")
        );
        assert_eq!(fs::read(folder.path().join("a.npy")).ok(), fs::read(folder.path().join("b.NPY")).ok());

        // Every centre by the other command.
        let centre = |k: usize| format!("{},{}\n", (k % width) as f64 + 0.5, (k / width) as f64 + 0.5);
        let asked: String = (0..width * height).map(centre).collect();
        let traced = json(&with_input(folder.path(), &["trace", "scene.toml", "--json"], &asked));
        let traced = traced.as_array().expect("a list");
        assert_eq!((found.len(), traced.len()), (width * height, width * height));
        let exr = read_channels(&folder.path().join("a.exr"), &["class", "board.U"]).expect("its channels");
        let [ChannelSamples::U32(exr_class), ChannelSamples::F32(exr_u)] = [&exr[0].samples, &exr[1].samples] else {
            panic!("u32 and f32")
        };
        for (k, ((mm, class), traced)) in found.iter().zip(traced).enumerate() {
            let name = names[*class as usize];
            let told = if traced["fate"] == "board" { &traced["side"] } else { &traced["fate"] };
            assert_eq!(told, name, "pixel {k}: {traced}");
            for (axis, mm) in mm.iter().enumerate() {
                match traced["board_mm"][axis].as_f64() {
                    Some(told) => assert_eq!(told.to_bits(), mm.to_bits(), "pixel {k}: {traced}"),
                    None => assert!(mm.is_nan(), "pixel {k}: {traced}"),
                }
            }
            // The picture's own truth, of one render, is the same class, and to an f32 the same place.
            assert_eq!(exr_class.data()[k], *class, "pixel {k}");
            let u = f64::from(exr_u.data()[k]);
            assert!(u.is_nan() && mm[0].is_nan() || (u - mm[0]).abs() <= 1e-6 * mm[0].abs().max(100.0), "{u} {mm:?}");
            classes[*class as usize] += 1;
        }
        // Not all of them are f32: the numbers did not go through one.
        let kept = |mm: f64| mm.is_nan() || f64::from(mm as f32).to_bits() == mm.to_bits();
        assert!(found.iter().filter(|(mm, _)| !kept(mm[0])).count() > width * height / 4);
        numpy(&folder.path().join("a.npy"), &found);
    }
    assert!([0, 1, 5, 6].iter().all(|class| classes[*class] > 20), "{classes:?}");
}

/// What NumPy reads, where Python has it: the sums of what is seen, bit for bit, and the counts of classes.
fn numpy(path: &Path, found: &[([f64; 2], u32)]) {
    let script = "import sys, numpy as np\nt = np.load(sys.argv[1])\nassert t.shape == (22, 36) and t.dtype.itemsize == 20\n\
                  for mm, c in zip(t['board_mm'].reshape(-1, 2), t['class'].ravel()):\n    print(mm[0].hex(), mm[1].hex(), c)";
    let has = Command::new("python3").args(["-c", "import numpy"]).output().is_ok_and(|done| done.status.success());
    if !has {
        return;
    }
    let done = Command::new("python3").args(["-c", script]).arg(path).output().expect("it runs");
    assert!(done.status.success(), "{}", text(&done.stderr));
    let read = text(&done.stdout);
    let lines: Vec<&str> = read.lines().collect();
    assert_eq!(lines.len(), found.len());
    for (line, (mm, class)) in lines.iter().zip(found) {
        let words: Vec<&str> = line.split(' ').collect();
        assert_eq!(words[2], class.to_string());
        assert!(mm.iter().zip(&words).all(|(mm, hex)| mm.is_nan() == (*hex == "nan")), "{line} {mm:?}");
        for (mm, hex) in mm.iter().zip(&words).filter(|(mm, _)| !mm.is_nan()) {
            assert_eq!(from_hex(hex).to_bits(), mm.to_bits(), "{line}");
        }
    }
}

/// A number as Python's `float.hex` writes it: `-0x1.8p+3`.
fn from_hex(text: &str) -> f64 {
    let (sign, rest) = text.strip_prefix('-').map_or((1.0, text), |rest| (-1.0, rest));
    let (digits, exponent) = rest.strip_prefix("0x").and_then(|rest| rest.split_once('p')).expect("hexadecimal");
    let (whole, fraction) = digits.split_once('.').expect("a point");
    let bits = u64::from_str_radix(&format!("{whole}{fraction}"), 16).expect("digits");
    let exponent: i32 = exponent.parse().expect("a number");
    sign * libm::ldexp(bits as f64, exponent - 4 * fraction.len() as i32)
}

/// Whole or not at all, and never without a folder to write to.
#[test]
fn a_table_that_cannot_be_written_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("scene.toml"), scene(FLAT, "")).expect("written");
    let done = biprism(folder.path(), &["render", "scene.toml", "--out", "new/a.npy"]);
    assert!(done.status.success() && folder.path().join("new/a.npy").is_file(), "{}", text(&done.stderr));
    fs::create_dir(folder.path().join("b.npy")).expect("a folder");
    let done = biprism(folder.path(), &["render", "scene.toml", "--out", "b.npy"]);
    assert!(done.status.code() == Some(2) && text(&done.stderr).contains("a directory"), "{}", text(&done.stderr));
    let done = biprism(folder.path(), &["render", "scene.toml", "--out", "a.npz"]);
    assert!(done.status.code() == Some(2) && text(&done.stderr).contains(".npy"), "{}", text(&done.stderr));
}
