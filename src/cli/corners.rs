//! `biprism corners`: the corners in any picture of a checkerboard, or a corner file in another format.

use super::args::CornersArgs;
use super::outcome::Outcome;
use super::progress::Progress;
use super::{files, light, output};
use crate::analysis::corners_on_board;
use crate::analysis::listed_corners::lattices;
use crate::analysis::transfer_choice::TransferChoice;
use crate::error::Error;
use crate::io::corners::{self, CornerFormat, CornerView, TransferFound, to_text};
use crate::io::inputs;
use crate::raster::Raster;
use crate::system::InLight;
use crate::vision::half::{Half, HalfImage};
use crate::vision::{self, Detection, Polarity, Settings, turned_like};
use serde_json::{Value, json};
use std::path::Path;

pub(super) fn run(args: &CornersArgs) -> Result<Outcome, Error> {
    let format = match &args.out {
        Some(path) => CornerFormat::of(path)?,
        None if args.json => CornerFormat::Json,
        None => CornerFormat::Csv,
    };
    if let (None, Some(value)) = (&args.scene, args.values.set.first()) {
        let rule = "it changes a scene, and there is none";
        return Err(Error::new(format!("--set {value}"), rule, "name the scene with --scene, or leave it out"));
    }
    let progress = Progress::new(0);
    progress.begin("picture", "read");
    let given = CornerFormat::of(&args.picture).is_ok();
    if given && (args.board.is_some() || args.all_boards) {
        let rule = "a corner file holds no picture, in which --board and --all-boards look for boards";
        return Err(Error::new(args.picture.display(), rule, "give the picture, or leave the option out"));
    }
    let (listed, light) = match given {
        true => (corners::read(&args.picture)?, None),
        false => (Vec::new(), Some(light::read(&args.picture, &args.curve, !args.whole)?)),
    };
    let (picture, choice) = light.map_or((None, None), |light| (Some(light.picture), light.choice));
    if let Some(path) = &args.out {
        inputs::check_outputs(std::slice::from_ref(path))?;
        files::folder_of(path)?;
    }
    let mut told = Vec::new();
    let mut views = match (&args.scene, picture) {
        (Some(path), picture) => by_scene(args, path, picture.as_ref(), listed, &progress)?,
        (None, Some(picture)) => {
            progress.begin("picture", "detect");
            let (views, notes) = detected(args, &picture);
            told = notes;
            views
        }
        (None, None) => listed,
    };
    drop(progress);
    told.iter().for_each(|note| output::stderr(note));
    if let Some(choice) = &choice {
        views.iter_mut().for_each(|view| view.transfer = Some(found(choice)));
    }
    let text = to_text(&views, format);
    match &args.out {
        Some(path) => files::text(path, &text)?,
        None => output::stdout(&text)?,
    }
    if args.json && args.out.is_some() {
        let halves: Vec<Value> = views.iter().map(counted).collect();
        return output::stdout(&format!("{:#}\n", json!({ "halves": halves }))).map(|()| outcome(args, &views));
    }
    for view in &views {
        tell(view);
    }
    Ok(outcome(args, &views))
}

/// What was found in a view, to stderr.
fn tell(view: &CornerView) {
    let rejected: Vec<String> =
        view.rejected.iter().filter(|(_, n)| *n > 0).map(|(reason, n)| format!("{n} {reason}")).collect();
    let aside = if rejected.is_empty() { "none".to_owned() } else { rejected.join(", ") };
    output::stderr(&format!("{}: {} corners; turned down: {aside}", view.name, view.corners.len()));
    if view.marked_squares {
        output::stderr(&format!(
            "note: {}: the squares of one colour hold marks, as those of a ChArUco board do: the corners are fitted to what is near the \
             edges of squares alone",
            view.name
        ));
    }
    if let Some(lean) = view.lean_px.filter(|lean| *lean != 0.0 && !view.marked_squares) {
        let (side, why) = if lean > 0.0 {
            ("dark", "bright parts are clipped, ink is lost, or the curve is too bright")
        } else {
            ("bright", "black parts are clipped, ink has spread, or the curve is too dark")
        };
        output::stderr(&format!(
            "note: {}: edges lie {:.2} px towards {side}: {why}; corners stay where they are",
            view.name,
            lean.abs()
        ));
    }
    if let Some(blur) = view.elongated_blur {
        // The Gaussian that is most like a uniform motion has 0.32 of its length.
        let motion_px = 3.1 * (blur.along_px * blur.along_px - blur.across_px * blur.across_px).sqrt();
        output::stderr(&format!(
            "note: {}: the blur is {:.2} px (standard deviation) along {:.0} deg from +x towards +y (down), and {:.2} px across that: as \
             of a motion over {motion_px:.0} px, or an astigmatic lens",
            view.name, blur.along_px, blur.direction_deg, blur.across_px
        ));
    }
}

/// The corners numbered by the board of the scene at `path`, of a picture, or else of a list.
fn by_scene(
    args: &CornersArgs,
    path: &Path,
    picture: Option<&Raster<f32>>,
    listed: Vec<CornerView>,
    progress: &Progress,
) -> Result<Vec<CornerView>, Error> {
    let scene = files::load(path, &args.values)?;
    files::checkerboard(&scene, path)?;
    if let Some(picture) = picture {
        files::check_size(&args.picture, picture, &scene)?;
    }
    progress.begin(&scene.name, "design");
    let system = files::build(&scene, path)?;
    progress.begin("picture", "detect");
    let Some(picture) = picture else {
        // The list is checked as `measure` does.
        lattices(&args.picture.display(), &system, &listed)?;
        let light = InLight::new(&system);
        let half = |view: &CornerView| Half::BOTH.into_iter().find(|half| half.name() == view.name);
        return Ok(listed
            .into_iter()
            .filter_map(|view| Some(corners_on_board::on_board(&light, half(&view)?, view)))
            .collect());
    };
    Ok(corners_on_board::detected(&system, picture).into())
}

/// Whether every view has the places on the board, where these were asked for; what has none is told.
fn outcome(args: &CornersArgs, views: &[CornerView]) -> Outcome {
    let mut outcome = Outcome::Done;
    if args.scene.is_none() {
        return outcome;
    }
    for view in views {
        for (reason, n) in &view.rejected {
            match reason.as_str() {
                corners_on_board::NOT_INDEXED => {
                    outcome = Outcome::Unmet;
                    let why = format!(
                        "{}: the scene does not tell which corners of the board the {n} that were found are: its board must be \
                         where the picture's is, to 0.3 of a square; without --scene they are written by numbers of their own",
                        view.name
                    );
                    output::stderr(&why);
                }
                corners_on_board::OFF_BOARD => output::stderr(&format!(
                    "note: {}: {n} corners lie where the scene's board has none, and are left out: look at its columns and rows",
                    view.name
                )),
                _ => {}
            }
        }
    }
    outcome
}

/// The boards of a picture, view by view, and what is to be told of them.
fn detected(args: &CornersArgs, picture: &Raster<f32>) -> (Vec<CornerView>, Vec<String>) {
    let mut told = Vec::new();
    if args.whole {
        return (listed("whole", 0, boards(args, "whole", picture, &mut told), &mut told), told);
    }
    // One half after the other: both at once would hold the picture twice.
    let [left, right] = Half::BOTH.map(|half| {
        let half = HalfImage::cut(picture, half);
        (half.first_column, boards(args, half.half.name(), &half.image, &mut told))
    });
    // Number the second half as the first, board by board.
    let mut right_boards = Vec::new();
    for (number, board) in right.1.into_iter().enumerate() {
        match left.1.get(number) {
            None => right_boards.push(board),
            Some(reference) => {
                right_boards.push(turned_like(reference, board));
                told.extend(differing(reference, &right_boards[number]));
            }
        }
    }
    let mut views = listed(Half::Left.name(), left.0, left.1, &mut told);
    views.extend(listed(Half::Right.name(), right.0, right_boards, &mut told));
    (views, told)
}

/// The boards that are asked for in one view: one, but for `--all-boards`.
fn boards(args: &CornersArgs, view: &str, image: &Raster<f32>, told: &mut Vec<String>) -> Vec<Detection> {
    let settings = Settings::default();
    let Some(size) = args.board else {
        return if args.all_boards {
            vision::detect_all(image, None, &settings)
        } else {
            vec![vision::detect(image, None, &settings)]
        };
    };
    let fitted = vision::board_of_size(vision::detect_all(image, None, &settings), size);
    if let Some(fitted) = fitted.as_ref().filter(|f| !f.board.corners.is_empty() && !f.is_whole(size)) {
        let [found, stated] = [fitted.reached, size].map(|size| format!("{} x {}", size.columns, size.rows));
        let left_out = match fitted.left_out {
            0 => String::new(),
            n => format!("; {n} that do not fit are left out"),
        };
        told.push(format!("note: {view}: the corners reach over {found} and the board has {stated}{left_out}"));
    }
    fitted.map(|fitted| fitted.board).into_iter().collect()
}

/// That the two halves show other corners of a board, so that one index does not mean one corner.
fn differing(left: &Detection, right: &Detection) -> Option<String> {
    let reached =
        |found: &Detection| found.corners.iter().fold([0; 2], |m, c| [0, 1].map(|k| m[k].max(c.index[k] + 1)));
    // Colours at even places: alike where both count from the same corner.
    let main = |found: &Detection| {
        found.corners.first().map(|c| (c.polarity == Polarity::Main) ^ ((c.index[0] + c.index[1]) % 2 != 0))
    };
    let ([a, b], colours) = ([left, right].map(reached), main(left) == main(right));
    let told = || {
        format!(
            "note: left reaches over {} x {} corners and right over {} x {}{}: each half counts from its own first corner, so that \
             one index is not one corner of the board in both; --scene SCENE gives the board's own",
            a[0],
            a[1],
            b[0],
            b[1],
            if colours { "" } else { ", of other colours" }
        )
    };
    let both = !left.corners.is_empty() && !right.corners.is_empty();
    (both && (a != b || !colours)).then(told)
}

/// Letters that name the boards of a view from the second on, and so the most that a file holds.
const SECOND_ON: std::ops::RangeInclusive<char> = 'b'..='h';

/// The boards of a view as a file holds them: `left`, `leftb`, `leftc`.
fn listed(name: &str, first_column: usize, boards: Vec<Detection>, told: &mut Vec<String>) -> Vec<CornerView> {
    let names = std::iter::once(name.to_owned()).chain(SECOND_ON.map(|letter| format!("{name}{letter}")));
    let most = SECOND_ON.count() + 1;
    if boards.len() > most {
        told.push(format!("note: {name}: of {} boards the {most} of most corners are given", boards.len()));
    }
    names.zip(&boards).map(|(name, board)| CornerView::new(&name, first_column, board)).collect()
}

/// What was written of a view, in numbers.
fn counted(view: &CornerView) -> Value {
    let rejected: serde_json::Map<String, Value> =
        view.rejected.iter().map(|(reason, n)| (reason.clone(), json!(n))).collect();
    json!({ "half": view.name, "corners": view.corners.len(), "rejected": rejected, "blur_px": view.blur_px,
        "elongated_blur": view.elongated_blur, "lean_px": view.lean_px,
        "marked_squares": view.marked_squares, "transfer": view.transfer })
}

/// What a file says of a curve that was found.
fn found(choice: &TransferChoice) -> TransferFound {
    TransferFound {
        curve: choice.curve.name(),
        residual: choice.residual,
        next: choice.next.name(),
        next_residual: choice.next_residual,
        standard_errors: choice.standard_errors,
    }
}
