//! How far the corners of a lattice lie from any smooth board, against what their fits claim: the check of the covariances
//! from outside.
//!
//! A fit knows the noise that its pixels show. What is wrong with its model, a curve or a blur that is not the picture's,
//! values that were rounded alike along an edge, moves it without showing so much. Neighbours are moved otherwise, and a board
//! is smooth: so a homography of column and row, bent by the polynomial that explains the corners best, leaves what the
//! fits did not know of. (A fit may also claim too much: a misfit that is alike on both sides of every edge moves no corner.) The
//! covariances are multiplied by its mean square in their own unit (Birge's ratio: R. T. Birge,
//! Phys. Rev. 40 (1932) 207) where that is not by chance.

use super::detection::Corner;
use crate::num::stats::quantile;
use glam::{DMat2, DVec2};
use nalgebra::{DMatrix, SMatrix};

/// Total degrees of the polynomial that are tried.
const DEGREES: std::ops::RangeInclusive<usize> = 1..=7;
/// Corners for a term of the polynomial at least.
const CORNERS_A_TERM: f64 = 1.12;
/// No ratio is below this: what moves all corners of a lattice alike does not show in it.
const LEAST_RATIO: f64 = 2e-3;
/// The ratio is believed when chance makes it as seldom as a normal deviate of this size, and one below 1 from a smaller one
/// on where the edges are known to be other than a Gaussian's.
const SURE: f64 = 4.0;
const LIKELY: f64 = 2.326;
/// The median of chi-square of two degrees of freedom, over 2.
const MEDIAN: f64 = std::f64::consts::LN_2;
/// A corner whose squared distance over 2 is above this against its fellows' has moved by itself: by chance one in 10^6 has.
const ALONE: f64 = 14.0;
/// Errors are left alike by polynomials of any degree. Where each degree leaves less than this share of what the one before it
/// leaves, all of it may be a bend that none of them follows, and tells nothing of the corners.
const SETTLED: f64 = 0.5;
/// Degrees of freedom from which on such a fall is no chance; where fewer are left, it is to less than this share.
const TELLING: f64 = 20.0;
const SETTLED_FEW: f64 = 0.15;
/// Where fewer are left, a degree is believed that leaves less than what the one before it does by more than chance does once in ten
/// times.
const SELDOM: f64 = 1.282;
/// What a misfit that is alike at all corners hides from the ratio: the homography and the first degrees take it, as if it were so
/// many degrees of freedom more, each with the mean square of those that are seen. Of little weight on a board of many corners;
/// nine hide most of theirs.
const HIDDEN: f64 = 12.0;
/// How often corners that moved by themselves are sought.
const ROUNDS: usize = 3;
/// No position is known better than this, in px: what a fit without noise leaves.
const LEAST_SIGMA_PX: f64 = 2e-5;

/// Multiplies the covariances by what the lattice shows against them, all alike, and those of single corners that moved beyond
/// that. `other` says that the picture's edges were found to be other than the model's: they lean, or their blur is no Gaussian.
pub(super) fn hold_against_lattice(corners: &mut [Corner], other: bool) {
    let Some(seen) = indices_on_plane(corners) else { return };

    // Take the smooth board that explains the corners best, and again without those that moved by themselves.
    let mut counts = vec![true; corners.len()];
    let (mut best, mut all) = (None, Vec::new());
    for _ in 0..ROUNDS {
        all = DEGREES.filter_map(|degree| left_over(corners, &seen, &counts, degree)).collect();
        let Some(scatter) = told_best(&all).map(|k| &all[k]) else { break };
        let before = counts;
        counts = scatter.halves.iter().map(|half| half / scatter.ratio.max(1.0) <= ALONE).collect();
        best = Some(scatter.clone());
        if counts == before {
            break;
        }
    }
    let Some(Scatter { ratio, freedom, halves }) = best else { return };

    // Scale all by the ratio, where chance does not make it. One that is too small by chance for a board of few terms is too small
    // whatever more terms explain.
    let unlikely = |s: &&Scatter| s.ratio < chance(s.freedom, if other { -LIKELY } else { -SURE });
    let small = all.iter().filter(unlikely).max_by(|a, b| a.freedom.total_cmp(&b.freedom)).map(Scatter::with_hidden);
    let settled = is_settled(&all, freedom);
    let wide = (ratio > chance(freedom, SURE)).then_some(ratio);
    if wide.is_some() && !settled {
        return;
    }
    let common = small.or(wide).map_or(1.0, |ratio| ratio.max(LEAST_RATIO));

    // Widen further the corners that have moved by themselves, by what they have.
    for (corner, half) in corners.iter_mut().zip(halves) {
        let own = half / common;
        corner.covariance_px2 *= common * if own > ALONE { own } else { 1.0 };
    }
}

/// What a smooth board leaves.
#[derive(Debug, Clone)]
struct Scatter {
    /// Mean square in the unit of the covariances.
    ratio: f64,
    /// Degrees of freedom.
    freedom: f64,
    /// Half the squared distance of each corner, in the unit of its covariance.
    halves: Vec<f64>,
}

impl Scatter {
    /// A ratio below 1, with what the terms hide beside it.
    fn with_hidden(&self) -> f64 {
        self.ratio * (1.0 + HIDDEN / self.freedom)
    }
}

/// The number of the polynomial that leaves least, of degrees that rise. Of those that leave few degrees of freedom each must leave less
/// than chance would of what the one before it leaves.
fn told_best(all: &[Scatter]) -> Option<usize> {
    let many = all.iter().take_while(|s| s.freedom >= TELLING).count();
    let best = (0..many.max(1).min(all.len())).min_by(|a, b| all[*a].ratio.total_cmp(&all[*b].ratio))?;
    let falls = |k: &usize, best: usize| all[*k].ratio < chance(all[*k].freedom, -SELDOM) * all[best].ratio;
    let more = (many.max(1)..all.len()).scan(best, |best, k| falls(&k, *best).then(|| *best = k).map(|()| k));
    Some(more.last().unwrap_or(best))
}

/// Whether what is left is no part of a bend that the polynomials do not follow.
fn is_settled(all: &[Scatter], freedom: f64) -> bool {
    let share = if freedom < TELLING { SETTLED_FEW } else { SETTLED };
    all.len() < 2 || all.windows(2).any(|pair| pair[1].ratio > share * pair[0].ratio)
}

/// The covariance, but no less than rounding.
fn covariance(corner: &Corner) -> DMat2 {
    corner.covariance_px2 + DMat2::from_diagonal(DVec2::splat(LEAST_SIGMA_PX * LEAST_SIGMA_PX))
}

/// What is left of the corners by a polynomial of total degree `degree` in the places of their indices, by least squares
/// weighted with their variances; `None` where it has nearly as many terms as there are corners.
fn left_over(corners: &[Corner], seen: &[DVec2], counts: &[bool], degree: usize) -> Option<Scatter> {
    // List the terms that the columns and rows can tell apart.
    let extent = |axis: usize| corners.iter().map(|c| c.index[axis]).max().map_or(0, |most| most.max(0) as usize);
    let (columns, rows) = (extent(0), extent(1));
    let terms: Vec<[usize; 2]> =
        (0..=degree.min(columns)).flat_map(|a| (0..=(degree - a).min(rows)).map(move |b| [a, b])).collect();
    let count = counts.iter().filter(|c| **c).count();
    if count < 9 || count as f64 <= CORNERS_A_TERM * terms.len() as f64 {
        return None;
    }

    // Solve, scaled to -1..1 so that the powers stay apart.
    let low = seen.iter().copied().reduce(DVec2::min)?;
    let high = seen.iter().copied().reduce(DVec2::max)?;
    let scaled = |p: DVec2| (p - 0.5 * (low + high)) / (0.5 * (high - low));
    let weights: Vec<f64> = corners
        .iter()
        .map(|c| {
            let v = covariance(c);
            (2.0 / (v.x_axis.x + v.y_axis.y)).sqrt()
        })
        .collect();
    let value = |i: usize, [a, b]: [usize; 2]| chebyshev(a, scaled(seen[i]).x) * chebyshev(b, scaled(seen[i]).y);
    let row = |i: usize| if counts[i] { weights[i] } else { 0.0 };
    let matrix = DMatrix::from_fn(corners.len(), terms.len(), |i, k| row(i) * value(i, terms[k]));
    let right = DMatrix::from_fn(corners.len(), 2, |i, k| row(i) * corners[i].position_px[k]);
    let factor = matrix.qr();
    let mut turned = right;
    factor.q_tr_mul(&mut turned);
    let solved = factor.r().solve_upper_triangular(&turned.rows(0, terms.len()))?;

    // Measure what is left in the unit of the covariances: by the median, which a few corners that moved do not change, where
    // there are enough for it.
    let halves: Vec<f64> = (0..corners.len())
        .map(|i| {
            let at = |k: usize| (0..terms.len()).map(|t| value(i, terms[t]) * solved[(t, k)]).sum::<f64>();
            let e = corners[i].position_px - DVec2::new(at(0), at(1));
            0.5 * e.dot(covariance(&corners[i]).inverse() * e)
        })
        .collect();
    let free = (count - terms.len()) as f64 / count as f64;
    let counted: Vec<f64> = halves.iter().zip(counts).filter(|(_, c)| **c).map(|(half, _)| *half).collect();
    let mean = counted.iter().sum::<f64>() / count as f64;
    let many = count >= 2 * terms.len() + 20;
    let typical = if many { quantile(&counted, 0.5)? / MEDIAN } else { mean };
    let ratio = typical / free;
    ratio.is_finite().then_some(Scatter { ratio, freedom: 2.0 * free * count as f64, halves })
}

/// The mean square of `freedom` normal deviates that is as seldom as the normal deviate `z` (Wilson and Hilferty's
/// approximation).
fn chance(freedom: f64, z: f64) -> f64 {
    let spread = 2.0 / (9.0 * freedom);
    let root = (1.0 - spread + z * spread.sqrt()).max(0.0);
    root * root * root
}

/// The polynomial of Chebyshev.
fn chebyshev(n: usize, x: f64) -> f64 {
    let (mut last, mut here) = (1.0, x);
    if n == 0 {
        return last;
    }
    for _ in 1..n {
        (last, here) = (here, 2.0 * x * here - last);
    }
    here
}

/// Where a homography sees column and row, in px: the direct linear transformation over all corners.
fn indices_on_plane(corners: &[Corner]) -> Option<Vec<DVec2>> {
    // Scale both sides to some 1 about 0.
    let n = corners.len() as f64;
    let index = |c: &Corner| DVec2::new(c.index[0].into(), c.index[1].into());
    let middle = |of: fn(&Corner) -> DVec2| corners.iter().map(of).sum::<DVec2>() / n;
    let (from, to) = (corners.iter().map(index).sum::<DVec2>() / n, middle(|c| c.position_px));
    let spread = |p: DVec2, of: &dyn Fn(&Corner) -> DVec2| {
        (corners.iter().map(|c| (of(c) - p).length_squared()).sum::<f64>() / n).sqrt()
    };
    let (s, t) = (spread(from, &index), spread(to, &|c| c.position_px));

    // Find the null vector of the equations.
    let mut normal = SMatrix::<f64, 9, 9>::zeros();
    for corner in corners {
        let (a, p) = ((index(corner) - from) / s, (corner.position_px - to) / t);
        for row in [
            [a.x, a.y, 1.0, 0.0, 0.0, 0.0, -p.x * a.x, -p.x * a.y, -p.x],
            [0.0, 0.0, 0.0, a.x, a.y, 1.0, -p.y * a.x, -p.y * a.y, -p.y],
        ] {
            let row = SMatrix::<f64, 9, 1>::from_row_slice(&row);
            normal += row * row.transpose();
        }
    }
    let eigen = normal.symmetric_eigen();
    let least = eigen.eigenvalues.imin();
    let h = eigen.eigenvectors.column(least);
    let place = |c: &Corner| {
        let a = (index(c) - from) / s;
        let w = h[6] * a.x + h[7] * a.y + h[8];
        DVec2::new(h[0] * a.x + h[1] * a.y + h[2], h[3] * a.x + h[4] * a.y + h[5]) / w * t + to
    };
    let seen: Vec<DVec2> = corners.iter().map(place).collect();
    seen.iter().all(|p| p.is_finite()).then_some(seen)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::Polarity;

    /// A board in perspective, bent, with errors of `told_px` and more where `off` says.
    fn lattice(columns: i32, rows: i32, told_px: f64, off: impl Fn(i32, i32) -> f64) -> Vec<Corner> {
        let mut state = 7u64;
        let mut deviate = || {
            // A sum of twelve uniform deviates.
            (0..12)
                .map(|_| {
                    state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                    (state >> 11) as f64 / (1u64 << 53) as f64
                })
                .sum::<f64>()
                - 6.0
        };
        let corner = |i: i32, j: i32, error: DVec2| {
            let (u, v) = (f64::from(i), f64::from(j));
            let w = 1.0 + 0.02 * u + 0.01 * v;
            let position_px =
                DVec2::new(40.0 * u + 3.0 * v + 0.1 * v * v, 38.0 * v - 2.0 * u + 0.08 * u * u * v) / w + error;
            Corner {
                position_px,
                index: [i, j],
                covariance_px2: DMat2::from_diagonal(DVec2::splat(told_px * told_px)),
                contrast: 0.8,
                residual: 0.01,
                polarity: Polarity::Main,
            }
        };
        let cells = (0..columns).flat_map(|i| (0..rows).map(move |j| (i, j)));
        cells.map(|(i, j)| corner(i, j, DVec2::new(deviate(), deviate()) * off(i, j))).collect()
    }

    fn told(corners: &[Corner]) -> f64 {
        let all: Vec<f64> = corners.iter().map(|c| c.covariance_px2.x_axis.x.sqrt()).collect();
        quantile(&all, 0.5).unwrap()
    }

    #[test]
    fn errors_as_told_change_nothing_and_larger_ones_widen() {
        for (columns, rows) in [(3, 3), (5, 4), (9, 6), (17, 13)] {
            let mut corners = lattice(columns, rows, 0.01, |_, _| 0.01);
            hold_against_lattice(&mut corners, false);
            assert!((told(&corners) - 0.01).abs() < 1e-12, "{columns} {rows}");
            // Ten times as far off as told: within a factor of two, as a ratio of four degrees of freedom allows.
            let mut corners = lattice(columns, rows, 0.001, |_, _| 0.01);
            hold_against_lattice(&mut corners, false);
            assert!((0.005..0.02).contains(&told(&corners)), "{columns} {rows} {}", told(&corners));
        }
    }

    /// Over nine columns exp(0.35 u) is to 1e-4 px no polynomial of degree 7: ten times the errors, and each degree less leaves ten
    /// times as much. The corners are as good as told all the same.
    #[test]
    fn a_bend_that_no_polynomial_follows_is_no_error() {
        let mut corners = lattice(9, 6, 1e-5, |_, _| 1e-5);
        for corner in &mut corners {
            let [u, v] = corner.index.map(f64::from);
            corner.position_px += DVec2::new(8.0 * libm::exp(0.35 * u), 5.0 * libm::exp(0.4 * v));
        }
        hold_against_lattice(&mut corners, false);
        assert!((told(&corners) - 1e-5).abs() < 1e-12, "{}", told(&corners));
    }

    /// A bend of a few px over three columns is of no low degree either, and nine corners do not tell it from errors: they are as good as
    /// told. Errors of a straight board that a polynomial that leaves two degrees of freedom happens to explain are errors all the same.
    #[test]
    fn nine_corners_tell_errors_from_a_bend() {
        let mut corners = lattice(3, 3, 1e-3, |_, _| 1e-3);
        for corner in &mut corners {
            let [u, v] = corner.index.map(f64::from);
            corner.position_px += DVec2::new(20.0 * u * u + 2.0 * u * u * v + 0.2 * u * u * v * v, 0.0);
        }
        hold_against_lattice(&mut corners, true);
        assert!((told(&corners) - 1e-3).abs() < 1e-12, "{}", told(&corners));

        // No errors but along x y^2, x^2 y and the like, which a board of third degree takes: by chance they have nearly none else.
        let pattern = [[1.0, -2.0, 1.0], [0.5, 0.0, -0.5], [-1.5, 2.0, -0.5]];
        let mut corners: Vec<Corner> = lattice(3, 3, 1e-3, |_, _| 0.0);
        for corner in &mut corners {
            let [u, v] = corner.index.map(|k| k as usize);
            corner.position_px = DVec2::new(40.0 * u as f64, 38.0 * v as f64) + 0.006 * pattern[v][u];
        }
        hold_against_lattice(&mut corners, true);
        assert!(told(&corners) > 2e-3, "{}", told(&corners));
    }

    #[test]
    fn a_corner_that_moved_alone_says_so_and_its_fellows_do_not() {
        let mut corners = lattice(9, 6, 0.01, |i, j| if (i, j) == (4, 2) { 0.5 } else { 0.01 });
        hold_against_lattice(&mut corners, false);
        let moved = corners.iter().find(|c| c.index == [4, 2]).unwrap();
        assert!(moved.covariance_px2.x_axis.x.sqrt() > 0.1, "{moved:?}");
        assert!((told(&corners) - 0.01).abs() < 1e-12);
    }
}
