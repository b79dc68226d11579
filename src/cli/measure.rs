//! `biprism measure`: the figures of one picture, rendered or photographed, or of corners that another program found.

use super::args::MeasureArgs;
use super::compare::not_judged;
use super::expect::expectations;
use super::light::Light;
use super::outcome::Outcome;
use super::progress::Progress;
use super::{files, light, origin, output};
use crate::analysis::budget;
use crate::analysis::compare::prisms;
use crate::analysis::fit_shift::fit_shifts;
use crate::analysis::judge::measure;
use crate::analysis::listed_corners::lattices;
use crate::analysis::photograph::photograph;
use crate::analysis::view::{detect, place};
use crate::error::Error;
use crate::io::corners::{self, CornerFormat};
use crate::io::inputs;
use crate::raster::Raster;
use crate::report::identity::{self, Likeness};
use crate::report::page::comparison::{self, PagePrism};
use crate::report::{self, design, json, table};
use crate::scene::Scene;
use crate::system::{System, doubts};
use std::collections::BTreeMap;
use std::path::Path;

/// What is measured.
enum Input {
    /// With the notes in its file on its origin.
    Picture(Raster<f32>, Option<String>),
    Corners(Vec<corners::CornerView>),
}

pub(super) fn run(args: &MeasureArgs) -> Result<Outcome, Error> {
    args.page.as_deref().map_or(Ok(()), checked_page)?;
    let scene = files::load(&args.scene, &args.values)?;
    files::checkerboard(&scene, &args.scene)?;
    files::named(&args.scene, prisms(&scene))?;
    let input = input(args, &scene)?;
    let progress = Progress::new(0);
    progress.begin(&scene.name, "design");
    let system = files::build(&scene, &args.scene)?;
    let watch = progress.watch("picture");
    let lattices = match &input {
        Input::Picture(picture, note) => {
            same_instrument(args, &scene, &system, note.as_deref())?;
            detect(&system, picture, &watch)
        }
        Input::Corners(views) => lattices(&args.picture.display(), &system, views)?,
    };
    let (judgement, pose) = if args.own {
        let view = place(&system, &lattices, true, &watch);
        progress.begin("picture", "measure");
        (measure(&scene, &system, view, &[]), None)
    } else {
        let photograph = photograph(&scene, &system, &lattices, &watch);
        progress.begin("picture", "measure");
        photograph.judged()
    };
    let budget = args.budget.then(|| {
        progress.begin("picture", "budget");
        budget::budget(&scene, &system, &judgement.view, &())
    });
    let timing = progress.take_seconds();
    drop(progress);
    let name = scene.prism.kind();
    let mut entry = design::entry(name, &judgement, &BTreeMap::new(), timing, scene.camera.pitch_mm);
    entry = match args.own {
        true => design::of_own_picture(entry, &scene, &system),
        false => design::of_photograph(entry, pose.as_ref()),
    };
    entry.error_budget = budget.transpose()?.map(|found| report::budget::entry(&found));
    entry.surface_fits = fit_shifts(&scene, &system).map(|fits| report::fit::entry(&fits));
    let report = json::Report { schema: json::SchemaName::V1, scene: scene.name.clone(), designs: vec![entry] };
    let outcome = expectations(&scene, &report)?;
    if let Some(path) = &args.page {
        let picture = if let Input::Picture(picture, _) = &input { Some(picture) } else { None };
        let entry = &report.designs[0];
        let made = format!("read from {}", args.picture.display());
        let notes = notes(entry, &scene, &system);
        let prism = PagePrism { entry, judgement: &judgement, scene: &scene, system: &system, picture, made, notes };
        let title = format!("{} measured as scene {}", args.picture.display(), scene.name);
        inputs::check_outputs(args.page.as_slice())?;
        files::text(path, &comparison::page(&title, &table::verdict(&report.designs), &[prism], &origin::origin()))?;
        output::stderr(&format!("wrote {}", path.display()));
    }
    let words = || format!("{}\n\n{}\n", table::text(&report.designs), table::verdict(&report.designs));
    output::stdout(&if args.json { json::to_text(&report) } else { words() })?;
    for design in &report.designs {
        notes(design, &scene, &system).iter().for_each(|note| output::stderr(&format!("note: {note}")));
    }
    let nothing = not_judged(&report);
    Ok(if nothing { Outcome::Unmet } else { outcome })
}

/// What a user must know besides the table.
fn notes(design: &json::Design, scene: &Scene, system: &System) -> Vec<String> {
    let fits = design.surface_fits.as_ref().map(report::fit::words).unwrap_or_default();
    let of_pose = design
        .board_pose
        .as_ref()
        .map(|pose| report::board_pose::notes(pose, design.matching.as_ref(), system.board().inner_corners()));
    let fits = fits.into_iter().map(|line| format!("fit of the {line}"));
    let posed = of_pose.into_iter().flatten();
    table::warnings(design).into_iter().chain(fits).chain(posed).chain(doubts(scene, system)).collect()
}

/// That the page may be written.
fn checked_page(path: &Path) -> Result<(), Error> {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    if !matches!(ending.as_deref(), Some("html" | "htm")) {
        let rule = format!("`{}` does not end in .html", path.display());
        return Err(Error::new("--page", rule, "name a .html file"));
    }
    files::folder_of(path)
}

/// A corner file by its ending, else a picture, which must be of the scene's size.
fn input(args: &MeasureArgs, scene: &Scene) -> Result<Input, Error> {
    if CornerFormat::of(&args.picture).is_ok() {
        return corners::read(&args.picture).map(Input::Corners);
    }
    let sized = |picture: &Raster<f32>| files::check_size(&args.picture, picture, scene);
    let Light { picture, mut metadata, .. } = light::read_checked(&args.picture, &args.curve, true, &sized)?;
    Ok(Input::Picture(picture, metadata.texts.remove("biprism")))
}

/// A picture that was rendered here says of which instrument; another one's truth is not its truth.
fn same_instrument(args: &MeasureArgs, scene: &Scene, system: &System, note: Option<&str>) -> Result<(), Error> {
    let said: Option<serde_json::Value> = note.and_then(|text| serde_json::from_str(text).ok());
    let Some(said) = said else { return Ok(()) };
    let others = match identity::likeness(scene, system, &said["instrument"]) {
        Likeness::Same => return Ok(()),
        Likeness::Others(others) => others,
        Likeness::Unknown => {
            output::stderr(&format!(
                "note: {} was written by another version of the program, and does not tell whether its instrument is that \
                 of {}: render it anew to know",
                args.picture.display(),
                files::shown(&args.scene)
            ));
            return Ok(());
        }
    };
    let rule = format!(
        "the picture was rendered from scene {} with prism {}, and {} (scene \"{}\" with prism \"{}\") has another {}",
        said["scene"],
        said["prism"],
        files::shown(&args.scene),
        scene.name,
        scene.prism.kind(),
        others.join(", ")
    );
    if args.own {
        let help = "name the picture's own scene with --scene, render it anew, or leave out --own";
        return Err(Error::new(args.picture.display(), rule, help));
    }
    output::stderr(&format!("note: {rule}"));
    Ok(())
}
