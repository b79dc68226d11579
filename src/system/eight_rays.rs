//! Rays of several places at once through prisms of triangles: eight of a part of a pixel behind one triangle of the front and one of
//! the back, and a packet in a row of pixels, each through its own.

use super::instrument::System;
use crate::geom::Ray;
use crate::num::simd::{Kernel, LANES, Lanes, widest};
use crate::prism::lanes::Rays;
use crate::prism::packed_triangles::PacketBehindTriangle;
use crate::prism::side::Side;
use glam::{DVec2, DVec3};

/// Of each of eight rays, how far within the sides of a triangle and on the half that its surface bounds it passed.
pub(crate) type EightWithin = [Lanes; 4];

impl System {
    /// [`System::behind_front`] of eight places, with the same bits.
    pub(crate) fn eight_behind_front(
        &self,
        px: &[DVec2; LANES],
        side: Side,
        triangle: u32,
    ) -> Option<(Rays, EightWithin)> {
        if let Some(behind) = widest(BehindFront { system: self, px, side, triangle }) {
            return Some((behind.rays, behind.within));
        }

        // Rays that need care are traced one by one.
        let nothing = Ray { origin: DVec3::ZERO, direction: DVec3::ZERO };
        let (mut rays, mut within) = ([nothing; LANES], [[0.0; 4]; LANES]);
        for k in 0..LANES {
            let behind = self.behind_front(px[k], side, triangle)?;
            (rays[k], within[k]) = (behind.ray, behind.within);
        }
        Some((Rays::packed(&rays), std::array::from_fn(|of| Lanes::of(|k| within[k][of]))))
    }

    /// [`System::seen_behind_back`] of eight rays, with the same bits: what they see along x and along y, and how far within.
    pub(crate) fn eight_behind_back(
        &self,
        inside: &Rays,
        side: Side,
        triangle: u32,
    ) -> Option<([Lanes; 2], EightWithin)> {
        if let Some(seen) = widest(BehindBack { system: self, inside, side, triangle }) {
            return Some(seen);
        }

        // Rays that need care are traced one by one.
        let (mut seen_mm, mut within) = ([DVec2::ZERO; LANES], [[0.0; 4]; LANES]);
        for k in 0..LANES {
            (seen_mm[k], within[k]) = self.seen_behind_back(&inside.lane(k), side, triangle)?;
        }
        let seen_mm = [Lanes::of(|k| seen_mm[k].x), Lanes::of(|k| seen_mm[k].y)];
        Some((seen_mm, std::array::from_fn(|of| Lanes::of(|k| within[k][of]))))
    }
}

/// What a packet of places sees of the board, in mm, by which side, and through which triangles of front and back.
pub(crate) type SeenThroughTriangles = ([Lanes; 2], Side, [[u32; LANES]; 2]);

impl System {
    /// What [`System::trace_with_parts`] tells of the places from `start` on to the right, one px apart, with the same bits; `None`
    /// where it is to be asked. The triangles of a place beside them, where they are known, lead to theirs.
    #[inline]
    pub(crate) fn trace_through_triangles(
        &self,
        start: DVec2,
        beside: Option<[u32; 2]>,
    ) -> Option<SeenThroughTriangles> {
        widest(ThroughTriangles { system: self, start, beside })
    }
}

struct ThroughTriangles<'a> {
    system: &'a System,
    start: DVec2,
    beside: Option<[u32; 2]>,
}

impl Kernel for ThroughTriangles<'_> {
    type Out = Option<SeenThroughTriangles>;

    #[inline(always)]
    fn run(self) -> Self::Out {
        let Self { system, start, beside } = self;
        let rays = system.camera().rays([Lanes::of(|k| start.x + k as f64), Lanes::splat(start.y)]);
        let passed = system.prism()?.packet_through_triangles(&rays, beside)?;
        let ([x, y], met) = system.board().intersect_all(&passed.rays);
        met.all().then_some(([x, y], passed.side, passed.triangles))
    }
}

struct BehindFront<'a> {
    system: &'a System,
    px: &'a [DVec2; LANES],
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
    type Out = Option<([Lanes; 2], EightWithin)>;

    #[inline(always)]
    fn run(self) -> Self::Out {
        let Self { system, inside, side, triangle } = self;
        let behind = system.prism()?.packet_behind_back(inside, side, triangle)?;
        let ([x, y], met) = system.board().intersect_all(&behind.rays);
        let endless = Lanes::splat(f64::INFINITY);
        (met & x.abs().lt(endless) & y.abs().lt(endless)).all().then_some(([x, y], behind.within))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prism::triangles::TrianglePair;
    use crate::scene::PrismSpec;
    use crate::surface::face::Face;
    use crate::surface::mesh::Normals;
    use glam::DVec3;

    /// The prism of triangles of the golden cases, with normals that differ from corner to corner of one of its faces.
    fn uneven(normals: Normals, face: Face) -> System {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cases/prism_mesh.toml");
        let mut scene = crate::scene::load(path.as_ref()).unwrap();
        let PrismSpec::Mesh(prism) = &mut scene.prism else { panic!("{:?}", scene.prism) };
        prism.normals = normals;
        let mesh = if face == Face::Front { &mut prism.front } else { &mut prism.back };
        for (k, normal) in mesh.point_normals.iter_mut().enumerate() {
            *normal = (*normal + 0.01 * DVec3::new(libm::sin(k as f64), libm::cos(k as f64), 0.0)).normalize();
        }
        crate::system::build(&scene).unwrap()
    }

    /// What a row sees, by packets and ray by ray, of meshes with normals that differ, and where it ends.
    #[test]
    fn a_row_is_as_its_single_rays() {
        for normals in [Normals::Flat, Normals::Smooth] {
            let system = uneven(normals, Face::Back);
            let mut packets = 0;
            for (j, i) in (0..60).flat_map(|j| (0..40).map(move |i| (j, i))) {
                // On whole numbers rays meet corners and sides of triangles.
                let start = DVec2::new(8.0 * f64::from(i), 3.0 * f64::from(j) + 0.25 * f64::from(j % 4));
                // A triangle beside it, and one that is not.
                let beside = system.triangles_at(start - DVec2::X).map(|pair| pair.triangles);
                for beside in [None, beside, Some([7, u32::MAX])] {
                    let Some(([x, y], side, triangles)) = system.trace_through_triangles(start, beside) else {
                        continue;
                    };
                    packets += 1;
                    for k in 0..LANES {
                        let (seen, parts) = system.trace_with_parts(start + DVec2::new(k as f64, 0.0));
                        let seen = seen.unwrap();
                        assert_eq!((seen.board_mm, seen.side), (DVec2::new(x.0[k], y.0[k]), side));
                        assert_eq!(parts.triangles, triangles.map(|of| of[k]), "{start}");
                    }
                }
            }
            println!("{packets} packets of 7200");
            assert!(packets > 3600, "{packets}");
        }
    }

    /// Packets have the bits of single rays, through one pair of triangles and through those around it, which they miss.
    #[test]
    fn eight_rays_are_eight_single_ones() {
        for normals in [Normals::Flat, Normals::Smooth] {
            let system = uneven(normals, Face::Front);
            let mut packets = 0;
            for k in 0..200 {
                let at =
                    DVec2::new((f64::from(k) * 0.754_877).fract() * 320.0, (f64::from(k) * 0.569_84).fract() * 180.0);
                let Some(pair) = system.triangles_at(at) else { continue };
                let px = std::array::from_fn(|k| at + 3.0 * DVec2::new((k % 3) as f64 - 1.0, (k / 3) as f64 - 1.0));
                packets += usize::from(is_as_single(&system, &px, pair));
            }
            assert!(packets > 150, "{packets}");
        }
    }

    /// Whether there are such rays; panics where they are not those of the scalar code.
    fn is_as_single(system: &System, px: &[DVec2; LANES], pair: TrianglePair) -> bool {
        let TrianglePair { side, triangles: [front, back] } = pair;
        let Some((inside, within)) = system.eight_behind_front(px, side, front) else { return false };
        let Some((seen_mm, behind)) = system.eight_behind_back(&inside, side, back) else { return false };
        let by_packet = widest(BehindFront { system, px, side, triangle: front }).is_some();
        for (k, px) in px.iter().enumerate() {
            let single = system.behind_front(*px, side, front).unwrap();
            assert_eq!((inside.lane(k), within.map(|of| of.0[k])), (single.ray, single.within));
            let seen = system.seen_behind_back(&single.ray, side, back).unwrap();
            assert_eq!((DVec2::from_array(seen_mm.map(|of| of.0[k])), behind.map(|of| of.0[k])), seen);
        }
        by_packet
    }
}
