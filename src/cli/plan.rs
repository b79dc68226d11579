//! The plan of a picture as `biprism check` shows it: path, effects, samples, time, memory, fates.

use crate::accuracy::Sampling;
use crate::analysis::forecast::{Forecast, forecast, smaller};
use crate::render::{Wanted, render_wanted};
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
pub(super) struct Plan {
    forecast: Forecast,
    /// Of the picture, in s.
    time_s: f64,
    /// What each effect that is left out would add, in s, in the order of the forecast.
    saved_s: Vec<Option<f64>>,
}

impl Plan {
    /// The plan of the picture of `scene`, whose instrument is `system`, settled by `verdicts`, and `ideal` without effects. Times are those of pictures made now: of the picture
    /// itself where it is small, else of one of fewer pixels, times the ratio of pixels. Larger pixels have more edges and more
    /// bend in them, so that such a time says too much.
    pub(super) fn new(scene: &Scene, ideal: &System, system: &System, verdicts: Vec<Verdict>) -> Self {
        let forecast = forecast(system, verdicts);
        let dropped: Vec<&str> = forecast.effects.iter().filter(|e| !e.kept).map(|e| e.effect).collect();
        let time_s = time(ideal, scene, &dropped);
        let saved = |key: &str| {
            let others: Vec<&str> = dropped.iter().copied().filter(|k| *k != key).collect();
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
        let Forecast { level, sampling, patches, mapped, passes, samples, effects, memory_bytes, fates } =
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
            (1, 1) => "samples one picture, exact means of its pixels\n".to_owned(),
            (passes, 1) => format!("samples mean of {passes} pictures, each of exact means of its pixels\n"),
            (passes, n) => format!("samples mean of {passes}, with {n} x {n} samples a pixel for the film\n"),
        };
        text += &format!("time    about {:.2} s here, measured on smaller pictures where it is large\n", self.time_s);
        text += &format!("memory  about {:.1} MB for the picture and its ground truth\n", *memory_bytes as f64 / 1e6);
        let ended: Vec<String> = fates.iter().map(|(fate, share)| format!("{:.1} % {fate}", 100.0 * share)).collect();
        let ended = if ended.is_empty() { "every ray reaches the board's plane".to_owned() } else { ended.join(", ") };
        text += &format!("fates   {ended}\n");
        if effects.is_empty() {
            return text + "effects none\n";
        }
        text += "effects              grey       px    is       saves    because\n";
        for (effect, saved_s) in effects.iter().zip(&self.saved_s) {
            let number = |of: fn(&crate::system::Bound) -> f64| {
                effect.bound.as_ref().map_or_else(|| "unknown".to_owned(), |b| format!("{:.1e}", of(b)))
            };
            let kept = if effect.kept { "kept" } else { "dropped" };
            let saves = saved_s.map_or_else(String::new, |s| format!("{s:.2} s"));
            text += &format!(
                "  {:14} {:>8} {:>8}    {kept:8} {saves:8} {}\n",
                effect.effect,
                number(|bound| bound.grey),
                number(|bound| bound.px),
                effect.why
            );
        }
        text
    }
}

/// The time of a picture of `scene` without the effects `left_out`, in s, from smaller ones.
fn time(ideal: &System, scene: &Scene, left_out: &[&str]) -> f64 {
    let system = smaller(ideal, scene, left_out);
    let begun = Instant::now();
    let mut fastest = f64::INFINITY;
    for _ in 0..REPETITIONS {
        let start = Instant::now();
        std::hint::black_box(render_wanted(&system, Wanted { truth: true }, &|_| ()));
        fastest = fastest.min(start.elapsed().as_secs_f64());
        if begun.elapsed().as_secs_f64() > PATIENCE_S {
            break;
        }
    }
    let [width, height] = system.camera.size_px();
    fastest * (scene.camera.width_px * scene.camera.height_px) as f64 / (width * height) as f64
}
