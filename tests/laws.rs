//! Does physics hold for any input?

use crate::instruments::{BOARD, FLAT, FREEFORM, built, scene, scene_from};
use biprism::geom::Ray;
use biprism::num::poly2::Poly2;
use biprism::optics::snell::refract;
use biprism::render;
use biprism::scene::PrismSpec;
use biprism::system::aim::Aimer;
use biprism::system::{Side, System};
use glam::{DVec2, DVec3};
use proptest::prelude::*;

/// Unit vectors, one in four of them within 1e-16 ..= 1e-3 of the z axis or of its equator.
fn unit() -> impl Strategy<Value = DVec3> {
    let any = (-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64);
    (any, 0..8u8, -16.0..-3.0f64).prop_filter_map("a direction needs a length", |((x, y, z), kind, exponent)| {
        let small = libm::pow(10.0, exponent);
        let v = match kind {
            0 => DVec3::new(x * small, y * small, 1.0),
            1 => DVec3::new(x, y, z * small),
            _ => DVec3::new(x, y, z),
        };
        (v.length() > 1e-3).then(|| v.normalize())
    })
}

/// Ratios of indices, one in four of them within 32 ulp of 1.
fn ratio() -> impl Strategy<Value = f64> {
    (0.25..4.0f64, 0..4u8, -32..=32i64).prop_map(|(eta, kind, ulps)| match kind {
        0 => f64::from_bits((1.0f64.to_bits() as i64 + ulps) as u64),
        _ => eta,
    })
}

/// Angles of incidence as (cosine, sine) of a ray in the x-z plane that meets the plane z = 0, at the critical angle
/// of `eta` to within 32 ulp of the sine.
fn near_critical() -> impl Strategy<Value = (f64, DVec3)> {
    (1.0001..4.0f64, -32..=32i64).prop_map(|(eta, ulps)| {
        let sine = f64::from_bits(((1.0 / eta).to_bits() as i64 + ulps) as u64);
        (eta, DVec3::new(sine, 0.0, ((1.0 - sine) * (1.0 + sine)).sqrt()))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    /// n_in sin(in) = n_out sin(out), and the outgoing ray lies in the plane of the incoming ray and the normal.
    #[test]
    fn snell_and_coplanarity(i in unit(), n in unit(), eta in ratio()) {
        if let Some(r) = refract(i, n, eta) {
            // Three roundings of unit vectors on each side.
            let bound = 8.0 * f64::EPSILON * eta.max(1.0);
            prop_assert!((eta * i.cross(n).length() - r.direction.cross(n).length()).abs() <= bound);
            prop_assert!(r.direction.dot(i.cross(n)).abs() <= bound);
            prop_assert!((r.direction.length() - 1.0).abs() <= bound);
            prop_assert!(r.direction.dot(n) * i.dot(n) >= 0.0, "the ray goes on to the other side");
        } else {
            prop_assert!(eta * i.cross(n).length() > 1.0 - 8.0 * f64::EPSILON * eta, "lost without total reflection");
        }
    }

    /// The bend keeps its digits however alike the media: gamma (n_in cos(in) + n_out cos(out)) / n_out is eta^2 - 1 by
    /// Snell's law, and eta^2 - 1 is a product of exact factors.
    #[test]
    fn the_bend_of_a_small_step_keeps_its_digits(i in unit(), n in unit(), ulps in -4096..=4096i64) {
        let eta = f64::from_bits((1.0f64.to_bits() as i64 + ulps) as u64);
        if let Some(r) = refract(i, n, eta) {
            let wanted = (eta - 1.0) * (eta + 1.0);
            let found = r.gamma * (eta * r.cos_in + r.cos_out);
            prop_assert!((found - wanted).abs() <= 4.0 * f64::EPSILON * wanted.abs(), "{found:e} {wanted:e}");
        }
    }

    /// The refracted ray, reversed, goes back where it came from. Near the critical angle the way back is as badly
    /// conditioned as 1/cos(out), so the bound grows with it.
    #[test]
    fn a_reversed_ray_retraces((eta, i) in near_critical(), n in unit(), j in unit(), free in ratio()) {
        for (i, n, eta) in [(i, DVec3::Z, eta), (j, n, free)] {
            if let Some(out) = refract(i, n, eta)
                && let Some(back) = refract(-out.direction, n, 1.0 / eta)
            {
                let bound = 16.0 * f64::EPSILON * (1.0 + eta + 1.0 / eta) / out.cos_in.max(1e-300);
                prop_assert!((back.direction + i).length() <= bound, "{} {bound}", (back.direction + i).length());
            }
        }
    }

    /// The gradient of a polynomial against the mean of its own integral form: p(b) - p(a) along a short step.
    #[test]
    fn gradient_is_the_slope(c in prop::collection::vec(-1.0..1.0f64, 21), x in -1.0..1.0f64, y in -1.0..1.0f64) {
        let p = Poly2::new(5, [0.3, -0.1], [1.5, 0.7], |m, n| c[m * 6 - m * m.saturating_sub(1) / 2 + n]);
        let h = 1e-5;
        let (_, dx, dy) = p.gradient(x, y);
        // h^2/6 times a third derivative below 21 * 60 * (2.5)^5, plus rounding of p (below 2e3) over h.
        let bound = 1e-10 / 6.0 * 21.0 * 60.0 * 1e3 + 2e3 * f64::EPSILON / h;
        prop_assert!(((p.value(x + h, y) - p.value(x - h, y)) / (2.0 * h) - dx).abs() < bound);
        prop_assert!(((p.value(x, y + h) - p.value(x, y - h)) / (2.0 * h) - dy).abs() < bound);
    }
}

fn flat_and_freeform() -> [System; 2] {
    [FLAT, FREEFORM].map(|prism| built(&scene(1920, 1080, prism, BOARD)))
}

/// The derivative of the map is the derivative of the map.
#[test]
fn footprint_agrees_with_differences_of_looks() {
    for system in flat_and_freeform() {
        for k in 0..200 {
            let px = DVec2::new(5.0 + 9.5 * k as f64, 540.0 + 530.0 * libm::sin(k as f64));
            let h = 1e-3;
            let (Ok(here), Ok(a), Ok(b)) =
                (system.footprint(px), system.trace(px - DVec2::new(h, 0.0)), system.trace(px + DVec2::new(h, 0.0)))
            else {
                panic!("{px} sees nothing")
            };
            if a.side == b.side {
                let slope = (b.board_mm - a.board_mm) / (2.0 * h);
                // Positions of up to 200 mm round to 3e-14 mm each.
                assert!((slope - here.jacobian.x_axis).length() < 4.0 * 3e-14 / h + 1e-9, "{px}");
            }
            let look = |d: f64| system.trace(px + DVec2::new(0.0, d)).expect("in view").board_mm;
            assert!(
                ((look(h) - look(-h)) / (2.0 * h) - here.jacobian.y_axis).length() < 4.0 * 3e-14 / h + 1e-9,
                "{px}"
            );
        }
    }
}

#[test]
fn aiming_undoes_looking() {
    for system in flat_and_freeform() {
        let aimer = Aimer::new(&system);
        for k in 0..300 {
            let px = DVec2::new(1.0 + 6.39 * k as f64, 540.0 + 530.0 * libm::sin(k as f64));
            let sight = system.trace(px).expect("in view");
            let back = aimer.aim(sight.board_mm, sight.side).expect("found");
            // 0.154 mm/px on the board; positions of 200 mm round to 3e-14 mm, so 2e-13 px and a few such.
            assert!((back - px).length() < 4e-12, "{px} {back}");
        }
    }
}

/// Index 1 is no prism. Directions are the very same; positions differ by rounding on the way.
#[test]
fn a_prism_of_air_is_no_prism() {
    let air = FLAT.replace("1.48", "1.0") + "\nfacet_angle_deg = 8.85";
    let with = built(&scene(480, 270, &air, BOARD));
    let without = built(&scene(480, 270, "kind = \"none\"", BOARD));
    for k in 0..1000 {
        let px = DVec2::new(0.48 * k as f64, 135.0 + 134.0 * libm::sin(k as f64));
        let (a, b) = (with.trace(px).expect("in view"), without.trace(px).expect("in view"));
        assert!((a.board_mm - b.board_mm).length() < 1e-12, "{px}");
    }
    let (a, b) = (render::render(&with, &()), render::render(&without, &()));
    for (x, y) in a.radiance.data().iter().zip(b.radiance.data()) {
        assert!((x - y).abs() <= f32::EPSILON, "{x} {y}");
    }
}

/// A plane-parallel plate of thickness T moves a ray at angle i sideways by T (tan i - tan r) in its plane and leaves its
/// direction (Born & Wolf, 4.7).
#[test]
fn a_plate_moves_rays_by_its_closed_form() {
    let plate = built(&scene(1920, 1080, &(FLAT.to_owned() + "\nfacet_angle_deg = 0.0"), BOARD));
    for k in 0..1000 {
        let px = DVec2::new(1.92 * k as f64, 540.0 + 530.0 * libm::sin(k as f64));
        let tangent = (px - DVec2::new(960.0, 540.0)) * (0.0055 / 35.0);
        let sine = tangent.length() / (1.0 + tangent.length_squared()).sqrt();
        let inner = sine / 1.48 / (1.0 - (sine / 1.48) * (sine / 1.48)).sqrt();
        let moved = 1.0 - 8.545 / 1000.0 * (1.0 - inner / tangent.length().max(1e-300));
        let expected = tangent * 1000.0 * if tangent == DVec2::ZERO { 1.0 } else { moved };
        let seen = plate.trace(px).expect("in view").board_mm;
        assert!((seen - expected).length() < 1e-12, "{px} {seen} {expected}");
    }
}

#[test]
fn halves_are_mirror_images_bit_for_bit() {
    for (width, height) in [(192, 108), (66, 37), (130, 70)] {
        for prism in [FLAT, FREEFORM] {
            let film = render::render(&built(&scene(width, height, prism, BOARD)), &());
            for j in 0..height {
                for i in 0..width / 2 {
                    let (a, b) = (film.radiance.get(i, j), film.radiance.get(width - 1 - i, j));
                    assert_eq!(a.to_bits(), b.to_bits(), "({i}, {j}) of {width} x {height}: {a} {b}");
                }
            }
        }
    }
}

/// A seam inside the pixels of the middle column leaves the rest as symmetric as f32 can say: beside the seam the
/// second derivatives come from other rays, equal to 1e-6 of themselves.
#[test]
fn an_odd_width_is_symmetric_about_its_middle_column() {
    for prism in [FLAT, FREEFORM] {
        let film = render::render(&built(&scene(65, 37, prism, BOARD)), &());
        assert_eq!(film.counts.cut_pixels, 37);
        for (j, i) in (0..37).flat_map(|j| (0..32).map(move |i| (j, i))) {
            let (a, b) = (film.radiance.get(i, j), film.radiance.get(64 - i, j));
            assert!((a - b).abs() <= 2.0 * f32::EPSILON, "({i}, {j}): {a} {b}");
        }
    }
}

/// The whole scene moved: the picture stays.
#[test]
fn moving_everything_changes_nothing() {
    let moved = |text: &str, by: DVec3, z: f64| format!("{text}\nposition_mm = [{}, {}, {}]", by.x, by.y, by.z + z);
    let base = built(&scene(1920, 1080, FREEFORM, BOARD));
    let by = DVec3::new(1000.0, -3000.0, 500.0);
    let board = moved("columns = 41\nrows = 41\nsquare_mm = 10.0", by, 1000.0);
    let elsewhere = built(&scene_from(1920, 1080, &moved("", by, 0.0), &moved(FREEFORM, by, 0.0), &board));
    for k in 0..1000 {
        let px = DVec2::new(1.92 * k as f64, 540.0 + 530.0 * libm::sin(k as f64));
        let (a, b) = (base.trace(px).expect("in view"), elsewhere.trace(px).expect("in view"));
        // Coordinates of 3000 mm round to 4.5e-13 mm, a few times over, and angles magnify by about 12.
        assert!((a.board_mm - b.board_mm).length() < 1e-10, "{px} {}", (a.board_mm - b.board_mm).length());
    }
}

/// Behind the prism, the reversed ray goes back through both surfaces to the pinhole.
#[test]
fn a_reversed_ray_returns_to_the_pinhole() {
    for system in flat_and_freeform() {
        for k in 0..500 {
            let px = DVec2::new(3.0 + 3.8 * k as f64, 540.0 + 530.0 * libm::sin(k as f64));
            let (path, end) = system.path(px);
            let (out, side) = end.expect("it passes");
            let before = system.camera().ray(px);
            // Normals from the law itself: n is along eta i - t.
            let mut back = Ray { origin: out.origin, direction: -out.direction };
            for (point, incoming, eta) in
                [(path.points[1], path.directions[0], 1.48), (path.points[0], before.direction, 1.0 / 1.48)]
            {
                let outgoing = -back.direction;
                let normal = (incoming * eta - outgoing).normalize();
                back.direction = refract(back.direction, normal, 1.0 / eta).expect("it came this way").direction;
                assert!((back.direction + incoming).length() < 1e-14, "{px} {side:?}");
                back.origin = point;
            }
            let miss = back.direction.cross(before.origin - back.origin).length();
            assert!(miss < 1e-12, "{px}: {miss} mm past the pinhole");
        }
    }
}

/// The sides of a scene without a prism are the halves of the picture.
#[test]
fn without_glass_the_halves_stand_for_the_sides() {
    let s = scene(192, 108, "kind = \"none\"", BOARD);
    assert_eq!(s.prism, PrismSpec::None);
    let system = built(&s);
    assert_eq!(system.trace(DVec2::new(95.9, 50.0)).map(|s| s.side), Ok(Side::Left));
    assert_eq!(system.trace(DVec2::new(96.1, 50.0)).map(|s| s.side), Ok(Side::Right));
}
