//! Ray aiming, the inverse of the trace: the pixel position that sees a point of the board.

use super::in_light::InLight;
use super::instrument::System;
use crate::optics::fate::Fate;
use crate::prism::side::Side;
use glam::DVec2;
use std::borrow::Cow;
use std::sync::OnceLock;

/// Rays along each edge of the coarse grid from which a search starts.
const STARTS: usize = 17;
/// Newton's method gives up after this many steps.
const MAX_STEPS: usize = 40;
/// Steps in a row that the rim of what a side lets through cuts short before a search ends: each comes at least half as near to the rim,
/// and the map, once the point is so near, tells on which side of the rim the point is.
const MOST_CUT_SHORT: usize = 6;
/// The largest Newton step that may be left when rounding ends the search, in px: the rounding of coordinates of a
/// kilometre (1e-10 mm) over 0.1 mm on the board per pixel, a few hundred times over.
const ROUNDING_PX: f64 = 1e-6;

/// A Newton step of more than a pixel is not halved below this share of it: where the map is smooth so small a one comes nearer, and
/// beyond the rim of what the side lets through none does.
const LEAST_SHARE: f64 = 1e-4;

/// Finds pixel positions by board positions, starting from a place near by where one is known, else from a coarse grid of positions,
/// which is traced when the first search needs it.
///
/// In light of one wavelength that is the position itself; in light of several it is their mean, weighted by what the
/// sensor receives of each, as in the grey picture.
#[derive(Debug, Clone)]
pub struct Aimer<'a> {
    /// The wavelengths, the one with the largest share first.
    lights: Vec<OneLight<'a>>,
}

/// The search in light of one wavelength.
#[derive(Debug, Clone)]
struct OneLight<'a> {
    share: f64,
    system: Cow<'a, System>,
    /// For the left and the right side, once they are needed: image positions with what they see.
    starts: [OnceLock<Vec<(DVec2, DVec2)>>; 2],
}

impl<'a> Aimer<'a> {
    /// Of an instrument, in every light that it is in.
    pub fn new(system: &'a System) -> Self {
        let light = InLight::new(system);
        let lights = light.lights().iter().map(|(share, system)| OneLight::new(*share, system.clone())).collect();
        Self { lights }
    }

    /// The instrument in light of the wavelength with the largest share.
    pub fn main_light(&self) -> &System {
        &self.lights[0].system
    }

    /// The image position of the coarse grid that sees through `side` what lies nearest to `board_mm`, in light of the wavelength with
    /// the largest share; `None` in light of several wavelengths, and where no ray of the grid reaches the board.
    pub fn nearest_start(&self, board_mm: DVec2, side: Side) -> Option<DVec2> {
        match &self.lights[..] {
            [only] => only.nearest(board_mm, side),
            _ => None,
        }
    }

    /// Whether `px` lies on the sensor and really looks through `side`, in light of the wavelength with the largest share.
    pub fn sees(&self, px: DVec2, side: Side) -> bool {
        let system = self.main_light();
        let [width, height] = system.camera().size_px().map(|n| n as f64);
        let inside = px.cmpge(DVec2::ZERO).all() && px.cmple(DVec2::new(width, height)).all();
        inside && system.trace(px).is_ok_and(|sight| sight.side == side)
    }

    /// The image position that sees `board_mm` through `side`, inside the sensor or not, continuing the side beyond
    /// the ridge where needed: check with [`Aimer::sees`] whether it is really seen.
    ///
    /// # Errors
    /// [`Fate::NotConverged`] when no position is found; the fate of the starting rays when none reaches the board.
    pub fn aim(&self, board_mm: DVec2, side: Side) -> Result<DVec2, Fate> {
        self.aim_from(board_mm, side, None)
    }

    /// [`Aimer::aim`], from a position `near` the one that is sought and from no other: of a point that may not be seen at all this tells
    /// sooner.
    ///
    /// # Errors
    /// [`Fate::NotConverged`] when no position is found from there; the fate of the first ray.
    pub fn aim_only_from(&self, board_mm: DVec2, side: Side, near: DVec2) -> Result<DVec2, Fate> {
        self.mean(|light| light.system.aim_from(near, board_mm, side))
    }

    /// [`Aimer::aim`], from a position `near` the one that is sought, where one is known.
    ///
    /// # Errors
    /// As [`Aimer::aim`].
    pub fn aim_from(&self, board_mm: DVec2, side: Side, near: Option<DVec2>) -> Result<DVec2, Fate> {
        self.mean(|light| light.aim(board_mm, side, near))
    }

    /// The mean of what is found in each light, weighted by their shares.
    fn mean(&self, of: impl Fn(&OneLight<'_>) -> Result<DVec2, Fate>) -> Result<DVec2, Fate> {
        match &self.lights[..] {
            [only] => of(only),
            lights => lights.iter().map(|light| Ok(of(light)? * light.share)).sum(),
        }
    }
}

impl<'a> OneLight<'a> {
    fn new(share: f64, system: Cow<'a, System>) -> Self {
        Self { share, system, starts: [OnceLock::new(), OnceLock::new()] }
    }

    /// The coarse grid of a side.
    fn starts(&self, side: Side) -> &[(DVec2, DVec2)] {
        self.starts[side as usize].get_or_init(|| {
            let [width, height] = self.system.camera().size_px().map(|n| n as f64);
            let first = if side == Side::Left { 0.0 } else { 0.5 * width };
            let along = |k: usize| k as f64 / (STARTS - 1) as f64;
            let places = (0..STARTS).flat_map(|j| (0..STARTS).map(move |i| (i, j)));
            let places = places.map(|(i, j)| DVec2::new(first + 0.5 * width * along(i), height * along(j)));
            let seen = |px| self.system.footprint_through(px, side).ok().map(|f| (px, f.sight.board_mm));
            places.filter_map(seen).collect()
        })
    }

    /// The position that sees `board_mm`: from `near`, and where nothing is found from there, from the grid.
    fn aim(&self, board_mm: DVec2, side: Side, near: Option<DVec2>) -> Result<DVec2, Fate> {
        if let Some(Ok(found)) = near.map(|near| self.system.aim_from(near, board_mm, side)) {
            return Ok(found);
        }
        self.system.aim_from(self.nearest(board_mm, side).ok_or(Fate::Missed)?, board_mm, side)
    }

    /// The position of the grid that sees what lies nearest to `board_mm`.
    fn nearest(&self, board_mm: DVec2, side: Side) -> Option<DVec2> {
        let starts = self.starts(side).iter();
        let far = |seen: &DVec2| seen.distance_squared(board_mm);
        starts.min_by(|a, b| far(&a.1).total_cmp(&far(&b.1))).map(|(px, _)| *px)
    }
}

impl System {
    /// The image position that sees `board_mm` through `side`, continued beyond the ridge, in light of the scene's own index, searched from
    /// the position `px` on: Newton's method on the traced map, each step halved until it improves.
    ///
    /// # Errors
    /// [`Fate::NotConverged`] when no position is found; the fate of the first ray.
    pub fn aim_from(&self, mut px: DVec2, board_mm: DVec2, side: Side) -> Result<DVec2, Fate> {
        let mut here = self.footprint_through(px, side)?;
        let mut cut_short = 0;

        // Take Newton steps.
        for _ in 0..MAX_STEPS {
            let gap = board_mm - here.sight.board_mm;
            let wanted = here.jacobian.inverse() * gap;
            if !wanted.is_finite() {
                return Err(Fate::NotConverged);
            }
            if wanted.length() <= self.accuracy().aim_px {
                return Ok(px + wanted);
            }

            // Halve the step until it comes nearer to the point.
            let mut step = wanted;
            let mut at_rim = false;
            let far = if wanted.length() > 1.0 { LEAST_SHARE } else { 0.0 };
            let least = (far * wanted.length()).max(1e-3 * self.accuracy().aim_px);
            loop {
                match self.footprint_through(px + step, side) {
                    Ok(next) if (board_mm - next.sight.board_mm).length() < gap.length() => {
                        (px, here) = (px + step, next);
                        break;
                    }
                    // The floor of rounding.
                    Ok(_) if wanted.length() <= ROUNDING_PX => return Ok(px),
                    // No step improves. Close by, that is the floor of rounding; far off, it is no answer: a place
                    // where the map folds over, or the rim of what the side lets through.
                    _ if step.length() < least => {
                        return if wanted.length() <= ROUNDING_PX { Ok(px) } else { Err(Fate::NotConverged) };
                    }
                    found => at_rim |= found.is_err(),
                }
                step *= 0.5;
            }

            // What is sought beyond the rim is not there.
            cut_short = if at_rim { cut_short + 1 } else { 0 };
            if cut_short == MOST_CUT_SHORT {
                break;
            }
        }
        Err(Fate::NotConverged)
    }
}
