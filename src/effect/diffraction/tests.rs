//! The pattern, its transfer function and the spread of light against closed forms of diffraction theory.
//! `tests/film.rs` holds rendered pictures against the Fourier series of a board.

use super::*;
use crate::raster::Raster;
use std::f64::consts::PI;

/// Light falls off to nothing at 1.22 wavelengths times f-number: 3.8317059702 / pi (Abramowitz and Stegun, table 9.5).
#[test]
fn the_first_dark_ring_holds_83_8_percent_of_the_light() {
    assert!((FIRST_ZERO - 3.831_705_970_207_512 / PI).abs() < 1e-15);
    assert!(airy(FIRST_ZERO) < 1e-30 && airy(FIRST_ZERO - 0.01) > 1e-6 && airy(FIRST_ZERO + 0.01) > 1e-6);
    assert!((encircled_energy(FIRST_ZERO) - 0.838).abs() < 5e-4);
    // The later rings of Born and Wolf, 8.5.2: 91.0 % and 93.8 % (zeros at 2.233 and 3.238).
    assert!((encircled_energy(2.233) - 0.910).abs() < 5e-4 && (encircled_energy(3.238) - 0.938).abs() < 5e-4);
    assert_eq!((airy(0.0), encircled_energy(0.0)), (1.0, 0.0));
}

/// The encircled energy is the integral of the pattern, whose whole is 4 / pi of its peak times (wavelength x f-number)^2.
#[test]
fn encircled_energy_is_the_integral_of_the_pattern() {
    for r in [0.3, FIRST_ZERO, 2.7] {
        let rule = crate::num::quadrature::gauss_legendre(60);
        let integral: f64 = rule.iter().map(|[x, w]| w * r * 2.0 * PI * (r * x) * airy(r * x)).sum();
        // J1 of libm is good to a few units in the last place of 1.
        assert!((integral * PI / 4.0 - encircled_energy(r)).abs() < 1e-13, "{r}");
    }
}

/// The transfer function is the transform of the pattern: of the zero order Hankel kind, here by its inverse.
#[test]
fn transfer_function_and_pattern_are_a_pair() {
    for r in [0.0, 0.4, 1.0, FIRST_ZERO, 3.1] {
        let rule = crate::num::quadrature::gauss_legendre(200);
        let back: f64 = rule.iter().map(|[nu, w]| w * 2.0 * PI * nu * mtf(*nu) * libm::j0(2.0 * PI * r * nu)).sum();
        // (1 - nu)^(3/2) at the end limits a Gauss rule of n nodes to n^-5.
        assert!((back * 4.0 / PI - airy(r)).abs() < 1e-9, "{r}: {back}");
    }
    assert_eq!((mtf(0.0), mtf(1.0), mtf(1.7)), (1.0, 0.0, 0.0));
}

/// The mean of the pattern over its rings falls as the cube of the distance: of J1^2 it is 1 / (pi v).
#[test]
fn the_far_pattern_falls_as_the_cube_of_the_distance() {
    for r in [6.0, 20.0, 40.0] {
        // Over one ring, the circumference times the mean height is what the encircled energy gains.
        let gained = encircled_energy(r + 0.5) - encircled_energy(r - 0.5);
        let mean = 1.0 / (PI * PI * PI * r * r * r);
        // The next order of J0^2 + J1^2 is a wave of 1 / (2 v) of it.
        assert!((gained / (2.0 * PI * r * mean) - 1.0).abs() < 0.4 / r, "{r}");
    }
}

/// Wavelengths times f-number and active sides, both in px.
const LENSES: [[f64; 2]; 8] =
    [[0.02, 1.0], [0.1, 0.3], [0.3, 1.0], [0.8, 0.5], [1.6, 1.0], [3.0, 0.25], [8.0, 1.0], [20.0, 0.7]];

fn cells(scale: f64, active: f64) -> usize {
    Diffraction { wavelength_nm: 500.0, f_number: scale / 500e-6, pitch_mm: 1.0 }.cells(active, f64::INFINITY)
}

fn noise(width: usize, height: usize, seed: u64) -> Raster<f32> {
    let value = |k: usize| crate::num::deviates::Stream::new(seed, 0, 0, k as u32).uniform() as f32;
    Raster::from_data(width, height, (0..width * height).map(value).collect())
}

/// Of a wave so long that pixels and cells do not see its bend, the transfer function's share is left.
#[test]
fn long_waves_lose_the_modulation_that_theory_says() {
    for [scale, active] in LENSES {
        let spread = PixelSpread::new(scale, active, cells(scale, active).max(2));
        for waves in [1, 2, 3] {
            let width = 512;
            let nu = f64::from(waves) / 256.0;
            let wave = |i: usize| 0.5 + 0.5 * libm::cos(2.0 * PI * nu * (i as f64 + 0.5));
            let row: Vec<f32> = (0..width).map(|i| wave(i) as f32).collect();
            let out = spread.spread(&Raster::from_data(width, 3, row.repeat(3)));
            for (i, found) in out.row(1).iter().enumerate() {
                let expected = 0.5 + (wave(i) - 0.5) * mtf(nu * scale);
                // The pixel, its active square and two cells of at most half a pixel bend it by (pi nu)^2 / 6 each at most.
                let bound = 0.5 * 2.0 * (PI * nu) * (PI * nu) / 6.0 + 1e-7;
                assert!((found - expected).abs() < bound, "{scale} {active} {waves} {i}: {found} {expected}");
            }
        }
    }
}

#[test]
fn light_is_neither_made_nor_lost_and_uniform_stays_uniform() {
    for [scale, active] in LENSES {
        let spread = PixelSpread::new(scale, active, cells(scale, active));
        let picture = noise(23, 9, 5);
        let before: f64 = picture.data().iter().map(|v| f64::from(*v)).sum();
        let after: f64 = spread.spread(&picture).data().iter().sum();
        // The table of aliases holds 0 for light that is even, to rounding.
        assert!((after / before - 1.0).abs() < 1e-12, "{scale} {active}: {after} {before}");
        let even = spread.spread(&Raster::filled(23, 9, 0.37f32));
        assert!(even.data().iter().all(|v| (v - f64::from(0.37f32)).abs() < 1e-14), "{scale} {active}");
    }
}

/// The pattern's height at a pixel, of the light of one pixel: pi / 4 of (scale)^-2 times [`airy`].
#[test]
fn one_bright_pixel_makes_the_pattern() {
    let scale = 9.0;
    let spread = PixelSpread::new(scale, 0.05, 100);
    let mut picture = Raster::filled(401, 401, 0.0f32);
    *picture.row_mut(200).get_mut(200).unwrap() = 1.0;
    let out = spread.spread(&picture);
    let peak = PI / 4.0 / (scale * scale);
    for (i, j) in [(0, 0), (3, 0), (7, 5), (0, 11), (20, 15), (40, 1)] {
        let r = f64::from(i * i + j * j).sqrt() / scale;
        let found = out.get(200 + i as usize, 200 + j as usize);
        // The pattern bends by (pi / 9)^2 / 2 px^-2 in its middle, and the mean of x^2 over a pixel is 1/12: 5.1e-3.
        assert!((found - peak * airy(r)).abs() < 5.5e-3 * peak, "({i}, {j}): {found} {}", peak * airy(r));
    }
}

/// What a bright pixel keeps tells what leaves it: most of the bound, which counts what crosses a corner twice and
/// what leaves over one pair of sides once.
#[test]
fn what_leaves_a_square_is_bounded() {
    for scale in [0.02, 0.1, 0.4, 1.0, 2.5] {
        let mut picture = Raster::filled(301, 301, 0.0f32);
        picture.row_mut(150)[150] = 1.0;
        let leaves = 1.0 - PixelSpread::new(scale, 1.0, 1000).spread(&picture).get(150, 150);
        let bound = leaving_square(scale);
        println!("{scale}: {leaves:.3e} of at most {bound:.3e}");
        assert!(leaves <= bound && bound <= 1.6 * leaves, "{scale}: {leaves} {bound}");
    }
}

/// One bright cell makes the pattern about itself, not about its pixel's middle.
#[test]
fn one_bright_cell_makes_the_pattern() {
    let (scale, count) = (3.0, 10);
    let (spread, cells) = (PixelSpread::new(scale, 0.05, count), CellSpread::new(scale, 0.05, count));
    let mut picture = Raster::filled(201, 201, 0.0f32);
    picture.row_mut(100)[100] = 0.01;
    let out = spread.spread(&picture);
    let mut around = Vec::new();
    cells.add(|i, j| if (i, j) == (8, 1) { 1.0 } else { 0.0 }, &mut around);
    let side = 2 * cells.reach() + 1;
    let peak = 0.01 * PI / 4.0 / (scale * scale);
    for (i, j) in [(0, 0), (1, -1), (3, 0), (-2, 1), (-5, -6), (9, 2)] {
        let near = |k: i32| (cells.reach() as i32 + k) as usize;
        let found = out.get((100 + i) as usize, (100 + j) as usize) + f64::from(around[near(j) * side + near(i)]);
        let [x, y] = [f64::from(i) - 0.35, f64::from(j) + 0.35];
        let expected = peak * airy((x * x + y * y).sqrt() / scale);
        // The cell bends the pattern by (pi / 3)^2 / 2 * 0.01 / 12 of its middle, and takes that off again.
        assert!((found - expected).abs() < 5e-4 * peak, "({i}, {j}): {found} {expected}");
    }
}

#[test]
fn a_mirrored_picture_is_spread_as_its_mirror_image() {
    let turned = |p: &Raster<f64>| {
        let w = p.width();
        Raster::from_data(w, p.height(), (0..p.data().len()).map(|k| p.get(w - 1 - k % w, k / w)).collect())
    };
    let picture = noise(37, 5, 6);
    let mirrored = turned(&picture.map(f64::from)).map(|v| v as f32);
    let spread = PixelSpread::new(0.8, 1.0, 14);
    let (a, b) = (turned(&spread.spread(&picture)), spread.spread(&mirrored));
    // Some 200 roundings of numbers up to 1.
    assert!(a.data().iter().zip(b.data()).all(|(a, b)| (a - b).abs() < 1e-13));
}

#[test]
fn the_bits_do_not_depend_on_the_threads() {
    let (spread, picture) = (PixelSpread::new(1.6, 1.0, 10), noise(50, 200, 7));
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a few threads");
        pool.install(|| spread.spread(&picture))
    };
    let one = with(1);
    assert!(one == with(2) && one == with(7));
}
