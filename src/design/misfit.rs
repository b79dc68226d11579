//! Why a polynomial does not go through a cloud of points.

use super::fit::{SurfaceFit, coefficients, fit_powers};
use crate::num::bernstein::MAX_DEGREE;
use crate::num::powers::Powers;
use glam::DVec3;
use std::collections::BTreeMap;

/// What is asked of the fit of a cloud.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CloudFitInput<'a> {
    /// The points, in mm.
    pub points_mm: &'a [DVec3],
    /// Total degree.
    pub degree: usize,
    /// Which powers of y there are.
    pub powers: Powers,
    /// The largest residual that is taken, in mm.
    pub max_residual_mm: f64,
    /// The key of the surface and its file, for messages: "`prism.front` (front.csv)".
    pub name: &'a str,
}

/// What is wrong with a cloud, as far as its residuals tell.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Misfit {
    /// Two points over one another, by their numbers from 1.
    TwoSheets {
        /// The two points.
        numbers: [usize; 2],
        /// Their distance along z.
        apart_mm: f64,
    },
    /// Two smooth surfaces that meet in a line along y.
    Kink {
        /// Where the line is.
        x_mm: f64,
    },
    /// A few points far off a surface that the others lie on.
    Outliers {
        /// The points, the farthest first.
        worst: Vec<Outlier>,
        /// The largest residual of the others, in mm.
        rest_mm: f64,
    },
    /// The lowest degree that is enough.
    Degree(usize),
    /// Odd powers of y are needed.
    Asymmetric,
    /// None of these.
    Unknown,
}

/// A point that is far off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Outlier {
    /// Its number, from 0.
    pub(super) index: usize,
    /// Its distance along z from the surface of the others, in mm.
    pub(super) off_mm: f64,
}

/// Points by which a cloud is judged; of larger ones every n-th is taken, but for outliers.
const JUDGED: usize = 4000;
/// Places of two points are one when they differ by less than this share of the cloud's extent.
const SAME_PLACE: f64 = 1e-9;
/// An explanation must leave at most this share of the residual that it explains.
const EXPLAINED: f64 = 0.1;
/// Outliers are this many robust standard deviations off (1.4826 times the median of magnitudes)...
const OUTLYING: f64 = 8.0;
/// ... and no more than this share of the points.
const MOST_OUTLIERS: f64 = 0.1;
/// Rounds in which outliers are sought.
const ROUNDS: usize = 12;
/// Degrees above a fit's that are tried before any other explanation.
const FEW_DEGREES: usize = 4;
/// A kink turns the slope so much that, over the width of the cloud, it is this many times what one polynomial leaves.
const KINKED: f64 = 10.0;
/// Halvings by which the place of a kink is found.
const BISECTIONS: usize = 50;
/// A kink is at x = 0 when it is nearer than this share of the cloud's width.
const AT_ZERO: f64 = 1e-3;
/// Places at which a kink is sought.
const SPLITS: usize = 24;

/// Judges the cloud whose fit is off by more than is allowed.
pub(super) fn of(input: &CloudFitInput, fitted: &SurfaceFit) -> Misfit {
    let explained_mm = input.max_residual_mm.max(EXPLAINED * fitted.max_mm);
    let stride = input.points_mm.len().div_ceil(JUDGED).max(1);
    let some: Vec<DVec3> = input.points_mm.iter().copied().step_by(stride).collect();
    let leaves = |degree, powers| fit_powers(&some, degree, powers, None).map_or(f64::INFINITY, |f| f.max_mm);
    if let Some(found) = two_sheets(input.points_mm, explained_mm) {
        return found;
    }
    let determined = |degree: &usize| 2 * coefficients(*degree, input.powers) <= some.len();
    let enough = |degree: &usize| leaves(*degree, input.powers) <= input.max_residual_mm;
    let mut degrees = (input.degree + 1..=MAX_DEGREE).take_while(determined);
    // A few degrees more make up for a degree that is too low; more of them may follow a kink.
    if let Some(degree) = degrees.by_ref().take(FEW_DEGREES).find(enough) {
        return Misfit::Degree(degree);
    }
    if let Some(outliers) = outliers(input, explained_mm) {
        return outliers;
    }
    if let Some(x_mm) = kink(&some, input, fitted.max_mm, explained_mm) {
        return Misfit::Kink { x_mm };
    }
    if input.powers == Powers::EvenInY && leaves(input.degree, Powers::All) <= explained_mm {
        return Misfit::Asymmetric;
    }
    degrees.find(enough).map_or(Misfit::Unknown, Misfit::Degree)
}

/// Two points at one place whose heights differ, when there are many such pairs.
fn two_sheets(points_mm: &[DVec3], apart_mm: f64) -> Option<Misfit> {
    let extent = points_mm.iter().fold(0.0f64, |most, p| most.max(p.x.abs()).max(p.y.abs()));
    let cell = |value: f64| (value / (SAME_PLACE * extent)).round() as i64;
    let mut seen: BTreeMap<(i64, i64), usize> = BTreeMap::new();
    let mut pairs = 0;
    let mut first = None;
    for (k, p) in points_mm.iter().enumerate() {
        let other = *seen.entry((cell(p.x), cell(p.y))).or_insert(k);
        let apart = (p.z - points_mm[other].z).abs();
        if apart > apart_mm {
            pairs += 1;
            first = first.or(Some(Misfit::TwoSheets { numbers: [other + 1, k + 1], apart_mm: apart }));
        }
    }
    first.filter(|_| pairs as f64 > MOST_OUTLIERS * points_mm.len() as f64)
}

/// Where a cut along y leaves two parts that are each well fitted.
fn kink(points_mm: &[DVec3], input: &CloudFitInput, whole_mm: f64, explained_mm: f64) -> Option<f64> {
    let (min, max) = points_mm.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), p| (a.min(p.x), b.max(p.x)));
    let step = (max - min) / SPLITS as f64;
    let leaves = |cut: f64| {
        let [left, right] = [part(points_mm, input, &|x| x <= cut)?, part(points_mm, input, &|x| x >= cut)?];
        Some(left.max_mm.max(right.max_mm))
    };
    // A cut beside the kink leaves less than none does, and one at it the least: sought coarsely, then by thirds.
    let at = |x: f64| leaves(x).unwrap_or(f64::INFINITY);
    let cuts = (1..SPLITS).map(|k| min + step * k as f64).map(|x| (x, at(x)));
    let (best, least) = cuts.min_by(|a, b| a.1.total_cmp(&b.1))?;
    let (mut low, mut high) = (best - step, best + step);
    for _ in 0..ROUNDS {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if at(a) <= at(b) { high = b } else { low = a }
    }
    let cut = 0.5 * (low + high);
    let cut = if at(cut) <= least { cut } else { best };
    if at(cut) > explained_mm {
        return None;
    }
    // The kink is where the two parts meet, in the middle of their border.
    let [left, right] = [part(points_mm, input, &|x| x <= cut)?, part(points_mm, input, &|x| x >= cut)?];
    let y = points_mm.iter().map(|p| p.y).sum::<f64>() / points_mm.len() as f64;
    // Parts of a smooth surface have nearly one slope where they meet.
    let turn = left.patch.sag.gradient(cut, y).1 - right.patch.sag.gradient(cut, y).1;
    if turn.abs() * (max - min) < KINKED * whole_mm {
        return None;
    }
    let gap = |x: f64| left.patch.sag.value(x, y) - right.patch.sag.value(x, y);
    let (mut low, mut high) = (cut - step, cut + step);
    if gap(low) * gap(high) > 0.0 {
        return Some(cut);
    }
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if gap(low) * gap(middle) <= 0.0 { high = middle } else { low = middle }
    }
    let x_mm = 0.5 * (low + high);
    // A ridge that is as good as at 0 is at 0.
    Some(if x_mm.abs() < AT_ZERO * (max - min) { 0.0 } else { x_mm })
}

/// The fit of the points whose x is kept.
fn part(points_mm: &[DVec3], input: &CloudFitInput, keep: &dyn Fn(f64) -> bool) -> Option<SurfaceFit> {
    let part: Vec<DVec3> = points_mm.iter().copied().filter(|p| keep(p.x)).collect();
    fit_powers(&part, input.degree, input.powers, None).ok()
}

/// The points that are far off the surface through the others; `None` where these are many, or the others no surface.
fn outliers(input: &CloudFitInput, explained_mm: f64) -> Option<Misfit> {
    let points = input.points_mm;
    let mut kept = vec![true; points.len()];
    let mut off: Vec<f64> = Vec::new();
    let mut fitted = None;
    for _ in 0..ROUNDS {
        let rest: Vec<DVec3> = points.iter().zip(&kept).filter(|(_, kept)| **kept).map(|(p, _)| *p).collect();
        let found = fit_powers(&rest, input.degree, input.powers, None).ok()?;
        off = points.iter().map(|p| (p.z - found.patch.sag.value(p.x, p.y)).abs()).collect();
        let mut sizes = off.clone();
        let middle = sizes.len() / 2;
        let (_, median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
        // Points that are within what is allowed are none.
        let most = (OUTLYING * 1.4826 * *median).max(input.max_residual_mm);
        let next: Vec<bool> = off.iter().map(|off| *off <= most).collect();
        fitted = Some(found);
        if next == kept {
            break;
        }
        kept = next;
    }
    let mut outliers: Vec<Outlier> =
        (0..points.len()).filter(|k| !kept[*k]).map(|index| Outlier { index, off_mm: off[index] }).collect();
    let few = !outliers.is_empty() && outliers.len() as f64 <= MOST_OUTLIERS * points.len() as f64;
    outliers.sort_by(|a, b| b.off_mm.total_cmp(&a.off_mm));
    let rest_mm = fitted?.max_mm;
    (few && rest_mm <= explained_mm).then_some(Misfit::Outliers { worst: outliers, rest_mm })
}
