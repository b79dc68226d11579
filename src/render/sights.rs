//! How a ray of a pixel and its neighbours see the board and each object.

use super::pixel::square;
use super::plan::{PartBorders, Plan};
use super::work::Work;
use crate::geom::Ray;
use crate::prism::payload::Differentials;
use crate::prism::side::Side;
use glam::{DMat2, DVec2};
use std::iter::once;

/// A thing as a ray and its neighbours see it.
pub(super) struct Sight<'a> {
    pub(super) plan: &'a Plan<'a>,
    /// The place that the ray sees, and how that moves by px, in mm.
    seen_mm: DVec2,
    jacobian: DMat2,
    /// How far the place lies along the ray, in mm, and how that changes by px.
    distance_mm: f64,
    slope: DVec2,
    half_mm: DVec2,
}

impl<'a> Sight<'a> {
    fn new(plan: &'a Plan<'a>, ray: &Ray, side: Side, differentials: &Differentials) -> Option<Self> {
        let footprint = plan.system.land(ray, side, differentials).ok()?;
        if !footprint.jacobian.is_finite() {
            return None;
        }
        let board = plan.system.board();
        let world = |mm: DVec2| board.world(mm);
        let (seen_mm, jacobian) = (footprint.sight.board_mm, footprint.jacobian);
        let own = world(seen_mm);
        let along = |step: DVec2| (world(seen_mm + step) - own).dot(ray.direction);
        Some(Self {
            plan,
            seen_mm,
            jacobian,
            distance_mm: (own - ray.origin).dot(ray.direction),
            slope: DVec2::new(along(jacobian.x_axis), along(jacobian.y_axis)),
            half_mm: plan.system.half_plate_mm(),
        })
    }

    /// The place that is seen `px` from the ray, in mm.
    pub(super) fn mm(&self, px: DVec2) -> DVec2 {
        self.seen_mm + self.jacobian * px
    }

    /// How far along the ray the plane lies `px` from it, in mm.
    pub(super) fn distance(&self, px: DVec2) -> f64 {
        self.distance_mm + self.slope.dot(px)
    }

    /// How far within the four sides of its plate a place is, in mm.
    pub(super) fn within(&self, px: DVec2, side: usize) -> f64 {
        let (axis, sign) = (side % 2, if side < 2 { 1.0 } else { -1.0 });
        self.half_mm[axis] - sign * self.mm(px)[axis]
    }

    /// Whether its plate is seen `px` from the ray.
    pub(super) fn covers(&self, px: DVec2) -> bool {
        (0..4).all(|side| self.within(px, side) >= 0.0)
    }
}

/// A pixel's surroundings in [`alone`]: half their side, in px.
const AROUND_PX: f64 = 1.0;
/// How far the tangent of the map may lead astray at their corners, in px.
const STRAY_PX: f64 = 0.25;

/// The thing that a pixel sees all over, by rays through its centre and the corners of its surroundings; `None` where a border of a
/// plate, a line where two planes meet, the ridge or a border of fates may pass through it.
pub(super) fn alone(plan: &Plan, px: DVec2, work: &mut Work) -> Option<usize> {
    if plan.kinks != PartBorders::None {
        return None;
    }
    // Trace the rays, all through one side and to the same planes.
    let corners = square(AROUND_PX);
    work.counts.rays += 1 + corners.len() as u64;
    let (side, centre) = sights(plan, px)?;
    let around: Vec<Vec<Option<Sight>>> = corners
        .iter()
        .map(|corner| sights(plan, px + *corner).filter(|(other, _)| *other == side).map(|(_, sights)| sights))
        .collect::<Option<_>>()?;

    // Find the things whose plates hold all of the surroundings; of the others one side has to keep all of them out.
    let mut covering = Vec::new();
    for (k, own) in centre.iter().enumerate() {
        let seen: Vec<&Sight> = around.iter().filter_map(|sights| sights[k].as_ref()).collect();
        let Some(own) = own.as_ref().filter(|_| seen.len() == corners.len()) else {
            if own.is_none() && seen.is_empty() { continue } else { return None }
        };
        let inverse = own.jacobian.inverse();
        let stray = |(corner, seen): (&DVec2, &&Sight)| (inverse * (seen.seen_mm - own.mm(*corner))).length();
        if !corners.iter().zip(&seen).all(|pair| stray(pair) < STRAY_PX) {
            return None;
        }
        if seen.iter().all(|sight| sight.covers(DVec2::ZERO)) {
            covering.push((k, seen.iter().map(|sight| sight.distance_mm).collect::<Vec<f64>>()));
        } else if !(0..4).any(|side| seen.iter().all(|sight| sight.within(DVec2::ZERO, side) < 0.0)) {
            return None;
        }
    }

    // Take the nearest, if it is so at every corner.
    let Some((own, nearest)) = covering.iter().min_by(|a, b| a.1[0].total_cmp(&b.1[0])) else { return Some(0) };
    let is_before = |(k, other): &(usize, Vec<f64>)| k == own || nearest.iter().zip(other).all(|(a, b)| a < b);
    covering.iter().all(is_before).then_some(*own)
}

/// How the ray through a place of the picture sees the board and each object, `None` of those that it does not meet, and the side of
/// the prism that it goes through.
pub(super) fn sights<'a>(plan: &'a Plan<'a>, px: DVec2) -> Option<(Side, Vec<Option<Sight<'a>>>)> {
    let mut differentials = plan.system.camera().differentials(px);
    let (ray, side) = plan.system.exit(plan.system.camera().ray(px), &mut differentials).ok()?;
    let sight = |one| Sight::new(one, &ray, side, &differentials);
    Some((side, once(plan).chain(&plan.objects).map(sight).collect()))
}
