//! Which cause it is for which a pair of half images has no figure.

use super::not_judged_cause::{LEAST_CORNERS, LEAST_SQUARE_PX, NotJudged};
use super::truth::{self, TrueCorners};
use super::view::{BoardPlace, BoardView, HalfView};
use crate::optics::fate::Fate;
use crate::scene::Scene;
use crate::system::System;
use crate::system::aim::Aimer;
use crate::vision::Reason;
use glam::DVec2;
use std::collections::BTreeMap;

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
    let name = |half: &HalfView| half.frame.half.name();
    let ended = view.halves.iter().find_map(|half| Some(NotJudged::RaysEnd(name(half), usual_end(system, half)?)));
    if let Some(cause) = ended.or_else(|| view.unmatched.clone()) {
        return Some(cause);
    }
    if view.place != BoardPlace::Unknown
        && let Some(cause) = by_place(system, view)
    {
        return Some(cause);
    }
    let empty: Vec<&HalfView> = view.halves.iter().filter(|half| half.detected.lattice == 0).collect();
    if let Some((half, n)) = empty.iter().find_map(|half| Some((half, single(half)?))) {
        return Some(NotJudged::TooFewCorners(name(half), n));
    }
    match &empty[..] {
        [] => {}
        [half] => return Some(NotJudged::NoneFound(name(half))),
        _ => return Some(NotJudged::NoneInEither),
    }
    let unplaced = view.halves.iter().find(|half| half.found.is_empty());
    Some(match unplaced {
        Some(half) => NotJudged::NotPlaced(name(half), half.detected.lattice),
        None if view.place == BoardPlace::Given => NotJudged::NonePaired,
        None => NotJudged::NothingInCommon,
    })
}

/// What can be said because it is known where the board is.
fn by_place(system: &System, view: &BoardView) -> Option<NotJudged> {
    let aimer = Aimer::new(system);
    let seen = view.halves.each_ref().map(|half| truth::corners(system, &aimer, &half.frame).unwrap_or_default());
    let halves = || view.halves.iter().zip(&seen).map(|(half, corners)| (half.frame.half.name(), half, corners));
    if let Some((name, ..)) = halves().find(|(.., corners)| corners.is_empty()) {
        return Some(NotJudged::BoardOutside(name));
    }
    if !seen[0].keys().any(|index| seen[1].contains_key(index)) {
        return Some(NotJudged::NothingInCommon);
    }
    halves().filter(|(_, half, _)| half.detected.lattice == 0).find_map(|(name, _, corners)| {
        if !is_grid(corners) {
            return Some(NotJudged::TooFewCorners(name, corners.len()));
        }
        let places = corners.iter().map(|(&index, corner)| (index, corner.position_px)).collect();
        let px = narrowest_px(&places).filter(|px| *px < LEAST_SQUARE_PX)?;
        Some(NotJudged::SquaresTooSmall(name, px))
    })
}

/// Whether corners reach over a grid that the detector takes.
fn is_grid(corners: &TrueCorners) -> bool {
    let span = |axis: usize| {
        let all = || corners.keys().map(|index| index[axis]);
        all().max().zip(all().min()).map_or(0, |(last, first)| last - first)
    };
    corners.len() >= LEAST_CORNERS && span(0) >= 2 && span(1) >= 2
}

/// How many corners the detector saw in a half that belong to no grid, where there are some.
fn single(half: &HalfView) -> Option<usize> {
    half.detected.rejected.get(Reason::NoGrid.name()).copied().filter(|n| *n > 0)
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
