//! Everything that is fixed for a picture, decided before its first pixel.

use super::coverage::Pattern;
use super::looks::Looker;
use super::map::{Cover, Patch, certify};
use super::{Account, Work, third};
use crate::accuracy::{Accuracy, Sampling};
use crate::effect::Hook;
use crate::optics::fate::Fate;
use crate::optics::surface::Surface;
use crate::system::{Side, System};
use glam::DVec2;
use std::ops::Range;

/// Rows of a band, the part of a picture that one thread makes at a time: few enough to balance the load, many enough
/// for the extra row above and below to be cheap.
pub(super) const BAND_ROWS: usize = 48;

/// A rectangle of pixels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Region {
    pub(super) columns: Range<usize>,
    pub(super) rows: Range<usize>,
}

/// The plan of a picture.
#[derive(Debug)]
pub struct Plan<'a> {
    /// The instrument.
    pub(super) system: &'a System,
    /// The board's radiance.
    pub(super) pattern: Pattern,
    /// How centres are traced.
    pub(super) looker: Looker<'a>,
    /// Rectangles that a polynomial map stands for.
    pub(super) patches: Vec<Patch>,
    /// Rectangles whose every pixel is traced.
    pub(super) traced: Vec<Region>,
    /// What the jets of traced pixels are wrong by, in px: see [`third`].
    pub(super) third_px: f64,
    /// Rays that planning took.
    pub(super) rays: u64,
    /// Whether the left half is copied from the right half, whose mirror image it is.
    pub(super) mirrored: bool,
    /// Whether transport effects change what pixels receive.
    pub(super) gained: bool,
    /// The side of the square in the middle of a pixel that receives light, in px.
    pub(super) active: f64,
    /// Whether the ridge is seen as a straight line, being that of two planes or the picture's own middle.
    pub(super) straight_ridge: bool,
}

impl<'a> Plan<'a> {
    /// Plans the picture of one pass of `system`, that of the instrument through the middle of its pupil: chooses the loops
    /// and, where its accuracy asks for one, fits and checks the map.
    pub fn new(system: &'a System) -> Self {
        let sampling = system.accuracy.sampling;
        let gained = system.effects.act_by(Hook::Transport);
        // Transport effects need not be symmetric.
        let mirrored = sampling != Sampling::SingleRays && !gained && system.is_mirror_symmetric();
        Self { gained, ..Self::by(system, sampling, mirrored) }
    }

    /// A plan by a given way of sampling, of both halves or of the right one, which is then copied: the picture is the
    /// same.
    pub(super) fn by(system: &'a System, sampling: Sampling, mirrored: bool) -> Self {
        let [width, height] = system.camera.size_px();
        let first = if mirrored { width / 2 } else { 0 };
        let all = Region { columns: first..width, rows: 0..height };
        let mut cover = match sampling {
            Sampling::SingleRays | Sampling::Packets => Cover { traced: vec![all], ..Cover::default() },
            Sampling::Map => certify(system, first),
        };
        let by_jets = sampling != Sampling::SingleRays && !cover.traced.is_empty();
        let third_px = if by_jets { third::of_differences_px(system, &mut cover.rays) } else { 0.0 };
        Self {
            system,
            third_px,
            pattern: Pattern::new(&system.board.pattern),
            looker: Looker::new(system, sampling != Sampling::SingleRays),
            patches: cover.patches,
            traced: cover.traced,
            rays: cover.rays,
            mirrored,
            gained: false,
            active: system.effects.active_side(),
            straight_ridge: system.prism.as_ref().is_none_or(|prism| {
                [Side::Left, Side::Right].iter().all(|side| matches!(prism.surface(*side, 0), Surface::Plane { .. }))
            }),
        }
    }

    /// What transport effects leave to `px` of what it sees; 1 without such effects.
    #[inline(always)]
    pub(super) fn gain(&self, px: DVec2) -> f64 {
        if self.gained { self.system.gain(px) } else { 1.0 }
    }

    /// Multiplies pixels of a row, the first with its centre at `start`, by their gains.
    pub(super) fn gain_row(&self, start: DVec2, row: &mut [f32], work: &mut Work) {
        work.counts.rays += row.len() as u64;
        for (i, value) in row.iter_mut().enumerate() {
            *value = (f64::from(*value) * self.system.gain(start + DVec2::new(i as f64, 0.0))) as f32;
        }
    }

    /// What the picture's own way of sampling says that `px` sees, in mm on the board: the map where it stands, the traced
    /// ray elsewhere.
    ///
    /// # Errors
    /// The fate of a ray that never reaches the board.
    pub fn look(&self, px: DVec2) -> Result<DVec2, Fate> {
        let width = self.system.camera.size_px()[0] as f64;
        let inside = |region: &Region, px: DVec2| {
            let (columns, rows) = (&region.columns, &region.rows);
            let within = |v: f64, range: &Range<usize>| v >= range.start as f64 && v <= range.end as f64;
            within(px.x, columns) && within(px.y, rows)
        };
        let mapped =
            |px: DVec2| self.patches.iter().find(|patch| inside(&patch.region, px)).map(|patch| patch.look(px).0);
        let mm = 1.0 / self.pattern.squares_per_mm();
        if let Some(seen) = mapped(px) {
            return Ok(seen * mm);
        }
        if self.mirrored
            && let Some(seen) = mapped(DVec2::new(width - px.x, px.y))
        {
            return Ok(DVec2::new(-seen.x, seen.y) * mm);
        }
        self.system.look(px).map(|sight| sight.board_mm)
    }

    /// The accuracy asked of pixels by their jets, whose third order is left out: that much less. Where nothing is left, such
    /// pixels are traced in parts.
    pub(super) fn less(&self, third_px: f64) -> Accuracy {
        Accuracy { bend_px: self.system.accuracy.bend_px - third_px, ..self.system.accuracy }
    }

    /// What the picture promises and keeps, given the bend left inside its pixels.
    pub fn account(&self, bend_px: f64) -> Account {
        let [width, height] = self.system.camera.size_px();
        let sides = if self.mirrored { 2 } else { 1 };
        let mapped: usize = self.patches.iter().map(|p| p.region.columns.len() * p.region.rows.len()).sum();
        let accuracy = &self.system.accuracy;
        let thirds = self.patches.iter().map(|p| p.third_px).chain([self.third_px]);
        let third_px = thirds.filter(|third| *third < accuracy.bend_px).fold(0.0, f64::max);
        Account {
            level: accuracy.level,
            target_px: accuracy.target_px,
            promise_px: accuracy.promise_px,
            map_px: self.patches.iter().fold(0.0, |worst, p| worst.max(p.error_px)),
            bend_px: bend_px + third_px,
            patches: sides * self.patches.len(),
            mapped: (sides * mapped) as f64 / (width * height) as f64,
            passes: 1,
            noise: None,
            unpromised_pixels: 0,
        }
    }
}
