//! The transfer curve of a picture that states none, found by what the corner fit leaves.
//!
//! An edge under a blur is as wide on its bright side as on its dark one, in light. Read by another curve it is not, and the
//! fit of a corner leaves the more of it the farther the curve is off. So the board is measured under each curve, and
//! the one of the least median of residual over contrast is taken. Some fifty corners are enough for that.

use crate::num::stats::quantile;
use crate::raster::Raster;
use crate::raster::transfer::{Transfer, by_value, decoded};
use crate::vision::half::{Half, HalfImage};
use crate::vision::{Corner, Settings, detect};
use glam::DVec2;

/// Exponents of light = value^g that are tried, besides linear (1) and sRGB.
const EXPONENTS: [f64; 3] = [1.6, 2.2, 2.8];
/// A fitted exponent lies within this of those that were tried.
const BEYOND: f64 = 0.3;
/// A curve of a name is preferred to a fitted one that leaves no less than this share of what it leaves.
const AS_GOOD: f64 = 0.98;
/// From so many of its own standard errors on the choice is called sure.
const SURE: f64 = 3.0;
/// A corner of one measurement is that of another within this, in px.
const SAME_PX: f64 = 1.0;

/// A transfer curve by which stored values, on a scale to 1, become light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Curve {
    /// One of those that have a name.
    Named(Transfer),
    /// Light = value^exponent.
    Power(f64),
}

impl Curve {
    /// Its name, as in a picture's metadata.
    pub fn name(self) -> String {
        match self {
            Self::Named(transfer) => transfer.name().to_owned(),
            Self::Power(exponent) => format!("power {exponent:.2}"),
        }
    }

    /// The light of stored values.
    fn light(self, stored: &Raster<f32>) -> Raster<f32> {
        match self {
            Self::Named(Transfer::Linear) => stored.clone(),
            Self::Named(transfer) => by_value(stored, |value| transfer.decode(f64::from(value)) as f32),
            Self::Power(exponent) => decoded(stored, exponent),
        }
    }
}

/// The curve that was chosen, and how it did.
#[derive(Debug, Clone, PartialEq)]
pub struct TransferChoice {
    /// The curve.
    pub curve: Curve,
    /// Median over the corners of residual over contrast under it.
    pub residual: f64,
    /// The next best of linear, sRGB and a power; the chosen one where no other shows three quarters of its corners.
    pub next: Curve,
    /// Residual over contrast under that one.
    pub next_residual: f64,
    /// By how many of its own standard errors the median of their ratio, corner by corner, differs from 1.
    pub standard_errors: f64,
}

impl TransferChoice {
    /// Whether the picture tells the chosen curve from the next best.
    pub fn is_sure(&self) -> bool {
        self.standard_errors >= SURE
    }

    /// The choice in words.
    pub fn words(&self) -> String {
        if self.next == self.curve {
            return format!(
                "the file states no transfer curve; read as {}, the only one of those tried that shows most corners of the board",
                self.curve.name()
            );
        }
        let sure =
            if self.is_sure() { "" } else { "; the picture does not tell them apart surely: state it with --transfer" };
        format!(
            "the file states no transfer curve; read as {}, under which the fit leaves {:.2} % of the contrast ({}: {:.2} %, {:.0} \
             standard errors){sure}",
            self.curve.name(),
            100.0 * self.residual,
            self.next.name(),
            100.0 * self.next_residual,
            self.standard_errors
        )
    }
}

/// A curve, and the corners that were measured under it.
struct Trial {
    curve: Curve,
    corners: Vec<Corner>,
    residual: f64,
}

/// What is in the picture under a curve; nothing where there is no board.
fn trial(stored: &Raster<f32>, curve: Curve, halves: bool) -> Option<Trial> {
    let light = curve.light(stored);
    let settings = Settings::default();
    let corners: Vec<Corner> = if halves {
        let of = |half: Half| {
            let half = HalfImage::cut(&light, half);
            let first = DVec2::new(half.first_column as f64, 0.0);
            let moved = move |c: Corner| Corner { position_px: c.position_px + first, ..c };
            detect(&half.image, None, &settings).corners.into_iter().map(moved)
        };
        Half::BOTH.into_iter().flat_map(of).collect()
    } else {
        detect(&light, None, &settings).corners
    };
    let shares: Vec<f64> = corners.iter().map(|c| c.residual / c.contrast).collect();
    let residual = quantile(&shares, 0.5)?;
    residual.is_finite().then_some(Trial { curve, corners, residual })
}

/// The median of the logarithm of the ratio of both residuals, corner by corner, in its own standard errors.
fn told_apart(a: &Trial, b: &Trial) -> f64 {
    let ratio = |c: &Corner| {
        let other = b.corners.iter().find(|o| o.position_px.distance(c.position_px) < SAME_PX)?;
        Some(libm::log((other.residual / other.contrast) / (c.residual / c.contrast)))
    };
    let ratios: Vec<f64> = a.corners.iter().filter_map(ratio).filter(|r| r.is_finite()).collect();
    let [Some(low), Some(middle), Some(high)] = [0.25, 0.5, 0.75].map(|q| quantile(&ratios, q)) else { return 0.0 };
    let error = 0.93 * (high - low) / (ratios.len() as f64).sqrt();
    if middle <= 0.0 { 0.0 } else { (middle / error.max(1e-3 * middle)).min(999.0) }
}

/// The power between and about those that were tried whose residual is the least, by the parabola through the best and its
/// neighbours.
fn fitted(stored: &Raster<f32>, powers: &[Trial], halves: bool) -> Option<Trial> {
    let exponent = |t: &Trial| if let Curve::Power(g) = t.curve { g } else { 1.0 };
    let best = (0..powers.len()).min_by(|&a, &b| powers[a].residual.total_cmp(&powers[b].residual))?;
    let middle = best.clamp(1, powers.len().checked_sub(2)?.max(1));
    let [a, b, c] = [middle.checked_sub(1)?, middle, middle + 1].map(|k| powers.get(k));
    let [(x0, y0), (x1, y1), (x2, y2)] = [a?, b?, c?].map(|t| (exponent(t), t.residual * t.residual));
    let (d0, d2) = ((y0 - y1) / (x0 - x1), (y2 - y1) / (x2 - x1));
    let bend = (d2 - d0) / (x2 - x0);
    if bend <= 0.0 {
        return None;
    }
    let place = 0.5 * (x0 + x1 - d0 / bend);
    let [low, high] = [exponent(powers.first()?) - BEYOND, exponent(powers.last()?) + BEYOND];
    trial(stored, Curve::Power(place.clamp(low, high)), halves)
}

/// Columns and rows of corners that are measured under each curve, at most: some fifty tell curves apart.
const SOME: i32 = 7;

/// The part of the picture around the middle corners of its largest board, as sRGB shows it; `None` where that shows none, or where
/// the part is most of what is looked at.
fn part(stored: &Raster<f32>, halves: bool) -> Option<Raster<f32>> {
    // Find the board, in one of the halves.
    let light = Curve::Named(Transfer::Srgb).light(stored);
    let settings = Settings::default();
    let (first_column, found) = if halves {
        let of = |half: Half| {
            let half = HalfImage::cut(&light, half);
            (half.first_column, detect(&half.image, None, &settings).corners)
        };
        let [left, right] = Half::BOTH.map(of);
        if right.1.len() > left.1.len() { right } else { left }
    } else {
        (0, detect(&light, None, &settings).corners)
    };

    // Take the corners about the one nearest to the middle of them.
    let middle = found.iter().map(|c| c.position_px).sum::<DVec2>() / found.len().max(1) as f64;
    let distance = |c: &Corner| c.position_px.distance(middle);
    let centre = found.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    let near = |c: &&Corner| (0..2).all(|k| (c.index[k] - centre.index[k]).abs() <= SOME / 2);
    let some: Vec<&Corner> = found.iter().filter(near).collect();

    // Cut them out with a step around them, and leave it where that saves little.
    let step_px =
        some.iter().filter(|c| c.index != centre.index).map(|c| distance_between(c, centre)).reduce(f64::min)?;
    let place = |c: &&Corner| c.position_px + DVec2::new(first_column as f64, 0.0);
    let low = some.iter().map(place).reduce(DVec2::min)? - 1.5 * step_px;
    let high = some.iter().map(place).reduce(DVec2::max)? + 1.5 * step_px;
    let [x, y] = low.max(DVec2::ZERO).to_array().map(|v| v as usize);
    let [right, bottom] = [(high.x as usize).min(stored.width()), (high.y as usize).min(stored.height())];
    (2 * (right - x) * (bottom - y) < stored.data().len()).then(|| {
        let data = (y..bottom).flat_map(|row| stored.row(row)[x..right].iter().copied());
        Raster::from_data(right - x, bottom - y, data.collect())
    })
}

fn distance_between(a: &Corner, b: &Corner) -> f64 {
    a.position_px.distance(b.position_px)
}

/// Chooses among linear, sRGB and a fitted power by what the corner fit leaves of `stored` values, on a scale to 1; of both
/// halves of the picture, or of the whole. `None` where no curve shows a board.
pub(crate) fn choose(stored: &Raster<f32>, halves: bool) -> Option<TransferChoice> {
    match part(stored, halves) {
        Some(part) => of_boards(&part, false),
        None => of_boards(stored, halves),
    }
}

/// The choice by the boards of the whole of `stored`, or of both its halves.
fn of_boards(stored: &Raster<f32>, halves: bool) -> Option<TransferChoice> {
    // Measure under each curve; only those that show most of the corners count.
    let srgb = trial(stored, Curve::Named(Transfer::Srgb), halves);
    let linear = trial(stored, Curve::Named(Transfer::Linear), halves);
    let powers = EXPONENTS.into_iter().filter_map(|g| trial(stored, Curve::Power(g), halves));
    let first =
        linear.as_ref().map(|t| Trial { curve: Curve::Power(1.0), corners: t.corners.clone(), residual: t.residual });
    let powers: Vec<Trial> = first.into_iter().chain(powers).collect();
    let power = fitted(stored, &powers, halves).into_iter().chain(powers).filter(|t| t.curve != Curve::Power(1.0));
    let power = power.min_by(|a, b| a.residual.total_cmp(&b.residual));
    let mut all: Vec<Trial> = [linear, srgb, power].into_iter().flatten().collect();
    let most = all.iter().map(|t| t.corners.len()).max()?;
    all.retain(|t| 4 * t.corners.len() >= 3 * most);

    // Take the least, and a curve of a name where it is as good as the fitted one.
    all.sort_by(|a, b| a.residual.total_cmp(&b.residual));
    if let [first, second, ..] = &all[..]
        && matches!(first.curve, Curve::Power(_))
        && (first.residual > AS_GOOD * second.residual || told_apart(first, second) < SURE)
    {
        all.swap(0, 1);
    }
    let (best, next) = (all.first()?, all.get(1).or(all.first())?);
    Some(TransferChoice {
        curve: best.curve,
        residual: best.residual,
        next: next.curve,
        next_residual: next.residual,
        standard_errors: if next.curve == best.curve { 999.0 } else { told_apart(best, next) },
    })
}

/// The light of stored values by the curve that was chosen.
pub fn light(stored: &Raster<f32>, choice: &TransferChoice) -> Raster<f32> {
    choice.curve.light(stored)
}
