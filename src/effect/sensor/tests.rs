//! The chain against EMVA 1288's model and against itself.
//!
//! Judgements of random numbers: a right program would fail each of the z-tests here with a probability below 1e-6 (5
//! standard deviations), were its seed drawn anew.

use super::*;
use crate::effect::picture::Picture;
use crate::num::stats::mean;
use crate::raster::Raster;

const Z: f64 = 5.0;

/// A machine vision sensor of 12 bits with every kind of noise.
fn real() -> Sensor {
    let adc = Adc { bits: 12, gain_dn_per_e: 0.35, black_level_dn: 64.0 };
    Sensor {
        seed: 11,
        fill_factor: 0.8,
        white_e: 9000.0,
        prnu: 0.01,
        dark_e: 12.0,
        shot_noise: true,
        full_well_e: 10_500.0,
        dsnu_e: 3.0,
        read_noise_e: 5.0,
        adc: Some(adc),
        ..Sensor::IDEAL
    }
}

fn grey(picture: Picture) -> Raster<f32> {
    assert!(picture.colour.is_none(), "a grey picture is asked for");
    picture.grey
}

fn flat(sensor: &Sensor, radiance: f32, side: usize) -> Raster<f32> {
    grey(sensor.expose(&Picture::of_grey(Raster::filled(side, side, radiance))))
}

/// In DN of the given converter.
fn dn(picture: &Raster<f32>, adc: &Adc) -> Vec<f64> {
    picture.data().iter().map(|v| f64::from(*v) * adc.largest_dn()).collect()
}

fn variance(values: &[f64]) -> f64 {
    let mean = mean(values);
    values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (values.len() - 1) as f64
}

/// How many standard deviations a sample variance lies from the true one, of near-normal numbers.
fn z_of_variance(found: f64, expected: f64, n: usize) -> f64 {
    (found / expected - 1.0) / (2.0 / (n - 1) as f64).sqrt()
}

#[test]
fn the_ideal_sensor_leaves_every_bit() {
    let light = Raster::from_data(64, 4, (0..256).map(|k| (k as f32 / 255.0).sqrt()).collect());
    assert_eq!(Sensor::IDEAL.expose(&Picture::of_grey(light.clone())), Picture::of_grey(light.clone()));
    // Also in electrons: each strength 0 without the others.
    for white_e in [7.0, 1e4, 123_456.7] {
        let sensor = Sensor { seed: 3, frame: 9, white_e, full_well_e: 1e9, ..Sensor::IDEAL };
        assert_eq!(sensor.expose(&Picture::of_grey(light.clone())), Picture::of_grey(light.clone()), "{white_e}");
        let colour = Picture::of_colours(light.map(|v| [v, 0.5 * v, 0.1]));
        assert_eq!(sensor.expose(&colour), colour);
    }
    // The grey of a spectrum need not be the luminance of its colours.
    let spectral = Picture { grey: light.clone(), colour: Some(light.map(|v| [v, 0.5 * v, 0.1])) };
    assert_eq!(Sensor { fill_factor: 0.5, ..Sensor::IDEAL }.expose(&spectral), spectral);
}

#[test]
fn each_thing_alone_changes_the_picture() {
    let ideal = Sensor { white_e: 1000.0, ..Sensor::IDEAL };
    let light = Picture::of_grey(Raster::filled(16, 16, 0.6f32));
    let adc = Adc { bits: 8, gain_dn_per_e: 0.2, black_level_dn: 5.0 };
    let bayer = Bayer { order: Order::Rggb, transmission: [0.9, 1.0, 0.8], demosaic: Demosaic::Raw };
    let changes = [
        Sensor { bayer: Some(bayer), ..ideal },
        Sensor { prnu: 0.01, ..ideal },
        Sensor { dark_e: 10.0, ..ideal },
        Sensor { shot_noise: true, ..ideal },
        Sensor { full_well_e: 500.0, ..ideal },
        Sensor { dsnu_e: 2.0, ..ideal },
        Sensor { read_noise_e: 2.0, ..ideal },
        Sensor { adc: Some(adc), ..ideal },
        Sensor { gamma: 2.2, ..ideal },
    ];
    for sensor in changes {
        assert_ne!(sensor.expose(&light), light, "{sensor:?}");
    }
}

/// The photon transfer equation of EMVA 1288: temporal variance = K^2 read^2 + 1/12 + K (mean - mean in the dark), from the difference of two
/// frames, in which the fixed pattern falls out.
#[test]
fn the_photon_transfer_curve_is_that_of_emva_1288() {
    let sensor = real();
    let adc = sensor.adc.unwrap();
    let side = 300;
    let pair = |radiance: f32| {
        let [a, b] = [0, 1].map(|frame| dn(&flat(&Sensor { frame, ..sensor }, radiance, side), &adc));
        let difference: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a - b).collect();
        (0.5 * (mean(&a) + mean(&b)), 0.5 * variance(&difference))
    };
    let k = adc.gain_dn_per_e;
    let mut curve = Vec::new();
    for radiance in [0.0, 0.02, 0.1, 0.25, 0.5, 0.75, 1.0] {
        let (mean_dn, variance_dn) = pair(radiance);
        let electrons = sensor.white_e * f64::from(radiance) + sensor.dark_e;
        let (expected_mean, expected) = (
            adc.black_level_dn + k * electrons,
            k * k * (sensor.read_noise_e * sensor.read_noise_e + electrons) + 1.0 / 12.0,
        );
        // The specimen's own mean gain and offset are those of 300 x 300 pixels.
        let square = |v: f64| v * v;
        let pattern = square(k * sensor.dsnu_e) + square(k * electrons * sensor.prnu);
        let error = ((pattern + 0.5 * expected) / (side * side) as f64).sqrt();
        assert!((mean_dn - expected_mean).abs() < Z * error, "{radiance}: mean {mean_dn} {expected_mean}");
        // The difference of two numbers of variance v has twice that; uneven gain adds its square, 1e-4.
        let z = z_of_variance(variance_dn / (1.0 + 1e-4), expected, side * side);
        assert!(z.abs() < Z, "{radiance}: variance {variance_dn} {expected}, z {z}");
        curve.push((mean_dn, variance_dn));
    }
    // The slope of the curve is the gain.
    let ((dark, noise), (bright, bright_noise)) = (curve[0], curve[curve.len() - 1]);
    let slope = (bright_noise - noise) / (bright - dark);
    let error = (2.0 / (side * side) as f64).sqrt() * bright_noise / (bright - dark);
    assert!((slope - k).abs() < Z * error, "{slope}");
}

#[test]
fn a_full_well_holds_no_noise_but_that_of_the_read_out() {
    let quiet = Sensor { dsnu_e: 0.0, read_noise_e: 0.0, adc: None, ..real() };
    // 10500 electrons of 9000 at radiance 1; at radiance 1.4 the mean is 21 standard deviations above.
    let full = flat(&quiet, 1.4, 64);
    assert!(full.data().iter().all(|v| f64::from(*v) == f64::from((10_500.0 / 9000.0) as f32)));
    let read = flat(&Sensor { read_noise_e: 5.0, ..quiet }, 1.4, 64);
    let electrons: Vec<f64> = read.data().iter().map(|v| f64::from(*v) * 9000.0).collect();
    let z = z_of_variance(variance(&electrons), 25.0, 64 * 64);
    assert!(z.abs() < Z, "{z}");
    // A converter that ends before the well does saturates at its own end.
    let adc = Adc { bits: 12, gain_dn_per_e: 0.5, black_level_dn: 64.0 };
    let clipped = flat(&Sensor { adc: Some(adc), ..real() }, 1.4, 64);
    assert!(clipped.data().iter().all(|v| *v == 1.0));
}

/// The error of rounding is even over a step: its variance is 1/12.
#[test]
fn quantisation_has_a_variance_of_a_twelfth() {
    let adc = Adc { bits: 8, gain_dn_per_e: 1.0, black_level_dn: 3.0 };
    let sensor = Sensor { white_e: 200.0, adc: Some(adc), ..Sensor::IDEAL };
    let n = 40_000;
    // Steps of an irrational part of a DN fill a step evenly.
    let light: Vec<f32> = (0..n).map(|k| ((k as f64 * 0.618_033_988_75).fract() * 0.9) as f32).collect();
    let seen = grey(sensor.expose(&Picture::of_grey(Raster::from_data(n, 1, light.clone()))));
    let errors: Vec<f64> = dn(&seen, &adc).iter().zip(&light).map(|(dn, v)| dn - 3.0 - 200.0 * f64::from(*v)).collect();
    // Of n even numbers the variance of the variance is 1/180 of the step^4; f32 keeps a DN of 255 to 1e-5.
    assert!((variance(&errors) - 1.0 / 12.0).abs() < Z * (1.0 / 180.0 / n as f64).sqrt());
    assert!(mean(&errors).abs() < Z * (1.0 / 12.0 / n as f64).sqrt());
    assert!(errors.iter().all(|e| e.abs() <= 0.5 + 1e-4));
    let levels: std::collections::BTreeSet<u64> = dn(&seen, &adc).iter().map(|v| v.round() as u64).collect();
    assert!(dn(&seen, &adc).iter().all(|v| (v - v.round()).abs() < 1e-4) && levels.len() == 181);
}

/// PRNU is the relative spread of the response to light, DSNU the spread in the dark (EMVA 1288, chapter 4), and both stay
/// from frame to frame.
#[test]
fn the_fixed_pattern_is_as_uneven_as_asked_and_stays() {
    let side = 200;
    let fixed = Sensor { shot_noise: false, read_noise_e: 0.0, adc: None, dark_e: 0.0, ..real() };
    let (dark, bright) = (flat(&fixed, 0.0, side), flat(&fixed, 1.0, side));
    assert_eq!(bright, flat(&Sensor { frame: 77, ..fixed }, 1.0, side));
    assert_ne!(bright, flat(&Sensor { seed: 12, ..fixed }, 1.0, side));
    let electrons = |p: &Raster<f32>| p.data().iter().map(|v| f64::from(*v) * 9000.0).collect::<Vec<_>>();
    let (dark, bright) = (electrons(&dark), electrons(&bright));
    let z = z_of_variance(variance(&dark), 9.0, side * side);
    assert!(z.abs() < Z, "DSNU: {z}");
    let response: Vec<f64> = bright.iter().zip(&dark).map(|(b, d)| (b - d) / 9000.0).collect();
    let z = z_of_variance(variance(&response), 1e-4, side * side);
    assert!(z.abs() < Z, "PRNU: {z}");
    // Gain and offset of a pixel have nothing to do with each other.
    let products: Vec<f64> = response.iter().zip(&dark).map(|(r, d)| (r - 1.0) / 0.01 * d / 3.0).collect();
    assert!(mean(&products).abs() < Z / side as f64);
}

/// Noise of two frames, of two pixels and of two channels is independent.
/// Pixels answer unevenly to light, not to their dark current (EMVA 1288, 2.2.2): in the dark they are even, and the
/// unevenness grows with the light alone.
#[test]
fn the_dark_current_has_no_part_in_uneven_response() {
    let sensor = Sensor { prnu: 0.1, dark_e: 400.0, white_e: 1000.0, ..Sensor::IDEAL };
    let dark = flat(&sensor, 0.0, 64);
    assert!(dark.data().iter().all(|v| *v == 0.4), "{:?}", &dark.data()[..4]);
    let lit = flat(&sensor, 0.5, 64);
    let values: Vec<f64> = lit.data().iter().map(|v| f64::from(*v)).collect();
    // 10 % of 0.5, in a sample of 4096: its own standard error is 1 / sqrt(2 x 4096) = 1.1 %; five of them.
    assert!((variance(&values).sqrt() / 0.05 - 1.0).abs() < 0.055, "{}", variance(&values).sqrt());
}

#[test]
fn noise_is_white_in_space_time_and_colour() {
    let sensor = Sensor { prnu: 0.0, dsnu_e: 0.0, adc: None, ..real() };
    let side = 200;
    let noise = |picture: &Raster<f32>| {
        let values: Vec<f64> = picture.data().iter().map(|v| f64::from(*v)).collect();
        let (mean, deviation) = (mean(&values), variance(&values).sqrt());
        values.iter().map(|v| (v - mean) / deviation).collect::<Vec<_>>()
    };
    let (a, b) = (noise(&flat(&sensor, 0.5, side)), noise(&flat(&Sensor { frame: 1, ..sensor }, 0.5, side)));
    let correlation = |x: &[f64], y: &[f64]| mean(&x.iter().zip(y).map(|(x, y)| x * y).collect::<Vec<_>>());
    for (name, other) in [("frame", &b[..]), ("right", &a[1..]), ("below", &a[side..])] {
        assert!(correlation(&a, other).abs() < Z / side as f64, "{name}");
    }
    let colour = sensor
        .expose(&Picture::of_colours(Raster::filled(side, side, [0.5f32; 3])))
        .colour
        .expect("colour stays colour");
    let channels = [0, 1, 2].map(|c| noise(&colour.map(|v| v[c])));
    for (i, j) in [(0, 1), (0, 2), (1, 2)] {
        assert!(correlation(&channels[i], &channels[j]).abs() < Z / side as f64, "{i} {j}");
    }
}

/// Without a black level, half of the read noise in the dark would be cut off.
#[test]
fn the_black_level_comes_before_the_limits() {
    let dark = |black_level_dn: f64| {
        let adc = Adc { bits: 12, gain_dn_per_e: 1.0, black_level_dn };
        let sensor = Sensor { seed: 5, white_e: 3000.0, read_noise_e: 5.0, adc: Some(adc), ..Sensor::IDEAL };
        dn(&flat(&sensor, 0.0, 100), &adc)
    };
    let z = z_of_variance(variance(&dark(64.0)), 25.0 + 1.0 / 12.0, 10_000);
    assert!(z.abs() < Z, "{z}");
    let cut = dark(0.0);
    assert!(cut.iter().all(|v| *v >= 0.0));
    // The mean of the positive half of a normal number: 5 / sqrt(2 pi).
    assert!((mean(&cut) - 5.0 / std::f64::consts::TAU.sqrt()).abs() < Z * 5.0 / 100.0);
}

/// Gamma comes last: the levels of the converter are its powers.
#[test]
fn gamma_bends_the_converters_numbers() {
    let adc = Adc { bits: 4, gain_dn_per_e: 0.15, black_level_dn: 0.0 };
    let sensor = Sensor { white_e: 100.0, adc: Some(adc), gamma: 2.2, ..Sensor::IDEAL };
    let light = Raster::from_data(100, 1, (0..100).map(|k| k as f32 / 99.0).collect());
    for v in grey(sensor.expose(&Picture::of_grey(light))).data() {
        let dn = libm::pow(f64::from(*v), 2.2) * 15.0;
        // An error of f32 in v is 2.2 times that of its power.
        assert!((dn - dn.round()).abs() < 15.0 * 2.2 * 1e-7, "{v} {dn}");
    }
}

/// Each pixel of the mosaic sees its own colour; the filters' shares scale the electrons, so that a dimmer channel is the
/// noisier one.
#[test]
fn the_mosaic_comes_before_the_electrons() {
    let bayer = Bayer { order: Order::Gbrg, transmission: [0.25, 1.0, 0.5], demosaic: Demosaic::Raw };
    let sensor = Sensor { seed: 8, bayer: Some(bayer), white_e: 4000.0, shot_noise: true, ..Sensor::IDEAL };
    let side = 200;
    for light in
        [Picture::of_grey(Raster::filled(side, side, 0.5)), Picture::of_colours(Raster::filled(side, side, [0.5; 3]))]
    {
        let raw = grey(sensor.expose(&light));
        for (colour, share) in bayer.transmission.iter().enumerate() {
            let of_colour = (0..side * side).filter(|k| bayer.colour(k % side, k / side) == colour);
            let electrons: Vec<f64> = of_colour.map(|k| f64::from(raw.data()[k]) * 4000.0).collect();
            let expected = 2000.0 * share;
            let n = electrons.len();
            assert!((mean(&electrons) - expected).abs() < Z * (expected / n as f64).sqrt(), "{colour}");
            assert!(z_of_variance(variance(&electrons), expected, n).abs() < Z, "{colour}");
        }
    }
    let developed = Sensor { bayer: Some(Bayer { demosaic: Demosaic::Bilinear, ..bayer }), ..sensor };
    let colour = developed
        .expose(&Picture::of_grey(Raster::filled(side, side, 0.5)))
        .colour
        .expect("a demosaicked picture has colours");
    // The mean of four pixels has a quarter of the variance: red at the place of blue.
    let red: Vec<f64> = (0..side * side)
        .filter(|k| bayer.colour(k % side, k / side) == 2 && k % side > 0 && k / side > 0)
        .map(|k| f64::from(colour.data()[k][0]) * 4000.0)
        .collect();
    // Neighbouring means share pixels, which widens the spread of the variance by sum of rho^2 = (1 + 2/4 + ...)^2: 2.25.
    assert!(z_of_variance(variance(&red), 500.0 / 4.0, red.len()).abs() < Z * 1.5);
}

#[test]
fn the_bits_do_not_depend_on_the_threads() {
    let light = Picture::of_grey(Raster::from_data(97, 61, (0..97 * 61).map(|k| k as f32 / 6000.0).collect()));
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a few threads");
        pool.install(|| real().expose(&light))
    };
    let one = with(1);
    assert!(one == with(2) && one == with(7));
}

#[test]
fn the_active_side_is_the_root_of_the_fill_factor() {
    assert_eq!(Sensor { fill_factor: 0.25, ..Sensor::IDEAL }.active_side(), 0.5);
    assert_eq!(Sensor::IDEAL.active_side(), 1.0);
}
