//! Whether light passes a prism: how a coarse grid of rays over the picture ends.

use super::instrument::System;
use super::shape_doubts;
use crate::effect::EffectId;
use crate::error::Error;
use crate::geom::Pose;
use crate::optics::fate::Fate;
use crate::prism::side::Side;
use crate::scene::Scene;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Rays along the width and the height of the picture.
const RAYS: [usize; 2] = [24, 16];
/// The same at most before an instrument is given up, through the middle of the pupil and through other points of it: a slit
/// or a stop may let light pass to a few pixels only.
const FINE_RAYS: [usize; 2] = [2048, 1152];
const FINE_RAYS_OF_VARIANT: [usize; 2] = [256, 144];
/// Variants of the instrument that are asked as well before a prism is given up.
const VARIANTS: usize = 16;

/// A ray that passed: where it went, in the prism's frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct PassedRay {
    pub(super) side: Side,
    /// Where it met front and back, in mm.
    pub(super) met_mm: [DVec3; 2],
    /// Whether it meets the plane of the board.
    pub(super) reaches_board: bool,
}

/// How the rays of a coarse grid over the picture end, through the middle of the pupil.
#[derive(Debug, Clone)]
pub(super) struct LightStudy {
    pub(super) passed: Vec<PassedRay>,
    /// Rays that end at the prism, by fate.
    pub(super) lost: BTreeMap<Fate, usize>,
}

impl LightStudy {
    pub(super) fn new(system: &System) -> Self {
        let mut study = Self { passed: Vec::new(), lost: BTreeMap::new() };
        let prism_from_world = system.designed.as_ref().map_or(Pose::IDENTITY, |prism| prism.prism_from_world());
        for px in grid(system, RAYS) {
            match system.path(px) {
                (path, Ok((ray, side))) => {
                    if let [front, back] = path.points[..] {
                        let met_mm = [front, back].map(|p| prism_from_world.point(p));
                        let reaches_board = system.board.intersect(&ray).is_ok();
                        study.passed.push(PassedRay { side, met_mm, reaches_board });
                    }
                }
                (_, Err(fate)) => *study.lost.entry(fate).or_default() += 1,
            }
        }
        study
    }

    /// Shares of the rays that end at the prism, in words: "86 % total_reflection, 14 % missed"; empty where none does.
    pub(super) fn fates(&self) -> String {
        let all = self.passed.len() + self.lost.values().sum::<usize>();
        shares(&self.lost, all)
    }
}

/// Shares of `all` by fate, the largest first.
pub(super) fn shares(counts: &BTreeMap<Fate, usize>, all: usize) -> String {
    let mut counts: Vec<_> = counts.iter().collect();
    counts.sort_by_key(|(_, n)| std::cmp::Reverse(**n));
    let share = |n: usize| 100.0 * n as f64 / all as f64;
    let words = counts.iter().map(|(fate, n)| format!("{:.1} % {}", share(**n), fate.name()));
    words.collect::<Vec<_>>().join(", ")
}

/// The middles of `columns` x `rows` equal parts of the picture.
pub(super) fn grid(system: &System, [columns, rows]: [usize; 2]) -> impl Iterator<Item = DVec2> + use<> {
    let size = DVec2::from_array(system.camera.size_px().map(|n| n as f64));
    let parts = DVec2::new(columns as f64, rows as f64);
    let place = move |k: usize| DVec2::new((k % columns) as f64 + 0.5, (k / columns) as f64 + 0.5);
    (0..columns * rows).map(move |k| size * place(k) / parts)
}

/// Some of the variants that the picture is made of, evenly taken.
pub(super) fn some_variants(system: &System, count: usize) -> Vec<System> {
    if system.effects.dimensions() == 0 {
        return Vec::new();
    }
    system.effects.variants(0).some(count).iter().map(|variant| system.variant(variant)).collect()
}

/// Refuses an instrument through whose prism no ray of the picture passes.
///
/// # Errors
/// A [`Error`] with the fates of the rays, and what is to be written instead as far as the surfaces tell it.
pub fn require_light(scene: &Scene, system: &System) -> Result<(), Error> {
    let passes = |system: &System| grid(system, RAYS).any(|px| system.exit_ray(px).is_ok());
    let passes_finely = |system: &System, most: [usize; 2]| {
        let size = system.camera.size_px();
        let count = [0, 1].map(|k| size[k].min(most[k]));
        let half = DVec2::new(size[0] as f64 / count[0] as f64, size[1] as f64 / count[1] as f64) * 0.5;
        // The middles of parts, and their corners: of an even picture those lie on its axes.
        let passes = |px: DVec2| system.exit_ray(px).is_ok() || system.exit_ray(px - half).is_ok();
        grid(system, count).par_bridge().any(passes)
    };
    if system.prism.is_none() || passes(system) {
        return Ok(());
    }
    let variants = some_variants(system, VARIANTS);
    if variants.iter().any(passes)
        || passes_finely(system, FINE_RAYS)
        || variants.iter().any(|variant| passes_finely(variant, FINE_RAYS_OF_VARIANT))
    {
        return Ok(());
    }
    let study = LightStudy::new(system);
    let rule = format!("no ray of the picture passes the prism: of {} rays {}", RAYS[0] * RAYS[1], study.fates());
    let as_designed = system.with_effects(&scene.effects.only(|row| row.id != EffectId::Manufacture));
    if as_designed != *system && passes(&as_designed) {
        let help = "the prism as it is designed lets them pass: lessen the errors in `[effect.manufacture]`";
        return Err(Error::new("the prism", rule, help));
    }
    let help = shape_doubts::of(scene, system).into_iter().next().unwrap_or_else(|| {
        let most = study.lost.iter().max_by_key(|(_, n)| **n).map(|(fate, _)| *fate);
        match most {
            Some(Fate::TotalReflection) => "give a smaller index ratio, or surfaces that are less steep".to_owned(),
            Some(Fate::Clipped) => "widen what clips the rays: `effect.clipping`".to_owned(),
            _ => shape_doubts::where_it_is(scene, system),
        }
    });
    Err(Error::new("the prism", rule, help))
}
