//! `biprism corners`: the corners in any picture of a checkerboard, or a corner file in another format.

use super::args::CornersArgs;
use super::outcome::Outcome;
use super::progress::Progress;
use super::{files, output};
use crate::error::Error;
use crate::io::corners::{self, CornerFormat, CornerView, to_text};
use crate::io::inputs;
use crate::raster::Raster;
use crate::vision::half::{Half, HalfImage};
use crate::vision::{self, Settings};
use serde_json::{Value, json};

pub(super) fn run(args: &CornersArgs) -> Result<Outcome, Error> {
    let format = match &args.out {
        Some(path) => CornerFormat::of(path)?,
        None if args.json => CornerFormat::Json,
        None => CornerFormat::Csv,
    };
    let progress = Progress::new(0);
    progress.begin("picture", "read");
    let given = CornerFormat::of(&args.picture).is_ok();
    let (listed, picture) = match given {
        true => (corners::read(&args.picture)?, None),
        false => (Vec::new(), Some(crate::io::read(&args.picture, args.transfer.map(Into::into))?.0)),
    };
    if let Some(path) = &args.out {
        inputs::check_outputs(std::slice::from_ref(path))?;
        path.parent().map_or(Ok(()), files::folder)?;
    }
    progress.begin("picture", "detect");
    let views = picture.map_or(listed, |picture| detected(args, &picture));
    drop(progress);
    let text = to_text(&views, format);
    match &args.out {
        Some(path) => files::text(path, &text)?,
        None => output::stdout(&text)?,
    }
    if args.json && args.out.is_some() {
        let halves: Vec<Value> = views.iter().map(counted).collect();
        return output::stdout(&format!("{:#}\n", json!({ "halves": halves }))).map(|()| Outcome::Done);
    }
    for view in &views {
        let rejected: Vec<String> =
            view.rejected.iter().filter(|(_, n)| *n > 0).map(|(reason, n)| format!("{n} {reason}")).collect();
        let aside = if rejected.is_empty() { "none".to_owned() } else { rejected.join(", ") };
        output::stderr(&format!("{}: {} corners; turned down: {aside}", view.name, view.corners.len()));
    }
    Ok(Outcome::Done)
}

fn detected(args: &CornersArgs, picture: &Raster<f32>) -> Vec<CornerView> {
    let settings = Settings::default();
    if args.whole {
        return vec![CornerView::new("whole", 0, &vision::detect(picture, None, &settings))];
    }
    // One half after the other: both at once would hold the picture twice.
    let view = |half: Half| {
        let half = HalfImage::cut(picture, half);
        CornerView::new(half.half.name(), half.first_column, &vision::detect(&half.image, None, &settings))
    };
    Half::BOTH.map(view).into()
}

/// What was written of a view, in numbers.
fn counted(view: &CornerView) -> Value {
    let rejected: serde_json::Map<String, Value> =
        view.rejected.iter().map(|(reason, n)| (reason.clone(), json!(n))).collect();
    json!({ "half": view.name, "corners": view.corners.len(), "rejected": rejected, "blur_px": view.blur_px })
}
