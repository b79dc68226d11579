//! The centre tracer: traces the centre rays of a run of pixels to the board, by packets where the glass allows.

use super::film::Class;
use crate::num::poly2::Poly2;
use crate::num::simd::{Kernel, LANES, Lanes, widest};
use crate::prism::packed_revolved::PackedRevolved;
use crate::prism::packet::{Glass, PackedBiprism, PackedPolynomial, Plane, Polynomial, Table};
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
        let system = self.system;
        match &self.layout {
            GlassLayout::Scalar => {
                for i in 0..out.class.len() {
                    let (board_mm, class) = trace_scalar(system, start + DVec2::new(i as f64, 0.0));
                    (out.x_mm[i], out.y_mm[i], out.class[i]) = (board_mm.x, board_mm.y, class);
                }
            }
            GlassLayout::Nothing => widest(RowTrace { system, glass: &(), start, out }),
            GlassLayout::Planes(glass) => widest(RowTrace { system, glass, start, out }),
            GlassLayout::Even5(glass) => widest(RowTrace { system, glass, start, out }),
            GlassLayout::Even8(glass) => widest(RowTrace { system, glass, start, out }),
            GlassLayout::Full5(glass) => widest(RowTrace { system, glass, start, out }),
            GlassLayout::AnyDegree(glass) => widest(RowTrace { system, glass, start, out }),
            GlassLayout::Revolved(glass) => widest(RowTrace { system, glass, start, out }),
        }
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

struct RowTrace<'a, 'b, G> {
    system: &'a System,
    glass: &'a G,
    start: DVec2,
    out: Run<'b>,
}

impl<G: Glass> Kernel for RowTrace<'_, '_, G> {
    type Out = ();

    #[inline(always)]
    fn run(self) {
        let Self { system, glass, start, out } = self;
        // A copy, of which the compiler knows that no row written here changes its kind.
        let camera = system.camera();
        let residual_mm = system.accuracy().surface_residual_mm;
        let y = Lanes::splat(start.y);
        let count = out.class.len();

        // Trace a packet of centre rays through the glass to the board.
        for first in (0..count).step_by(LANES) {
            let x = Lanes::of(|k| start.x + (first + k) as f64);
            let passed = glass.pass(&camera.rays([x, y]), residual_mm);
            let (seen, met) = system.board().intersect_all(&passed.rays);
            let sure = passed.sure & met;

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
                    let (board_mm, class) = trace_scalar(system, DVec2::new(x.0[k], start.y));
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
