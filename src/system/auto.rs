//! Automatic choice of effects: what each changes at most, against the threshold below which the scene leaves them out.

use super::bounds::{bound, ghosts_light};
use super::instrument::System;
use super::output_gain::OutputGain;
use super::radiance_range::Bound;
use crate::effect::{Bounding, EffectId, EffectRow, Effects, TABLE};
use crate::scene::Scene;

/// What becomes of an effect.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Verdict {
    /// Which effect.
    pub effect: EffectId,
    /// What it changes at most; `None` where no bound is known.
    pub bound: Option<Bound>,
    /// Whether it is simulated.
    pub kept: bool,
    /// Why.
    pub why: &'static str,
}

/// What becomes of every effect that acts in a scene, whose instrument without effects is `ideal`; all are kept where the
/// scene asks for all of them.
///
/// The effects are gone through from the weakest on, what others need after all of them, and left out as long as
/// all that are left out change no more than the threshold even if their changes add up.
pub fn verdicts(ideal: &System, scene: &Scene) -> Vec<Verdict> {
    // Bound the change of every effect.
    let effects = &scene.effects;
    let gain = OutputGain::of(ideal, scene);
    // What an effect changes of objects is not bounded.
    let bounded = scene.objects.is_empty();
    let ghosts = if bounded { ghosts_light(ideal, effects, &gain) } else { None };
    let bound_of = |row| if bounded { bound(ideal, scene, &gain, ghosts, row) } else { None };
    let verdict = |row: &'static EffectRow| {
        let why = match (effects.auto, row.bounding) {
            (None, _) => "the scene asks for it",
            (_, Bounding::Never(why)) => why,
            _ => "no bound of its change is known",
        };
        Verdict { effect: row.id, bound: bound_of(row), kept: true, why }
    };
    let mut all: Vec<Verdict> = effects.acting().map(verdict).collect();
    if ideal.prism.is_none() {
        for idle in all.iter_mut().filter(|verdict| verdict.effect.row().of_glass) {
            (idle.kept, idle.why) = (false, "there is no glass by which it acts");
        }
    }
    let Some(threshold) = effects.auto else { return all };

    // Order the effects by their bounds, the weakest first.
    let share = |bound: Bound| threshold.share(bound.grey, bound.px);
    let mut order: Vec<usize> = (0..all.len()).collect();
    let own = |k: usize| all[k].bound.map_or(f64::INFINITY, share);
    let stands_on = |effect: EffectId, base: EffectId| effect.row().needs == Some(base);
    // What others stand on is judged after all of them.
    let place = |k: usize| {
        let base = all[k].effect;
        let others = order.iter().copied().filter(|other| stands_on(all[*other].effect, base)).map(own);
        let is_base = TABLE.iter().any(|row| row.needs == Some(base));
        (others.fold(own(k), f64::max), u8::from(is_base))
    };
    let weights: Vec<(f64, u8)> = order.iter().map(|k| place(*k)).collect();
    order.sort_by(|a, b| weights[*a].0.total_cmp(&weights[*b].0).then(weights[*a].1.cmp(&weights[*b].1)));

    // Leave out effects as long as their changes together are within the threshold.
    let mut left_out = Bound { grey: 0.0, px: 0.0 };
    for k in order {
        let Some(bound) = all[k].bound else { continue };
        let together = Bound { grey: left_out.grey + bound.grey, px: left_out.px + bound.px };
        let needed = all.iter().any(|v| v.kept && stands_on(v.effect, all[k].effect));
        let (kept, why) = match () {
            () if share(bound) > 1.0 => (true, "may change more than the threshold"),
            () if needed => (true, "another effect that is kept stands on it"),
            () if share(together) > 1.0 => (true, "may change more than the threshold with those left out"),
            () => (false, "changes less than the threshold"),
        };
        (all[k].kept, all[k].why) = (kept, why);
        if !kept {
            left_out = together;
        }
    }
    all
}

/// The effects of a scene that its picture is rendered with.
pub fn settled(verdicts: &[Verdict], scene: &Scene) -> Effects {
    match scene.effects.auto {
        None => scene.effects.clone(),
        Some(_) => scene.effects.only(|row| verdicts.iter().any(|verdict| verdict.effect == row.id && verdict.kept)),
    }
}
