//! Lenses other than the pinhole, and what stands in their light, as a scene file writes them.

use super::rules;
use crate::effect::clipping::{Clipping, Outline, Stop};
use crate::effect::{Quadrature, Telecentric};
use crate::error::Error;
use crate::scene::document::Document;
use crate::scene::limits::*;
use crate::scene::model::{BoardSpec, CameraSpec, PrismSpec};
use crate::scene::source::ValueSource;
use glam::DVec2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TelecentricFile {
    /// Size of an image over that of its object.
    #[schemars(range(min = 1.0 / MAGNIFICATION, max = MAGNIFICATION))]
    pub(super) magnification: f64,
    /// Numerical aperture on the side of the objects: sine of half the angle of the cones that it collects.
    #[serde(default)]
    #[schemars(range(min = 0, max = NA))]
    pub(super) na: f64,
    /// Distance from the camera's position to the plane that it would show sharp without a prism, in mm.
    #[schemars(range(min = SHORTEST_MM, max = LONGEST_MM))]
    pub(super) focus_mm: f64,
}

#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct ClippingFile {
    /// The rim of the prism, about the z axis of its frame, the same on front and back.
    pub(super) rim: Option<RimFile>,
    /// Width of the ground or bevelled strip in place of the ridge, across it, in mm.
    #[schemars(range(min = 0, max = LONGEST_MM))]
    pub(super) chamfer_mm: f64,
    /// A round stop before the camera, about its axis.
    pub(super) stop: Option<StopFile>,
}

/// A rim: a rectangle or a circle.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct RimFile {
    /// Width and height of a rectangular rim, in mm.
    #[schemars(inner(range(min = SHORTEST_MM, max = LONGEST_MM)))]
    pub(super) sides_mm: Option<[f64; 2]>,
    /// Diameter of a round rim, in mm.
    #[schemars(range(min = SHORTEST_MM, max = LONGEST_MM))]
    pub(super) diameter_mm: Option<f64>,
}

/// A round stop.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct StopFile {
    /// Distance from the camera along z, in mm.
    #[schemars(range(min = SHORTEST_MM, max = LONGEST_MM))]
    pub(super) at_mm: f64,
    /// Its diameter, in mm.
    #[schemars(range(min = SHORTEST_MM, max = LONGEST_MM))]
    pub(super) diameter_mm: f64,
}

/// Two lenses cannot stand in one place.
pub(super) fn two_lenses(document: &Document) -> Error {
    let rule = "`effect.thin_lens` and `effect.telecentric` are both there, and the camera has one lens";
    document.fault("effect.telecentric", rule.to_owned(), "take one of the two tables out")
}

pub(super) fn telecentric(document: &Document, file: &TelecentricFile) -> Result<Telecentric, Error> {
    let &TelecentricFile { magnification, na, focus_mm } = file;
    let lens = Telecentric { magnification, na, focus_mm };
    rules::cone_behind(document, &lens).map(|()| lens)
}

/// A rim has one shape, and a stop stands before the prism, or before the board where there is none.
pub(super) fn clipping(
    document: &Document,
    file: &ClippingFile,
    camera: &CameraSpec,
    prism: &PrismSpec,
    board: &BoardSpec,
) -> Result<Clipping, Error> {
    let outline = match &file.rim {
        None => None,
        Some(RimFile { sides_mm: Some([width, height]), diameter_mm: None }) => {
            Some(Outline::Rectangle { half_mm: 0.5 * DVec2::new(*width, *height) })
        }
        Some(RimFile { sides_mm: None, diameter_mm: Some(diameter) }) => {
            Some(Outline::Circle { radius_mm: 0.5 * diameter })
        }
        Some(RimFile { sides_mm, .. }) => {
            let said = if sides_mm.is_some() { "both `sides_mm` and `diameter_mm`" } else { "no size" };
            let rule = format!("`effect.clipping.rim` has {said}, and a rim is a rectangle or a circle");
            return Err(document.refuse(
                "effect.clipping.rim",
                rule,
                "give `sides_mm = [width, height]` or `diameter_mm`",
            ));
        }
    };
    let stop = file.stop.as_ref().map(|stop| Stop { distance_mm: stop.at_mm, radius_mm: 0.5 * stop.diameter_mm });
    if let Some(stop) = &stop {
        rules::stop_in_front(document, stop, camera, prism, board)?;
    }
    Ok(Clipping { outline, chamfer_mm: file.chamfer_mm, stop })
}

pub(super) fn quadrature(document: &Document, file: &QuadratureFile) -> Result<Quadrature, Error> {
    let &QuadratureFile { points, replicates, noise, seed, fill } = file;
    let quadrature = Quadrature { points, replicates, noise, seed: u64::from(seed), fill };
    rules::sets_tell_noise(document, &quadrature).map(|()| quadrature)
}

/// How effects that are averages are sampled.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct QuadratureFile {
    /// Points of one set, a picture each: of the pupil, and of the slopes of rough surfaces. A set is whole pairs of opposite
    /// points, or whole rings where the count of blades is odd, so that it may be a few more.
    #[schemars(range(min = 1, max = POINTS))]
    pub(super) points: usize,
    /// Sets at most, each shifted at random, whose spread tells the error of their mean. A single set is not shifted.
    #[schemars(range(min = 1, max = REPLICATES))]
    pub(super) replicates: usize,
    /// No further set is taken once the standard error of a pixel is below this, of full scale 1, in the worst block of 16
    /// x 16 pixels.
    #[schemars(range(min = 0, max = 1))]
    pub(super) noise: Option<f64>,
    /// Of the random shifts.
    #[schemars(range(max = SEED))]
    pub(super) seed: u32,
    /// Whether each point of the pupil stands for the part of it around it, so that fewer tell as much: of the design paper's
    /// scene at f/4 a third to a half. For a lens before one board, without roughness, clipping, ghosts, diffraction and `replicates`.
    pub(super) fill: bool,
}

impl Default for QuadratureFile {
    fn default() -> Self {
        let Quadrature { points, replicates, noise, seed, fill } = Quadrature::default();
        Self { points, replicates, noise, seed: seed as u32, fill }
    }
}
