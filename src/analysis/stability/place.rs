//! Scale and place: the same instrument, tiny, huge, or far from the origin.

use super::case::{Case, ErrorUnit};
use super::scenes::{BOARD, FLAT, FULL, TRACE_PX, built, in_px, places};
use super::tables::PRISM;
use super::tally::{CaseOutcome, Tally};
use crate::num::poly2::Poly2;
use crate::scene::{PolynomialPatch, PrismSpec, Scene};
use crate::system::System;
use crate::system::aim::Aimer;
use crate::{scene, system};
use glam::{DVec2, DVec3};

pub(super) const CASES: &[Case] = &[
    Case {
        group: "scale and place",
        name: "the whole scene scaled by 1e-6 ... 1e6",
        hard: "lengths of 8e-5 ... 8e7 mm against residuals in mm; the camera's f and pitch with them",
        property: "board positions, scaled back, are those of the scene at its own size",
        unit: ErrorUnit::Px,
        bound: 4.0 * TRACE_PX,
        why: "two whole traces, on surfaces whose coefficients are rounded anew",
        run: scaled,
    },
    Case {
        group: "scale and place",
        name: "everything moved by 1e6 mm",
        hard: "positions of a kilometre, rounded to 1.2e-10 mm each, flat and polynomial",
        property: "board positions are those of the scene at the origin",
        unit: ErrorUnit::Px,
        bound: 2e-7,
        why: "a prism 80 mm away that is off by 1.2e-10 mm turns a direction by 1.5e-12, 1e-8 px, once at each of some \
              ten steps",
        run: moved,
    },
    Case {
        group: "scale and place",
        name: "aiming from the base to 1e12 mm",
        hard: "boards 1e-10 mm behind the glass, at 1e9 and at 1e12 mm; squares from 1e-9 mm to 1e9 mm",
        property: "aiming undoes looking",
        unit: ErrorUnit::Px,
        bound: 4.0 * TRACE_PX,
        why: "rounding of a trace there and of one back",
        run: near_and_far,
    },
];

/// The scene with every length times `factor`. The board and the flat prism are exact multiples where the factor is a
/// power of two; elsewhere they are rounded once.
fn times(scene: &Scene, factor: f64) -> Scene {
    let mut s = scene.clone();
    s.camera.position_mm *= factor;
    s.camera.focal_length_mm *= factor;
    s.camera.pitch_mm *= factor;
    s.board.square_mm *= factor;
    s.board.margin_mm *= factor;
    s.board.world_from_board.translation_mm *= factor;
    let patch = |p: &PolynomialPatch| PolynomialPatch {
        sag: Poly2::new(
            p.sag.degree(),
            p.sag.centre().map(|c| c * factor),
            p.sag.scale().map(|c| c * factor),
            |m, n| p.sag.terms().find(|t| (t.0, t.1) == (m, n)).map_or(0.0, |t| t.2 * factor),
        ),
        domain: crate::geom::Rect { min: p.domain.min * factor, max: p.domain.max * factor },
    };
    match &mut s.prism {
        PrismSpec::Flat(flat) => {
            flat.ridge_distance_mm *= factor;
            flat.thickness_mm *= factor;
        }
        PrismSpec::Polynomial(p) => {
            p.front = patch(&p.front);
            p.back = patch(&p.back);
        }
        _ => panic!("the cases scale flat and polynomial prisms"),
    }
    s
}

fn system(scene: &Scene) -> System {
    system::build(scene).unwrap_or_else(|problem| panic!("{problem}"))
}

fn scaled() -> CaseOutcome {
    let mut tally = Tally::default();
    for prism in [FLAT, PRISM] {
        let scene = super::scenes::scene(FULL, "", prism, BOARD);
        let own = system(&scene);
        for exponent in -6..=6 {
            let factor = libm::exp10(f64::from(exponent));
            let other = system(&times(&scene, factor));
            for px in places(FULL, 300) {
                let end = other.trace(px);
                tally.ended(&end);
                match (own.trace(px), end) {
                    (Ok(a), Ok(b)) => {
                        tally.error(
                            || format!("{px}, factor {factor:e}"),
                            in_px(&own, px, b.board_mm / factor - a.board_mm),
                        );
                    }
                    (a, b) => tally.require(false, || format!("{px}, factor {factor:e}: {a:?} {b:?}")),
                }
            }
        }
    }
    tally.done()
}

fn moved() -> CaseOutcome {
    let mut tally = Tally::default();
    for prism in [FLAT, PRISM] {
        let scene = super::scenes::scene(FULL, "", prism, BOARD);
        let own = system(&scene);
        for by in [DVec3::splat(1e6), DVec3::new(-1e6, 1e6, 1e6), DVec3::new(1e6, 0.0, -1e6)] {
            let mut there = scene.clone();
            there.camera.position_mm += by;
            there.board.world_from_board.translation_mm += by;
            match &mut there.prism {
                PrismSpec::Flat(flat) => flat.body.world_from_prism.translation_mm += by,
                PrismSpec::Polynomial(p) => p.body.world_from_prism.translation_mm += by,
                _ => panic!("the cases move flat and polynomial prisms"),
            }
            let other = system(&there);
            for px in places(FULL, 500) {
                let end = other.trace(px);
                tally.ended(&end);
                match (own.trace(px), end) {
                    (Ok(a), Ok(b)) => tally.error(|| format!("{px}, {by}"), in_px(&own, px, b.board_mm - a.board_mm)),
                    (a, b) => tally.require(false, || format!("{px}, {by}: {a:?} {b:?}")),
                }
            }
        }
    }
    tally.done()
}

fn near_and_far() -> CaseOutcome {
    let mut tally = Tally::default();
    for (z, square) in [(87.017_000_000_1, 1e-9), (87.1, 1e-3), (1e5, 1.0), (1e9, 1e7), (1e12, 1e9)] {
        let board = format!("columns = 41\nrows = 41\nsquare_mm = {square:?}\nposition_mm = [0.0, 0.0, {z:?}]");
        let text = super::scenes::text(FULL, "", FLAT, &board);
        let scene =
            scene::parse(&text, "the catalogue of hard cases", None).unwrap_or_else(|problem| panic!("{problem}"));
        let system = system(&scene);
        let aimer = Aimer::new(&system);
        for px in places(FULL, 300) {
            let end = system.trace(px).and_then(|sight| aimer.aim(sight.board_mm, sight.side));
            tally.ended(&end);
            match end {
                Ok(back) => tally.error(|| format!("{px}, board at {z:e}"), (back - px).length()),
                Err(fate) => tally.require(false, || format!("{px}, board at {z:e}: {}", fate.name())),
            }
        }
    }
    // A view so narrow that the board's rounding shows is still a number.
    let narrow = built([3, 3], "", FLAT, "columns = 1\nrows = 1\nsquare_mm = 1e-9\nposition_mm = [0.0, 0.0, 1e12]");
    tally.require(narrow.trace(DVec2::splat(1.2)).is_ok(), || "a tiny square far away".to_owned());
    tally.done()
}
