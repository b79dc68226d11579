//! The kernel and the blur against closed forms of diffraction theory.

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

/// A pattern far wider than a pixel: pixels that are lit and collect all over weigh as the pattern's height, whose middle
/// is pi / 4 over the square of its scale.
#[test]
fn weights_of_a_wide_pattern_are_its_heights() {
    let scale = 5.0;
    let kernel = PointSpread::with_samples(scale, 1.0, 1);
    let side = 2 * kernel.core + 1;
    for (i, j) in [(0, 0), (1, 0), (2, 3), (6, 0), (9, 4), (0, 21)] {
        let height = |x: f64, y: f64| airy((x * x + y * y).sqrt() / scale) * PI / 4.0 / (scale * scale);
        let weight = kernel.near[(kernel.core + j) * side + kernel.core + i];
        // The spline's response is 0.5 % low at the cut-off, 1/5 a px, where no light is left, and 0.03 % at half of it.
        assert!((weight - height(i as f64, j as f64)).abs() < 5e-4 * height(0.0, 0.0), "({i}, {j}): {weight}");
    }
}

#[test]
fn all_light_is_accounted_for() {
    for scale in [1e-3, 0.05, 0.3, 0.8, 1.6, 3.0, 7.0, 16.0] {
        for active in [1.0, 0.6] {
            let kernel = PointSpread::new(scale, active);
            let sum = |weights: &[f64]| weights.iter().sum::<f64>();
            assert!(kernel.near.iter().chain(&kernel.far.weights).all(|w| *w >= 0.0));
            let (near, far) = (sum(&kernel.near), sum(&kernel.far.weights));
            // Some 30000 numbers summed, each rounded.
            assert!((near + far - 1.0).abs() < 1e-12, "{scale}");
            // What is far lies beyond the largest circle within the core and within the smallest around it. A pixel blurs
            // by less than a px itself; 1e-4 is for what HIGHEST leaves out.
            let beyond = |r: f64| 1.0 - encircled_energy(r / scale);
            let r = kernel.core as f64 + 0.5;
            let (most, least) = (beyond(r - 0.75), beyond(2f64.sqrt() * (r + 0.75)));
            assert!((least - 1e-4..most + 1e-4).contains(&far), "{scale} {active}: {far} {least} {most}");
            assert!(kernel.lost() <= 0.005 && kernel.far.block % 2 == 1);
        }
    }
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
    let kernel = PointSpread::new(2.0, 1.0);
    let (side, reach) = (2 * kernel.far.reach + 1, kernel.far.reach);
    let weight = |m: usize| kernel.far.weights[reach * side + reach + m];
    assert!((weight(8) / weight(16) - 8.0).abs() < 0.2, "{}", weight(8) / weight(16));
}

#[test]
fn without_a_pattern_a_pixel_keeps_its_light() {
    let kernel = PointSpread::new(1e-6, 1.0);
    let fine = Raster::from_data(28, 20, (0..28 * 20).map(|k| ((k * 7919) % 97) as f32 / 97.0).collect());
    let out = blur(&fine, &kernel);
    let n = kernel.samples();
    for j in 0..out.height() {
        for i in 0..out.width() {
            let mean: f32 = (0..n * n).map(|k| fine.get(n * i + k % n, n * j + k / n)).sum::<f32>() / (n * n) as f32;
            // The spline takes the light of the pixel's own samples only, but for what HIGHEST leaves out: 1e-5 of each
            // of the 128 samples around, of a contrast of 1, the half of them too much.
            assert!((out.get(i, j) - mean).abs() < 6e-4, "{} {mean}", out.get(i, j));
        }
    }
}

/// A wave of `nu` per px along x with the exact means of `n` samples a pixel.
fn sine(nu: f64, n: usize, width: usize) -> Raster<f32> {
    let step = 1.0 / n as f64;
    let edge = |k: usize| -libm::cos(2.0 * PI * nu * k as f64 * step) / (2.0 * PI * nu);
    let row: Vec<f32> = (0..width * n).map(|k| (0.5 + 0.5 * (edge(k + 1) - edge(k)) / step) as f32).collect();
    Raster::from_data(width * n, 2 * n, row.repeat(2 * n))
}

/// The amplitude of the wave of `nu` per px in the middle of a row, by least squares over whole waves; the picture is 1/2 +
/// a sin + b cos.
fn amplitude(picture: &Raster<f32>, nu: f64, from: usize, to: usize) -> f64 {
    let (mut s, mut c) = (0.0, 0.0);
    for i in from..to {
        let (sin, cos) = libm::sincos(2.0 * PI * nu * (i as f64 + 0.5));
        s += (f64::from(picture.get(i, 0)) - 0.5) * sin;
        c += (f64::from(picture.get(i, 0)) - 0.5) * cos;
    }
    2.0 * 2.0 / (to - from) as f64 * (s * s + c * c).sqrt()
}

/// The measured modulation of rendered waves against the closed form, times the pixel's own sinc.
#[test]
fn waves_lose_the_modulation_that_theory_says() {
    for (scale, active) in [(0.4, 1.0), (0.8, 1.0), (0.8, 0.6), (1.6, 1.0), (3.0, 1.0), (3.0, 0.7)] {
        let kernel = PointSpread::new(scale, active);
        let n = kernel.samples();
        for nu in [0.05, 0.1, 0.2, 0.3, 0.4, 0.45] {
            let (margin, waves) = (kernel.radius() + 1, 80);
            let out = blur(&sine(nu, n, 2 * margin + waves), &kernel);
            let measured = amplitude(&out, nu, margin, margin + waves);
            let expected = mtf(nu * scale) * libm::sin(PI * nu * active) / (PI * nu * active);
            // The light that falls beyond the kernel carries at most its own share of the wave.
            assert!((measured - expected).abs() < kernel.lost(), "{scale} {active} {nu}: {measured} {expected}");
        }
    }
}

/// The most by which the picture of an edge of height 1 can be wrong because its samples were taken `n` a pixel: the
/// integral over all frequencies of what the samples make of the edge's wave, less what diffraction makes of it.
fn sampling_error(scale: f64, active: f64, n: f64) -> f64 {
    let sinc = |x: f64| if x == 0.0 { 1.0 } else { libm::sin(PI * x) / (PI * x) };
    let optics = |nu: f64| mtf(nu * scale) * sinc(active * nu);
    // Of the spline: nu^-4 over the sum of its aliases, here n times finer than a pixel.
    let spline = |nu: f64| {
        let fourth = |u: f64| if u == 0.0 { 1.0 } else { 1.0 / (u * u * u * u) };
        let aliases: f64 = (-30..=30).map(|m| fourth(nu / n + f64::from(m))).sum();
        if (nu / n).fract() == 0.0 { f64::from(nu == 0.0) } else { fourth(nu / n) / aliases }
    };
    let response = |nu: f64| -> f64 {
        let folded = (-6..=6).map(|m| nu + f64::from(m) * n);
        folded
            .filter(|nu| nu.abs() < 1.0 / scale && nu.abs() > 1e-9)
            .map(|nu| optics(nu) * spline(nu) / sinc(nu / n))
            .sum()
    };
    // From one period to the next the wave of an edge falls off and the samples' sinc with it: the rest is 1 %.
    let (steps, end) = (20_000, 12.0 * n);
    let nu = |k: usize| (k as f64 + 0.5) * end / steps as f64;
    let made = |nu: f64| (response(nu) * sinc(nu / n) - optics(nu)).abs() / (PI * nu);
    1.01 * (0..steps).map(|k| made(nu(k))).sum::<f64>() * end / steps as f64
}

/// An edge through a pixel row at any phase, against the integral of the transfer function.
#[test]
fn edges_look_as_theory_says() {
    for (scale, active) in [(0.1, 1.0), (0.3, 1.0), (0.8, 1.0), (0.8, 0.6), (1.6, 1.0), (3.0, 1.0)] {
        let kernel = PointSpread::new(scale, active);
        let (n, margin) = (kernel.samples(), kernel.radius() + 1);
        let width = 2 * margin + 20;
        let step = 1.0 / n as f64;
        let mut worst: f64 = 0.0;
        for phase in 0..7 {
            let edge = margin as f64 + 10.0 + f64::from(phase) / 7.0;
            let row: Vec<f32> = (0..width * n).map(|k| (k as f64 + 1.0 - edge / step).clamp(0.0, 1.0) as f32).collect();
            let out = blur(&Raster::from_data(width * n, n, row.repeat(n)), &kernel);
            let rule = crate::num::quadrature::gauss_legendre(400);
            for i in margin..margin + 20 {
                let x = i as f64 + 0.5 - edge;
                let integral: f64 = (rule.iter())
                    .map(|[t, w]| {
                        let nu = t / scale;
                        let sinc = libm::sin(PI * nu * active) / (PI * nu * active);
                        w / scale * mtf(*t) * sinc * libm::sin(2.0 * PI * nu * x) / (PI * nu)
                    })
                    .sum();
                worst = worst.max((f64::from(out.get(i, 0)) - 0.5 - integral).abs());
            }
        }
        let bound = 0.5 * kernel.lost() + sampling_error(scale, active, n as f64);
        assert!(worst < bound, "{scale} {active}: {worst} {bound}");
    }
}

#[test]
fn light_is_neither_made_nor_lost_and_uniform_stays_uniform() {
    for scale in [0.3, 0.8, 3.0] {
        let kernel = PointSpread::new(scale, 1.0);
        let n = kernel.samples();
        let (width, height) = (23, 9);
        let noise = |k: usize| crate::num::deviates::Stream::new(5, 0, 0, k as u32).uniform() as f32;
        // Evenly lit pixels: of the light of one sample a little more than of its neighbour's falls beyond the core.
        let even = |k: usize| noise(k / n % width + k / (width * n) / n * width);
        let fine = Raster::from_data(width * n, height * n, (0..width * n * height * n).map(even).collect());
        let sum = |picture: &Raster<f32>| picture.data().iter().map(|v| f64::from(*v)).sum::<f64>();
        let before = sum(&fine) / (n * n) as f64;
        let after = blur(&fine, &kernel);
        // Every value rounds once to f32. Between blocks the far light, 5 %, is linear, which leaves out its bend over a
        // block: 1/8 of (3 / 5)^2 of what it changes by over the core, by turns too little and too much.
        assert!((sum(&after) / before - 1.0).abs() < 1e-4, "{scale}: {} {before}", sum(&after));
        let (low, high) =
            (fine.data().iter().copied().fold(1.0, f32::min), fine.data().iter().copied().fold(0.0, f32::max));
        assert!(after.data().iter().all(|v| (low..=high).contains(v)));
        let uniform = blur(&Raster::filled(width * n, height * n, 0.37f32), &kernel);
        assert!(uniform.data().iter().all(|v| (v - 0.37).abs() <= 0.37 * f32::EPSILON), "{scale}");
    }
}

#[test]
fn a_mirrored_picture_has_the_mirrored_bits() {
    let kernel = PointSpread::new(0.8, 1.0);
    let n = kernel.samples();
    let (width, height) = (37, 5);
    let noise = |k: usize| crate::num::deviates::Stream::new(6, 0, 0, k as u32).uniform() as f32;
    let fine = Raster::from_data(width * n, height * n, (0..width * n * height * n).map(noise).collect());
    let turned = |p: &Raster<f32>| {
        let w = p.width();
        Raster::from_data(w, p.height(), (0..p.data().len()).map(|k| p.get(w - 1 - k % w, k / w)).collect())
    };
    assert_eq!(blur(&turned(&fine), &kernel), turned(&blur(&fine, &kernel)));
}

#[test]
fn the_bits_do_not_depend_on_the_threads() {
    let kernel = PointSpread::new(1.6, 1.0);
    let n = kernel.samples();
    let noise = |k: usize| crate::num::deviates::Stream::new(7, 0, 0, k as u32).uniform() as f32;
    let fine = Raster::from_data(50 * n, 200 * n, (0..50 * n * 200 * n).map(noise).collect());
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a few threads");
        pool.install(|| blur(&fine, &kernel))
    };
    let one = with(1);
    assert!(one == with(2) && one == with(7));
}
