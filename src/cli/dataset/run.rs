//! A run of `biprism dataset`.

use super::manifest_file::{MANIFEST, ManifestFile};
use super::places;
use super::workers::Workshop;
use crate::analysis::dataset::{Dataset, SetCameras};
use crate::analysis::half_image::NoPinhole;
use crate::cli::dataset_args::{DatasetArgs, LookArg};
use crate::cli::outcome::Outcome;
use crate::cli::progress::Progress;
use crate::cli::{files, output};
use crate::error::Error;
use crate::progress::Observer;
use crate::report::dataset::{ManifestHead, SetFiles, SetSummary, SetTally, cameras_text};
use crate::scene::{self, Scene};
use std::time::Instant;

/// The cameras' file.
const CAMERAS: &str = "cameras.yml";

pub(crate) fn run(args: &DatasetArgs) -> Result<Outcome, Error> {
    if files::is_stdin(&args.scene) && args.pose_file.as_deref().is_some_and(files::is_stdin) {
        let rule = "scene and places are both to come from stdin";
        return Err(Error::new("stdin", rule, "give the places as a file, with --pose-file"));
    }
    let (scene, text) = files::load_with_text(&args.scene, &args.values)?;
    let place = files::shown(&args.scene);
    can_be(args, &scene, &text, &place)?;
    let (plan, count) = places::plan(args, &scene)?;
    let files_of = SetFiles { halves: args.halves, truth: args.truth, detected: args.detect };

    // Design the prism, and see what is there.
    let progress = Progress::new(0);
    progress.begin(&scene.name, "design");
    let set = files::named(&args.scene, Dataset::new(&scene, plan))?;
    let head = ManifestHead::new(&scene, &text, &set, files_of);
    let manifest = ManifestFile::open(&args.out, &head, set.plan())?;
    let cameras = SetCameras::new(&scene, &set);
    let cameras_path = files::outputs(&args.out, &[CAMERAS])?.swap_remove(0);
    if let Ok(cameras) = &cameras {
        files::text(&cameras_path, &cameras_text(cameras))?;
    }

    // Make what is not.
    let there = manifest.count();
    let again = manifest.incomplete.iter().copied().filter(|number| *number < count);
    let numbers: Vec<u32> = again.chain(there..count.max(there)).collect();
    let watch = progress.watch(&scene.name);
    watch.stage_of("pictures", numbers.len());
    let started = Instant::now();
    let workshop = Workshop { set: &set, files: files_of, out: &args.out, scene_text: &text, scene_place: &place };
    let manifest = workshop.make_all(&numbers, manifest, &watch)?;
    let seconds = started.elapsed().as_secs_f64();
    drop(progress);

    // Tell it.
    let out = args.out.display().to_string();
    let (made, tally) = (numbers.len(), manifest.tally);
    let summary =
        SetSummary { scene: &scene.name, out, seed: args.seed, made, tally, cameras: cameras.as_ref().ok(), seconds };
    output::stdout(&if args.json { format!("{:#}\n", summary.json()) } else { summary.words() })?;
    notes(&tally, there, count, cameras.as_ref().err());
    let written = [Some(&manifest.path), cameras.is_ok().then_some(&cameras_path)];
    written.into_iter().flatten().for_each(|path| output::stderr(&format!("wrote {}", path.display())));
    Ok(if tally.not_kept > 0 { Outcome::Unmet } else { Outcome::Done })
}

/// Refuses what the scene contradicts.
fn can_be(args: &DatasetArgs, scene: &Scene, text: &str, place: &str) -> Result<(), Error> {
    if args.noise.is_some() && scene::has_no_effects(text, place)? {
        let rule = "noise is that of a sensor, and the scene says `effects = \"none\"`";
        return Err(Error::new("--noise", rule, "leave the option out, or take `effects` out of the scene"));
    }
    if args.halves && scene.camera.width_px < 2 {
        let rule = "the picture has one column, and its halves have none";
        return Err(Error::new("--halves", rule, "leave it out, or give the camera more columns"));
    }
    let textured = match &args.texture[..] {
        [] => scene.texture.is_some(),
        looks => looks.iter().any(|look| *look != LookArg::Squares),
    };
    if args.detect && textured {
        let rule = "the detector looks for the corners of squares, and boards of the set show a texture";
        return Err(Error::new("--detect", rule, "leave it out, or give `--texture squares`"));
    }
    Ok(())
}

/// What a user must know besides.
fn notes(tally: &SetTally, there: u32, count: u32, no_cameras: Option<&NoPinhole>) {
    let note = |text: String| output::stderr(&format!("note: {text}"));
    if there > count {
        note(format!("{MANIFEST} already has {there} pictures, more than the {count} that were asked for; they stay"));
    }
    if let Some(why) = no_cameras {
        note(format!("{CAMERAS} is left out: {}", why.reason()));
    }
    if tally.without_corners > 0 {
        note(format!(
            "of {} pictures one half or both see no corner: a smaller --tilt-deg or a larger board may show some",
            tally.without_corners
        ));
    }
    if tally.clamped_px > 0 {
        note(format!("{} pixels of all pictures are brighter than full scale, and are clamped", tally.clamped_px));
    }
    if tally.not_kept > 0 {
        note(format!("{} pictures do not keep to the accuracy that the scene asks for", tally.not_kept));
    }
}
