//! The picture of an instrument with ray effects: a mean over passes, each the picture of a plain instrument.

use super::{Account, Film, Plan, Wanted, Work, ghosts, picture};
use crate::effect::Variant;
use crate::effect::quadrature::LEAST_REPLICATES;
use crate::raster::Raster;
use crate::system::System;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Side of the blocks by whose mean variance the error of a picture is judged, in px: one pixel's own spread over a few
/// sets tells little.
const BLOCK: usize = 16;

/// A picture in f64.
struct Sums {
    grey: Raster<f64>,
    colour: Option<Raster<[f64; 3]>>,
}

/// The mean over sets of variants of `system`, of which `set` makes the k-th, each a weighted sum of pictures; what is
/// wanted besides the radiance is that of `system` itself. `progress` hears of each pixel once for all passes.
pub(super) fn mean(
    system: &System,
    set: &dyn Fn(usize) -> Vec<Variant>,
    wanted: Wanted,
    progress: &(dyn Fn(usize) + Sync),
) -> Film {
    let most_sets = system.effects.sets();
    let [width, height] = system.camera.size_px();
    // What is true of a picture is what the middle of the pupil sees.
    let own = Plan::new(system);
    let truth = wanted.truth.then(|| picture(&own, wanted, &|_| ()));
    let mut work = Work::default();
    let mut account = own.account(0.0);
    let first = set(0);
    let heard = AtomicUsize::new(0);
    let mut total = None::<Sums>;
    // Sums of squared deviations from the mean so far, by Welford's recurrence (Technometrics 4, 1962, 419).
    let mut squares = (most_sets > 1).then(|| Raster::filled(width, height, 0.0f64));
    let mut sets = 0;
    while sets < most_sets {
        let variants = if sets == 0 { first.clone() } else { set(sets) };
        let passes = most_sets * variants.len();
        let share = |pixels: usize| {
            let before = heard.fetch_add(pixels, Ordering::Relaxed);
            progress((before + pixels) / passes - before / passes);
        };
        let one = sum(system, &variants, &mut work, &mut account, &share);
        sets += 1;
        account.passes = sets * variants.len();
        total = Some(match total {
            None => one,
            Some(mut mean) => {
                if let Some(squares) = &mut squares {
                    mean.add(&one, squares, sets);
                }
                mean
            }
        });
        if let (Some(target), Some(squares)) = (system.effects.quadrature.noise, &squares)
            && sets >= LEAST_REPLICATES
            && worst_error(squares, sets) <= target
        {
            break;
        }
    }
    let all = most_sets * first.len();
    progress(width * height - heard.load(Ordering::Relaxed) / all);
    let squares = squares.filter(|_| sets > 1);
    account.noise = squares.as_ref().map(|squares| worst_error(squares, sets));
    let Sums { grey, colour } = total.unwrap_or(Sums { grey: Raster::filled(width, height, 0.0), colour: None });
    let nothing = || (Raster::from_data(0, 0, Vec::new()), Raster::from_data(0, 0, Vec::new()));
    let (class, board_mm) = truth.map_or_else(nothing, |film| (film.class, film.board_mm));
    Film {
        radiance: grey.map(|sum| sum as f32),
        colour: colour.map(|sums| sums.map(|sum| sum.map(|channel| channel as f32))),
        noise: squares.map(|squares| squares.map(|square| standard_error(square, sets) as f32)),
        class,
        board_mm,
        counts: work.counts,
        account,
    }
}

/// The weighted sum of the pictures of `variants`.
fn sum(
    system: &System,
    variants: &[Variant],
    work: &mut Work,
    account: &mut Account,
    progress: &(dyn Fn(usize) + Sync),
) -> Sums {
    let [width, height] = system.camera.size_px();
    let mut grey = Raster::filled(width, height, 0.0f64);
    let in_colour = variants.iter().all(|variant| variant.colour.is_some());
    let mut colour = in_colour.then(|| Raster::filled(width, height, [0.0f64; 3]));
    for variant in variants {
        let varied = system.varied(variant);
        let mut film = picture(&Plan::new(&varied), Wanted { truth: false }, progress);
        ghosts::add(&varied, &mut film);
        let values = film.radiance.data();
        (grey.data_mut().par_iter_mut().zip(values)).for_each(|(sum, value)| *sum += variant.grey * f64::from(*value));
        if let (Some(colour), Some(shares)) = (&mut colour, variant.colour) {
            (colour.data_mut().par_iter_mut().zip(values)).for_each(|(sums, value)| {
                sums.iter_mut().zip(shares).for_each(|(sum, share)| *sum += share * f64::from(*value));
            });
        }
        *work += Work { counts: film.counts, bend_px: film.account.bend_px };
        *account = account.with(&film.account);
    }
    Sums { grey, colour }
}

impl Sums {
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

/// Standard error of the mean of `sets` values whose squared deviations sum up to `square`.
fn standard_error(square: f64, sets: usize) -> f64 {
    (square / (sets * (sets - 1)) as f64).sqrt()
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

impl Account {
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
