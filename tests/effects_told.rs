//! Is what the program tells of effects true: noise, what acts and what does not, the square that receives light?

use crate::command::biprism;
use crate::instruments::{BOARD, FLAT, NO_GLASS, built, scene, with};
use biprism::effect::thin_lens::Aperture;
use biprism::effect::{Effects, Lens, Quadrature, ThinLens};
use biprism::render::{Outputs, render_wanted};
use biprism::scene::{self, Scene};
use biprism::system::auto::verdicts;
use biprism::system::{doubts, ideal};
use std::fs;

/// A scene as text, of a picture of 48 x 27 px `times` as fine.
fn text(times: usize, prism: &str, rest: &str) -> String {
    let [width, height] = [48 * times, 27 * times];
    let pitch_um = 10560.0 / width as f64;
    format!(
        "name = \"told\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = {width}\nheight_px = {height}\n\
         pixel_pitch_um = {pitch_um:?}\n[prism]\n{prism}\n[board]\n{BOARD}\n{rest}\n"
    )
}

fn parsed(text: &str) -> Scene {
    scene::parse(text, "told", None).unwrap_or_else(|problem| panic!("{problem}\n{text}"))
}

/// The standard error told of few sets is that of many pictures, and where sets stop for it, it is kept.
#[test]
fn a_standard_error_is_what_pictures_stray_by() {
    const SEEDS: u64 = 100;
    // One block, all of it out of focus.
    let board = "columns = 9\nrows = 9\nsquare_mm = 100.0\nposition_mm = [13.0, 7.0, 1000.0]\ntilt_deg = [0, 0, 20]";
    let plain = scene(8, 8, NO_GLASS, board);
    let lens = Lens::Thin(ThinLens::new(2.0, 600.0, Aperture::Circle, 35.0));
    let of = |quadrature| {
        let effects = Effects { lens, quadrature, ..Effects::default() };
        render_wanted(&with(&plain, effects), Outputs { truth: false }, &())
    };
    let truth = of(Quadrature { points: 4096, ..Quadrature::default() });
    let square_error = |film: &biprism::render::Film| {
        let pixels = film.radiance.data().iter().zip(truth.radiance.data());
        let squares = pixels.map(|(a, b)| f64::from(a - b) * f64::from(a - b));
        squares.sum::<f64>() / truth.radiance.data().len() as f64
    };

    // Compare the root mean squares of what is found and what is told, over the seeds.
    for replicates in [4, 5, 8] {
        let (mut found, mut told) = (0.0, 0.0);
        for seed in 0..SEEDS {
            let film = of(Quadrature { points: 4, replicates, noise: None, seed, ..Quadrature::default() });
            found += square_error(&film) / SEEDS as f64;
            told += film.account.noise.expect("there are sets enough") / SEEDS as f64;
        }
        let ratio = told / found.sqrt();
        println!("{replicates} sets: told {told:.3e}, found {:.3e}, ratio {ratio:.3}", found.sqrt());
        assert!((0.8..1.2).contains(&ratio), "{replicates} sets: {ratio}");
    }
    // Two sets or three tell nothing.
    assert!(
        of(Quadrature { points: 4, replicates: 3, noise: None, seed: 1, ..Quadrature::default() })
            .account
            .noise
            .is_none()
    );

    // The true standard error of as many sets as were taken: their variance falls as their number.
    let mut square = 0.0;
    for seed in 0..SEEDS {
        square +=
            square_error(&of(Quadrature { points: 4, replicates: 8, noise: None, seed, ..Quadrature::default() }))
                / SEEDS as f64;
    }
    let target = (square * 8.0 / 10.0).sqrt();
    let stopped =
        |seed| of(Quadrature { points: 4, replicates: 24, noise: Some(target), seed, ..Quadrature::default() });
    let missed = (0..SEEDS).filter(|seed| stopped(*seed).account.passes < 10 * 4).count();
    println!("{missed} of {SEEDS} runs stopped before 10 sets");
    assert!(missed * 20 <= SEEDS as usize, "{missed} of {SEEDS} runs stopped too early");
}

/// A noise that was asked for and not reached is exit code 1, in words and in the report's account.
#[test]
fn an_unmet_noise_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let lens = |noise: f64| {
        let rest = "[effect.thin_lens]\nf_number = 4.0\nfocus_mm = 600.0\n[quadrature]\npoints = 4\nreplicates = 8\n";
        text(1, FLAT, &format!("{rest}noise = {noise:?}"))
    };
    for (noise, code, words) in [(1e-3, 1, "`quadrature.noise` asks for 1.0e-3"), (0.5, 0, "")] {
        fs::write(folder.path().join("scene.toml"), lens(noise)).unwrap();
        let run = biprism(folder.path(), &["render", "scene.toml", "--out", "a.png"]);
        let told = String::from_utf8_lossy(&run.stderr).into_owned();
        assert!(run.status.code() == Some(code) && told.contains(words), "{told}");
        assert!(folder.path().join("a.png").exists(), "the picture is what it is");
    }
}

/// What acts by the glass of a prism does nothing without one, costs nothing, and is told.
#[test]
fn effects_of_a_glass_that_is_not_there_are_told() {
    let plain = built(&parsed(&text(1, NO_GLASS, "")));
    let plain = render_wanted(&plain, Outputs { truth: true }, &());
    for (effect, key) in [
        ("[effect.fresnel]", "fresnel"),
        ("[effect.fresnel]\n[effect.coating]\nindex = 1.38\nquarter_wave_nm = 550", "coating"),
        ("[effect.fresnel]\n[effect.ghosts]\nbehind = 0.5", "ghosts"),
        ("[effect.absorption]\nper_mm = 0.05", "absorption"),
        ("[effect.roughness]\nback_slope_deg = 1.0", "roughness"),
        ("[effect.manufacture]\ntilt_deg = [1, 0, 0]", "manufacture"),
        ("[effect.clipping]\nrim = { diameter_mm = 5.0 }", "clipping"),
        ("[effect.clipping]\nchamfer_mm = 0.5", "clipping"),
    ] {
        let scene = parsed(&text(1, NO_GLASS, effect));
        let system = built(&scene);
        let told = doubts(&scene, &system);
        assert!(told.len() == 1 && told[0].contains(&format!("`[effect.{key}]`")), "{told:?}");
        let film = render_wanted(&system, Outputs { truth: true }, &());
        assert!(film.radiance == plain.radiance && film.account.passes == 1, "{key}");
    }
    // A stop before the lens needs no glass.
    let stop = parsed(&text(1, NO_GLASS, "[effect.clipping]\nstop = { at_mm = 30.0, diameter_mm = 5.0 }"));
    assert!(doubts(&stop, &built(&stop)).is_empty());
}

/// Ghosts are averaged over the square that receives light: that of a fill factor of 1 / 11^2 is the middle pixel of 11 x 11.
#[test]
fn ghosts_are_those_of_the_active_square() {
    let ghosts = "[effect.fresnel]\n[effect.ghosts]\nbounces = 4\nleast_power = 0.0\nbehind = 0.2\nsamples = 16";
    let prism = FLAT.replace("1.48", "1.9") + "\nfacet_angle_deg = 1.0";
    let of = |times: usize, rest: &str| {
        let scene = parsed(&text(times, &prism, rest));
        render_wanted(&built(&scene), Outputs { truth: false }, &()).radiance
    };
    let part = of(1, &format!("{ghosts}\n[effect.sensor]\nfill_factor = {:?}", 1.0 / 121.0));
    let [fine, whole] = [of(11, ghosts), of(1, ghosts)];
    let off = |of: &dyn Fn(usize, usize) -> f32| {
        let pixels = (0..48 * 27).map(|k| (k % 48, k / 48));
        pixels.map(|(i, j)| f64::from((of(i, j) - part.get(i, j)).abs())).fold(0.0, f64::max)
    };
    let (to_middle, to_whole) = (off(&|i, j| fine.get(11 * i + 5, 11 * j + 5)), off(&|i, j| whole.get(i, j)));
    println!("to the middle {to_middle:.1e}, to the whole {to_whole:.1e}");
    // Two pictures keep to their bends of blocks, 1e-5; pixels where light takes several routes are sampled.
    assert!(to_middle < 1e-3 && to_whole > 0.01, "{to_middle} {to_whole}");
}

/// The grey of a colour picture is the luminance of its channels, as the reader of pictures takes it, with a sensor or not.
#[test]
fn grey_is_the_luminance_of_the_colours() {
    let prism = FLAT.replace("1.48", "1.84666") + "\nglass = \"N-SF57\"";
    let dispersion = "[effect.dispersion]\nresponse = \"nikon_d5100\"\nwavelengths = 6";
    for sensor in ["", "[effect.sensor]\nadc_bits = 16", "[effect.diffraction]\nf_number = 8.0"] {
        let scene = parsed(&text(1, &prism, &format!("{dispersion}\n{sensor}")));
        let film = render_wanted(&built(&scene), Outputs { truth: false }, &());
        let colour = film.colour.expect("the sensor tells colours apart");
        for (grey, [r, g, b]) in film.radiance.data().iter().zip(colour.data()) {
            let told = 0.2126 * f64::from(*r) + 0.7152 * f64::from(*g) + 0.0722 * f64::from(*b);
            // Sums of single precision, and what one rounding of each channel leaves.
            assert!((f64::from(*grey) - told).abs() < 4.0 * f64::from(f32::EPSILON), "{sensor}: {grey} {told}");
        }
    }
}

/// The file of a picture that is no linear light says how it is made light again.
#[test]
fn a_file_says_how_its_values_are_made_light() {
    let folder = tempfile::tempdir().unwrap();
    let sensor = "[effect.sensor]\nwhite_e = 1000.0\nshot_noise = false\nadc_bits = 12\ngain_dn_per_e = 2.0\n\
                  black_level_dn = 64.0\ngamma = 2.0";
    fs::write(folder.path().join("scene.toml"), text(1, FLAT, sensor)).unwrap();
    assert!(biprism(folder.path(), &["render", "scene.toml", "--out", "a.exr"]).status.success());
    let (_, metadata) = biprism::io::read(&folder.path().join("a.exr"), None).unwrap();
    let notes = metadata.texts.values().find(|text| text.contains("\"radiance\"")).expect("the file has notes");
    let notes: serde_json::Value = serde_json::from_str(notes).unwrap();
    let words = notes["radiance"].as_str().unwrap();
    assert!(
        words.contains("which v^2 undoes") && words.contains(&format!("(v - {}) * {}", 64.0 / 4095.0, 4095.0 / 2000.0)),
        "{words}"
    );
}

/// Corners of a picture that a sensor has coded by its gamma are those of the light, from both kinds of file and in the
/// program's own measurement.
#[test]
fn a_gamma_is_undone_before_corners_are_sought() {
    let folder = tempfile::tempdir().unwrap();
    let mut found: Vec<Vec<[f64; 2]>> = Vec::new();
    for (name, gamma) in [("plain", "1.0"), ("coded", "2.2")] {
        let sensor = format!("[effect.sensor]\ngamma = {gamma}");
        fs::write(folder.path().join("scene.toml"), text(8, FLAT, &sensor)).unwrap();
        for file in [format!("{name}.exr"), format!("{name}.png")] {
            assert!(biprism(folder.path(), &["render", "scene.toml", "--out", &file]).status.success());
            let run = biprism(folder.path(), &["corners", &file, "--json"]);
            let value: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
            let corners =
                value["halves"].as_array().unwrap().iter().flat_map(|half| half["corners"].as_array().unwrap());
            let px = |corner: &serde_json::Value| [0, 1].map(|axis| corner["position_px"][axis].as_f64().unwrap());
            found.push(corners.map(px).collect());
        }
    }
    assert!(found[0].len() > 20, "{}", found[0].len());
    for other in &found[1..] {
        assert_eq!(other.len(), found[0].len());
        for (a, b) in found[0].iter().zip(other) {
            // 16 bits, after a gamma some 4 of them lost in the dark.
            assert!(libm::hypot(a[0] - b[0], a[1] - b[1]) < 2e-3, "{a:?} {b:?}");
        }
    }
}

/// A symmetric scene has a symmetric picture, whatever it is sampled by.
#[test]
fn symmetric_scenes_have_symmetric_pictures() {
    for effect in [
        "[effect.thin_lens]\nf_number = 2.0\nfocus_mm = 700.0",
        "[effect.thin_lens]\nf_number = 2.0\nfocus_mm = 700.0\nblades = 6",
        "[effect.roughness]\nback_slope_deg = 0.3",
        "[effect.thin_lens]\nf_number = 2.0\nfocus_mm = 700.0\n[effect.roughness]\nfront_slope_deg = 0.2\n[quadrature]\n\
         points = 16\nreplicates = 4",
        "[effect.diffraction]\nf_number = 40.0",
    ] {
        let scene = parsed(&text(1, FLAT, effect));
        let picture = render_wanted(&built(&scene), Outputs { truth: false }, &()).radiance;
        let width = picture.width();
        for (k, value) in picture.data().iter().enumerate() {
            let twin = picture.get(width - 1 - k % width, k / width);
            // The promise of the level, 1e-5 px on either side, and f32.
            assert!((value - twin).abs() < 2e-5, "{effect}: {k} {value} {twin}");
        }
    }
}

/// The bound of an effect holds beside a lamp that lights more than the reference, and behind a wide lens.
#[test]
fn bounds_hold_among_other_effects() {
    let lamp = "[effect.lamp]\nposition_mm = [60, 0, 980]\n[effect.absorption]\nper_mm = 2e-4";
    let lens = "[effect.thin_lens]\nf_number = 1.4\nfocus_mm = 1000\n[effect.cos4]\n[quadrature]\npoints = 8";
    // A gamma below 1 is steepest where light is above full scale.
    let bright = "white = 5.0\n[effect.cos4]\nexponent = 0.2\n[effect.sensor]\ngamma = 0.4";
    for (prism, rest, key) in [(FLAT, lamp, "absorption"), (NO_GLASS, lens, "cos4"), (NO_GLASS, bright, "cos4")] {
        let scene = parsed(&text(1, prism, rest));
        let without = Scene { effects: scene.effects.only(|row| row.key() != key), ..scene.clone() };
        let of = |scene: &Scene| render_wanted(&built(scene), Outputs { truth: false }, &()).radiance;
        let (a, b) = (of(&scene), of(&without));
        let change = a.data().iter().zip(b.data()).map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max);
        let told = verdicts(&ideal(&scene).unwrap(), &scene);
        let bound = told.iter().find(|verdict| verdict.effect.key() == key).unwrap().bound.unwrap();
        println!("{key}: {change:.2e} of at most {:.2e}", bound.grey);
        assert!(change <= bound.grey && bound.grey < 10.0 * change, "{key}: {change} above {}", bound.grey);
    }
}

/// What is left out changes less than the threshold also where an effect acts by others: a ridge that a lens or an error of the
/// prism brings into the picture, rims that stop ghosts, coatings that make ghosts, what ghosts bring, a lamp between the rays of
/// the grid, and waves of its distance.
#[test]
fn what_acts_by_others_is_kept() {
    let aside = format!("{FLAT}\nposition_mm = [13.0, 0.0, 0.0]");
    let ghosts = "[effect.fresnel]\n[effect.ghosts]\nbehind = 2.0\nsamples = 1";
    let lens = "[effect.thin_lens]\nf_number = 1.4\nfocus_mm = 1000\n[quadrature]\npoints = 16";
    let cases = [
        (aside.as_str(), "clipping", format!("[effect.clipping]\nchamfer_mm = 1.0\n{lens}")),
        (FLAT, "clipping", format!("[effect.clipping]\nrim = {{ sides_mm = [26.0, 14.6] }}\n{ghosts}")),
        (FLAT, "ghosts", format!("{ghosts}\n[effect.coating]\nindex = 2.6\nthickness_nm = 56.0")),
        (FLAT, "absorption", format!("{ghosts}\n[effect.absorption]\nper_mm = 2e-4")),
        (NO_GLASS, "lamp", "[effect.lamp]\nposition_mm = [3.1, 5.7, 999.7]\nshare = 1e-6".to_owned()),
        (FLAT, "manufacture", "[[effect.manufacture.front.waves]]\namplitude_um = 0.5\nperiod_mm = 0.7".to_owned()),
    ];
    for (prism, key, rest) in cases {
        let scene = parsed(&text(1, prism, &rest));
        let without = Scene { effects: scene.effects.only(|row| row.key() != key), ..scene.clone() };
        let of = |scene: &Scene| render_wanted(&built(scene), Outputs { truth: false }, &()).radiance;
        let (a, b) = (of(&scene), of(&without));
        let change = a.data().iter().zip(b.data()).map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max);
        let told = verdicts(&ideal(&scene).unwrap(), &scene);
        let bound = told.iter().find(|verdict| verdict.effect.key() == key).unwrap().bound;
        println!("{key}: {change:.2e} of at most {bound:?}");
        assert!(bound.is_none_or(|bound| change <= bound.grey), "{key}: {change} above {bound:?}");
    }
}
