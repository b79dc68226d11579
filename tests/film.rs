//! Does the film show what diffraction, a pixel's active area and a sensor do, in rendered pictures?

use crate::instruments::{BOARD, FLAT, FREEFORM, NO_GLASS, built, picture, scene, scene_from, with};
use biprism::accuracy::Accuracy;
use biprism::effect::diffraction::mtf;
use biprism::effect::{Diffraction, Effects, Sensor};
use biprism::num::quadrature::gauss_legendre;
use biprism::num::stats::mean;
use biprism::scene::{self, Encoding, Scene};
use glam::DVec2;
use std::f64::consts::PI;
use std::path::Path;

/// One upright edge, black to its left, white to its right.
const EDGE: &str = "columns = 2\nrows = 1\nsquare_mm = 2000.0\nmargin_mm = 0\nblack = 0\nwhite = 1";

/// A lens of the wavelength times f-number in px, before the pixels of `scene`.
fn lens(scene: &Scene, scale_px: f64) -> Option<Diffraction> {
    let pitch_mm = scene.camera.pitch_mm;
    Some(Diffraction { wavelength_nm: 500.0, f_number: scale_px * pitch_mm / 500e-6, pitch_mm })
}

fn sinc(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { libm::sin(PI * x) / (PI * x) }
}

/// What a gamma has coded is not coded again, and neither is what a scene asks for.
#[test]
fn a_picture_is_coded_once() {
    let coded = |tables: &str, first: &str| {
        let text = format!(
            "name = \"t\"\n{first}\n[camera]\nfocal_length_mm = 35\nwidth_px = 64\nheight_px = 36\npixel_pitch_um = 165\n\
             [prism]\n{NO_GLASS}\n[board]\n{BOARD}\n{tables}\n"
        );
        scene::parse(&text, "test", None).map(|scene| scene.encoding).ok()
    };
    let gamma = "[effect.sensor]\ngamma = 2.2\n";
    let says = |word: &str| format!("{gamma}[output]\nencoding = \"{word}\"");
    assert_eq!(coded("", ""), Some(Encoding::Srgb));
    assert_eq!(coded("[effect.sensor]\nprnu = 0.01\n", ""), Some(Encoding::Srgb));
    assert_eq!(coded(gamma, ""), Some(Encoding::Linear));
    assert_eq!(coded(&says("linear"), ""), Some(Encoding::Linear));
    assert_eq!(coded(&says("srgb"), ""), None);
    // Without effects there is no gamma.
    assert_eq!(coded(&says("srgb"), "effects = \"none\""), Some(Encoding::Srgb));
    assert_eq!(coded(gamma, "effects = \"none\""), Some(Encoding::Srgb));
}

/// The picture of an edge is the integral over its waves of what the lens and the pixel leave of them.
#[test]
fn a_rendered_edge_is_blurred_as_the_transfer_function_says() {
    for (scale, fill_factor) in [(0.12, 1.0), (0.5, 1.0), (1.0, 1.0), (1.0, 0.05), (2.5, 1.0)] {
        for shift_px in [0.0, 0.31, 0.77] {
            let pitch_um = 55.0;
            let x_mm = shift_px * pitch_um * 1e-3 * 1000.0 / 35.0;
            let plain = scene(192, 6, NO_GLASS, &format!("{EDGE}\nposition_mm = [{x_mm}, 0.0, 1000.0]"));
            let diffraction = lens(&plain, scale);
            let sensor = Some(Sensor { fill_factor, ..Sensor::IDEAL });
            let found = picture(&with(&plain, Effects { diffraction, sensor, ..Effects::default() }));
            let (rule, active) = (gauss_legendre(300), fill_factor.sqrt());
            for (i, value) in found.row(3).iter().enumerate().skip(76).take(40) {
                let x = i as f64 + 0.5 - 96.0 - shift_px;
                let wave = |t: f64| {
                    let nu = t / scale;
                    mtf(t) * sinc(active * nu) * libm::sin(2.0 * PI * nu * x) / (PI * nu) / scale
                };
                let expected = 0.5 + rule.iter().map(|[t, w]| w * wave(*t)).sum::<f64>();
                assert!((f64::from(*value) - expected).abs() < 1e-3, "{scale} {fill_factor} {i}: {value} {expected}");
            }
        }
    }
}

/// The Fourier series of a board of squares of `square_px`, with a corner `corner_px` off the picture's middle and a white
/// square to the upper left and the lower right of it, after the lens and pixels with an active square of side `active`
/// (Goodman, Introduction to Fourier Optics, 4th ed., 7.3: each wave is weakened by the transfer function).
fn series(size: [usize; 2], board: TurnedBoard, [scale, active]: [f64; 2]) -> Vec<f64> {
    let TurnedBoard { square_px, corner_px, .. } = board;
    let odd: Vec<f64> = (0..=(square_px / scale) as usize).map(|k| (2 * k + 1) as f64).collect();
    let nu = |k: f64| k / (2.0 * square_px);
    let waves = |axis: usize| -> Vec<Vec<f64>> {
        let place = |i: usize| i as f64 + 0.5 - 0.5 * size[axis] as f64 - corner_px[axis];
        let wave = |i: usize, k: f64| 4.0 / PI * libm::sin(2.0 * PI * nu(k) * place(i)) / k * sinc(active * nu(k));
        (0..size[axis]).map(|i| odd.iter().map(|k| wave(i, *k)).collect()).collect()
    };
    let left = |k: f64, l: f64| mtf(scale * (nu(k) * nu(k) + nu(l) * nu(l)).sqrt());
    let (x, y) = (waves(0), waves(1));
    let rows = y.iter().flat_map(|y| {
        let along = |k: f64| odd.iter().zip(y).map(|(l, y)| y * left(k, *l)).sum::<f64>();
        let row: Vec<f64> = odd.iter().map(|k| along(*k)).collect();
        x.iter()
            .map(move |x| 0.5 + 0.5 * x.iter().zip(&row).map(|(x, along)| x * along).sum::<f64>())
            .collect::<Vec<_>>()
    });
    rows.collect()
}

/// The same of a board that is turned by `turn_rad` from right to down, wave by wave.
fn turned_series(size: [usize; 2], board: TurnedBoard, [scale, active]: [f64; 2]) -> Vec<f64> {
    let TurnedBoard { square_px, corner_px, turn_rad } = board;
    let along = DVec2::from_angle(turn_rad);
    let odd = || (0..=(square_px / scale) as usize).map(|k| (2 * k + 1) as f64);
    let waves: Vec<(DVec2, f64)> = odd()
        .flat_map(|k| odd().flat_map(move |l| [(k, l), (k, -l)]))
        .map(|(k, l)| {
            let nu = (k * along + l * along.perp()) / (2.0 * square_px);
            let left = mtf(scale * nu.length()) * sinc(active * nu.x) * sinc(active * nu.y);
            (nu, -8.0 / (PI * PI * k * l) * left)
        })
        .filter(|(_, weight)| *weight != 0.0)
        .collect();
    let value = |at: usize| {
        let px = DVec2::new((at % size[0]) as f64 + 0.5, (at / size[0]) as f64 + 0.5);
        let from = px - 0.5 * DVec2::new(size[0] as f64, size[1] as f64) - DVec2::from_array(corner_px);
        0.5 + 0.5 * waves.iter().map(|(nu, weight)| weight * libm::cos(2.0 * PI * nu.dot(from))).sum::<f64>()
    };
    (0..size[0] * size[1]).map(value).collect()
}

/// A board of squares of `square_px`, with a corner `corner_px` off the picture's middle, turned from right to down.
#[derive(Clone, Copy)]
struct TurnedBoard {
    square_px: f64,
    corner_px: [f64; 2],
    turn_rad: f64,
}

/// The largest difference between a board's picture and its series, and the largest shift of a place between two pixels of a
/// row that is half bright where an edge is at least half as steep as the steepest, in px.
fn against_series(size: [usize; 2], board: TurnedBoard, [scale, fill_factor]: [f64; 2]) -> [f64; 2] {
    let TurnedBoard { square_px, corner_px, turn_rad } = board;
    let mm = 10.56 / size[0] as f64 * 1000.0 / 35.0;
    // An even number of squares far beyond the border.
    let count = 2 * (40.0 + 20.0 * (size[0] as f64 + 40.0 * scale) / square_px) as usize;
    let [x, y] = corner_px.map(|at| at * mm);
    let lines = format!(
        "columns = {count}\nrows = {count}\nsquare_mm = {:?}\nposition_mm = [{x:?}, {y:?}, 1000.0]\n\
         tilt_deg = [0, 0, {:?}]\nblack = 0\nwhite = 1",
        square_px * mm,
        turn_rad.to_degrees()
    );
    let plain = scene(size[0], size[1], NO_GLASS, &lines);
    let (diffraction, sensor) = (lens(&plain, scale), Some(Sensor { fill_factor, ..Sensor::IDEAL }));
    let found = picture(&with(&plain, Effects { diffraction, sensor, ..Effects::default() }));
    let beside = 0.3 * square_px * DVec2::from_angle(turn_rad).rotate(DVec2::ONE);
    let place = 0.5 * DVec2::new(size[0] as f64, size[1] as f64) + DVec2::from_array(corner_px) - beside;
    let upper_left = picture(&built(&plain)).get(place.x as usize, place.y as usize);
    let fourier = if turn_rad == 0.0 { series } else { turned_series };
    let series = fourier(size, board, [scale, fill_factor.sqrt()]);
    let expected: Vec<f64> = if upper_left > 0.5 { series } else { series.iter().map(|value| 1.0 - value).collect() };
    let off: Vec<f64> = found.data().iter().zip(&expected).map(|(a, b)| f64::from(*a) - b).collect();
    let most = off.iter().fold(0.0, |most: f64, off| most.max(off.abs()));

    // Half-bright places, by how steep the edge is there.
    let steep = |i: usize, j: usize| {
        let at = |i: usize, j: usize| expected[j * size[0] + i];
        let [left, up] = [i.saturating_sub(1), j.saturating_sub(1)];
        let [right, down] = [(i + 1).min(size[0] - 1), (j + 1).min(size[1] - 1)];
        let across = (at(right, j) - at(left, j)) / (right - left) as f64;
        DVec2::new(across, (at(i, down) - at(i, up)) / (down - up) as f64).length()
    };
    let all = || (0..size[1]).flat_map(|j| (0..size[0] - 1).map(move |i| (i, j)));
    let steepest = all().fold(0.0, |most: f64, (i, j)| most.max(steep(i, j)));
    let shift = all().fold(0.0, |most: f64, (i, j)| {
        let at = j * size[0] + i;
        let (a, b) = (expected[at] - 0.5, expected[at + 1] - 0.5);
        let slope = steep(i, j).min(steep(i + 1, j));
        if a * b >= 0.0 || slope < 0.5 * steepest {
            return most;
        }
        let t = a / (a - b);
        most.max(((1.0 - t) * off[at] + t * off[at + 1]).abs() / slope)
    });
    [most, shift]
}

/// Boards that lie aslant, of which other light lies beyond the border than the mirror image of what is seen: the same bounds.
#[test]
fn a_turned_board_is_its_fourier_series() {
    let cases = [
        ([64, 20], 24.83, 45.0, [0.79, 1.0]),
        ([64, 20], 25.7, 45.0, [2.47, 0.05]),
        ([64, 20], 28.83, 45.0, [6.27, 0.05]),
        ([24, 18], 25.46, 39.9, [2.49, 0.5]),
        ([64, 20], 13.33, 45.0, [0.49, 1.0]),
        ([48, 36], 0.6, 45.0, [0.56, 0.25]),
        ([24, 18], 0.54, 45.0, [3.29, 1.0]),
    ];
    for (size, square_px, turn_deg, optics) in cases {
        let board = TurnedBoard { square_px, corner_px: [0.137, 0.32], turn_rad: f64::to_radians(turn_deg) };
        let [most, shift] = against_series(size, board, optics);
        println!("{square_px} px, {turn_deg} deg: {most:.1e} of the contrast, half-bright places {shift:.1e} px");
        let blurred = square_px < 10.3 + 6.0 * optics[0];
        assert!(most < 1e-3 && (blurred || shift < 1e-3), "{square_px} px, {turn_deg} deg: {most}, {shift} px");
    }
}

/// Boards that are sharp to boards that are nearly grey, from pixels that are lit all over to a twentieth: within 1e-3 of the
/// contrast everywhere, and half-bright places within 1e-3 px where squares are as large as the pattern.
#[test]
fn a_rendered_board_is_its_fourier_series() {
    let corners = [[0.137, 0.32], [0.5, 0.0], [-0.26, 0.44]];
    for (k, scale) in [0.1, 0.15, 0.2, 0.3, 0.56, 0.9, 1.4, 2.2, 4.0, 8.0, 13.0, 20.0].into_iter().enumerate() {
        for (l, fill_factor) in [1.0, 0.25, 0.05].into_iter().enumerate() {
            let square_px = 5.3 + 2.7 * ((k + l) % 3) as f64;
            let board = TurnedBoard { square_px, corner_px: corners[(k + 2 * l) % 3], turn_rad: 0.0 };
            let [most, _] = against_series([48, 36], board, [scale, fill_factor]);
            assert!(most < 1e-3, "{scale} px, {fill_factor}, squares of {square_px} px: {most}");
        }
        let square_px = 10.3 + 6.0 * scale;
        let board = TurnedBoard { square_px, corner_px: corners[k % 3], turn_rad: 0.0 };
        let [most, shift] = against_series([96, 54], board, [scale, 1.0]);
        println!(
            "{scale} px, squares of {square_px} px: {most:.1e} of the contrast, half-bright places {shift:.1e} px"
        );
        assert!(most < 1e-3 && shift < 1e-3, "{scale} px, squares of {square_px} px: {most}, {shift} px");
    }
}

/// The slanted-edge method of ISO 12233 on a rendered edge finds the closed form of the transfer function.
#[test]
fn a_slanted_edge_measures_the_transfer_function() {
    const BINS_PER_PX: f64 = 10.0;
    const REACH_PX: f64 = 24.0;
    // A slope of 1 in 10: ten rows fill a pixel's phases.
    let slope = 0.1f64;
    let tilt_deg = libm::atan(slope).to_degrees();
    let board = format!("{EDGE}\nposition_mm = [0.0, 0.0, 1000.0]\ntilt_deg = [0.0, 0.0, {tilt_deg}]");
    let plain = scene(96, 60, NO_GLASS, &board);
    for scale in [0.6, 1.0, 2.0] {
        let effects = Effects { diffraction: lens(&plain, scale), ..Effects::default() };
        let found = picture(&with(&plain, effects));
        // The edge's profile, by the distance of pixels from it.
        let cos = 1.0 / (1.0 + slope * slope).sqrt();
        let bins = (2.0 * REACH_PX * BINS_PER_PX) as usize;
        let (mut sums, mut counts) = (vec![0.0; bins], vec![0.0; bins]);
        for (j, i) in (0..60).flat_map(|j| (0..96).map(move |i| (j, i))) {
            let (x, y) = (i as f64 + 0.5 - 48.0, j as f64 + 0.5 - 30.0);
            let place = ((x + slope * y) * cos + REACH_PX) * BINS_PER_PX;
            if place >= 0.0 && place < bins as f64 {
                sums[place as usize] += f64::from(found.get(i, j));
                counts[place as usize] += 1.0;
            }
        }
        assert!(counts.iter().all(|n| *n > 0.0), "every bin is met");
        let profile: Vec<f64> = sums.iter().zip(&counts).map(|(s, n)| s / n).collect();
        for nu in [0.1, 0.2, 0.3, 0.4] {
            let (mut re, mut im) = (0.0, 0.0);
            for (k, pair) in profile.windows(2).enumerate() {
                let (sin, cos) = libm::sincos(2.0 * PI * nu * (k as f64 + 1.0) / BINS_PER_PX);
                re += (pair[1] - pair[0]) * cos;
                im += (pair[1] - pair[0]) * sin;
            }
            // Means over bins, and their differences, damp a wave.
            let binned = sinc(nu / BINS_PER_PX) * sinc(nu / BINS_PER_PX);
            let measured = (re * re + im * im).sqrt() / binned;
            // The pixel's own sinc, along the normal of the edge: its sides are seen at an angle.
            let pixel = sinc(nu * cos) * sinc(nu * slope * cos);
            let expected = mtf(nu * scale) * pixel;
            // Of the edge's light 4 scale / (pi^3 24 px) falls beyond the profile.
            assert!((measured - expected).abs() < 0.012, "{scale} {nu}: {measured} {expected}");
        }
    }
}

/// A pixel whose active square has half its side is the middle four of sixteen: at the edges of squares, on the ridge, at
/// the border of the plate, at every level of accuracy.
#[test]
fn the_active_square_is_the_middle_of_the_pixel() {
    let tilted = format!("{FLAT}\ntilt_deg = [2.0, 3.0, 5.0]");
    for (prism, accuracy) in [
        (FREEFORM, Accuracy::standard()),
        (FLAT, Accuracy::exact()),
        (&tilted, Accuracy::standard()),
        (FLAT, Accuracy::draft()),
        (FLAT, Accuracy::reference()),
    ] {
        let mut plain = scene(64, 36, prism, BOARD);
        plain.accuracy = accuracy;
        let sensor = Some(Sensor { fill_factor: 0.25, ..Sensor::IDEAL });
        let found = picture(&with(&plain, Effects { sensor, ..Effects::default() }));
        let fine = picture(&built(&plain).sampled(4));
        let mut worst = 0.0f64;
        for (j, i) in (0..36).flat_map(|j| (0..64).map(move |i| (j, i))) {
            let middle = |k: usize| f64::from(fine.get(4 * i + 1 + k % 2, 4 * j + 1 + k / 2));
            let expected = 0.25 * (0..4).map(middle).sum::<f64>();
            worst = worst.max((f64::from(found.get(i, j)) - expected).abs());
        }
        // A level may move each of up to four lines in a square by its promise, which is twice as much of half a pixel's
        // width, and in the fine picture by a quarter of that; of a contrast of 0.8.
        let bound = 1e-6 + 4.0 * 2.0 * 1.25 * 0.8 * accuracy.promise_px;
        assert!(worst < bound, "{prism} {:?}: {worst}", accuracy.level);
    }
}

/// Even light stays even on average, and as noisy as its electrons: shot noise of half a full well of 10000.
#[test]
fn a_rendered_wall_shows_the_noise_of_its_electrons() {
    let wall = format!("{BOARD}\nblack = 0.5\nwhite = 0.5\nbackground = 0.5");
    let sensor = "[effect.sensor]\nseed = 9\nwhite_e = 10000.0\nread_noise_e = 20.0\n";
    let noisy = scene_from(160, 90, "", FLAT, &format!("{wall}\n{sensor}"));
    let electrons: Vec<f64> = picture(&built(&noisy)).data().iter().map(|v| 1e4 * f64::from(*v)).collect();
    let (n, expected) = (electrons.len() as f64, 5000.0 + 400.0);
    let average = mean(&electrons);
    // z-tests of 5 standard deviations: a right picture would fail once in a million seeds.
    assert!((average - 5000.0).abs() < 5.0 * (expected / n).sqrt(), "{average}");
    let variance = electrons.iter().map(|e| (e - average) * (e - average)).sum::<f64>() / (n - 1.0);
    assert!((variance / expected - 1.0).abs() < 5.0 * (2.0 / n).sqrt(), "{variance}");
}

#[test]
fn film_effects_have_the_same_bits_from_any_number_of_threads() {
    for case in ["effect_diffraction", "effect_sensor"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/cases/{case}.toml"));
        let system = built(&scene::load(&path).unwrap_or_else(|problem| panic!("{problem}")));
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| picture(&system))
        };
        let one = with(1);
        assert!(one == with(2) && one == with(5), "{case}");
    }
}
