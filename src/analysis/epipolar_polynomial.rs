//! Where the other half sees what a pixel looks at, at any depth, as one polynomial a half: for programs that draw epipolar
//! lines and have no prism to trace.

use super::half_image::HalfFrame;
use crate::geom::Pose;
use crate::num::{chebyshev, lsq};
use crate::scene::{BoardSpec, Scene};
use crate::system::System;
use crate::system::aim::Aimer;
use crate::vision::half::Half;
use glam::{DVec2, DVec3};
use nalgebra::DMatrix;
use rayon::prelude::*;

/// Highest degree in both image coordinates together, and in the inverse depth.
const DEGREES: [usize; 2] = [6, 4];
/// Points that are traced, along the columns, the rows and the inverse depth of a half.
const POINTS: [usize; 3] = [9, 9, 6];
/// The nearest depth as a share of the nearest board that a scene names, and the farthest as a multiple of the farthest.
const BEYOND: [f64; 2] = [0.6, 4.0];

/// The polynomial of one half: with s and t from -1 to 1 over the half's columns and rows, and w from -1 to 1 over the inverse
/// depth from the farthest to the nearest, the point that the pixel sees at that depth lies in the other half at the pixel's
/// own position plus sum of c T_i(s) T_j(t) T_k(w).
#[derive(Debug, Clone, PartialEq)]
pub struct EpipolarPolynomial {
    /// First column of the half in the picture, and its size, in px.
    pub frame: HalfFrame,
    /// First column of the other half.
    pub other_first_column: usize,
    /// Nearest and farthest depth: distance from the camera's position along z, in mm.
    pub depths_mm: [f64; 2],
    /// i, j and k of each term.
    pub terms: Vec<[usize; 3]>,
    /// c of each term, in px: along the columns and along the rows.
    pub coefficients_px: Vec<DVec2>,
    /// The longest that it misses one of the points that were traced, in px.
    pub misfit_px: f64,
}

/// A traced point: its place in [-1, 1]^3, and where the other half sees it less where its own does, each from its half's origin, in
/// px.
struct MatchedPoint {
    at: [f64; 3],
    shift_px: DVec2,
}

/// The polynomials of the left and the right half; `None` of a half where too few rays are seen by both.
pub fn epipolar_polynomials(scene: &Scene, system: &System) -> [Option<EpipolarPolynomial>; 2] {
    // Choose the depths, evenly in their inverse.
    let own = scene.board.world_from_board.translation_mm.z - scene.camera.position_mm.z;
    let named = || scene.analysis.depths_mm.iter().copied().chain([own]);
    let near = BEYOND[0] * named().fold(f64::INFINITY, f64::min);
    let far = BEYOND[1] * named().fold(0.0, f64::max);
    let w = chebyshev::points(POINTS[2]);

    // Trace a grid of each half to a facing board at each depth, and back through the other side.
    let at_depth = |w: &f64| {
        let depth_mm = 2.0 / ((1.0 + w) / near + (1.0 - w) / far);
        let centre_mm = scene.camera.position_mm + DVec3::Z * depth_mm;
        let board = BoardSpec { world_from_board: Pose { translation_mm: centre_mm, ..Pose::IDENTITY }, ..scene.board };
        let facing = system.with_board(&board);
        let aimer = Aimer::new(&facing);
        Half::BOTH.map(|half| matched(&facing, &aimer, half, *w))
    };
    let traced: Vec<[Vec<MatchedPoint>; 2]> = w.par_iter().map(at_depth).collect();

    // Fit each half.
    [0, 1].map(|k| {
        let points: Vec<&MatchedPoint> = traced.iter().flat_map(|halves| &halves[k]).collect();
        let [frame, other] = [k, 1 - k].map(|k| HalfFrame::new(system, Half::BOTH[k]));
        let (terms, coefficients_px, misfit_px) = fit(&points)?;
        let other_first_column = other.first_column;
        Some(EpipolarPolynomial {
            frame,
            other_first_column,
            depths_mm: [near, far],
            terms,
            coefficients_px,
            misfit_px,
        })
    })
}

/// The points of a grid of `half` that both halves of `facing` see, in the picture or beyond its border.
fn matched(facing: &System, aimer: &Aimer<'_>, half: Half, w: f64) -> Vec<MatchedPoint> {
    let frame = HalfFrame::new(facing, half);
    let other = HalfFrame::new(facing, if half == Half::Left { Half::Right } else { Half::Left });
    let [columns, rows] = [POINTS[0], POINTS[1]].map(chebyshev::points);
    let grid = columns.iter().flat_map(|s| rows.iter().map(move |t| [*s, *t]));
    let point = |[s, t]: [f64; 2]| {
        let half_px = 0.5 * (DVec2::new(s, t) + 1.0) * frame.size_px;
        let hit = facing.trace(frame.full(half_px)).ok().filter(|hit| hit.side == frame.side())?;
        // The other half sees it at about the same place.
        let near = other.full(half_px);
        let seen = other.own(aimer.aim_only_from(hit.board_mm, other.side(), near).ok()?);
        Some(MatchedPoint { at: [s, t, w], shift_px: seen - half_px })
    };
    grid.filter_map(point).collect()
}

/// The terms, their coefficients, and the longest miss; `None` where the points do not fix them.
fn fit(points: &[&MatchedPoint]) -> Option<(Vec<[usize; 3]>, Vec<DVec2>, f64)> {
    let all = (0..=DEGREES[0]).flat_map(|i| (0..=DEGREES[0] - i).map(move |j| (i, j)));
    let terms: Vec<[usize; 3]> = all.flat_map(|(i, j)| (0..=DEGREES[1]).map(move |k| [i, j, k])).collect();
    let bases: Vec<[Vec<f64>; 3]> = points.iter().map(|point| point.at.map(chebyshev_values)).collect();
    let value = |r: usize, c: usize| (0..3).map(|axis| bases[r][axis][terms[c][axis]]).product::<f64>();
    let a = DMatrix::from_fn(points.len(), terms.len(), value);
    let b = DMatrix::from_fn(points.len(), 2, |r, axis| points[r].shift_px[axis]);
    let x = lsq::linear(&a, &b).ok()?;
    let rest = a * &x - b;
    let misfit_px = rest.row_iter().map(|row| row.norm()).fold(0.0, f64::max);
    Some((terms, x.row_iter().map(|row| DVec2::new(row[0], row[1])).collect(), misfit_px))
}

/// T_0 to T_n at `x`, n the highest degree of all.
fn chebyshev_values(x: f64) -> Vec<f64> {
    let mut values = vec![1.0, x];
    while values.len() <= DEGREES[0].max(DEGREES[1]) {
        values.push(2.0 * x * values[values.len() - 1] - values[values.len() - 2]);
    }
    values
}

impl EpipolarPolynomial {
    /// Where the other half sees what `half_px` sees at `depth_mm`, in the other half's own px.
    pub fn other_px(&self, half_px: DVec2, depth_mm: f64) -> DVec2 {
        let place = half_px / self.frame.size_px * 2.0 - 1.0;
        let [near, far] = self.depths_mm.map(f64::recip);
        let at = [place.x, place.y, (2.0 / depth_mm - near - far) / (near - far)].map(chebyshev_values);
        let term = |t: &[usize; 3]| (0..3).map(|axis| at[axis][t[axis]]).product::<f64>();
        half_px + self.terms.iter().zip(&self.coefficients_px).map(|(t, c)| *c * term(t)).sum::<DVec2>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{scene, system};

    const SCENE: &str = "name = \"pair\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = 480\nheight_px = 270\n\
        pixel_pitch_um = 22.0\n[prism]\nkind = \"flat\"\nindex = 1.48\nridge_distance_mm = 78.472\nthickness_mm = 8.545\n\
        [board]\ncolumns = 41\nrows = 41\nsquare_mm = 20.0\nposition_mm = [0.0, 0.0, 1000.0]\n\
        [analysis]\ndepths_mm = [600.0, 2000.0]\n";

    #[test]
    fn the_polynomial_is_where_the_rays_of_other_depths_lead() {
        let scene = scene::parse(SCENE, "test", None).unwrap_or_else(|problem| panic!("{problem}"));
        let built = system::build(&scene).unwrap();
        let [left, right] =
            epipolar_polynomials(&scene, &built).map(|found| found.expect("both halves see the boards"));
        for depth_mm in [470.0, 1234.0, 5678.0] {
            let mut board = scene.board;
            board.world_from_board.translation_mm.z = scene.camera.position_mm.z + depth_mm;
            let facing = built.with_board(&board);
            let aimer = Aimer::new(&facing);
            for half_px in [DVec2::new(13.0, 9.0), DVec2::new(120.5, 200.25), DVec2::new(231.0, 133.0)] {
                for (polynomial, half) in [(&left, Half::Left), (&right, Half::Right)] {
                    let frame = HalfFrame::new(&facing, half);
                    let hit = facing.trace(frame.full(half_px)).unwrap();
                    let seen = aimer.aim(hit.board_mm, hit.side.other()).unwrap();
                    let exact = seen - DVec2::new(polynomial.other_first_column as f64, 0.0);
                    let miss = polynomial.other_px(half_px, depth_mm).distance(exact);
                    assert!(miss < 4.0 * polynomial.misfit_px + 1e-3, "{miss} px at {half_px}, {depth_mm} mm");
                }
            }
        }
        assert!(left.misfit_px < 0.01, "{}", left.misfit_px);
    }
}
