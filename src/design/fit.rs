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
    /// Root mean square of the residuals along z, in mm; of weighted points the weighted one.
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
    checked(points_mm, degree)?;
    FitEquations::new(Samples { points_mm, weights: &[] }, degree, kept, centre_mm)?.solved(degree)
}

/// [`fit`] by the least sum of squares that each count as their weight, of which there is one above 0 for every point,
/// of mean 1.
///
/// # Errors
/// As [`fit_powers`].
///
/// # Panics
/// When there are not as many weights as points.
pub(crate) fn fit_weighted(
    points_mm: &[DVec3],
    weights: &[f64],
    degree: usize,
    centre_mm: Option<DVec2>,
) -> Result<SurfaceFit, Error> {
    assert_eq!(points_mm.len(), weights.len(), "each point has its weight");
    checked(points_mm, degree)?;
    FitEquations::new(Samples { points_mm, weights }, degree, Powers::EvenInY, centre_mm)?.solved(degree)
}

/// [`fit_powers`] of several degrees, with one pass over the points for the equations of all of them: those of a lower degree
/// are columns of those of the highest. Residuals differ from those of [`fit_powers`] in the last bits. Each point counts as its weight,
/// or as any other where there are none.
///
/// # Errors
/// As [`fit_powers`], of each degree by itself.
pub(crate) fn fit_degrees(
    (points_mm, weights): (&[DVec3], &[f64]),
    degrees: &[usize],
    kept: Powers,
    centre_mm: Option<DVec2>,
) -> Vec<Result<SurfaceFit, Error>> {
    let highest = degrees.iter().copied().max().unwrap_or(1);
    let equations = checked(points_mm, highest)
        .and_then(|()| FitEquations::new(Samples { points_mm, weights }, highest, kept, centre_mm));
    degrees.iter().map(|degree| equations.as_ref().map_err(Clone::clone)?.solved(*degree)).collect()
}

/// Refuses a degree out of range and coordinates that are none.
fn checked(points_mm: &[DVec3], degree: usize) -> Result<(), Error> {
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
    Ok(())
}

/// Points and what each counts: as much as any other where no weights are given.
#[derive(Clone, Copy)]
struct Samples<'a> {
    points_mm: &'a [DVec3],
    weights: &'a [f64],
}

impl Samples<'_> {
    fn weight(&self, k: usize) -> f64 {
        self.weights.get(k).copied().unwrap_or(1.0)
    }
}

/// The equations of a fit, factored: the triangle R of [powers | z] = Q R, each row times the root of its weight.
struct FitEquations<'a> {
    samples: Samples<'a>,
    degree: usize,
    kept: Powers,
    centre: DVec2,
    scale: DVec2,
    /// The smallest and the largest coordinates.
    bounds: [DVec2; 2],
    triangle: DMatrix<f64>,
}

impl<'a> FitEquations<'a> {
    fn new(samples: Samples<'a>, degree: usize, kept: Powers, centre_mm: Option<DVec2>) -> Result<Self, Error> {
        // Scale the points by their extent.
        let points_mm = samples.points_mm;
        if points_mm.is_empty() {
            return Err(rank_problem(0, 0, kept, degree));
        }
        let (min, max) =
            points_mm.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(a, b), p| (a.min(*p), b.max(*p)));
        let [min, max] = [min, max].map(DVec3::truncate);
        let centre = centre_mm.unwrap_or(match kept {
            Powers::EvenInY => DVec2::new(0.5 * (min.x + max.x), 0.0),
            Powers::All => 0.5 * (min + max),
        });
        // A cloud without extent has no scale; any will do, since it is refused for its rank.
        let scale = (max - centre).max(centre - min).map(|s| if s >= SMALLEST_EXTENT_MM { s } else { 1.0 });
        let triangle = triangle(samples, &powers(degree, kept), centre, scale);
        Ok(Self { samples, degree, kept, centre, scale, bounds: [min, max], triangle })
    }

    /// The triangle of the powers of `degree`, which is no higher than that of all equations.
    fn of_degree(&self, degree: usize) -> DMatrix<f64> {
        if degree == self.degree {
            return self.triangle.clone();
        }
        let all = powers(self.degree, self.kept);
        let of = |power: &(usize, usize)| all.iter().position(|p| p == power).expect("a lower degree has fewer powers");
        let kept: Vec<usize> = powers(degree, self.kept).iter().map(of).chain([all.len()]).collect();
        self.triangle.select_columns(&kept).qr().unpack_r()
    }

    fn solved(&self, degree: usize) -> Result<SurfaceFit, Error> {
        // Demand full rank by the singular values.
        let Self { samples, kept, centre, scale, bounds: [min, max], .. } = *self;
        let (points, powers) = (samples.points_mm.len(), powers(degree, kept));
        let triangle = self.of_degree(degree);
        let equations = triangle.columns(0, powers.len()).into_owned();
        let singular = equations.clone().singular_values();
        let (largest, smallest) = (singular.max(), singular.min());
        let rank = singular.iter().filter(|s| **s * MAX_CONDITION > largest).count();
        if rank < powers.len() {
            return Err(rank_problem(points, rank, kept, degree));
        }

        // Solve the triangle for the coefficients.
        let square = equations.rows(0, powers.len());
        let right: DVector<f64> = triangle.column(powers.len()).rows(0, powers.len()).into_owned();
        let solution =
            square.solve_upper_triangular(&right).expect("a matrix of full rank has no zero on its diagonal");
        let sag = Poly2::new(degree, centre.to_array(), scale.to_array(), |m, n| {
            powers.iter().position(|&p| p == (m, n)).map_or(0.0, |i| solution[i])
        });

        // Measure the residuals, and grow the domain beyond the points.
        let Residuals { rms_mm, max_mm, worst } = residuals(samples, &sag);
        let margin = (max - min) * DOMAIN_MARGIN;
        let patch = PolynomialPatch { sag, domain: Rect { min: min - margin, max: max + margin } };
        Ok(SurfaceFit { patch, points, rms_mm, max_mm, worst, condition: largest / smallest })
    }
}

/// A surface that was not fitted to `points_mm`, and how well it goes through them.
pub(super) fn given(patch: PolynomialPatch, points_mm: &[DVec3]) -> SurfaceFit {
    let Residuals { rms_mm, max_mm, worst } = residuals(Samples { points_mm, weights: &[] }, &patch.sag);
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
fn triangle(samples: Samples<'_>, powers: &[(usize, usize)], centre: DVec2, scale: DVec2) -> DMatrix<f64> {
    // Factor block by block.
    let columns = powers.len() + 1;
    let rows = BLOCK.max(4 * columns);
    let triangles: Vec<DMatrix<f64>> = samples
        .points_mm
        .par_chunks(rows)
        .enumerate()
        .map(|(number, block)| {
            let mut a = DMatrix::zeros(block.len(), columns);
            for (row, p) in block.iter().enumerate() {
                // Fill a row with the powers of the scaled coordinates, and z, times the root of the weight.
                let root = samples.weight(number * rows + row).sqrt();
                let [x, y] = ((p.truncate() - centre) / scale).to_array();
                let mut power = [[1.0; MAX_DEGREE + 1]; 2];
                for i in 1..=MAX_DEGREE {
                    power[0][i] = power[0][i - 1] * x;
                    power[1][i] = power[1][i - 1] * y;
                }
                for (column, &(m, n)) in powers.iter().enumerate() {
                    a[(row, column)] = root * (power[0][m] * power[1][n]);
                }
                a[(row, powers.len())] = root * p.z;
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

fn residuals(samples: Samples<'_>, sag: &Poly2) -> Residuals {
    let blocks: Vec<(f64, f64, usize)> = samples
        .points_mm
        .par_chunks(BLOCK)
        .enumerate()
        .map(|(block, points)| {
            let residuals = points.iter().map(|p| p.z - sag.value(p.x, p.y)).enumerate();
            residuals.fold((0.0, 0.0, block * BLOCK), |(sum, max, worst), (k, r): (usize, f64)| {
                let (max, worst) = if r.abs() > max { (r.abs(), block * BLOCK + k) } else { (max, worst) };
                (sum + samples.weight(block * BLOCK + k) * (r * r), max, worst)
            })
        })
        .collect();
    let (sum, max_mm, worst) = blocks.iter().fold((0.0, 0.0, 0), |(sum, max, worst): (f64, f64, usize), b| {
        let (max, worst) = if b.1 > max { (b.1, b.2) } else { (max, worst) };
        (sum + b.0, max, worst)
    });
    // Weights have the mean 1.
    Residuals { rms_mm: (sum / samples.points_mm.len() as f64).sqrt(), max_mm, worst }
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
#[path = "fit_tests.rs"]
mod tests;
