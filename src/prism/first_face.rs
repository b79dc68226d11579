//! The rule for which face a ray meets first, and its three kernels: for one ray, for a packet of rays, and for light that
//! is reflected.
//!
//! The facets meet in the ridge, x = 0 in the prism's frame. The right facet counts where x >= 0, the left one where x < 0,
//! its own half: what either surface does beyond the ridge is not glass.
//!
//! 1. A ray meets the nearest facet that it meets on that facet's own half; the right one at the same distance.
//! 2. A ray that meets both facets, neither on its own half, went through the ridge itself where the x of the meeting point
//!    is 0 to within its rounding: there it meets the right facet.
//! 3. Any other ray meets no facet.
//! 4. Behind a facet the back of the same side counts everywhere: light passes the two surfaces of a side in sequence. Light
//!    that is reflected, and finds no back of the side whose facet it met last, meets the other back on that one's own half.
//!    Of a solid prism each back counts on its own half only, as the facets do: the glass is what lies between facet and back
//!    of the right half where x >= 0, and of the left half where x < 0. Light that crosses x = 0 in it leaves through the
//!    back of the other half; at the edge of both, to within rounding, through the right one.
//! 5. A face never sees itself: it is less bent than the light on it is inclined, as it is where
//!    [`crate::surface::shape::PolynomialSurface`] knows that a ray crosses it once.
//!
//! A ray that never changes the sign of x needs one facet only. The packet leaves to the scalar kernel what it cannot decide
//! for all of its rays at once: lanes of the other side, and the ridge of 2. Light that no surface reflects takes the way of
//! the scalar kernel, bit for bit.

use super::biprism::Prism;
use super::lanes::Rays;
use super::packet::{Hits, PackedBiprism, PacketSurface};
use super::side::{PrismFace, Side};
use crate::geom::Ray;
use crate::num::simd::Lanes;
use crate::optics::fate::Fate;
use crate::surface::face::Face;
use crate::surface::hit::Hit;
use crate::surface::shape::Surface;
use glam::DVec3;

/// Relative rounding of a point's x on its way along a ray, by which it may lie on the other side of the ridge: a few
/// operations.
const RIDGE_ROUNDINGS: f64 = 8.0 * f64::EPSILON;

impl Prism {
    /// The side whose facet the ray (in the prism's frame) meets first, by the rule above.
    ///
    /// # Errors
    /// The fate of a ray that meets none.
    #[inline(always)]
    pub(super) fn first_facet(&self, ray: &Ray, residual_mm: f64) -> Result<(Side, Hit), Fate> {
        let [[left_facet, _], [right_facet, _]] = &self.sides;
        let (x, dx) = (ray.origin.x, ray.direction.x);
        // A ray that never changes the sign of x can meet one side only.
        if x >= 0.0 && dx >= 0.0 {
            return right_facet.intersect(ray, residual_mm).map(|m| (Side::Right, m));
        }
        if x <= 0.0 && dx < 0.0 {
            return left_facet.intersect(ray, residual_mm).map(|m| (Side::Left, m));
        }
        let right = right_facet.intersect(ray, residual_mm).map(|m| (Side::Right, m));
        let left = left_facet.intersect(ray, residual_mm).map(|m| (Side::Left, m));
        let right_is_own = right.is_ok_and(|(_, m)| ray.at(m.t_mm).x >= 0.0);
        let left_is_own = left.is_ok_and(|(_, m)| ray.at(m.t_mm).x < 0.0);
        match (left_is_own, right_is_own) {
            (true, true) => left.and_then(|l| right.map(|r| if l.1.t_mm < r.1.t_mm { l } else { r })),
            (true, false) => left,
            (false, true) => right,
            (false, false) => match (right, left) {
                // Both sides meet in the ridge: a ray that finds neither on its own half went through the ridge itself,
                // to within the rounding of x.
                (Ok((_, m)), Ok(_)) if ray.at(m.t_mm).x.abs() <= RIDGE_ROUNDINGS * (x.abs() + m.t_mm) => right,
                _ => Err(right.err().or(left.err()).unwrap_or(Fate::Missed)),
            },
        }
    }
}

impl Prism {
    /// The back that bounds a solid prism where the ray (in the prism's frame), which came through the facet of `side`, leaves
    /// it, and where.
    ///
    /// # Errors
    /// The fate of a ray that meets none.
    #[inline(never)]
    pub(super) fn back_behind(&self, ray: &Ray, side: Side, residual_mm: f64) -> Result<(&Surface, Hit), Fate> {
        let met = |side: Side| {
            let surface = self.surface(side, Face::Back);
            let hit = surface.intersect(ray, residual_mm)?;
            let part = if surface.part_counts() == [1; 2] { side as u32 } else { hit.part };
            Ok((surface, Hit { part, ..hit }))
        };
        let x_of = |found: &Result<(&Surface, Hit), Fate>| found.map_or(f64::NAN, |(_, hit)| ray.at(hit.t_mm).x);

        // On the half where it came in, the way to a place of that half stays in it.
        let own = met(side);
        if is_on_half(side, x_of(&own)) {
            return own;
        }
        let other = met(side.other());
        if is_on_half(side.other(), x_of(&other)) {
            return other;
        }
        let right = if side == Side::Right { own } else { other };
        let edge = |(_, hit): (&Surface, Hit)| x_of(&right).abs() <= RIDGE_ROUNDINGS * (ray.origin.x.abs() + hit.t_mm);
        match right {
            Ok(found) if edge(found) => right,
            _ => Err(own.err().or(other.err()).unwrap_or(Fate::Missed)),
        }
    }
}

/// Whether a ray that starts on the other half leads away from that of `side`, and starts so far from it, in mm, that no rounding
/// along its way brings it there.
fn is_beyond_reach(side: Side, ray: &Ray) -> bool {
    const FAR_MM: f64 = 1e-6;
    let (x, dx) = (ray.origin.x, ray.direction.x);
    match side {
        Side::Right => x < -FAR_MM && dx <= 0.0,
        Side::Left => x > FAR_MM && dx >= 0.0,
    }
}

/// Whether a place with this x is on the half of `side`.
fn is_on_half(side: Side, x: f64) -> bool {
    match side {
        Side::Right => x >= 0.0,
        Side::Left => x < 0.0,
    }
}

impl<S: PacketSurface> PackedBiprism<S> {
    /// The side whose facet the rays (in the prism's frame) meet first, by the rule above; lanes of another side, and
    /// those that only the ridge decides, are not met.
    #[inline(always)]
    pub(super) fn first_facet(&self, rays: &Rays, residual_mm: f64) -> (Side, Hits) {
        let zero = Lanes::splat(0.0);
        let (x, dx) = (rays.origin.x, rays.direction.x);
        let only_right = zero.le(x) & zero.le(dx);
        if only_right.all() {
            return (Side::Right, self.sides[1][0].intersect(rays, residual_mm));
        }
        let only_left = x.le(zero) & dx.lt(zero);
        if only_left.all() {
            return (Side::Left, self.sides[0][0].intersect(rays, residual_mm));
        }
        let (left, right) =
            (self.sides[0][0].intersect(rays, residual_mm), self.sides[1][0].intersect(rays, residual_mm));
        let on_right = right.met & zero.le(rays.at(right.t_mm).x);
        let on_left = left.met & rays.at(left.t_mm).x.lt(zero);
        // On one side's own half, and surely not on the other's.
        let not_left = (left.met & !on_left) | self.sides[0][0].misses(rays);
        let not_right = (right.met & !on_right) | self.sides[1][0].misses(rays);
        let free = !only_right & !only_left;
        let is_right = right.met & (only_right | (free & on_right & not_left));
        let is_left = left.met & (only_left | (free & on_left & not_right));
        if is_left.none() {
            (Side::Right, Hits { met: is_right, ..right })
        } else {
            (Side::Left, Hits { met: is_left, ..left })
        }
    }
}

/// Where light sets out that may be reflected.
#[derive(Debug, Clone, Copy)]
pub(super) struct RayStart {
    /// The face where it starts; `None` at first.
    pub from: Option<PrismFace>,
    /// Whether it is in the glass.
    pub inside: bool,
    /// The side whose facet it met last; at first the one that it is turned to.
    pub side: Side,
    /// Whether it was ever reflected.
    pub reflected: bool,
}

/// What light comes to next.
pub(super) enum NextFace {
    /// A face, met there, with the normal by which it refracts and reflects.
    Meets(PrismFace, Hit),
    /// Nothing: it leaves the glass for good.
    Escapes,
    /// The rim of the glass, or a place that no solver finds.
    Lost,
}

impl Prism {
    /// Where the ray (in the prism's frame) first meets a face, with the normal by which that refracts.
    fn intersect_face(&self, at: PrismFace, ray: &Ray, residual_mm: f64) -> Result<Hit, Fate> {
        let hit = self.surface(at.side, at.face).intersect(ray, residual_mm)?;
        Ok(Hit { normal: self.normal(at.face, &hit), ..hit })
    }

    /// What light that goes along `ray` (in the prism's frame) from `start` meets next, by the rule above.
    pub(super) fn next_face(&self, ray: &Ray, start: &RayStart, residual_mm: f64) -> NextFace {
        // Through the back there is nothing more to meet.
        if !start.inside && start.from.is_some_and(|from| from.face == Face::Back) {
            return NextFace::Escapes;
        }
        let mut nearest: Option<(FacePart, PrismFace, Hit)> = None;
        let facet = |side: Side| PrismFace { side, face: Face::Front };
        let back = |side: Side| PrismFace { side, face: Face::Back };
        let faces = [facet(Side::Right), facet(Side::Left), back(start.side), back(start.side.other())];
        let mut own_back = false;
        for at in &faces[..if start.inside { 4 } else { 2 }] {
            let other_back = *at == faces[3];
            // Light that is not reflected passes in sequence, or not at all.
            if other_back && !self.is_solid() && (own_back || !start.reflected) {
                continue;
            }
            let itself = start
                .from
                .is_some_and(|from| if at.face == Face::Back { from.face == Face::Back } else { from == *at });
            if itself || (at.face == Face::Front && is_beyond_reach(at.side, ray)) {
                continue;
            }
            let meeting = match self.intersect_face(*at, ray, residual_mm) {
                Ok(meeting) => meeting,
                Err(Fate::NotConverged) => return NextFace::Lost,
                Err(_) => continue,
            };
            let on_its_half = other_back || self.is_solid();
            let Some(part) = part_met(ray, start.inside, *at, on_its_half, &meeting) else { continue };
            own_back |= at.face == Face::Back;
            let nearer = nearest.is_none_or(|(other, met, m)| match (other, part) {
                (FacePart::Ridge, FacePart::Own) if met.face == at.face => true,
                (FacePart::Own, FacePart::Ridge) if met.face == at.face => false,
                (FacePart::Ridge, FacePart::Ridge) => false,
                _ => meeting.t_mm < m.t_mm,
            });
            if nearer {
                nearest = Some((part, *at, meeting));
            }
        }
        match nearest {
            Some((_, at, meeting)) => NextFace::Meets(at, meeting),
            // Inside, the rim of the glass.
            None if start.inside => NextFace::Lost,
            None => NextFace::Escapes,
        }
    }
}

/// Where a face was met.
#[derive(Clone, Copy, PartialEq, Eq)]
enum FacePart {
    /// Where it counts.
    Own,
    /// In the ridge, to within rounding.
    Ridge,
}

/// Where a face was met, if it is there and is met from the side on which the light is. This, and not a least distance,
/// keeps light from meeting again what it has just left.
///
/// A facet counts on its own half, and so does a back if `on_its_half`.
fn part_met(ray: &Ray, inside: bool, at: PrismFace, on_its_half: bool, meeting: &Hit) -> Option<FacePart> {
    let upwards: DVec3 = meeting.normal * meeting.normal.z.signum();
    let along = ray.direction.dot(upwards);
    // Glass is behind the facets, in +z, and in front of the backs.
    let into_glass = if at.face == Face::Front { along } else { -along };
    if along == 0.0 || (into_glass < 0.0) != inside {
        return None;
    }
    let x = ray.at(meeting.t_mm).x;
    let own = (at.face == Face::Back && !on_its_half) || is_on_half(at.side, x);
    let slack = RIDGE_ROUNDINGS * (ray.origin.x.abs() + meeting.t_mm);
    if own { Some(FacePart::Own) } else { (x.abs() <= slack).then_some(FacePart::Ridge) }
}
