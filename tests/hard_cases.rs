//! Does each case of the catalogue stay stable, with its error within its bound?

use biprism::analysis::stability::{Case, CaseOutcome, catalogue};
use biprism::optics::fate::Fate;
use biprism::{scene, system};
use glam::DVec2;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// What a case may err by besides its own bound, which tells what no one may go beyond: in its own unit, by the float format
/// or the method.
const ROUNDING: [(&str, f64, &str); 7] = [
    ("edge-on board", TRACE_PX, "a whole trace's rounding"),
    ("on the ridge to the last bit", 32.0 * 2.9e-14, "32 roundings of board positions of up to 256 mm"),
    ("fold-over of the map", 4.0 * TRACE_PX, "four traces' rounding"),
    ("degree 15", TRACE_PX, "a whole trace's rounding"),
    ("everything moved by 1e6 mm", 16.0 * 1.2e-10 / 0.157, "16 roundings of 1e6 mm, seen at 0.157 mm a pixel"),
    ("coverage of the standard level", 5e-6, "the bend that the level leaves inside a pixel"),
    (
        "no surface to be had",
        1.6e-6,
        "one Runge-Kutta step over the field: its tangent of 0.075 to the fifth, over 5!, of 80 mm",
    ),
];

/// 16 roundings of numbers of order 1, weighed by the focal length in px: a whole trace.
const TRACE_PX: f64 = 16.0 * f64::EPSILON * 35.0 / 0.0055;

fn run(chapters: &[&str]) {
    let cases: Vec<&Case> = catalogue().filter(|case| chapters.contains(&case.group)).collect();
    assert!(!cases.is_empty());
    let ran: Vec<(&Case, CaseOutcome)> = cases.into_par_iter().map(|case| (case, (case.run)())).collect();
    for (case, outcome) in ran {
        assert!(
            case.holds(&outcome),
            "{}: {}\n{}\nworst {:e} {} at {} (bound {:e}: {})\nbroken: {:#?}",
            case.group,
            case.name,
            case.hard,
            outcome.worst,
            case.unit.name(),
            outcome.worst_at,
            case.bound,
            case.why,
            outcome.broken
        );
        if let Some((_, bound, why)) = ROUNDING.iter().find(|(name, ..)| *name == case.name) {
            assert!(outcome.worst <= *bound, "{}: {:e} above {bound:e}: {why}", case.name, outcome.worst);
        }
    }
}

#[test]
fn every_second_bound_belongs_to_a_case_and_is_below_its_first() {
    for (name, bound, _) in ROUNDING {
        assert!(catalogue().any(|case| case.name == name && bound < 0.3 * case.bound), "{name}");
    }
}

#[test]
fn total_reflection_and_grazing() {
    run(&["total reflection", "grazing"]);
}

#[test]
fn ridge() {
    run(&["ridge"]);
}

#[test]
fn vanishing_optics() {
    run(&["vanishing optics"]);
}

#[test]
fn freeform_and_solver() {
    run(&["freeform", "solver"]);
}

#[test]
fn scale_and_place() {
    run(&["scale and place"]);
}

#[test]
fn sampling() {
    run(&["sampling"]);
}

#[test]
fn marching() {
    run(&["marching"]);
}

/// At most one ray in a million is given up in any shipped scene, and none in the paper's.
#[test]
fn no_shipped_scene_goes_beyond_its_budget() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let scenes = ["scenes", "scenes/cases"].iter().flat_map(|folder| {
        fs::read_dir(root.join(folder)).expect("it is committed").map(|entry| entry.expect("it can be listed").path())
    });
    let mut scenes: Vec<_> = scenes.filter(|path| path.extension().is_some_and(|e| e == "toml")).collect();
    scenes.sort();
    assert!(scenes.len() > 10, "{scenes:?}");
    for path in scenes {
        let scene = scene::load(&path).unwrap_or_else(|problem| panic!("{problem}"));
        let system = system::build(&scene).unwrap_or_else(|problem| panic!("{problem}"));
        let [width, height] = [scene.camera.width_px, scene.camera.height_px];
        let given_up = |j: usize| {
            let sights = (0..width).map(|i| system.trace(DVec2::new(i as f64 + 0.5, j as f64 + 0.5)));
            sights.filter(|sight| matches!(sight, Err(Fate::NotConverged))).count()
        };
        let given_up: usize = (0..height).into_par_iter().map(given_up).sum();
        let budget = if path.ends_with("paper.toml") { 0.0 } else { 1e-6 * (width * height) as f64 };
        assert!(given_up as f64 <= budget, "{}: {given_up} of {} rays", path.display(), width * height);
    }
}

#[test]
fn every_case_has_its_own_name_and_a_chapter_that_is_tested() {
    let names: BTreeSet<&str> = catalogue().map(|case| case.name).collect();
    assert_eq!(names.len(), catalogue().count());
    let chapters: BTreeSet<&str> = catalogue().map(|case| case.group).collect();
    let tested = [
        "freeform",
        "grazing",
        "marching",
        "ridge",
        "sampling",
        "scale and place",
        "solver",
        "total reflection",
        "vanishing optics",
    ];
    assert!(chapters.iter().eq(tested.iter()), "{chapters:?}");
}

/// A catalogue that cannot fail says nothing.
#[test]
fn an_error_that_is_no_number_or_above_the_bound_breaks_a_case() {
    use biprism::analysis::stability::Tally;
    let case = catalogue().next().expect("there is a first case");
    let with = |error: f64| {
        let mut tally = Tally::default();
        tally.error(|| "here".to_owned(), error);
        case.holds(&tally.done())
    };
    assert!(with(0.5 * case.bound) && !with(2.0 * case.bound) && !with(f64::NAN) && !with(f64::INFINITY));
    assert!(!case.holds(&Tally::default().done()), "nothing checked is nothing kept");
}
