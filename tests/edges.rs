//! Do the laws hold where numbers are nearly equal, tiny or huge?
//!
//! Generators lean on the edges: within 32 ulp of equal, exponents uniform in their logarithm, tangent rays.

use crate::instruments::{BOARD, built, scene};
use biprism::geom::{Ray, Rect};
use biprism::num::bernstein::Bernstein;
use biprism::num::poly2::Poly2;
use biprism::optics::fate::Fate;
use biprism::optics::snell::refract;
use biprism::render;
use biprism::render::checkerboard::Checkerboard;
use biprism::scene::{self, PolynomialPatch};
use biprism::surface::shape::{PolynomialSurface, Surface};
use biprism::system;
use biprism::system::aim::Aimer;
use glam::{DVec2, DVec3};
use proptest::prelude::*;

fn ulps(x: f64, n: i64) -> f64 {
    f64::from_bits((x.to_bits() as i64 + n) as u64)
}

/// 10^low ... 10^high, uniform in the exponent.
fn logarithmic(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low..high).prop_map(libm::exp10)
}

/// A cosine of incidence within 32 ulp or 1e-16 ... 1e-3 of that at the critical angle of an eta above 1.
fn near_critical() -> impl Strategy<Value = (f64, f64)> {
    (prop_oneof![1.0001..4.0f64, (1..=32i64).prop_map(|n| ulps(1.0, n))], -32..=32i64, -16.0..-3.0f64, 0..3u8).prop_map(
        |(eta, n, exponent, kind)| {
            let critical = ((eta - 1.0) * (eta + 1.0)).sqrt() / eta;
            let off = libm::exp10(exponent);
            match kind {
                0 => (eta, ulps(critical, n)),
                1 => (eta, critical * (1.0 + off)),
                _ => (eta, critical + off),
            }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Towards the critical angle the cosine of refraction rises with that of incidence, from each number to the next, by
    /// as much as its derivative eta^2 cos_in / cos_out says: a kernel that rounds before it subtracts stutters.
    #[test]
    fn refraction_rises_smoothly_from_the_critical_angle((eta, cos_in) in near_critical()) {
        let at = |c: f64| refract(DVec3::new(((1.0 - c) * (1.0 + c)).sqrt(), 0.0, c), DVec3::Z, eta).map(|r| r.cos_out);
        let next = ulps(cos_in, 1);
        match (at(cos_in), at(next)) {
            (Some(a), Some(b)) => {
                // Each cosine is right to 8 eps of itself, however close to 0 it is.
                prop_assert!(b >= a * (1.0 - 16.0 * f64::EPSILON), "{a:?} {b:?}");
                // cos_out^2 rises by eta^2 (next^2 - cos_in^2), exactly.
                let rise = eta * eta * (next - cos_in) * (next + cos_in);
                let rounding = 32.0 * f64::EPSILON * b * b;
                prop_assert!(((b - a) * (b + a) - rise).abs() <= rounding + 1e-9 * rise, "{} {rise}", (b - a) * (b + a));
            }
            // Light ends at the cosine sqrt(eta^2 - 1) / eta: five roundings, of which three are halved by the root.
            (None, _) => {
                let critical = ((eta - 1.0) * (eta + 1.0)).sqrt() / eta;
                prop_assert!(cos_in <= critical * (1.0 + 4.0 * f64::EPSILON), "light ends at {cos_in:?}, not {critical:?}");
            }
            (Some(_), None) => prop_assert!(false, "light ends away from the critical angle"),
        }
    }

    /// No crossing lies before the one that is found, and the ray is on the sheet there; a ray that misses never changes
    /// sides over the domain. Rays are aimed to graze a crest.
    #[test]
    fn the_first_crossing_is_the_first(
        c in prop::collection::vec(-1.0..1.0f64, 28), x in -0.9..0.9f64, y in -0.9..0.9f64,
        turn in 0.0..std::f64::consts::TAU, lift in prop_oneof![Just(0.0), logarithmic(-14.0, -1.0), -0.5..0.5f64],
        slope in -0.3..0.3f64,
    ) {
        let index = |m: usize, n: usize| m * 7 - m * m.saturating_sub(1) / 2 + n;
        let sag = Poly2::new(6, [0.0, 0.0], [1.0, 1.0], |m, n| c[index(m, n)]);
        let domain = Rect { min: DVec2::splat(-1.0), max: DVec2::splat(1.0) };
        let sheet = Surface::Freeform(PolynomialSurface::new(&PolynomialPatch { sag: sag.clone(), domain }, false));
        // Along a tangent of the sheet at (x, y), lifted a little and tilted not at all or a little.
        let (z, zx, zy) = sag.gradient(x, y);
        let along = DVec2::new(libm::cos(turn), libm::sin(turn));
        let tilt = if c[0] > 0.0 { 0.0 } else { slope };
        let direction = DVec3::new(along.x, along.y, zx * along.x + zy * along.y + tilt).normalize();
        let ray = Ray { origin: DVec3::new(x, y, z + lift) - direction * 8.0, direction };
        let gap = |t: f64| { let p = ray.at(t); p.z - sag.value(p.x, p.y) };
        let inside = |t: f64| { let p = ray.at(t); domain.contains(DVec2::new(p.x, p.y)) };
        let met = sheet.intersect(&ray, 1e-12);
        let end = met.map_or(f64::INFINITY, |m| m.t_mm);
        if let Ok(m) = met {
            prop_assert!(gap(m.t_mm).abs() < 1e-11, "gap {}", gap(m.t_mm));
        }
        // 28 terms of at most 1, rounded.
        let rounding = 1e-13;
        let mut side = 0.0;
        for k in 0..6000 {
            let t = 5.0 + k as f64 * 1e-3;
            if t < end - 1e-6 && inside(t) && gap(t).abs() > rounding {
                prop_assert!(side == 0.0 || side == gap(t).signum(), "a crossing before {end}, at {t}");
                side = gap(t).signum();
            }
        }
    }

    /// The least of the known roots, however close the next.
    #[test]
    fn the_least_root_is_found(
        roots in prop::collection::vec(-0.5..1.5f64, 1..8), apart in logarithmic(-7.0, -1.0), scale in logarithmic(-100.0, 100.0)
    ) {
        let twin = roots[0] + apart;
        let p = roots.iter().chain([&twin]).fold(Bernstein::constant(scale), |p, r| p.times_line([-r, 1.0 - r]));
        // Where roots are close the value is lost in its rounding, and so is the place. What counts is that the value
        // vanishes there to within rounding, and that beyond rounding it has one sign before it.
        let rounding = 1e-13 * scale;
        let found = p.first_root();
        if let Some(found) = found {
            prop_assert!(p.value(found).abs() <= rounding, "{found} is no root");
        }
        let end = found.unwrap_or(1.0);
        let mut places: Vec<f64> = roots.iter().copied().chain([twin, 0.0, end]).map(|r| r.clamp(0.0, end)).collect();
        places.sort_by(f64::total_cmp);
        let values: Vec<f64> = places.windows(2).map(|w| p.value(0.5 * (w[0] + w[1]))).collect();
        let signs = [values.iter().any(|v| *v > rounding), values.iter().any(|v| *v < -rounding)];
        prop_assert!(signs != [true, true], "a root before {found:?} is overlooked: {places:?} {values:?}");
    }

    /// The mean over a polygon lies between the pattern's darkest and brightest, and is that of its two parts by area,
    /// with corners within 32 ulp of the pattern's lines.
    #[test]
    fn coverage_is_a_mean_and_adds_up(
        cells in prop::collection::vec(-6i32..6, 8), near in prop::collection::vec(-32i64..=32, 8),
        free in prop::collection::vec(-60.0..60.0f64, 8), which in 0u8..=255, cut in 0.01..0.99f64,
    ) {
        let pattern = Checkerboard::new(&scene(96, 54, "kind = \"none\"", &BOARD.replace("41", "9")).board);
        // Half the coordinates are at lines of the pattern (odd multiples of 5 mm, the rim at 45, the plate at 55).
        let v = |k: usize| if which >> k & 1 == 1 { ulps(5.0 + 10.0 * f64::from(cells[k]), near[k]) } else { free[k] };
        let (c, a, b) = (DVec2::new(v(0), v(1)), DVec2::new(v(2), v(3)) * 0.2, DVec2::new(v(4), v(5)) * 0.2);
        if a.perp_dot(b).abs() < 1e-6 * (a.length_squared() + b.length_squared()) {
            return Ok(());
        }
        let mean = |p: [DVec2; 4]| pattern.mean_over(&p).expect("it has an area");
        let whole = mean([c, c + a, c + a + b, c + b]);
        prop_assert!((0.05 - 1e-9..=0.85 + 1e-9).contains(&whole), "{whole}");
        let (first, second) = (mean([c, c + a * cut, c + a * cut + b, c + b]), mean([c + a * cut, c + a, c + a + b, c + a * cut + b]));
        // Rounding of the parts' areas against slivers of 1e-6 of their squares.
        prop_assert!((whole - (first * cut + second * (1.0 - cut))).abs() < 1e-7, "{whole} {first} {second}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Any instrument inside the file's limits: refused in words, or each ray is a number or a fate, each pixel a radiance
    /// of the board or the dark of the glass, and each pixel aimed at sees its point.
    #[test]
    fn any_instrument_is_refused_or_finite(
        focal in logarithmic(-3.0, 6.0), pitch in logarithmic(-6.0, 6.0), ridge in logarithmic(-9.0, 12.0),
        thickness in logarithmic(-12.0, 12.0), board_z in logarithmic(-3.0, 12.0), square in logarithmic(-9.0, 12.0),
        index in prop_oneof![0.1..10.0f64, (-32..=32i64).prop_map(|n| ulps(1.0, n)), Just(1.48)],
        angle in prop_oneof![-88.0..88.0f64, logarithmic(-300.0, 1.9), logarithmic(-300.0, 1.9).prop_map(|a| -a)],
        x in prop_oneof![Just(0.0), -1.0..1.0f64], tilt in prop_oneof![Just(0.0), -180.0..180.0f64, Just(90.0)],
        width in 1usize..9, height in 1usize..5, paper in 0u8..64,
    ) {
        // Most draws keep to the paper in most of their values, or few would be instruments.
        let or = |k: u8, paper_value: f64, value: f64| if paper >> k & 1 == 0 { value } else { paper_value };
        let text = format!(
            "name = \"any\"\n[camera]\nfocal_length_mm = {:?}\nwidth_px = {width}\nheight_px = {height}\npixel_pitch_um = {:?}\n\
             position_mm = [{:?}, 0.0, 0.0]\n[prism]\nkind = \"flat\"\nindex = {index:?}\nridge_distance_mm = {:?}\n\
             thickness_mm = {:?}\nfacet_angle_deg = {:?}\n[board]\ncolumns = 41\nrows = 40\nsquare_mm = {:?}\n\
             position_mm = [0.0, 0.0, {:?}]\ntilt_deg = [{tilt:?}, 0.0, 0.0]\n",
            or(0, 35.0, focal), or(0, 10560.0 / width as f64, pitch), x * or(1, 78.0, ridge).min(1e11), or(1, 78.472, ridge),
            or(2, 8.545, thickness), or(3, 8.85, angle), or(4, 10.0, square), or(5, 1000.0, board_z),
        );
        let Ok(scene) = scene::parse(&text, "any", None) else { return Ok(()) };
        let Ok(system) = system::build(&scene) else { return Ok(()) };
        let aimer = Aimer::new(&system);
        for k in 0..25 {
            let px = DVec2::new(width as f64 * f64::from(k % 5) / 4.0, height as f64 * f64::from(k / 5) / 4.0);
            if let Ok(footprint) = system.footprint(px) {
                let sight = footprint.sight;
                prop_assert!(sight.board_mm.is_finite(), "{px} sees {}\n{text}", sight.board_mm);
                if let Ok(back) = aimer.aim(sight.board_mm, sight.side) {
                    let there = system.footprint_through(back, sight.side).expect("it was aimed at");
                    let off = (there.jacobian.inverse() * (sight.board_mm - there.sight.board_mm)).length();
                    prop_assert!(off <= 1e-6, "{px} sees {}, {back} is {off} px off\n{text}", sight.board_mm);
                }
            }
        }
        let film = render::render(&system, &());
        for value in film.radiance.data() {
            prop_assert!((-1e-6..=0.85 + 1e-6).contains(value), "{value}\n{text}");
        }
    }
}

/// A back whose slope grows with x^2 folds the map: no pixel sees further than about 38 mm aside, and what is aimed at
/// beyond it is refused, not answered with the pixel that comes nearest.
#[test]
fn what_lies_beyond_a_fold_is_not_found() {
    let patch = |terms: &str| {
        format!(
            "centre_mm = [0.0, 0.0]\nscale_mm = [1.0, 1.0]\ndomain_mm = [[-1.0, 13.0], [-9.0, 9.0]]\nterms = {terms}\n"
        )
    };
    let prism = format!(
        "kind = \"polynomial\"\nindex = 1.48\n[prism.front]\n{}[prism.back]\n{}",
        patch("[[0, 0, 80.0]]"),
        patch("[[0, 0, 90.0], [3, 0, -7.9e-4]]")
    );
    let system = built(&scene(480, 270, &prism, BOARD));
    let seen = (0..480 * 270).filter_map(|k| system.trace(DVec2::new(f64::from(k % 480), f64::from(k / 480))).ok());
    let farthest_mm = seen.map(|sight| sight.board_mm.x.abs()).fold(0.0, f64::max);
    assert!((30.0..50.0).contains(&farthest_mm), "{farthest_mm}");
    let aimer = Aimer::new(&system);
    for k in 0..200 {
        let board_mm = DVec2::new(farthest_mm + 0.5 + 0.25 * f64::from(k), f64::from(k % 20) - 10.0);
        let end = aimer.aim(board_mm, system::Side::Right);
        assert_eq!(end, Err(Fate::NotConverged), "{board_mm}");
    }
}

/// The map of the paper's scene, aimed at from every corner of its board: each pixel sees its corner to rounding.
#[test]
fn every_corner_that_is_aimed_at_is_seen() {
    for prism in [crate::instruments::FLAT, crate::instruments::FREEFORM] {
        let system = built(&scene(1920, 1080, prism, BOARD));
        let aimer = Aimer::new(&system);
        for (row, column) in (0..40).flat_map(|j| (0..40).map(move |i| (j, i))) {
            let board_mm = system.board().corner_at(f64::from(column), f64::from(row));
            for side in [system::Side::Left, system::Side::Right] {
                if let Ok(px) = aimer.aim(board_mm, side) {
                    let seen = system.footprint_through(px, side).expect("it was aimed at").sight.board_mm;
                    // 0.16 mm on the board per px, and positions of 300 mm round to 6e-14 mm.
                    assert!((seen - board_mm).length() < 2e-12, "{board_mm}: {px} sees {seen}");
                }
            }
        }
    }
}
