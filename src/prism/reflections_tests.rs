//! Closed forms of plates and wedges, and the laws of power.

use super::*;
use crate::geom::{Ray, Rect};
use crate::optics::fresnel::{Interface, Layer, Polarisation, left_after};
use crate::optics::polarisation::{Beam, PolarisationState};
use crate::prism::biprism::Prism;
use crate::prism::parity_tests::bent_sheets;
use crate::scene::GlassSpec;
use crate::surface::face::Face;
use crate::surface::mesh::{Mesh, Normals, Triangles};
use crate::surface::shape::Surface;
use glam::{DVec2, DVec3};
use proptest::prelude::*;
use std::sync::Arc;

const GLASS: GlassBody =
    GlassBody { n_outer: 1.0, n_glass: 1.48, layers: [None; 2], wavelength_nm: 550.0, absorption_per_mm: 0.0 };
const ALL: Limits = Limits { bounces: 80, least_power: 0.0 };

/// A biprism with its ridge at (0, 0, 80), 8 mm thick.
fn faces(facet_rad: f64) -> [[Surface; 2]; 2] {
    let (sin, cos) = libm::sincos(facet_rad);
    let facet = |s: f64| Surface::Plane { point: DVec3::new(0.0, 0.0, 80.0), normal: DVec3::new(-s * sin, 0.0, cos) };
    let back = Surface::Plane { point: DVec3::new(0.0, 0.0, 88.0), normal: DVec3::Z };
    [[facet(-1.0), back.clone()], [facet(1.0), back]]
}

fn prism(faces: &[[Surface; 2]; 2]) -> Prism {
    Prism::new(&GlassSpec::new(1.48, 1.0), faces.clone())
}

fn towards(x: f64, y: f64) -> Ray {
    Ray { origin: DVec3::ZERO, direction: DVec3::new(x, y, 80.0).normalize() }
}

fn exits(
    body: GlassBody,
    faces: &[[Surface; 2]; 2],
    ray: &Ray,
    light: PolarisationState,
    limits: Limits,
) -> (PowerBudget, Vec<Exit>) {
    let mut found = Vec::new();
    let start = Beam::new(ray.direction, light);
    let prism = prism(faces);
    let tracer = ReflectionTracer { prism: &prism, body, limits, residual_mm: 1e-12 };
    let account = tracer.trace(ray, start, &mut |exit| found.push(*exit));
    (account, found)
}

/// A plate of thickness 8: the k-th ghost has been reflected 2 k times, has the power T^2 R^2k, and is moved sideways by
/// 2 k T tan(r) along the plate (Born & Wolf, 7.6.1).
#[test]
fn ghosts_of_a_plate_have_their_closed_form() {
    let ray = towards(0.0, 30.0);
    let (account, found) = exits(GLASS, &faces(0.0), &ray, PolarisationState::X, ALL);
    let cos_in = ray.direction.z;
    // The plane of incidence is y-z, so that light along x is s.
    let shares = Interface::bare(1.0, 1.48).shares(Polarisation::S, cos_in);
    let (r, t) = (shares.reflected, shares.transmitted);
    let sin = (1.0 - cos_in * cos_in).sqrt() / 1.48;
    let tan = sin / (1.0 - sin * sin).sqrt();
    let through: Vec<&Exit> = found.iter().filter(|e| e.last.face == Face::Back).collect();
    for (k, exit) in through.iter().take(5).enumerate() {
        assert_eq!(exit.bounces, 2 * k as u32);
        let expected = t * t * libm::pow(r * r, k as f64);
        assert!((exit.power / expected - 1.0).abs() < 1e-13, "{k}: {} {expected}", exit.power);
        let y = 30.0 + 8.0 * tan * (2 * k + 1) as f64;
        assert!((exit.ray.origin - DVec3::new(0.0, y, 88.0)).length() < 1e-12);
        assert!((exit.ray.direction - ray.direction).length() < 1e-15);
    }
    // All of them, and all that is sent back: (1 - R) / (1 + R) and 2 R / (1 + R).
    let sum = |face: Face| -> f64 { found.iter().filter(|e| e.last.face == face).map(|e| e.power).sum() };
    assert!(
        (sum(Face::Back) - (1.0 - r) / (1.0 + r)).abs() < 1e-14
            && (sum(Face::Front) - 2.0 * r / (1.0 + r)).abs() < 1e-14
    );
    assert!((account.escaped - 1.0).abs() < 1e-14 && account.dropped < 1e-100);
}

/// An absorbing plate met along its normal: A = (1 - R) (1 - e) / (1 - R e), with e left after one way.
#[test]
fn an_absorbing_plate_has_its_closed_form() {
    let body = GlassBody { absorption_per_mm: 0.05, ..GLASS };
    let ray = towards(0.0, 0.0);
    let (account, _) = exits(body, &faces(0.0), &ray, PolarisationState::Unpolarised, ALL);
    let (r, e): (f64, f64) = ((0.48f64 / 2.48) * (0.48 / 2.48), left_after(0.05, 8.0));
    assert!((account.absorbed - (1.0 - r) * (1.0 - e) / (1.0 - r * e)).abs() < 1e-14);
    let back = r + (1.0 - r) * (1.0 - r) * r * e * e / (1.0 - r * r * e * e);
    let through = (1.0 - r) * (1.0 - r) * e / (1.0 - r * r * e * e);
    assert!((account.escaped - back - through).abs() < 1e-14);
}

/// The first ghost of a wedge: two reflections in mirrors at the angle a turn the light by 2 a inside the glass, and
/// Snell's law at the back makes that the angle of emergence.
#[test]
fn the_ghost_of_a_wedge_is_turned_by_twice_its_angle() {
    let a = 0.1545;
    let (_, found) = exits(GLASS, &faces(a), &towards(4.0, 0.0), PolarisationState::Y, Limits { bounces: 2, ..ALL });
    let through: Vec<&Exit> = found.iter().filter(|e| e.last.face == Face::Back).collect();
    let inner = |exit: &Exit| libm::asin(exit.ray.direction.x / 1.48);
    assert_eq!(through.iter().map(|e| e.bounces).collect::<Vec<_>>(), [0, 2]);
    // The right facet rises with x: its normal leans towards -x, and so does the ghost.
    assert!((inner(through[0]) - inner(through[1]) - 2.0 * a).abs() < 1e-14);
}

/// Beyond the critical angle nothing gets through, nothing is lost, and the light goes on inside.
#[test]
fn total_reflection_keeps_the_power() {
    // Steep facets turn the light so far that the back reflects it whole.
    let body = GlassBody { n_glass: 1.9, ..GLASS };
    let (account, found) = exits(body, &faces(1.2), &towards(1.0, 0.5), PolarisationState::Unpolarised, ALL);
    assert!(
        found.iter().all(|e| !(e.last.face == Face::Back && e.bounces == 0)),
        "the first meeting with the back is total"
    );
    assert!((account.escaped + account.absorbed + account.dropped - 1.0).abs() < 1e-13);
    assert!(account.escaped > 1.0 - 1e-12, "it finds its way out: {account:?}");
}

#[test]
fn limits_give_up_light_and_say_how_much() {
    let faces = faces(0.15);
    let ray = towards(5.0, 1.0);
    let (none, found) =
        exits(GLASS, &faces, &ray, PolarisationState::Unpolarised, Limits { bounces: 0, least_power: 0.0 });
    assert_eq!(found.len(), 1, "only the light that is never reflected");
    assert!((none.escaped - found[0].power).abs() < 1e-16 && (none.escaped + none.dropped - 1.0).abs() < 1e-15);
    let (few, kept) =
        exits(GLASS, &faces, &ray, PolarisationState::Unpolarised, Limits { bounces: 80, least_power: 1e-4 });
    assert!(kept.iter().all(|e| e.power >= 1e-4) && few.dropped > 0.0 && few.dropped < 1e-3);
}

/// At the ridge and beside it, of a wedge and of a groove, all light that comes back to a facet meets one.
#[test]
fn no_light_slips_through_the_ridge() {
    for angle in [0.15, -0.15, 0.6] {
        for x in [0.0, 1e-16, -1e-16, 1e-13, -1e-13, 0.2, -0.2] {
            let (account, found) = exits(GLASS, &faces(angle), &towards(x, 0.3), PolarisationState::Unpolarised, ALL);
            // A wedge lets go of all light: 80 reflections of 15 % or less are left. A groove widens, and may trap what it
            // has reflected twice, by 5 % or less each time.
            let bound = if angle > 0.0 { 1e-60 } else { 2.5e-3 };
            assert!(account.dropped < bound, "{angle} {x}: {account:?}");
            for exit in found.iter().filter(|e| e.last.face == Face::Front) {
                let p = exit.ray.origin;
                assert!((p.z - 80.0 - p.x.abs() * libm::tan(angle)).abs() < 1e-12, "{angle} {x}: {p} is on no facet");
            }
        }
    }
}

/// Tessellated planes are planes: the same light leaves at the same places, the nearest face found by a hierarchy.
#[test]
fn a_mesh_of_planes_gives_the_light_of_planes() {
    let exact = faces(0.1545);
    let domain = Rect { min: DVec2::new(-25.0, -25.0), max: DVec2::new(25.0, 25.0) };
    let meshes = exact.clone().map(|side| {
        side.map(|surface| {
            let Surface::Plane { point, normal } = surface else { unreachable!("all are planes") };
            let height =
                |x: f64, y: f64| (point.z - (normal.x * (x - point.x) + normal.y * (y - point.y)) / normal.z, normal);
            let mesh = Mesh::new(Triangles::over(domain, 17, height), Normals::Flat);
            Surface::Mesh { mesh: Arc::new(mesh), mirrored: false }
        })
    });
    let prism = prism(&meshes);
    let limits = Limits { bounces: 4, least_power: 1e-9 };
    let tracer = ReflectionTracer { prism: &prism, body: GLASS, limits, residual_mm: 1e-12 };
    let mut compared = 0;
    for k in 0..300 {
        let ray = towards(9.0 * libm::sin(1.7 * k as f64), 7.0 * libm::cos(0.9 * k as f64));
        let (account, wanted) = exits(GLASS, &exact, &ray, PolarisationState::Unpolarised, limits);
        let mut found = Vec::new();
        let start = Beam::new(ray.direction, PolarisationState::Unpolarised);
        let by_mesh = tracer.trace(&ray, start, &mut |exit| found.push(*exit));
        assert_eq!(found.len(), wanted.len(), "{ray:?}");
        for (a, b) in found.iter().zip(&wanted) {
            assert_eq!((a.bounces, a.last), (b.bounces, b.last));
            // Corners of triangles round to 1e-14 mm, over edges of 3 mm.
            assert!((a.ray.origin - b.ray.origin).length() < 1e-11 && (a.power - b.power).abs() < 1e-12);
            compared += 1;
        }
        assert!((by_mesh.dropped - account.dropped).abs() < 1e-12);
    }
    assert!(compared > 1500);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]

    /// escaped + absorbed + dropped = 1, whatever the glass, the coating, the shape and the limits, at the ridge and
    /// far from it.
    #[test]
    fn no_power_is_lost(
        (n_outer, n_glass) in (1.0..2.0f64, 1.0..3.0f64),
        angle in prop_oneof![Just(0.0), -1.2..1.2f64],
        (x, y) in (prop_oneof![Just(0.0), Just(1e-16), -1e-12..1e-12f64, -30.0..30.0f64], -30.0..30.0f64),
        absorption_per_mm in prop_oneof![Just(0.0), 0.0..0.3f64],
        layer in prop::option::of((1.0..2.5f64, 0.0..500.0f64)),
        (bounces, exponent) in (0..12u32, -12.0..-1.0f64),
        curved in any::<bool>(),
    ) {
        let layer = layer.map(|(index, thickness_nm)| Layer { index, thickness_nm });
        let body = GlassBody { n_outer, n_glass, layers: [layer; 2], wavelength_nm: 550.0, absorption_per_mm };
        let faces = if curved { bent_sheets() } else { faces(angle) };
        let limits = Limits { bounces, least_power: libm::pow(10.0, exponent) };
        let (account, found) = exits(body, &faces, &towards(x, y), PolarisationState::Unpolarised, limits);
        let PowerBudget { escaped, absorbed, dropped } = account;
        prop_assert!((escaped + absorbed + dropped - 1.0).abs() < 1e-12, "{account:?}");
        prop_assert!(escaped >= 0.0 && absorbed >= 0.0 && dropped >= 0.0);
        let sum: f64 = found.iter().map(|e| e.power).sum();
        prop_assert!((sum - escaped).abs() < 1e-14);
        for exit in &found {
            prop_assert!(exit.bounces <= bounces && exit.ray.direction.is_finite() && exit.ray.origin.is_finite());
        }
    }
}
