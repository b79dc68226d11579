//! A picture strip by strip: each can be handed on before the next is begun, so that a picture takes the memory of a few
//! strips, whatever its height.

use super::plan::{BAND_ROWS, Plan};
use super::{Account, Class, Counts, Film, Wanted, Work, render_wanted, rows};
use crate::effect::Hook;
use crate::raster::Raster;
use crate::system::System;

/// Rows of a picture; fields as those of [`Film`].
#[derive(Debug, Clone, PartialEq)]
pub struct Strip {
    /// Mean radiance over each pixel.
    pub radiance: Raster<f32>,
    /// The same of red, green and blue.
    pub colour: Option<Raster<[f32; 3]>>,
    /// Standard error of the radiance.
    pub noise: Option<Raster<f32>>,
    /// What happened to each pixel's centre ray.
    pub class: Raster<Class>,
    /// The board position that it sees, in mm.
    pub board_mm: Raster<[f32; 2]>,
}

/// Each strip but the last has a multiple of this many rows.
pub const STRIP_ROWS: usize = BAND_ROWS;

/// Pixels of a strip, about: more where the bands of so many would leave threads idle.
const STRIP_PIXELS: usize = 1 << 20;

/// Hands the picture that `system` takes to `take`, with its ground truth, from the top down; the strips are those of
/// [`super::render`], bit for bit. Where effects act across the picture it is one strip. `progress` as there.
pub fn render_strips(
    system: &System,
    progress: &(dyn Fn(usize) + Sync),
    take: &mut dyn FnMut(Strip),
) -> (Counts, Account) {
    if system.effects.act_by(Hook::Film) || system.effects.averages() {
        let wanted = Wanted { truth: true };
        let Film { radiance, colour, noise, class, board_mm, counts, account } =
            render_wanted(system, wanted, progress);
        take(Strip { radiance, colour, noise, class, board_mm });
        return (counts, account);
    }
    let plan = Plan::new(system);
    let bands = (STRIP_PIXELS / (system.camera.size_px()[0] * BAND_ROWS)).max(rayon::current_num_threads());
    by_bands(&plan, bands, progress, take)
}

/// The same of a plan, in strips of so many bands.
pub(super) fn by_bands(
    plan: &Plan,
    bands: usize,
    progress: &(dyn Fn(usize) + Sync),
    take: &mut dyn FnMut(Strip),
) -> (Counts, Account) {
    let [_, height] = plan.system.camera.size_px();
    let mut work = Work::of(plan);
    for first in (0..height).step_by(bands * BAND_ROWS) {
        let last = height.min(first + bands * BAND_ROWS);
        let (strip, done) = rows(plan, first..last, Wanted { truth: true }, progress);
        work += done;
        take(strip);
    }
    (work.counts, plan.account(work.bend_px))
}

impl From<&Film> for Strip {
    /// The whole picture as one strip.
    fn from(film: &Film) -> Self {
        Self {
            radiance: film.radiance.clone(),
            colour: film.colour.clone(),
            noise: film.noise.clone(),
            class: film.class.clone(),
            board_mm: film.board_mm.clone(),
        }
    }
}
