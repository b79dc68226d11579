//! The time of a picture, from small pieces of it.

use crate::effect::{Hook, Picture};
use crate::raster::Raster;
use crate::render::{DiffractionSample, GhostSample, Plan, frame_px};
use crate::system::System;
use glam::DVec2;
use std::time::Instant;

/// Passes that are looked at, at most.
const MOST_PASSES: usize = 16;
/// Pieces of each, at most.
const PIECES: usize = 24;
/// A pass that took less than this and is the first was cold: it warms up and is not counted, in s.
const WARM_UP_S: f64 = 0.02;
/// Side of the first piece that is traced, in px, and of those that follow where it was cheap.
const SIDES_PX: [usize; 2] = [4, 16];
/// A piece is cheap below this, in s.
const CHEAP_S: f64 = 0.002;
/// Side of the picture on which film effects are timed, in px.
const FILM_PX: usize = 64;
/// Side of the part of a picture on which diffraction is timed, in px.
const DIFFRACTION_PX: usize = 128;
/// The times of pieces tell that of the picture to this factor, besides their own spread: threads share a machine, and its
/// clock is not steady.
const FACTOR: f64 = 1.6;

/// What the pieces tell of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PictureTime {
    /// Its time, in s.
    pub(super) time_s: f64,
    /// The time is within this factor of it, either way.
    pub(super) factor: f64,
    /// The accuracy that the pieces kept to, in px: no better is that of the picture.
    pub(super) achieved_px: f64,
}

/// Times of equal things.
#[derive(Default)]
struct Times {
    seconds: Vec<f64>,
}

impl Times {
    fn add(&mut self, seconds: f64) {
        self.seconds.push(seconds);
    }

    fn mean(&self) -> f64 {
        if self.seconds.is_empty() { 0.0 } else { self.seconds.iter().sum::<f64>() / self.seconds.len() as f64 }
    }

    /// Variance of the mean.
    fn variance(&self) -> f64 {
        let (n, mean) = (self.seconds.len() as f64, self.mean());
        if n < 2.0 {
            return mean * mean;
        }
        self.seconds.iter().map(|s| (s - mean) * (s - mean)).sum::<f64>() / (n * (n - 1.0))
    }
}

/// Seconds that `work` takes, and what it gives.
fn timed<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let start = Instant::now();
    let result = std::hint::black_box(work());
    (start.elapsed().as_secs_f64(), result)
}

/// Place k of a sequence that fills the unit square evenly (Roberts 2018, the R2 sequence).
fn place(k: usize) -> DVec2 {
    let fill = |alpha: f64| (0.5 + alpha * (k + 1) as f64).fract();
    DVec2::new(fill(0.754_877_666_246_693), fill(0.569_840_290_998_053_3))
}

/// The time of the picture that `system` takes, from what fits into `patience_s`, and one pass with one piece at the least.
pub(super) fn picture_time(system: &System, patience_s: f64) -> PictureTime {
    // Among the threads, where a piece is not handed over to another one.
    let mut found = None;
    rayon::scope(|_| found = Some(from_pieces(system, patience_s)));
    found.expect("the scope has run to its end")
}

fn from_pieces(system: &System, patience_s: f64) -> PictureTime {
    let effects = &system.effects();
    let begun = Instant::now();
    let framed = &system.framed(frame_px(system));
    let variants = effects.averages().then(|| effects.variants(0));
    let passes = variants.as_ref().map_or(1, |variants| variants.len() * effects.sets());

    // Time passes that are spread over all of them.
    let mut sum = PassTimes::default();
    for k in 0..MOST_PASSES.min(2 * passes) {
        let left_s = patience_s - begun.elapsed().as_secs_f64();
        if k > 0 && left_s <= 0.0 {
            break;
        }
        let (setting_up_s, instrument) = timed(|| match &variants {
            None => framed.clone(),
            Some(all) => framed.variant(&all.get(((place(k).x * all.len() as f64) as usize).min(all.len() - 1))),
        });
        let (planning_s, plan) = timed(|| Plan::new(&instrument));
        let cold = k == 0 && setting_up_s + planning_s < WARM_UP_S;
        sum.pass(&plan, k, if cold { 0.25 * left_s } else { 0.5 * left_s });
        if cold && begun.elapsed().as_secs_f64() < patience_s {
            sum = PassTimes { achieved_px: sum.achieved_px, ..PassTimes::default() };
        } else {
            sum.once.add(setting_up_s + planning_s);
        }
    }

    // All passes, what is true of the picture, and the film.
    let whole = sum.of_pass(framed);
    let own = if effects.averages() { whole.0 } else { 0.0 };
    let time_s = passes as f64 * whole.0 + own + diffraction_time(framed, passes) + film_time(system);
    let relative = if whole.0 > 0.0 { whole.1.sqrt() / whole.0 } else { 0.0 };
    PictureTime { time_s, factor: FACTOR + 2.0 * relative, achieved_px: sum.achieved_px }
}

/// The times of parts of passes.
#[derive(Default)]
struct PassTimes {
    /// Setting up and planning.
    once: Times,
    /// A pixel of the map, of those traced, and of ghosts.
    pixel: [Times; 3],
    /// Pixels of a pass of each kind.
    pixels: [f64; 3],
    achieved_px: f64,
}

impl PassTimes {
    /// Times pieces of one pass for about `patience_s`.
    fn pass(&mut self, plan: &Plan, number: usize, patience_s: f64) {
        let begun = Instant::now();
        let work = plan.pixel_work();
        let [width, height] = plan.system().camera().size_px();
        let with_ghosts = plan.system().effects().ghosts.is_some_and(|ghosts| !ghosts.is_nothing());
        self.pixels = [work.mapped as f64, work.traced as f64, if with_ghosts { (width * height) as f64 } else { 0.0 }];
        let map_px = plan.account(0.0).achieved_px();
        let mut side = SIDES_PX[0];
        for k in 0..PIECES {
            // Every other piece is of what is traced, which may be a small part of the picture and most of its time.
            let at = place(PIECES * number + k);
            let traced = || if k % 2 == 1 { plan.sample_traced(at, side) } else { None };
            let (seconds, piece) = timed(|| traced().unwrap_or_else(|| plan.sample(at, side)));
            self.pixel[usize::from(!piece.mapped)].add(seconds / piece.pixels as f64);
            self.achieved_px = self.achieved_px.max(map_px + piece.bend_px);
            if !piece.mapped && seconds < CHEAP_S {
                side = SIDES_PX[1];
            }
            if with_ghosts && k % 4 == 0 {
                let mut sample = GhostSample::new(plan, place(PIECES * number + k), side);
                let (seconds, pixels) = timed(|| sample.add());
                self.pixel[2].add(seconds / pixels as f64);
            }
            if begun.elapsed().as_secs_f64() > patience_s {
                break;
            }
        }
    }

    /// The time of a pass of `system`, and the variance of it.
    fn of_pass(&self, system: &System) -> (f64, f64) {
        let [_, height] = system.camera().size_px();
        // Each thread makes a band of some rows at a time.
        let bands = height.div_ceil(crate::render::STRIP_ROWS);
        let threads = rayon::current_num_threads().min(bands) as f64;
        // Of a way that no piece was made in, the other one's time stands.
        let fallback = self.pixel[0].mean().max(self.pixel[1].mean());
        let mut sum = (self.once.mean(), self.once.variance());
        for (times, pixels) in self.pixel.iter().zip(self.pixels) {
            let each = if times.seconds.is_empty() { fallback } else { times.mean() };
            sum.0 += each * pixels / threads;
            sum.1 += times.variance() * (pixels / threads) * (pixels / threads);
        }
        sum
    }
}

/// The time of what diffraction adds to a picture of so many passes, from a part of it.
fn diffraction_time(system: &System, passes: usize) -> f64 {
    if system.effects().diffracting().is_none() {
        return 0.0;
    }
    let (once_s, sample) = timed(|| DiffractionSample::new(system, DIFFRACTION_PX));
    let (one_s, pixels) = timed(|| sample.spread(1));
    let (two_s, _) = timed(|| sample.spread(2));
    let shares = system.camera().size_px().iter().product::<usize>() as f64 / pixels as f64;
    once_s + shares * (one_s + (passes - 1) as f64 * (two_s - one_s).max(0.0))
}

/// The time of the sensor of a picture, from a small one.
fn film_time(system: &System) -> f64 {
    if !system.effects().act_by(Hook::Film) {
        return 0.0;
    }
    let [width, height] = system.camera().size_px();
    let (columns, rows) = (width.min(FILM_PX), height.min(FILM_PX));
    let grey = Raster::filled(columns, rows, 0.5);
    let (seconds, _) = timed(|| system.effects().develop(Picture { grey, colour: None }));
    seconds * (width * height) as f64 / (columns * rows) as f64
}
