//! The picture of an instrument with ray effects: a mean over passes, each the picture of a plain instrument.

use super::{Account, Film, Plan, Wanted, Work, picture};
use crate::raster::Raster;
use crate::system::System;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The weighted sum of the pictures of all variants of `system`; what is wanted besides the radiance is that of `system`
/// itself. `progress` hears of each pixel once for all passes.
pub(super) fn sum(system: &System, wanted: Wanted, progress: &(dyn Fn(usize) + Sync)) -> Film {
    let variants = system.effects.variants();
    let done = AtomicUsize::new(0);
    let share = |pixels: usize| {
        let before = done.fetch_add(pixels, Ordering::Relaxed);
        progress((before + pixels) / variants.len() - before / variants.len());
    };
    // What is true of a picture is what the middle of the pupil sees.
    let own = Plan::new(system);
    let truth = if wanted.truth { Some(picture(&own, wanted, &|_| ())) } else { None };
    let [width, height] = system.camera.size_px();
    let mut sums = Raster::filled(width, height, 0.0f64);
    let mut work = Work::default();
    let mut account = Account { passes: variants.len(), ..own.account(0.0) };
    for variant in &variants {
        let film = picture(&Plan::new(&system.varied(variant)), Wanted { truth: false }, &share);
        let pixels = sums.data_mut().par_iter_mut().zip(film.radiance.data());
        pixels.for_each(|(sum, value)| *sum += variant.weight * f64::from(*value));
        work += Work { counts: film.counts, bend_px: film.account.bend_px };
        account = account.with(&film.account);
    }
    let radiance = sums.map(|sum| sum as f32);
    let (class, board_mm) = truth.map_or_else(
        || (Raster::from_data(0, 0, Vec::new()), Raster::from_data(0, 0, Vec::new())),
        |film| (film.class, film.board_mm),
    );
    Film { radiance, class, board_mm, counts: work.counts, account }
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
