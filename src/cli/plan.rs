//! The plan of a picture as `biprism check` shows it: path, effects, samples, time, memory, fates.

use super::picture_time::{PictureTime, picture_time};
use crate::accuracy::{FINEST_TARGET_PX, Sampling, is_told_by_radiance};
use crate::analysis::estimate::{PictureEstimate, forecast};
use crate::effect::EffectId;
use crate::scene::Scene;
use crate::system::System;
use crate::system::auto::Verdict;
use serde_json::{Value, json};

/// For this long pieces of the picture are made, to tell its time, in s; and for as long for all effects together that are
/// left out.
const PATIENCE_S: f64 = 0.2;

/// A forecast with what it costs in time.
pub(super) struct TimedEstimate {
    forecast: PictureEstimate,
    /// Of the picture, and what its pieces kept to.
    time: PictureTime,
    /// What was asked for, in px.
    target_px: Option<f64>,
    /// What each effect that is left out would add, in s, in the order of the forecast.
    saved_s: Vec<Option<f64>>,
}

impl TimedEstimate {
    /// The plan of the picture of `scene`, whose instrument is `system`, settled by `verdicts`, and `ideal` without effects.
    /// Times are told from small pieces of the picture: [`picture_time`].
    pub(super) fn new(scene: &Scene, ideal: &System, system: &System, verdicts: Vec<Verdict>) -> Self {
        let forecast = forecast(system, verdicts);
        let dropped: Vec<EffectId> = forecast.effects.iter().filter(|e| !e.kept).map(|e| e.effect).collect();
        let time = picture_time(system, PATIENCE_S);
        let saved = |effect: EffectId| {
            let others: Vec<EffectId> = dropped.iter().copied().filter(|other| *other != effect).collect();
            let with = ideal.with_effects(&scene.effects.only(|row| !others.contains(&row.id)));
            (picture_time(&with, PATIENCE_S / dropped.len() as f64).time_s - time.time_s).max(0.0)
        };
        let saved_s = forecast.effects.iter().map(|e| (!e.kept).then(|| saved(e.effect))).collect();
        Self { forecast, time, target_px: system.accuracy().target_px, saved_s }
    }

    /// Whether the picture can keep to what is asked of it, as far as its pieces tell.
    pub(super) fn in_reach(&self) -> bool {
        self.target_px.is_none_or(|target_px| is_told_by_radiance(target_px) && self.time.achieved_px <= target_px)
    }

    /// The plan for a script.
    pub(super) fn json(&self) -> Value {
        let mut value = json!(self.forecast);
        let PictureTime { time_s, factor, achieved_px } = self.time;
        value["time_s"] = json!(time_s);
        value["time_within_factor"] = json!(factor);
        if let Some(target_px) = self.target_px {
            let target = json!({ "target_px": target_px, "reached_px": achieved_px, "in_reach": self.in_reach() });
            value["target"] = target;
        }
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
            (1, n) => format!("samples one picture, with {n} x {n} cells a pixel on edges for diffraction"),
            (passes, n) => {
                format!("samples mean of {passes} pictures, with {n} x {n} cells a pixel on edges for diffraction")
            }
        };
        text += &match self.forecast.ghost_samples {
            0 => "\n".to_owned(),
            n => format!("; ghosts by {n} x {n} rays a pixel where their ways part\n"),
        };
        if let Some(target_px) = self.target_px.filter(|_| !self.in_reach()) {
            let least = no_less(self.time.achieved_px);
            text += &format!(
                "target  {target_px:e} px is out of reach: pieces of the picture keep to {least} px, and f32 tells \
                 {FINEST_TARGET_PX:e} px\n"
            );
        }
        let PictureTime { time_s, factor, .. } = self.time;
        text += &format!(
            "time    about {} s here to render, within a factor of {factor:.1}, from pieces of the picture; files take more\n",
            two_digits(time_s)
        );
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
