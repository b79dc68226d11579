//! Does it measure a photograph, whose board stands where nobody measured it? Pictures rendered here, with what a camera and a
//! JPEG file add, and scenes that are wrong of the pose.

mod causes;
mod poses;

use crate::common::board::Noise;
use biprism::analysis::photograph::{Photograph, photograph};
use biprism::analysis::truth;
use biprism::analysis::view::detect;
use biprism::raster::Raster;
use biprism::raster::transfer::Transfer;
use biprism::render::render;
use biprism::scene::{self, Scene};
use biprism::system::aim::Aimer;
use biprism::system::{self, System};
use glam::DVec2;
use image::codecs::jpeg::JpegEncoder;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// The camera of every scene here.
const CAMERA: &str = "[camera]\nfocal_length_mm = 35.0\nwidth_px = 480\nheight_px = 270\npixel_pitch_um = 22.0\n";
/// What a real lens adds to it.
const LENS: &str = "distortion = [-0.15, 0.1, 0.0005, -0.0004, 0.0]\nprincipal_point_px = [242.5, 133.8]\n";
pub(crate) const FLAT: &str =
    "[prism]\nkind = \"flat\"\nindex = 1.48\nridge_distance_mm = 78.472\nthickness_mm = 8.545\n";
const FREEFORM: &str = "[prism]\nkind = \"freeform\"\nindex = 1.48\nridge_distance_mm = 78.472\nthickness_mm = 8.545\n\
    [prism.design]\nstep_px = 4.0\n";
/// Larger than the picture.
const LARGE: &str = "columns = 21\nrows = 21\nsquare_mm = 20.0\n";
/// Wholly in both halves.
const SMALL: &str = "columns = 6\nrows = 7\nsquare_mm = 20.0\n";
/// Where the board of the pictures is.
pub(crate) const TRUE_POSE: &str = "position_mm = [12.0, -7.0, 1010.0]\ntilt_deg = [4.0, -6.0, 2.0]\n";

pub(crate) fn text(prism: &str, board: &str, pose: &str) -> String {
    format!("name = \"photograph\"\n{CAMERA}{prism}[board]\n{board}{pose}")
}

/// The same through a real lens.
pub(crate) fn through_a_lens(text: &str) -> String {
    text.replace(CAMERA, &format!("{CAMERA}{LENS}"))
}

pub(crate) fn built(text: &str) -> (Scene, System) {
    let scene = scene::parse(text, "test", None).unwrap_or_else(|problem| panic!("{problem}\n{text}"));
    let system = system::build(&scene).unwrap_or_else(|problem| panic!("{problem}"));
    (scene, system)
}

/// A Gaussian blur of `sigma` px, of pixel means; beyond the border the picture goes on as at it.
fn blurred(image: &Raster<f32>, sigma: f64) -> Raster<f32> {
    let reach = (5.0 * sigma).ceil() as i64;
    let weight = |d: i64| libm::exp(-0.5 * (d as f64 / sigma) * (d as f64 / sigma));
    let total: f64 = (-reach..=reach).map(weight).sum();
    let (width, height) = (image.width() as i64, image.height() as i64);
    let along = |from: &Raster<f32>, [x, y]: [i64; 2]| -> Raster<f32> {
        let value =
            |i: i64, j: i64| f64::from(from.get(i.clamp(0, width - 1) as usize, j.clamp(0, height - 1) as usize));
        let mean = |k: i64| {
            let (i, j) = (k % width, k / width);
            ((-reach..=reach).map(|d| weight(d) * value(i + d * x, j + d * y)).sum::<f64>() / total) as f32
        };
        Raster::from_data(from.width(), from.height(), (0..width * height).map(mean).collect())
    };
    along(&along(image, [1, 0]), [0, 1])
}

/// What a camera makes of a picture of linear light: blur of 0.8 px, noise of 1 % of full scale, and a JPEG file of quality 92
/// in sRGB, at `path`.
fn shot(light: &Raster<f32>, path: &Path) {
    let noisy = Noise::new(11).added(&blurred(light, 0.8), 0.01);
    let encode = |v: &f32| {
        let v = f64::from(*v).clamp(0.0, 1.0);
        let encoded = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * libm::pow(v, 1.0 / 2.4) - 0.055 };
        (encoded * 255.0).round() as u8
    };
    let bytes: Vec<u8> = noisy.data().iter().map(encode).collect();
    let mut file = Vec::new();
    JpegEncoder::new_with_quality(&mut file, 92)
        .encode(&bytes, light.width() as u32, light.height() as u32, image::ExtendedColorType::L8)
        .expect("it can be encoded");
    fs::write(path, file).expect("it is written");
}

/// A photograph of the scene `text`, in a file of its own folder.
pub(crate) fn photographed(text: &str) -> (tempfile::TempDir, Raster<f32>) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("photo.jpg");
    shot(&render(&built(text).1, &()).radiance, &path);
    let picture = biprism::io::read(&path, Some(Transfer::Srgb)).expect("it is a JPEG").0;
    (folder, picture)
}

/// A picture as the scene `text` has it measured.
pub(crate) fn measured(picture: &Raster<f32>, text: &str) -> Photograph {
    let (scene, system) = built(text);
    photograph(&scene, &system, &detect(&system, picture, &()), &())
}

/// Measured and true vertical disparity (RMS, px) of the pairs of a photograph of the scene `text`; the truth is the inverse
/// trace's, each corner the true one that it lies nearest to. No pair may be of two corners.
pub(crate) fn disparities(photo: &Photograph, text: &str) -> [f64; 2] {
    let system = built(text).1;
    let aimer = Aimer::new(&system);
    let [left, right] = photo.view.halves.each_ref().map(|half| {
        let truth = truth::corners(&system, &aimer, &half.frame).expect("few enough");
        let nearest = |px: DVec2| {
            let (index, corner) = truth
                .iter()
                .min_by(|a, b| a.1.position_px.distance(px).total_cmp(&b.1.position_px.distance(px)))
                .expect("there are corners");
            assert!(corner.position_px.distance(px) < 1.0, "{px} is no corner");
            (*index, half.rectified(corner.position_px).y)
        };
        half.found
            .iter()
            .map(|f| (f.index, (half.rectified(f.position_px).y, nearest(f.position_px))))
            .collect::<BTreeMap<_, _>>()
    });
    let mut pairs = Vec::new();
    for (index, (y, (own, true_y))) in &left {
        let Some((other_y, (other, true_other_y))) = right.get(index) else { continue };
        assert_eq!(own, other, "corner {index:?} of the lattice");
        pairs.push([y - other_y, true_y - true_other_y]);
    }
    assert!(pairs.len() > 20, "only {} pairs", pairs.len());
    [0, 1].map(|k| (pairs.iter().map(|pair| pair[k] * pair[k]).sum::<f64>() / pairs.len() as f64).sqrt())
}
