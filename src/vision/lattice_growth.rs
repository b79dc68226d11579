//! Lattice growth: from candidates to a lattice by growth from a seed, each new corner predicted from its neighbours
//! only, so that no global model of the picture is needed and bending does not matter.

use super::buckets::Buckets;
use super::candidate::{Candidate, NEIGHBOURS};
use super::candidates::Candidates;
use super::settings::Settings;
use crate::raster::Raster;
use glam::{DVec2, IVec2};
use std::collections::{BTreeMap, VecDeque};

/// A neighbour lies within this share of a step of where it is predicted.
const PREDICTION_TOLERANCE: f64 = 0.28;
/// Lobe directions of neighbours differ by 90 deg: the cosine of twice the difference is below this.
const OPPOSITE: f64 = -0.5;
/// The weakest contrast of a corner against the neighbour it is reached from.
const AMPLITUDE_SHARE: f64 = 0.25;
/// A seed's neighbour lies within 32 deg of the arm it is sought along (cosine): blur turns the arms of a slanted
/// crossing.
const ARM_COSINE: f64 = 0.85;
/// Opposite neighbours of a seed differ in distance by at most this share of their mean.
const ARM_IMBALANCE: f64 = 0.35;
/// How far a seed's neighbours are sought, in px, one radius after another.
const SEED_RADII_PX: [f64; 6] = [16.0, 32.0, 64.0, 128.0, 256.0, 512.0];

/// A seed's neighbour is not sought further where so many candidates lie nearer: the squares of a board are the nearest of their
/// resolution, and among texture a wide search costs the square of its crossings.
const MOST_AROUND: usize = 400;

/// Where along the way from a corner to its neighbour the edge between them is sampled.
const EDGE_PLACES: [f64; 5] = [0.3, 0.4, 0.5, 0.6, 0.7];
/// How far to both sides of the edge, as a share of the step and at least in pixels of the resolution: near enough that a way slanting over
/// squares has both sides in one square for the most part, and nearer, beside marks that reach to a tenth of a step from the edge.
const EDGE_ASIDE: [(f64, f64); 2] = [(0.1, 1.5), (0.05, 1.5)];
/// The least mean difference across the edge, as a share of the ring's amplitude: a true edge has 1.6 and more, a way over
/// squares (to a corner that is not next) less than 1.
const EDGE_SHARE: f64 = 1.0;

/// Lattice index (column, row) -> number of the candidate.
pub(super) type Lattice = BTreeMap<[i32; 2], usize>;

/// The lattices found in a picture, largest first; a crossing is in at most one, but the same place may be in a lattice of a coarser
/// picture too.
#[derive(Debug, Clone, Default)]
pub struct Lattices(pub(super) Vec<Lattice>);

impl Lattices {
    /// How many crossings each holds.
    pub fn sizes(&self) -> Vec<usize> {
        self.0.iter().map(Lattice::len).collect()
    }
}

/// Grows lattices from the crossings of a picture.
pub fn grow(candidates: &Candidates<'_>, settings: &Settings) -> Lattices {
    grow_levels(candidates, settings, Lattices::default(), 0)
}

/// The lattices of the finest resolution, and those that grow from the crossings of all coarser ones.
pub(super) fn grow_coarser(candidates: &Candidates<'_>, settings: &Settings, finest: Lattices) -> Lattices {
    grow_levels(candidates, settings, finest, 1)
}

/// Adds the lattices of the resolutions from `first` on to those of finer ones.
fn grow_levels(candidates: &Candidates<'_>, settings: &Settings, finer: Lattices, first: usize) -> Lattices {
    let Lattices(mut lattices) = finer;
    let Some(image) = &candidates.prepared else { return Lattices(lattices) };
    for level in candidates.levels.iter().skip(first) {
        let list = &candidates.list[level.clone()];
        let grown = grow_level(&GrowthField::new(image, list), settings);
        // Number the crossings among those of all resolutions, and keep what finer ones do not show.
        let numbered =
            grown.into_iter().map(|lattice| lattice.into_iter().map(|(c, k)| (c, k + level.start)).collect());
        let new: Vec<Lattice> = numbered.filter(|lattice| shows_more(candidates, &lattices, lattice)).collect();
        lattices.extend(new);
    }
    // Stable: of equal lattices the one found first stays first.
    lattices.sort_by_key(|l| std::cmp::Reverse(l.len()));
    Lattices(lattices)
}

/// Whether a lattice has a crossing that is in none of those of finer resolutions.
fn shows_more(candidates: &Candidates<'_>, finer: &[Lattice], lattice: &Lattice) -> bool {
    let known: Vec<Candidate> = finer.iter().flat_map(Lattice::values).map(|&k| candidates.list[k]).collect();
    let buckets = Buckets::new(&known);
    let shown = |place: &Candidate| {
        let radius = place.same_px();
        buckets.around(place.position, radius).any(|k| known[k].position.distance(place.position) < radius)
    };
    lattice.values().any(|&k| !shown(&candidates.list[k]))
}

/// Grows lattices from the crossings of one resolution.
fn grow_level(field: &GrowthField<'_>, settings: &Settings) -> Vec<Lattice> {
    let mut used = vec![false; field.candidates.len()];
    let mut lattices: Vec<Lattice> = Vec::new();
    for seed in seeds(field.candidates) {
        if used[seed] {
            continue;
        }
        let Some(cross) = cross(field, &used, seed) else { continue };
        let lattice = extend(field, &mut used, cross);
        if lattice.len() >= settings.min_corners && is_broad(&lattice) {
            lattices.push(lattice);
        } else {
            // What belongs to no lattice may still belong to one that grows from another seed.
            lattice.values().for_each(|&k| used[k] = k == seed);
        }
    }
    lattices
}

/// Whether the lattice reaches over at least three columns and three rows.
pub(super) fn is_broad(lattice: &Lattice) -> bool {
    (0..2).all(|axis| {
        let span = lattice.keys().map(|k| k[axis]);
        span.clone().max().zip(span.min()).is_some_and(|(last, first)| last - first >= 2)
    })
}

/// Candidate numbers from the middle of the cloud outwards: a seed inside a board has neighbours on all sides.
fn seeds(candidates: &[Candidate]) -> Vec<usize> {
    let middle = candidates.iter().map(|c| c.position).sum::<DVec2>() / candidates.len().max(1) as f64;
    let mut order: Vec<usize> = (0..candidates.len()).collect();
    let distance = |k: usize| candidates[k].position.distance_squared(middle);
    order.sort_by(|&a, &b| distance(a).total_cmp(&distance(b)).then(a.cmp(&b)));
    order
}

/// What a lattice grows on.
struct GrowthField<'a> {
    image: &'a Raster<f32>,
    candidates: &'a [Candidate],
    buckets: Buckets,
    /// Unit vectors at twice the angle of each one's bright lobe.
    lobes: Vec<DVec2>,
}

impl<'a> GrowthField<'a> {
    fn new(image: &'a Raster<f32>, candidates: &'a [Candidate]) -> Self {
        let lobe = |c: &Candidate| {
            let (sin, cos) = libm::sincos(2.0 * c.ring.lobe_rad);
            DVec2::new(cos, sin)
        };
        Self { image, candidates, buckets: Buckets::new(candidates), lobes: candidates.iter().map(lobe).collect() }
    }

    /// Whether two corners are neighbours: bright where the other is dark, of like contrast, and with an edge between.
    fn linked(&self, a: usize, b: usize) -> bool {
        let opposite = self.lobes[a].dot(self.lobes[b]) < OPPOSITE;
        let (a, b) = (&self.candidates[a], &self.candidates[b]);
        opposite
            && a.ring.amplitude > AMPLITUDE_SHARE * b.ring.amplitude
            && b.ring.amplitude > AMPLITUDE_SHARE * a.ring.amplitude
            && self.edge_between(a, b)
    }

    /// Whether one side of the way from `a` to `b` is bright and the other dark, as the lobes of `a` foretell.
    fn edge_between(&self, a: &Candidate, b: &Candidate) -> bool {
        let step = b.position - a.position;
        let unit = step.perp().normalize_or_zero();
        // The lobe is a direction without sign: the bright square is the one that the lobe leans to.
        let (sin, cos) = libm::sincos(a.ring.lobe_rad);
        let lobe = DVec2::new(cos, sin);
        let expected = (lobe.dot(step) * lobe.dot(unit)).signum();
        let value = |p: DVec2| {
            let place = |v: f64, count: usize| (v.max(0.0) as usize).min(count - 1);
            f64::from(self.image.get(place(p.x, self.image.width()), place(p.y, self.image.height())))
        };
        EDGE_ASIDE.iter().any(|(share, least)| {
            let aside = unit * (least * a.scale).max(share * step.length());
            let across = |p: DVec2| value(p + aside) - value(p - aside);
            let difference: f64 =
                EDGE_PLACES.iter().map(|&t| across(a.position + step * t)).sum::<f64>() / EDGE_PLACES.len() as f64;
            difference * expected > EDGE_SHARE * a.ring.amplitude.min(b.ring.amplitude)
        })
    }

    /// Of some candidates, those further than `from` px (where that is not 0) from `point` and within `radius` px that `accept` takes, the nearest.
    fn nearest(
        &self,
        some: impl Iterator<Item = usize>,
        point: DVec2,
        [from, radius]: [f64; 2],
        accept: impl Fn(usize) -> bool,
    ) -> Option<usize> {
        let within = |squared: f64| squared <= radius * radius && (from == 0.0 || squared > from * from);
        // Only what is nearer than the nearest so far is asked for more than its place.
        let mut best: Option<(f64, usize)> = None;
        for k in some {
            let squared = self.candidates[k].position.distance_squared(point);
            if within(squared) && best.is_none_or(|best| (squared, k) < best) && accept(k) {
                best = Some((squared, k));
            }
        }
        best.map(|(_, k)| k)
    }
}

/// The seed with its nearest neighbour along each of its four arms.
fn cross(field: &GrowthField<'_>, used: &[bool], seed: usize) -> Option<Lattice> {
    let centre = &field.candidates[seed];
    let step = |k: usize| field.candidates[k].position - centre.position;
    // A seed whose first arm leads nowhere is done: nothing is asked for ahead.
    let (mut few, mut around) = (0, Vec::new());
    let mut found = [0; 4];
    for (place, &arm) in found.iter_mut().zip(&centre.ring.arms) {
        // By squares: most candidates are asked for no more than this.
        let along = |k: usize| {
            let (way, step) = (step(k).dot(arm), step(k));
            way > 0.0 && way * way > ARM_COSINE * ARM_COSINE * step.length_squared()
        };
        let accept = |k: usize| along(k) && !used[k] && field.linked(seed, k);
        let mut ring = |number: usize| {
            let (from, radius) = (number.checked_sub(1).map_or(0.0, |n| SEED_RADII_PX[n]), SEED_RADII_PX[number]);
            if few <= number {
                around.clear();
                around.extend(field.buckets.around(centre.position, radius).take(MOST_AROUND + 1));
                (around.len() <= MOST_AROUND).then_some(())?;
                few = number + 1;
            }
            Some(field.nearest(around.iter().copied(), centre.position, [from, radius], accept))
        };
        *place = (0..SEED_RADII_PX.len()).map_while(&mut ring).flatten().next()?;
    }
    let balanced = |i: usize| {
        let (one, other) = (step(found[i]), step(found[i + 2]));
        (one + other).length() < ARM_IMBALANCE * 0.5 * (one.length() + other.length())
    };
    (balanced(0) && balanced(1)).then(|| {
        let cells = [[1, 0], [0, 1], [-1, 0], [0, -1]];
        cells.into_iter().zip(found).chain([([0, 0], seed)]).collect()
    })
}

/// Breadth first from the cross until no neighbour is found where it is predicted.
fn extend(field: &GrowthField<'_>, used: &mut [bool], cross: Lattice) -> Lattice {
    let mut lattice = cross;
    let mut queue: VecDeque<IVec2> = lattice.keys().map(|&k| IVec2::from_array(k)).collect();
    lattice.values().for_each(|&k| used[k] = true);
    while let Some(cell) = queue.pop_front() {
        for direction in NEIGHBOURS {
            let next = cell + direction;
            if lattice.contains_key(&next.to_array()) {
                continue;
            }
            let Some((from, predicted)) = predict(field.candidates, &lattice, cell, direction) else { continue };
            let tolerance = PREDICTION_TOLERANCE * predicted.distance(field.candidates[from].position);
            let around = field.buckets.around(predicted, tolerance);
            if let Some(k) = field.nearest(around, predicted, [0.0, tolerance], |k| !used[k] && field.linked(from, k)) {
                used[k] = true;
                lattice.insert(next.to_array(), k);
                queue.push_back(next);
            }
        }
    }
    lattice
}

/// Where the neighbour of `cell` in a direction should be: on along the line, with its bend where three corners show
/// it, or as the fourth corner of a parallelogram. With it the number of the candidate at `cell`.
fn predict(candidates: &[Candidate], lattice: &Lattice, cell: IVec2, direction: IVec2) -> Option<(usize, DVec2)> {
    let at = |c: IVec2| lattice.get(&c.to_array()).map(|&k| candidates[k].position);
    let from = *lattice.get(&cell.to_array())?;
    let here = candidates[from].position;
    let predicted = match (at(cell - direction), at(cell - direction * 2)) {
        (Some(back), Some(further)) => 3.0 * (here - back) + further,
        (Some(back), None) => 2.0 * here - back,
        (None, _) => [direction.perp(), -direction.perp()]
            .into_iter()
            .find_map(|aside| Some(here + at(cell + aside + direction)? - at(cell + aside)?))?,
    };
    Some((from, predicted))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vision::ring_test::RingTest;

    #[test]
    fn a_way_over_squares_links_no_corners() {
        let board = |k: usize| if (k % 120 / 20 + k / 120 / 20).is_multiple_of(2) { 0.9 } else { 0.1 };
        let image = Raster::from_data(120, 120, (0..120 * 120).map(board).collect());
        let at = |x: f64, y: f64| {
            let position = DVec2::new(x, y);
            Candidate { position, ring: RingTest::new().test(&image, position).unwrap(), scale: 1.0 }
        };
        // A corner, its neighbour along the edge, one that is a knight's move away, and one across the square.
        let candidates = [at(40.0, 40.0), at(60.0, 40.0), at(80.0, 60.0), at(60.0, 60.0)];
        let field = GrowthField::new(&image, &candidates);
        assert!(field.linked(0, 1) && field.linked(1, 0));
        assert!(!field.linked(0, 2), "bright and dark alternate, but no edge joins them");
        assert!(!field.linked(0, 3), "both are alike");
    }
}
