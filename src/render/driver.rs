//! The render driver: from an instrument to its film, in the order of the light.

use super::accumulate::light;
use super::diffraction;
use super::film::{Film, Outputs};
use super::ground_truth::classes;
use crate::effect::{Hook, Picture};
use crate::progress::Observer;
use crate::system::System;

/// The picture that `system` takes, with its ground truth; `observer` hears how many more pixels are done,
/// from any thread.
pub fn render(system: &System, observer: &dyn Observer) -> Film {
    render_wanted(system, Outputs { truth: true }, observer)
}

/// The picture that `system` takes, with what became of the ray of every pixel's centre, and without what it sees where that would
/// take longer; `observer` as in [`render`].
pub fn render_classed(system: &System, observer: &dyn Observer) -> Film {
    if !system.effects().averages() {
        return render(system, observer);
    }
    Film { class: classes(system), ..render_wanted(system, Outputs { truth: false }, observer) }
}

/// The picture that `system` takes, with what is wanted of it; `observer` as in [`render`].
pub fn render_wanted(system: &System, wanted: Outputs, observer: &dyn Observer) -> Film {
    let effects = system.effects();

    // Render the light that pixels collect: by passes, each by a plan of its own and band by band, and spread by diffraction.
    let light = match effects.diffracting() {
        Some(settings) => diffraction::spread_light(system, settings, wanted, observer),
        None => light(system, wanted, observer),
    };

    // Let the sensor make numbers of it.
    if !effects.act_by(Hook::Film) {
        return light;
    }
    let Picture { grey, colour } = effects.develop(Picture { grey: light.radiance, colour: light.colour });
    Film { radiance: grey, colour, ..light }
}
