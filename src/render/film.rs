//! The picture of an instrument with film effects.

use super::{Account, Film, Plan, Wanted, light, picture};
use crate::effect::Picture;
use crate::system::System;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The light that reaches the film of `system`, sampled as its film effects ask for, and what they make of it. What is
/// wanted besides the radiance is that of `system` itself; `progress` hears of each pixel once.
pub(super) fn developed(system: &System, wanted: Wanted, progress: &(dyn Fn(usize) + Sync)) -> Film {
    let samples = system.effects.samples(system.camera.size_px());
    let film = if samples == 1 { light(system, wanted, progress) } else { sampled(system, samples, wanted, progress) };
    let Picture { grey, colour } =
        system.effects.develop(Picture { grey: film.radiance, colour: film.colour }, samples);
    Film { radiance: grey, colour, ..film }
}

/// The light of `n` x `n` samples a pixel.
fn sampled(system: &System, n: usize, wanted: Wanted, progress: &(dyn Fn(usize) + Sync)) -> Film {
    let done = AtomicUsize::new(0);
    let share = |samples: usize| {
        let before = done.fetch_add(samples, Ordering::Relaxed);
        progress((before + samples) / (n * n) - before / (n * n));
    };
    let fine = light(&system.sampled(n), Wanted { truth: false }, &share);
    let px = 1.0 / n as f64;
    let account = Account { map_px: px * fine.account.map_px, bend_px: px * fine.account.bend_px, ..fine.account };
    // Of the samples, the noise has not the picture's size.
    if !wanted.truth {
        return Film { noise: None, account, ..fine };
    }
    let own = picture(&Plan::new(system), wanted, &|_| ());
    Film { radiance: fine.radiance, colour: fine.colour, counts: fine.counts, account, ..own }
}
