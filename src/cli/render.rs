//! `biprism render`: the picture of a scene.

use super::args::RenderArgs;
use super::outcome::Outcome;
use super::progress::Progress;
use super::{accuracy, files, output};
use crate::analysis::fit_shift::fit_shifts;
use crate::analysis::judge::fates;
use crate::error::Error;
use crate::render::{AccuracyReport, Counts, Strip, render_strips};
use crate::report::fit;
use crate::scene::{self, Scene};
use crate::system::{System, doubts};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::sync_channel;

pub(super) fn run(args: &RenderArgs) -> Result<Outcome, Error> {
    let scene = accuracy::asked(scene::load(&args.scene)?, args.target_px);
    args.out.iter().try_for_each(|path| files::picture_name(path))?;
    let mut progress = Progress::new((scene.camera.width_px * scene.camera.height_px) as u64);
    progress.begin(&scene.name, "design");
    let system = files::build(&scene, &args.scene)?;
    progress.begin(&scene.name, "render");
    let Done { fates, counts, account } = written(&args.out, &scene, &system, &progress.handle())?;
    let left_out: Vec<&str> =
        scene.effects.acting().filter(|row| !(row.acts)(&system.effects)).map(|row| row.key).collect();
    let seconds = progress.take_seconds();
    drop(progress);
    let doubts = doubts(&scene, &system);
    let fits = fit_shifts(&scene, &system).map(|fits| fit::entry(&fits));
    if args.json {
        let done = serde_json::json!({
            "scene": scene.name,
            "size_px": [scene.camera.width_px, scene.camera.height_px],
            "fates": fates,
            "counts": counts,
            "effects_left_out": left_out,
            "doubts": doubts,
            "surface_fits": fits,
            "accuracy": accuracy::entry(&account, &counts),
            "timing_s": seconds,
        });
        output::stdout(&format!("{done:#}\n"))?;
    } else {
        for path in &args.out {
            output::stderr(&format!("wrote {}", path.display()));
        }
        if !left_out.is_empty() {
            output::stderr(&format!("left out: {}; `biprism check` says why", left_out.join(", ")));
        }
        // Fates are those of one ray a pixel.
        let how = if system.effects.dimensions() > 0 { " through the middle of the pupil" } else { "" };
        for (fate, n) in fates.into_iter().filter(|(_, n)| *n > 0) {
            output::stderr(&format!("{n} pixels never see the board{how}: {fate}"));
        }
        fits.iter().flat_map(fit::words).for_each(|line| output::stderr(&format!("fit of the {line}")));
        doubts.iter().for_each(|doubt| output::stderr(&format!("note: {doubt}")));
    }
    Ok(accuracy::told(&scene.name, &account, &counts))
}

/// What was done.
struct Done {
    fates: BTreeMap<&'static str, usize>,
    counts: Counts,
    account: AccuracyReport,
}

/// Renders the picture strip by strip into all the files at once: of each file a thread writes one strip while the next
/// is made, so that few strips are held at a time.
fn written(
    paths: &[PathBuf],
    scene: &Scene,
    system: &System,
    progress: &(dyn Fn(usize) + Sync),
) -> Result<Done, Error> {
    std::thread::scope(|scope| {
        let writers: Vec<_> = paths
            .iter()
            .map(|path| {
                let (strips, received) = sync_channel::<Arc<Strip>>(1);
                (strips, scope.spawn(move || files::strips(path, scene, system, received.into_iter())))
            })
            .collect();
        let mut all_fates = BTreeMap::new();
        let (counts, account) = render_strips(system, progress, &mut |strip| {
            fates(&strip.class).into_iter().for_each(|(fate, n)| *all_fates.entry(fate).or_insert(0) += n);
            let strip = Arc::new(strip);
            for (strips, _) in &writers {
                // A writer that takes no more has met a problem, which is told below.
                let _ = strips.send(Arc::clone(&strip));
            }
        });
        for (strips, writer) in writers {
            drop(strips);
            writer.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
        }
        Ok(Done { fates: all_fates, counts, account })
    })
}
