//! Does it reach the bound with noise, and know its error?

use super::judge::{bound, judge};
use crate::common::board::{Noise, Scene};
use biprism::vision::{Settings, detect};
use glam::{DMat3, DVec2, DVec3};

#[test]
fn reaches_the_cramer_rao_bound_with_noise_and_knows_its_error() {
    let scene = Scene {
        sigma_px: 0.7,
        bend_px: DVec2::new(10.0, 8.0),
        ..Scene::view(640, 720, 50.0, 3.0, 8.0, DVec2::new(3.25, -4.63))
    };
    let clean = scene.render();
    let whole: Vec<_> = scene.corners().into_iter().filter(|(index, _)| scene.visible(*index) > 0.999).collect();
    let sample: Vec<[f64; 2]> = whole.iter().step_by(9).map(|(index, _)| bound(&scene, *index, 0.45)).collect();
    let variance = sample.iter().map(|b| b[0] + b[1]).sum::<f64>() / sample.len() as f64;
    for (noise, seeds) in [(0.01, 8), (0.03, 8), (0.05, 8)] {
        let (mut squares, mut distance, mut count, mut sum) = (0.0, 0.0, 0.0, DVec2::ZERO);
        for seed in 0..seeds {
            let image = Noise::new(1000 * seed + (noise * 1e4) as u64).added(&clean, noise);
            let detection = detect(&image, None, &Settings::default());
            let judged = judge(&scene, &detection);
            assert_eq!((judged.missing, judged.wrong), (0, 0), "{noise} {seed}");
            for (_, truth) in &whole {
                let corner = detection
                    .corners
                    .iter()
                    .min_by(|a, b| a.position_px.distance(*truth).total_cmp(&b.position_px.distance(*truth)))
                    .unwrap();
                let e = corner.position_px - *truth;
                squares += e.length_squared();
                distance += 0.5 * e.dot(corner.covariance_px2.inverse() * e);
                sum += e;
                count += 1.0;
            }
        }
        let (rms, limit) = ((squares / count).sqrt(), noise * variance.sqrt());
        let (ratio, calibration, bias) = (rms / limit, distance / count, sum / count);
        println!(
            "noise {noise}: rms {rms:.5} bound {limit:.5} ratio {ratio:.4} calibration {calibration:.3} bias {bias:.5}"
        );
        // The ratio's own standard error is 1 / sqrt(4 count) = 0.012.
        assert!(ratio < 1.05, "{noise}: {ratio}");
        assert!((0.9..1.1).contains(&calibration), "{noise}: {calibration}");
        // Four standard errors of the mean.
        assert!(bias.abs().max_element() < 4.0 * rms / (2.0 * count).sqrt(), "{noise}: {bias}");
    }
}

/// A corner says how its error leans: on a board that is turned and tilted, x and y err together, and all three second
/// moments of the errors are those that are told, or less: what is told may be too large by a fifth in px, never too small.
#[test]
fn errors_lean_as_the_covariance_says() {
    // A board tilted about an axis that is itself turned: lines of one family are half as far apart as those of the other.
    let mut scene = Scene { sigma_px: 0.7, ..Scene::view(560, 600, 32.0, 0.0, 60.0, DVec2::new(3.25, -4.63)) };
    let (sin, cos) = libm::sincos(40f64.to_radians());
    let turn = DMat3::from_cols(DVec3::new(cos, sin, 0.0), DVec3::new(-sin, cos, 0.0), DVec3::Z);
    let middle = DVec2::new(280.0, 300.0);
    scene.board_from_image *= DMat3::from_translation(middle) * turn * DMat3::from_translation(-middle);
    let clean = scene.render();
    let truth: Vec<DVec2> =
        scene.corners().into_iter().filter(|(index, _)| scene.visible(*index) > 0.999).map(|(_, at)| at).collect();
    // Sums of e_x^2, e_y^2, e_x e_y and of what is told of them; of the variance of a product of normal deviates; count.
    let (mut found, mut told, mut spread, mut count) = ([0.0; 3], [0.0; 3], [0.0; 3], 0.0);
    for seed in 0..2 {
        let image = Noise::new(40 + seed).added(&clean, 0.03);
        for corner in detect(&image, None, &Settings::default()).corners {
            let near = truth.iter().find(|at| at.distance(corner.position_px) < 1.0);
            let (Some(at), c) = (near, corner.covariance_px2) else { continue };
            let (e, [xx, yy, xy]) = (corner.position_px - *at, [c.x_axis.x, c.y_axis.y, c.x_axis.y]);
            assert_eq!(c.x_axis.y, c.y_axis.x);
            for (k, (product, moment, variance)) in
                [(e.x * e.x, xx, 2.0 * xx * xx), (e.y * e.y, yy, 2.0 * yy * yy), (e.x * e.y, xy, xx * yy + xy * xy)]
                    .into_iter()
                    .enumerate()
            {
                found[k] += product;
                told[k] += moment;
                spread[k] += variance;
            }
            count += 1.0;
        }
    }
    println!("{count} corners: found {found:?}, told {told:?}");
    assert!(count > 300.0, "{count}");
    for k in 0..3 {
        let four_errors = 4.0 * spread[k].sqrt();
        assert!(found[k].abs() < told[k].abs() + four_errors, "{k}: {found:?} {told:?}");
        assert!(1.44 * found[k].abs() > told[k].abs() - four_errors, "{k}: {found:?} {told:?}");
    }
    // The lean is there to be told.
    assert!(told[2].abs() > 5.0 * spread[2].sqrt() && found[2].abs() > 3.0 * spread[2].sqrt(), "{told:?} {spread:?}");
}
