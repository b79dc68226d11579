//! The light of reflections in the glass, over the picture.

use super::Film;
use super::coverage::Pattern;
use crate::effect::{Ghosts, Journey, Landing};
use crate::optics::polarisation::{Beam, Light};
use crate::system::System;
use crate::trace::nonsequential::{Body, Exit, Limits};
use glam::DVec2;
use rayon::prelude::*;

/// Adds the light of ghosts to the picture of one pass of `system`, where some act.
pub(super) fn add(system: &System, film: &mut Film) {
    let Some(watch) = Watch::new(system) else { return };
    let n = watch.ghosts.samples;
    let share = 1.0 / (n * n) as f64;
    let width = film.radiance.width();
    film.radiance.data_mut().par_chunks_mut(width).enumerate().for_each(|(j, row)| {
        for (i, value) in row.iter_mut().enumerate() {
            let corner = DVec2::new(i as f64, j as f64);
            let at = |k: usize| DVec2::new((k % n) as f64 + 0.5, (k / n) as f64 + 0.5) / n as f64;
            let ghosts = share * (0..n * n).map(|k| watch.seen(corner + at(k))).sum::<f64>();
            *value = (f64::from(*value) + ghosts) as f32;
        }
    });
    film.counts.rays += (film.radiance.data().len() * n * n) as u64;
}

/// What is fixed for a picture of ghosts.
struct Watch<'a> {
    system: &'a System,
    ghosts: Ghosts,
    body: Body,
    light: Light,
    pattern: Pattern,
}

impl<'a> Watch<'a> {
    fn new(system: &'a System) -> Option<Self> {
        let ghosts = system.effects.ghosts.filter(|ghosts| !ghosts.is_nothing())?;
        let light = system.effects.fresnel?.light;
        Some(Self { system, ghosts, body: system.body()?, light, pattern: Pattern::new(&system.board.pattern) })
    }

    /// The radiance of all ghosts at an image position.
    fn seen(&self, px: DVec2) -> f64 {
        let Self { system, ghosts, .. } = self;
        let Some(prism) = &system.prism else { return 0.0 };
        let ray = system.camera.ray(px);
        let limits = Limits { bounces: ghosts.bounces, least_power: ghosts.least_power };
        let residual_mm = system.accuracy.surface_residual_mm;
        let mut sum = 0.0;
        prism.follow(&ray, Beam::new(ray.direction, self.light), self.body, limits, residual_mm, &mut |exit| {
            // The light that is never reflected is the picture itself.
            if exit.bounces > 0 {
                sum += exit.power * self.radiance(exit, px);
            }
        });
        sum
    }

    /// What light that leaves the glass sees, weakened as all light at `px` is: by everything but the glass.
    fn radiance(&self, exit: &Exit, px: DVec2) -> f64 {
        let Self { system, ghosts, pattern, .. } = self;
        let (seen, landing) = if exit.face.which == 0 {
            (ghosts.behind, None)
        } else {
            match system.board.meet(&exit.ray) {
                Ok((board_mm, t_mm)) => {
                    let landing = Landing { point_mm: exit.ray.at(t_mm), normal: system.board.normal() };
                    (pattern.at(board_mm), Some(landing))
                }
                Err(_) => (pattern.background(), None),
            }
        };
        let journey = Journey { image_cos: system.camera.image_cos(px), crossings: &[], landing };
        seen * system.effects.gain(&journey)
    }
}
