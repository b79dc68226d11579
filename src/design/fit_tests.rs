//! Tests of the surface fit.

use super::*;

/// A polynomial with even powers of y only, in mm over x in -4..10, y in -5..5.
fn truth() -> Poly2 {
    let c = |m: usize, n: usize| if n.is_multiple_of(2) { 1.0 / (1 + m + 2 * n) as f64 - 0.3 * m as f64 } else { 0.0 };
    Poly2::new(5, [3.0, 0.0], [7.0, 5.0], c)
}

fn grid(columns: usize, rows: usize) -> Vec<DVec3> {
    let spread = |i: usize, n: usize| 2.0 * i as f64 / (n - 1) as f64 - 1.0;
    let at = |i, j| (3.0 + 7.0 * spread(i, columns), 5.0 * spread(j, rows));
    let sag = truth();
    (0..columns * rows).map(|k| at(k % columns, k / columns)).map(|(x, y)| DVec3::new(x, y, sag.value(x, y))).collect()
}

#[test]
fn a_polynomial_is_found_again_from_any_centre() {
    let sag = truth();
    for centre in [None, Some(DVec2::new(2.0, 0.0))] {
        let fit = fit(&grid(71, 51), 5, centre).unwrap();
        // Rounding of z (3.6e-15 mm at 20 mm) times a condition number of some hundreds.
        assert!(fit.rms_mm < 1e-13 && fit.max_mm < 1e-12, "{fit:?}");
        assert!((fit.patch.sag.value(9.3, -4.4) - sag.value(9.3, -4.4)).abs() < 1e-12);
        assert!(fit.patch.sag.terms().all(|(_, n, c)| n.is_multiple_of(2) || c == 0.0));
    }
    let own = fit(&grid(71, 51), 5, None).unwrap();
    assert_eq!(own.patch.sag.scale(), [7.0, 5.0]);
    for ((m, n, found), (_, _, exact)) in own.patch.sag.terms().zip(sag.terms()) {
        assert!((found - exact).abs() < 1e-12, "({m}, {n}): {found} {exact}");
    }
}

#[test]
fn all_powers_are_kept_unless_the_surface_is_symmetric() {
    let tilted: Vec<_> = grid(41, 31).iter().map(|p| *p + DVec3::Z * 0.02 * (p.y - 1.0)).collect();
    let found = fit_powers(&tilted, 5, Powers::All, None).unwrap();
    assert!(found.max_mm < 1e-12, "{found:?}");
    let even = fit_powers(&tilted, 5, Powers::EvenInY, None).unwrap();
    // 0.02 (y - 1) over y in -5..5 leaves its odd part: 0.1 mm at the rim.
    assert!((even.max_mm - 0.1).abs() < 1e-9 && tilted[even.worst].y.abs() > 4.99, "{even:?}");
}

#[test]
fn the_domain_reaches_two_percent_beyond_the_points() {
    let domain = fit(&grid(20, 20), 3, None).unwrap().patch.domain;
    assert!((domain.min - DVec2::new(-4.0 - 0.28, -5.0 - 0.2)).length() < 1e-12);
    assert!((domain.max - DVec2::new(10.0 + 0.28, 5.0 + 0.2)).length() < 1e-12);
}

#[test]
fn residuals_are_at_right_angles_to_every_power() {
    // A surface that no polynomial of degree 4 holds: the least-squares residual is orthogonal to the powers.
    let points: Vec<_> = grid(300, 11).iter().map(|p| DVec3::new(p.x, p.y, libm::cos(0.4 * p.x + 0.2 * p.y))).collect();
    let fit = fit(&points, 4, None).unwrap();
    assert!(fit.rms_mm > 1e-3 && fit.max_mm >= fit.rms_mm);
    let [x0, _] = fit.patch.sag.centre();
    let [sx, sy] = fit.patch.sag.scale();
    for (m, n) in powers(4, Powers::EvenInY) {
        let power = |t: f64, k: usize| (0..k).map(|_| t).product::<f64>();
        let dot: f64 = points
            .iter()
            .map(|p| (p.z - fit.patch.sag.value(p.x, p.y)) * power((p.x - x0) / sx, m) * power(p.y / sy, n))
            .sum();
        // 3300 terms, each rounded to 1e-16.
        assert!(dot.abs() < 1e-11, "({m}, {n}): {dot:e}");
    }
}

#[test]
fn blocks_make_no_difference() {
    // One point more or less than whole blocks, and fewer points in the last block than coefficients.
    let all = grid(41, 101);
    for count in [BLOCK - 1, BLOCK, BLOCK + 1, 2 * BLOCK + 3, all.len()] {
        let fit = fit(&all[..count], 5, None).unwrap();
        assert!(fit.points == count && fit.max_mm < 1e-11, "{count}: {fit:?}");
    }
}

#[test]
fn degrees_of_one_pass_are_those_of_their_own() {
    let points: Vec<_> = grid(300, 11).iter().map(|p| DVec3::new(p.x, p.y, libm::cos(0.4 * p.x + 0.2 * p.y))).collect();
    for kept in [Powers::EvenInY, Powers::All] {
        for (degree, found) in (2..=9).zip(fit_degrees((&points, &[]), &[2, 3, 4, 5, 6, 7, 8, 9], kept, None)) {
            let (found, own) = (found.unwrap(), fit_powers(&points, degree, kept, None).unwrap());
            // Roundings of z (up to 1) times a condition number of some hundreds.
            assert!((found.rms_mm - own.rms_mm).abs() < 1e-13 && (found.max_mm - own.max_mm).abs() < 1e-12);
            assert!((found.condition / own.condition - 1.0).abs() < 1e-9, "{degree}");
        }
    }
    // What the points do not determine is refused, and the rest is there.
    let few = &grid(4, 3)[..];
    let found = fit_degrees((few, &[]), &[2, 9], Powers::All, None);
    assert!(found[0].is_ok() && found[1].as_ref().unwrap_err().rule.contains("of degree 9"));
}

#[test]
fn the_highest_degree_is_within_the_condition() {
    let fit = fit(&grid(161, 121), MAX_DEGREE, None).unwrap();
    assert!(fit.condition < 1e9, "{:e}", fit.condition);
    assert!(fit.max_mm < 1e-11, "{:e}", fit.max_mm);
}

#[test]
fn clouds_that_determine_too_little_name_their_rank() {
    let few = &grid(10, 10)[..3];
    let line: Vec<_> = grid(400, 2).into_iter().map(|p| DVec3::new(p.x, 0.0, p.z)).collect();
    // 3 x 3 places, of which even powers of y tell 3 x 2 apart.
    let twin: Vec<_> = (0..90).map(|i| grid(3, 3)[i % 9] + DVec3::X * 1e-13 * i as f64).collect();
    let same: Vec<_> = vec![DVec3::new(1.0, 1.0, 1.0); 50];
    for (points, rank) in [(few, 3), (&line, 6), (&twin, 6), (&same, 1), (&[], 0)] {
        let problem = fit(points, 5, None).unwrap_err();
        assert!(
            problem.rule.contains(&format!("{} points determine {rank} of the 12 coefficients", points.len())),
            "{}",
            problem.rule
        );
        assert!(problem.help.contains("at least 12 points"), "{}", problem.help);
    }
    assert!(fit(few, 5, None).unwrap_err().help.contains("lower the degree to 1 (2 coefficients)"));
}

#[test]
fn impossible_input_is_a_problem() {
    for degree in [0, MAX_DEGREE + 1] {
        assert!(fit(&grid(9, 9), degree, None).unwrap_err().rule.contains("degree"));
    }
    let mut points = grid(9, 9);
    points[40].z = f64::NAN;
    assert!(fit(&points, 5, None).unwrap_err().rule.contains("point 41"));
    points[40].z = 1e7;
    assert!(fit(&points, 5, None).unwrap_err().rule.contains("point 41"));
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let points = grid(200, 100);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| fit(&points, 5, None).unwrap())
    };
    assert_eq!(with(1), with(3));
}
