//! What accuracy costs in time: the knobs of the simulator and of the design turned one by one, each setting timed and
//! compared with the reference. With the command line the only place that reads the clock.
//!
//! Times are of the machine that runs the study, in one interleaved run: each repetition takes every setting once, so that
//! a busy moment falls on all alike. A fixed kernel, timed among them, is the yardstick between machines.

mod corners;
mod designs;
mod eye;
mod lines;
mod meshes;
mod time;
mod ways;

use crate::accuracy::{Accuracy, Level};
use crate::raster::Raster;
use crate::render::{Account, Counts, Wanted, render_wanted};
use crate::scene::Scene;
use crate::system::System;
use corners::Corners;
use eye::Eye;
use glam::DVec2;
use lines::line_shifts;
use time::{Job, Taken};
use ways::Way;

pub use designs::Design;
pub use eye::Measured;
pub use meshes::Meshed;
pub use time::{Spread, calibration, cpu_ms};

/// How much the study does.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Repetitions of each setting.
    pub repetitions: usize,
    /// A setting is not repeated once it has taken this long altogether, in s.
    pub patience_s: f64,
    /// Levels of accuracy that are timed.
    pub levels: Vec<Level>,
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
            levels: Level::ALL.to_vec(),
            supersampling: vec![1, 2, 4, 8],
            steps_um: vec![91.0, 55.0, 22.0, 11.0, 5.5, 2.75, 1.0],
            degrees: vec![3, 4, 5, 6, 7, 9],
            triangles: vec![1_000, 10_000, 100_000, 1_000_000],
        }
    }
}

impl Settings {
    /// A first look: the cheap end of each range. Of the reference only the picture is made that others are held against.
    pub fn quick() -> Self {
        Self {
            patience_s: 0.5,
            levels: Level::ALL.into_iter().filter(|level| *level != Level::Reference).collect(),
            supersampling: vec![1, 2],
            steps_um: vec![91.0, 22.0],
            degrees: vec![3, 5],
            triangles: vec![1_000],
            ..Self::default()
        }
    }
}

/// The study.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Study {
    /// The yardstick: ns of CPU time for one ray of [`calibration`].
    pub yardstick_ns: Spread,
    /// Columns and rows of a picture.
    pub size_px: [usize; 2],
    /// What the reference says of itself.
    pub reference: Account,
    /// Corners whose exact positions were compared.
    pub corners: usize,
    /// Settings of the simulator.
    pub pictures: Vec<Setting>,
    /// The prism as triangles.
    pub meshes: Vec<Meshed>,
    /// Settings of the design; none where the scene does not design its prism.
    pub designs: Vec<Design>,
}

/// One setting of the simulator.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Setting {
    /// What was turned.
    pub knob: &'static str,
    /// To what, in words.
    pub value: String,
    /// To what, as a number, to be put on an axis.
    pub number: f64,
    /// CPU time of a picture on one thread, in ms.
    pub time_ms: Spread,
    /// The same, over that of the yardstick at one ray a pixel.
    pub yardsticks: Spread,
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
    /// What the corner detector finds in the picture.
    pub measured: Measured,
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

/// What the study does next, and how much of it there is.
pub type Stage<'a> = dyn FnMut(&'static str, usize) + 'a;

/// Turns the knobs of `system`, the instrument of `scene`. `stage` hears what is done next and of how many steps it is,
/// `done` how many of these are done.
pub fn cost(
    scene: &Scene,
    system: &System,
    settings: &Settings,
    stage: &mut Stage<'_>,
    done: &(dyn Fn(usize) + Sync),
) -> Study {
    let [width, height] = system.camera.size_px();
    stage("reference", width * height);
    let exact = System { accuracy: Accuracy::reference(), ..system.clone() };
    let reference = render_wanted(&exact, Wanted { truth: false }, done);
    let corners = Corners::of(&exact);
    let eye = Eye::new(system, &reference.radiance);

    let pool = time::one_thread();
    let ways = ways::all(settings);
    let meshes = pool.install(|| meshes::all(&exact, settings));
    let designs = designs::all(scene, settings);
    let pictures = ways.iter().map(|way| job(|| way.picture(system)));
    let traces = meshes.iter().map(|mesh| job(|| mesh.trace()));
    let jobs: Vec<Job> = pictures.chain(traces).chain(designs.iter().map(|plan| job(|| plan.make()))).collect();
    stage("times", jobs.len() * settings.repetitions.max(1));
    let times = pool.install(|| time::interleaved(&jobs, settings.repetitions, settings.patience_s, done));
    let (of_pictures, rest) = times.split_at(ways.len());
    let (of_meshes, of_designs) = rest.split_at(meshes.len());

    stage("errors", jobs.len());
    let judge = Judge { system, reference: &reference.radiance, corners: &corners, eye: &eye };
    let heard = |_: &_| done(1);
    let pictures = ways.iter().zip(of_pictures).map(|(way, taken)| judge.setting(way, taken)).inspect(heard).collect();
    let heard = |_: &_| done(1);
    let meshes =
        meshes.iter().zip(of_meshes).map(|(mesh, taken)| mesh.judged(&corners, taken)).inspect(heard).collect();
    let heard = |_: &_| done(1);
    let designs = designs.iter().zip(of_designs).map(|(plan, taken)| plan.judged(scene, taken)).inspect(heard);
    let designs = designs.flatten().collect();
    Study {
        yardstick_ns: time::yardstick_ns(&times),
        size_px: [width, height],
        reference: reference.account,
        corners: corners.count(),
        pictures,
        meshes,
        designs,
    }
}

/// Work whose result is of no interest, and may not be left out for that.
fn job<'a, T>(work: impl Fn() -> T + Sync + 'a) -> Job<'a> {
    Box::new(move || {
        std::hint::black_box(work());
    })
}

/// What pictures are held against.
struct Judge<'a> {
    system: &'a System,
    reference: &'a Raster<f32>,
    corners: &'a Corners,
    eye: &'a Eye,
}

impl Judge<'_> {
    /// A setting, given the times of its pictures.
    fn setting(&self, way: &Way, taken: &Taken) -> Setting {
        let Self { system, reference, corners, eye } = self;
        let made = way.picture(system);
        let contrast = system.board.pattern.white - system.board.pattern.black;
        Setting {
            knob: way.knob,
            value: way.value.clone(),
            number: way.number,
            time_ms: taken.spread_ms(1.0),
            yardsticks: taken.in_yardsticks(reference.data().len() as f64),
            counts: made.counts,
            rmse: rmse(&made.radiance, reference),
            lines_px: Shifts::of(&line_shifts(&made.radiance, reference, contrast)),
            corners_px: way.accuracy().and_then(|accuracy| corners.shifts(system, accuracy)),
            measured: eye.measure(system, &made.radiance),
            account: made.account,
        }
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
