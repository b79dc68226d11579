//! The search for a blur that is no Gaussian: weights of its bumps (`blur_shape`) from what the fits of some corners leave near
//! their edges, by least squares over all of these at once.
//!
//! An Airy pattern, the disc of a lens out of focus, a square and motion along a line come out so, each family of lines with its own.
//! A picture whose Gaussian leaves no more than chance, or no more than the model's own error, keeps it.

use super::blur_shape::{BUMPS, BlurShape, PictureBlur};
use super::candidates::Candidates;
use super::column::{CHUNK, Column};
use super::corner_fit::{CornerFit, profiles};
use super::corner_model::Model;
use super::corner_site::CornerSite;
use super::edge_spread::{EdgeShape, SHARP_PX};
use super::equations::edge_models;
use super::motion::find_motion;
use super::pilot_fits::{EFFORT, PilotFit, fit_again, fit_pilots, squares};
use super::profile::{Profile, pairs};
use super::settings::Settings;
use super::strip::{EdgeModel, EdgeStrip, left_of, product};
use crate::num::simd::{Kernel, widest};
use nalgebra::{SMatrix, SVector};
use rayon::prelude::*;

/// Weights of a family: of what is alike to both sides of an edge, and of what is not.
const WEIGHTS: usize = 2 * BUMPS;
/// Corners that the weights are found from, and rounds of fits.
const PILOTS: usize = 12;
const ROUNDS: usize = 3;
/// Steps of distance in which the misfit is sought.
const BINS: usize = 16;
/// It is there where these explain so many times what chance would, and where it is larger than this share of the contrast:
/// what is left of the model's own error is smaller.
const SURE: f64 = 6.0;
const LEAST_MISFIT: f64 = 5e-4;
/// Pixels whose distances from an edge differ by less than this, in px, see much the same of a bump, which is six times as wide at least.
const PLACE_PX: f64 = 0.05;
/// Another shape is believed where it explains at least this share of the squares that the Gaussian leaves near the edges.
const BELIEVED: f64 = 0.2;
/// A weight's own standard deviation, before anything is seen of it, and the least share of the normal matrix that holds it.
const PRIOR: f64 = 0.3;
const HOLD: f64 = 1e-7;

/// Some pixels near an edge, as the fit of their corner leaves them.
struct Seen {
    distance: Column,
    /// A on the pixel's side of the other edge.
    contrast: Column,
    weight: Column,
    /// Picture less model.
    left: Column,
    /// On which side of the edge it is bright, 1 or -1.
    bright: Column,
}

impl Seen {
    #[inline(always)]
    fn new(pixels: &[Column; 5], model: &Model, edge: &EdgeModel<'_>) -> Self {
        let [distance, contrast, left] = left_of(pixels, model, edge);
        let [_, _, _, weight, sign] = pixels;
        let bright = sign.map(|sign| sign * model.light[3].signum());
        Self { distance, contrast, weight: *weight, left, bright }
    }
}

/// Pixels gathered by their distances towards bright: sums of w A^2 and of w A times what is left of them, each pixel shared between
/// the two nearest places.
struct Gathered {
    distance: Column,
    squares: Column,
    left: Column,
}

impl Gathered {
    /// Places for the distances to `reach` px on both sides.
    fn places(reach: f64) -> Vec<Self> {
        let count = (2.0 * reach / PLACE_PX).ceil() as usize + 2;
        let place = |i: usize| i as f64 * PLACE_PX - reach;
        let chunk = |first: usize| Self {
            distance: std::array::from_fn(|i| place(first + i)),
            squares: [0.0; CHUNK],
            left: [0.0; CHUNK],
        };
        (0..count).step_by(CHUNK).map(chunk).collect()
    }

    /// Adds some pixels; those beyond `reach` do not count.
    #[inline(always)]
    fn add(places: &mut [Self], seen: &Seen, reach: f64) {
        for i in 0..CHUNK {
            let towards = seen.bright[i] * seen.distance[i];
            if towards.abs() < reach && seen.weight[i] > 0.0 {
                let place = (towards + reach) / PLACE_PX;
                let first = place as usize;
                let part = place - first as f64;
                let by = seen.weight[i] * seen.contrast[i];
                let (squares, left) = (by * seen.contrast[i], by * seen.bright[i] * seen.left[i]);
                for (at, share) in [(first, 1.0 - part), (first + 1, part)] {
                    let chunk = &mut places[at / CHUNK];
                    chunk.squares[at % CHUNK] += share * squares;
                    chunk.left[at % CHUNK] += share * left;
                }
            }
        }
    }
}

/// Four lanes, summed in a fixed order.
#[inline(always)]
fn dot(a: &Column, b: &Column) -> f64 {
    const LANES: usize = 4;
    let mut sums = [0.0; LANES];
    for i in (0..CHUNK).step_by(LANES) {
        for lane in 0..LANES {
            sums[lane] += a[i + lane] * b[i + lane];
        }
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}

/// Adds the pixels of a strip for so many weights; their equations only where they are wanted.
struct Leaving<'a> {
    sum: &'a mut Left,
    strip: &'a EdgeStrip,
    model: &'a Model,
    edge: &'a EdgeModel<'a>,
    shape: &'a BlurShape,
    /// Under the Gaussian and under a bump.
    profiles: &'a [Profile; 2],
    reach: f64,
    weights: (usize, bool),
}

impl Kernel for Leaving<'_> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let Self { sum, strip, model, edge, shape, profiles, reach, weights: (count, equations) } = self;
        let mut places = if equations { Gathered::places(reach) } else { Vec::new() };
        for pixels in strip.chunks() {
            let seen = Seen::new(pixels, model, edge);
            sum.add_bins(&seen, reach, count > BUMPS);
            if equations {
                Gathered::add(&mut places, &seen, reach);
            }
        }
        for gathered in &places {
            sum.add_equations(gathered, (shape, profiles), count);
        }
    }
}

/// What the fits leave near the edges of one family.
#[derive(Debug, Clone, Copy)]
struct Left {
    normal: SMatrix<f64, WEIGHTS, WEIGHTS>,
    right: SVector<f64, WEIGHTS>,
    /// Sums of w A^2 and of what is left, towards the side of the edge, times A, in steps of distance.
    bins: [[f64; 2]; 2 * BINS],
    /// Sums of what is left squared, and of the weights.
    squares: f64,
    weight: f64,
}

impl Left {
    fn none() -> Self {
        let bins = [[0.0; 2]; 2 * BINS];
        Self { normal: SMatrix::zeros(), right: SVector::zeros(), bins, squares: 0.0, weight: 0.0 }
    }

    /// Adds some pixels: their distances and what is left of them, in steps of distance.
    #[inline(always)]
    fn add_bins(&mut self, seen: &Seen, reach: f64, both_sides: bool) {
        for i in 0..CHUNK {
            let Seen { distance, contrast, weight, left, bright } = seen;
            self.squares += weight[i] * left[i] * left[i];
            self.weight += weight[i];
            let d = distance[i];
            let bin = ((d.abs() / reach * BINS as f64) as usize).min(BINS - 1);
            // Both sides of an edge go together where they are alike.
            let apart = both_sides && d * bright[i] < 0.0;
            let (bin, side) = if apart { (BINS + bin, bright[i]) } else { (bin, d.signum()) };
            let bin = &mut self.bins[bin];
            bin[0] += weight[i] * contrast[i] * contrast[i];
            bin[1] += weight[i] * contrast[i] * left[i] * side;
        }
    }

    /// Adds the equations of some pixels, gathered by their distances towards bright, for so many weights.
    #[inline(always)]
    fn add_equations(
        &mut self,
        Gathered { distance, squares, left }: &Gathered,
        (shape, [under, bump]): (&BlurShape, &[Profile; 2]),
        count: usize,
    ) {
        let columns = pairs(shape, bump, &under.at_all(distance)[0], distance, count);
        for i in 0..count {
            let weighted = product(squares, &columns[i]);
            for (j, column) in columns[..=i].iter().enumerate() {
                self.normal[(i, j)] += dot(&weighted, column);
            }
            self.right[i] += dot(left, &columns[i]);
        }
    }

    fn sum(mut self, other: &Self) -> Self {
        self.normal += other.normal;
        self.right += other.right;
        for (bin, more) in self.bins.iter_mut().zip(other.bins) {
            *bin = [bin[0] + more[0], bin[1] + more[1]];
        }
        self.squares += other.squares;
        self.weight += other.weight;
        self
    }

    /// Whether what is left depends on the distance from the edge, more than by chance and more than the model's own error.
    fn is_misfit(&self) -> bool {
        let used = self.bins.iter().filter(|b| b[0] > 0.0).count() as f64;
        let explained: f64 = self.bins.iter().filter(|b| b[0] > 0.0).map(|b| b[1] * b[1] / b[0]).sum();
        let strength: f64 = self.bins.iter().map(|b| b[0]).sum();
        let chance = (self.squares - explained) / (self.weight - used).max(1.0);
        // A is half the contrast.
        let share = 0.5 * (explained / strength.max(f64::MIN_POSITIVE)).sqrt();
        explained > SURE * used * chance && share > LEAST_MISFIT
    }

    /// By how much the weights change.
    fn change(&self) -> Option<SVector<f64, WEIGHTS>> {
        let hold = (self.squares / self.weight.max(1.0) / (PRIOR * PRIOR)).max(HOLD * self.normal.trace());
        let held = |i: usize, j: usize| if i == j { hold } else { 0.0 };
        // The sums are those of the lower triangle.
        let entry = |i: usize, j: usize| self.normal[(i.max(j), i.min(j))] + held(i, j);
        let normal = SMatrix::<f64, WEIGHTS, WEIGHTS>::from_fn(entry);
        let change = normal.cholesky()?.solve(&self.right);
        change.iter().all(|v| v.is_finite()).then_some(change)
    }
}

/// The shapes of the blur of a picture whose Gaussians are known: from some corners, and only where a Gaussian leaves clearly more.
/// Where edges lean (`leaning`) they may be unlike to both sides of them.
pub(super) fn find_shapes(
    candidates: &Candidates<'_>,
    sites: &[CornerSite],
    settings: &Settings,
    sigma_px: [f64; 2],
    leaning: bool,
) -> PictureBlur {
    // See whether the Gaussians leave more than chance.
    let mut plain = PictureBlur::gaussian(sigma_px);
    let sites: Vec<CornerSite> = sites.iter().copied().step_by(sites.len().div_ceil(PILOTS).max(1)).collect();
    let weights = if leaning { WEIGHTS } else { BUMPS };
    let misfits = |plain: &PictureBlur, fits: &[PilotFit]| {
        let misfit = left(fits, (weights, false)).map(|l| l.is_misfit());
        [0, 1].map(|k| misfit[k] && plain.sigma_px[k] >= SHARP_PX)
    };
    let mut fits = fit_pilots(candidates, &sites, settings, &plain, plain.shapes.map(|shape| shape.reach_px()));
    let mut shaped = misfits(&plain, &fits);
    let elongated = sites.first().is_some_and(|site| site.skew != 0.0);
    if shaped == [false; 2] && !elongated {
        return plain;
    }

    // See whether the picture moved, and whether that leaves more than chance.
    if let Some(moved) = find_motion(candidates, &sites, settings, &fits) {
        plain = moved;
        fits = fit_pilots(candidates, &sites, settings, &plain, [0.0; 2]);
        shaped = misfits(&plain, &fits);
    }
    if shaped == [false; 2] {
        return plain;
    }

    find_weights(candidates, &sites, settings, (plain, shaped), leaning)
}

/// The weights of the bumps beside a blur, of the families for which they are sought (`shaped`) and where they explain enough.
fn find_weights(
    candidates: &Candidates<'_>,
    sites: &[CornerSite],
    settings: &Settings,
    (plain, mut shaped): (PictureBlur, [bool; 2]),
    leaning: bool,
) -> PictureBlur {
    // Fit the pilots with the pixels that bumps may reach.
    let weights = if leaning { WEIGHTS } else { BUMPS };
    let mut blur = plain;
    let reach_px = [0, 1].map(|k| if shaped[k] { plain.shapes[k].most_reach_px(!leaning) } else { 0.0 });
    let mut fits = fit_pilots(candidates, sites, settings, &plain, reach_px);
    let models = |fits: &[PilotFit]| squares(fits.iter().flatten().map(|(_, fit)| fit));
    let before = models(&fits);

    // Find the weights, and fit again.
    for round in 0..ROUNDS {
        let left = left(&fits, (weights, true));
        for k in 0..2 {
            let Some(change) = left[k].change() else { return plain };
            shaped[k] &= round > 0 || change.dot(&left[k].right) > BELIEVED * left[k].squares;
            if shaped[k] {
                let BlurShape { weights, uneven, .. } = &mut blur.shapes[k];
                weights.iter_mut().chain(uneven).zip(change.iter()).for_each(|(w, c)| *w += c);
            }
        }
        if shaped == [false; 2] {
            return plain;
        }
        let from: Vec<_> = fits.iter().map(|pilot| pilot.as_ref().map(|(window, fit)| (window, fit))).collect();
        let again = fit_again(&from, &blur, &EFFORT);
        fits = fits.into_iter().zip(again).map(|(before, fit)| Some((before?.0, fit?))).collect();
    }
    if models(&fits) < before { blur } else { plain }
}

/// What fits leave near the edges of both families, for so many weights and with or without their equations.
fn left(fits: &[PilotFit], weights: (usize, bool)) -> [Left; 2] {
    let one = |fit: &PilotFit| {
        let mut own = [Left::none(); 2];
        if let Some((window, CornerFit { model, .. })) = fit {
            let seen_as = profiles(model);
            let gaussian = PictureBlur::gaussian([1.0; 2]).shapes[0];
            for (k, edge) in edge_models(model, &seen_as, false).iter().enumerate() {
                let shape = &model.shapes[k];
                let beside_px = if weights.1 { shape.most_reach_px(weights.0 == BUMPS) } else { shape.reach_px() };
                let plain = EdgeShape::moved(edge.normal, model.sigma_px[k], model.half_way_px);
                let reach = plain.reach_under(beside_px);
                let profiles = [plain, plain.under(shape.bump_px())].map(|plain| Profile::shaped(plain, &gaussian));
                let sum = &mut own[k];
                let strip = &window.strips[k];
                widest(Leaving { sum, strip, model, edge, shape, profiles: &profiles, reach, weights });
            }
        }
        own
    };
    let all: Vec<[Left; 2]> = fits.par_iter().map(one).collect();
    [0, 1].map(|k| all.iter().fold(Left::none(), |sum, own| sum.sum(&own[k])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    #[test]
    fn what_is_not_alike_to_both_sides_is_even_towards_bright() {
        let mut shape = PictureBlur::gaussian([1.0; 2]).shapes[0];
        shape.uneven[1] = -0.3;
        let normal = DVec2::from_angle(0.4);
        let (plain, shaped) = (Profile::new(normal, 1.0), Profile::shaped(EdgeShape::new(normal, 1.0), &shape));
        let bump = Profile::new(normal, shape.bump_px());
        for i in -40..=40 {
            let d = f64::from(i) * 0.13;
            // What the pair adds, by its own definition: two bumps of opposite sign, two spacings away.
            let away = 2.0 * shape.spacing_px;
            let expected = -0.15 * (bump.at(d - away).value - bump.at(d + away).value);
            let added = |d: f64| shaped.at(d).value - plain.at(d).value;
            // Tables err by 5e-6 each.
            assert!((added(d) - expected).abs() < 2e-5, "{d}: {} for {expected}", added(d));
            assert!((added(d) - added(-d)).abs() < 2e-5, "{d}");
            // Bright on the other side it is the mirror image, and the mean of both is the blur alone.
            assert_eq!(shaped.towards(d, -1.0).value, -shaped.at(-d).value);
            assert!((shaped.odd(d).value - plain.at(d).value).abs() < 2e-5, "{d}");
        }
    }
}
