//! Corner candidates: peaks of the saddle response that pass the ring test, in the picture and in coarser ones.
//!
//! A blur that is wider than the ring fills it, and motion along the diagonal of squares draws a crossing out into two saddles
//! half the way to either side. In a picture of pixels twice as large both are half as wide, so that crossings are sought in
//! coarser pictures too.

use super::buckets::Buckets;
use super::candidate::{Candidate, NEIGHBOURS};
use super::detection::{Detection, Reason, Rejected};
use super::halving::halved;
use super::response::{Peak, peaks};
use super::ring_test::{RADIUS_PX, Ring, RingTest};
use crate::raster::Raster;
use glam::{DVec2, IVec2};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::ops::Range;

/// The strength goes with the square of the contrast. A peak of this share of the median of the strongest 20 crossings (a
/// quarter of their contrast) is tested, whatever the noise.
const STRONG: f32 = 0.06;
/// How many of the strongest crossings set that scale.
const STRONGEST: usize = 20;
/// A weaker one, as on a board in the shade of what stands beside it, is tested down to this share (0.3 % of the contrast),
const WEAKEST: f32 = 1e-5;
/// and where it is so many times as strong as what is left around it when the crossings of a board are taken away: of the peaks of
/// white noise one in two hundred is.
const ABOVE_REST: f32 = 4.0;
/// What is around a peak: a tile of this side, in px. A board of squares of 10 px has less than a crossing for each so many px^2,
/// noise has two peaks.
const TILE_PX: usize = 64;
const CROSSING_PX2: usize = 100;
/// A corner this share of a step away from two borders of the picture still has 0.6 of its window in it.
const IN_SIGHT: f64 = 0.25;
/// Peaks that are tested, at most: a picture of noise has one in every 50 px.
const MOST_PEAKS: usize = 50_000;

/// Resolutions that crossings are sought in: of pixels 1, 2, 4, 8, 16 and 32 px wide, as long as so many remain along a side.
const LEVELS: i32 = 6;
const LEAST_SIDE_PX: usize = 48;

/// A crossing is given the position of a finer one within so many px: a third of a pixel of the second coarsest, which its own is known
/// to.
const MOST_SHIFT_PX: f64 = 3.0;

/// Peaks among which those of split crossings are sought.
const MOST_PAIRED: usize = 4000;
/// The strongest peaks, of which so many tell what a crossing's strength is.
const FIRST_TESTED: usize = 400;
/// Two peaks of one crossing are not further apart than this, in px, and the weaker has this share of the other's strength.
const NECK_PX: f64 = 8.0;
const ALIKE: f32 = 0.6;

/// A picture and the crossings found in it.
#[derive(Debug)]
pub struct Candidates<'a> {
    /// The picture itself, in its own unit.
    pub(super) image: &'a Raster<f32>,
    /// Which pixels count, or `None` where all do.
    pub(super) valid: Option<Raster<bool>>,
    /// The picture scaled to 0..1 and without holes; `None` for a picture of one value.
    pub(super) prepared: Option<Raster<f32>>,
    /// Crossings of two edges, of one resolution after the other, the finest first, each from the strongest on.
    pub(super) list: Vec<Candidate>,
    /// Which of them belong to which resolution.
    pub(super) levels: Vec<Range<usize>>,
    /// Peaks of the finest resolution that are none.
    pub(super) rejected: Vec<Rejected>,
}

impl Candidates<'_> {
    /// How many crossings were found in the picture itself.
    pub fn crossings(&self) -> usize {
        self.levels.first().map_or(0, Range::len)
    }

    /// Whether a corner at a position, a step of so many px away from others, would be in sight: with its ring, and with more than
    /// half of its window however that is cut.
    pub(super) fn shows(&self, position: DVec2, step_px: f64) -> bool {
        let reach = RADIUS_PX.max(IN_SIGHT * step_px);
        let size = DVec2::new(self.image.width() as f64, self.image.height() as f64);
        (position - reach).min_element() >= 0.0
            && (size - position - reach).min_element() > 0.0
            && self.valid.as_ref().is_none_or(|valid| {
                let places = [DVec2::ZERO, DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y];
                places.into_iter().map(|d| position + d * reach).all(|p| valid.get(p.x as usize, p.y as usize))
            })
    }
}

impl Candidates<'_> {
    /// Whether a column or row of a board lacks a corner that would be in sight, beside one that it has.
    pub(super) fn misses_some(&self, found: &Detection) -> bool {
        let at: BTreeMap<[i32; 2], DVec2> = found.corners.iter().map(|c| (c.index, c.position_px)).collect();
        let last = at.keys().fold(IVec2::ZERO, |last, &cell| last.max(IVec2::from_array(cell)));
        let is_missing = |cell: IVec2| {
            let inside = cell.cmpge(IVec2::ZERO).all() && cell.cmple(last).all();
            inside && !at.contains_key(&cell.to_array())
        };
        at.iter().any(|(&cell, &here)| {
            let cell = IVec2::from_array(cell);
            NEIGHBOURS.into_iter().filter(|direction| is_missing(cell + *direction)).any(|direction| {
                // Carried on along the line, or as the line beside it goes.
                let step = |to: IVec2| Some(*at.get(&(to + direction).to_array())? - *at.get(&to.to_array())?);
                let aside = direction.perp();
                let step = step(cell - direction).or_else(|| step(cell + aside)).or_else(|| step(cell - aside));
                step.is_none_or(|step| self.shows(here + step, step.length()))
            })
        })
    }
}

/// Finds crossings of two edges. Pixels where `mask` is false or whose value is not finite do not count.
///
/// # Panics
/// When the mask has another size than the picture.
pub fn find_candidates<'a>(image: &'a Raster<f32>, mask: Option<&Raster<bool>>) -> Candidates<'a> {
    if let Some(mask) = mask {
        assert_eq!((mask.width(), mask.height()), (image.width(), image.height()), "mask and picture differ in size");
    }
    let valid = valid(image, mask);
    let prepared = prepare(image, valid.as_ref());
    let mut found =
        Candidates { image, valid, prepared: None, list: Vec::new(), levels: Vec::new(), rejected: Vec::new() };
    let Some(prepared) = prepared else { return found };

    let (list, rejected) = candidates(&prepared, found.valid.as_ref(), 1.0);
    found.levels.push(0..list.len());
    (found.list, found.rejected, found.prepared) = (list, rejected, Some(prepared));
    found
}

impl Candidates<'_> {
    /// Adds the crossings of coarser pictures: of pixels twice as large, and twice as large again.
    pub(super) fn add_coarser(&mut self) {
        let Some(mut coarse) = self.prepared.as_ref().map(halved) else { return };
        for level in 1..LEVELS {
            if coarse.width().min(coarse.height()) < LEAST_SIDE_PX {
                return;
            }
            let (mut more, _) = candidates(&coarse, self.valid.as_ref(), f64::from(1 << level));
            let finer = self.levels.last().map_or(&[][..], |level| &self.list[level.clone()]);
            take_positions(&mut more, finer);
            self.levels.push(self.list.len()..self.list.len() + more.len());
            self.list.extend(more);
            coarse = halved(&coarse);
        }
    }
}

/// Gives crossings the positions of those of a finer resolution that they are.
fn take_positions(crossings: &mut [Candidate], finer: &[Candidate]) {
    let buckets = Buckets::new(finer);
    for crossing in crossings {
        let distance = |k: usize| finer[k].position.distance(crossing.position);
        let radius = crossing.same_px().min(MOST_SHIFT_PX);
        let near = buckets.around(crossing.position, radius);
        let same = near.filter(|&k| distance(k) < radius && crossing.is_alike(&finer[k]));
        if let Some(k) = same.min_by(|&a, &b| distance(a).total_cmp(&distance(b)).then(a.cmp(&b))) {
            crossing.position = finer[k].position;
        }
    }
}

/// Which pixels count, or `None` where all do.
fn valid(image: &Raster<f32>, mask: Option<&Raster<bool>>) -> Option<Raster<bool>> {
    // Sums, not `all`: they use the processor's lanes.
    let holes = image.data().iter().map(|v| u32::from(!v.is_finite())).fold(0u32, |sum, v| sum | v);
    let masked = mask.is_some_and(|m| m.data().iter().any(|&v| !v));
    if holes == 0 && !masked {
        return None;
    }
    let counts = (0..image.data().len()).map(|k| image.data()[k].is_finite() && mask.is_none_or(|m| m.data()[k]));
    Some(Raster::from_data(image.width(), image.height(), counts.collect()))
}

/// The picture scaled to 0..1, each pixel that does not count replaced by the nearest one of its row that does.
fn prepare(image: &Raster<f32>, valid: Option<&Raster<bool>>) -> Option<Raster<f32>> {
    // Find the darkest and the brightest pixel that counts, in lanes.
    let mut lanes = [(f32::INFINITY, f32::NEG_INFINITY); 16];
    let mut enter = |values: &[f32]| {
        for (lane, &v) in lanes.iter_mut().zip(values) {
            *lane = (if v < lane.0 { v } else { lane.0 }, if v > lane.1 { v } else { lane.1 });
        }
    };
    match valid {
        None => image.data().chunks(16).for_each(enter),
        Some(valid) => {
            let counted = image.data().iter().zip(valid.data()).filter(|(_, counts)| **counts);
            counted.for_each(|(&v, _)| enter(&[v]));
        }
    }
    let (low, high) = lanes.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), v| (l.min(v.0), h.max(v.1)));

    // Scale the picture to 0..1.
    let scale = 1.0 / (high - low);
    if !(scale.is_normal() && scale > 0.0) {
        return None;
    }
    let mut prepared = image.map(|v| (v - low) * scale);

    // Fill its holes.
    if let Some(valid) = valid {
        let width = image.width();
        for (row, counts) in prepared.data_mut().chunks_exact_mut(width).zip(valid.data().chunks_exact(width)) {
            fill(row, counts);
        }
    }
    Some(prepared)
}

/// Replaces each value of a row that does not count by the nearest that does; a row of none becomes 0.
fn fill(row: &mut [f32], counts: &[bool]) {
    let known: Vec<usize> = (0..row.len()).filter(|&i| counts[i]).collect();
    for i in (0..row.len()).filter(|&i| !counts[i]) {
        let after = known.partition_point(|&k| k < i);
        let nearest = [after.checked_sub(1).map(|k| known[k]), known.get(after).copied()]
            .into_iter()
            .flatten()
            .min_by_key(|&k| k.abs_diff(i));
        row[i] = nearest.map_or(0.0, |k| row[k]);
    }
}

/// A peak, and what the ring around it shows where it passes.
type Tested = (Peak, Option<Ring>);

/// Puts the middle of two peaks in the place of both where the ring passes there and not at both of them. Strongest first, before and
/// after.
///
/// Where all edges lie some px towards dark (or bright), since light is clipped or ink spread, two squares of a colour meet in a
/// neck: the saddle's response is as strong at either of its ends, and the corner lies between them.
fn join_split(peaks: &mut Vec<Tested>, test: impl Fn(DVec2) -> Option<Ring>) {
    // List the strongest from left to right.
    let count = peaks.len().min(MOST_PAIRED);
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|&a, &b| peaks[a].0.position.x.total_cmp(&peaks[b].0.position.x));

    // Join each with the first behind it that belongs to it.
    let mut joined = vec![false; peaks.len()];
    let mut middles = Vec::new();
    for (place, &a) in order.iter().enumerate() {
        let (one, one_passes) = (peaks[a].0, peaks[a].1.is_some());
        let near = order[place + 1..].iter().take_while(|&&b| peaks[b].0.position.x - one.position.x < NECK_PX);
        let middle = |&b: &usize| {
            let (other, other_passes) = (peaks[b].0, peaks[b].1.is_some());
            let alike = one.strength.min(other.strength) > ALIKE * one.strength.max(other.strength);
            let apart = joined[a] || joined[b] || (one_passes && other_passes) || !alike;
            if apart || one.position.distance(other.position) >= NECK_PX {
                return None;
            }
            let position = 0.5 * (one.position + other.position);
            let strength = one.strength.max(other.strength);
            Some((b, (Peak { position, strength }, Some(test(position)?))))
        };
        let found = near.clone().find_map(middle);
        if let Some((b, found)) = found {
            (joined[a], joined[b]) = (true, true);
            middles.push(found);
        }
    }

    // Put the middles in their places by strength.
    if !middles.is_empty() {
        let mut number = 0..;
        peaks.retain(|_| number.next().is_none_or(|k: usize| !joined[k]));
        peaks.append(&mut middles);
        peaks.sort_by(|a, b| b.0.strength.total_cmp(&a.0.strength));
    }
}

/// The strength of crossings: the median of the strongest, not of the strongest peaks, since a hot pixel is a strong peak. `None`
/// where none passes.
fn scale_of(peaks: &[Peak], test: impl Fn(DVec2) -> Option<Ring>) -> Option<f32> {
    // A board all of whose crossings are split has some of them among the first.
    let first = peaks.len().min(FIRST_TESTED);
    let mut tested: Vec<Tested> = peaks[..first].iter().map(|peak| (*peak, test(peak.position))).collect();
    join_split(&mut tested, &test);
    let joined = tested.iter().filter(|(_, ring)| ring.is_some()).map(|(peak, _)| peak.strength);
    let later = peaks[first..].iter().filter(|peak| test(peak.position).is_some()).map(|peak| peak.strength);
    let strongest: Vec<f32> = joined.chain(later).take(STRONGEST).collect();
    strongest.get(strongest.len() / 2).copied()
}

/// The crossings of two edges: peaks of the saddle response that pass the ring test, and those that do not, in a picture of pixels
/// that are `scale` px wide in the picture that `valid` is of.
fn candidates(prepared: &Raster<f32>, valid: Option<&Raster<bool>>, scale: f64) -> (Vec<Candidate>, Vec<Rejected>) {
    // Find the peaks of the saddle response, strongest first.
    let mut peaks = peaks(prepared);
    peaks.truncate(MOST_PEAKS);
    let ring_test = RingTest::new();
    let test = |position: DVec2| ring_test.test(prepared, position);
    let Some(middle) = scale_of(&peaks, test) else { return (Vec::new(), Vec::new()) };

    // Test the ring around every peak that is strong, or stands out of what is around it.
    let strong = peaks.partition_point(|p| p.strength >= STRONG * middle);
    peaks.truncate(peaks.partition_point(|p| p.strength >= WEAKEST * middle));
    let rest = rests(&peaks);
    let stands_out = |peak: &Peak| rest.get(&tile(peak)).is_none_or(|rest| peak.strength >= ABOVE_REST * rest);
    let worth = peaks.par_iter().enumerate().filter(|(k, peak)| *k < strong || stands_out(peak));
    let mut tested: Vec<Tested> = worth.map(|(_, peak)| (*peak, test(peak.position))).collect();
    join_split(&mut tested, test);

    // Keep the crossings whose ring lies inside the picture and the mask.
    let size = DVec2::new(prepared.width() as f64, prepared.height() as f64);
    let (mut candidates, mut rejected) = (Vec::new(), Vec::new());
    for (peak, ring) in tested {
        let position = peak.position * scale;
        let inside = (peak.position - RADIUS_PX).min_element() >= 0.0
            && (size - peak.position - RADIUS_PX).min_element() >= 0.0
            && valid.is_none_or(|v| v.get(position.x as usize, position.y as usize));
        match ring {
            // Of weak peaks most are texture, which is not worth a word.
            None if peak.strength < STRONG * middle => {}
            None => rejected.push(Rejected { position_px: position, reason: Reason::Ring }),
            Some(_) if !inside => rejected.push(Rejected { position_px: position, reason: Reason::Cut }),
            Some(ring) => candidates.push(Candidate { position, ring, scale }),
        }
    }
    (candidates, rejected)
}

fn tile(peak: &Peak) -> [usize; 2] {
    // A cast cuts off what is below 0.
    [peak.position.x as usize / TILE_PX, peak.position.y as usize / TILE_PX]
}

/// The strength of the strongest peak of each tile that is beyond the number of a board's crossings; none where there are fewer.
fn rests(strongest_first: &[Peak]) -> BTreeMap<[usize; 2], f32> {
    let mut counts: BTreeMap<[usize; 2], usize> = BTreeMap::new();
    let mut rests = BTreeMap::new();
    for peak in strongest_first {
        let count = counts.entry(tile(peak)).or_default();
        *count += 1;
        if *count == TILE_PX * TILE_PX / CROSSING_PX2 {
            rests.insert(tile(peak), peak.strength);
        }
    }
    rests
}
