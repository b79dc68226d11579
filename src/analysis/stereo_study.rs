//! Stereo without rectification: what is left of points that both halves see, as the halves are, and after each of what software can
//! do about it.

use super::half_image::{HalfFrame, row_shift, virtual_camera};
use super::judge::grid_sightings;
use super::rectify::{Rectifier, plane, seen_px};
use crate::error::Error;
use crate::metrics::pair_residual::{PairResidual, SeenPoint};
use crate::metrics::pinhole::Pinhole;
use crate::metrics::pixel_map::{Correspondence, PixelMap};
use crate::metrics::ray_bundle::PixelRay;
use crate::metrics::rectified_pair::{CentreAndLook, RectifiedPair};
use crate::scene::{DesignGoal, DesignSettings, Objective, PrismSpec, Rear, Scene};
use crate::system::aim::Aimer;
use crate::system::{InLight, System};
use crate::vision::half::Half;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Rays along each edge of a half to which a warp is fitted.
const FIT_GRID: usize = 33;

/// What is studied.
#[derive(Debug, Clone)]
pub struct StereoStudyInput {
    /// Planes across the axis, by their depths from the camera, in mm; a tilted one stands at the depth of the fit.
    pub depths_mm: Vec<f64>,
    /// The depth at which warps and maps are right, in mm.
    pub fit_depth_mm: f64,
    /// The turn of the tilted plane about the vertical, in radians.
    pub tilt_rad: f64,
    /// Total degree of the warps.
    pub degree: usize,
    /// Points along each edge of the left half.
    pub grid: usize,
}

/// What is done to both halves before they are matched.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Treatment {
    /// Nothing.
    Raw,
    /// The shift of each row that the prism's law states is undone.
    RowShift,
    /// A polynomial of the position a half, which makes it a pinhole at one depth: the rival in software.
    Warp,
    /// The maps of `biprism rectify`.
    Map,
}

impl Treatment {
    /// Its word.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Raw => "raw",
            Self::RowShift => "row shift",
            Self::Warp => "warp",
            Self::Map => "map",
        }
    }
}

/// A plane on which points are matched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Where the axis meets it, from the camera, in mm.
    pub depth_mm: f64,
    /// Its turn about the vertical, in radians.
    pub tilt_rad: f64,
}

/// What a treatment leaves on a plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TreatedPlace {
    /// The treatment.
    pub treatment: Treatment,
    /// The plane.
    pub place: Place,
    /// What it leaves; `None` where both halves see nothing in common.
    pub residual: Option<PairResidual>,
}

/// The study of one prism.
#[derive(Debug, Clone)]
pub struct StereoStudy {
    /// The virtual cameras that the halves are designed to be, as a pair.
    pub designed: RectifiedPair,
    /// The pair of the maps.
    pub mapped: RectifiedPair,
    /// Where the camera is, in mm.
    pub camera_mm: DVec3,
    /// What each treatment leaves on each plane.
    pub places: Vec<TreatedPlace>,
}

/// The exact prism of the scene's flat or freeform one: of the same glass, ridge and thickness, with the rows for epipolar lines and
/// one smooth rear surface; `None` where the scene's own is one already, or is given by its surfaces.
pub(crate) fn exact_of(scene: &Scene) -> Option<Scene> {
    let flat = match &scene.prism {
        PrismSpec::Freeform(_, settings) if settings.objective == Objective::Epipolar => return None,
        PrismSpec::Flat(flat) | PrismSpec::Freeform(flat, _) => *flat,
        _ => return None,
    };
    let settings = DesignSettings {
        objective: Objective::Epipolar,
        degree: 7,
        goal: DesignGoal { rear: Rear::Even, ..DesignGoal::PLAIN },
        ..DesignSettings::of_sensor(scene.camera.width_px)
    };
    Some(Scene { prism: PrismSpec::Freeform(flat, settings), ..scene.clone() })
}

/// The study of one instrument, of its board's plane alone: objects hide nothing.
///
/// # Errors
/// When its halves have no virtual cameras, or make no rectified pair.
pub fn study(system: &System, input: &StereoStudyInput) -> Result<StereoStudy, Error> {
    // Make the cameras, the warps and the maps.
    let designed = DesignedPair::new(system)?;
    let rectifier = Rectifier::new(system, input.fit_depth_mm)?;
    let warps = designed.warps(system, input)?;
    let light = InLight::new(rectifier.at_plane());

    // Match points on each plane, and treat them.
    let upright = input.depths_mm.iter().map(|&depth_mm| Place { depth_mm, tilt_rad: 0.0 });
    let tilted = Place { depth_mm: input.fit_depth_mm, tilt_rad: input.tilt_rad };
    let places = upright.chain((input.tilt_rad != 0.0).then_some(tilted));
    let mut found: Vec<TreatedPlace> = Vec::new();
    for place in places {
        let there = system.with_board(&plane(system, &designed.pair, place.depth_mm, place.tilt_rad));
        let seen = seen_by_both(&there, &designed.frames, input.grid);
        let mut add = |treatment, pair: &RectifiedPair, image: &(dyn Fn(usize, DVec2) -> Option<DVec2> + Sync)| {
            let residual = treated(&seen, image).and_then(|seen| PairResidual::of(pair, &seen));
            found.push(TreatedPlace { treatment, place, residual });
        };
        let raw = |k, full_px| designed.image_px(system, k, full_px);
        add(Treatment::Raw, &designed.pair, &raw);
        if designed.frames.iter().any(|frame| row_shift(system, frame).is_some()) {
            add(Treatment::RowShift, &designed.pair, &|k, full_px| designed.unshifted_px(system, k, full_px));
        }
        add(Treatment::Warp, &designed.pair, &|k, full_px| warps[k].at(raw(k, full_px)?));
        add(Treatment::Map, rectifier.pair(), &|k, full_px| rectifier.shown_px(k, full_px, &light));
    }
    let camera_mm = system.camera().position_mm();
    Ok(StereoStudy { designed: designed.pair, mapped: *rectifier.pair(), camera_mm, places: found })
}

/// Positions in the whole picture, left and right, and the point that both see.
type Matched = ([DVec2; 2], DVec3);

/// Points of the board that both halves see, from a grid of pixels of the left one.
fn seen_by_both(there: &System, frames: &[HalfFrame; 2], grid: usize) -> Vec<Matched> {
    let (light, aimer) = (InLight::new(there), Aimer::new(there));
    let [left, right] = frames;
    let places: Vec<(usize, usize)> = (0..grid).flat_map(|j| (0..grid).map(move |i| (i, j))).collect();
    let found = places.into_par_iter().filter_map(|(i, j)| {
        let full_px = left.full(left.size_px * (DVec2::new(i as f64, j as f64) + 0.5) / grid as f64);
        let hit = light.trace(full_px).ok().filter(|hit| hit.side == left.side())?;
        let other_px = seen_px(right, &aimer, hit.board_mm)?;
        Some(([full_px, other_px], there.board().world(hit.board_mm)))
    });
    found.collect()
}

/// The matched points where a treatment puts them; `None` where it has no place for one.
fn treated(seen: &[Matched], image: &(dyn Fn(usize, DVec2) -> Option<DVec2> + Sync)) -> Option<Vec<SeenPoint>> {
    let one = |(full_px, point_mm): &Matched| {
        Some(SeenPoint { image_px: [image(0, full_px[0])?, image(1, full_px[1])?], point_mm: *point_mm })
    };
    seen.par_iter().map(one).collect()
}

/// The virtual cameras that the halves are designed to be, as a rectified pair.
struct DesignedPair {
    frames: [HalfFrame; 2],
    cameras: [Pinhole; 2],
    /// The same cameras turned alike, where a design has them toed in.
    pair: RectifiedPair,
}

impl DesignedPair {
    fn new(system: &System) -> Result<Self, Error> {
        let help = "use a pinhole camera whose half images look through the prism";
        let frames = Half::BOTH.map(|half| HalfFrame::new(system, half));
        let camera = |k: usize| {
            virtual_camera(system, &frames[k]).map_err(|why| {
                Error::new("the half image", format!("it has no virtual camera: {}", why.reason()), help)
            })
        };
        let cameras = [camera(0)?, camera(1)?];
        let look = |k: usize| {
            let image_px = frames[k].own(frames[k].centre_px(system));
            CentreAndLook { centre_mm: cameras[k].centre_mm(), direction: direction(&cameras[k], image_px), image_px }
        };
        let pair = RectifiedPair::new([look(0), look(1)], cameras[0].focal_px)
            .map_err(|why| Error::new("prism", format!("its virtual cameras make no pair: {why}"), help))?;
        Ok(Self { frames, cameras, pair })
    }

    /// Where the pair's image `k` shows what the half shows at `half_px`, as if that were its virtual camera.
    fn turned_px(&self, k: usize, half_px: DVec2) -> Option<DVec2> {
        let camera = &self.pair.cameras()[k];
        camera.project(camera.centre_mm() + direction(&self.cameras[k], half_px))
    }

    /// The half as it is, but for the camera's own lens.
    fn image_px(&self, system: &System, k: usize, full_px: DVec2) -> Option<DVec2> {
        let frame = &self.frames[k];
        self.turned_px(k, frame.rectified(system.camera(), frame.own(full_px)))
    }

    /// The same without the shift of its rows.
    fn unshifted_px(&self, system: &System, k: usize, full_px: DVec2) -> Option<DVec2> {
        let frame = &self.frames[k];
        let half_px = frame.rectified(system.camera(), frame.own(full_px));
        self.turned_px(k, row_shift(system, frame).map_or(half_px, |rows| rows.undone(half_px)))
    }

    /// The polynomials that make each half its pinhole of the pair at the depth of the fit.
    fn warps(&self, system: &System, input: &StereoStudyInput) -> Result<Vec<PixelMap>, Error> {
        let there = system.with_board(&plane(system, &self.pair, input.fit_depth_mm, 0.0));
        let of = |k: usize| {
            let camera = &self.pair.cameras()[k];
            let sample = |sighting: PixelRay| {
                let [origin, toward] = [sighting.ray.origin, sighting.ray.at(1.0)].map(|p| there.board().local(p).z);
                let along = origin / (origin - toward);
                let value = (along > 0.0).then(|| camera.project(sighting.ray.at(along)))??;
                Some(Correspondence { image_px: self.turned_px(k, sighting.image_px)?, value })
            };
            let samples: Vec<_> =
                grid_sightings(system, &self.frames[k], FIT_GRID).into_iter().filter_map(sample).collect();
            PixelMap::fit(&samples, input.degree).map_err(|why| {
                let rule = format!("the {} half has no warp of degree {}: {why}", Half::BOTH[k].name(), input.degree);
                Error::new("the half image", rule, "give a lower --degree, or a prism that both halves look through")
            })
        };
        [0, 1].into_iter().map(of).collect()
    }
}

/// Where a camera's pixel looks, in the world.
fn direction(camera: &Pinhole, image_px: DVec2) -> DVec3 {
    camera.camera_from_world.rotation.transpose() * camera.at_depth(image_px, 1.0)
}
