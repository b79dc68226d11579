//! The march of the design: its order of convergence, its floor, and where it must stop.

use super::case::{Case, ErrorUnit};
use super::scenes::{BOARD, scene};
use super::tally::{CaseOutcome, Tally};
use crate::design::{DesignInput, freeform_by};
use crate::num::ode::Integrator;
use crate::scene::PrismSpec;

pub(super) const CASES: &[Case] = &[
    Case {
        group: "marching",
        name: "order of convergence",
        hard: "Euler, midpoint and Runge-Kutta at steps from a third of the field down",
        property: "the spread of the optical path falls with the step as 1, 2, 4 until rounding, and stays there",
        unit: ErrorUnit::Order,
        bound: 0.35,
        why: "halving a finite step shows the order up to the next power of the step",
        run: order,
    },
    Case {
        group: "marching",
        name: "no surface to be had",
        hard: "denominators of Eq. 4 near 0: index ratio near 1, fields of 46 deg, no glass left; steps beyond the field",
        property: "a design or a problem that says where and why; every figure is a number",
        unit: ErrorUnit::Mm,
        bound: 1e-3,
        why: "one step of Runge-Kutta over a whole field is coarse, but not wild",
        run: singular,
    },
];

/// The input of a small sensor over the paper's field, `step` px of its 96 columns.
fn input(prism: &str, camera: &str, step: f64) -> DesignInput {
    let text = format!("kind = \"freeform\"\n{prism}\n[prism.design]\nstep_px = {step:?}");
    let scene = scene([96, 54], camera, &text, BOARD);
    let PrismSpec::Freeform(flat, settings) = scene.prism else { panic!("the scene has a freeform prism") };
    DesignInput { camera: scene.camera, prism: flat, settings, virtual_camera_z_mm: 0.0 }
}

const PAPER: &str = "index = 1.48\nridge_distance_mm = 78.472\nthickness_mm = 8.545";

fn order() -> CaseOutcome {
    let mut tally = Tally::default();
    let spread = |integrator, step: f64| {
        freeform_by(&input(PAPER, "", step), integrator).map_or(f64::NAN, |design| design.optical_path_spread_mm)
    };
    for (integrator, expected) in [(Integrator::Euler, 1.0), (Integrator::Midpoint, 2.0), (Integrator::Rk4, 4.0)] {
        let mut coarse = spread(integrator, 4.0);
        for step in [2.0, 1.0, 0.5, 0.25] {
            let fine = spread(integrator, step);
            // Path lengths of 90 mm round to 1.4e-14 mm, some hundred times over a line of the march.
            if fine > 1e-11 {
                tally.error(|| format!("{integrator:?} at {step} px"), libm::log2(coarse / fine) - expected);
            } else {
                tally.require(fine <= coarse.max(3e-12), || format!("{integrator:?}: {fine:e} at {step} px grows"));
            }
            coarse = fine;
        }
    }
    tally.done()
}

fn singular() -> CaseOutcome {
    let mut tally = Tally::default();
    let prisms = [
        PAPER.to_owned(),
        PAPER.replace("1.48", "1.0029") + "\nfacet_angle_deg = 5.0",
        PAPER.replace("1.48", "1.0000000001") + "\nfacet_angle_deg = 1.0",
        PAPER.replace("1.48", "4.0"),
        PAPER.replace("8.545", "1.0"),
        PAPER.replace("8.545", "60.0") + "\nfacet_angle_deg = 35.0",
        PAPER.to_owned() + "\nfacet_angle_deg = -20.0",
        PAPER.to_owned() + "\nfacet_angle_deg = 0.0",
        PAPER.to_owned() + "\nfacet_angle_deg = 1e-300",
        "index = 1.48\nridge_distance_mm = 1e-6\nthickness_mm = 8.545".to_owned(),
        "index = 1.48\nridge_distance_mm = 78.472\nthickness_mm = 1e-6\nfacet_angle_deg = 0.0".to_owned(),
    ];
    for prism in &prisms {
        for step in [1000.0, 24.0, 0.5] {
            let text = format!("kind = \"freeform\"\n{prism}\n[prism.design]\nstep_px = {step:?}");
            let text = super::scenes::text([96, 54], "", &text, BOARD);
            // Either the scene, or its design, or the traced result: whichever is refused says so.
            let Ok(scene) = crate::scene::parse(&text, "the catalogue of hard cases", None) else {
                tally.require(true, String::new);
                continue;
            };
            let PrismSpec::Freeform(flat, settings) = scene.prism else { panic!("the scene has a freeform prism") };
            let input = DesignInput { camera: scene.camera, prism: flat, settings, virtual_camera_z_mm: 0.0 };
            match freeform_by(&input, Integrator::Rk4) {
                Ok(design) => {
                    tally.error(|| format!("{prism:?}, step {step}"), design.optical_path_spread_mm);
                    let finite =
                        [&design.front, &design.back].iter().all(|f| f.rms_mm.is_finite() && f.condition.is_finite());
                    tally.require(finite, || format!("{prism:?}, step {step}: a figure is no number"));
                }
                Err(problem) => {
                    tally.require(!problem.rule.is_empty(), || format!("{prism:?}: refused without a word"))
                }
            }
        }
    }
    tally.done()
}
