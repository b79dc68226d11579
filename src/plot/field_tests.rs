//! Tests of maps of a field.

use super::*;
use crate::plot::examine;
use crate::plot::svg;

const HALF: Rect = Rect { min: DVec2::ZERO, max: DVec2::new(960.0, 1080.0) };

fn arrows(largest: f64) -> Vec<Arrow> {
    let place = |i: i32, j: i32| DVec2::new(f64::from(i) * 60.0, f64::from(j) * 60.0);
    let error = |p: DVec2| {
        let n = (p - 0.5 * HALF.max) / (0.5 * HALF.max);
        DVec2::new(0.2 * n.x * n.x + 0.8 * n.y * n.y, 0.7 * n.x * n.y) * (largest / 1.22)
    };
    let places = (1..16).flat_map(|i| (1..18).map(move |j| place(i, j)));
    places.map(|at| Arrow { at, error: error(at) }).collect()
}

fn quiver() -> QuiverInput {
    let panel = |name: &str, largest, gain| QuiverPanel { name: name.into(), arrows: arrows(largest), gain };
    QuiverInput {
        title: "Corner errors in the right half image".into(),
        area: HALF,
        unit: "px".into(),
        panels: vec![panel("(a) flat prism", 20.0, 5.0), panel("(b) freeform prism", 0.5, 200.0)],
        width_px: 1600,
    }
}

fn heat(values: &Raster<f64>) -> HeatMapInput<'_> {
    HeatMapInput {
        title: "Vertical disparity over the right half".into(),
        values,
        area: HALF,
        plane: HeatMapPlane::Image,
        axes: ["u, px".into(), "v, px".into()],
        caption: "vertical disparity, px".into(),
        map: Map::Diverging,
        width_px: 1000,
    }
}

#[test]
fn a_realistic_quiver_is_sound() {
    for width_px in [400, 1600, 4000] {
        examine::examine(&format!("quiver_{width_px}"), &draw_quiver(&QuiverInput { width_px, ..quiver() }));
    }
    let one = QuiverInput { panels: quiver().panels[..1].to_vec(), width_px: 900, ..quiver() };
    let drawing = draw_quiver(&one);
    examine::examine("quiver_one", &drawing);
    examine::keep("quiver_one.svg", svg::write(&drawing, &one.title).as_bytes());
}

#[test]
fn arrows_without_a_place_are_counted() {
    let mut input = quiver();
    input.panels.truncate(1);
    let arrow = |x: f64, e: f64| Arrow { at: DVec2::new(x, 5.0), error: DVec2::new(0.0, e) };
    input.panels[0].arrows = vec![arrow(1.0, 3.0), arrow(2.0, f64::NAN), arrow(-1.0, 1.0), arrow(4.0, 4.0)];
    let drawing = draw_quiver(&input);
    // RMS of 3 and 4, by hand: 3.54.
    assert!(examine::says(&drawing, "n = 2, 2 left out, RMS 3.54 px, largest 4.00 px"));
}

#[test]
fn a_realistic_heat_map_is_sound() {
    let value = |i: usize, j: usize| {
        let n = DVec2::new(i as f64 - 23.5, j as f64 - 26.5) / 25.0;
        if (i, j) == (5, 6) { f64::NAN } else { 3.0 * n.x * n.y + 0.4 }
    };
    let values = Raster::from_data(48, 54, (0..54).flat_map(|j| (0..48).map(move |i| value(i, j))).collect());
    let drawing = draw_heat_map(&heat(&values));
    examine::examine("heat_diverging", &drawing);
    assert!(examine::says(&drawing, "1 of 2592 values are no numbers (pale)"));
    let lengths = values.map(|v| v * v);
    let input = HeatMapInput { map: Map::Sequential, caption: "squared, px²".into(), ..heat(&lengths) };
    examine::examine("heat_sequential", &draw_heat_map(&input));
}

/// Of a chart the smallest y is at the bottom, whatever the units are.
#[test]
fn a_chart_of_two_quantities_grows_upwards() {
    let values = Raster::from_data(1, 2, vec![0.0, 1.0]);
    let picture = |plane| {
        let area = Rect { min: DVec2::ZERO, max: DVec2::new(1e-6, 1e6) };
        let drawing = draw_heat_map(&HeatMapInput { plane, area, map: Map::Sequential, ..heat(&values) });
        let found = drawing.items().iter().find_map(|item| match item {
            Item::Picture(place, colours) if colours.height() == 2 => Some((place.size(), colours.get(0, 0))),
            _ => None,
        });
        found.expect("the map is a picture")
    };
    let (size, top) = picture(HeatMapPlane::Chart);
    assert!((size.x / size.y - 1.5).abs() < 0.02, "{size}");
    assert_eq!(top, Map::Sequential.colour(1.0));
    assert_eq!(picture(HeatMapPlane::Image).1, Map::Sequential.colour(0.0));
}

#[test]
fn zero_is_white_in_a_diverging_map() {
    let values = Raster::from_data(3, 1, vec![0.0, -1.0, 7.0]);
    let drawing = draw_heat_map(&heat(&values));
    let Some(Item::Picture(_, colours)) = drawing.items().iter().find(|item| matches!(item, Item::Picture(..))) else {
        panic!("a heat map is a picture")
    };
    assert_eq!(colours.get(0, 0), [247, 247, 247]);
    assert!(colours.get(1, 0)[2] > colours.get(1, 0)[0] && colours.get(2, 0)[0] > colours.get(2, 0)[2]);
}

#[test]
fn empty_and_hostile_input_gives_a_labelled_figure() {
    let long = "words without any end ".repeat(40);
    let areas = [
        HALF,
        Rect { min: DVec2::NAN, max: DVec2::ONE },
        Rect { min: DVec2::ZERO, max: DVec2::new(1e-6, 1e6) },
        Rect { min: DVec2::ZERO, max: DVec2::new(1e6, 1e-3) },
        Rect { min: DVec2::splat(1e9), max: DVec2::splat(1e9 + 1.0) },
    ];
    for (k, area) in areas.into_iter().enumerate() {
        for panels in [0, 1, 9] {
            let far = Arrow { at: area.min, error: DVec2::splat(1e200) };
            let panel = QuiverPanel { name: long.clone(), arrows: vec![far; panels], gain: 1e200 };
            let drawing = draw_quiver(&QuiverInput {
                title: long.clone(),
                area,
                unit: if k == 0 { "px".into() } else { long.clone() },
                panels: vec![panel; panels],
                width_px: 0,
            });
            examine::examine(&format!("quiver_hostile_{k}_{panels}"), &drawing);
        }
        for values in [Raster::filled(0, 0, 0.0), Raster::filled(3, 2, f64::NAN), Raster::filled(5000, 2, 1e308)] {
            let input = HeatMapInput { area, title: long.clone(), caption: long.clone(), ..heat(&values) };
            examine::examine(&format!("heat_hostile_{k}_{}", values.width()), &draw_heat_map(&input));
        }
    }
    assert!(examine::says(&draw_heat_map(&heat(&Raster::filled(0, 0, 0.0))), "no data"));
}
