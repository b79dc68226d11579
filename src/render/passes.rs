//! The picture of an instrument with ray effects: a mean over passes, each the picture of a plain instrument.

use super::{Account, Film, Plan, Wanted, Work, ghosts, picture};
use crate::effect::Variant;
use crate::raster::Raster;
use crate::system::System;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The weighted sum of the pictures of the `variants` of `system`; what is wanted besides the radiance is that of
/// `system` itself. `progress` hears of each pixel once for all passes.
pub(super) fn sum(system: &System, variants: &[Variant], wanted: Wanted, progress: &(dyn Fn(usize) + Sync)) -> Film {
    let done = AtomicUsize::new(0);
    let share = |pixels: usize| {
        let before = done.fetch_add(pixels, Ordering::Relaxed);
        progress((before + pixels) / variants.len() - before / variants.len());
    };
    // What is true of a picture is what the middle of the pupil sees.
    let own = Plan::new(system);
    let truth = wanted.truth.then(|| picture(&own, wanted, &|_| ()));
    let [width, height] = system.camera.size_px();
    let mut grey = Raster::filled(width, height, 0.0f64);
    let in_colour = variants.iter().all(|variant| variant.colour.is_some());
    let mut colour = in_colour.then(|| Raster::filled(width, height, [0.0f64; 3]));
    let mut work = Work::default();
    let mut account = Account { passes: variants.len(), ..own.account(0.0) };
    for variant in variants {
        let varied = system.varied(variant);
        let mut film = picture(&Plan::new(&varied), Wanted { truth: false }, &share);
        ghosts::add(&varied, &mut film);
        let values = film.radiance.data();
        (grey.data_mut().par_iter_mut().zip(values)).for_each(|(sum, value)| *sum += variant.grey * f64::from(*value));
        if let (Some(colour), Some(shares)) = (&mut colour, variant.colour) {
            (colour.data_mut().par_iter_mut().zip(values)).for_each(|(sums, value)| {
                sums.iter_mut().zip(shares).for_each(|(sum, share)| *sum += share * f64::from(*value));
            });
        }
        work += Work { counts: film.counts, bend_px: film.account.bend_px };
        account = account.with(&film.account);
    }
    let nothing = || (Raster::from_data(0, 0, Vec::new()), Raster::from_data(0, 0, Vec::new()));
    let (class, board_mm) = truth.map_or_else(nothing, |film| (film.class, film.board_mm));
    Film {
        radiance: grey.map(|sum| sum as f32),
        colour: colour.map(|sums| sums.map(|sum| sum.map(|channel| channel as f32))),
        class,
        board_mm,
        counts: work.counts,
        account,
    }
}

impl Account {
    /// The account of this picture and `other` together: the worse of both.
    fn with(self, other: &Self) -> Self {
        Self {
            map_px: self.map_px.max(other.map_px),
            bend_px: self.bend_px.max(other.bend_px),
            mapped: self.mapped.min(other.mapped),
            ..self
        }
    }
}
