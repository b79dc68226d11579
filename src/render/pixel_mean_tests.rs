use super::*;
use crate::geom::Pose;
use crate::scene::BoardSpec;

fn pattern() -> Checkerboard {
    Checkerboard::new(&BoardSpec {
        columns: 9,
        rows: 9,
        square_mm: 1.0,
        margin_mm: 0.0,
        world_from_board: Pose::IDENTITY,
        black: 0.1,
        white: 0.9,
        background: 0.4,
    })
}

fn one(pattern: &Checkerboard, taylor: &Taylor2, accuracy: &Accuracy) -> PixelMean {
    pixel_means(pattern, &PackedTaylor2::splat(taylor), accuracy)[0]
}

/// A pixel that spans some 0.2 squares, about `seen`, its map bent by `bend` px.
fn taylor(k: usize, seen: DVec2, bend: f64) -> Taylor2 {
    let wave = |n: usize| libm::sin((k * n) as f64);
    Taylor2 {
        seen,
        dx: 0.2 * DVec2::new(wave(3), wave(5)),
        dy: 0.2 * DVec2::new(wave(7), wave(11)),
        dxx: 0.2 * bend * DVec2::new(wave(13), wave(17)),
        dxy: 0.2 * bend * DVec2::new(wave(19), wave(23)),
        dyy: 0.2 * bend * DVec2::new(wave(29), wave(31)),
    }
}

/// The closed form of one line against the exact integral of many small flat parts.
#[test]
fn one_line_is_wrong_by_the_square_of_the_bend() {
    let pattern = pattern();
    let mut lines = 0;
    for bend in [0.0, 1e-4, 1e-3, 1e-2] {
        for k in 1..4000 {
            let seen = DVec2::new(3.9 * libm::sin(0.7 * k as f64), 3.9 * libm::cos(0.3 * k as f64));
            let taylor = taylor(k, seen, bend);
            // Nearly parallel steps make the pixel a line, on which "to second order" means nothing.
            if taylor.dx.perp_dot(taylor.dy).abs() < 0.2 * 0.02 {
                continue;
            }
            let (value, constant, line, _) = at_most_one_line(&pattern, &PackedTaylor2::splat(&taylor), f64::INFINITY);
            if line.none() && constant.none() {
                continue;
            }
            lines += usize::from(line.all());
            let parts = mean_of_parts(&of_squares(&pattern), &taylor, 16);
            // 0.8 of contrast; second order in a bend that slanting steps magnify up to 20 times; in each part of
            // 1/16 the bend is left out along the line, whose mean is right.
            let bound = 1e-13 + 0.8 * (20.0 * bend * 20.0 * bend + bend / 256.0);
            assert!((value.0[0] - parts).abs() < bound, "{k} {bend}: {} {parts}", value.0[0]);
        }
    }
    assert!(lines > 2000, "{lines}");
}

#[test]
fn mirrored_pixels_have_the_same_bits() {
    let pattern = pattern();
    let flip = |v: DVec2| DVec2::new(-v.x, v.y);
    for k in 1..4000 {
        let seen = DVec2::new(4.9 * libm::sin(0.7 * k as f64), 4.9 * libm::cos(0.3 * k as f64));
        let mut right = taylor(k, seen, [0.0, 1e-5, 1e-3][k % 3]);
        if k % 5 == 0 {
            // Steps along the axes, and lines that pass through corners of pixels.
            right.dx.y = 0.0;
            right.dy.x = 0.0;
            right.seen.x = 0.5 - 0.5 * right.dx.x * libm::sin(k as f64).signum();
        }
        let left = Taylor2 {
            seen: flip(right.seen),
            dx: -flip(right.dx),
            dy: flip(right.dy),
            dxx: flip(right.dxx),
            dxy: -flip(right.dxy),
            dyy: flip(right.dyy),
        };
        let accuracy = Accuracy::exact();
        assert_eq!(one(&pattern, &right, &accuracy), one(&pattern, &left, &accuracy), "{k}");
    }
}

#[test]
fn a_line_through_the_middle_leaves_half() {
    let pattern = pattern();
    let upright = Taylor2 {
        seen: DVec2::new(0.5, 0.0),
        dx: DVec2::new(0.1, 0.0),
        dy: DVec2::new(0.0, 0.1),
        dxx: DVec2::ZERO,
        dxy: DVec2::ZERO,
        dyy: DVec2::ZERO,
    };
    let value = |taylor: &Taylor2| match one(&pattern, taylor, &Accuracy::exact()) {
        PixelMean::Edge { value, .. } => value,
        other => panic!("{other:?}"),
    };
    assert!((value(&upright) - 0.5).abs() < 1e-15);
    // The line bows by dyy y^2 / 2 over y = -0.5 ..= 0.5, whose mean is dyy / 24, of 0.1 squares a px: to the right the
    // pixel sees 1/240 more of the white square at (1, 0).
    let bowed = Taylor2 { dyy: DVec2::new(0.001, 0.0), ..upright };
    assert!((value(&bowed) - (0.5 + 0.8 * 0.001 / 24.0 / 0.1)).abs() < 1e-12);
}
