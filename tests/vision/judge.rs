//! A detection against the truth.

use crate::common::board::Scene;
use biprism::vision::Detection;
use glam::{DVec2, IVec2};

/// Errors of a detection against the truth.
#[derive(Debug)]
pub(crate) struct Errors {
    pub(crate) found: usize,
    /// Sufficiently visible corners that are not in the answer.
    pub(crate) missing: usize,
    /// Corners of the answer that are none, or whose index does not fit the others'.
    pub(crate) wrong: usize,
    pub(crate) rms: f64,
    pub(crate) max: f64,
    pub(crate) bias: DVec2,
}

/// A corner is sufficiently visible when its ring (4.5 px and the rough position's error) lies in the picture and so
/// does half its window.
const RING_PX: f64 = 5.0;

pub(crate) fn judge(scene: &Scene, detection: &Detection) -> Errors {
    let truth = scene.corners();
    let edge = DVec2::new(scene.width as f64, scene.height as f64);
    let mut errors = Vec::new();
    let mut wrong = 0;
    // Column and row of the truth are an integer rotation and shift of those of the answer.
    let mut pairs = Vec::new();
    for corner in &detection.corners {
        let nearest = truth
            .iter()
            .min_by(|a, b| a.1.distance(corner.position_px).total_cmp(&b.1.distance(corner.position_px)))
            .expect("a scene has corners");
        if nearest.1.distance(corner.position_px) > 1.0 {
            wrong += 1;
            continue;
        }
        errors.push(corner.position_px - nearest.1);
        pairs.push((IVec2::from_array(corner.index), IVec2::from_array(nearest.0)));
    }
    let fits = |column: IVec2, row: IVec2| {
        let shift = pairs.first().map_or(IVec2::ZERO, |(a, b)| *b - column * a.x - row * a.y);
        pairs.iter().filter(|(a, b)| *b == column * a.x + row * a.y + shift).count()
    };
    let turns = [IVec2::X, IVec2::Y, IVec2::NEG_X, IVec2::NEG_Y];
    let right = turns.iter().map(|&t| fits(t, t.perp())).max().unwrap_or(0);
    wrong += pairs.len() - right;
    let missing = truth
        .iter()
        .filter(|(index, p)| {
            p.min_element() > RING_PX && (edge - *p).min_element() > RING_PX && scene.visible(*index) > 0.52
        })
        .filter(|(index, _)| scene.spacing(*index) > 10f64.max(6.3 * scene.sigma_px))
        .filter(|(_, p)| !detection.corners.iter().any(|c| c.position_px.distance(*p) < 1.0))
        .count();
    let n = errors.len().max(1) as f64;
    Errors {
        found: detection.corners.len(),
        missing,
        wrong,
        rms: (errors.iter().map(|e| e.length_squared()).sum::<f64>() / n).sqrt(),
        max: errors.iter().map(|e| e.length()).fold(0.0, f64::max),
        bias: errors.iter().sum::<DVec2>() / n,
    }
}

/// The Cramer-Rao bound of a corner: variances (x, y) of its position, in px^2, per unit variance of a pixel, when the
/// directions of both edges and the six numbers of the light are unknown and the bend and the blur are known.
///
/// Straight edges under a Gaussian and a square pixel, whose mean is taken by 6 x 6 points; derivatives by differences.
pub(crate) fn bound(scene: &Scene, index: [i32; 2], half: f64) -> [f64; 2] {
    let at = |x: f64, y: f64| {
        scene.image(DVec2::new(f64::from(index[0]) + x, f64::from(index[1]) + y)).expect("in the picture")
    };
    let corner = at(0.0, 0.0);
    let steps = glam::DMat2::from_cols(0.5 * (at(1.0, 0.0) - at(-1.0, 0.0)), 0.5 * (at(0.0, 1.0) - at(0.0, -1.0)));
    let inverse = steps.inverse();
    let normal = |t: DVec2| libm::atan2(-t.x, t.y);
    let angles = [normal(steps.x_axis), normal(steps.y_axis)];
    let contrast = 0.5 * (scene.levels[1] - scene.levels[0]);
    // p[0..2]: corner, p[2..4]: angles.
    let pattern = |pixel: DVec2, p: [f64; 4]| {
        let n = 6;
        let sum: f64 = (0..n * n)
            .map(|k| {
                let sub = DVec2::new(f64::from(k % n) + 0.5, f64::from(k / n) + 0.5) / f64::from(n) - 0.5;
                let r = pixel + sub - DVec2::new(p[0], p[1]);
                let edge = |angle: f64| {
                    let (sin, cos) = libm::sincos(angle);
                    libm::erf(DVec2::new(cos, sin).dot(r) / scene.sigma_px * std::f64::consts::FRAC_1_SQRT_2)
                };
                edge(p[2]) * edge(p[3])
            })
            .sum();
        sum / f64::from(n * n)
    };
    let mut fisher = nalgebra::SMatrix::<f64, 10, 10>::zeros();
    let reach = half * (steps.x_axis.abs() + steps.y_axis.abs()) + 1.0;
    let (low, high) = ((corner - reach).floor(), (corner + reach).ceil());
    for j in low.y as i32..high.y as i32 {
        for i in low.x as i32..high.x as i32 {
            let pixel = DVec2::new(f64::from(i) + 0.5, f64::from(j) + 0.5);
            let local = inverse * (pixel - corner);
            if local.abs().max_element() > half {
                continue;
            }
            let p = [corner.x, corner.y, angles[0], angles[1]];
            let value = pattern(pixel, p);
            let by = |k: usize, h: f64| {
                let (mut a, mut b) = (p, p);
                a[k] += h;
                b[k] -= h;
                contrast * (pattern(pixel, a) - pattern(pixel, b)) / (2.0 * h)
            };
            let r = pixel - corner;
            let gradient = nalgebra::SVector::<f64, 10>::from_row_slice(&[
                by(0, 1e-3),
                by(1, 1e-3),
                by(2, 1e-4),
                by(3, 1e-4),
                1.0,
                r.x,
                r.y,
                value,
                value * r.x,
                value * r.y,
            ]);
            fisher += gradient * gradient.transpose();
        }
    }
    let inverse = fisher.cholesky().expect("a corner is determined").inverse();
    [inverse[(0, 0)], inverse[(1, 1)]]
}
