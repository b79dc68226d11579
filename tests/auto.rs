//! Is what the program says of an effect a bound, and does it leave out what it may?

use crate::instruments::{BOARD, FLAT, FREEFORM, built, picture};
use biprism::accuracy::{Accuracy, Level};
use biprism::effect::Threshold;
use biprism::raster::Raster;
use biprism::scene::{self, Scene};
use biprism::system::auto::verdicts;
use biprism::system::{self, Bound};

/// Effects in words of a scene, strong and weak, each with what it stands on.
const EFFECTS: [(&str, &str); 25] = [
    ("thin_lens", "[effect.thin_lens]\nf_number = 4.0\nfocus_mm = 900.0\n[quadrature]\npoints = 8"),
    ("thin_lens", "[effect.thin_lens]\nf_number = 900.0\nfocus_mm = 990.0\n[quadrature]\npoints = 8"),
    (
        "thin_lens",
        "[effect.thin_lens]\nf_number = 400.0\nfocus_mm = 700.0\nblades = 5\n[quadrature]\nreplicates = 4\npoints = 4",
    ),
    ("cos4", "[effect.cos4]"),
    ("cos4", "[effect.cos4]\nexponent = 0.01"),
    ("lamp", "[effect.lamp]\nposition_mm = [-300.0, 100.0, 300.0]"),
    ("lamp", "[effect.lamp]\nposition_mm = [-300.0, 100.0, 300.0]\nshare = 0.001"),
    ("fresnel", "[effect.fresnel]"),
    ("coating", "[effect.fresnel]\n[effect.coating]\nindex = 1.38\nthickness_nm = 5.0"),
    ("coating", "[effect.fresnel]\n[effect.coating]\nindex = 1.38\nthickness_nm = 100.0"),
    ("absorption", "[effect.absorption]\nper_mm = 1e-5"),
    ("absorption", "[effect.absorption]\nper_mm = 0.01"),
    ("ghosts", "[effect.fresnel]\n[effect.ghosts]\nbehind = 0.5"),
    ("dispersion", "[effect.dispersion]\nlines_nm = [580.0, 595.0]"),
    ("manufacture", "[effect.manufacture]\ndecentre_mm = [0.01, 0.0, 0.02]"),
    ("manufacture", "[effect.manufacture]\nindex = 1e-4\n[effect.manufacture.back]\ntilt_deg = [0.002, 0.003, 0.0]"),
    ("roughness", "[effect.roughness]\nback_slope_deg = 0.001\n[quadrature]\npoints = 8"),
    ("roughness", "[effect.roughness]\nfront_slope_deg = 0.01\nback_slope_deg = 0.02\n[quadrature]\npoints = 8"),
    ("clipping", "[effect.clipping]\nchamfer_mm = 0.005"),
    ("clipping", "[effect.clipping]\nchamfer_mm = 0.2"),
    ("clipping", "[effect.clipping]\nstop = { at_mm = 30.0, diameter_mm = 12.0 }"),
    ("diffraction", "[effect.diffraction]\nf_number = 0.05"),
    ("diffraction", "[effect.diffraction]\nf_number = 8.0"),
    ("diffraction", "[effect.diffraction]\nf_number = 90.0"),
    // The lamp makes the board brighter, and not what lies behind the camera.
    ("ghosts", "[effect.fresnel]\n[effect.ghosts]\nbehind = 20.0\n[effect.lamp]\nposition_mm = [60.0, 0.0, 900.0]"),
];

fn parsed(prism: &str, board: &str, effect: &str) -> Scene {
    let text = format!(
        "name = \"t\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = 96\nheight_px = 54\npixel_pitch_um = 110.0\n\
         [prism]\n{prism}\nglass = \"N-BK7\"\n[board]\n{board}\n{effect}\n"
    );
    scene::parse(&text, "test", None).unwrap_or_else(|problem| panic!("{problem}\n{text}"))
}

/// Pixels within this of the truth, in px: what is told apart here is larger.
const BEND_PX: f64 = 1e-4;

/// Scenes with the ridge in the middle and beside it, with large and with small squares.
fn scenes(effect: &str) -> Vec<Scene> {
    let fine =
        "columns = 101\nrows = 101\nsquare_mm = 4.0\nposition_mm = [3.0, 2.0, 1000.0]\ntilt_deg = [5.0, 8.0, 7.0]";
    let accuracy = Accuracy { bend_px: BEND_PX, ..Level::Exact.accuracy() };
    let beside = format!("{FLAT}\nposition_mm = [1.0, 0.0, 0.0]");
    [(&*beside, BOARD), (FREEFORM, BOARD), (FLAT, fine)]
        .map(|(prism, board)| Scene { accuracy, ..parsed(prism, board, effect) })
        .to_vec()
}

fn change(a: &Raster<f32>, b: &Raster<f32>) -> f64 {
    a.data().iter().zip(b.data()).fold(0.0, |worst: f64, (a, b)| worst.max(f64::from((a - b).abs())))
}

fn bound_of(scene: &Scene, key: &str) -> Option<Bound> {
    let ideal = system::ideal(scene).unwrap_or_else(|problem| panic!("{problem}"));
    verdicts(&ideal, scene)
        .iter()
        .find(|verdict| verdict.effect.key() == key)
        .unwrap_or_else(|| panic!("{key} does not act"))
        .bound
}

/// Pictures with and without each effect differ by no more than its bound.
#[test]
fn no_pixel_changes_by_more_than_its_bound() {
    let mut close = 0;
    for (key, effect) in EFFECTS {
        for (k, scene) in scenes(effect).iter().enumerate() {
            let Some(bound) = bound_of(scene, key) else {
                // What is told by rays that end in the glass, or by a stop that is in the picture.
                assert!(key != "cos4" && key != "diffraction", "{key} {k} has no bound");
                continue;
            };
            let without = Scene { effects: scene.effects.only(|row| row.key() != key), ..scene.clone() };
            let found = change(&picture(&built(scene)), &picture(&built(&without)));
            println!("{key:12} scene {k}: {found:.2e} of at most {:.2e}", bound.grey);
            // Each of the two pictures keeps to its bend on four lines and the ridge through a pixel, of contrast 0.9.
            let told = 2.0 * 0.9 * 5.0 * std::f64::consts::SQRT_2 * BEND_PX;
            assert!(found <= bound.grey + told, "{effect} in scene {k}: {found} above {}", bound.grey);
            close += usize::from(bound.grey < 4.0 * found);
        }
    }
    // A bound that is always 1 would say nothing.
    assert!(close > 15, "{close}");
}

/// Where the edges of a row are: two pixels hold the edge, and their sum is that of the sides next to them, each up to it.
fn edges(picture: &Raster<f32>, row: usize) -> Vec<f64> {
    let values: Vec<f64> = picture.row(row).iter().map(|v| f64::from(*v)).collect();
    let mut found = Vec::new();
    for i in 1..values.len() - 2 {
        let (left, right) = (values[i - 1], values[i + 2]);
        let middle = 0.5 * (left + right);
        if (left - right).abs() > 0.3 && (values[i] < middle) != (values[i + 1] < middle) {
            let (from, to) = (i as f64, i as f64 + 2.0);
            found.push((right * to - left * from - (values[i] + values[i + 1])) / (right - left));
        }
    }
    found
}

/// Edges far from corners move by no more than is said: those of large squares, against the picture without the effect.
#[test]
fn no_edge_moves_farther_than_its_bound() {
    // Two squares: one upright edge in each half, away from the ridge.
    let board = "columns = 2\nrows = 1\nsquare_mm = 400.0\nposition_mm = [60.0, 0.0, 1000.0]\nmargin_mm = 0";
    let (mut moved, mut told) = (0, 0);
    let factors = ["cos4", "lamp", "absorption", "coating"];
    let displacements = ["manufacture", "dispersion", "thin_lens", "roughness"];
    for (key, effect) in EFFECTS.iter().filter(|(key, _)| factors.contains(key) || displacements.contains(key)) {
        let scene = parsed(FLAT, board, effect);
        let bound = bound_of(&scene, key).expect("it is told by rays that pass");
        // The sides are half a pixel from the edge at least: what is blurred farther has none.
        if bound.px > 0.4 {
            continue;
        }
        let without = Scene { effects: scene.effects.only(|row| row.key() != *key), ..scene.clone() };
        let [with, without] = [&scene, &without].map(|scene| picture(&built(scene)));
        // Where light grows by a share q a pixel on either side, white by b and black by a px, sums and sides together move
        // the edge by q (white b (b + 1) + black a (a + 1)) / (2 contrast); b is 1.5 at most, a then 0.5. The bound is of q
        // times mean over contrast.
        let (black, white) = (scene.board.black, scene.board.white);
        let light = (white * 1.5 * 2.5 + black * 0.5 * 1.5) / (black + white);
        let times = if factors.contains(key) { light } else { 1.0 };
        for row in [5, 27, 48] {
            // Near the ridge the two halves mix.
            let clear = |picture: &Raster<f32>| {
                let all = edges(picture, row);
                all.into_iter().filter(|x| (x - 47.5).abs() > 8.0).collect::<Vec<_>>()
            };
            let (a, b) = (clear(&with), clear(&without));
            assert!(a.len() == b.len() && !a.is_empty(), "{effect}: {a:?} {b:?}");
            for (a, b) in a.iter().zip(&b) {
                // Each picture keeps to its promise, and sums of f32 tell a place to 1e-6 px.
                let off = 2.0 * scene.accuracy.promise_px + 1e-6;
                assert!((a - b).abs() <= times * bound.px + off, "{effect} {row}: {a} {b} {}", bound.px);
                moved += usize::from((a - b).abs() > 1e-4);
                told += 1;
            }
        }
    }
    assert!(moved > 5 && told > 40, "{moved} of {told}");
}

#[test]
fn what_changes_too_little_is_left_out_and_the_rest_is_kept() {
    let lens = "[effect.thin_lens]\nf_number = 9000.0\nfocus_mm = 990.0";
    let all = format!("{lens}\n{}\n{}", EFFECTS[3].1, EFFECTS[6].1);
    let scene = parsed(FLAT, BOARD, &all);
    let acting = |auto: Option<Threshold>| {
        let mut scene = scene.clone();
        scene.effects.auto = auto;
        built(&scene).effects().acting().map(|row| row.key()).collect::<Vec<_>>()
    };
    let threshold = |grey: f64, px: f64| Some(Threshold { grey: Some(grey), px: Some(px) });
    assert_eq!(acting(None), ["lamp", "thin_lens", "cos4"]);
    // The lens of 0.002 mm moves the ridge, 78 mm away, by 0.002 of its 0.25 mm per px, and the board by less; cos^4 takes 4 %.
    assert_eq!(acting(threshold(0.02, 0.05)), ["cos4"]);
    assert_eq!(acting(threshold(0.0, 0.0)), ["lamp", "thin_lens", "cos4"]);
    assert!(acting(threshold(1.0, 1.0)).is_empty());
    let grey = Some(Threshold { grey: Some(0.02), px: None });
    assert_eq!(acting(grey), ["cos4"]);
    // Together they must not change more than may be.
    let bounds: Vec<Bound> = ["lamp", "thin_lens"].iter().filter_map(|key| bound_of(&scene, key)).collect();
    let larger = bounds[0].grey.max(bounds[1].grey);
    let both = Some(Threshold { grey: Some(larger * 1.0001), px: None });
    assert_eq!(acting(both).len(), 2);
    let full = picture(&built(&scene));
    let mut lighter = scene.clone();
    lighter.effects.auto = grey;
    assert!(change(&full, &picture(&built(&lighter))) <= 0.02 + 2e-5);
    // Where reflection is dropped, nothing that stands on it is left.
    let reflecting = parsed(FLAT, BOARD, EFFECTS[12].1);
    for grey in [1e-6, 0.01, 0.1, 1.0] {
        let mut scene = reflecting.clone();
        scene.effects.auto = Some(Threshold { grey: Some(grey), px: None });
        let system = built(&scene);
        let effects = system.effects();
        assert!(effects.fresnel.is_some() || effects.ghosts.is_none(), "{grey}");
    }
}

/// Reflection goes with the ghosts that stand on it, and stays with them, however weak it is.
#[test]
fn reflection_is_judged_after_what_stands_on_it() {
    let kept = |ghosts: &str, grey: f64| {
        let mut scene = parsed(FLAT, BOARD, &format!("[effect.fresnel]\n[effect.ghosts]\n{ghosts}"));
        scene.effects.auto = Some(Threshold { grey: Some(grey), px: None });
        let ideal = system::ideal(&scene).unwrap();
        let told = verdicts(&ideal, &scene);
        let of = |key: &str| *told.iter().find(|verdict| verdict.effect.key() == key).unwrap();
        (of("fresnel"), of("ghosts"))
    };
    let (fresnel, ghosts) = kept("", 0.9);
    assert!(!fresnel.kept && !ghosts.kept, "{fresnel:?} {ghosts:?}");
    // A bright light behind the camera, of which the base alone reflects 4 % back.
    let (fresnel, ghosts) = kept("behind = 1e3", 0.9);
    assert!(fresnel.bound.unwrap().grey < 0.9 && ghosts.kept && fresnel.kept, "{fresnel:?} {ghosts:?}");
    assert_eq!(fresnel.why, "another effect that is kept stands on it");
    // Ghosts, which cross a surface more often than the light that is missing behind it, are a little weaker: they go alone.
    let (fresnel, ghosts) = kept("", 0.9);
    let between = 0.5 * (fresnel.bound.unwrap().grey + ghosts.bound.unwrap().grey);
    let (fresnel, ghosts) = kept("", between);
    assert!(fresnel.kept && !ghosts.kept, "{fresnel:?} {ghosts:?}");
}

/// The threshold of a scene file, and the sizes that it must have.
#[test]
fn a_scene_says_what_may_be_left_out() {
    let text = |effects: &str| {
        format!(
            "name = \"t\"\neffects = {effects}\n[camera]\nfocal_length_mm = 35\nwidth_px = 64\nheight_px = 36\n\
             pixel_pitch_um = 165\n[prism]\nkind = \"none\"\n[board]\n{BOARD}\n[effect.cos4]\n"
        )
    };
    let auto = |effects: &str| scene::parse(&text(effects), "test", None).map(|scene| scene.effects.auto);
    assert_eq!(auto("\"auto\"").ok(), Some(Some(Threshold::default())));
    let some = Threshold { grey: Some(0.002), px: Some(0.01) };
    assert_eq!(auto("{ auto = { grey = 0.002, px = 0.01 } }").ok(), Some(Some(some)));
    assert_eq!(auto("{ auto = { px = 0.5 } }").ok(), Some(Some(Threshold { grey: None, px: Some(0.5) })));
    assert_eq!(auto("\"all\"").ok(), Some(None));
    assert!(auto("{ auto = {} }").is_err() && auto("{ auto = { grey = -1.0 } }").is_err());
}
