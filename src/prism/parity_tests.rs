//! The kernels of the rule for which face a ray meets first, held against each other on rays near the ridge and far from it.

use super::biprism::Prism;
use super::lanes::Rays;
use super::packed_revolved::PackedRevolved;
use super::packet::{Glass, PackedPolynomial, Plane, Table};
use super::reflections::{GlassBody, Limits, ReflectionTracer};
use super::side::{PrismFace, Side};
use crate::geom::{Pose, Ray, Rect};
use crate::num::curve::ChebyshevCurve;
use crate::num::poly2::Poly2;
use crate::num::simd::LANES;
use crate::optics::polarisation::{Beam, PolarisationState};
use crate::scene::GlassSpec;
use crate::surface::face::Face;
use crate::surface::shape::{PolynomialPatch, PolynomialSurface, RevolvedPatch, RevolvedSurface, Surface};
use glam::{DVec2, DVec3};

/// What the solvers stop at, in mm.
const RESIDUAL_MM: f64 = 1e-12;
/// Packets of rays a prism.
const PACKETS: usize = 1200;

fn glass(tilt_rad: DVec3) -> GlassSpec {
    GlassSpec { world_from_prism: Pose::new(DVec3::new(0.3, -0.2, 1.5), tilt_rad), ..GlassSpec::new(1.48, 1.0) }
}

/// A biprism of planes with its ridge at (0, 0, 80), 8 mm thick; a groove where the angle is negative.
fn flat(glass: &GlassSpec, facet_rad: f64) -> Prism {
    let (sin, cos) = libm::sincos(facet_rad);
    let facet = |s: f64| Surface::Plane { point: DVec3::new(0.0, 0.0, 80.0), normal: DVec3::new(-s * sin, 0.0, cos) };
    let back = Surface::Plane { point: DVec3::new(0.0, 0.0, 88.0), normal: DVec3::Z };
    Prism::new(glass, [[facet(-1.0), back.clone()], [facet(1.0), back]])
}

/// The same with bent surfaces, each given beyond the ridge.
fn polynomial(glass: &GlassSpec) -> Prism {
    Prism::new(glass, bent_sheets())
}

/// Fronts and backs of both halves that bend, given beyond the ridge.
pub(super) fn bent_sheets() -> [[Surface; 2]; 2] {
    let domain = Rect { min: DVec2::new(-2.0, -15.0), max: DVec2::new(22.0, 15.0) };
    let sheet = |constant: f64, slope: f64, bend: f64| {
        let sag = Poly2::new(2, [0.0, 0.0], [1.0, 1.0], move |m, n| match (m, n) {
            (0, 0) => constant,
            (1, 0) => slope,
            (2, 0) | (0, 2) => bend,
            _ => 0.0,
        });
        PolynomialPatch { sag, domain }
    };
    [true, false].map(|mirrored| {
        [sheet(80.0, 0.15, 1e-3), sheet(88.0, 0.0, -7e-4)]
            .map(|patch| Surface::Freeform(PolynomialSurface::new(&patch, mirrored)))
    })
}

/// The same of surfaces of revolution about a line along x, given beyond the ridge.
fn revolved(glass: &GlassSpec) -> Prism {
    let part = |c: [f64; 4], mirrored: bool| {
        let profile = ChebyshevCurve::new([-2.0, 22.0], c.to_vec());
        let patch = RevolvedPatch { point_mm: DVec3::ZERO, axis: DVec3::X, profile, azimuth_rad: 0.12 };
        Surface::Revolved(Box::new(RevolvedSurface::new(&patch, mirrored)))
    };
    let sides =
        [true, false].map(|mirrored| [[81.5, 1.8, 0.05, 0.01], [88.2, 0.3, -0.1, 0.02]].map(|c| part(c, mirrored)));
    Prism::new(glass, sides)
}

/// The k-th ray (in the world), which aims at the front: every lane of a packet at one side, every fourth packet far from
/// the ridge, the others within a nanometre, within a few roundings, and at the ridge itself.
fn aimed(prism: &Prism, k: usize) -> Ray {
    let even = |step: f64| (k as f64 * step).fract();
    let packet = k / LANES;
    let reach_mm = [12.0, 1e-6, 1e-14, 0.0][packet % 4];
    let sign = if packet % 8 < 4 { 1.0 } else { -1.0 };
    let (x, y) = (sign * reach_mm * even(0.754_877_666), 20.0 * even(0.569_840_291) - 10.0);
    // From the axis, as a camera's rays, or from beside it, so that rays cross the plane of the ridge on their way.
    let aside = if packet % 16 < 8 { 0.0 } else { 12.0 * even(0.819_172_513) - 6.0 };
    let side = if x >= 0.0 { Side::Right } else { Side::Left };
    let target = DVec3::new(x, y, prism.surface(side, Face::Front).height_mm(x, y));
    let origin = DVec3::new(aside, 0.5, 0.0);
    let own = Ray { origin, direction: (target - origin).normalize() };
    prism.poses.map_or(own, |[world_from_prism, _]| own.moved(&world_from_prism))
}

/// Where light that is never reflected leaves the prism.
fn unreflected(prism: &Prism, ray: &Ray) -> Vec<(Ray, PrismFace)> {
    let [n_outer, n_glass] = prism.indices();
    let body = GlassBody { n_outer, n_glass, layers: [None; 2], wavelength_nm: 550.0, absorption_per_mm: 0.0 };
    let limits = Limits { bounces: 0, least_power: 0.0 };
    let tracer = ReflectionTracer { prism, body, limits, residual_mm: RESIDUAL_MM };
    let mut found = Vec::new();
    let start = Beam::new(ray.direction, PolarisationState::Unpolarised);
    tracer.trace(ray, start, &mut |exit| found.push((exit.ray, exit.last)));
    found
}

fn hold_against_each_other(name: &str, prism: &Prism, packets: &impl Glass) {
    let (mut passed, mut far, mut far_by_packet) = (0, 0, 0);
    for packet in 0..PACKETS {
        let rays: Vec<Ray> = (0..LANES).map(|i| aimed(prism, LANES * packet + i)).collect();
        let together = packets.pass(&Rays::packed(&rays), RESIDUAL_MM);
        for (i, ray) in rays.iter().enumerate() {
            let alone = prism.pass(ray, RESIDUAL_MM, &mut ());
            let wanted: Vec<(Ray, PrismFace)> =
                alone.iter().map(|&(out, side)| (out, PrismFace { side, face: Face::Back })).collect();
            let mut reached = unreflected(prism, ray);
            if prism.is_solid() {
                // Through the back of either side.
                reached.iter_mut().zip(&wanted).for_each(|(reached, wanted)| reached.1.side = wanted.1.side);
            }
            assert_eq!(reached, wanted, "{name} {packet} {i}: {ray:?}");
            let sure = together.sure.0[i] != 0;
            if sure {
                let side = if together.right.0[i] != 0 { Side::Right } else { Side::Left };
                assert_eq!(Ok((together.rays.lane(i), side)), alone, "{name} {packet} {i}: {ray:?}");
            }
            passed += usize::from(alone.is_ok());
            far += usize::from(packet % 4 == 0 && alone.is_ok());
            far_by_packet += usize::from(packet % 4 == 0 && sure);
        }
    }
    // The test would be empty if few rays passed, or the packets left most of them to the scalar kernel.
    assert!(passed * 10 > 9 * PACKETS * LANES, "{name}: {passed}");
    assert!(far_by_packet * 10 > 8 * far, "{name}: {far_by_packet} of {far}");
}

#[test]
fn all_kernels_meet_the_same_facet_first() {
    for (name, tilt_rad) in [("upright", DVec3::ZERO), ("tilted", DVec3::new(0.05, -0.03, 0.08))] {
        let glass = glass(tilt_rad);
        let plane = |surface: &Surface| match *surface {
            Surface::Plane { point, normal } => Some(Plane { point, normal }),
            _ => None,
        };
        for facet_rad in [0.1545, -0.1545] {
            let prism = flat(&glass, facet_rad);
            let packets = prism.for_packets(plane).expect("planes go in packets");
            hold_against_each_other(&format!("{name}, flat, {facet_rad}"), &prism, &packets);
        }
        for solid in [false, true] {
            let prism = revolved(&glass).with_solid(solid);
            assert_eq!(prism.is_solid(), solid);
            let packets = prism.for_packets(|surface| match surface {
                Surface::Revolved(part) => Some(PackedRevolved::new(part)),
                _ => None,
            });
            let packets = packets.expect("surfaces of revolution go in packets");
            hold_against_each_other(&format!("{name}, revolved, {solid}"), &prism, &packets);
        }
        for solid in [false, true] {
            let prism = polynomial(&glass).with_solid(solid);
            let packets = prism.for_packets(|surface| match surface {
                Surface::Freeform(sheet) => Some(PackedPolynomial::new(sheet, Table::<6, true>::new(sheet.sag())?)),
                _ => None,
            });
            hold_against_each_other(
                &format!("{name}, polynomial, {solid}"),
                &prism,
                &packets.expect("sheets go in packets"),
            );
        }
    }
}
