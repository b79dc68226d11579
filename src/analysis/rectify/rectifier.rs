//! The rectified pair of an instrument, and the plane at which its maps are right.

use crate::analysis::half_image::{HalfFrame, NoPinhole};
use crate::analysis::judge::grid_sightings;
use crate::error::Error;
use crate::geom::{Pose, Ray};
use crate::metrics::Unmeasurable;
use crate::metrics::ray_bundle::{CommonPoint, RayMisses, common_point};
use crate::metrics::rectified_pair::{CentreAndLook, RectifiedPair};
use crate::optics::fate::Fate;
use crate::scene::BoardSpec;
use crate::system::{InLight, System};
use crate::vision::half::Half;
use glam::{DMat3, DVec2, DVec3};

/// Rays along each edge of a half, of which the centre of its camera is the best common point.
pub(super) const GRID: usize = 33;

/// A rectified pair in place of an instrument's halves.
#[derive(Debug, Clone)]
pub struct Rectifier {
    pub(super) pair: RectifiedPair,
    /// Left and right.
    pub(super) frames: [HalfFrame; 2],
    /// The instrument before a board in the plane at which the maps are right.
    pub(super) at_plane: System,
    /// The depth of that plane from the camera, in mm.
    pub(super) depth_mm: f64,
    /// The rays of each half, behind the prism.
    pub(super) rays: [Vec<Ray>; 2],
    /// How far those pass by the centre of their camera.
    misses: [RayMisses; 2],
}

impl Rectifier {
    /// The pair at the best common points of the rays of each half, with the focal lengths that the prism's law states, or
    /// else that of the camera; a half's centre is seen where it is. Its maps are to be right `depth_mm` from the camera, in the
    /// plane across the pair's axis.
    ///
    /// # Errors
    /// An instrument without a prism, a telecentric one, one whose halves have no centre or no central ray, or see nothing
    /// in common there.
    pub fn new(system: &System, depth_mm: f64) -> Result<Self, Error> {
        let Some(designed) = system.designed() else {
            let help = "give a scene with a prism, as scenes/paper.toml";
            return Err(Error::new("prism", "there is no prism, and so no pair of images to be rectified", help));
        };
        let camera = system.camera();
        let camera_focal_px =
            1.0 / camera.tangent_per_px().ok_or_else(|| no_camera(Half::Left, NoPinhole::Telecentric))?;
        let pitch_mm = system.camera_spec().pitch_mm;
        let focal_px = designed.law().map_or(DVec2::splat(camera_focal_px), |law| DVec2::from(law.focal_mm) / pitch_mm);

        // Find the centres, and where the middle of each half looks.
        let frames = Half::BOTH.map(|half| HalfFrame::new(system, half));
        let rays = frames.map(|frame| -> Vec<Ray> {
            grid_sightings(system, &frame, GRID)
                .into_iter()
                .map(|s| s.ray)
                .filter(|ray| ray.direction.z > 0.0)
                .collect()
        });
        let light = InLight::new(system);
        let [left, right] = [0, 1].map(|k| -> Result<_, Error> {
            let frame = &frames[k];
            let common = common_point(&rays[k]).map_err(|why| no_centre(frame.half, &why))?;
            let middle = light
                .exit_ray_through(frame.centre_px(system), frame.side())
                .map_err(|fate| no_camera(frame.half, NoPinhole::Ends(fate)))?;
            Ok((common, look(system, frame, (&common, &middle), depth_mm)?))
        });
        let (left, right) = (left?, right?);
        let pair = RectifiedPair::new([left.1, right.1], focal_px).map_err(|why| {
            Error::new(
                "prism",
                format!("the halves make no pair: {why}"),
                "see what its halves look at with `biprism check`",
            )
        })?;

        let at_plane = system.with_board(&plane(system, &pair, depth_mm, 0.0));
        let misses = [left.0.misses, right.0.misses];
        let rectifier = Self { pair, frames, at_plane, depth_mm, rays, misses };
        if rectifier.pairs(depth_mm).is_none() {
            let rule = format!("no point {depth_mm} mm from the camera is seen by both halves");
            return Err(Error::new("prism", rule, "give a depth at which the halves overlap, with --depth-mm"));
        }
        Ok(rectifier)
    }

    /// Depth of the middle of the board of `system` from its camera along z, in mm.
    pub fn board_depth_mm(system: &System) -> f64 {
        system.board().pattern.world_from_board.translation_mm.z - system.camera().position_mm().z
    }

    /// The two cameras.
    pub fn pair(&self) -> &RectifiedPair {
        &self.pair
    }

    /// The halves, left and right.
    pub fn frames(&self) -> &[HalfFrame; 2] {
        &self.frames
    }

    /// The depth from the camera at which the maps are right, in mm.
    pub fn depth_mm(&self) -> f64 {
        self.depth_mm
    }

    /// How far the rays of the left and the right half pass by the centre of their camera.
    pub fn misses(&self) -> &[RayMisses; 2] {
        &self.misses
    }

    /// How far the centres of the pair lie before the real camera, along the pair's axis, in mm: a depth from the camera less this is
    /// one of the pair.
    pub fn centres_ahead_mm(&self) -> f64 {
        self.pair.ahead_of_mm(self.at_plane.camera().position_mm())
    }

    /// The instrument before a board in the plane across the pair's axis, so far from the camera.
    pub(super) fn before_plane(&self, depth_mm: f64) -> System {
        self.at_plane.with_board(&plane(&self.at_plane, &self.pair, depth_mm, 0.0))
    }
}

/// The camera of a half: its centre, and the direction from it to what the middle of the half sees at about `depth_mm`.
fn look(
    system: &System,
    frame: &HalfFrame,
    (common, middle): (&CommonPoint, &Ray),
    depth_mm: f64,
) -> Result<CentreAndLook, Error> {
    if middle.direction.z <= 0.0 {
        return Err(no_camera(frame.half, NoPinhole::Ends(Fate::PastBoard)));
    }
    let along = (system.camera().position_mm().z + depth_mm - middle.origin.z) / middle.direction.z;
    let centre_mm = common.point_mm;
    Ok(CentreAndLook {
        centre_mm,
        direction: middle.at(along) - centre_mm,
        image_px: frame.own(frame.centre_px(system)),
    })
}

/// A board in the plane that the axis of the pair meets `depth_mm` from the camera: across the axis, then turned by `tilt_rad` about
/// the y axis of the pair.
pub(in crate::analysis) fn plane(system: &System, pair: &RectifiedPair, depth_mm: f64, tilt_rad: f64) -> BoardSpec {
    let across = pair.common_from_world().transpose();
    let translation_mm = system.camera().position_mm() + across * DVec3::new(0.0, 0.0, depth_mm);
    let rotation = across * DMat3::from_rotation_y(tilt_rad);
    BoardSpec { world_from_board: Pose { rotation, translation_mm }, ..system.board().pattern }
}

fn no_camera(half: Half, why: NoPinhole) -> Error {
    let place = if why == NoPinhole::Telecentric { "camera" } else { "prism" };
    let rule = format!("the {} half cannot be rectified: {}", half.name(), why.reason());
    Error::new(place, rule, "a half is rectified by a pinhole, and needs a centre that its rays pass near")
}

fn no_centre(half: Half, why: &Unmeasurable) -> Error {
    let rule = format!("the rays of the {} half have no centre: {why}", half.name());
    Error::new("prism", rule, "see with `biprism trace` where its pixels look")
}
