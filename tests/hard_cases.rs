//! Does each case of the catalogue stay stable, with its error within its bound?

use biprism::analysis::stability::{Case, Outcome, catalogue};
use rayon::prelude::*;
use std::collections::BTreeSet;

fn run(chapters: &[&str]) {
    let cases: Vec<&Case> = catalogue().filter(|case| chapters.contains(&case.group)).collect();
    assert!(!cases.is_empty());
    let ran: Vec<(&Case, Outcome)> = cases.into_par_iter().map(|case| (case, (case.run)())).collect();
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
