//! Are boards with textures rendered as what they show says, at every level and with every effect?

use crate::command::{biprism, text};
use crate::instruments::{BOARD, FLAT, FREEFORM, NO_GLASS, built, picture};
use biprism::accuracy::Level;
use biprism::raster::Raster;
use biprism::render::supersample::{SamplePlaces, supersampled};
use biprism::render::{Class, render};
use biprism::scene::{self, Scene};
use std::fs;
use std::path::Path;

/// Samples along each side of a pixel by which a picture is judged: 16384 in all.
const SAMPLES: usize = 128;
/// Of a quarter of the paper's field, whose pixels bend little, so that the reference has soon divided them enough.
const NARROW_UM: f64 = 2640.0;

/// A scene over the paper's field of `width` x `height` px whose board has these keys; files are looked for in `folder`.
fn textured(size: [usize; 2], prism: &str, board: &str, effects: &str, folder: Option<&Path>) -> Scene {
    textured_over(10560.0, size, prism, board, effects, folder)
}

/// [`textured`], over so many um of the sensor.
fn textured_over(
    width_um: f64,
    size: [usize; 2],
    prism: &str,
    board: &str,
    effects: &str,
    folder: Option<&Path>,
) -> Scene {
    let pitch_um = width_um / size[0] as f64;
    let text = format!(
        "name = \"test\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = {}\nheight_px = {}\npixel_pitch_um = {pitch_um}\n\
         [prism]\n{prism}\n[board]\n{board}\n{effects}\n",
        size[0], size[1]
    );
    scene::parse(&text, "test", folder).unwrap_or_else(|problem| panic!("{problem}\n{text}"))
}

/// A PGM of 8 bits.
fn pgm(folder: &Path, name: &str, size: [usize; 2], value: impl Fn(usize, usize) -> u8) {
    let mut bytes = format!("P5\n{} {}\n255\n", size[0], size[1]).into_bytes();
    bytes.extend((0..size[0] * size[1]).map(|k| value(k % size[0], k / size[0])));
    fs::write(folder.join(name), bytes).unwrap();
}

/// The largest differences of pixels: of those amid one side and one texture, and of all.
fn differences(scene: &Scene, own: &Raster<f32>, samples: &Raster<f32>) -> [f64; 2] {
    let film = render(&built(scene), &());
    let class = film.class.unwrap();
    let (width, height) = (own.width(), own.height());
    let mut worst = [0.0f64; 2];
    for j in 0..height {
        for i in 0..width {
            let around = (0..9).filter_map(|k| {
                let (x, y) = ((i + k % 3).checked_sub(1)?, (j + k / 3).checked_sub(1)?);
                (x < width && y < height).then(|| class.get(x, y))
            });
            let amid = around.clone().all(|c| c == class.get(i, j)) && class.get(i, j) != Class::PastBoard;
            let off = f64::from((own.get(i, j) - samples.get(i, j)).abs());
            worst = [if amid { worst[0].max(off) } else { worst[0] }, worst[1].max(off)];
        }
    }
    worst
}

/// Smooth textures, whose samples at the middles of 16384 parts have the mean of a pixel to far better than a step of 14 bits,
/// but for the pixels under the ridge: there samples miss a straight line of the whole contrast by half a part along it.
#[test]
fn pictures_of_noise_are_the_means_of_samples_at_every_level() {
    let boards = [
        format!("{BOARD}\ntexture = {{ pattern = \"noise\", finest_mm = 8.0, seed = 5 }}"),
        format!("{BOARD}\ntilt_deg = [9.0, -14.0, 25.0]\ntexture = {{ pattern = \"noise\", finest_mm = 30.0 }}"),
    ];
    for (prism, board) in [(NO_GLASS, &boards[0]), (FLAT, &boards[1]), (FREEFORM, &boards[0])] {
        let scene = textured_over(NARROW_UM, [22, 4], prism, board, "", None);
        let samples = supersampled(&built(&scene), SAMPLES, SamplePlaces::Grid);
        let systems = Level::ALL.map(|level| built(&scene).with_accuracy(level.accuracy()));
        let pictures = systems.each_ref().map(picture);
        let reference = &pictures[Level::Reference as usize];
        for ((level, system), own) in Level::ALL.into_iter().zip(&systems).zip(&pictures) {
            let [amid, all] = differences(&scene, own, &samples);
            assert!(amid < 6e-5 && all < 0.8 / SAMPLES as f64, "{level:?} {prism}: {amid:e} {all:e}");

            // Between levels a pixel changes by what their promises move lines of the whole contrast by.
            let moved = own.data().iter().zip(reference.data()).map(|(a, b)| f64::from((a - b).abs()));
            let most = moved.fold(0.0, f64::max);
            let promise_px = system.accuracy().promise_px.max(1e-6);
            assert!((most - 1e-7) / (0.8 * 2f64.sqrt()) < promise_px, "{level:?} {prism}: {most:e}");
        }
    }
}

/// Charts and pictures of hard edges, whose samples miss each edge in a pixel by half a part along it at most.
#[test]
fn pictures_of_hard_edges_are_the_means_of_samples() {
    let folder = tempfile::tempdir().unwrap();
    pgm(folder.path(), "a.pgm", [19, 7], |i, j| ((i * 37 + j * 91) % 256) as u8);
    let chart = BOARD.replace("41", "7").replace("10.0", "60.0") + "\ntilt_deg = [0.0, 4.0, 3.0]\ntexture = \"chart\"";
    let image = |more: &str| format!("{BOARD}\ntexture = {{ image = \"a.pgm\", width_mm = 300.0{more} }}");
    for (prism, board, edges) in
        [(FREEFORM, chart, 12.0), (FREEFORM, image(""), 3.0), (FLAT, image(", interpolation = \"linear\""), 2.0)]
    {
        let scene = textured([32, 6], prism, &board, "", Some(folder.path()));
        let samples = supersampled(&built(&scene), SAMPLES, SamplePlaces::Grid);
        for level in [Level::Draft, Level::Standard, Level::Exact] {
            let own = picture(&built(&scene).with_accuracy(level.accuracy()));
            let [_, all] = differences(&scene, &own, &samples);
            assert!(all < edges * 0.4 / SAMPLES as f64, "{level:?} {board}: {all:e}");
        }
    }
}

/// A picture that is a checkerboard is rendered as the checkerboard, whose means are known by other formulas, at every level, and
/// with every kind of effect at the standard one. The board that shows it says one square, so that its own squares are none of it.
#[test]
fn a_picture_of_a_checkerboard_is_a_checkerboard() {
    let folder = tempfile::tempdir().unwrap();
    pgm(folder.path(), "squares.pgm", [21, 21], |i, j| if (i + j) % 2 == 0 { 0 } else { 255 });
    let board = |squares: &str| {
        format!("{squares}\nmargin_mm = 20.0\nposition_mm = [0.0, 0.0, 1000.0]\ntilt_deg = [5.0, -7.0, 11.0]")
    };
    let squares = board("columns = 21\nrows = 21\nsquare_mm = 20.0");
    let shown = board("columns = 1\nrows = 1\nsquare_mm = 420.0") + "\ntexture = { image = \"squares.pgm\" }";
    let glass = FREEFORM.replace("1.48", "1.5168\nglass = \"N-BK7\"");
    let effects = [
        ("", 0.0),
        ("[effect.cos4]\n[effect.lamp]\nposition_mm = [100.0, 50.0, 400.0]\n[effect.sensor]\nfill_factor = 0.6", 0.0),
        ("[effect.thin_lens]\nf_number = 4.0\nfocus_mm = 900.0\n[quadrature]\npoints = 8", 0.0),
        ("[effect.dispersion]\nlines_nm = [486.1, 656.3]\nresponse = \"nikon_d5100\"", 0.0),
        // What blocks of one radiance are of the checkerboard is sampled by 8 x 8 rays of a texture, of a hundredth of the light.
        ("[effect.fresnel]\n[effect.ghosts]\nsamples = 8", 2e-3),
        // The promise of diffraction, of the contrast.
        ("[effect.diffraction]\nf_number = 8.0", 1e-3),
        ("[effect.clipping.rim]\ndiameter_mm = 14.0", 0.0),
        ("[effect.roughness]\nfront_slope_deg = 0.05\n[quadrature]\npoints = 8", 0.0),
    ];
    for (effect, more) in effects {
        let [plain, own] = [&squares, &shown]
            .map(|board| textured_over(NARROW_UM, [20, 2], &glass, board, effect, Some(folder.path())));
        for level in Level::ALL {
            if level != Level::Standard && !effect.is_empty() {
                continue;
            }
            let at = |scene: &Scene| render(&built(scene).with_accuracy(level.accuracy()), &());
            let (plain, own) = (at(&plain), at(&own));
            let pairs = plain.radiance.data().iter().zip(own.radiance.data());
            let most = pairs.map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max);
            let allowed = 0.8 * 2f64.sqrt() * 2.0 * level.accuracy().promise_px.max(1e-6) + 1e-6 + more;
            assert!(most < allowed, "{level:?} {effect}: {most:e}");
            assert_eq!(plain.class, own.class, "{level:?} {effect}");
            // f32 of up to 1000 mm.
            let (plain, own) = (plain.board_mm.unwrap(), own.board_mm.unwrap());
            for (a, b) in plain.data().iter().flatten().zip(own.data().iter().flatten()) {
                assert!((a - b).abs() < 1e-4 * a.abs().max(1.0), "{level:?} {effect}: {a} {b}");
            }
        }
    }
}

/// What the scene says of a picture: black is 0, white is 1, its middle is that of the squares, its pixels are square.
#[test]
fn a_picture_lies_where_its_width_says() {
    let folder = tempfile::tempdir().unwrap();
    pgm(folder.path(), "two.pgm", [2, 1], |i, _| [0, 255][i]);
    let board = "columns = 3\nrows = 1\nsquare_mm = 10.0\nmargin_mm = 5.0\nposition_mm = [0.0, 0.0, 1000.0]\nblack = 0.1\n\
                 white = 0.7\nbackground = 0.4\ntexture = { image = \"two.pgm\", width_mm = 100.0 }";
    let system = built(&textured([64, 32], NO_GLASS, board, "", Some(folder.path())));
    let plate = system.plate().unwrap();
    let at = |x: f64, y: f64| plate.at(glam::DVec2::new(x, y));
    let seen = [at(-49.9, 24.9), at(49.9, -24.9), at(52.0, 0.0), at(0.0, 28.0), at(56.0, 0.0), at(0.0, 31.0)];
    assert_eq!(seen, [0.1, 0.7, 0.7, 0.7, 0.4, 0.4]);
}

/// Where corners are looked for, a board without them is refused in one sentence, before anything is written.
#[test]
fn verbs_that_look_for_corners_say_that_there_are_none() {
    let folder = tempfile::tempdir().unwrap();
    let scene = format!(
        "name = \"noise\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = 64\nheight_px = 36\npixel_pitch_um = 165.0\n\
         [prism]\n{FLAT}\n[board]\n{BOARD}\ntexture = \"noise\"\n"
    );
    fs::write(folder.path().join("noise.toml"), scene).unwrap();
    let run = biprism(folder.path(), &["render", "noise.toml", "--out", "noise.png"]);
    assert!(run.status.success(), "{}", text(&run.stderr));
    for verb in [
        &["compare", "noise.toml"][..],
        &["measure", "noise.png", "--scene", "noise.toml"],
        &["corners", "noise.png", "--scene", "noise.toml"],
        &["cost", "noise.toml", "--quick"],
    ] {
        let run = biprism(folder.path(), verb);
        let told = text(&run.stderr);
        assert!(run.status.code() == Some(2) && told.contains("`board.texture` is noise"), "{verb:?}: {told}");
        assert!(told.contains("take `texture` out of `[board]`") && !folder.path().join("out").exists(), "{told}");
    }
    // The picture tells that it is of another board than that of squares.
    let scene = fs::read_to_string(folder.path().join("noise.toml")).unwrap();
    fs::write(folder.path().join("squares.toml"), scene.replace("texture = \"noise\"", "")).unwrap();
    let run = biprism(folder.path(), &["measure", "noise.png", "--scene", "squares.toml", "--own"]);
    assert!(run.status.code() == Some(2) && text(&run.stderr).contains("has another board"), "{}", text(&run.stderr));
    let checked = biprism(folder.path(), &["check", "noise.toml"]);
    assert!(text(&checked.stdout).contains("noise, 410 x 410 mm"), "{}", text(&checked.stdout));
}

/// A picture's file is asked for its size, its form and its light before a scene is accepted.
#[test]
fn pictures_that_cannot_be_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    pgm(folder.path(), "a.pgm", [2, 2], |_, _| 9);
    fs::write(folder.path().join("text.png"), "no picture").unwrap();
    // A header of 65535 x 8192 pixels, above the limit of a texture and beyond the file.
    fs::write(folder.path().join("large.pgm"), "P5\n65535 8192\n255\n").unwrap();
    let refused = |texture: &str| {
        let text = format!(
            "name = \"test\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = 64\nheight_px = 36\npixel_pitch_um = 165.0\n\
             [prism]\n{FLAT}\n[board]\n{BOARD}\ntexture = {texture}\n"
        );
        scene::parse(&text, "test", Some(folder.path())).expect_err(texture).to_string()
    };
    for (texture, rule) in [
        ("{ image = \"none.png\" }", "there is no file"),
        ("{ image = \"text.png\" }", "must be a PNG"),
        ("{ image = \"large.pgm\" }", "65535 x 8192"),
        ("{ image = \"a.pgm\", seed = 3 }", "`board.texture.seed` says nothing of a picture"),
        ("{ pattern = \"chart\", finest_mm = 3.0 }", "`board.texture.finest_mm` says nothing of a chart"),
        ("{ pattern = \"noise\", width_mm = 3.0 }", "`board.texture.width_mm` says nothing of a built-in pattern"),
        ("{ pattern = \"noise\", finest_mm = 0.01 }", "the limit is 33554432"),
        ("{ pattern = \"noise\", image = \"a.pgm\" }", "both `image` and `pattern`"),
        ("{ seed = 1 }", "neither `image` nor `pattern`"),
        ("\"sand\"", "must be \"noise\" or \"chart\""),
        ("{ image = \"a.pgm\", width_mm = 0.0 }", "`board.texture.width_mm` is 0.0"),
    ] {
        let told = refused(texture);
        assert!(told.contains(rule), "{texture}: {told}");
    }
}

/// In a larger picture, which the map stands for, it is that of rays, also where effects weaken the light.
#[test]
fn maps_and_rays_agree() {
    let board = format!("{BOARD}\ntilt_deg = [9.0, -14.0, 25.0]\ntexture = {{ pattern = \"noise\", finest_mm = 3.0 }}");
    let scene = textured([480, 68], FREEFORM, &board, "[effect.cos4]", None);
    let [map, rays] =
        [Level::Standard, Level::Exact].map(|level| render(&built(&scene).with_accuracy(level.accuracy()), &()));
    assert!(map.account.mapped > 0.9 && rays.account.mapped == 0.0, "{}", map.account);
    let pairs = map.radiance.data().iter().zip(rays.radiance.data());
    let most = pairs.map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max);
    assert!(most < 2.0 * 1e-5 * 0.8 * 2f64.sqrt(), "{most:e}");
}
