//! Draws of a set: each belongs to the seed and to the number of its picture alone, whatever others are made.

use super::plan::{BoardPlaces, DatasetPlan, InView, PlaceRanges, StatedPlace};
use crate::analysis::half_image::HalfFrame;
use crate::analysis::truth;
use crate::error::Error;
use crate::geom::Pose;
use crate::num::deviates::Stream;
use crate::scene::BoardSpec;
use crate::system::aim::Aimer;
use crate::system::{Side, System};
use crate::vision::half::Half;
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// The purpose of the random numbers.
const PURPOSE: u32 = 0x6461_7461;
/// Places that are drawn for a picture at most.
const MOST_DRAWS: u32 = 1000;

/// What is drawn for a picture besides the board's place; shares of the plan's ranges, from 0 to 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct LookDraw {
    pub(super) look: f64,
    pub(super) noise: f64,
    pub(super) exposure: f64,
    /// Number of the sensor's exposure.
    pub(super) frame: u32,
}

impl LookDraw {
    /// The draw of picture `number`. All are drawn whether or not they are asked for, so that none depends on that.
    pub(super) fn new(seed: u64, number: u32) -> Self {
        let mut stream = Stream::new(seed, PURPOSE, 0, number);
        let [look, noise, exposure, frame] = [(); 4].map(|()| stream.uniform());
        Self { look, noise, exposure, frame: (frame * f64::from(u32::MAX)) as u32 }
    }
}

/// A place that was drawn, and from which numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DrawnPlace {
    pub(super) place: StatedPlace,
    /// Angle between the board's normal and +z, and turn about the normal, in deg.
    pub(super) tilt_and_roll_deg: Option<[f64; 2]>,
}

/// The place of the board in picture `number` of the instrument `system`, whose board is `board`.
///
/// # Errors
/// When no place was found at which both halves see what they must.
pub(super) fn place(plan: &DatasetPlan, system: &System, board: &BoardSpec, number: u32) -> Result<DrawnPlace, Error> {
    let ranges = match &plan.places {
        BoardPlaces::Listed(places) => {
            return Ok(DrawnPlace { place: places[number as usize], tilt_and_roll_deg: None });
        }
        BoardPlaces::Drawn(ranges) => ranges,
    };
    let found = (1..=MOST_DRAWS).find_map(|draw| {
        let (drawn, px) = candidate(ranges, system, &mut Stream::new(plan.seed, PURPOSE, draw, number))?;
        let own = BoardSpec { world_from_board: drawn.place.pose(), ..*board };
        is_seen(&system.with_board(&own), ranges.in_view, px).then_some(drawn)
    });
    found.ok_or_else(|| {
        let (what, help) = match ranges.in_view {
            InView::Centre => ("its middle", "give other distances, where the views of both halves overlap"),
            InView::Whole => {
                ("all of its squares", "give larger distances, a smaller board, or `--in-view centre`, which lets it be cut")
            }
        };
        let size = board.squares_mm();
        let rule = format!(
            "of {MOST_DRAWS} places of the board ({} x {} mm) that were drawn for it from {} to {} mm, both halves see {what} at none",
            size.x, size.y, ranges.distance_mm.low, ranges.distance_mm.high
        );
        Error::new(format_args!("pose {number}"), rule, help)
    })
}

impl StatedPlace {
    /// The board's frame in the world.
    pub(super) fn pose(&self) -> Pose {
        Pose::new(self.position_mm, DVec3::from_array(self.tilt_deg.to_array().map(f64::to_radians)))
    }
}

/// A place drawn from `ranges`, its middle on the ray of the position in the picture that it comes with; `None` where that sees
/// nothing.
fn candidate(ranges: &PlaceRanges, system: &System, stream: &mut Stream) -> Option<(DrawnPlace, DVec2)> {
    let [distance, tilt, towards, roll, x, y] = [(); 6].map(|()| stream.uniform());

    // Tilt the board, turned about its normal, towards a direction.
    let [tilt_deg, roll_deg] = [ranges.tilt_deg.at(tilt), ranges.roll_deg.at(roll)];
    let towards_rad = TAU * towards;
    let turn = Pose::new(DVec3::ZERO, DVec3::new(0.0, 0.0, roll_deg.to_radians() - towards_rad));
    let lean = Pose::new(DVec3::ZERO, DVec3::new(0.0, tilt_deg.to_radians(), towards_rad));
    let angles_rad = lean.after(&turn).angles_rad();

    // Put its middle where a position of the picture looks.
    let px = DVec2::from(system.camera().size_px().map(|n| n as f64)) * DVec2::new(x, y);
    let (ray, _) = system.exit_ray(px).ok().filter(|(ray, _)| ray.direction.z > 0.0)?;
    let z_mm = system.camera_spec().position_mm.z + ranges.distance_mm.at(distance);
    let on_ray = ray.at((z_mm - ray.origin.z) / ray.direction.z);
    let position_mm = DVec3::new(on_ray.x, on_ray.y, z_mm);
    let tilt = DVec3::from_array(angles_rad.to_array().map(f64::to_degrees));
    let place = StatedPlace { position_mm, tilt_deg: tilt };
    Some((DrawnPlace { place, tilt_and_roll_deg: Some([tilt_deg, roll_deg]) }, px))
}

/// Whether both halves see what they must of the board of `system`, whose middle one of them sees at `px`.
fn is_seen(system: &System, in_view: InView, px: DVec2) -> bool {
    // Search the other half from the place that is as far from its edge.
    let [width, height] = system.camera().size_px().map(|n| n as f64);
    let Ok(own) = system.trace(px).map(|hit| hit.side) else { return false };
    let over = if own == Side::Left { 0.5 * width } else { -0.5 * width };
    let Ok(other_px) = system.aim_from(px + DVec2::new(over, 0.0), DVec2::ZERO, own.other()) else { return false };
    let on_sensor = other_px.cmpge(DVec2::ZERO).all() && other_px.cmple(DVec2::new(width, height)).all();
    let middle = on_sensor && system.trace(other_px).is_ok_and(|hit| hit.side == own.other());
    middle && (in_view == InView::Centre || shows_all_squares(system))
}

/// Whether both halves see every square, by its four corners: those of the whole first, which most places fail.
fn shows_all_squares(system: &System) -> bool {
    let aimer = &Aimer::new(system);
    let half = 0.5 * system.board().pattern.squares_mm();
    let both = |mm: DVec2| Side::ALL.into_iter().all(|s| aimer.aim(mm, s).is_ok_and(|px| aimer.sees(px, s)));
    let rim = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    if !rim.into_iter().all(|corner| both(half * DVec2::from(corner))) {
        return false;
    }
    let inner: usize = system.board().inner_corners().into_iter().product();
    Half::BOTH.into_iter().all(|half| {
        let corners = truth::corners(system, aimer, &HalfFrame::new(system, half));
        corners.is_some_and(|corners| corners.len() == inner && corners.values().all(|corner| corner.whole))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::dataset::plan::DrawRange;

    /// The normal of the board is as far from z as was drawn, and the turn about it is told.
    #[test]
    fn tilt_is_that_of_the_normal() {
        let scene = crate::scene::parse(include_str!("../../../scenes/cases/prism_flat.toml"), "flat", None).unwrap();
        let system = crate::system::build(&scene).unwrap();
        let range = |low, high| DrawRange { low, high };
        let ranges = PlaceRanges {
            distance_mm: range(400.0, 1600.0),
            tilt_deg: range(0.0, 60.0),
            roll_deg: range(-180.0, 180.0),
            in_view: InView::Centre,
        };
        let camera_z = scene.camera.position_mm.z;
        for number in 0..200 {
            let (drawn, px) = candidate(&ranges, &system, &mut Stream::new(7, PURPOSE, 1, number)).unwrap();
            let [tilt_deg, roll_deg] = drawn.tilt_and_roll_deg.unwrap();
            let pose = drawn.place.pose();
            // Degrees and back, and two products of rotations: a few roundings of 1, whose arc cosine near 1 is their root.
            let angle = libm::acos(pose.rotation.z_axis.z.clamp(-1.0, 1.0)).to_degrees();
            assert!((angle - tilt_deg).abs() < 1e-5, "{angle} {tilt_deg}");
            // Without its tilt, along the shortest way back, it is turned by the roll.
            let axis = pose.rotation.z_axis.cross(DVec3::Z);
            let upright = if axis.length() < 1e-9 {
                pose.rotation.x_axis
            } else {
                let (axis, x) = (axis.normalize(), pose.rotation.x_axis);
                let (sin, cos) = libm::sincos(tilt_deg.to_radians());
                x * cos + axis.cross(x) * sin + axis * axis.dot(x) * (1.0 - cos)
            };
            let turned = libm::atan2(upright.y, upright.x).to_degrees() - roll_deg;
            assert!(((turned + 540.0).rem_euclid(360.0) - 180.0).abs() < 1e-5, "{turned}");
            assert!((400.0..=1600.0).contains(&(drawn.place.position_mm.z - camera_z)));
            // The position sees the board's middle.
            let board = BoardSpec { world_from_board: pose, ..scene.board };
            assert!(system.with_board(&board).trace(px).unwrap().board_mm.length() < 1e-9);
        }
    }
}
