//! Does any input, however broken, end in a result or in a sentence?
//!
//! The bodies are those of the fuzz targets in `fuzz/`; here they run on the files of this repository and on mutations of
//! them that are the same on every run. `BIPRISM_HOSTILE_ROUNDS` multiplies the rounds for a long run.

mod bodies;

use crate::common::long_run::number;
use biprism::io::corners;
use biprism::io::corners::{CornerView, ListedCorner, Quality};
use biprism::io::mesh;
use biprism::io::point_cloud::PointFormat;
use biprism::vision::Polarity;
use glam::{DMat2, DVec2};
use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Stdio};

/// xorshift64*: mutations must be the same on every machine.
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }
}

/// Numbers and words on which readers stumble.
const DICTIONARY: [&[u8]; 26] = [
    b"nan",
    b"inf",
    b"-inf",
    b"1e999",
    b"-1e308",
    b"5e-324",
    b"0",
    b"-0.0",
    b"-1",
    b"1e12",
    b"99999999999999999999",
    b"[",
    b"]",
    b"\n",
    b",",
    b"\"",
    b"\xff\xff\xff\xff",
    b"\x00\x00\x00\x00",
    b"\x7f\xff\xff\xff",
    b"\x80",
    b"\xef\xbb\xbf",
    b"=",
    b"1e-300",
    b" ",
    b"1e80",
    "é".as_bytes(),
];

/// A text's number replaced, bytes flipped, dropped, doubled or put in, or the end cut off.
fn mutated(seed: &[u8], dice: &mut Dice) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..1 + dice.below(4) {
        let at = dice.below(bytes.len());
        let length = 1 + dice.below(16);
        let end = (at + length).min(bytes.len());
        match dice.below(8) {
            0 if !bytes.is_empty() => bytes[at] ^= 1 << dice.below(8),
            1 if !bytes.is_empty() => bytes[at] = dice.below(256) as u8,
            2 => drop(bytes.drain(at..end)),
            3 => {
                let piece = bytes[at..end].to_vec();
                bytes.splice(at..at, piece);
            }
            4 => bytes.truncate(at),
            5 | 6 => {
                // The number at or after the place, if there is one nearby.
                let digit = |b: &u8| b.is_ascii_digit() || b"+-.e".contains(b);
                let start = at + bytes[at..].iter().position(digit).unwrap_or(0);
                let end = start + bytes[start..].iter().position(|b| !digit(b)).unwrap_or(0);
                bytes.splice(start..end, DICTIONARY[dice.below(DICTIONARY.len())].iter().copied());
            }
            _ => drop(bytes.splice(at..at, DICTIONARY[dice.below(DICTIONARY.len())].iter().copied())),
        }
    }
    bytes
}

fn rounds(standard: usize) -> usize {
    standard * number("BIPRISM_HOSTILE_ROUNDS", 1)
}

fn attack(seeds: &[Vec<u8>], standard: usize, body: impl Fn(&[u8])) {
    let mut dice = Dice(0x9e37_79b9_7f4a_7c15);
    seeds.iter().for_each(|seed| body(seed));
    for _ in 0..rounds(standard) {
        let seed = &seeds[dice.below(seeds.len())];
        body(&mutated(seed, &mut dice));
    }
}

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn files(folder: &str, ending: &str) -> Vec<Vec<u8>> {
    let mut paths: Vec<PathBuf> =
        fs::read_dir(root().join(folder)).expect("it is committed").flatten().map(|e| e.path()).collect();
    paths.retain(|p| p.extension().is_some_and(|e| e == ending));
    paths.sort();
    assert!(!paths.is_empty(), "{folder} has no .{ending}");
    paths.iter().map(|p| fs::read(p).expect("it can be read")).collect()
}

fn polynomial_scene() -> Vec<u8> {
    let prism = fs::read_to_string(root().join("tests/oracle/prism.toml")).expect("it is committed");
    format!(
        "name = \"p\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = 48\nheight_px = 27\npixel_pitch_um = 220.0\n{prism}\n\
         [board]\ncolumns = 41\nrows = 41\nsquare_mm = 10.0\nposition_mm = [0.0, 0.0, 1000.0]\n"
    )
    .into_bytes()
}

#[test]
fn scene_texts() {
    let mut seeds = files("tests/bad_scenes", "toml");
    seeds.push(fs::read(root().join("scenes/paper.toml")).expect("it is committed"));
    let paper = String::from_utf8(seeds.last().expect("just pushed").clone()).expect("it is text");
    // Flat, so that a round is not a design.
    seeds.push(
        paper
            .replace("kind = \"freeform\"", "kind = \"flat\"")
            .replace("[prism.design]\norder = \"x-then-y\"\ndegree = 5\n", "")
            .into_bytes(),
    );
    attack(&seeds, 3000, bodies::scene_text);
}

#[test]
fn polynomial_scenes() {
    attack(&[polynomial_scene()], 3000, bodies::scene_text);
}

#[test]
fn png_pictures() {
    attack(&files("tests/fixtures/pictures", "png"), 1500, |bytes| bodies::picture(bytes, ".png"));
}

#[test]
fn exr_pictures() {
    attack(&files("tests/fixtures/pictures", "exr"), 1500, |bytes| bodies::picture(bytes, ".exr"));
}

#[test]
fn point_clouds() {
    let xyz: String = (0..60).map(|k| format!("{} {} {:e}\n", k % 9, k / 9, 80.0 + 0.01 * f64::from(k * k))).collect();
    let csv = format!("x_mm,y_mm,z_mm\n{}", xyz.replace(' ', ","));
    let both = "u_px,v_px,front_x_mm,front_y_mm,front_z_mm,back_x_mm,back_y_mm,back_z_mm\n0,0,1,2,80,1,2,87\n";
    let head = |format: &str| {
        format!(
            "ply\nformat {format} 1.0\nelement vertex 60\nproperty double x\nproperty float y\nproperty double z\nend_header\n"
        )
    };
    let ascii = head("ascii") + &xyz;
    let mut binary = head("binary_little_endian").into_bytes();
    for k in 0..60 {
        binary.extend(f64::from(k % 9).to_le_bytes());
        binary.extend(((k / 9) as f32).to_le_bytes());
        binary.extend((80.0 + f64::from(k)).to_le_bytes());
    }
    let rows: String = (0..42).map(|k| format!("{:e} 0.1 -0.2 0 {}\n", 0.01 * f64::from(k * k), k / 41)).collect();
    let sag = format!("! by hand\n6 7 0.5 0.25 0 1.5 -2\n{rows}");
    attack(&[sag.into_bytes()], 3000, |bytes| bodies::cloud(bytes, PointFormat::GridSag));
    attack(&[xyz.into_bytes()], 3000, |bytes| bodies::cloud(bytes, PointFormat::Xyz));
    attack(&[csv.into_bytes(), both.into()], 3000, |bytes| bodies::cloud(bytes, PointFormat::Csv));
    attack(&[ascii.into_bytes(), binary], 6000, |bytes| bodies::cloud(bytes, PointFormat::Ply));
}

#[test]
fn meshes() {
    let obj = "# q\nv 0 0 80\nv 1 0 80.1\nv 1 1 80\nv 0 1 80\nv 2 0 80\nf 1//1 2//1 3//1 4//1\nf -1 -4 -3\n";
    let ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty float y\nproperty double z\nproperty \
               float nx\nproperty float ny\nproperty float nz\nelement face 2\nproperty list uchar int vertex_indices\n\
               end_header\n0 0 80 0 0 1\n1 0 80 0 0.1 1\n1 1 80 0 0 -1\n0 1 80 0 0 1\n3 0 1 2\n4 0 1 2 3\n";
    attack(&[obj.into()], 6000, |bytes| bodies::mesh(bytes, mesh::MeshFormat::Obj));
    attack(&[ply.into()], 6000, |bytes| bodies::mesh(bytes, mesh::MeshFormat::Ply));
    let corners = [[0.0f32, 0.0, 80.0], [1.0, 0.0, 80.1], [1.0, 1.0, 80.0], [0.0, 1.0, 80.2]];
    let facets = [[0, 1, 2], [0, 2, 3]].map(|facet| facet.map(|k: usize| corners[k]));
    let words = facets.map(|facet| {
        let vertices = facet.map(|[x, y, z]| format!("vertex {x} {y} {z}\n")).concat();
        format!("facet normal 0 0 1\nouter loop\n{vertices}endloop\nendfacet\n")
    });
    let ascii = format!("solid s\n{}endsolid s\n", words.concat());
    let mut binary = vec![0; 80];
    binary.extend(2u32.to_le_bytes());
    for facet in facets {
        binary.extend([0; 12]);
        binary.extend(facet.as_flattened().iter().flat_map(|v| v.to_le_bytes()));
        binary.extend([0; 2]);
    }
    attack(&[ascii.into_bytes(), binary], 6000, |bytes| bodies::mesh(bytes, mesh::MeshFormat::Stl));
}

#[test]
fn corner_files() {
    let corner = |x: f64, y: f64, column: i32| ListedCorner {
        index: [column, 3],
        position_px: DVec2::new(x, y),
        quality: Some(Quality {
            covariance_px2: DMat2::from_cols(DVec2::new(1e-6, 1e-7), DVec2::new(1e-7, 2e-6)),
            contrast: 0.8,
            residual: 1e-4,
            polarity: Polarity::Main,
        }),
    };
    let corners: Vec<ListedCorner> = (0..12).map(|k| corner(10.25 * f64::from(k), 7.125 + f64::from(k), k)).collect();
    let bare: Vec<ListedCorner> = corners.iter().map(|c| ListedCorner { quality: None, ..*c }).collect();
    let view = |name: &str, corners: &[ListedCorner]| CornerView {
        name: name.to_owned(),
        index_origin: Some(corners::IndexOrigin::Board),
        corners: corners.to_vec(),
        rejected: vec![("flat".to_owned(), 3)],
        blur_px: Some([0.7, 0.8]),
        elongated_blur: Some(corners::BlurEllipse { along_px: 3.0, across_px: 0.7, direction_deg: 30.0 }),
        lean_px: None,
        marked_squares: true,
        transfer: None,
    };
    for format in [corners::CornerFormat::Csv, corners::CornerFormat::Json, corners::CornerFormat::OpenCv] {
        let seeds = [vec![view("left", &corners), view("right", &corners)], vec![view("whole", &bare)], Vec::new()];
        let seeds: Vec<Vec<u8>> = seeds.iter().map(|views| corners::to_text(views, format).into_bytes()).collect();
        attack(&seeds, 4000, |bytes| bodies::corners(bytes, format));
    }
}

/// The tables that `trace` reads, forth and back: exit 0 or 2, no panic, and no number that is none.
#[test]
fn trace_tables() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene = folder.path().join("scene.toml");
    fs::write(&scene, polynomial_scene()).expect("it is written");
    let trace = |bytes: &[u8], back: bool| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_biprism"));
        command.arg("trace").arg(&scene).args(back.then_some("--back"));
        let mut child =
            command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
        // It may end before it has read all.
        let _ = child.stdin.take().expect("it is piped").write_all(bytes);
        let output = child.wait_with_output().expect("it ends");
        let (out, words) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        assert!(matches!(output.status.code(), Some(0 | 2)), "{:?}: {words}", output.status);
        assert!(!words.contains("panicked"), "{words}");
        assert!(!out.contains("NaN") && !out.contains("inf"), "{out}");
    };
    let forth =
        b"x_px,y_px\n24,13.5\n0,0\n48,27\n-1e9,1e300\n1e308,-1e308\n5e-324,0\n24.000000000001,-1e150\n".to_vec();
    let back =
        b"side,u_mm,v_mm\nleft,0,0\nright,12.5,-3\nleft,1e300,1e300\nright,-1e160,0\nleft,1e12,5e-324\n".to_vec();
    attack(&[forth], 60, |bytes| trace(bytes, false));
    attack(&[back], 60, |bytes| trace(bytes, true));
}

/// Photographs and Netpbm's pictures, whole and mutated.
#[test]
fn photographs() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let grey = image::GrayImage::from_fn(24, 16, |x, y| image::Luma([(x * 9 + y * 3) as u8]));
    let colour = image::RgbImage::from_fn(24, 16, |x, y| image::Rgb([(x * 9) as u8, (y * 9) as u8, 7]));
    for ending in ["jpg", "bmp", "pnm"] {
        let [a, b] = ["a", "b"].map(|name| folder.path().join(format!("{name}.{ending}")));
        grey.save(&a).expect("it is written");
        colour.save(&b).expect("it is written");
        let mut seeds = vec![fs::read(&a).expect("it is there"), fs::read(&b).expect("it is there")];
        if ending == "pnm" {
            seeds.push(b"P2 3 2 9\n0 1 2 3 4 9\n".to_vec());
            seeds.push(b"P7\nWIDTH 3\nHEIGHT 1\nDEPTH 1\nMAXVAL 9\nENDHDR\n\x00\x01\x09".to_vec());
        }
        attack(&seeds, 1500, bodies::photograph);
    }
}

#[test]
fn tiff_pictures() {
    attack(&files("tests/fixtures/pictures/tiff", "tif"), 4000, bodies::photograph);
}

/// A header that promises more than there is costs no memory and no time.
#[test]
fn promises_are_not_believed() {
    let started = std::time::Instant::now();
    let ply = "ply\nformat binary_little_endian 1.0\nelement vertex 9999999\nproperty double x\nproperty double y\nproperty double z\nend_header\n";
    bodies::cloud(ply.as_bytes(), PointFormat::Ply);
    for png in files("tests/fixtures/pictures", "png").iter_mut() {
        // Width and height of the header, which then has a wrong checksum or too little behind it.
        png[16..24].copy_from_slice(&[0, 0, 0x40, 0, 0, 0, 0x40, 0]);
        bodies::picture(png, ".png");
    }
    assert!(started.elapsed().as_secs() < 20, "{:?}", started.elapsed());
}

/// The decoder's own reading of a palette would panic.
#[test]
fn a_palette_that_ends_within_a_colour_is_refused() {
    for bytes in [0, 1, 13, 769, 1000] {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, 7, 5);
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_palette(vec![200; bytes]);
        let mut writer = encoder.write_header().expect("it is memory");
        writer.write_image_data(&[0; 35]).expect("it is memory");
        writer.finish().expect("it is memory");
        bodies::picture(&file, ".png");
    }
}

#[test]
fn calibrations() {
    let yaml = fs::read(root().join("tests/oracle/camera.yml")).expect("it is committed");
    let json = "{\"K\": {\"data\": [600, 0, 320, 0, 601, 240, 0, 0, 1]}, \"D\": {\"data\": [-0.3, 0.1, 0, 0]}}";
    attack(&[yaml, json.into()], 6000, bodies::calibration);
}

/// Cameras of their own, whose lens may fold the picture.
#[test]
fn scenes_with_calibrated_cameras() {
    let scene = String::from_utf8(polynomial_scene()).expect("it is text");
    let own = "pixel_pitch_um = 220.0\nprincipal_point_px = [24.5, 13.0]\nrotation_deg = [1.0, -2.0, 3.0]\n\
               distortion = [-0.3, 0.1, 0.001, -0.002, 0.01]";
    attack(&[scene.replace("pixel_pitch_um = 220.0", own).into_bytes()], 3000, bodies::scene_text);
}
