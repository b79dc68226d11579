//! What accuracy costs in time: the knobs of the simulator and of the design turned one by one, each setting timed and
//! compared with the reference. With the command line the only place that reads the clock.
//!
//! Times are of the machine that runs the study, in one interleaved run: each repetition takes every setting once, so that
//! a busy moment falls on all alike. A fixed kernel, timed among them, is the yardstick between machines.

mod corners;
mod designs;
mod lines;
mod meshes;
mod time;
mod ways;

use crate::accuracy::Accuracy;
use crate::raster::Raster;
use crate::render::{Account, Counts, render};
use crate::scene::Scene;
use crate::system::System;
use corners::Corners;
use glam::DVec2;
use lines::line_shifts;

pub use designs::Design;
pub use meshes::Meshed;
pub use time::{Spread, calibration};

/// How much the study does.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Repetitions of each setting.
    pub repetitions: usize,
    /// A setting is not repeated once it has taken this long altogether, in s.
    pub patience_s: f64,
    /// Side of the grids of samples a pixel that stand for a renderer without knowledge of its scene.
    pub supersampling: Vec<usize>,
    /// Steps of the design's integration, in um on the sensor.
    pub steps_um: Vec<f64>,
    /// Degrees of the polynomials that are fitted to a design.
    pub degrees: Vec<usize>,
    /// Triangles of front and back together.
    pub triangles: Vec<usize>,
}

impl Default for Settings {
    /// The ranges of the design paper's Fig. 4(b) and beyond.
    fn default() -> Self {
        Self {
            repetitions: 7,
            patience_s: 6.0,
            supersampling: vec![1, 2, 4, 8],
            steps_um: vec![91.0, 55.0, 22.0, 11.0, 5.5, 2.75, 1.0],
            degrees: vec![3, 4, 5, 6, 7, 9],
            triangles: vec![1_000, 10_000, 100_000, 1_000_000],
        }
    }
}

/// The study.
#[derive(Debug, Clone, PartialEq)]
pub struct Study {
    /// The yardstick: ns of CPU time for one ray of [`calibration`].
    pub calibration_ns: Spread,
    /// Pixels of a picture.
    pub pixels: usize,
    /// What the reference says of itself.
    pub reference: Account,
    /// Corners whose positions were compared.
    pub corners: usize,
    /// Settings of the simulator.
    pub pictures: Vec<Setting>,
    /// The prism as triangles.
    pub meshes: Vec<Meshed>,
    /// Settings of the design; none where the scene does not design its prism.
    pub designs: Vec<Design>,
}

/// One setting of the simulator.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// What was turned.
    pub knob: &'static str,
    /// To what, in words.
    pub value: String,
    /// To what, as a number, to be put on an axis.
    pub number: f64,
    /// CPU time of a picture, in ms: wall time on one thread.
    pub time_ms: Spread,
    /// How much work a picture was; of point samples only the rays are counted.
    pub counts: Counts,
    /// Root of the mean square of the pixels' difference from the reference, of full scale 1.
    pub rmse: f64,
    /// Shifts of the pattern's lines against the reference, from the pixels: at every crossing of a line by a row or a
    /// column of pixels, the integral of the difference across it over the contrast.
    pub lines_px: Option<Shifts>,
    /// Shifts of the board's corners: the distance of what a corner's exact position is said to see from the corner.
    /// `None` of point samples, which say nothing between them.
    pub corners_px: Option<Shifts>,
    /// What the level says of itself; `None` of point samples.
    pub account: Option<Account>,
}

/// Sizes of shifts, in px.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Shifts {
    /// How many were measured.
    pub n: usize,
    /// sqrt(sum d^2 / n)
    pub rms: f64,
    /// Ninety-nine of a hundred are below this.
    pub p99: f64,
    /// The largest.
    pub max: f64,
}

impl Shifts {
    /// The sizes of `shifts_px`; `None` of none.
    fn of(shifts_px: &[f64]) -> Option<Self> {
        use crate::num::stats::{max_abs, quantile, rms};
        let sizes: Vec<f64> = shifts_px.iter().map(|s| s.abs()).collect();
        let p99 = quantile(&sizes, 0.99)?;
        Some(Self { n: sizes.len(), rms: rms(&sizes), p99, max: max_abs(&sizes) })
    }
}

/// Turns the knobs of `system`, the instrument of `scene`. `stage` hears what is done next.
pub fn cost(scene: &Scene, system: &System, settings: &Settings, stage: &mut dyn FnMut(&str)) -> Study {
    stage("reference");
    let exact = System { accuracy: Accuracy::reference(), ..system.clone() };
    let reference = render(&exact, &|_| ());
    let corners = Corners::of(&exact);
    stage("pictures");
    let ways = ways::all(settings);
    let pool = time::one_thread();
    let mut makers: Vec<Box<dyn Fn() + Sync + '_>> = vec![Box::new(|| {
        std::hint::black_box(calibration(std::hint::black_box(time::CALIBRATION_RAYS)));
    })];
    for way in &ways {
        makers.push(Box::new(|| {
            std::hint::black_box(way.picture(system));
        }));
    }
    let mut times = pool.install(|| time::interleaved(&makers, settings.repetitions, settings.patience_s));
    drop(makers);
    let calibration_ns = times.remove(0).scaled(1e6 / time::CALIBRATION_RAYS as f64);
    let board = &system.board.pattern;
    let contrast = board.white - board.black;
    let pictures = ways
        .iter()
        .zip(times)
        .map(|(way, time_ms)| {
            let made = way.picture(system);
            Setting {
                knob: way.knob,
                value: way.value.clone(),
                number: way.number,
                time_ms,
                counts: made.counts,
                rmse: rmse(&made.radiance, &reference.radiance),
                lines_px: Shifts::of(&line_shifts(&made.radiance, &reference.radiance, contrast)),
                corners_px: way.accuracy().and_then(|accuracy| corners.shifts(system, accuracy)),
                account: made.account,
            }
        })
        .collect();
    stage("meshes");
    let meshes = meshes::all(&exact, &corners, settings);
    stage("designs");
    let designs = designs::all(scene, settings);
    let [width, height] = system.camera.size_px();
    Study {
        calibration_ns,
        pixels: width * height,
        reference: reference.account,
        corners: corners.count(),
        pictures,
        meshes,
        designs,
    }
}

fn rmse(a: &Raster<f32>, b: &Raster<f32>) -> f64 {
    let squares = a.data().iter().zip(b.data()).map(|(a, b)| f64::from(a - b) * f64::from(a - b));
    (squares.sum::<f64>() / a.data().len() as f64).sqrt()
}

/// The shift in px that a difference on the board stands for, given d board / d px.
fn shift_px(jacobian: glam::DMat2, difference_mm: DVec2) -> f64 {
    (jacobian.inverse() * difference_mm).length()
}

#[cfg(test)]
mod tests;
