//! `biprism measure`: the figures of one picture, made here or by a camera.

use super::args::MeasureArgs;
use super::expect::expectations;
use super::progress::Progress;
use super::{Outcome, files, say};
use crate::analysis::judge::measure;
use crate::analysis::view::see;
use crate::problem::Problem;
use crate::report::{design, json, table};
use crate::scene::Scene;
use crate::{raster, scene};
use std::collections::BTreeMap;

pub(super) fn run(args: &MeasureArgs) -> Result<Outcome, Problem> {
    let scene = scene::load(&args.scene)?;
    let (picture, metadata) = raster::read(&args.picture, args.transfer.map(Into::into))?;
    let size = [scene.camera.width_px, scene.camera.height_px];
    if [picture.width(), picture.height()] != size {
        return Err(Problem::new(
            args.picture.display(),
            format!(
                "the picture is {} x {}, and the scene's camera has {} x {} pixels",
                picture.width(),
                picture.height(),
                size[0],
                size[1]
            ),
            "name the scene that the picture belongs to with --scene",
        ));
    }
    same_scene(args, &scene, metadata.texts.get("biprism").map(String::as_str))?;
    let mut progress = Progress::new(0);
    progress.begin(&scene.name, "design");
    let system = files::build(&scene, &args.scene)?;
    let view = see(&system, &picture, args.own, &mut |step| progress.begin("picture", step));
    progress.begin("picture", "measure");
    let judgement = measure(&scene, &system, view, &[]);
    let timing = progress.take_seconds();
    drop(progress);
    let name = files::prism_name(&scene.prism);
    let entry = design::entry(name, &judgement, &BTreeMap::new(), timing, scene.camera.pitch_mm);
    let report = json::Report { schema: json::SchemaName::V1, scene: scene.name.clone(), designs: vec![entry] };
    let outcome = expectations(&scene, &report)?;
    let words = || format!("{}\n\n{}\n", table::text(&report.designs), table::verdict(&report.designs));
    say::data(&if args.json { json::to_text(&report) } else { words() })?;
    report.designs.iter().flat_map(table::warnings).for_each(|warning| say::words(&warning));
    Ok(outcome)
}

/// A picture that was rendered here says from which scene and prism; another scene's truth is not its truth.
fn same_scene(args: &MeasureArgs, scene: &Scene, note: Option<&str>) -> Result<(), Problem> {
    let said: Option<serde_json::Value> = note.and_then(|text| serde_json::from_str(text).ok());
    let Some(said) = said else { return Ok(()) };
    let prism = files::prism_name(&scene.prism);
    if said["scene"] == scene.name.as_str() && said["prism"] == prism {
        return Ok(());
    }
    let rule = format!(
        "the picture was rendered from scene {} with prism {}, and {} is scene \"{}\" with prism \"{prism}\"",
        said["scene"],
        said["prism"],
        args.scene.display(),
        scene.name
    );
    if args.own {
        let help = "name the picture's own scene with --scene, or leave out --own";
        return Err(Problem::new(args.picture.display(), rule, help));
    }
    say::words(&format!("note: {rule}"));
    Ok(())
}
