use super::*;
use crate::geom::Pose;

fn board(columns: usize, rows: usize) -> BoardSpec {
    BoardSpec {
        columns,
        rows,
        square_mm: 10.0,
        margin_mm: 5.0,
        world_from_board: Pose::IDENTITY,
        black: 0.0,
        white: 1.0,
        background: 0.25,
    }
}

fn square(centre: DVec2, half: f64) -> [DVec2; 4] {
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| centre + DVec2::new(x, y) * half)
}

#[test]
fn top_left_square_is_black_and_its_neighbour_white() {
    for (columns, rows) in [(3, 3), (4, 4), (4, 3), (5, 2)] {
        let p = Checkerboard::new(&board(columns, rows));
        let corner = DVec2::new(columns as f64, rows as f64) * -0.5;
        assert_eq!(p.radiance(corner + 0.1), 0.0, "{columns} x {rows}");
        assert_eq!(p.radiance(corner + DVec2::new(1.1, 0.1)), 1.0);
        assert_eq!(p.radiance(corner - 0.1), 1.0, "the margin is white");
        assert_eq!(p.radiance(corner - 0.6), 0.25, "the background is neither");
    }
}

#[test]
fn a_window_over_a_corner_is_half_and_half() {
    let p = Checkerboard::new(&board(4, 4));
    // The corner at the origin; moved by a quarter of the window, 3/4 x 3/4 + 1/4 x 1/4 of it has one colour.
    let mean = |c: DVec2| p.mean_over(&square(c, 0.2)).expect("not degenerate");
    assert!((mean(DVec2::ZERO) - 0.5).abs() < 1e-15);
    assert!((mean(DVec2::new(0.1, 0.1)) - (1.0 - 0.625)).abs() < 1e-15);
}

#[test]
fn a_window_over_everything_sees_every_share() {
    let p = Checkerboard::new(&board(3, 3));
    // 4 white squares of 9, the margin 40^2 - 30^2, the rest of 100^2 background.
    let mean = p.mean_over(&square(DVec2::new(0.3, -0.7), 5.0)).expect("not degenerate");
    let expected = (400.0 + (1600.0 - 900.0) + 0.25 * (10000.0 - 1600.0)) / 10000.0;
    assert!((mean - expected).abs() < 1e-14, "{mean} {expected}");
}

#[test]
fn constant_agrees_with_the_integral_and_with_points() {
    let p = Checkerboard::new(&board(4, 3));
    for k in 0..4000 {
        let centre = DVec2::new((k % 83) as f64 * 0.061 - 2.5, (k / 83) as f64 * 0.083 - 2.0);
        if let Some(value) = p.constant(centre, DVec2::splat(0.07)) {
            assert_eq!(value, p.radiance(centre), "{centre}");
            let mean = p.mean_over(&square(centre, 0.07)).expect("not degenerate");
            assert!((mean - value).abs() < 1e-13, "{centre} {mean} {value}");
        }
    }
}

#[test]
fn a_slanted_polygon_agrees_with_a_million_points() {
    let p = Checkerboard::new(&board(4, 3));
    let (c, a, b) = (DVec2::new(1.3, -0.9), DVec2::new(1.7, 0.4), DVec2::new(-0.5, 1.2));
    let polygon = [c - a / 2.0 - b / 2.0, c + a / 2.0 - b / 2.0, c + a / 2.0 + b / 2.0, c - a / 2.0 + b / 2.0];
    let n = 1000;
    let place = |k: usize| (k as f64 + 0.5) / n as f64 - 0.5;
    let sum: f64 = (0..n * n).map(|k| p.radiance(c + a * place(k % n) + b * place(k / n))).sum();
    // A grid of n points errs by at most the cells on the pattern's lines: a few lines of n cells of 1/n^2, half
    // of each on average random in sign.
    assert!((p.mean_over(&polygon).expect("not degenerate") - sum / (n * n) as f64).abs() < 2e-4);
}

#[test]
fn mirrored_polygons_have_the_same_bits() {
    let p = Checkerboard::new(&board(5, 5));
    for k in 0..500 {
        let c = DVec2::new(libm::sin(k as f64) * 2.4, libm::cos(1.7 * k as f64) * 2.4);
        let (a, b) = (DVec2::new(0.09, 0.005 * libm::sin(3.0 * k as f64)), DVec2::new(-0.007, 0.11));
        let flip = |v: DVec2| DVec2::new(-v.x, v.y);
        let corners = |c: DVec2, a: DVec2, b: DVec2| {
            let (a, b) = (a / 2.0, b / 2.0);
            [c - a - b, c + a - b, c + a + b, c - a + b]
        };
        let right = p.mean_over(&corners(c, a, b));
        let left = p.mean_over(&corners(flip(c), -flip(a), flip(b)));
        assert_eq!(right.map(f64::to_bits), left.map(f64::to_bits), "{c}");
    }
}

/// Along a diagonal a sliver sees squares of one colour only, however many.
#[test]
fn a_sliver_over_thousands_of_squares_is_not_given_their_mean() {
    let mut fine = board(100_000, 100_000);
    fine.square_mm = 1e-3;
    let p = Checkerboard::new(&fine);
    let (along, across) = (DVec2::new(3000.0, 3000.0), DVec2::new(-0.05, 0.05));
    let sliver = |s: f64| [-along * s - across, along * s - across, along * s + across, -along * s + across];
    let short = p.mean_over(&sliver(0.5)).expect("it is short enough");
    assert!(!(0.1..=0.9).contains(&short), "{short}");
    assert_eq!(p.mean_over(&sliver(1.0)), None);
}

#[test]
fn squares_far_below_the_footprint_tend_to_their_mean() {
    let mut fine = board(100_000, 100_000);
    fine.square_mm = 1e-3;
    let p = Checkerboard::new(&fine);
    for half in [500.0, 1500.0, 7000.0] {
        let mean = p.mean_over(&square(DVec2::new(123.0, -777.0), half)).expect("not degenerate");
        assert!((mean - 0.5).abs() < 2e-3, "{half} {mean}");
    }
}

/// Sides that run along a line of the pattern, on it to a few roundings, as rays through pixels on a line see them.
#[test]
fn sides_along_lines_are_where_they_are() {
    for count in [3, 4, 5, 41] {
        let p = Checkerboard::new(&board(count, count));
        for k in 0..20_000u32 {
            let roundings = |shift: u32| f64::from((k >> shift) % 8) - 3.0;
            let [x0, x1] = [0, 1].map(|line| f64::from(line + k % 2) + if count % 2 == 1 { 0.5 } else { 0.0 });
            let off = |x: f64, shift: u32| x + roundings(shift) * f64::EPSILON * x.abs().max(0.25);
            let [y0, y1] = [0.3 - 0.01 * f64::from(k % 97), 1.9 + 0.003 * f64::from(k % 89)];
            let sides = [(off(x0, 0), y0), (off(x1, 3), y0), (off(x1, 6), y1), (off(x0, 9), y1)];
            let exact = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)];
            let [found, expected] =
                [sides, exact].map(|corners| p.mean_over(&corners.map(DVec2::from)).expect("not degenerate"));
            assert!((found - expected).abs() < 1e-13, "{count} {k}: {found} {expected}");
        }
    }
}
