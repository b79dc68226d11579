//! The resolution that a board is measured in.
//!
//! A blur of many px spreads each edge over many pixels, of which each tells little, and a crossing over their square. The mean of
//! two by two pixels is a square pixel again, so that the model holds as it is in a picture of half the resolution; where its pixels
//! are still no wider than half the blur, a corner is known there to within half a percent as well, from a quarter of the pixels.

use super::blur::{self, FirstFits};
use super::candidate::Candidate;
use super::candidates::Candidates;
use super::corner_site::CornerSite;
use super::detection::{Corner, Detection, ElongatedBlur, Rejected};
use super::halving::{halved, halved_mask};
use super::lattice_growth::Lattice;
use super::lattice_lines::Grid;
use super::settings::{Blur, Settings};
use crate::raster::Raster;
use glam::DVec2;

/// Resolutions below that of the picture, at most: of pixels of 2, 4, 8 .. px.
const MOST_HALVINGS: usize = 6;
/// The blur is no narrower than this, in pixels of the resolution.
const LEAST_BLUR_PX: f64 = 2.0;
/// The squares are no smaller than this in any resolution, in its pixels.
const LEAST_STEP_PX: f64 = 20.0;

/// A picture of half the resolution, or of half of that, and so on, with the same candidates.
pub(super) struct Coarser {
    image: Raster<f32>,
    valid: Option<Raster<bool>>,
    list: Vec<Candidate>,
    /// Pixels of the picture along a side of one of these.
    scale: f64,
}

impl Coarser {
    /// Of a picture that is `scale` times as fine as another, from that one.
    fn new(image: Raster<f32>, valid: Option<Raster<bool>>, candidates: &Candidates<'_>, scale: f64) -> Self {
        let moved =
            |c: &Candidate| Candidate { position: c.position / scale, scale: (c.scale / scale).max(1.0), ring: c.ring };
        Self { image, valid, list: candidates.list.iter().map(moved).collect(), scale }
    }

    /// Its candidates.
    pub(super) fn candidates(&self) -> Candidates<'_> {
        Candidates {
            image: &self.image,
            valid: self.valid.clone(),
            prepared: None,
            list: self.list.clone(),
            levels: Vec::new(),
            rejected: Vec::new(),
        }
    }

    /// The settings there.
    pub(super) fn settings(&self, settings: &Settings) -> Settings {
        let blur = match settings.blur {
            Blur::Known(sigma_px) => Blur::Known(sigma_px / self.scale),
            other => other,
        };
        Settings { blur, ..*settings }
    }

    /// What was found there, in px of the picture.
    pub(super) fn in_picture(&self, found: Detection) -> Detection {
        let scale = self.scale;
        let corner = |c: Corner| Corner {
            position_px: c.position_px * scale,
            covariance_px2: c.covariance_px2 * (scale * scale),
            ..c
        };
        let elongated = |blur: ElongatedBlur| ElongatedBlur {
            along_px: blur.along_px * scale,
            across_px: blur.across_px * scale,
            ..blur
        };
        Detection {
            corners: found.corners.into_iter().map(corner).collect(),
            rejected: found
                .rejected
                .into_iter()
                .map(|r| Rejected { position_px: r.position_px * scale, ..r })
                .collect(),
            sigma_px: found.sigma_px.map(|sigma| sigma.map(|s| s * scale)),
            elongated_blur: found.elongated_blur.map(elongated),
            lean_px: found.lean_px * scale,
            marked_squares: found.marked_squares,
        }
    }
}

/// The resolution that a board is measured in.
pub(super) enum Resolution {
    /// The picture's own, with the fits that told it, where any were made.
    Own(Option<FirstFits>),
    /// A coarser one.
    Coarser(Coarser),
}

/// The coarsest resolution in which the blur of a lattice, numbered upright, is wide enough.
pub(super) fn resolution(candidates: &Candidates<'_>, lattice: &Lattice, settings: &Settings) -> Resolution {
    // See how far squares and blur allow it at all.
    let positions: Vec<DVec2> = candidates.list.iter().map(|c| c.position).collect();
    let grid = Grid::new(lattice.clone(), positions);
    let pilots = grid.pilots();
    let sites = blur::some_of(&pilots);
    let mut first = None;
    let step_px = sites.iter().map(CornerSite::step_px).fold(f64::INFINITY, f64::min);
    let most_scale = match settings.blur {
        Blur::PerCorner => return Resolution::Own(None),
        Blur::Known(sigma_px) => (sigma_px / LEAST_BLUR_PX).min(step_px / LEAST_STEP_PX),
        Blur::Common => {
            let fits = first.insert(blur::first_fits(candidates, &pilots, settings));
            if blur::is_narrow(fits) { 0.0 } else { step_px / LEAST_STEP_PX }
        }
    };
    let mut pictures: Vec<Coarser> = Vec::new();
    let mut scale = 2.0;
    while scale <= most_scale && pictures.len() < MOST_HALVINGS {
        let (image, valid) = match pictures.last() {
            None => (halved(candidates.image), candidates.valid.as_ref().map(halved_mask)),
            Some(finer) => (halved(&finer.image), finer.valid.as_ref().map(halved_mask)),
        };
        pictures.push(Coarser::new(image, valid, candidates, scale));
        scale *= 2.0;
    }

    // From the coarsest on, take the first in which the blur is wide.
    let coarser = pictures.into_iter().rev().find(|picture| {
        let candidates = picture.candidates();
        let grid = Grid::new(lattice.clone(), candidates.list.iter().map(|c| c.position).collect());
        let known = |sigma_px: f64| Some([sigma_px; 2]);
        let sigma_px = match picture.settings(settings).blur {
            Blur::Known(sigma_px) => known(sigma_px),
            _ => {
                let few = blur::some_of(&grid.pilots());
                blur::estimate(&candidates, &few, settings, blur::first_fits(&candidates, &few, settings))
            }
        };
        sigma_px.is_some_and(|[s0, s1]| s0.min(s1) >= LEAST_BLUR_PX)
    });
    coarser.map_or(Resolution::Own(first), Resolution::Coarser)
}
