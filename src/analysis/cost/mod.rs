//! What accuracy costs in time: the knobs of the simulator and of the design turned one by one, each setting timed and
//! compared with the reference. With the command line the only place that reads the clock.
//!
//! Times are of the machine that runs the study, in one interleaved run: each repetition takes every setting once, so that
//! a busy moment falls on all alike. A fixed kernel, timed among them, is the yardstick between machines.

mod corners;
mod designs;
mod effects;
mod lines;
mod meshes;
mod time;

use crate::accuracy::Accuracy;
use crate::progress::Observer;
use crate::render::{Outputs, render_wanted};
use crate::scene::Scene;
use crate::system::System;
use corners::ReferenceCorners;
use detector::DetectorRun;
use shift_judge::Judge;
use time::Job;

pub use designs::DesignSetting;
pub use detector::Measured;
pub use effects::FILLED;
pub use meshes::Meshed;
pub use time::{Spread, calibration, cpu_ms};

/// Turns the knobs of `system`, the instrument of `scene`. `observer` hears what is done next, of how many steps
/// it is, and how many of these are done.
pub fn cost(scene: &Scene, system: &System, settings: &CostSettings, observer: &dyn Observer) -> CostStudy {
    let [width, height] = system.camera().size_px();
    observer.stage_of("reference", width * height);
    let exact = system.with_accuracy(Accuracy::reference());
    let reference = render_wanted(&exact, Outputs { truth: false }, observer);
    let corners = ReferenceCorners::of(&exact);
    let eye = DetectorRun::new(system, &reference.radiance);

    let pool = time::one_thread();
    let ways = methods::all(settings);
    let meshes = pool.install(|| meshes::all(&exact, settings));
    let designs = designs::all(scene, settings);
    let seen_with = pool.install(|| effects::all(scene, &exact.without_effects(), settings));
    let pictures = ways.iter().map(|way| job(|| way.picture(system)));
    let traces = meshes.iter().map(|mesh| job(|| mesh.trace()));
    let made = designs.iter().map(|plan| job(|| plan.make()));
    let with_effects = seen_with.iter().flat_map(|runs| runs.pictures()).map(job);
    let jobs: Vec<Job> = pictures.chain(traces).chain(made).chain(with_effects).collect();
    observer.stage_of("times", jobs.len() * settings.repetitions.max(1));
    let times = pool.install(|| time::interleaved(&jobs, settings.repetitions, settings.patience_s, observer));
    let (of_pictures, rest) = times.split_at(ways.len());
    let (of_meshes, rest) = rest.split_at(meshes.len());
    let (of_designs, mut of_effects) = rest.split_at(designs.len());

    observer.stage_of("errors", jobs.len());
    let judge = Judge { system, reference: &reference.radiance, corners: &corners, eye: &eye };
    let heard = |_: &_| observer.pixels(1);
    let pictures = ways.iter().zip(of_pictures).map(|(way, taken)| judge.setting(way, taken)).inspect(heard).collect();
    let heard = |_: &_| observer.pixels(1);
    let meshes =
        meshes.iter().zip(of_meshes).map(|(mesh, taken)| mesh.judged(&corners, taken)).inspect(heard).collect();
    let heard = |_: &_| observer.pixels(1);
    let designs = designs.iter().zip(of_designs).map(|(plan, taken)| plan.judged(scene, taken)).inspect(heard);
    let designs = designs.flatten().collect();
    let mut effects = Vec::new();
    for runs in &seen_with {
        let (own, others) = of_effects.split_at(runs.len());
        effects.extend(runs.judged(own));
        observer.pixels(runs.len());
        of_effects = others;
    }
    CostStudy {
        yardstick_ns: time::yardstick_ns(&times),
        size_px: [width, height],
        reference: reference.account,
        corners: corners.count(),
        pictures,
        meshes,
        designs,
        effects,
    }
}

/// Work whose result is of no interest, and may not be left out for that.
fn job<'a, T>(work: impl Fn() -> T + Sync + 'a) -> Job<'a> {
    Box::new(move || {
        std::hint::black_box(work());
    })
}

#[cfg(test)]
mod tests;
mod methods;
mod detector;
mod study;
mod shift_judge;
mod settings;
mod shifts;

pub use settings::CostSettings;
pub use shifts::Shifts;
pub use study::{CostStudy, EffectSetting, Setting};
