//! How the corners of a photograph were matched and where its board is: as entries of the report, and in words.

use super::json::{BoardPoseEntry, BoardPoseSource, MatchedByName, MatchingEntry, PlacedByName};
use super::number::{number, rounded};
use crate::analysis::photograph::{FoundPose, MatchedBy, PlacedBy, PoseSource};
use crate::geom::Pose;

/// What a fit of a pose leaves free.
const FREE: [&str; 6] = ["position_x_mm", "position_y_mm", "position_z_mm", "tilt_x_deg", "tilt_y_deg", "tilt_z_deg"];
/// What is taken from pairs of corners.
const OF_PAIRS: [&str; 9] = [
    "stereo/vertical_disparity_rms_px",
    "stereo/vertical_disparity_max_px",
    "stereo/vertical_disparity_mean_px",
    "stereo/opencv_average_epipolar_px",
    "stereo/depth_law_rms_px",
    "stereo/depth_error_rms_mm",
    "stereo/depth_error_max_mm",
    "stereo/depth_error_rms_percent",
    "stereo/depth_error_max_percent",
];
/// A match that is off by more squares than this from what the rays say contradicts them.
const CONTRADICTS: f64 = 0.6;

/// The entry of where the board is.
pub fn entry(found: &FoundPose) -> BoardPoseEntry {
    let (source, failure) = match found.source {
        PoseSource::Stated => (BoardPoseSource::Stated, None),
        PoseSource::Asked => (BoardPoseSource::Asked, None),
        PoseSource::Mismatch => (BoardPoseSource::Mismatch, None),
        PoseSource::Unknown(failure) => (BoardPoseSource::Unknown, Some(failure.to_string())),
    };
    let known = (source != BoardPoseSource::Unknown).then_some(found.world_from_board);
    let free: &[&str] = if found.stated.is_some() { &FREE } else { &[] };
    BoardPoseEntry {
        source,
        free: free.iter().map(|name| (*name).to_owned()).collect(),
        position_mm: known.map(|pose| pose.translation_mm.to_array()),
        tilt_deg: known.map(|pose| tilt_deg(&pose)),
        residual_rms_px: found.deviation.map(|d| d.rms),
        residual_max_px: found.deviation.map(|d| d.max),
        corners: found.corners as u64,
        stated_rms_px: found.stated.and_then(|stated| Some(stated.deviation?.rms)),
        off_mm: found.stated.map(|stated| stated.off_mm),
        off_deg: found.stated.map(|stated| stated.off_rad.to_degrees()),
        other_tilt_deg: found.other.as_ref().map(tilt_deg),
        failure,
        placed_by: match found.placed {
            PlacedBy::OnlyPlace => PlacedByName::OnlyPlace,
            PlacedBy::NearestToStated => PlacedByName::NearestToStated,
            PlacedBy::AgainstColours => PlacedByName::AgainstColours,
            PlacedBy::LargerThanBoard => PlacedByName::LargerThanBoard,
        },
        seen: found.seen.map(|n| n as u64),
    }
}

/// The entry of how the halves were matched; `None` where they were not.
pub fn matching(found: &FoundPose) -> Option<MatchingEntry> {
    let matched = found.matched?;
    let [columns_by, rows_by] = matched.by.map(|by| match by {
        MatchedBy::WholeBoard => MatchedByName::WholeBoard,
        MatchedBy::Rays => MatchedByName::Rays,
        MatchedBy::StatedPose => MatchedByName::StatedPose,
    });
    let rests: &[&str] = if matched.is_sure() { &[] } else { &OF_PAIRS };
    Some(MatchingEntry {
        columns_by,
        rows_by,
        doubt_squares: matched.doubt,
        rests: rests.iter().map(|path| (*path).to_owned()).collect(),
    })
}

fn tilt_deg(pose: &Pose) -> [f64; 3] {
    pose.angles_rad().to_array().map(f64::to_degrees)
}

/// A line for the table: where the board is, what was free, and what is left.
pub fn line(pose: &BoardPoseEntry) -> Option<String> {
    let (at, tilt) = (list(&pose.position_mm?), list(&pose.tilt_deg?));
    let left = number(pose.residual_rms_px);
    let n = pose.corners;
    Some(if pose.free.is_empty() {
        format!(
            "board as stated, at [{at}] mm, tilt [{tilt}] deg: residual RMS {left} px over {n} corners of both halves"
        )
    } else {
        format!(
            "board fitted to {n} corners of both halves, its position and its tilt about x, y and z free: at [{at}] mm, tilt \
             [{tilt}] deg, residual RMS {left} px"
        )
    })
}

/// A line for the table: what the figures of pairs rest on, where they do.
pub fn rests(matching: &MatchingEntry) -> Option<String> {
    let by = |by: MatchedByName| match by {
        MatchedByName::WholeBoard => "the whole board in both halves",
        MatchedByName::Rays => "the size of the squares in one half and the scene's prism",
        MatchedByName::StatedPose => "the stated pose of the board",
    };
    let (columns, rows) = (by(matching.columns_by), by(matching.rows_by));
    let told = if columns == rows { columns.to_owned() } else { format!("{columns} (columns) and {rows} (rows)") };
    (!matching.rests.is_empty()).then(|| {
        format!(
            "*: rests on which corner of the left half is which of the right one, told by {told}, {} squares from a whole shift",
            number(Some(matching.doubt_squares))
        )
    })
}

/// What a user must know of the pose and the match, in sentences.
pub fn notes(pose: &BoardPoseEntry, matching: Option<&MatchingEntry>, inner: [usize; 2]) -> Vec<String> {
    let mut notes = Vec::new();
    if pose.source == BoardPoseSource::Mismatch
        && let (Some(at), Some(tilt)) = (pose.position_mm, pose.tilt_deg)
    {
        let left = match pose.stated_rms_px {
            Some(rms) => format!("{} px (RMS) from where it has them", number(Some(rms))),
            None => "where it never has them".to_owned(),
        };
        notes.push(format!(
            "the stated pose of the board does not match the picture, whose corners are {left}, and was fitted instead: it is \
             off by {} mm and {} deg; write `position_mm = [{}]` and `tilt_deg = [{}]`, or `pose = \"fit\"`, in `[board]`",
            number(pose.off_mm),
            number(pose.off_deg),
            list(&at),
            list(&tilt)
        ));
    }
    if let Some(failure) = &pose.failure {
        notes.push(format!(
            "it is not known where the board is, and figures that need it are left out: the fit of its pose failed ({failure}), \
             and the stated one does not match the picture; write the board's place to 0.3 of a square"
        ));
    }
    match pose.placed_by {
        PlacedByName::NearestToStated if !pose.free.is_empty() => notes.push(
            "which corners of the board are seen is told by the stated pose, the nearest of places that look alike: the fitted \
             position holds up to whole squares; show the whole board to be sure"
                .to_owned(),
        ),
        PlacedByName::AgainstColours => notes.push(
            "no place on the board has the colours of the picture, whose top left square is not the black one: exchange \
             `board.black` and `board.white`, or check `board.columns` and `board.rows`"
                .to_owned(),
        ),
        PlacedByName::LargerThanBoard => notes.push(format!(
            "the picture shows {} x {} inner corners, and the scene's board has {} x {}: check `board.columns` and `board.rows`",
            pose.seen[0], pose.seen[1], inner[0], inner[1]
        )),
        PlacedByName::OnlyPlace | PlacedByName::NearestToStated => {}
    }
    if let Some(tilt) = pose.other_tilt_deg {
        notes.push(format!(
            "the corners do not tell the board's tilt from [{}] deg: tilt it more, or take a sharper picture",
            list(&tilt)
        ));
    }
    notes.extend(matching.and_then(contradiction));
    notes
}

fn contradiction(matching: &MatchingEntry) -> Option<String> {
    let squares = number(Some(matching.doubt_squares));
    if matching.doubt_squares > CONTRADICTS {
        return Some(format!(
            "both halves show the whole board, and the scene's prism and camera put them {squares} squares apart: check \
             `board.square_mm`, `[prism]` and `[camera]`"
        ));
    }
    let stated = [matching.columns_by, matching.rows_by].contains(&MatchedByName::StatedPose);
    stated.then(|| {
        "the left half was matched to the right one by the stated pose of the board: show the whole board in both halves to be \
         sure"
            .to_owned()
    })
}

/// Three numbers as a scene has them.
fn list(values: &[f64; 3]) -> String {
    values.map(|v| if v.abs() < 5e-7 { "0".to_owned() } else { rounded(v) }).join(", ")
}
