//! `biprism corners`: the corners in any picture of a checkerboard.

use super::args::CornersArgs;
use super::{Outcome, files, say};
use crate::problem::Problem;
use crate::raster;
use crate::report::corners::{Format, View, to_text};
use crate::vision::half::{HalfImage, split};
use crate::vision::{self, Settings};

pub(super) fn run(args: &CornersArgs) -> Result<Outcome, Problem> {
    let format = match &args.out {
        Some(path) => Format::of(path)?,
        None if args.json => Format::Json,
        None => Format::Csv,
    };
    let (picture, _) = raster::read(&args.picture, args.transfer.map(Into::into))?;
    let settings = Settings::default();
    let views = if args.whole {
        vec![View::new("whole", 0, &vision::detect(&picture, None, &settings))]
    } else {
        let view =
            |h: HalfImage<f32>| View::new(h.half.name(), h.first_column, &vision::detect(&h.image, None, &settings));
        split(&picture).map(view).into()
    };
    let text = to_text(&views, format);
    match &args.out {
        Some(path) => files::text(path, &text)?,
        None => say::data(&text)?,
    }
    for view in &views {
        let rejected: Vec<String> =
            view.rejected.iter().filter(|(_, n)| *n > 0).map(|(reason, n)| format!("{n} {reason}")).collect();
        let aside = if rejected.is_empty() { "none".to_owned() } else { rejected.join(", ") };
        say::words(&format!("{}: {} corners; turned down: {aside}", view.name, view.corners.len()));
    }
    Ok(Outcome::Done)
}
