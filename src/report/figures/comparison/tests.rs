use super::*;
use crate::plot::examine;
use crate::raster::Raster;
use crate::report::figures::samples;

fn rows() -> Vec<FigureRow> {
    let row = |label: &str, a: &str, b: &str| FigureRow { label: label.into(), values: vec![a.into(), b.into()] };
    vec![
        row("vertical disparity, RMS, px", "16.93", "0.204"),
        row("vertical disparity, largest, px", "38.51", "0.512"),
        row("epipolar slope, largest, mrad", "21.7", "0.31"),
        row("pinhole deviation, horizontal, mean, mm", "0.0604", "0.0034"),
        row("pinhole deviation, vertical, mean, mm", "0.0936", "0.0009"),
        row("straightness of rows and columns, RMS, px", "4.81", "0.12"),
        row("corners found / visible", "510 / 510", "510 / 510"),
    ]
}

const VERDICT: &str = "The freeform prism keeps both halves within 0.51 px of a pinhole camera; the flat prism bends \
    lines by up to 15 px. Only the freeform pair can go into a stereo matcher as it is.";

fn example(then: impl Fn(&ComparisonInput)) {
    let (flat, freeform) = (samples::board(20.0), samples::board(0.5));
    let panels = [
        Panel { name: "flat prism".into(), picture: &flat.0, corners: &flat.1, seam_px: 960.0, found: 0 },
        Panel { name: "freeform prism".into(), picture: &freeform.0, corners: &freeform.1, seam_px: 960.0, found: 0 },
    ];
    then(&ComparisonInput {
        title: "One checkerboard through two prisms: 1 m away, squares of 10 mm".into(),
        arrow_gain: suitable_gain(&panels),
        panels: panels.to_vec(),
        figures: rows(),
        verdict: VERDICT.into(),
        width_px: 2000,
    });
}

#[test]
fn a_realistic_comparison_is_sound_at_any_width() {
    example(|input| {
        for width_px in [800, 2000, 2401] {
            let drawing = draw(&ComparisonInput { width_px, ..input.clone() });
            examine::examine(&format!("comparison_{width_px}"), &drawing);
            // The halves of the sample are mirror images: every corner is as high in both.
            for words in ["(a) 0 px of vertical disparity", "left half"] {
                assert!(examine::says(&drawing, words), "{words}");
            }
        }
    });
}

#[test]
fn hostile_input_gives_a_sound_figure() {
    let long = "A very long sentence that has no end and goes on – with letters such as 稜鏡 and ß – ".repeat(30);
    let bad = |x: f64, e: f64| CornerMark { index: [0, 0], position_px: DVec2::splat(x), error_px: DVec2::splat(e) };
    let corners = [bad(f64::NAN, 1.0), bad(5.0, f64::INFINITY), bad(1e9, 3.0), bad(7.0, 1e200), bad(3.0, -0.0)];
    let pictures = [(0, 0), (1, 1), (3, 4000), (4000, 3), (1920, 1080)].map(|(w, h)| Raster::filled(w, h, f32::NAN));
    for (k, picture) in pictures.iter().enumerate() {
        let seam_px = [f64::NAN, 960.0, -5.0, f64::INFINITY, 1e12][k];
        let panel = |corners| Panel { name: long.clone(), picture, corners, seam_px, found: 0 };
        let drawing = draw(&ComparisonInput {
            title: long.clone(),
            panels: [vec![panel(&corners), panel(&[])], vec![panel(&corners); k]].concat(),
            arrow_gain: [f64::NAN, 0.0, -3.0, f64::INFINITY, 1e300][k],
            figures: vec![FigureRow { label: long.clone(), values: vec![long.clone(); 2 + k] }; 40],
            verdict: long.clone(),
            width_px: 1000,
        });
        examine::examine(&format!("comparison_hostile_{k}"), &drawing);
    }
}

/// One prism, and more than stand in a row: each has its panel, its letter and its column of figures.
#[test]
fn any_number_of_prisms_is_drawn() {
    let (picture, corners) = samples::board(20.0);
    for count in [1, 3, 8] {
        let name = |k: usize| format!("prism {k}");
        let panels: Vec<Panel> = (0..count)
            .map(|k| Panel { name: name(k), picture: &picture, corners: &corners, seam_px: 960.0, found: 0 })
            .collect();
        let values = (0..count).map(|k| format!("{k}.5")).collect();
        let drawing = draw(&ComparisonInput {
            title: "Prisms".into(),
            arrow_gain: suitable_gain(&panels),
            panels,
            figures: vec![FigureRow { label: "vertical disparity, RMS, px".into(), values }],
            verdict: VERDICT.into(),
            width_px: 2000,
        });
        examine::examine(&format!("comparison_of_{count}"), &drawing);
        for k in 0..count {
            let letter = ["a", "b", "c", "d", "e", "f", "g", "h"][k];
            assert!(examine::says(&drawing, &format!("({letter}) {}", name(k))), "{count} {k}");
            assert!(examine::says(&drawing, &format!("{k}.5")), "{count} {k}");
        }
    }
}

#[test]
fn an_empty_comparison_is_still_labelled() {
    let picture = Raster::filled(1920, 1080, 0.5);
    let panel = |name: &str| Panel { name: name.into(), picture: &picture, corners: &[], seam_px: 960.0, found: 0 };
    let panels = [panel("flat"), panel("freeform")];
    assert_eq!(suitable_gain(&panels), 1.0);
    let drawing = draw(&ComparisonInput {
        title: "Nothing yet".into(),
        panels: panels.to_vec(),
        arrow_gain: 1.0,
        figures: Vec::new(),
        verdict: String::new(),
        width_px: 1600,
    });
    examine::examine("comparison_empty", &drawing);
    for words in ["(a) flat", "(b) freeform", "no corners detected"] {
        assert!(examine::says(&drawing, words), "{words}");
    }
    assert!(!examine::says(&drawing, "length of the corner error"), "there is no length");
}

#[test]
fn corners_without_a_number_are_counted_and_the_others_drawn() {
    let picture = Raster::filled(100, 50, 0.5);
    let mark = |x: f64, e: f64| CornerMark { index: [0, 0], position_px: DVec2::splat(x), error_px: DVec2::splat(e) };
    let corners = [mark(10.0, 3.0), mark(20.0, f64::NAN), mark(f64::NAN, 1.0), mark(30.0, 4.0)];
    let panel = Panel { name: "flat".into(), picture: &picture, corners: &corners, seam_px: 50.0, found: 0 };
    let drawing = draw(&ComparisonInput {
        title: String::new(),
        panels: vec![panel.clone(), panel],
        arrow_gain: 1.0,
        figures: Vec::new(),
        verdict: String::new(),
        width_px: 1600,
    });
    // RMS of 3 and 4 times the root of 2, by hand: 5.
    assert!(examine::says(&drawing, "2 corners (+ 2 without a number), error RMS 5.00 px, largest 5.66 px"));
}

#[test]
fn the_gain_makes_the_longer_arrows_no_longer_than_about_a_square() {
    let mark = |i: i32, e: f64| CornerMark {
        index: [i, 0],
        position_px: DVec2::new(60.0 * f64::from(i), 10.0),
        error_px: DVec2::new(0.0, e),
    };
    let picture = Raster::filled(1, 1, 0.0);
    for (error, gain) in [(11.0, 5.0), (0.05, 1000.0), (30.0, 2.0), (500.0, 1.0), (0.0, 1.0)] {
        let corners: Vec<CornerMark> = (0..9).map(|i| mark(i, error)).collect();
        let panel = Panel { name: String::new(), picture: &picture, corners: &corners, seam_px: 1e9, found: 0 };
        assert_eq!(suitable_gain(&[panel.clone(), panel]), gain, "{error}");
    }
}
