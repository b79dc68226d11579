//! The surface fit: a polynomial through a point cloud by linear least squares (Eq. 6 of the design paper).

use crate::error::Error;
use crate::geom::Rect;
use crate::num::bernstein::MAX_DEGREE;
use crate::num::poly2::Poly2;
use crate::num::powers::Powers;
use crate::surface::shape::PolynomialPatch;
use glam::{DVec2, DVec3};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Largest condition number of a fit: above it the coefficients have fewer than six certain digits. The scaled powers of
/// degree 20 on a well-spread cloud stay below 1e9.
pub const MAX_CONDITION: f64 = 1e10;

/// Largest magnitude of a coordinate: a kilometre, far above any prism and far below where squares lose their digits.
pub const MAX_COORDINATE_MM: f64 = 1e6;

/// Smallest extent of a cloud in x or y: a picometre. One below it is no extent.
const SMALLEST_EXTENT_MM: f64 = 1e-9;

/// Points whose equations are factored together. Fixed, so that the result does not depend on the number of threads;
/// this many rows of 13 columns stay in a core's second cache.
const BLOCK: usize = 1024;

/// How far a patch's domain reaches beyond its points, as a fraction of their extent, on every side.
const DOMAIN_MARGIN: f64 = 0.02;

/// A fitted surface, and how well it goes through its points.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceFit {
    /// z(x, y) over the bounding rectangle of the points, grown by 2 % of its size on every side.
    pub patch: PolynomialPatch,
    /// Points fitted.
    pub points: usize,
    /// Root mean square of the residuals along z, in mm.
    pub rms_mm: f64,
    /// Largest residual along z, in mm.
    pub max_mm: f64,
    /// The number of the point with the largest residual, from 0.
    pub worst: usize,
    /// Condition number of the equations: the largest over the smallest singular value.
    pub condition: f64,
}

/// [`fit_powers`] with even powers of y only, which a designed surface has.
///
/// # Errors
/// As [`fit_powers`].
pub fn fit(points_mm: &[DVec3], degree: usize, centre_mm: Option<DVec2>) -> Result<SurfaceFit, Error> {
    fit_powers(points_mm, degree, Powers::EvenInY, centre_mm)
}

/// The polynomial z(x, y) = sum of c_mn X^m Y^n over m + n <= `degree` and the `kept` powers that goes through
/// `points_mm` with the least squares of residuals along z. X = (x - x0)/sx and Y = (y - y0)/sy with (x0, y0) =
/// `centre_mm` and (sx, sy) the largest distances of a point from it. Without a centre, (x0, y0) is the middle of the
/// points; with even powers of y only, y = y0 is the plane of symmetry and y0 = 0, that of a biprism.
///
/// Householder QR, in blocks of rows whose triangles are stacked and factored again (Demmel et al., SIAM J. Sci. Comput.
/// 34 (2012) A206): as stable as one QR of the whole, without its memory, and the same bits for any number of threads.
///
/// # Errors
/// A [`Error`] when the degree is not 1 ..= 20, a coordinate is not a number, or the points do not determine every
/// coefficient: then it names the rank.
pub fn fit_powers(
    points_mm: &[DVec3],
    degree: usize,
    kept: Powers,
    centre_mm: Option<DVec2>,
) -> Result<SurfaceFit, Error> {
    // Refuse a degree out of range and coordinates that are none.
    if !(1..=MAX_DEGREE).contains(&degree) {
        return Err(Error::new(
            "the surface fit",
            format!("the degree is {degree}, and must be within 1 .. {MAX_DEGREE}"),
            "set `prism.design.degree` to 5, the paper's",
        ));
    }
    if let Some(bad) = points_mm.iter().position(|p| !p.abs().cmple(DVec3::splat(MAX_COORDINATE_MM)).all()) {
        return Err(Error::new(
            "the surface fit",
            format!("point {} is {}, and must be within {MAX_COORDINATE_MM:e} mm", bad + 1, points_mm[bad]),
            "remove the point from the cloud, or check its unit",
        ));
    }

    // Scale the points by their extent.
    let powers = powers(degree, kept);
    if points_mm.is_empty() {
        return Err(rank_problem(0, 0, kept, degree));
    }
    let (min, max) = points_mm.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(a, b), p| (a.min(*p), b.max(*p)));
    let centre = centre_mm.unwrap_or(match kept {
        Powers::EvenInY => DVec2::new(0.5 * (min.x + max.x), 0.0),
        Powers::All => 0.5 * (min + max).truncate(),
    });
    // A cloud without extent has no scale; any will do, since it is refused for its rank.
    let scale =
        (max.truncate() - centre).max(centre - min.truncate()).map(|s| if s >= SMALLEST_EXTENT_MM { s } else { 1.0 });

    // Factor the equations, and demand full rank by the singular values.
    let triangle = triangle(points_mm, &powers, centre, scale);
    let equations = triangle.columns(0, powers.len()).into_owned();
    let singular = equations.clone().singular_values();
    let (largest, smallest) = (singular.max(), singular.min());
    let rank = singular.iter().filter(|s| **s * MAX_CONDITION > largest).count();
    if rank < powers.len() {
        return Err(rank_problem(points_mm.len(), rank, kept, degree));
    }

    // Solve the triangle for the coefficients.
    let square = equations.rows(0, powers.len());
    let right: DVector<f64> = triangle.column(powers.len()).rows(0, powers.len()).into_owned();
    let solution = square.solve_upper_triangular(&right).expect("a matrix of full rank has no zero on its diagonal");

    let sag = Poly2::new(degree, centre.to_array(), scale.to_array(), |m, n| {
        powers.iter().position(|&p| p == (m, n)).map_or(0.0, |i| solution[i])
    });

    // Measure the residuals, and grow the domain beyond the points.
    let Residuals { rms_mm, max_mm, worst } = residuals(points_mm, &sag);
    let margin = (max - min).truncate() * DOMAIN_MARGIN;
    let domain = Rect { min: min.truncate() - margin, max: max.truncate() + margin };
    let patch = PolynomialPatch { sag, domain };
    Ok(SurfaceFit { patch, points: points_mm.len(), rms_mm, max_mm, worst, condition: largest / smallest })
}

/// A surface that was not fitted to `points_mm`, and how well it goes through them.
pub(super) fn given(patch: PolynomialPatch, points_mm: &[DVec3]) -> SurfaceFit {
    let Residuals { rms_mm, max_mm, worst } = residuals(points_mm, &patch.sag);
    SurfaceFit { patch, points: points_mm.len(), rms_mm, max_mm, worst, condition: 1.0 }
}

/// The powers (m, n) of a fit: m + n <= `degree`, and n even where only those are kept.
fn powers(degree: usize, kept: Powers) -> Vec<(usize, usize)> {
    let step = if kept == Powers::EvenInY { 2 } else { 1 };
    (0..=degree).step_by(step).flat_map(|n| (0..=degree - n).map(move |m| (m, n))).collect()
}

/// How many coefficients a fit has.
pub fn coefficients(degree: usize, kept: Powers) -> usize {
    powers(degree, kept).len()
}

/// The triangle R of [powers | z] = Q R over all points. Its last column is Q^T z.
fn triangle(points_mm: &[DVec3], powers: &[(usize, usize)], centre: DVec2, scale: DVec2) -> DMatrix<f64> {
    // Factor block by block.
    let columns = powers.len() + 1;
    let rows = BLOCK.max(4 * columns);
    let triangles: Vec<DMatrix<f64>> = points_mm
        .par_chunks(rows)
        .map(|block| {
            let mut a = DMatrix::zeros(block.len(), columns);
            for (row, p) in block.iter().enumerate() {
                // Fill a row with the powers of the scaled coordinates, and z.
                let [x, y] = ((p.truncate() - centre) / scale).to_array();
                let mut power = [[1.0; MAX_DEGREE + 1]; 2];
                for i in 1..=MAX_DEGREE {
                    power[0][i] = power[0][i - 1] * x;
                    power[1][i] = power[1][i - 1] * y;
                }
                for (column, &(m, n)) in powers.iter().enumerate() {
                    a[(row, column)] = power[0][m] * power[1][n];
                }
                a[(row, powers.len())] = p.z;
            }
            a.qr().unpack_r()
        })
        .collect();

    // Stack the triangles and factor them again.
    let mut stacked = DMatrix::zeros(triangles.iter().map(DMatrix::nrows).sum(), columns);
    let mut row = 0;
    for triangle in &triangles {
        stacked.rows_mut(row, triangle.nrows()).copy_from(triangle);
        row += triangle.nrows();
    }
    stacked.qr().unpack_r()
}

/// What a fit leaves of z - sag(x, y).
struct Residuals {
    rms_mm: f64,
    max_mm: f64,
    worst: usize,
}

fn residuals(points_mm: &[DVec3], sag: &Poly2) -> Residuals {
    let blocks: Vec<(f64, f64, usize)> = points_mm
        .par_chunks(BLOCK)
        .enumerate()
        .map(|(block, points)| {
            let residuals = points.iter().map(|p| p.z - sag.value(p.x, p.y)).enumerate();
            residuals.fold((0.0, 0.0, block * BLOCK), |(sum, max, worst), (k, r): (usize, f64)| {
                let (max, worst) = if r.abs() > max { (r.abs(), block * BLOCK + k) } else { (max, worst) };
                (sum + r * r, max, worst)
            })
        })
        .collect();
    let (sum, max_mm, worst) = blocks.iter().fold((0.0, 0.0, 0), |(sum, max, worst): (f64, f64, usize), b| {
        let (max, worst) = if b.1 > max { (b.1, b.2) } else { (max, worst) };
        (sum + b.0, max, worst)
    });
    Residuals { rms_mm: (sum / points_mm.len() as f64).sqrt(), max_mm, worst }
}

fn rank_problem(points: usize, rank: usize, kept: Powers, degree: usize) -> Error {
    let wanted = coefficients(degree, kept);
    let lower = (1..degree).rev().find(|d| coefficients(*d, kept) <= rank);
    Error::new(
        "the surface fit",
        format!(
            "{points} points determine {rank} of the {wanted} coefficients of degree {degree} (the rank of the fit)"
        ),
        match lower {
            Some(d) => format!(
                "give at least {wanted} points that spread over x and y, or lower the degree to {d} ({} coefficients)",
                coefficients(d, kept)
            ),
            None => format!("give at least {wanted} points that spread over x and y"),
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A polynomial with even powers of y only, in mm over x in -4..10, y in -5..5.
    fn truth() -> Poly2 {
        let c =
            |m: usize, n: usize| if n.is_multiple_of(2) { 1.0 / (1 + m + 2 * n) as f64 - 0.3 * m as f64 } else { 0.0 };
        Poly2::new(5, [3.0, 0.0], [7.0, 5.0], c)
    }

    fn grid(columns: usize, rows: usize) -> Vec<DVec3> {
        let spread = |i: usize, n: usize| 2.0 * i as f64 / (n - 1) as f64 - 1.0;
        let at = |i, j| (3.0 + 7.0 * spread(i, columns), 5.0 * spread(j, rows));
        let sag = truth();
        (0..columns * rows)
            .map(|k| at(k % columns, k / columns))
            .map(|(x, y)| DVec3::new(x, y, sag.value(x, y)))
            .collect()
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
        let points: Vec<_> =
            grid(300, 11).iter().map(|p| DVec3::new(p.x, p.y, libm::cos(0.4 * p.x + 0.2 * p.y))).collect();
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
}
