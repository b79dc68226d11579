//! Is it right under motion, which draws each crossing out, and does it tell the direction?

use super::judge::judge;
use crate::common::board::Noise;
use crate::common::twin::{Kernel, Twin};
use biprism::vision::{Settings, detect, detect_all};

/// Motion by a quarter and a third of a square in any direction costs no corner, and no more than OpenCV's two detectors err on such
/// pictures, 0.03 to 0.08 px; the direction is that of the motion.
#[test]
fn motion_by_a_third_of_a_square_costs_no_corner_and_its_direction_is_told() {
    for (length, degrees) in [(12.0, 0.0), (16.0, 30.0), (12.0, 45.0), (16.0, 45.0), (16.0, 120.0), (16.0, 90.0)] {
        let kernel = Kernel::Line(length, f64::to_radians(degrees));
        let twin = Twin { kernel, ..Twin::board([6, 5], 45.0) };
        let picture = Noise::new(3).added(&twin.render(), 0.004);
        let found = detect(&picture, None, &Settings::default());
        let e = judge(&twin.scene, &found);
        println!(
            "{length} px at {degrees} deg: found {} rms {:.4} max {:.4} {:?} {:?}",
            e.found, e.rms, e.max, found.sigma_px, found.elongated_blur
        );
        let blur = found.elongated_blur.unwrap();
        let off = (blur.direction_rad.to_degrees() - degrees + 90.0).rem_euclid(180.0) - 90.0;
        assert_eq!((e.found, e.wrong), (30, 0), "{length} {degrees} {e:?}");
        assert!(e.rms < 0.03, "{length} {degrees} {e:?}");
        assert!(off.abs() < 3.0, "{length} {degrees} {blur:?}");
        // The standard deviation of a uniform motion is its length over the root of 12, 0.289 of it.
        assert!(
            (0.27..0.31).contains(&(blur.along_px / length)) && blur.across_px < 0.4,
            "{length} {degrees} {blur:?}"
        );
    }
}

/// Motion along a line moves no corner, however short or long it is and wherever it goes, on boards of few corners too: a blur that is
/// Gaussian across each family of lines turns the edges at each crossing, by up to 0.017 px of the corner.
#[test]
fn motion_of_any_length_and_direction_moves_no_corner() {
    let mut failed = Vec::new();
    for (length, degrees, tilt) in [
        (1.0, 45.0, 8.0),
        (2.0, 90.0, 35.0),
        (3.0, 160.0, 8.0),
        (4.0, 0.0, 35.0),
        (6.0, 20.0, 8.0),
        (8.0, 90.0, 8.0),
        (8.0, 120.0, 35.0),
        (12.0, 0.0, 8.0),
        (12.0, 45.0, 35.0),
    ] {
        let twin =
            Twin { kernel: Kernel::Line(length, f64::to_radians(degrees)), ..Twin::posed([3, 3], 40.0, -12.0, tilt) };
        let e = judge(&twin.scene, &detect(&twin.render(), None, &Settings::default()));
        println!("{length} px at {degrees} deg, tilted by {tilt}: found {} rms {:.5} max {:.5}", e.found, e.rms, e.max);
        if e.found != 9 || e.wrong > 0 || e.rms > 2e-3 {
            failed.push(format!("{length} px at {degrees} deg, tilted by {tilt}: {e:?}"));
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

/// One board is one, though finer and coarser pictures show it.
#[test]
fn a_board_under_motion_is_one_board() {
    let twin = Twin { kernel: Kernel::Line(14.0, f64::to_radians(40.0)), ..Twin::board([6, 5], 45.0) };
    let boards = detect_all(&twin.render(), None, &Settings::default());
    assert_eq!(boards.iter().map(|board| board.corners.len()).collect::<Vec<_>>(), [30]);
}

/// A blur that is even all around is not called elongated, whatever the noise.
#[test]
fn an_even_blur_is_not_elongated() {
    for (kernel, noise) in [(Kernel::Gaussian(2.0), 0.0), (Kernel::Gaussian(2.0), 0.03), (Kernel::Disc(4.0), 0.01)] {
        let twin = Twin { kernel, ..Twin::board([6, 5], 40.0) };
        let found = detect(&Noise::new(5).added(&twin.render(), noise), None, &Settings::default());
        assert_eq!((found.corners.len(), found.elongated_blur), (30, None), "{kernel:?} {noise}");
    }
}
