//! The plan of a picture as `biprism check` shows it: path, effects, samples, time, memory, fates.

use crate::accuracy::Sampling;
use crate::analysis::estimate::{PictureEstimate, forecast, smaller};
use crate::effect::EffectId;
use crate::render::{Outputs, render_wanted};
use crate::scene::Scene;
use crate::system::System;
use crate::system::auto::Verdict;
use serde_json::{Value, json};
use std::time::Instant;

/// Pictures of which the fastest is taken for the time of one, while they take no longer together than [`PATIENCE_S`].
const REPETITIONS: usize = 3;
/// A picture is not made again once this has passed, in s.
const PATIENCE_S: f64 = 1.0;

/// A forecast with what it costs in time.
pub(super) struct TimedEstimate {
    forecast: PictureEstimate,
    /// Of the picture, in s.
    time_s: f64,
    /// What each effect that is left out would add, in s, in the order of the forecast.
    saved_s: Vec<Option<f64>>,
}

impl TimedEstimate {
    /// The plan of the picture of `scene`, whose instrument is `system`, settled by `verdicts`, and `ideal` without effects.
    /// Times are those of pictures made now: of the picture itself where it is small, else of one of fewer pixels, times the
    /// ratio of pixels. Larger pixels have more edges and more bend in them, so that such a time says too much.
    pub(super) fn new(scene: &Scene, ideal: &System, system: &System, verdicts: Vec<Verdict>) -> Self {
        let forecast = forecast(system, verdicts);
        let dropped: Vec<EffectId> = forecast.effects.iter().filter(|e| !e.kept).map(|e| e.effect).collect();
        let time_s = time(ideal, scene, &dropped);
        let saved = |effect: EffectId| {
            let others: Vec<EffectId> = dropped.iter().copied().filter(|other| *other != effect).collect();
            (time(ideal, scene, &others) - time_s).max(0.0)
        };
        let saved_s = forecast.effects.iter().map(|e| (!e.kept).then(|| saved(e.effect))).collect();
        Self { forecast, time_s, saved_s }
    }

    /// The plan for a script.
    pub(super) fn json(&self) -> Value {
        let mut value = json!(self.forecast);
        value["time_s"] = json!(self.time_s);
        for (effect, saved_s) in self.saved_s.iter().enumerate() {
            value["effects"][effect]["saved_s"] = json!(saved_s);
        }
        value
    }

    /// The plan for a person: lines of words.
    pub(super) fn text(&self) -> String {
        let PictureEstimate { level, sampling, patches, mapped, passes, samples, effects, memory_bytes, fates, .. } =
            &self.forecast;
        let path = match sampling {
            Sampling::Map if *patches > 0 => {
                format!("a map of {patches} patches for {:.1} % of the pixels", 100.0 * mapped)
            }
            Sampling::Map | Sampling::Packets => "every pixel traced, by packets where they serve".to_owned(),
            Sampling::SingleRays => "every pixel traced, ray by ray, and divided".to_owned(),
        };
        let mut text = format!("path    {}: {path}\n", level.name());
        text += &match (*passes, *samples) {
            (1, 1) => "samples one picture, exact means of its pixels".to_owned(),
            (passes, 1) => format!("samples mean of {passes} pictures, each of exact means of its pixels"),
            (passes, n) => format!("samples mean of {passes}, with {n} x {n} samples a pixel for the film"),
        };
        text += &match self.forecast.ghost_samples {
            0 => "\n".to_owned(),
            n => format!("; ghosts by {n} x {n} rays a pixel where their ways part\n"),
        };
        let time = two_digits(self.time_s);
        text += &format!("time    about {time} s here, measured on smaller pictures where it is large\n");
        let memory = two_digits(*memory_bytes as f64 / 1e6);
        text += &format!("memory  about {memory} MB for the picture and its ground truth, besides the program\n");
        let ended: Vec<String> = fates.iter().map(|(fate, share)| format!("{:.1} % {fate}", 100.0 * share)).collect();
        let ended = if ended.is_empty() { "every ray reaches the board's plane".to_owned() } else { ended.join(", ") };
        let which = if self.forecast.other_rays { ", through the middle of the pupil" } else { "" };
        text += &format!("fates   {ended}{which}\n");
        if effects.is_empty() {
            return text + "effects none\n";
        }
        text += "effects              grey       px    is       saves     because\n";
        for (effect, saved_s) in effects.iter().zip(&self.saved_s) {
            let number = |of: fn(&crate::system::Bound) -> f64| {
                effect.bound.as_ref().map_or_else(|| "unknown".to_owned(), |b| no_less(of(b)))
            };
            let kept = if effect.kept { "kept" } else { "dropped" };
            let saves = saved_s.map_or_else(String::new, |s| format!("{} s", two_digits(s)));
            text += &format!(
                "  {:14} {:>8} {:>8}    {kept:8} {saves:9} {}\n",
                effect.effect.key(),
                number(|bound| bound.grey),
                number(|bound| bound.px),
                effect.why
            );
        }
        text
    }
}

/// A size of 0 or more to two significant digits, and all those before the point.
fn two_digits(value: f64) -> String {
    let behind = if value > 0.0 { 1.0 - libm::floor(libm::log10(value)) } else { 0.0 };
    format!("{value:.*}", behind.clamp(0.0, 12.0) as usize)
}

/// A bound to two digits that are not below it.
fn no_less(bound: f64) -> String {
    let step = if bound > 0.0 { libm::pow(10.0, libm::floor(libm::log10(bound)) - 1.0) } else { 0.0 };
    let nearest = format!("{bound:.1e}");
    let below = nearest.parse().is_ok_and(|shown: f64| shown < bound);
    if below { format!("{:.1e}", bound + 0.5 * step) } else { nearest }
}

/// The time of a picture of `scene` without the effects `left_out`, in s, from smaller ones.
fn time(ideal: &System, scene: &Scene, left_out: &[EffectId]) -> f64 {
    let system = smaller(ideal, scene, left_out);
    let begun = Instant::now();
    let mut fastest = f64::INFINITY;
    for _ in 0..REPETITIONS {
        let start = Instant::now();
        std::hint::black_box(render_wanted(&system, Outputs { truth: true }, &()));
        fastest = fastest.min(start.elapsed().as_secs_f64());
        if begun.elapsed().as_secs_f64() > PATIENCE_S {
            break;
        }
    }
    let [width, height] = system.camera().size_px();
    fastest * (scene.camera.width_px * scene.camera.height_px) as f64 / (width * height) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_keep_two_digits() {
        let cases =
            [(0.0, "0"), (4.2e-5, "0.000042"), (0.0996, "0.100"), (0.314, "0.31"), (8.33, "8.3"), (833.7, "834")];
        for (value, shown) in cases {
            assert_eq!(two_digits(value), shown);
        }
    }

    #[test]
    fn bounds_are_never_shown_too_small() {
        for (bound, shown) in
            [(0.1347, "1.4e-1"), (0.1302, "1.4e-1"), (0.13, "1.3e-1"), (0.0, "0.0e0"), (9.91e-7, "1.0e-6")]
        {
            assert_eq!(no_less(bound), shown);
        }
        for k in 1..2000 {
            let bound = libm::exp(f64::from(k) * 0.0123 - 12.0);
            let shown: f64 = no_less(bound).parse().unwrap_or(0.0);
            assert!(shown >= bound && shown < 1.101 * bound, "{bound}: {shown}");
        }
    }
}
