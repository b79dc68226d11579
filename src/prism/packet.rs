//! Packets of rays through the two surfaces of a biprism, with the bits of the scalar trace.
//!
//! Every line repeats a line of [`crate::optics`] or [`crate::prism::refract_at`] on [`Lanes`]; the tests of `render` compare
//! whole pictures bit by bit. Only the common way is here: a lane that needs care (near total reflection, a missed
//! surface, several crossings, a slow solver) is handed back undecided, to be traced by the scalar code.

use super::lanes::{Rays, Vectors};
use super::side::Side;
use crate::geom::{Pose, Rect};
use crate::num::poly2::Poly2;
use crate::num::simd::{Lanes, Mask};
use crate::optics::snell::CAREFUL_BELOW;
use crate::surface::shape::{FULL_WAYS_PER_MM, PolynomialSurface};
use glam::DVec3;

/// Where rays meet a surface.
#[derive(Debug, Clone, Copy)]
pub struct Hits {
    pub(super) t_mm: Lanes,
    pub(super) normal: Vectors,
    /// Lanes that surely met it.
    pub(super) met: Mask,
}

/// A shape that a packet of rays can meet.
pub trait PacketSurface {
    /// Where the rays first meet it, for a solver that stops at `residual_mm`.
    fn intersect(&self, rays: &Rays, residual_mm: f64) -> Hits;
    /// Which rays surely do not meet it; nothing is said of the others.
    fn misses(&self, rays: &Rays) -> Mask;
}

/// A whole plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// A point of it, in mm.
    pub point: DVec3,
    /// Its unit normal.
    pub normal: DVec3,
}

impl PacketSurface for Plane {
    #[inline(always)]
    fn intersect(&self, rays: &Rays, _: f64) -> Hits {
        let (point, normal) = (Vectors::splat(self.point), Vectors::splat(self.normal));
        let o = rays.origin;
        let to_point = Vectors { x: point.x - o.x, y: point.y - o.y, z: point.z - o.z };
        let t_mm = to_point.dot(normal) / rays.direction.dot(normal);
        let met = Lanes::splat(0.0).lt(t_mm) & t_mm.lt(Lanes::splat(f64::INFINITY));
        Hits { t_mm, normal, met }
    }

    #[inline(always)]
    fn misses(&self, rays: &Rays) -> Mask {
        !self.intersect(rays, 0.0).met
    }
}

/// The coefficients of a [`Poly2`] laid out for loops of a length that is known to the compiler: degree at most N - 1.
/// Rows of odd powers of y are left out where `EVEN`.
#[derive(Debug, Clone, PartialEq)]
pub struct Table<const N: usize, const EVEN: bool> {
    rows: [[f64; N]; N],
}

/// The polynomial of a [`PackedPolynomial`].
pub trait Polynomial {
    /// p, dp/dX, dp/dY at (X, Y), in scaled coordinates.
    fn gradient(&self, x: Lanes, y: Lanes) -> [Lanes; 3];
}

impl<const N: usize, const EVEN: bool> Table<N, EVEN> {
    /// The table of `p`; `None` when its degree is too high, or a term is odd in Y where none may be.
    pub fn new(p: &Poly2) -> Option<Self> {
        let mut rows = [[0.0; N]; N];
        for (m, n, c) in p.terms() {
            if c != 0.0 {
                if m + n >= N || (EVEN && n % 2 == 1) {
                    return None;
                }
                rows[n][m] = c;
            }
        }
        Some(Self { rows })
    }
}

impl<const N: usize, const EVEN: bool> Polynomial for Table<N, EVEN> {
    // The nested Horner schemes of Poly2::gradient, without the multiplications of zero at their starts.
    #[inline(always)]
    fn gradient(&self, u: Lanes, v: Lanes) -> [Lanes; 3] {
        // Sum up the rows from the highest power of y on.
        let zero = Lanes::splat(0.0);
        let (mut p, mut pu, mut pv) = (zero, zero, zero);
        for n in (0..N).rev() {
            // Leave out the odd powers of y.
            if EVEN && n % 2 == 1 {
                (pv, p, pu) = (pv * v + p, p * v, pu * v);
                continue;
            }

            // Sum up the powers of x, with their derivative.
            let row = &self.rows[n];
            let last = N - 1 - n;
            let (mut r, mut ru) = (Lanes::splat(row[last]), zero);
            if last > 0 {
                ru = r;
                r = r * u + Lanes::splat(row[last - 1]);
                for m in (0..last - 1).rev() {
                    ru = ru * u + r;
                    r = r * u + Lanes::splat(row[m]);
                }
            }

            // Go on to the next power of y.
            if n == N - 1 {
                (p, pu) = (r, ru);
            } else {
                (pv, p, pu) = (pv * v + p, p * v + r, pu * v + ru);
            }
        }
        [p, pu, pv]
    }
}

/// A polynomial of any degree, evaluated without a table.
impl Polynomial for Poly2 {
    #[inline(always)]
    fn gradient(&self, u: Lanes, v: Lanes) -> [Lanes; 3] {
        let zero = Lanes::splat(0.0);
        let (mut p, mut pu, mut pv) = (zero, zero, zero);
        for row in self.rows() {
            let (mut r, mut ru) = (zero, zero);
            for &c in row.iter().rev() {
                ru = ru * u + r;
                r = r * u + Lanes::splat(c);
            }
            (pv, p, pu) = (pv * v + p, p * v + r, pu * v + ru);
        }
        [p, pu, pv]
    }
}

/// A polynomial sheet z(x, y) over a rectangle, or its mirror image z(-x, y): a [`PolynomialSurface`] for packets.
#[derive(Debug, Clone, PartialEq)]
pub struct PackedPolynomial<P> {
    polynomial: P,
    centre: [f64; 2],
    inverse_scale: [f64; 2],
    tangent: [f64; 3],
    steepest: f64,
    domain: Rect,
    heights: [f64; 2],
    mirrored: bool,
}

impl<P> PackedPolynomial<P> {
    /// The sheet `freeform`, whose polynomial is laid out as `polynomial`.
    pub fn new(freeform: &PolynomialSurface, polynomial: P) -> Self {
        Self {
            polynomial,
            centre: freeform.sag().centre(),
            inverse_scale: freeform.sag().inverse_scale(),
            tangent: freeform.tangent(),
            steepest: freeform.steepest(),
            domain: freeform.domain(),
            heights: freeform.heights(),
            mirrored: freeform.is_mirrored(),
        }
    }
}

/// Steps of Newton's method before a lane is handed back.
const MAX_STEPS: usize = 6;

impl<P: Polynomial> PacketSurface for PackedPolynomial<P> {
    #[inline(always)]
    fn intersect(&self, rays: &Rays, residual_mm: f64) -> Hits {
        // Move the rays to the sheet's own frame, and start from its tangent plane.
        let own = |v: Vectors| Vectors { x: v.x.negated_where(Mask::splat(self.mirrored)), ..v };
        let (o, d) = (own(rays.origin), own(rays.direction));
        let [x0, y0] = self.centre.map(Lanes::splat);
        let [a, b] = self.inverse_scale.map(Lanes::splat);
        let [z0, zx0, zy0] = self.tangent.map(Lanes::splat);
        let residual = Lanes::splat(residual_mm);
        let mut t = (z0 + zx0 * (o.x - x0) + zy0 * (o.y - y0) - o.z) / (d.z - zx0 * d.x - zy0 * d.y);
        let across = (d.x * d.x + d.y * d.y).sqrt();

        // Step by Newton's method until every lane is done or needs care.
        let (mut t_mm, mut zx_met, mut zy_met) = (t, t, t);
        let mut inside = Mask::splat(false);
        // A ray that may cross the sheet several times, or whose residual stalls, needs the scalar solver's care.
        let mut care = !(Lanes::splat(self.steepest) * across).lt(d.z.abs());
        let mut done = care;
        let mut previous = Lanes::splat(f64::INFINITY);
        for _ in 0..MAX_STEPS {
            // Evaluate the gap between ray and sheet.
            let p = Vectors { x: o.x + d.x * t, y: o.y + d.y * t, z: o.z + d.z * t };
            let [z, pu, pv] = self.polynomial.gradient((p.x - x0) * a, (p.y - y0) * b);
            let (zx, zy) = (pu * a, pv * b);
            let gap = p.z - z;
            let next = t - gap / (d.z - zx * d.x - zy * d.y);

            // Keep the lanes whose gap is within the residual, one last step on.
            let wanted = residual * (Lanes::splat(FULL_WAYS_PER_MM) * t.abs()).min(Lanes::splat(1.0));
            let newly = gap.abs().le(wanted) & !done;
            (t_mm, zx_met, zy_met) = (newly.select(next, t_mm), newly.select(zx, zx_met), newly.select(zy, zy_met));

            // Accept a hit ahead of the ray and within the domain.
            let Rect { min, max } = self.domain;
            let within = Lanes::splat(0.0).lt(t)
                & Lanes::splat(min.x).le(p.x)
                & p.x.le(Lanes::splat(max.x))
                & Lanes::splat(min.y).le(p.y)
                & p.y.le(Lanes::splat(max.y));
            inside = inside | (newly & within);

            // Hand back the lanes whose gap no longer falls.
            care = care | (previous.le(gap.abs()) & !newly & !done);
            done = done | newly | care;
            if done.all() {
                break;
            }
            (t, previous) = (next, gap.abs());
        }

        // Take the normal where they were met.
        let normal = Vectors { x: -zx_met, y: -zy_met, z: Lanes::splat(1.0) }.normalize();
        let met = inside & t_mm.abs().lt(Lanes::splat(f64::INFINITY));
        Hits { t_mm, normal: own(normal), met }
    }

    /// The rays that pass by the box about the sheet.
    #[inline(always)]
    fn misses(&self, rays: &Rays) -> Mask {
        let mirror = Mask::splat(self.mirrored);
        let (o, d, Rect { min, max }) = (rays.origin, rays.direction, self.domain);
        let (x, dx) = (o.x.negated_where(mirror), d.x.negated_where(mirror));
        let (mut near, mut far) = (Lanes::splat(0.0), Lanes::splat(f64::INFINITY));
        for (o, d, low, high) in
            [(x, dx, min.x, max.x), (o.y, d.y, min.y, max.y), (o.z, d.z, self.heights[0], self.heights[1])]
        {
            let (a, b) = ((Lanes::splat(low) - o) / d, (Lanes::splat(high) - o) / d);
            (near, far) = (a.min(b).max(near), a.max(b).min(far));
        }
        // Of a ray along a slab nothing is said: it may lie on its border.
        let zero = Lanes::splat(0.0);
        far.lt(near) & zero.lt(dx.abs()) & zero.lt(d.y.abs()) & zero.lt(d.z.abs())
    }
}

/// The rays behind a surface, met at `meetings`, with `eta` = n_in / n_out; false where refraction needs care.
#[inline(always)]
pub(super) fn pass(rays: &Rays, meetings: &Hits, eta: f64) -> (Rays, Mask) {
    let incoming = rays.direction;
    let along = meetings.normal.dot(incoming);
    let turned = Lanes::splat(0.0).lt(along);
    let n = meetings.normal;
    let normal = Vectors { x: n.x.negated_where(turned), y: n.y.negated_where(turned), z: n.z.negated_where(turned) };
    let eta_lanes = Lanes::splat(eta);
    let slowed = eta_lanes * along.abs();
    let excess = (eta - 1.0) * (eta + 1.0);
    let square = slowed * slowed - Lanes::splat(excess);
    // Near the critical angle the scalar code takes this difference more carefully; beyond it there is no ray.
    let clear = Lanes::splat(CAREFUL_BELOW * excess).le(square) & Lanes::splat(0.0).le(square);
    let gamma = Lanes::splat(excess) / (slowed + square.sqrt());
    let direction = incoming.times(eta_lanes).plus(normal.times(gamma));
    (Rays { origin: rays.at(meetings.t_mm), direction }, clear)
}

/// Both sides of a prism, left first, between media of unlike index.
#[derive(Debug, Clone, PartialEq)]
pub struct PackedBiprism<S> {
    /// From the world to the prism's frame and back; `None` where they are the same.
    pub poses: Option<[Pose; 2]>,
    /// Front and back of the left, then of the right side.
    pub sides: [[S; 2]; 2],
    /// n_outer / n_glass, then n_glass / n_outer.
    pub eta: [f64; 2],
    /// Whether each back bounds the glass of its own half only.
    pub solid: bool,
}

/// Rays behind the glass.
#[derive(Debug, Clone, Copy)]
pub struct Passed {
    /// In the world.
    pub rays: Rays,
    /// The rays in the glass, in the world; without glass the same.
    pub inside: Rays,
    /// Where they passed the right side.
    pub right: Mask,
    /// Lanes that did pass; nothing is said of the others.
    pub sure: Mask,
}

/// What a packet of rays passes on their way to the board.
pub trait Glass {
    /// The rays behind it, by solvers that stop at `residual_mm`.
    fn pass(&self, rays: &Rays, residual_mm: f64) -> Passed;
}

/// No glass: the image's own halves stand for the sides.
impl Glass for () {
    #[inline(always)]
    fn pass(&self, rays: &Rays, _: f64) -> Passed {
        Passed { rays: *rays, inside: *rays, right: Lanes::splat(0.0).le(rays.direction.x), sure: Mask::splat(true) }
    }
}

impl<S: PacketSurface> Glass for PackedBiprism<S> {
    #[inline(always)]
    fn pass(&self, rays: &Rays, residual_mm: f64) -> Passed {
        let own = match &self.poses {
            None => *rays,
            Some([_, prism_from_world]) => rays.moved(prism_from_world),
        };
        let (side, front) = self.first_facet(&own, residual_mm);
        let (inside, in_glass) = pass(&own, &front, self.eta[0]);
        let back = self.sides[side as usize][1].intersect(&inside, residual_mm);
        let (out, left_glass) = pass(&inside, &back, self.eta[1]);
        // What leaves a solid prism through the other half is left to the scalar kernel.
        let own_half = if self.solid {
            let right = Lanes::splat(0.0).le(inside.at(back.t_mm).x);
            if side == Side::Right { right } else { !right }
        } else {
            Mask::splat(true)
        };
        let in_world = |rays: Rays| match &self.poses {
            None => rays,
            Some([world_from_prism, _]) => rays.moved(world_from_prism),
        };
        Passed {
            rays: in_world(out),
            inside: in_world(inside),
            right: Mask::splat(side == Side::Right),
            sure: front.met & in_glass & back.met & left_glass & own_half,
        }
    }
}
