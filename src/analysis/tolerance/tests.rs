//! Errors of the paper's prism against an independent program, and what trials must be.

use super::operand::Operand;
use super::probe::{Criterion, Probe};
use super::sensitivity::{Budgeted, sensitivities};
use super::trials::{Distribution, TrialPlan, quantiles, trial, yield_of};
use crate::analysis::relay::lens::RelayLens;
use crate::analysis::relay::tests::freeform_of_the_tables;
use crate::scene::{self, Scene};
use std::sync::LazyLock;

fn paper() -> Scene {
    let text = include_str!("../../../scenes/paper.toml");
    scene::parse(text, "paper", None).unwrap_or_else(|problem| panic!("{problem}"))
}

const LENS: RelayLens = RelayLens { na: 0.09, magnification: 0.55, wavelength_mm: 486.1327e-6 };

static PROBE: LazyLock<Probe> =
    LazyLock::new(|| Probe::new(&paper(), LENS, 16, None).unwrap_or_else(|problem| panic!("{problem}")));

/// A program in numpy, which shares nothing with this one but the surfaces: spots in um, focused as the right prism and anew.
#[test]
fn errors_cost_what_another_program_says() {
    let probe = Probe::new(&freeform_of_the_tables(), LENS, 16, None).unwrap_or_else(|problem| panic!("{problem}"));
    let asked = [Criterion::Spot, Criterion::BestSpot];
    for (operand, amount, wanted) in [
        (Operand::Radius1, 1.0, [11.414_260_29, 0.553_304_090_2]),
        (Operand::Radius1, -1.0, [11.804_253_40, 0.342_788_456_8]),
        (Operand::Thickness, 0.2, [2.876_254_950, 1.484_373_120]),
        (Operand::Thickness, -0.2, [2.118_177_163, 0.930_310_168_4]),
        (Operand::DecentreX2, 0.2, [0.832_797_042_6, 0.815_048_292_3]),
        (Operand::DecentreX2, -0.2, [0.838_400_332_7, 0.396_330_627_7]),
    ] {
        let scene = operand.put_into(&probe.scene, amount).expect("it can have it");
        let found = probe.figures(&scene, &asked).expect("rays pass");
        for (found, wanted) in found.into_iter().zip(wanted) {
            assert!((found / wanted - 1.0).abs() < 1e-7, "{} {amount}: {found} for {wanted}", operand.name());
        }
    }
}

/// The largest error that is allowed keeps the budget with either sign, and one of 2 thousandths more does not; without need nothing is
/// allowed, and where nothing is too large nothing is said.
#[test]
fn allowed_errors_are_the_largest() {
    let vertical = |most: f64| Budgeted { criterion: Criterion::Vertical, most };
    let operands =
        [(Operand::Roll, 1e-3), (Operand::TiltY1, 10.0), (Operand::Radius1, 1.0), (Operand::DecentreX2, 1e-6)];
    let found = |most: f64| sensitivities(&PROBE, &operands, &[Criterion::Vertical], &[vertical(most)], &|| {});
    let [all @ .., unfound] = &found(0.1)[..] else { panic!("errors") };
    for found in all {
        let end = found.allowed[0].expect("there is an end");
        let at = |amount: f64| {
            let scene = found.operand.put_into(&PROBE.scene, amount).expect("it can have it");
            PROBE.figures(&scene, &[Criterion::Vertical]).map_or(f64::INFINITY, |figures| figures[0])
        };
        let worse = |size: f64| at(size).max(at(-size));
        assert!(worse(end) <= 0.1 && worse(1.002 * end) > 0.1, "{}: {end} {}", found.operand.name(), worse(end));
    }
    assert_eq!(unfound.allowed, [None]);
    assert!(found(1e-3).iter().all(|found| found.allowed == [Some(0.0)]));
}

/// Facets of a design by surfaces of revolution and of triangles turn as those of polynomials do.
#[test]
fn facets_of_every_kind_turn() {
    let steeper = |scene: &Scene| {
        let lens = RelayLens { na: 0.02, magnification: 0.55, wavelength_mm: 486.1327e-6 };
        let probe = Probe::new(scene, lens, 4, None).unwrap_or_else(|problem| panic!("{problem}"));
        let baseline = |amount: f64| {
            let scene = Operand::FacetAngle.put_into(&probe.scene, amount).expect("it can have it");
            let system = crate::system::build(&scene).unwrap_or_else(|problem| panic!("{problem}"));
            let at = |x: f64| system.trace(glam::DVec2::new(x, 540.0)).expect("it passes").board_mm.x;
            at(1440.0) - at(480.0)
        };
        (baseline(0.1) - baseline(-0.1), scene.prism.kind())
    };
    let text = include_str!("../../../scenes/paper.toml");
    let of = |design: &str| {
        let text = text
            .replace("[prism.design]", &format!("[prism.design]\nobjective = \"epipolar\"\nsurface = \"{design}\""));
        scene::parse(&text, "facets", None).unwrap_or_else(|problem| panic!("{problem}"))
    };
    let (polynomial, revolved) = (steeper(&of("polynomial")), steeper(&of("revolved")));
    // Twice 0.1 deg of either facet turn each view by (n - 1) times as much, at 1 m of distance.
    let wanted = 2.0 * 0.2f64.to_radians() * 0.48 * 1000.0;
    assert!((polynomial.0.abs() / wanted - 1.0).abs() < 0.15, "{} for {wanted}", polynomial.0);
    assert!((revolved.0 / polynomial.0 - 1.0).abs() < 0.02, "{} {}", revolved.0, polynomial.0);
}

/// An error of nothing changes nothing, and a small one of twice the size changes the pair twice as much.
#[test]
fn small_errors_act_in_proportion() {
    let asked = [Criterion::Vertical, Criterion::Pinhole];
    let of = |operand: Operand, amount: f64| {
        let scene = operand.put_into(&PROBE.scene, amount).expect("it can have it");
        PROBE.figures(&scene, &asked).expect("rays pass")
    };
    let right = PROBE.figures(&PROBE.scene, &asked).expect("rays pass");
    for operand in Operand::ALL {
        assert_eq!(of(operand, 0.0), right, "{}", operand.name());
        // Squares of the figures are parabolas of the amount.
        let step = 1e-3 * operand.usual();
        let square = |amount: f64, k: usize| of(operand, amount)[k] * of(operand, amount)[k];
        for k in 0..2 {
            let [a, b, c, d] = [-1.0, 0.0, 1.0, 2.0].map(|s| square(s * step, k));
            let third = (d - 3.0 * c + 3.0 * b - a).abs();
            assert!(third <= 1e-3 * (a - 2.0 * b + c).abs() + 1e-9 * b + 1e-16, "{} {k}: {third:e}", operand.name());
        }
    }
}

/// Roll about z turns the vertical disparity by 0.26 px an arcminute for any prism: the baseline over the distance, in px, by the angle.
#[test]
fn roll_tilts_the_baseline() {
    let minutes = 3.0;
    let scene = Operand::Roll.put_into(&PROBE.scene, minutes / 60.0).expect("it can have it");
    let [rolled] = PROBE.figures(&scene, &[Criterion::Vertical]).expect("rays pass")[..] else { panic!("one") };
    let [right] = PROBE.figures(&PROBE.scene, &[Criterion::Vertical]).expect("rays pass")[..] else { panic!("one") };
    let by_roll = (rolled * rolled - right * right).sqrt() / minutes;
    println!("{by_roll} px an arcminute");
    assert!((by_roll / 0.26 - 1.0).abs() < 0.1, "{by_roll}");
}

#[test]
fn trials_belong_to_their_number_alone() {
    let plan = |seed: u64| TrialPlan {
        operands: Operand::ALL.map(|operand| (operand, operand.usual())).to_vec(),
        distribution: Distribution::Normal,
        seed,
        asked: vec![Criterion::Vertical],
    };
    let of = |seed: u64, number: u32| trial(&PROBE, &plan(seed), number).expect("rays pass")[0];
    assert_eq!(of(1, 7).to_bits(), of(1, 7).to_bits());
    assert!(of(1, 7) != of(1, 8) && of(1, 7) != of(2, 7));
}

/// In 2000 samples of 200 uniform numbers the interval holds the true quantile in 95 of 100 cases, by a binomial to 1.5 of 100.
#[test]
fn intervals_hold_what_they_should() {
    let shares = [0.5, 0.9];
    let mut held = [0; 2];
    for sample in 0..2000 {
        let mut stream = crate::num::deviates::Stream::new(3, 0, 0, sample);
        let values: Vec<f64> = (0..200).map(|_| stream.uniform()).collect();
        for (held, found) in held.iter_mut().zip(quantiles(&values, &shares)) {
            let [low, high] = found.interval.map(|end| end.expect("there are enough"));
            *held += usize::from(low <= found.share && found.share <= high);
        }
    }
    for held in held {
        assert!((1870..=1960).contains(&held), "{held}");
    }
    let [share, low, high] = yield_of(90, 100);
    assert!(share == 0.9 && (low - 0.825_6).abs() < 1e-3 && (high - 0.944_8).abs() < 1e-3, "{low} {high}");
}
