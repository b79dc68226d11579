use super::*;
use crate::metrics::noise::Noise;
use crate::num::lsq::Failure;

fn designed() -> Pinhole {
    Pinhole::parallel(DVec3::new(6.0, 0.0, 0.0), 35.0, 0.0055, DVec2::new(480.0, 540.0))
}

/// A camera near the designed one, every parameter changed.
fn real() -> Pinhole {
    let camera_from_world = Pose::new(DVec3::new(-6.3, 0.2, -6.4), DVec3::new(0.01, -0.004, 0.006));
    Pinhole { camera_from_world, focal_px: DVec2::new(5782.0, 6360.0), principal_px: DVec2::new(471.0, 548.0) }
}

/// Boards of 8 x 9 points that face the designed camera, at the given depths.
fn boards(depths: &[f64]) -> Vec<DVec3> {
    let board =
        |z: f64| (0..72).map(move |k| DVec3::new(f64::from(k % 8) - 3.5, f64::from(k / 8) - 4.0, 0.0) * z / 100.0);
    depths.iter().flat_map(|&z| board(z).map(move |p| p + DVec3::new(6.0, 0.0, z))).collect()
}

fn seen(camera: &Pinhole, points: &[DVec3], sigma: f64, seed: u64) -> Vec<Observation> {
    let mut noise = Noise(seed);
    let see = |&point_mm: &DVec3| Observation {
        point_mm,
        image_px: camera.project(point_mm).unwrap() + sigma * noise.normal(),
    };
    points.iter().map(see).collect()
}

#[test]
fn derivatives_agree_with_central_differences() {
    let observations = seen(&real(), &boards(&[500.0, 2000.0]), 3.0, 1);
    let free = [ALL.as_slice(), &[Focal]].concat();
    let (_, jacobian) = derivatives(&real(), &free, &observations).unwrap();
    for (k, &parameter) in free.iter().enumerate() {
        let h = 1e-4;
        let at = |by| derivatives(&moved(real(), parameter, by), &free, &observations).unwrap().0;
        let slope = (at(h) - at(-h)) / (2.0 * h);
        let column = jacobian.column(k);
        // The difference errs by h^2 / 6 of a third derivative, here of the size of the first, and by rounding of
        // 1e-12 px / h.
        assert!((slope - column).norm() < 1e-7 * (1.0 + column.norm()), "{parameter:?}");
    }
}

#[test]
fn exact_images_give_back_every_parameter() {
    let observations = seen(&real(), &boards(&[500.0, 1000.0, 2000.0]), 0.0, 0);
    let found = fit(&designed(), &ALL, &observations).unwrap();
    assert!(found.deviation.max < 1e-9, "{:?}", found.deviation);
    let (a, b) = (found.pinhole, real());
    assert!((a.focal_px - b.focal_px).length() < 1e-6 && (a.principal_px - b.principal_px).length() < 1e-6);
    assert!((a.centre_mm() - b.centre_mm()).length() < 1e-6);
    let turn = (a.camera_from_world.rotation - b.camera_from_world.rotation).to_cols_array();
    assert!(turn.iter().all(|t| t.abs() < 1e-9));
}

#[test]
fn an_implied_transform_is_no_deviation() {
    // A camera that only stands and looks elsewhere: large against the design, nothing after the fit of the pose.
    let turned = Pinhole { camera_from_world: real().camera_from_world, ..designed() };
    for depths in [[500.0, 500.0], [500.0, 2000.0]] {
        let observations = seen(&turned, &boards(&depths), 0.0, 0);
        assert!(designed().deviation_px(&observations).unwrap().rms > 10.0);
        assert!(fit(&designed(), &POSE, &observations).unwrap().deviation.max < 1e-9);
    }
}

#[test]
fn a_poor_start_still_finds_the_pose() {
    // A board photographed from 0.3 m aside, nearer by a fifth and turned by 20 degrees about each axis.
    let pose = Pose::new(DVec3::new(200.0, -220.0, 200.0), DVec3::splat(0.35));
    let far = Pinhole { camera_from_world: pose, ..designed() };
    let found = fit(&designed(), &POSE, &seen(&far, &boards(&[1000.0]), 0.0, 0)).unwrap();
    assert!(found.deviation.max < 1e-8 && (found.pinhole.centre_mm() - far.centre_mm()).length() < 1e-5);
}

#[test]
fn covariance_is_calibrated_on_noise() {
    // Squared Mahalanobis distances of the truth, with the true variance, are chi-squared of p degrees: mean p,
    // variance 2p.
    let (points, sigma, runs) = (boards(&[500.0, 1000.0, 2000.0]), 0.05, 200);
    let free = POSE_AND_ANAMORPHIC;
    let truth = Pinhole { principal_px: designed().principal_px, ..real() };
    let (mut chi, mut variance) = (0.0, 0.0);
    for run in 0..runs {
        let found = fit(&designed(), &free, &seen(&truth, &points, sigma, run)).unwrap();
        let n = 2 * points.len() - free.len();
        let estimate = found.residuals_px.iter().map(|e| e.length_squared()).sum::<f64>() / n as f64;
        variance += estimate / (sigma * sigma) / f64::from(runs as u32);
        let information = found.covariance.clone().try_inverse().unwrap() * (estimate / (sigma * sigma));
        let error = DVector::from_vec(parameters(&found.pinhole, &truth));
        chi += (error.transpose() * information * &error)[0] / f64::from(runs as u32);
    }
    let p = free.len() as f64;
    // Five standard deviations of each mean.
    assert!((chi - p).abs() < 5.0 * (2.0 * p / f64::from(runs as u32)).sqrt(), "{chi}");
    let freedom = (2 * points.len()) as f64 - p;
    assert!((variance - 1.0).abs() < 5.0 * (2.0 / freedom / f64::from(runs as u32)).sqrt(), "{variance}");
}

/// The steps of [`POSE_AND_ANAMORPHIC`] that lead from `truth` to `found`, to first order.
fn parameters(found: &Pinhole, truth: &Pinhole) -> Vec<f64> {
    let turn = found.camera_from_world.rotation * truth.camera_from_world.rotation.transpose();
    let shift = found.camera_from_world.translation_mm - turn * truth.camera_from_world.translation_mm;
    let focal = found.focal_px - truth.focal_px;
    vec![turn.y_axis.z, turn.z_axis.x, turn.x_axis.y, shift.x, shift.y, shift.z, focal.x, focal.y]
}

#[test]
fn moving_world_and_camera_together_changes_no_residual() {
    let observations = seen(&real(), &boards(&[500.0, 2000.0]), 0.1, 5);
    let world = Pose::new(DVec3::new(300.0, -200.0, 100.0), DVec3::new(0.4, 1.0, -2.0));
    let moved: Vec<_> = observations.iter().map(|o| Observation { point_mm: world.point(o.point_mm), ..*o }).collect();
    let back = world.inverse();
    let seen_from = designed().camera_from_world;
    let camera_from_world =
        Pose { rotation: seen_from.rotation * back.rotation, translation_mm: seen_from.point(back.translation_mm) };
    let a = fit(&designed(), &POSE_AND_FOCAL, &observations).unwrap();
    let b = fit(&Pinhole { camera_from_world, ..designed() }, &POSE_AND_FOCAL, &moved).unwrap();
    assert!((a.deviation.rms - b.deviation.rms).abs() < 1e-9);
    assert!((world.point(a.pinhole.centre_mm()) - b.pinhole.centre_mm()).length() < 1e-6);
}

#[test]
fn hard_input_is_named() {
    let camera = designed();
    let observations = seen(&camera, &boards(&[1000.0]), 0.0, 0);
    assert!(matches!(fit(&camera, &POSE, &[]), Err(Unmeasurable::TooFew { found: 0, needed: 4, .. })));
    assert!(matches!(fit(&camera, &POSE, &observations[..1]), Err(Unmeasurable::TooFew { found: 1, .. })));
    let row = fit(&camera, &POSE, &observations[..8]);
    assert!(matches!(row, Err(Unmeasurable::Fit(Failure::Singular { .. }))), "{row:?}");
    let facing = fit(&camera, &POSE_AND_FOCAL, &observations);
    assert!(matches!(facing, Err(Unmeasurable::Fit(Failure::Singular { .. }))), "{facing:?}");
    let mut bad = observations.clone();
    bad[2].image_px.y = f64::NAN;
    assert_eq!(fit(&camera, &POSE, &bad), Err(Unmeasurable::NotFinite { what: "observation", index: 2 }));
    bad[2] = Observation { point_mm: -observations[2].point_mm, ..observations[2] };
    assert_eq!(fit(&camera, &POSE, &bad), Err(Unmeasurable::BehindCamera { index: 2 }));
}

/// What a facing board leaves open is told as that, and not as steps of a search.
#[test]
fn a_facing_board_is_named_where_it_does_not_fix_the_fit() {
    let camera = designed();
    let mut unfixed = 0;
    for seed in 0..60 {
        let points = boards(&[600.0]);
        // A bend that no pinhole has, besides noise.
        let bent = |o: Observation| {
            let r = (o.image_px - camera.principal_px) / 500.0;
            let bend = 30.0 * f64::from(seed as u32 % 6) * r.length_squared() * r;
            Observation { image_px: o.image_px + bend, ..o }
        };
        let observations: Vec<_> = seen(&real(), &points, 0.5, seed).into_iter().map(bent).collect();
        for free in [&POSE[..], &POSE_AND_FOCAL, &POSE_AND_ANAMORPHIC, &ALL] {
            match fit(&camera, free, &observations) {
                Err(Unmeasurable::Fit(Failure::NotConverged { .. })) => panic!("steps were counted"),
                Err(Unmeasurable::Degenerate(told)) => {
                    assert_eq!(told, FACING);
                    unfixed += 1;
                }
                _ => {}
            }
        }
    }
    println!("{unfixed} fits were left open");
}
