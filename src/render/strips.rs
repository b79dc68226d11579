//! Strip-wise rendering: each strip of a picture can be handed on before the next is begun, so that a picture takes the
//! memory of a few strips, whatever its height.

use super::bands::rows;
use super::driver::{render, render_classed};
use super::film::{AccuracyReport, Counts, Film, Outputs, Strip};
use super::plan::{BAND_ROWS, Plan};
use crate::effect::Hook;
use crate::progress::Observer;
use crate::system::System;

/// Each strip but the last has a multiple of this many rows.
pub const STRIP_ROWS: usize = BAND_ROWS;

/// Pixels of a strip, about: more where the bands of so many would leave threads idle.
const STRIP_PIXELS: usize = 1 << 20;

/// Hands the picture that `system` takes to `take`, from the top down, with its ground truth; where that is not wanted, with the
/// classes of the pixels at least. The strips are those of [`super::render`], bit for bit. Where effects act across the picture it
/// is one strip. `observer` as there.
pub fn render_strips(
    system: &System,
    wanted: Outputs,
    observer: &dyn Observer,
    take: &mut dyn FnMut(Strip),
) -> (Counts, AccuracyReport) {
    if is_whole(system) {
        let film = if wanted.truth { render(system, observer) } else { render_classed(system, observer) };
        let Film { radiance, colour, noise, class, board_mm, object, counts, account } = film;
        take(Strip { radiance, colour, noise, class, board_mm, object });
        return (counts, account);
    }
    let plan = Plan::new(system);
    by_bands(&plan, bands(system), observer, take)
}

/// Whether effects act across the picture, so that it is rendered as a whole.
fn is_whole(system: &System) -> bool {
    system.effects().act_by(Hook::Film) || system.effects().averages()
}

/// Bands of a strip.
fn bands(system: &System) -> usize {
    (STRIP_PIXELS / (system.camera().size_px()[0] * BAND_ROWS)).max(rayon::current_num_threads())
}

/// Rows of a strip of the picture that `system` takes, but of the last one; all where it is rendered as a whole. More
/// for more threads.
pub fn strip_rows(system: &System) -> usize {
    let height = system.camera().size_px()[1];
    if is_whole(system) { height } else { height.min(bands(system) * BAND_ROWS) }
}

/// The same of a plan, in strips of so many bands.
pub(super) fn by_bands(
    plan: &Plan,
    bands: usize,
    observer: &dyn Observer,
    take: &mut dyn FnMut(Strip),
) -> (Counts, AccuracyReport) {
    let [_, height] = plan.system.camera().size_px();
    let mut work = plan.work();
    for first in (0..height).step_by(bands * BAND_ROWS) {
        let last = height.min(first + bands * BAND_ROWS);
        let (strip, done) = rows(plan, first..last, Outputs { truth: true }, observer);
        work += done;
        take(strip);
    }
    (work.counts, plan.account_of(&work))
}
