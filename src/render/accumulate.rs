//! Multi-pass accumulation: the picture of an instrument with ray effects is a mean over passes, each the picture of an
//! instrument without.

use super::band::Band;
use super::bands::{picture, render_band, render_half};
use super::fill::Fill;
use super::film::{AccuracyReport, Counts, Film, Outputs};
use super::ghosts;
use super::ground_truth::ground_truth;
use super::plan::{BAND_ROWS, Plan};
use super::sums::Sums;
use super::work::Work;
use crate::effect::quadrature::LEAST_REPLICATES;
use crate::effect::{Variant, Variants};
use crate::progress::{Observer, Scaled};
use crate::raster::Raster;
use crate::system::System;
use rayon::prelude::*;

/// Side of the blocks by whose mean variance the error of a picture is judged, in px: one pixel's own spread over a few
/// sets tells little.
const BLOCK: usize = 16;
/// Variants whose plans are held at a time.
const PLANS: usize = 16;

/// The light that falls on the pixels of `system`, before film effects: one picture, or the mean over its variants.
pub(super) fn light(system: &System, wanted: Outputs, observer: &dyn Observer) -> Film {
    let effects = system.effects();
    if effects.averages() {
        let fill = Fill::of(system);
        let set = |set: usize| match &fill {
            Some(fill) => effects.variants(set).with_pupils(|pupil| fill.drawn_in(pupil)),
            None => effects.variants(set),
        };
        mean(system, &VariantSets { set: &set, fill: fill.as_ref() }, wanted, observer)
    } else {
        picture(&Plan::new(system), wanted, observer)
    }
}

/// The variants whose weighted sum the picture with this account is, each with the share of its set.
pub(super) fn variants_of(system: &System, account: &AccuracyReport) -> Vec<(f64, Variant)> {
    let effects = system.effects();
    let sets = account.passes / effects.variants(0).len();
    let of_set = |set: usize| effects.variants(set).iter().collect::<Vec<_>>();
    (0..sets).flat_map(of_set).map(|variant| (1.0 / sets as f64, variant)).collect()
}

/// A picture in f64.
struct RunningMean {
    grey: Raster<f64>,
    colour: Option<Raster<[f64; 3]>>,
}

/// Sets of variants of an instrument.
pub(super) struct VariantSets<'a> {
    /// Makes the k-th.
    pub(super) set: &'a dyn Fn(usize) -> Variants<'a>,
    /// What the points of the pupil stand for, where it is more than they.
    pub(super) fill: Option<&'a Fill>,
}

/// The mean over sets of variants of `system`, each a weighted sum of pictures; what is wanted besides the radiance is that of
/// `system` itself. `observer` hears of each pixel once for all passes.
pub(super) fn mean(system: &System, sets: &VariantSets, wanted: Outputs, observer: &dyn Observer) -> Film {
    let most_sets = system.effects().sets();
    let [width, height] = system.camera().size_px();

    // Trace the ground truth, through the middle of the pupil.
    let own = Plan::new(system);
    let truth = wanted.truth.then(|| ground_truth(system));

    // Add sets, each a weighted sum of pictures, until all are done or the noise is within its target.
    let mut work = Work::default();
    let mut account = own.account(0.0);
    let first = (sets.set)(0);
    let pixels = width * height;
    let all = most_sets.saturating_mul(first.len()).saturating_mul(pixels);
    let scaled = Scaled::new(observer, pixels, all);
    let mut mean = MeanOfSets::new(most_sets, [width, height]);
    while mean.sets < most_sets {
        let variants = if mean.sets == 0 { first.clone() } else { (sets.set)(mean.sets) };
        let mut one = sum(system, &variants, &mut work, &mut account, &scaled);
        one.complete(system, sets.fill);
        mean.add(one);
        account.passes = mean.sets * variants.len();
        if system.effects().quadrature.noise.is_some_and(|target| mean.reaches(target)) {
            break;
        }
    }

    // Report the pixels of the sets that were not needed.
    scaled.pixels(all.saturating_sub(mean.sets * first.len() * pixels));

    // Give out the mean with its noise and the truth.
    account.noise = mean.noise();
    account.noise_target = system.effects().quadrature.noise.filter(|_| most_sets > 1);
    let sets = mean.sets;
    let squares = mean.squares.filter(|_| sets >= LEAST_REPLICATES);
    let RunningMean { grey, colour } =
        mean.picture.unwrap_or(RunningMean { grey: Raster::filled(width, height, 0.0), colour: None });
    let (class, board_mm, object) = truth.map_or((None, None, None), |film| (film.class, film.board_mm, film.object));
    Film {
        radiance: grey.map(|sum| sum as f32),
        colour: colour.map(|sums| sums.map(|sum| sum.map(|channel| channel as f32))),
        noise: squares.map(|squares| squares.map(|square| standard_error(square, sets) as f32)),
        class,
        board_mm,
        object,
        counts: work.counts,
        account,
    }
}

/// The mean over sets so far, and its spread.
struct MeanOfSets {
    picture: Option<RunningMean>,
    /// Sums of squared deviations from the mean so far, by Welford's recurrence (Technometrics 4, 1962, 419); `None`
    /// where there is one set.
    squares: Option<Raster<f64>>,
    sets: usize,
}

impl MeanOfSets {
    fn new(most_sets: usize, [width, height]: [usize; 2]) -> Self {
        let squares = (most_sets > 1).then(|| Raster::filled(width, height, 0.0f64));
        Self { picture: None, squares, sets: 0 }
    }

    /// Adds the picture of one more set.
    fn add(&mut self, one: RunningMean) {
        self.sets += 1;
        self.picture = Some(match self.picture.take() {
            None => one,
            Some(mut mean) => {
                if let Some(squares) = &mut self.squares {
                    mean.add(&one, squares, self.sets);
                }
                mean
            }
        });
    }

    /// Whether the sets say that the standard error of the worst block is at most `target`, and all but surely.
    fn reaches(&self, target: f64) -> bool {
        self.noise().is_some_and(|noise| noise * surely_below(self.sets) <= target)
    }

    /// Standard error of a pixel in the worst block; `None` of too few sets to tell it.
    fn noise(&self) -> Option<f64> {
        let squares = self.squares.as_ref().filter(|_| self.sets >= LEAST_REPLICATES);
        squares.map(|squares| worst_error(squares, self.sets))
    }
}

/// The weighted sum of the pictures of `variants`.
fn sum(
    system: &System,
    variants: &Variants,
    work: &mut Work,
    account: &mut AccuracyReport,
    observer: &dyn Observer,
) -> RunningMean {
    // Start the weighted sums, in colour where every variant has its three weights.
    let [width, height] = system.camera().size_px();
    let mut grey = Raster::filled(width, height, 0.0f64);
    let mut colour = variants.in_colour().then(|| Raster::filled(width, height, [0.0f64; 3]));

    // Render some variants at a time, and add them by their weights: band by band while a band is at hand, or each with its
    // ghosts, which are those of a whole picture.
    let all: Vec<Variant> = variants.iter().collect();
    let with_ghosts = system.effects().ghosts.is_some_and(|ghosts| !ghosts.is_nothing());
    for some in all.chunks(PLANS) {
        let instruments: Vec<System> = some.par_iter().map(|variant| system.variant(variant)).collect();
        let plans: Vec<Plan> = instruments.par_iter().map(Plan::new).collect();
        let mut bands = Sums::bands(&mut grey, &mut colour);
        let done: Vec<Done> = if with_ghosts {
            let whole =
                plans.iter().zip(some).map(|(plan, variant)| with_its_ghosts(plan, variant, &mut bands, observer));
            whole.collect()
        } else {
            band_by_band(&plans, some, &mut bands, observer)
        };

        // Account for their rays and for the worst of their errors.
        for (counts, of_plan) in done {
            *work += Work { counts, bend_px: of_plan.bend_px };
            *account = account.with(&of_plan);
        }
    }

    RunningMean { grey, colour }
}

/// What became of a picture that was added: its operations, and its accuracy.
type Done = (Counts, AccuracyReport);

/// Adds the pictures of these plans, which are those of `variants`, to the bands.
fn band_by_band(plans: &[Plan], variants: &[Variant], bands: &mut [Sums], observer: &dyn Observer) -> Vec<Done> {
    // Of pictures that are all their own mirror images one half is made and added.
    let mirrored = plans.iter().all(|plan| plan.mirrored);
    let of_band = |sums: &mut Sums| -> Vec<Work> {
        let mut radiance = vec![0.0; sums.grey.len()];
        let mut of_plan = |(plan, variant): (&Plan, &Variant)| {
            let (width, first_row) = (sums.width, sums.first_row);
            let mut band = Band { width, first_column: 0, first_row, radiance: &mut radiance, truth: None };
            // As in a single picture: one that ends the work does so before a band.
            observer.pixels(0);
            let work = if mirrored { render_half(plan, &mut band) } else { render_band(plan, &mut band) };
            sums.add(variant, &radiance, if mirrored { width / 2 } else { 0 });
            observer.pixels(radiance.len());
            work
        };
        let done = plans.iter().zip(variants).map(&mut of_plan).collect();
        if mirrored {
            sums.mirror();
        }
        done
    };
    let done: Vec<Vec<Work>> = bands.par_iter_mut().with_max_len(1).map(of_band).collect();

    // Sum up the work on each plan in the order of the bands.
    let of_plan = |(k, plan): (usize, &Plan)| {
        let mut work = plan.work();
        done.iter().for_each(|band| work += band[k]);
        (work.counts, plan.account_of(&work))
    };
    plans.iter().enumerate().map(of_plan).collect()
}

/// Adds the picture of a plan, with its ghosts, to the bands.
fn with_its_ghosts(plan: &Plan, variant: &Variant, bands: &mut [Sums], observer: &dyn Observer) -> Done {
    let mut film = picture(plan, Outputs { truth: false }, observer);
    ghosts::add(plan.system(), &mut film);
    let rows = film.radiance.data().par_chunks(film.radiance.width() * BAND_ROWS);
    bands.par_iter_mut().zip(rows).for_each(|(sums, values)| sums.add(variant, values, 0));
    (film.counts, film.account)
}

/// Makes each pixel the mean of itself and its mirror image to the left or right.
pub(super) fn make_symmetric<T: Copy + Send>(picture: &mut Raster<T>, mean: impl Fn(T, T) -> T + Sync) {
    let width = picture.width();
    picture.data_mut().par_chunks_mut(width).for_each(|row| {
        for i in 0..width / 2 {
            let value = mean(row[i], row[width - 1 - i]);
            (row[i], row[width - 1 - i]) = (value, value);
        }
    });
}

impl RunningMean {
    /// Adds what the points of one set leave out.
    fn complete(&mut self, system: &System, fill: Option<&Fill>) {
        // Spread each by the part of the pupil that it stands for.
        if let Some(fill) = fill {
            fill.spread(&mut self.grey);
            if let Some(colour) = &mut self.colour {
                for channel in 0..3 {
                    let mut plane = colour.map(|rgb| rgb[channel]);
                    fill.spread(&mut plane);
                    colour.data_mut().iter_mut().zip(plane.data()).for_each(|(rgb, value)| rgb[channel] = *value);
                }
            }
        }

        // Points of a set are not their own mirror images; of a symmetric scene, take those that are for as many again.
        if system.receives_mirror_images() {
            make_symmetric(&mut self.grey, |a, b| 0.5 * (a + b));
            if let Some(colour) = &mut self.colour {
                make_symmetric(colour, |a, b| [0, 1, 2].map(|c| 0.5 * (a[c] + b[c])));
            }
        }
    }

    /// Makes this mean of `sets` - 1 sets one of `sets`, and `squares` the sums of squared deviations from it.
    fn add(&mut self, one: &Self, squares: &mut Raster<f64>, sets: usize) {
        let share = 1.0 / sets as f64;
        let pixels = self.grey.data_mut().par_iter_mut().zip(one.grey.data()).zip(squares.data_mut());
        pixels.for_each(|((mean, value), square)| {
            let before = *value - *mean;
            *mean += before * share;
            *square += before * (*value - *mean);
        });
        if let (Some(means), Some(values)) = (&mut self.colour, &one.colour) {
            means.data_mut().par_iter_mut().zip(values.data()).for_each(|(means, values)| {
                means.iter_mut().zip(values).for_each(|(mean, value)| *mean += (*value - *mean) * share);
            });
        }
    }
}

/// Standard error of the mean of `sets` values whose squared deviations sum up to `square`: the spread of few values is
/// mostly too small, so that it is multiplied by the quantile of Student's distribution within which the mean lies as often
/// as a normal one within one standard deviation.
fn standard_error(square: f64, sets: usize) -> f64 {
    student_factor(sets) * (square / (sets * (sets - 1)) as f64).sqrt()
}

/// That quantile, by Fisher's expansion (Abramowitz & Stegun, Handbook of Mathematical Functions, 26.7.5, at x = 1).
fn student_factor(sets: usize) -> f64 {
    let dof = (sets - 1) as f64;
    1.0 + (0.5 + (0.25 + 0.0625 / dof) / dof) / dof
}

/// What the standard error told of `sets` values may be multiplied by to lie above the true one in 98 of 100 cases, by the
/// quantile of the chi-squared distribution (Wilson & Hilferty, Proc. Natl. Acad. Sci. 17, 1931, 684).
fn surely_below(sets: usize) -> f64 {
    // The normal deviate of 2 %.
    const DEVIATE: f64 = -2.053_749;
    let dof = (sets - 1) as f64;
    let spread = 2.0 / (9.0 * dof);
    let root = 1.0 - spread + DEVIATE * spread.sqrt();
    1.0 / (student_factor(sets) * (root * root * root).sqrt())
}

/// The largest root mean square of the standard errors in a block.
fn worst_error(squares: &Raster<f64>, sets: usize) -> f64 {
    let (width, height) = (squares.width(), squares.height());
    let block = |x: usize, y: usize| {
        let rows = y..height.min(y + BLOCK);
        let columns = x..width.min(x + BLOCK);
        let pixels = (rows.len() * columns.len()) as f64;
        rows.map(|j| squares.row(j)[columns.clone()].iter().sum::<f64>()).sum::<f64>() / pixels
    };
    let blocks = (0..height).step_by(BLOCK).flat_map(|y| (0..width).step_by(BLOCK).map(move |x| (x, y)));
    standard_error(blocks.map(|(x, y)| block(x, y)).fold(0.0, f64::max), sets)
}

impl AccuracyReport {
    /// The account of this picture and `other` together: the worse of both.
    fn with(self, other: &Self) -> Self {
        Self {
            map_px: self.map_px.max(other.map_px),
            bend_px: self.bend_px.max(other.bend_px),
            mapped: self.mapped.min(other.mapped),
            unpromised_pixels: self.unpromised_pixels.max(other.unpromised_pixels),
            ..self
        }
    }
}
