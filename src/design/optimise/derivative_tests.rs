//! Are the derivatives of the search those of its residuals?

use super::merit::LawMerit;
use super::start::Start;
use crate::design::virtual_camera::tests::{paper_camera, paper_prism};
use crate::design::virtual_camera::virtual_camera;
use crate::num::geodesic::Merit;
use crate::scene::{DesignGoal, DesignSettings, Objective, Rear};
use nalgebra::DVector;

/// Every kind of unknown and of residual, somewhere off the flat prism.
fn merits() -> Vec<(LawMerit, DVector<f64>)> {
    let goal = |rear, square, spot_weight| DesignGoal {
        rear,
        square,
        f_number: Some(8.0),
        spot_weight,
        ..DesignGoal::default()
    };
    let cases = [
        (Objective::ToedIn, goal(Rear::Own, false, 0.0)),
        (Objective::Epipolar, goal(Rear::Even, false, 0.3)),
        (Objective::Pinhole, goal(Rear::Flat, false, 0.0)),
        (Objective::Pinhole, goal(Rear::Own, true, 0.1)),
        (Objective::Depth, goal(Rear::Own, false, 0.0)),
    ];
    let made = |(objective, goal): (Objective, DesignGoal)| {
        let settings = DesignSettings { objective, degree: 4, goal, ..DesignSettings::default() };
        let target = virtual_camera(&paper_camera(), &paper_prism(), 0.0).unwrap();
        let start = Start::new(&paper_camera(), &target, &settings).unwrap();
        let merit = start.merit(4);
        let x = start.unknowns(&merit.layout);
        let x = DVector::from_fn(x.len(), |k, _| x[k] + 0.01 * libm::sin(1.0 + 3.0 * k as f64));
        (merit, x)
    };
    cases.into_iter().map(made).collect()
}

/// Against central differences, whose error is a step's square times a third derivative, and rounding over the step.
#[test]
fn slopes_are_those_of_the_residuals() {
    for (merit, x) in merits() {
        let (residuals, slopes) = merit.jacobian(&x).unwrap();
        assert!((&residuals - merit.residuals(&x).unwrap()).amax() < 1e-9 * residuals.amax());
        let h = 1e-5;
        for k in 0..x.len() {
            let moved = |h: f64| {
                let mut x = x.clone();
                x[k] += h;
                merit.residuals(&x).unwrap()
            };
            let by = (moved(h) - moved(-h)) / (2.0 * h);
            let column = slopes.column(k);
            let off = (&by - column).amax();
            assert!(column.amax() > 1e-3, "{k} does nothing");
            assert!(off < 1e-5 * column.amax().max(1.0), "{k} of {}: {off:e} of {:e}", x.len(), column.amax());
        }
    }
}

#[test]
fn the_bend_is_that_of_the_residuals() {
    for (merit, x) in merits() {
        let way = DVector::from_fn(x.len(), |k, _| libm::cos(2.0 * k as f64));
        let bend = merit.bend(&x, &way).unwrap();
        let h = 1e-4;
        let [before, here, behind] = [-h, 0.0, h].map(|h| merit.residuals(&(&x + h * &way)).unwrap());
        let by = (before - 2.0 * here + behind) / (h * h);
        let off = (&by - &bend).amax();
        assert!(bend.amax() > 1.0 && off < 1e-3 * bend.amax(), "{off:e} of {:e}", bend.amax());
    }
}
