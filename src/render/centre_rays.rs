//! The centre tracer: traces the centre rays of a run of pixels, or those of any places, to the board, by packets where the glass allows.

use super::film::Class;
use crate::geom::Ray;
use crate::num::poly2::Poly2;
use crate::num::simd::{Kernel, LANES, Lanes, widest};
use crate::prism::packed_revolved::PackedRevolved;
use crate::prism::packet::{Glass, PackedBiprism, PackedPolynomial, Passed, Plane, Polynomial, Table};
use crate::surface::shape::{PolynomialSurface, Surface};
use crate::system::{BoardHit, Prism, Side, System};
use glam::DVec2;

/// What a run of positions sees: board positions in mm, and classes; (0, 0) where the class is no side.
#[derive(Debug)]
pub(super) struct Run<'a> {
    pub(super) x_mm: &'a mut [f64],
    pub(super) y_mm: &'a mut [f64],
    pub(super) class: &'a mut [Class],
}

/// The glass of a system, laid out for the loops.
#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "there is one for a whole picture, and a box would cost the loops a jump")]
enum GlassLayout {
    /// One ray at a time.
    Scalar,
    Nothing,
    Planes(PackedBiprism<Plane>),
    Even5(PackedBiprism<PackedPolynomial<Table<6, true>>>),
    Even8(PackedBiprism<PackedPolynomial<Table<9, true>>>),
    Full5(PackedBiprism<PackedPolynomial<Table<6, false>>>),
    AnyDegree(PackedBiprism<PackedPolynomial<Poly2>>),
    Revolved(PackedBiprism<PackedRevolved>),
}

/// Traces the centre rays of rows of an instrument's picture.
#[derive(Debug)]
pub(super) struct CentreTracer<'a> {
    system: &'a System,
    layout: GlassLayout,
}

impl<'a> CentreTracer<'a> {
    /// By packets of rays where `packets`, else ray by ray: the bits are the same.
    pub(super) fn new(system: &'a System, packets: bool) -> Self {
        let layout = match system.prism() {
            // Packets know neither stops nor the halves of a camera whose rays are parallel, or that sees by a calibration.
            _ if !packets || system.stop().is_some() => GlassLayout::Scalar,
            None if system.camera().tangent_per_px().is_none() || !system.camera().is_plain() => GlassLayout::Scalar,
            None => GlassLayout::Nothing,
            Some(prism) => layout(prism),
        };
        Self { system, layout }
    }

    /// What `start` and the positions to its right see, one px apart, for as many as `out` holds.
    pub(super) fn trace(&self, start: DVec2, out: Run<'_>) {
        self.trace_places(Places::Row(start), out, None);
    }

    /// What places see, in mm, which all are to see by one class; `None` where one does not. `rays` counts those up to that one.
    pub(super) fn of_class(&self, class: Class, places: &[DVec2], rays: &mut u64) -> Option<Vec<DVec2>> {
        let mut seen_mm = Vec::with_capacity(places.len());
        for few in places.chunks(LANES) {
            let (mut x_mm, mut y_mm, mut own) = ([0.0; LANES], [0.0; LANES], [class; LANES]);
            let n = few.len();
            let out = Run { x_mm: &mut x_mm[..n], y_mm: &mut y_mm[..n], class: &mut own[..n] };
            self.trace_places(Places::Any(few), out, None);
            if let Some(k) = own[..n].iter().position(|own| *own != class) {
                *rays += k as u64 + 1;
                return None;
            }
            *rays += n as u64;
            seen_mm.extend((0..n).map(|k| DVec2::new(x_mm[k], y_mm[k])));
        }
        Some(seen_mm)
    }

    /// The instrument.
    pub(super) fn system(&self) -> &'a System {
        self.system
    }

    /// What places see, and the last packet of their ways through glass.
    fn trace_places(&self, places: Places<'_>, out: Run<'_>, way: Option<&mut Option<Passed>>) {
        let system = self.system;
        match &self.layout {
            GlassLayout::Scalar => {
                for i in 0..out.class.len() {
                    let (board_mm, class) = trace_scalar(system, places.at(i));
                    (out.x_mm[i], out.y_mm[i], out.class[i]) = (board_mm.x, board_mm.y, class);
                }
            }
            GlassLayout::Nothing => widest(PlacesTrace { system, glass: &(), places, out, way: None }),
            GlassLayout::Planes(glass) => widest(PlacesTrace { system, glass, places, out, way }),
            GlassLayout::Even5(glass) => widest(PlacesTrace { system, glass, places, out, way }),
            GlassLayout::Even8(glass) => widest(PlacesTrace { system, glass, places, out, way }),
            GlassLayout::Full5(glass) => widest(PlacesTrace { system, glass, places, out, way }),
            GlassLayout::AnyDegree(glass) => widest(PlacesTrace { system, glass, places, out, way }),
            GlassLayout::Revolved(glass) => widest(PlacesTrace { system, glass, places, out, way }),
        }
    }
}

/// Places that are traced.
#[derive(Clone, Copy)]
enum Places<'a> {
    /// From this one on to the right, one px apart.
    Row(DVec2),
    /// These, of which the last stands for those beyond.
    Any(&'a [DVec2]),
}

impl Places<'_> {
    #[inline(always)]
    fn at(&self, i: usize) -> DVec2 {
        match self {
            Self::Row(start) => DVec2::new(start.x + i as f64, start.y),
            Self::Any(places) => places[i.min(places.len() - 1)],
        }
    }

    /// A packet from number `first` on.
    #[inline(always)]
    fn packet(&self, first: usize) -> [Lanes; 2] {
        match self {
            Self::Row(start) => [Lanes::of(|k| start.x + (first + k) as f64), Lanes::splat(start.y)],
            Self::Any(_) => [Lanes::of(|k| self.at(first + k).x), Lanes::of(|k| self.at(first + k).y)],
        }
    }
}

/// The way of a ray through the glass to the board.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WayToBoard {
    /// The ray in the glass, from where it met the front, in the world.
    pub inside: Ray,
    /// The ray behind the glass, from where it left the back, in the world.
    pub behind: Ray,
    /// Where it meets the plane of the board.
    pub hit: BoardHit,
}

/// Traces ways through the glass by packets, with the bits of [`System::path`] and [`System::trace`].
#[derive(Debug)]
pub struct WayTracer<'a>(CentreTracer<'a>);

impl<'a> WayTracer<'a> {
    /// Through the glass of `system`.
    pub fn new(system: &'a System) -> Self {
        Self(CentreTracer::new(system, true))
    }

    /// The ways of the rays of as many places as there are lanes; `None` of each of which single rays are to tell.
    pub fn trace(&self, places: &[DVec2; LANES]) -> [Option<WayToBoard>; LANES] {
        let (mut x_mm, mut y_mm, mut class) = ([0.0; LANES], [0.0; LANES], [Class::Missed; LANES]);
        let mut way = None;
        let out = Run { x_mm: &mut x_mm, y_mm: &mut y_mm, class: &mut class };
        self.0.trace_places(Places::Any(places), out, Some(&mut way));
        let Some(Passed { rays, inside, sure, .. }) = way else { return [None; LANES] };
        std::array::from_fn(|k| {
            let hit = BoardHit { board_mm: DVec2::new(x_mm[k], y_mm[k]), side: class[k].side()? };
            (sure.0[k] != 0).then(|| WayToBoard { inside: inside.lane(k), behind: rays.lane(k), hit })
        })
    }
}

/// The tightest layout that holds the prism.
fn layout(prism: &Prism) -> GlassLayout {
    // What each surface is packed as, if it is of that kind.
    fn plane(surface: &Surface) -> Option<Plane> {
        match *surface {
            Surface::Plane { point, normal } => Some(Plane { point, normal }),
            _ => None,
        }
    }
    fn revolved(surface: &Surface) -> Option<PackedRevolved> {
        match surface {
            Surface::Revolved(part) => Some(PackedRevolved::new(part)),
            _ => None,
        }
    }
    fn sheets<P: Polynomial>(
        prism: &Prism,
        table: fn(&Poly2) -> Option<P>,
    ) -> Option<PackedBiprism<PackedPolynomial<P>>> {
        let sheet = |f: &PolynomialSurface| Some(PackedPolynomial::new(f, table(f.sag())?));
        prism.for_packets(|surface| match surface {
            Surface::Freeform(f) => sheet(f),
            _ => None,
        })
    }

    // Take the first that holds all four.
    (prism.for_packets(plane).map(GlassLayout::Planes))
        .or_else(|| sheets(prism, Table::new).map(GlassLayout::Even5))
        .or_else(|| sheets(prism, Table::new).map(GlassLayout::Full5))
        .or_else(|| sheets(prism, Table::new).map(GlassLayout::Even8))
        .or_else(|| sheets(prism, |p| Some(p.clone())).map(GlassLayout::AnyDegree))
        .or_else(|| prism.for_packets(revolved).map(GlassLayout::Revolved))
        .unwrap_or(GlassLayout::Scalar)
}

/// One position by the scalar trace.
pub(super) fn trace_scalar(system: &System, px: DVec2) -> (DVec2, Class) {
    match system.trace(px) {
        Ok(BoardHit { board_mm, side }) => (board_mm, side.into()),
        Err(fate) => (DVec2::ZERO, fate.into()),
    }
}

struct PlacesTrace<'a, 'b, G> {
    system: &'a System,
    glass: &'a G,
    places: Places<'a>,
    out: Run<'b>,
    /// What becomes of the last packet, of which only those are sure that meet the board.
    way: Option<&'b mut Option<Passed>>,
}

impl<G: Glass> Kernel for PlacesTrace<'_, '_, G> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let Self { system, glass, places, out, mut way } = self;
        // A copy, of which the compiler knows that no row written here changes its kind.
        let camera = system.camera();
        let residual_mm = system.accuracy().surface_residual_mm;
        let count = out.class.len();

        // Trace a packet of centre rays through the glass to the board.
        for first in (0..count).step_by(LANES) {
            let [x, y] = places.packet(first);
            let passed = glass.pass(&camera.rays([x, y]), residual_mm);
            let (seen, met) = system.board().intersect_all(&passed.rays);
            let sure = passed.sure & met;
            if let Some(way) = &mut way {
                **way = Some(Passed { sure, ..passed });
            }

            // Store its board points and sides.
            let n = LANES.min(count - first);
            let side = passed.right.0.map(|right| if right != 0 { Class::Right } else { Class::Left });
            if n == LANES {
                out.x_mm[first..first + LANES].copy_from_slice(&seen[0].0);
                out.y_mm[first..first + LANES].copy_from_slice(&seen[1].0);
                out.class[first..first + LANES].copy_from_slice(&side);
            } else {
                out.x_mm[first..].copy_from_slice(&seen[0].0[..n]);
                out.y_mm[first..].copy_from_slice(&seen[1].0[..n]);
                out.class[first..].copy_from_slice(&side[..n]);
            }

            // Trace the rays again, one by one, whose packet could not decide their end.
            if !sure.all() {
                for k in (0..n).filter(|&k| sure.0[k] == 0) {
                    let (board_mm, class) = trace_scalar(system, DVec2::new(x.0[k], y.0[k]));
                    let i = first + k;
                    (out.x_mm[i], out.y_mm[i], out.class[i]) = (board_mm.x, board_mm.y, class);
                }
            }
        }
    }
}

impl From<Side> for Class {
    fn from(side: Side) -> Self {
        match side {
            Side::Left => Self::Left,
            Side::Right => Self::Right,
        }
    }
}
