//! Estimates of a picture's time, memory and fates, before it is rendered.

use crate::accuracy::{Level, Sampling};
use crate::effect::{EffectId, Hook};
use crate::optics::fate::Fate;
use crate::render::{Plan, cells, frame_px, strip_rows};
use crate::system::System;
use crate::system::auto::Verdict;
use glam::DVec2;
use std::collections::BTreeMap;

/// The plan of a picture.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct PictureEstimate {
    /// The level of accuracy.
    pub level: Level,
    /// How pixels learn what they see.
    pub sampling: Sampling,
    /// Patches of the map.
    pub patches: usize,
    /// Share of the pixels for which the map stands.
    pub mapped: f64,
    /// Pictures that are summed up, at most.
    pub passes: usize,
    /// Cells along each side of a pixel that diffraction spreads one by one; 1 without.
    pub samples: usize,
    /// The effects that act, and what becomes of each.
    pub effects: Vec<Verdict>,
    /// Rays along each side of a pixel by which ghosts are sampled where their ways part; 0 without ghosts.
    pub ghost_samples: usize,
    /// Memory of the picture and its ground truth while it is rendered, in bytes, without the program itself and what
    /// writes a file.
    pub memory_bytes: u64,
    /// Share of the pixels that end in each fate, from a grid of them, by rays through the middle of the pupil and
    /// smooth surfaces.
    pub fates: BTreeMap<&'static str, f64>,
    /// Whether the picture has other rays than these, which may end otherwise.
    pub other_rays: bool,
}

/// Pixels along each side of the grid that is traced for fates.
const GRID: usize = 65;

/// What the picture of `system` will be, which was settled by these verdicts.
pub fn forecast(system: &System, effects: Vec<Verdict>) -> PictureEstimate {
    let account = Plan::new(system).account(0.0);
    let sets = system.effects().sets();
    let (passes, samples) = (sets * system.effects().variants(0).len(), cells(system));
    let samples_ghosts = system.effects().acting().any(|row| row.id == EffectId::Ghosts);
    PictureEstimate {
        level: account.level,
        sampling: system.accuracy().sampling,
        patches: account.patches,
        mapped: account.mapped,
        passes,
        samples,
        effects,
        ghost_samples: system.effects().ghosts.filter(|_| samples_ghosts).map_or(0, |ghosts| ghosts.samples),
        memory_bytes: memory_bytes(system, sets),
        fates: fates(system),
        other_rays: system.effects().dimensions() > 0,
    }
}

/// Strips of a picture that are held at a time: one is rendered, one waits, and one is written.
const STRIPS: usize = 3;

/// What is held of every pixel of the strips at hand, or of the picture where it is rendered as a whole: radiance (4
/// bytes), class (1) and board position (8). A mean of pictures is summed up in f64 beside the picture of one pass, and
/// so are the squares of its sets; three more of each where there are colours.
fn memory_bytes(system: &System, sets: usize) -> u64 {
    let effects = system.effects();
    let [width, height] = system.camera().size_px();
    let colours = if effects.variants(0).in_colour() { 3 } else { 0 };
    let mut each = 4 + 4 * colours;
    if effects.averages() {
        each += 4 + 8 + 8 * colours + if sets > 1 { 16 + 8 * colours } else { 0 };
    }
    let developed = if effects.act_by(Hook::Film) { 4 + 4 * colours } else { 0 };
    if effects.diffracting().is_none() {
        let rows = height.min(STRIPS * strip_rows(system));
        return (width * rows * (each + developed + 9)) as u64;
    }
    // Transforms take two pictures in f64, with the frame.
    let frame = frame_px(system);
    let framed = |n: usize| n + 2 * frame;
    (framed(width) * framed(height) * (each + developed + 9 + 16 + 8 * (1 + colours))) as u64
}

fn fates(system: &System) -> BTreeMap<&'static str, f64> {
    let size = DVec2::from_array(system.camera().size_px().map(|n| n as f64));
    let mut counts: BTreeMap<&'static str, f64> = BTreeMap::new();
    for k in 0..GRID * GRID {
        let place = (DVec2::new((k % GRID) as f64, (k / GRID) as f64) + 0.5) / GRID as f64;
        if let Err(fate) = system.trace(size * place) {
            *counts.entry(Fate::name(fate)).or_default() += 1.0 / (GRID * GRID) as f64;
        }
    }
    counts
}
