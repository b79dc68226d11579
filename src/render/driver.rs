//! The render driver: from an instrument to its film, in the order of the light.

use super::accumulate;
use super::bands::picture;
use super::film::{AccuracyReport, Film, Outputs};
use super::ground_truth::ground_truth;
use super::plan::Plan;
use crate::effect::{Hook, Picture};
use crate::progress::{Observer, OnPixels};
use crate::system::System;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The picture that `system` takes, with its ground truth; `observer` hears how many more pixels are done,
/// from any thread.
pub fn render(system: &System, observer: &dyn Observer) -> Film {
    render_wanted(system, Outputs { truth: true }, observer)
}

/// The picture that `system` takes, with what is wanted of it; `observer` as in [`render`].
pub fn render_wanted(system: &System, wanted: Outputs, observer: &dyn Observer) -> Film {
    let effects = system.effects();

    // Choose the sampling: film effects may ask for n x n samples in place of each pixel.
    let n = effects.samples(system.camera().size_px());
    let finer = (n > 1).then(|| system.sampled(n));
    let sampled = finer.as_ref().unwrap_or(system);
    let sampled_wants = Outputs { truth: wanted.truth && n == 1 };
    let heard = AtomicUsize::new(0);
    let tell = OnPixels(|samples: usize| {
        let before = heard.fetch_add(samples, Ordering::Relaxed);
        observer.pixels((before + samples) / (n * n) - before / (n * n));
    });

    // Render the passes, each by a plan of its own and band by band, and accumulate their mean; a plain instrument has one.
    let light = if effects.averages() {
        accumulate::mean(sampled, &|set| effects.variants(set), sampled_wants, &tell)
    } else {
        picture(&Plan::new(sampled), sampled_wants, &tell)
    };

    // Give the samples the ground truth and the account of the pixels that they are parts of.
    let light = if n == 1 { light } else { of_pixels(system, light, n, wanted) };

    // Apply the film effects: optics, then sensor.
    if !effects.act_by(Hook::Film) {
        return light;
    }
    let Picture { grey, colour } = effects.develop(Picture { grey: light.radiance, colour: light.colour }, n);
    Film { radiance: grey, colour, ..light }
}

/// The film `fine` of `n` x `n` samples a pixel with what is wanted besides of `system` itself.
fn of_pixels(system: &System, fine: Film, n: usize, wanted: Outputs) -> Film {
    let px = 1.0 / n as f64;
    let account =
        AccuracyReport { map_px: px * fine.account.map_px, bend_px: px * fine.account.bend_px, ..fine.account };
    // Of the samples, the noise has not the picture's size.
    if !wanted.truth {
        return Film { noise: None, account, ..fine };
    }
    let own = ground_truth(system);
    Film { radiance: fine.radiance, colour: fine.colour, counts: fine.counts, account, ..own }
}
