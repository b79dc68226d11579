//! `biprism corners`: the corners in any picture of a checkerboard, or a corner file in another format.

use super::args::CornersArgs;
use super::outcome::Outcome;
use super::{files, output};
use crate::error::Error;
use crate::io::corners::{self, CornerFormat, CornerView, to_text};
use crate::vision::half::{HalfImage, split};
use crate::vision::{self, Settings};
use serde_json::{Value, json};

pub(super) fn run(args: &CornersArgs) -> Result<Outcome, Error> {
    let format = match &args.out {
        Some(path) => CornerFormat::of(path)?,
        None if args.json => CornerFormat::Json,
        None => CornerFormat::Csv,
    };
    let views = if CornerFormat::of(&args.picture).is_ok() { corners::read(&args.picture)? } else { detected(args)? };
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

fn detected(args: &CornersArgs) -> Result<Vec<CornerView>, Error> {
    let (picture, _) = crate::io::read(&args.picture, args.transfer.map(Into::into))?;
    let settings = Settings::default();
    if args.whole {
        return Ok(vec![CornerView::new("whole", 0, &vision::detect(&picture, None, &settings))]);
    }
    let view =
        |h: HalfImage<f32>| CornerView::new(h.half.name(), h.first_column, &vision::detect(&h.image, None, &settings));
    Ok(split(&picture).map(view).into())
}

/// What was written of a view, in numbers.
fn counted(view: &CornerView) -> Value {
    let rejected: serde_json::Map<String, Value> =
        view.rejected.iter().map(|(reason, n)| (reason.clone(), json!(n))).collect();
    json!({ "half": view.name, "corners": view.corners.len(), "rejected": rejected, "blur_px": view.blur_px })
}
