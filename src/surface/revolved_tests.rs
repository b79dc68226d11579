//! Surfaces of revolution against closed forms, finite differences, and rays that graze or miss.

use super::*;
use crate::surface::shape::Surface;
use std::f64::consts::FRAC_PI_3;

const RESIDUAL_MM: f64 = 1e-12;

/// Numbers in [-1, 1], low in discrepancy.
fn even(k: usize, step: f64) -> f64 {
    2.0 * (k as f64 * step).fract() - 1.0
}

fn patch(axis: DVec3, ends: [f64; 2], rho: impl Fn(f64) -> f64) -> RevolvedPatch {
    let values: Vec<f64> = ChebyshevCurve::nodes(ends, 33).into_iter().map(rho).collect();
    RevolvedPatch {
        point_mm: DVec3::new(0.5, -1.0, 2.0),
        axis,
        profile: ChebyshevCurve::through(ends, &values, 1e-16),
        azimuth_rad: FRAC_PI_3,
    }
}

/// The k-th ray about the patch: from anywhere in a box of 12 mm about it, to a place near it.
fn ray(patch: &RevolvedPatch, k: usize) -> Ray {
    let point = |steps: [f64; 3], size: f64| DVec3::from_array(steps.map(|step| size * even(k, step)));
    let origin = patch.point_mm + point([0.754_877_666, 0.569_840_291, 0.438_579_021], 12.0);
    let target = patch.point_mm + point([0.819_172_513, 0.671_043_606, 0.549_700_477], 6.0);
    Ray { origin, direction: (target - origin).normalize() }
}

/// The roots t > 0 of |across|^2 = (a + b s)^2 along a ray, in rising order: a cone, or a cylinder where b is 0.
fn cone_roots(surface: &RevolvedSurface, ray: &Ray, a: f64, b: f64) -> Vec<f64> {
    let AxialRay { origin: o, direction: d } = surface.axial_ray(ray);
    let (r0, r1) = (a + b * o.x, b * d.x);
    let (qa, qb, qc) =
        (d.y * d.y + d.z * d.z - r1 * r1, o.y * d.y + o.z * d.z - r0 * r1, o.y * o.y + o.z * o.z - r0 * r0);
    let square = qb * qb - qa * qc;
    if square < 0.0 {
        return Vec::new();
    }
    let mut roots: Vec<f64> = [-1.0, 1.0].map(|sign| (-qb + sign * square.sqrt()) / qa).to_vec();
    roots.sort_by(f64::total_cmp);
    roots.retain(|t| *t > 0.0 && r0 + r1 * t > 0.0);
    roots
}

/// Of rays in all directions, from inside and outside, the first root within the part is found, and no other, whichever side the
/// surface is met from.
#[test]
fn cylinders_and_cones_are_met_at_the_first_root_of_their_quadratic() {
    for (a, b) in [(6.0, 0.0), (6.0, 0.3), (5.0, -0.7)] {
        let patch = patch(DVec3::new(1.0, 0.2, -0.4), [-4.0, 5.0], |s| a + b * s);
        for mirrored in [false, true] {
            let surface = RevolvedSurface::new(&patch, mirrored);
            let (mut met, mut missed, mut twice) = (0, 0, 0);
            for k in 0..4000 {
                let own = ray(&patch, k);
                let ray = Ray { origin: turned(own.origin, mirrored), direction: turned(own.direction, mirrored) };
                let axial = surface.axial_ray(&ray);
                let roots = cone_roots(&surface, &ray, a, b);
                let within: Vec<f64> = roots.iter().copied().filter(|t| surface.holds(&axial, *t)).collect();
                // Rays that graze, or meet the rim, to within a nanometre are another test's.
                let near_rim = |t: &f64| {
                    let p = axial.origin + axial.direction * *t;
                    let rims = [p.x + 4.0, 5.0 - p.x, surface.azimuth[2] * p.y - p.z.abs()];
                    rims.iter().any(|rim| rim.abs() < 1e-6)
                };
                if roots.iter().any(near_rim) || roots.windows(2).any(|t| t[1] - t[0] < 1e-3) {
                    continue;
                }
                twice += usize::from(within.len() == 2);
                match (surface.intersect(&ray, RESIDUAL_MM), within.first()) {
                    // Where a ray is nearly parallel to the surface a gap of 1e-12 mm is a longer way.
                    (Ok(hit), Some(t)) => {
                        met += 1;
                        assert!((hit.t_mm - t).abs() < 1e-9, "{a} {b} {k}: {} {t}", hit.t_mm);
                        let gap = surface.gap(&axial, hit.t_mm).value;
                        assert!(gap.abs() < RESIDUAL_MM, "{k}: {gap}");
                    }
                    (Err(Fate::Missed), None) => missed += 1,
                    (found, wanted) => panic!("{a} {b} {k}: {found:?} {wanted:?}"),
                }
            }
            assert!(met > 400 && missed > 400 && twice > 20, "{met} {missed} {twice}");
        }
    }
}

/// Rays at right angles to the radius, by a micrometre below and above the surface: the first crossing of two, or none.
#[test]
fn grazing_rays_cross_or_miss() {
    let patch = patch(DVec3::X, [-4.0, 4.0], |s| (64.0 - s * s).sqrt());
    let surface = RevolvedSurface::new(&patch, false);
    for k in 0..500 {
        let (turn, lean) = (0.8 * even(k, 0.754_877_666), 0.3 * even(k, 0.569_840_291));
        let height = [-1e-6, -1e-8, 1e-8, 1e-6][k % 4];
        let radial = DVec3::new(libm::sin(lean), libm::cos(lean) * libm::sin(turn), libm::cos(lean) * libm::cos(turn));
        let direction = radial.any_orthonormal_vector();
        let middle = patch.point_mm + radial * (8.0 + height);
        let ray = Ray { origin: middle - direction * 20.0, direction };
        match surface.intersect(&ray, RESIDUAL_MM) {
            Ok(hit) => {
                assert!(height < 0.0, "{k}: met {height} mm above");
                // The chord at a depth h of a sphere of 8 mm, to what the series of degree 32 and rounding leave of h.
                let half = (-height * 16.0).sqrt();
                let depth_error = 1e-13;
                assert!((hit.t_mm - (20.0 - half)).abs() < depth_error * 16.0 / half + 1e-6 * half, "{k}");
                assert!(hit.normal.dot(direction) < 0.0 || hit.normal.dot(radial) > 0.0);
            }
            Err(fate) => assert!(fate == Fate::Missed && height > 0.0, "{k}: {fate:?} {height}"),
        }
    }
}

/// Along the axis a wavy profile is crossed many times.
#[test]
fn the_first_of_many_crossings_is_met() {
    let patch = patch(DVec3::X, [-1.0, 1.0], |s| 10.0 + 0.1 * libm::cos(12.0 * s));
    let surface = RevolvedSurface::new(&patch, false);
    for k in 0..40 {
        let height = 10.0 + 0.09 * even(k, 0.754_877_666);
        let origin = patch.point_mm + DVec3::new(-3.0, 0.0, height);
        let hit = surface.intersect(&Ray { origin, direction: DVec3::X }, RESIDUAL_MM).expect("it crosses");
        // From -1 on the phase runs from 12 back to 0; cos 12 = 0.84.
        let want = libm::acos((height - 10.0) / 0.1);
        let phases = [std::f64::consts::TAU + want, 2.0 * std::f64::consts::TAU - want];
        let first = phases.into_iter().filter(|phase| *phase <= 12.0).fold(0.0, f64::max);
        // The series of degree 32 of a cosine over 24 rad leaves J_33(12) = 1e-10 of its 0.1 mm, and waves have slopes of 0.5 and more.
        assert!((hit.t_mm - (3.0 - first / 12.0)).abs() < 1e-9, "{k}: {} {}", hit.t_mm, 3.0 - first / 12.0);
    }
}

/// Rays through random points of a bent cone that are said to cross it once do, by the gap in many places on their way; among them are many
/// that go too fast along the axis for one that rises as steeply as this one falls.
#[test]
fn what_is_said_to_be_crossed_once_is() {
    let patch = patch(DVec3::X, [-1.0, 1.0], |s| 10.0 - 0.5 * s + 0.1 * s * s);
    let surface = RevolvedSurface::new(&patch, false);
    let steepest = 0.7;
    let [sin, cos, _] = surface.azimuth();
    let (mut told, mut falling) = ([[0; 3]; 2], 0);
    for k in 0..1000 {
        let [s, azimuth] = [even(k, 0.754_877_666), 0.9 * FRAC_PI_3 * even(k, 0.569_840_291)];
        let rho = patch.profile.gradient(s)[0];
        let at = DVec3::new(s, rho * libm::cos(azimuth), rho * libm::sin(azimuth));
        let direction = DVec3::new(1.0, even(k, 0.819_172_513), 0.3 * even(k, 0.671_043_606)).normalize();
        let ray = AxialRay { origin: at - 5.0 * direction, direction };

        // Count the crossings where the ray is within the part.
        let gaps = (1..2500).map(|i| 4e-3 * f64::from(i)).filter(|t| surface.holds(&ray, *t));
        let signs: Vec<bool> = gaps.map(|t| surface.gap(&ray, t).value < 0.0).collect();
        let crossings = signs.windows(2).filter(|pair| pair[0] != pair[1]).count();
        let once = surface.is_crossed_once(direction);
        told[usize::from(once)][crossings.min(2)] += 1;
        let towards = cos * direction.y.abs() - sin * direction.z.abs();
        falling += usize::from(once && steepest * direction.x.abs() >= towards);
    }
    assert!(told[1][2] == 0 && told[1][1] > 100 && told[0][2] > 20 && falling > 20, "{told:?} {falling}");
}

/// Normals are at right angles to the surface, and turn as their differences say; heights have the derivatives of theirs.
#[test]
fn normals_and_heights_are_those_of_the_surface() {
    let patch = patch(DVec3::new(1.0, 0.1, 0.5), [-4.0, 4.0], |s| 9.0 + 0.2 * s + 0.03 * s * s - 0.002 * s * s * s);
    for mirrored in [false, true] {
        let surface = Surface::Revolved(Box::new(RevolvedSurface::new(&patch, mirrored)));
        let centre = turned(RevolvedSurface::new(&patch, false).point_of_profile(0.0), mirrored);
        let (h, mut met) = (1e-4, 0);
        for k in 0..40 {
            let (x, y) = (centre.x + 1.5 * even(k, 0.754_877_666), centre.y + 3.0 * even(k, 0.569_840_291));
            let Some(jet) = surface.jet(x, y) else { continue };
            met += 1;
            let at = |dx: f64, dy: f64| surface.jet(x + dx, y + dy).expect("it is wide");
            // Central differences: third derivatives of 0.05/mm^2 times h^2 / 6, and rounding of 1e-14 / h.
            let found = [jet.dx, jet.dy, jet.dxx, jet.dxy, jet.dyy];
            let differences = [
                (at(h, 0.0).value - at(-h, 0.0).value) / (2.0 * h),
                (at(0.0, h).value - at(0.0, -h).value) / (2.0 * h),
                (at(h, 0.0).dx - at(-h, 0.0).dx) / (2.0 * h),
                (at(0.0, h).dx - at(0.0, -h).dx) / (2.0 * h),
                (at(0.0, h).dy - at(0.0, -h).dy) / (2.0 * h),
            ];
            for (a, b) in found.iter().zip(differences) {
                assert!((a - b).abs() < 1e-8, "{k}: {found:?} {differences:?}");
            }
            let below = |dx: f64, dy: f64| {
                let ray = Ray { origin: DVec3::new(x + dx, y + dy, 0.0), direction: DVec3::Z };
                let hit = surface.intersect(&ray, RESIDUAL_MM).expect("it is there");
                (ray.at(hit.t_mm), hit)
            };
            let (point, hit) = below(0.0, 0.0);
            let gradient = DVec3::new(-jet.dx, -jet.dy, 1.0).normalize();
            assert!((hit.normal - gradient * hit.normal.dot(gradient).signum()).length() < 1e-12, "{k}");
            let ((ahead, after), (behind, before)) = (below(0.6 * h, -0.8 * h), below(-0.6 * h, 0.8 * h));
            for sign in [1.0, -1.0] {
                let turn = surface.normal_change(&hit, point, hit.normal * sign, ahead - behind);
                let wanted = (after.normal - before.normal) * sign;
                assert!((turn - wanted).length() < 1e-11, "{k}: {turn} {wanted}");
            }
        }
        assert!(met > 30, "{met}");
    }
}
