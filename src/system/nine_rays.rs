//! Nine rays of a part of a pixel at once, behind one triangle of the front and one of the back.

use super::instrument::System;
use crate::geom::Ray;
use crate::num::simd::{Kernel, LANES, Lanes, widest};
use crate::prism::lanes::{Rays, Vectors};
use crate::prism::packed_triangles::PacketBehindTriangle;
use crate::prism::side::Side;
use glam::{DVec2, DVec3};

/// Nine rays: a packet, and the one that it leaves over.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NineRays {
    packet: Rays,
    last: Ray,
}

/// Of each of nine rays, how far within the sides of a triangle and on the half that its surface bounds it passed.
pub(crate) type NineWithin = [[f64; NINE]; 4];

const NINE: usize = LANES + 1;

impl System {
    /// [`System::behind_front`] of nine places, with the same bits.
    pub(crate) fn nine_behind_front(
        &self,
        px: &[DVec2; NINE],
        side: Side,
        triangle: u32,
    ) -> Option<(NineRays, NineWithin)> {
        let last = self.behind_front(px[LANES], side, triangle)?;
        if let Some(behind) = widest(BehindFront { system: self, px, side, triangle }) {
            return Some((NineRays { packet: behind.rays, last: last.ray }, nine(behind.within, last.within)));
        }

        // Rays that need care are traced one by one.
        let mut rays = [last.ray; LANES];
        let mut within = [last.within; LANES];
        for k in 0..LANES {
            let behind = self.behind_front(px[k], side, triangle)?;
            (rays[k], within[k]) = (behind.ray, behind.within);
        }
        let within = std::array::from_fn(|of| Lanes::of(|k| within[k][of]));
        Some((NineRays { packet: packed(&rays), last: last.ray }, nine(within, last.within)))
    }

    /// [`System::seen_behind_back`] of nine rays, with the same bits.
    pub(crate) fn nine_behind_back(
        &self,
        inside: &NineRays,
        side: Side,
        triangle: u32,
    ) -> Option<([DVec2; NINE], NineWithin)> {
        let (last_mm, last_within) = self.seen_behind_back(&inside.last, side, triangle)?;
        if let Some(([x, y], within)) = widest(BehindBack { system: self, inside: &inside.packet, side, triangle }) {
            let seen_mm = |k: usize| if k < LANES { DVec2::new(x.0[k], y.0[k]) } else { last_mm };
            return Some((std::array::from_fn(seen_mm), nine(within, last_within)));
        }

        // Rays that need care are traced one by one.
        let mut seen_mm = [last_mm; NINE];
        let mut within = [last_within; LANES];
        for (k, seen_mm) in seen_mm.iter_mut().take(LANES).enumerate() {
            (*seen_mm, within[k]) = self.seen_behind_back(&lane(&inside.packet, k), side, triangle)?;
        }
        Some((seen_mm, nine(std::array::from_fn(|of| Lanes::of(|k| within[k][of])), last_within)))
    }
}

/// The values of a packet and of the last ray.
#[inline(always)]
fn nine(packet: [Lanes; 4], last: [f64; 4]) -> NineWithin {
    std::array::from_fn(|of| std::array::from_fn(|k| if k < LANES { packet[of].0[k] } else { last[of] }))
}

fn packed(rays: &[Ray; LANES]) -> Rays {
    let vectors = |of: fn(&Ray) -> DVec3| Vectors {
        x: Lanes::of(|k| of(&rays[k]).x),
        y: Lanes::of(|k| of(&rays[k]).y),
        z: Lanes::of(|k| of(&rays[k]).z),
    };
    Rays { origin: vectors(|ray| ray.origin), direction: vectors(|ray| ray.direction) }
}

fn lane(rays: &Rays, k: usize) -> Ray {
    let vector = |v: &Vectors| DVec3::new(v.x.0[k], v.y.0[k], v.z.0[k]);
    Ray { origin: vector(&rays.origin), direction: vector(&rays.direction) }
}

struct BehindFront<'a> {
    system: &'a System,
    px: &'a [DVec2; NINE],
    side: Side,
    triangle: u32,
}

impl Kernel for BehindFront<'_> {
    type Out = Option<PacketBehindTriangle>;

    #[inline(always)]
    fn run(self) -> Self::Out {
        let Self { system, px, side, triangle } = self;
        let rays = system.camera().rays([Lanes::of(|k| px[k].x), Lanes::of(|k| px[k].y)]);
        let behind = system.prism()?.packet_behind_front(&rays, side, triangle)?;
        Some(PacketBehindTriangle { within: behind.within.map(|value| value / rays.direction.z), ..behind })
    }
}

struct BehindBack<'a> {
    system: &'a System,
    inside: &'a Rays,
    side: Side,
    triangle: u32,
}

impl Kernel for BehindBack<'_> {
    /// What they see of the board, in mm, and how far within they passed.
    type Out = Option<([Lanes; 2], [Lanes; 4])>;

    #[inline(always)]
    fn run(self) -> Self::Out {
        let Self { system, inside, side, triangle } = self;
        let behind = system.prism()?.packet_behind_back(inside, side, triangle)?;
        let ([x, y], met) = system.board().intersect_all(&behind.rays);
        let endless = Lanes::splat(f64::INFINITY);
        (met & x.abs().lt(endless) & y.abs().lt(endless)).all().then_some(([x, y], behind.within))
    }
}
