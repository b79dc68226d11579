use super::*;
use crate::geom::Pose;
use crate::metrics::noise::Noise;

const CENTRE: DVec3 = DVec3::new(6.0, -1.0, 12.0);

fn designed() -> Pinhole {
    Pinhole::parallel(CENTRE, 35.0, 0.0055, DVec2::new(480.0, 540.0))
}

fn pixels() -> impl Iterator<Item = DVec2> {
    (0..9).flat_map(|j| (0..9).map(move |i| DVec2::new(120.0 * f64::from(i), 135.0 * f64::from(j))))
}

/// What a camera whose centre lies at `centre` sees, its rays starting at z = 90 mm, as behind a prism.
fn bundle(centre: DVec3) -> Vec<PixelRay> {
    let ray = |image_px| {
        let direction = designed().at_depth(image_px, 1.0).normalize();
        Ray { origin: centre + direction * ((90.0 - centre.z) / direction.z), direction }
    };
    pixels().map(|image_px| PixelRay { image_px, ray: ray(image_px) }).collect()
}

fn rays(sightings: &[PixelRay]) -> Vec<Ray> {
    sightings.iter().map(|s| s.ray).collect()
}

#[test]
fn a_moved_centre_shifts_every_ideal_point_by_similar_triangles() {
    // A camera moved by (0.1, -0.2, 0): every line moves by that much, on any plane.
    let moved = bundle(CENTRE + DVec3::new(0.1, -0.2, 0.0));
    for z in [35.0, -35.0, 1000.0] {
        let d = on_plane(&designed(), &moved, z).unwrap();
        assert!((d.mm.mean - DVec2::new(0.1, -0.2)).length() < 1e-12);
        assert!((d.mm.mean_abs - DVec2::new(0.1, 0.2)).length() < 1e-12);
        assert!((d.px.rms / (d.mm.rms * 35.0 / z.abs() / 0.0055) - 1.0).abs() < 1e-12);
    }
    assert!(on_plane(&designed(), &bundle(CENTRE), 35.0).unwrap().px.max < 1e-10);
}

#[test]
fn planes_and_rays_without_an_answer_are_named() {
    let mut sightings = bundle(CENTRE);
    assert!(matches!(on_plane(&designed(), &sightings, 0.0), Err(Unmeasurable::Degenerate(_))));
    assert!(matches!(on_plane(&designed(), &[], 35.0), Err(Unmeasurable::TooFew { .. })));
    sightings[4].ray.direction = DVec3::X;
    assert_eq!(on_plane(&designed(), &sightings, 35.0), Err(Unmeasurable::Parallel { index: 4 }));
    sightings[4].ray.direction = DVec3::NAN;
    let reason = on_plane(&designed(), &sightings, 35.0);
    assert_eq!(reason, Err(Unmeasurable::NotFinite { what: "sighting", index: 4 }));
}

#[test]
fn the_common_point_of_a_pinhole_is_its_centre() {
    let found = common_point(&rays(&bundle(CENTRE))).unwrap();
    assert!((found.point_mm - CENTRE).length() < 1e-10, "{found:?}");
    assert!(found.misses.max_mm < 1e-11);
    let other = misses(&rays(&bundle(CENTRE)), CENTRE + DVec3::new(0.0, 0.0, 2.0)).unwrap();
    // The central ray runs along z, so its miss is 0; the corner's is 2 sin(angle).
    let corner = designed().at_depth(DVec2::ZERO, 1.0);
    assert!((other.max_mm - 2.0 * corner.truncate().length() / corner.length()).abs() < 1e-12);
}

#[test]
fn two_skew_lines_meet_half_way() {
    let x = Ray { origin: DVec3::new(-5.0, 0.0, 1.0), direction: DVec3::X };
    let y = Ray { origin: DVec3::new(0.0, 9.0, -1.0), direction: DVec3::Y };
    let found = common_point(&[x, y]).unwrap();
    assert!(found.point_mm.length() < 1e-14 && (found.misses.rms_mm - 1.0).abs() < 1e-14);
    let parallel = [x, Ray { origin: DVec3::Y, ..x }, Ray { origin: DVec3::Z, ..x }];
    assert!(matches!(common_point(&parallel), Err(Unmeasurable::Degenerate(_))));
    assert!(matches!(common_point(&[x]), Err(Unmeasurable::TooFew { found: 1, .. })));
    assert!(matches!(misses(&[], DVec3::ZERO), Err(Unmeasurable::TooFew { .. })));
}

#[test]
fn crossings_lie_where_the_bundle_meets_its_axis() {
    let axis = Ray { origin: CENTRE, direction: DVec3::Z };
    let crossings = axis_crossings(&rays(&bundle(CENTRE + DVec3::new(0.0, 0.0, 3.0))), &axis).unwrap();
    // The pixel at the principal point looks along the axis and has no crossing.
    assert_eq!((crossings.n, crossings.along_mm[40]), (80, None));
    assert!((crossings.along_mm[0].unwrap() - 3.0).abs() < 1e-10);
    assert!((crossings.mean_abs_mm - 3.0).abs() < 1e-10 && crossings.gap_rms_mm < 1e-11);
    // A line that passes 1 mm above the axis, 7 mm ahead of its origin.
    let skew = Ray { origin: CENTRE + DVec3::new(-4.0, 1.0, 3.0), direction: DVec3::new(1.0, 0.0, 1.0).normalize() };
    let crossings = axis_crossings(&[skew], &axis).unwrap();
    assert!((crossings.max_abs_mm - 7.0).abs() < 1e-12 && (crossings.gap_rms_mm - 1.0).abs() < 1e-12);
    assert!(matches!(axis_crossings(&[axis], &axis), Err(Unmeasurable::TooFew { .. })));
    assert!(matches!(axis_crossings(&[], &axis), Err(Unmeasurable::TooFew { .. })));
}

#[test]
fn corners_at_two_depths_give_back_the_centre_of_projection() {
    let mut noise = Noise(7);
    let mut view = |depth: f64, sigma: f64| -> Vec<Observation> {
        let board = Pose::new(DVec3::new(0.0, 0.0, depth), DVec3::new(0.05, -0.03, 0.1));
        let grid = (-30..=30).flat_map(|j| (-30..=30).map(move |i| DVec3::new(f64::from(i), f64::from(j), 0.0)));
        grid.filter_map(|p| {
            let point_mm = board.point(p * 5.0);
            let ideal = designed().project(point_mm)?;
            let seen = ideal.x > 0.0 && ideal.x < 960.0 && ideal.y > 0.0 && ideal.y < 1080.0;
            seen.then(|| Observation { point_mm, image_px: ideal + sigma * noise.normal() })
        })
        .collect()
    };
    let inner: Vec<DVec2> = pixels().collect();
    // A tilted board's map is a ratio of linear functions: at tilts of 0.05 and degree 5 a remainder of
    // (0.05 * 0.085)^6 = 6e-15 of the board.
    let exact = rays_from_depths(&[view(500.0, 0.0), view(1000.0, 0.0)], &inner, 5).unwrap();
    let found = common_point(&rays(&exact)).unwrap();
    assert!((found.point_mm - CENTRE).length() < 1e-6 && found.misses.max_mm < 1e-6, "{found:?}");
    // Rays point from the first depth towards the last.
    let backwards = rays_from_depths(&[view(1000.0, 0.0), view(500.0, 0.0)], &inner, 5).unwrap();
    assert!(exact.iter().all(|s| s.ray.direction.z > 0.9) && backwards.iter().all(|s| s.ray.direction.z < -0.9));
    let noisy = rays_from_depths(&[view(500.0, 0.02), view(1000.0, 0.02)], &inner, 5).unwrap();
    let drift = (common_point(&rays(&noisy)).unwrap().point_mm - CENTRE).length();
    // 0.02 px is 3e-6 rad, so 3e-3 mm at 1 m; over angles of 0.08 rad that is 0.04 mm along z before averaging.
    assert!(drift > 1e-6 && drift < 0.1, "{drift}");
    assert!(matches!(rays_from_depths(&[view(500.0, 0.0)], &inner, 5), Err(Unmeasurable::TooFew { .. })));
    let same = [view(500.0, 0.0), view(500.0, 0.0)];
    assert!(matches!(rays_from_depths(&same, &inner, 5), Err(Unmeasurable::Degenerate(_))));
}
