//! `biprism render`: the picture of a scene.

use super::args::RenderArgs;
use super::outcome::Outcome;
use super::progress::Progress;
use super::{accuracy, files, output};
use crate::analysis::fit_shift::fit_shifts;
use crate::error::Error;
use crate::io::inputs;
use crate::report::picture::{self, PictureFile, Written};
use crate::report::{design, fit};
use crate::scene::Scene;
use crate::system::doubts;
use std::path::PathBuf;

pub(super) fn run(args: &RenderArgs) -> Result<Outcome, Error> {
    let scene = accuracy::asked(files::load(&args.scene, &args.values)?, args.target_px);
    args.out.iter().try_for_each(|path| picture::check_name(path))?;
    let wanted = wanted(args, &scene)?;
    let paths: Vec<PathBuf> = wanted.iter().map(|file| file.path.clone()).collect();
    inputs::check_outputs(&paths)?;
    paths.iter().filter_map(|path| path.parent()).try_for_each(files::folder)?;
    let progress = Progress::new((scene.camera.width_px * scene.camera.height_px) as u64);
    progress.begin(&scene.name, "design");
    let system = files::build(&scene, &args.scene)?;
    progress.begin(&scene.name, "render");
    let Written { fates, counts, account, clamped } =
        picture::render_to_files(&wanted, &scene, &system, &progress.watch(&scene.name))?;
    paths.iter().zip(clamped).for_each(|(path, pixels)| files::print_clamped(path, pixels));
    let left_out: Vec<&str> =
        scene.effects.acting().filter(|row| !(row.acts)(system.effects())).map(|row| row.key()).collect();
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
            "accuracy": design::accuracy(&account, &counts),
            "timing_s": seconds,
        });
        output::stdout(&format!("{done:#}\n"))?;
    } else {
        for path in &paths {
            output::stderr(&format!("wrote {}", path.display()));
        }
        if !left_out.is_empty() {
            output::stderr(&format!("left out: {}; `biprism check` says why", left_out.join(", ")));
        }
        // Fates are those of one ray a pixel.
        let how = if system.effects().dimensions() > 0 { " through the middle of the pupil" } else { "" };
        for (fate, n) in fates.into_iter().filter(|(_, n)| *n > 0) {
            output::stderr(&format!("{n} pixels never see the board{how}: {fate}"));
        }
        fits.iter().flat_map(fit::words).for_each(|line| output::stderr(&format!("fit of the {line}")));
        doubts.iter().for_each(|doubt| output::stderr(&format!("note: {doubt}")));
    }
    Ok(accuracy::told(&scene.name, &account, &counts))
}

/// The files that are asked for.
fn wanted(args: &RenderArgs, scene: &Scene) -> Result<Vec<PictureFile>, Error> {
    let whole = |path: &PathBuf| PictureFile { stereo: args.stereo, ..PictureFile::plain(path.clone()) };
    let wholes = args.out.iter().map(whole);
    if !args.halves {
        return Ok(wholes.collect());
    }
    if scene.camera.width_px < 2 {
        let rule = "the picture has one column, and its halves have none";
        return Err(Error::new("--halves", rule, "leave it out, or give the camera more columns"));
    }
    Ok(wholes.flat_map(|file| file.halves()).collect())
}
