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
    if is_whole(system) {
        let wanted = Wanted { truth: true };
        let Film { radiance, colour, noise, class, board_mm, counts, account } =
            render_wanted(system, wanted, progress);
        take(Strip { radiance, colour, noise, class, board_mm });
        return (counts, account);
    }
    let plan = Plan::new(system);
    by_bands(&plan, bands(system), progress, take)
}

/// Whether effects act across the picture, so that it is made as a whole.
fn is_whole(system: &System) -> bool {
    system.effects.act_by(Hook::Film) || system.effects.averages()
}

/// Bands of a strip.
fn bands(system: &System) -> usize {
    (STRIP_PIXELS / (system.camera.size_px()[0] * BAND_ROWS)).max(rayon::current_num_threads())
}

/// Rows of a strip of the picture that `system` takes, but of the last one; all where it is made as a whole. More for more
/// threads.
pub fn strip_rows(system: &System) -> usize {
    let height = system.camera.size_px()[1];
    if is_whole(system) { height } else { height.min(bands(system) * BAND_ROWS) }
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
    (work.counts, work.account(plan))
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
