//! Places of the board, and all else that is drawn, as it was asked for.

use crate::analysis::dataset::{BoardPlaces, DatasetPlan, DrawRange, PlaceRanges, StatedPlace};
use crate::cli::dataset_args::{DatasetArgs, MOST_POSES};
use crate::cli::field_lines::{each_line, number};
use crate::cli::files;
use crate::error::Error;
use crate::scene::Scene;
use glam::DVec3;
use std::path::Path;

/// The columns of a file of places.
const COLUMNS: [&str; 6] = ["x_mm", "y_mm", "z_mm", "tilt_x_deg", "tilt_y_deg", "tilt_z_deg"];
/// Distances of the boards where nothing is said, of that of the scene's own board.
const USUAL_DISTANCES: [f64; 2] = [0.7, 1.5];

/// What is to be drawn for a set of `scene`, and of how many pictures.
pub(super) fn plan(args: &DatasetArgs, scene: &Scene) -> Result<(DatasetPlan, u32), Error> {
    let (places, count) = match &args.pose_file {
        Some(path) => {
            let places = listed(path)?;
            let count = places.len() as u32;
            (BoardPlaces::Listed(places), count)
        }
        None => (BoardPlaces::Drawn(drawn(args, scene)), args.poses.unwrap_or(1)),
    };
    let looks = args.texture.iter().copied().map(Into::into).collect();
    let plan = DatasetPlan { seed: args.seed, places, looks, noise: args.noise, exposure: args.exposure };
    Ok((plan, count))
}

fn drawn(args: &DatasetArgs, scene: &Scene) -> PlaceRanges {
    let own_mm = scene.board.world_from_board.translation_mm.z - scene.camera.position_mm.z;
    let [low, high] = USUAL_DISTANCES.map(|times| times * own_mm);
    PlaceRanges {
        distance_mm: args.distance_mm.unwrap_or(DrawRange { low, high }),
        tilt_deg: args.tilt_deg,
        roll_deg: args.roll_deg,
        in_view: args.in_view.into(),
    }
}

/// The places in the file at `path`.
fn listed(path: &Path) -> Result<Vec<StatedPlace>, Error> {
    let mut places = Vec::new();
    each_line(path, &COLUMNS[..1], |place, fields| {
        let fields: [&str; 6] = fields.try_into().map_err(|_| {
            let rule = format!("the line has {} fields, and must have 6", fields.len());
            Error::new(place, rule, format!("write {}, as in 12.5,-3,1000,0,20,5", COLUMNS.join(",")))
        })?;
        if places.len() == MOST_POSES as usize {
            let rule = format!("there are more than {MOST_POSES} places, the most that are taken");
            return Err(Error::new(place, rule, "split the file, and give each part a folder of its own"));
        }
        let mut values = [0.0; 6];
        for (k, value) in values.iter_mut().enumerate() {
            *value = number(place, COLUMNS[k], fields[k])?;
        }
        let [x, y, z, tilt_x, tilt_y, tilt_z] = values;
        places.push(StatedPlace { position_mm: DVec3::new(x, y, z), tilt_deg: DVec3::new(tilt_x, tilt_y, tilt_z) });
        Ok(())
    })?;
    if places.is_empty() {
        let help = format!("write a line {} for each picture", COLUMNS.join(","));
        return Err(Error::new(files::shown(path), "the file has no place of a board", help));
    }
    Ok(places)
}
