//! `biprism measure`: the figures of one picture, made here or by a camera, or of corners that another program found.

use super::args::MeasureArgs;
use super::expect::expectations;
use super::outcome::Outcome;
use super::progress::Progress;
use super::{files, identity, output};
use crate::analysis::budget;
use crate::analysis::fit_shift::fit_shifts;
use crate::analysis::half_image::HalfFrame;
use crate::analysis::judge::measure;
use crate::analysis::view::{DetectedLattice, place, see};
use crate::error::Error;
use crate::io::corners::{self, CornerFormat};
use crate::raster::Raster;
use crate::report::{design, json, table};
use crate::scene::Scene;
use crate::system::{System, doubts};
use crate::vision::half::Half;
use crate::vision::{LatticeCorner, upright};
use crate::{report, scene};
use std::collections::BTreeMap;

/// What is measured.
enum Input {
    /// With what is noted in its file of how it was made.
    Picture(Raster<f32>, Option<String>),
    Corners(Vec<corners::CornerView>),
}

pub(super) fn run(args: &MeasureArgs) -> Result<Outcome, Error> {
    let scene = scene::load(&args.scene)?;
    let input = input(args, &scene)?;
    let mut progress = Progress::new(0);
    progress.begin(&scene.name, "design");
    let system = files::build(&scene, &args.scene)?;
    let mut stage = |step| progress.begin("picture", step);
    let view = match &input {
        Input::Picture(picture, note) => {
            same_instrument(args, &scene, &system, note.as_deref())?;
            see(&system, picture, args.own, &mut stage)
        }
        Input::Corners(views) => place(&system, &lattices(args, &system, views)?, args.own, &mut stage),
    };
    progress.begin("picture", "measure");
    let judgement = measure(&scene, &system, view, &[]);
    let budget = args.budget.then(|| {
        progress.begin("picture", "budget");
        budget::budget(&scene, &system, &judgement.view, &|_| ())
    });
    let timing = progress.take_seconds();
    drop(progress);
    let name = files::prism_name(&scene.prism);
    let mut entry = design::entry(name, &judgement, &BTreeMap::new(), timing, scene.camera.pitch_mm);
    entry.error_budget = budget.transpose()?.map(|found| report::budget::entry(&found));
    entry.surface_fits = fit_shifts(&scene, &system).map(|fits| report::fit::entry(&fits));
    let report = json::Report { schema: json::SchemaName::V1, scene: scene.name.clone(), designs: vec![entry] };
    let outcome = expectations(&scene, &report)?;
    let words = || format!("{}\n\n{}\n", table::text(&report.designs), table::verdict(&report.designs));
    output::stdout(&if args.json { json::to_text(&report) } else { words() })?;
    report.designs.iter().flat_map(table::warnings).for_each(|warning| output::stderr(&warning));
    let fits = report.designs.iter().filter_map(|design| design.surface_fits.as_ref()).flat_map(report::fit::words);
    fits.for_each(|line| output::stderr(&format!("fit of the {line}")));
    doubts(&scene, &system).iter().for_each(|doubt| output::stderr(&format!("note: {doubt}")));
    Ok(outcome)
}

/// A corner file by its ending, else a picture, which must be of the scene's size.
fn input(args: &MeasureArgs, scene: &Scene) -> Result<Input, Error> {
    if CornerFormat::of(&args.picture).is_ok() {
        return corners::read(&args.picture).map(Input::Corners);
    }
    let (picture, mut metadata) = crate::io::read(&args.picture, args.transfer.map(Into::into))?;
    let size = [scene.camera.width_px, scene.camera.height_px];
    if [picture.width(), picture.height()] != size {
        return Err(Error::new(
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
    Ok(Input::Picture(picture, metadata.texts.remove("biprism")))
}

/// The corners of a file, in the px of the halves that they must lie in.
fn lattices(args: &MeasureArgs, system: &System, views: &[corners::CornerView]) -> Result<[DetectedLattice; 2], Error> {
    let known = |view: &corners::CornerView| Half::BOTH.iter().any(|half| half.name() == view.name);
    if let Some(view) = views.iter().find(|view| !known(view)) {
        let rule = format!("it has corners of a view {:?}, and must have those of left and right", view.name);
        return Err(Error::new(args.picture.display(), rule, "detect in each half of the picture by itself"));
    }
    let [left, right] = Half::BOTH.map(|half| {
        let Some(view) = views.iter().find(|view| view.name == half.name()) else {
            return Ok(DetectedLattice::default());
        };
        let frame = HalfFrame::new(system, half);
        if let Some(stray) = view.corners.iter().find(|c| !frame.contains(frame.own(c.position_px))) {
            let (low, high) = (frame.first_column, frame.full(frame.size_px));
            let rule = format!(
                "corner ({}, {}) of the {} half lies at {}, and must lie in columns {low} to {} and rows 0 to {}",
                stray.index[0],
                stray.index[1],
                half.name(),
                stray.position_px,
                high.x,
                high.y
            );
            let help = "give positions in px of the whole picture, of the size that the scene says";
            return Err(Error::new(args.picture.display(), rule, help));
        }
        let seen = |c: &corners::ListedCorner| LatticeCorner {
            index: c.index,
            position_px: frame.own(c.position_px),
            polarity: c.quality.map(|q| q.polarity),
        };
        Ok(DetectedLattice {
            corners: upright(&view.corners.iter().map(seen).collect::<Vec<_>>()),
            rejected: view.rejected.iter().cloned().collect(),
            blur_px: view.blur_px,
        })
    });
    Ok([left?, right?])
}

/// A picture that was rendered here says of which instrument; another one's truth is not its truth.
fn same_instrument(args: &MeasureArgs, scene: &Scene, system: &System, note: Option<&str>) -> Result<(), Error> {
    let said: Option<serde_json::Value> = note.and_then(|text| serde_json::from_str(text).ok());
    let Some(said) = said else { return Ok(()) };
    let others = identity::others(scene, system, &said["instrument"]);
    if others.is_empty() {
        return Ok(());
    }
    let rule = format!(
        "the picture was rendered from scene {} with prism {}, and {} (scene \"{}\" with prism \"{}\") has another {}",
        said["scene"],
        said["prism"],
        args.scene.display(),
        scene.name,
        files::prism_name(&scene.prism),
        others.join(", ")
    );
    if args.own {
        let help = "name the picture's own scene with --scene, render it anew, or leave out --own";
        return Err(Error::new(args.picture.display(), rule, help));
    }
    output::stderr(&format!("note: {rule}"));
    Ok(())
}
