//! Why a pair of half images has no figure: each cause by its own name, with what to do.

use super::truth;
use super::view::{BoardView, HalfView};
use crate::optics::fate::Fate;
use crate::scene::Scene;
use crate::system::System;
use crate::system::aim::Aimer;
use glam::DVec2;
use std::collections::BTreeMap;

/// Why no corner of the board could be paired between the left and the right half. The first that holds, in this order.
#[derive(Debug, Clone, PartialEq)]
pub enum NotJudged {
    /// All squares have one radiance.
    NoContrast,
    /// Most rays of a half end, in this way.
    RaysEnd(&'static str, Fate),
    /// A half sees none of the board's inner corners.
    BoardOutside(&'static str),
    /// Each half sees corners, and no corner is in both.
    NothingInCommon,
    /// The squares of a half are narrower than this, in px, and the detector needs [`LEAST_SQUARE_PX`].
    SquaresTooSmall(&'static str, f64),
    /// The detector found no lattice in a half.
    NoneFound(&'static str),
    /// The detector found a lattice of so many corners in a half, whose place on the board is not known.
    NotPlaced(&'static str, usize),
    /// Corners were found and placed in both halves, and none is the same.
    NonePaired,
}

/// Lines of the board must be this far apart for the detector, in px.
pub const LEAST_SQUARE_PX: f64 = 10.0;

/// Pixels along each side of the grid of a half that is asked for fates.
const GRID: usize = 16;

/// Why the corners of `view`, a picture of `scene`'s board through `system`, give no pair; `None` where they give one.
pub fn not_judged(scene: &Scene, system: &System, view: &BoardView) -> Option<NotJudged> {
    let [left, right] = &view.halves;
    let paired = left.found.iter().any(|l| right.found.iter().any(|r| r.index == l.index));
    if paired {
        return None;
    }
    if scene.board.black == scene.board.white {
        return Some(NotJudged::NoContrast);
    }

    // What the scene says that the halves see.
    let aimer = Aimer::new(system);
    let mut seen = Vec::new();
    for half in &view.halves {
        let name = half.frame.half.name();
        if let Some(fate) = usual_end(system, half) {
            return Some(NotJudged::RaysEnd(name, fate));
        }
        let corners = truth::corners(system, &aimer, &half.frame).unwrap_or_default();
        if corners.is_empty() {
            return Some(NotJudged::BoardOutside(name));
        }
        seen.push(corners);
    }
    if !seen[0].keys().any(|index| seen[1].contains_key(index)) {
        return Some(NotJudged::NothingInCommon);
    }

    // What the detector made of that.
    for (half, corners) in view.halves.iter().zip(&seen) {
        let name = half.frame.half.name();
        if half.detected.lattice == 0 {
            let places = corners.iter().map(|(&index, corner)| (index, corner.position_px)).collect();
            return Some(match narrowest_px(&places) {
                Some(px) if px < LEAST_SQUARE_PX => NotJudged::SquaresTooSmall(name, px),
                _ => NotJudged::NoneFound(name),
            });
        }
        if half.found.is_empty() {
            return Some(NotJudged::NotPlaced(name, half.detected.lattice));
        }
    }
    Some(NotJudged::NonePaired)
}

/// How most rays of a half end, where more than half of them do.
fn usual_end(system: &System, half: &HalfView) -> Option<Fate> {
    let mut ends: BTreeMap<&'static str, (usize, Fate)> = BTreeMap::new();
    for k in 0..GRID * GRID {
        let place = (DVec2::new((k % GRID) as f64, (k / GRID) as f64) + 0.5) / GRID as f64;
        if let Err(fate) = system.trace(half.frame.full(half.frame.size_px * place)) {
            ends.entry(fate.name()).or_insert((0, fate)).0 += 1;
        }
    }
    let all: usize = ends.values().map(|(n, _)| n).sum();
    let most = ends.values().max_by_key(|(n, _)| *n).map(|(_, fate)| *fate);
    most.filter(|_| 2 * all > GRID * GRID)
}

/// The median distance of neighbours in a row or a column, in px.
fn narrowest_px(places: &BTreeMap<[i32; 2], DVec2>) -> Option<f64> {
    let steps = |[column, row]: [i32; 2]| {
        [[column + 1, row], [column, row + 1]].map(|next| Some(places.get(&next)?.distance(places[&[column, row]])))
    };
    let all: Vec<f64> = places.keys().flat_map(|index| steps(*index)).flatten().collect();
    crate::num::stats::quantile(&all, 0.5)
}

impl std::fmt::Display for NotJudged {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NoContrast => write!(
                f,
                "the board's squares have one radiance, and no corner can be seen: give `board.black` and `board.white` \
                 different values"
            ),
            Self::RaysEnd(half, fate) => write!(
                f,
                "most rays of the {half} half never see the board ({}): `biprism check` tells where they end",
                fate.name()
            ),
            Self::BoardOutside(half) => write!(
                f,
                "the {half} half sees no inner corner of the board: move the board, or give it more or larger squares"
            ),
            Self::NothingInCommon => write!(
                f,
                "the left and the right half see different parts of the board: move it farther away, or make it larger"
            ),
            Self::SquaresTooSmall(half, px) => write!(
                f,
                "the squares are {px:.1} px wide in the {half} half, and the detector needs {LEAST_SQUARE_PX}: make them larger"
            ),
            Self::NoneFound(half) => write!(
                f,
                "the detector found no checkerboard in the {half} half, where the scene says that there is one: look at the \
                 picture, and whether the scene is the picture's own"
            ),
            Self::NotPlaced(half, n) => write!(
                f,
                "the detector found {n} corners in the {half} half, and the scene does not tell which corners of the board \
                 they are: its board must be where the picture's is, to 0.3 of a square"
            ),
            Self::NonePaired => write!(
                f,
                "corners were found in both halves, and none is the same corner of the board: `biprism corners` shows which"
            ),
        }
    }
}
