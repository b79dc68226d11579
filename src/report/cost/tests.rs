use super::*;
use crate::analysis::cost::{CostStudy, EffectSetting, Measured, Meshed, Setting, Shifts, Spread};
use crate::plot::svg;
use crate::render::Counts;
use crate::report::figures::cost as chart;

fn spread(median: f64) -> Spread {
    Spread { min: 0.9 * median, median, p90: 1.2 * median, n: 5 }
}

fn shifts(max: f64) -> Shifts {
    Shifts { n: 100, rms: 0.3 * max, p99: 0.8 * max, max }
}

fn setting(value: &str, ms: f64, error: f64) -> Setting {
    Setting {
        knob: "samples, grid",
        value: value.to_owned(),
        number: 1.0,
        time_ms: spread(ms),
        yardsticks: spread(ms / 60.0),
        counts: Counts::default(),
        rmse: 0.1 * error,
        lines_px: Some(shifts(error)),
        corners_px: None,
        measured: Measured {
            corners: 3,
            shifts_px: None,
            reprojection_rms_px: Some(0.5),
            vertical_disparity_rms_px: None,
        },
        account: None,
    }
}

fn study() -> CostStudy {
    let reference = crate::render::AccuracyReport {
        level: crate::accuracy::Level::Reference,
        target_px: None,
        promise_px: 0.0,
        map_px: 0.0,
        bend_px: 1e-9,
        patches: 0,
        mapped: 0.0,
        passes: 1,
        noise: None,
        noise_target: None,
        unpromised_pixels: 0,
    };
    let mesh = Meshed {
        triangles: 1000,
        normals: "smooth",
        build_ms: 1.0,
        time_ms: spread(100.0),
        yardsticks: spread(2.0),
        corners_px: Some(shifts(1e-2)),
        reprojection_rms_px: None,
        lost: 0,
    };
    CostStudy {
        yardstick_ns: spread(20.0),
        size_px: [1920, 1080],
        reference,
        corners: 700,
        pictures: vec![
            setting("2 x 2", 4.0, 0.2),
            setting("1 x 1", 1.0, 0.4),
            setting("3 x 3", 9.0, 0.3),
            setting("4 x 4", 16.0, 0.1),
        ],
        meshes: vec![mesh],
        designs: Vec::new(),
        effects: vec![EffectSetting {
            effect: "thin_lens",
            knob: "points",
            value: "32".to_owned(),
            number: 32.0,
            time_ms: spread(250.0),
            yardsticks: spread(5.0),
            rmse: 6e-3,
            lines_px: None,
        }],
    }
}

fn machine() -> Machine {
    Machine { processor: "Testor 1".into(), threads: 2, system: "linux x86_64".into(), vectors: "AVX2" }
}

#[test]
fn the_front_leaves_out_what_is_slower_and_worse() {
    let study = study();
    let names: Vec<&str> = front(&study.pictures).iter().map(|s| s.value.as_str()).collect();
    assert_eq!(names, ["1 x 1", "2 x 2", "4 x 4"]);
}

#[test]
fn every_line_of_the_csv_has_every_column() {
    let text = csv::text(&study());
    let columns = |line: &str| {
        let mut quoted = false;
        let commas = line.chars().filter(|c| {
            quoted ^= *c == '"';
            *c == ',' && !quoted
        });
        commas.count() + 1
    };
    let n = columns(csv::HEADER);
    assert_eq!(text.lines().count(), 7);
    assert!(text.lines().all(|line| columns(line) == n), "{text}");
    assert!(text.contains("picture,\"samples, grid\",2 x 2,1,3.6,4,4.8,5,"), "{text}");
}

#[test]
fn the_json_says_what_it_is_and_what_is_best() {
    let (study, machine) = (study(), machine());
    let value: serde_json::Value =
        serde_json::from_str(&CostReport::new("paper", &machine, &study).to_json()).expect("it is JSON");
    assert_eq!(value["schema"], "biprism-cost/1");
    assert_eq!(value["pictures"][1]["time_ms"]["median"], 1.0);
    assert_eq!(value["pareto_front"][2]["value"], "4 x 4");
    assert_eq!(value["machine"]["processor"], "Testor 1");
}

#[test]
fn table_and_chart_name_the_machine_and_each_setting() {
    let (study, machine) = (study(), machine());
    let table = table::text("paper", &machine, &study);
    let drawing = chart::pictures("paper", &machine, &study);
    let chart = svg::write(&drawing, &chart::title("paper", &study));
    for text in [&table, &chart] {
        for words in ["Testor 1", "1 x 1", "4 x 4", "1920"] {
            assert!(text.contains(words), "{words}: {text}");
        }
    }
    assert!(table.contains("4 x 4*") && !table.contains("3 x 3*"), "{table}");
    assert!(chart.contains("Pareto front") && !chart.contains("triangles"), "lines and corners share no axis: {chart}");
    let effects = svg::write(&chart::effects("paper", &machine, &study), &chart::effect_title("paper"));
    assert!(effects.contains("thin lens, pupil points") && !effects.contains("telecentric"), "{effects}");
    assert!(table.contains("thin_lens, points"), "{table}");
    let meshes = svg::write(&chart::meshes("paper", &machine, &study), &chart::mesh_title("paper"));
    assert!(meshes.contains("10³ triangles") && !meshes.contains("Pareto front"), "{meshes}");
}
