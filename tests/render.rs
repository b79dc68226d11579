//! Is a rendered pixel the mean of what it sees? Judged by brute force, f64, jittered samples.

use crate::instruments::{BOARD, FLAT, FREEFORM, built, scene};
use biprism::accuracy::Accuracy;
use biprism::render::checkerboard::Checkerboard;
use biprism::render::{Film, render};
use biprism::system::System;
use glam::DVec2;

/// A fixed sequence of numbers in 0..1 (splitmix64), so that the samples are the same on every run.
struct Jitter(u64);

impl Jitter {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// The mean over pixel (i, j) of n x n jittered samples.
fn brute(system: &System, pattern: &Checkerboard, i: usize, j: usize, n: usize) -> f64 {
    let mut jitter = Jitter((i * 1_000_003 + j) as u64);
    let mut sum = 0.0;
    for k in 0..n * n {
        let cell = DVec2::new((k % n) as f64 + jitter.next(), (k / n) as f64 + jitter.next()) / n as f64;
        let px = DVec2::new(i as f64, j as f64) + cell;
        sum += system.trace(px).map_or(0.0, |sight| pattern.at(sight.board_mm));
    }
    sum / (n * n) as f64
}

/// RMS difference over the crop, over all its pixels, with 128 x 128 samples in each pixel that is not constant.
fn rmse(system: &System, film: &Film, x: std::ops::Range<usize>, y: std::ops::Range<usize>) -> (f64, f64) {
    let pattern = Checkerboard::new(&system.board().pattern);
    let board = system.board().pattern;
    let (mut sum, mut worst, n) = (0.0, 0.0f64, (x.len() * y.len()) as f64);
    for (i, j) in y.flat_map(|j| x.clone().map(move |i| (i, j))) {
        let value = film.radiance.get(i, j);
        // A constant pixel needs few samples to show that it is one.
        let constant = value == board.black as f32 || value == board.white as f32;
        let difference = brute(system, &pattern, i, j, if constant { 8 } else { 128 }) - f64::from(value);
        sum += difference * difference;
        worst = worst.max(difference.abs());
    }
    ((sum / n).sqrt(), worst)
}

/// An edge through a pixel crosses about 128 to 180 of its 128^2 cells; a cell cut at random has a variance of at most
/// 1/6 of the contrast squared on average, so a pixel errs by 0.8 sqrt(180/6)/128^2 = 2.7e-4, and the crop, of which
/// less than a third of the pixels hold an edge, by less than 1.6e-4.
const NOISE_FLOOR: f64 = 1.6e-4;

#[test]
fn pixels_are_the_mean_of_what_they_see() {
    for prism in [FLAT, FREEFORM] {
        let system = built(&scene(1920, 1080, prism, BOARD));
        let film = render(&system, &());
        for (x, y) in [(30, 20), (1500, 700), (1880, 1030)] {
            let (rmse, worst) = rmse(&system, &film, x..x + 40, y..y + 40);
            assert!(rmse < NOISE_FLOOR && worst < 2e-3, "{prism} at ({x}, {y}): RMSE {rmse:e}, worst {worst:e}");
        }
    }
}

/// At the seam, between the pixels of an even width and inside those of an odd one, nothing is different.
#[test]
fn the_seam_has_no_step() {
    for (width, height) in [(1920, 1080), (1921, 1081)] {
        for prism in [FLAT, FREEFORM] {
            let system = built(&scene(width, height, prism, BOARD));
            let film = render(&system, &());
            let (rmse, worst) = rmse(&system, &film, 955..966, 300..380);
            assert!(rmse < NOISE_FLOOR && worst < 2e-3, "{width}, {prism}: RMSE {rmse:e}, worst {worst:e}");
        }
    }
}

/// A slanted seam, off centre, cuts pixels anywhere; with squares of a few pixels every cut pixel may hold an edge.
#[test]
fn a_slanted_seam_is_cut_exactly() {
    let tilted = FLAT.to_owned() + "\nposition_mm = [0.8, 0.3, 0.0]\ntilt_deg = [0.5, -0.8, 1.5]";
    let system = built(&scene(480, 270, &tilted, BOARD));
    let film = render(&system, &());
    assert!(film.counts.cut_pixels >= 270, "the seam crosses every row");
    let (rmse, worst) = rmse(&system, &film, 220..260, 100..140);
    // Where the ridge, an edge of the board and a bend meet in a pixel of 22 um, the piece's tangent errs too.
    assert!(rmse < 2.0 * NOISE_FLOOR && worst < 4e-3, "RMSE {rmse:e}, worst {worst:e}");
}

/// The levels keep their promise to each other.
#[test]
fn standard_agrees_with_reference() {
    let mut scene = scene(480, 270, FREEFORM, BOARD);
    let standard = render(&built(&scene), &());
    scene.accuracy = Accuracy::reference();
    let reference = render(&built(&scene), &());
    let pairs = standard.radiance.data().iter().zip(reference.radiance.data());
    let square: f64 = pairs.map(|(a, b)| f64::from(a - b) * f64::from(a - b)).sum();
    let rmse = (square / standard.radiance.data().len() as f64).sqrt();
    // An edge pixel's value changes by the contrast, 0.8, for a shift of 1 px; shifts keep below 2e-5 px.
    assert!(rmse < 0.8 * 2e-5, "{rmse:e}");
}
