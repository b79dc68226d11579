//! Do lenses, stops and rims do what geometry says?

use crate::instruments::{BOARD, FLAT, FREEFORM, NO_GLASS, built, edge_integral, picture, scene, scene_from, with};
use biprism::accuracy::Accuracy;
use biprism::effect::clipping::{Outline, Stop};
use biprism::effect::thin_lens::Aperture;
use biprism::effect::{Clipping, Effects, Fresnel, Ghosts, Lens, Quadrature, Telecentric, ThinLens};
use biprism::optics::polarisation::PolarisationState;
use biprism::raster::Raster;
use biprism::render::{Class, Outputs, render, render_wanted};

use glam::{DVec2, DVec3};

/// Surroundings of radiance 1: what is missing from a pixel was clipped.
const WHITE: &str = "columns = 41\nrows = 41\nsquare_mm = 10.0\nposition_mm = [0.0, 0.0, 1000.0]\nblack = 1\nwhite = 1\n\
                     background = 1";

fn light(picture: &Raster<f32>) -> f64 {
    picture.data().iter().map(|v| f64::from(*v)).sum()
}

/// What is seen of a telecentric lens moves by pitch over magnification from pixel to pixel, at every depth; through a flat
/// prism by that times 1 + tan(a) tan(i) across the ridge, with a the angle of the facets and i that of the rays in the
/// glass to the axis, sin(a) = n sin(a - i): towards the rim the glass is thinner, and shifts rays less to the axis.
#[test]
fn telecentric_magnification_does_not_depend_on_depth() {
    let lens = Telecentric { magnification: 0.55, na: 0.0, focus_mm: 500.0 };
    let effects = Effects { lens: Lens::Telecentric(lens), ..Effects::default() };
    let angle = 8.0f64.to_radians();
    let inside = angle - libm::asin(libm::sin(angle) / 1.48);
    let stretched = 1.0 + libm::tan(angle) * libm::tan(inside);
    for (prism, across) in [(NO_GLASS, 1.0), (&*format!("{FLAT}\nfacet_angle_deg = 8"), stretched)] {
        for depth in [150.0, 500.0, 4000.0] {
            let board = format!("columns = 9\nrows = 9\nsquare_mm = 2.0\nposition_mm = [0.0, 0.0, {depth}]");
            let system = with(&scene(320, 180, prism, &board), effects.clone());
            let step = 10.56 / 320.0 / 0.55;
            let seen = |x: f64, y: f64| system.trace(DVec2::new(x, y)).unwrap().board_mm;
            let (a, b) = (seen(170.5, 3.25), seen(300.5, 150.75));
            let expected = DVec2::new(130.0 * step * across, 147.5 * step);
            // Some roundings of coordinates of up to 4000 mm.
            assert!((b - a - expected).length() < 1e-11, "{prism} {depth}: {}", b - a);
            let footprint = system.footprint(DVec2::new(250.0, 40.0)).unwrap().jacobian;
            assert!((footprint.x_axis - DVec2::new(step * across, 0.0)).length() < 1e-13);
            assert!((footprint.y_axis - DVec2::new(0.0, step)).length() < 1e-13);
        }
    }
}

/// Out of focus, a telecentric lens shows a point as a circle of the diameter 2 tan(asin NA) |depth - focus|, the same
/// all over the picture; in focus it is sharp.
#[test]
fn telecentric_blur_is_the_cone_of_its_aperture() {
    let board = "columns = 2\nrows = 1\nsquare_mm = 100.0\nposition_mm = [0.0, 0.0, 300.0]\nmargin_mm = 0";
    let plain = scene(192, 1, NO_GLASS, board);
    let quadrature = Quadrature { points: 1024, ..Quadrature::default() };
    let step = 10.56 / 192.0 / 0.55;
    for focus_mm in [260.0, 300.0, 330.0] {
        let lens = Telecentric { magnification: 0.55, na: 0.02, focus_mm };
        let found = picture(&with(&plain, Effects { lens: Lens::Telecentric(lens), quadrature, ..Effects::default() }));
        let radius_px = 0.5 * lens.blur_mm(300.0) / step;
        for (i, value) in found.row(0).iter().enumerate() {
            let place = |x: f64| (x - 96.0) / radius_px;
            let (from, to) = (place(i as f64), place(i as f64 + 1.0));
            let white = match radius_px == 0.0 {
                true => f64::from(u8::from(i >= 96)),
                false => (edge_integral(to) - edge_integral(from)) * radius_px,
            };
            let expected = 0.05 + 0.8 * white;
            // log(n) / n of the even points; and the cone is filled evenly in sines, not in tangents: NA^2 / 2. In focus all
            // directions see the same point, and there is only rounding to f32.
            let blurred = 0.8 * (libm::log(1024.0) / 1024.0 + 0.02 * 0.02 / 2.0);
            let bound = if radius_px == 0.0 { 4.0 * f64::from(f32::EPSILON) } else { blurred };
            assert!((f64::from(*value) - expected).abs() < bound, "{focus_mm} {i}: {value} {expected}");
        }
    }
}

/// Packets, the map and single rays see the same through a telecentric lens.
#[test]
fn telecentric_pictures_agree_at_every_level() {
    let board = "columns = 31\nrows = 21\nsquare_mm = 0.7\nposition_mm = [0.1, 0.2, 200.0]\ntilt_deg = [10, -15, 5]";
    let lens = Telecentric { magnification: 0.55, na: 0.0, focus_mm: 200.0 };
    for prism in [NO_GLASS.to_owned(), format!("{FLAT}\ntilt_deg = [1, 0.5, 2]"), FREEFORM.to_owned()] {
        let plain = scene(120, 68, &prism, board);
        let system = with(&plain, Effects { lens: Lens::Telecentric(lens), ..Effects::default() });
        use biprism::accuracy::Level;
        let [standard, exact, reference] = [Level::Standard, Level::Exact, Level::Reference]
            .map(|level| render(&system.with_accuracy(level.accuracy()), &()));
        assert!(standard.class == exact.class && exact.class == reference.class, "{prism}");
        assert!(exact.board_mm == reference.board_mm, "{prism}");
        for (a, b) in standard.radiance.data().iter().zip(reference.radiance.data()) {
            // The promise of the level, 1e-5 px, over a contrast of 0.8, along a pixel's diagonal.
            assert!((a - b).abs() < 1.5e-5, "{prism}: {a} {b}");
        }
    }
}

/// A ground ridge of width w is a black band: its half is seen where the facet is w/2 off the ridge, at f/pitch times
/// (w/2) / (D + (w/2) tan a). The band is cut exactly, so the light that is missing is its width.
#[test]
fn a_chamfer_is_a_black_band_of_its_width() {
    // In the middle of a picture of odd width, a narrow band lies within one pixel; off it, no centre of a pixel meets it. A
    // band as narrow as the smallest parts of a pixel is right or told as without promise.
    let (middle, beside) = ((321, 0.0), (320, 0.3));
    let places = [(320, 0.0), middle, beside].into_iter().flat_map(|place| [0.05, 0.4, 2.0].map(|mm| (place, mm)));
    for ((columns, off_px), chamfer_mm) in places.chain([(middle, 1e-4), (beside, 1e-4)]) {
        let camera = format!("position_mm = [{:?}, 0.0, 0.0]", off_px * 10.56 / f64::from(columns) * 78.472 / 35.0);
        let plain = scene_from(columns as usize, 24, &camera, &format!("{FLAT}\nfacet_angle_deg = 8"), WHITE);
        let clipping = Clipping { chamfer_mm, ..Clipping::default() };
        let film = render(&with(&plain, Effects { clipping: Some(clipping), ..Effects::default() }), &());
        let half = 0.5 * chamfer_mm;
        let tangent = half / (78.472 + half * libm::tan(8.0f64.to_radians()));
        let width_px = 2.0 * tangent * 35.0 / plain.camera.pitch_mm;
        let told = chamfer_mm < 1e-3 && film.account.unpromised_pixels == 24;
        for j in 0..24 {
            let missing: f64 = film.radiance.row(j).iter().map(|v| 1.0 - f64::from(*v)).sum();
            // The places of the cuts are found to 2^-40 px, and each of 320 radiances is rounded to f32.
            let bound = if told { 2e-3 } else { 1e-5 };
            assert!((missing - width_px).abs() < bound, "{columns} {off_px} {chamfer_mm} {j}: {missing} {width_px}");
        }
        let clipped = film.class.as_ref().unwrap().row(12).iter().filter(|c| **c == Class::Clipped).count();
        assert!((clipped as f64 - width_px).abs() <= 1.0, "{clipped} {width_px}");
    }
}

/// The round rim of a plate at D, T thick: the back clips first, where D tan(u) + T tan(u') = R with sin(u) = n sin(u').
/// The lit part of the picture is a circle, which straight cuts through pixels leave 1/6 of its radius^0 short: each of
/// its 2 pi r pixels of border loses 1/(12 r) px^2.
#[test]
fn a_round_rim_lights_a_circle() {
    let plate = format!("{FLAT}\nfacet_angle_deg = 0");
    let plain = scene(160, 90, &plate, WHITE);
    let radius_mm = 5.3;
    let outline = Some(Outline::Circle { radius_mm });
    let clipping = Clipping { outline, ..Clipping::default() };
    let reach = |tangent: f64| {
        let sin = tangent / (1.0 + tangent * tangent).sqrt() / 1.48;
        78.472 * tangent + 8.545 * sin / (1.0 - sin * sin).sqrt()
    };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if reach(middle) < radius_mm { low = middle } else { high = middle }
    }
    let radius_px = low * 35.0 / plain.camera.pitch_mm;
    assert!(radius_px < 45.0);
    let area = std::f64::consts::PI * radius_px * radius_px;
    for level in biprism::accuracy::Level::ALL {
        let system = with(&plain, Effects { clipping: Some(clipping), ..Effects::default() });
        let found = light(&picture(&system.with_accuracy(level.accuracy())));
        assert!((found - area).abs() < 2.0 * std::f64::consts::PI / 12.0, "{level:?}: {found} {area}");
    }
}

/// A rim that only just reaches into the picture is not overlooked by the map, wherever between its rays it does: a round
/// one reaches in at the corners, a rectangular one in the middle of a side. There the back is met farthest out, at
/// D tan(u) + T tan(u') with sin(u) = n sin(u'); and of 168 rows the middle one lies between two rays.
#[test]
fn a_rim_at_the_edge_of_the_picture_is_seen() {
    let plain = scene(320, 168, &format!("{FLAT}\nfacet_angle_deg = 0"), WHITE);
    let reach_mm = |rows: f64| {
        let tangent = DVec2::new(160.0, rows) * plain.camera.pitch_mm / 35.0;
        let square = tangent.length_squared();
        tangent.x * (78.472 + 8.545 / (1.48 * 1.48 * (1.0 + square) - square).sqrt())
    };
    let round = (0..12).map(|step| Outline::Circle { radius_mm: 13.2 + 0.05 * f64::from(step) });
    let upright =
        [1.0, 2.0, 3.0].into_iter().map(|rows| Outline::Rectangle { half_mm: DVec2::new(reach_mm(rows), 100.0) });
    for outline in round.chain(upright) {
        let clipping = Clipping { outline: Some(outline), ..Clipping::default() };
        let system = with(&plain, Effects { clipping: Some(clipping), ..Effects::default() });
        let by = |level: biprism::accuracy::Level| render(&system.with_accuracy(level.accuracy()), &());
        let [mapped, traced] = [biprism::accuracy::Level::Standard, biprism::accuracy::Level::Exact].map(by);
        assert!(mapped.class == traced.class, "{outline:?}");
        for (a, b) in mapped.radiance.data().iter().zip(traced.radiance.data()) {
            assert!((a - b).abs() < 1e-6, "{outline:?}: {a} {b}");
        }
        // The rectangular rims take light from the picture, if little.
        let taken = traced.radiance.data().iter().any(|v| *v < 1.0);
        assert!(taken || matches!(outline, Outline::Circle { .. }), "{outline:?}");
    }
}

/// What is in the way of light is in the way of its ghosts: nothing at all shows where all light is stopped, and a rim that
/// takes some ways through the glass takes some of its ghosts.
#[test]
fn ghosts_are_clipped_as_the_picture_is() {
    let plain = scene(160, 90, &format!("{FLAT}\nfacet_angle_deg = 1"), WHITE);
    let ghosts = Some(Ghosts { bounces: 4, least_power: 1e-9, behind: 1.0, samples: 4 });
    let fresnel = Some(Fresnel { light: PolarisationState::Unpolarised });
    let of = |clipping| picture(&with(&plain, Effects { fresnel, ghosts, clipping, ..Effects::default() }));
    let stop = Some(Stop { distance_mm: 30.0, radius_mm: 1.5 });
    let stopped = of(Some(Clipping { stop, ..Clipping::default() }));
    let free = of(None);
    for j in 0..90 {
        for i in 0..160 {
            let tangent =
                (DVec2::new(i as f64 + 0.5, j as f64 + 0.5) - DVec2::new(80.0, 45.0)).length() * 10.56 / 160.0 / 35.0;
            // A ghost is sampled within blocks of 8 x 8 pixels, of which the diagonal is 12 px.
            let block = 12.0 * 10.56 / 160.0 / 35.0;
            let found = stopped.get(i, j);
            if tangent > 1.5 / 30.0 + block {
                assert_eq!(found, 0.0, "({i}, {j})");
            } else if tangent < 1.5 / 30.0 - block {
                // Rounding to f32, where one of the two takes the exact way and the other samples.
                assert!((found - free.get(i, j)).abs() <= 2.0 * f32::EPSILON, "({i}, {j}): {found}");
            }
        }
    }
    let rim = Some(Outline::Circle { radius_mm: 4.0 });
    let rimmed = of(Some(Clipping { outline: rim, ..Clipping::default() }));
    assert!(rimmed.get(80, 2) == 0.0 && rimmed.get(2, 45) == 0.0);
    assert!(rimmed.data().iter().zip(free.data()).all(|(a, b)| *a <= b + 1e-5));
}

/// Mechanical vignetting: of a pupil of radius a, a stop of radius b at the distance d leaves to the field tangent t what
/// two circles share whose middles are d t apart, for a lens in focus far away.
#[test]
fn a_stop_before_a_lens_vignettes_as_two_circles_overlap() {
    let white = WHITE.replace("1000.0]", "1e9]");
    let plain = scene(161, 1, NO_GLASS, &white);
    let lens = ThinLens::new(4.0, 1e12, Aperture::Circle, 35.0);
    let (a, b, d) = (lens.radius_mm, 4.0, 60.0);
    let stop = Some(Stop { distance_mm: d, radius_mm: b });
    let clipping = Some(Clipping { stop, ..Clipping::default() });
    let points = 2048;
    let quadrature = Quadrature { points, ..Quadrature::default() };
    let found = picture(&with(&plain, Effects { lens: Lens::Thin(lens), clipping, quadrature, ..Effects::default() }));
    let mut partly = 0;
    for i in 0..161 {
        let apart = d * (i as f64 + 0.5 - 80.5).abs() * plain.camera.pitch_mm / 35.0;
        let shared = overlap(a, b, apart) / (std::f64::consts::PI * a * a);
        partly += usize::from(shared > 0.01 && shared < 0.99);
        // An even set counts a convex area to log(n) / n at worst.
        let bound = libm::log(points as f64) / points as f64;
        let value = f64::from(found.get(i, 0));
        assert!((value - shared).abs() < bound, "{i}: {value} {shared}");
    }
    assert!(partly > 40, "{partly}");
}

/// The area that two circles of radii `a` and `b` share, `apart` from middle to middle.
fn overlap(a: f64, b: f64, apart: f64) -> f64 {
    if apart >= a + b {
        return 0.0;
    }
    if apart <= (a - b).abs() {
        return std::f64::consts::PI * a.min(b) * a.min(b);
    }
    let segment = |r: f64, other: f64| {
        let h = (apart * apart + r * r - other * other) / (2.0 * apart);
        r * r * libm::acos(h / r) - h * (r * r - h * h).max(0.0).sqrt()
    };
    segment(a, b) + segment(b, a)
}

/// Plane-parallel glass of thickness t at the angle u takes an image in its plane of incidence farther away than one
/// across it: by t (n^2 cos^2 u / (n^2 - sin^2 u)^(3/2) - 1 / (n^2 - sin^2 u)^(1/2)), along the ray and negative
/// (W. J. Smith, Modern Optical Engineering, 4.8, with the roles of both planes kept apart).
#[test]
fn a_tilted_plate_is_astigmatic_by_the_closed_form() {
    let angle = 40.0f64.to_radians();
    let plate = format!("{FLAT}\nfacet_angle_deg = 0\ntilt_deg = [0, 40, 0]\nposition_mm = [60, 0, 0]");
    let plain = scene(64, 36, &plate.replace("8.545", "20"), BOARD);
    let lens = ThinLens::new(100.0, 400.0, Aperture::Circle, 35.0);
    let system = with(&plain, Effects { lens: Lens::Thin(lens), ..Effects::default() });
    let exit = |point: DVec2| {
        let variant =
            biprism::effect::Variant { pupil: point, slopes: [DVec2::ZERO; 2], wave: None, grey: 1.0, colour: None };
        system.variant(&variant).exit_ray(DVec2::new(32.0, 18.0)).unwrap().0
    };
    // Where two rays, little above and below the middle one of the pupil, come together along z.
    let intersect = |axis: DVec2, pick: fn(DVec3) -> f64| {
        let (a, b) = (exit(1e-2 * axis), exit(-1e-2 * axis));
        let (slope_a, slope_b) = (pick(a.direction) / a.direction.z, pick(b.direction) / b.direction.z);
        let at = |ray: &biprism::geom::Ray, slope: f64| pick(ray.origin) - slope * ray.origin.z;
        (at(&b, slope_b) - at(&a, slope_a)) / (slope_a - slope_b)
    };
    let tangential = intersect(DVec2::X, |v| v.x);
    let sagittal = intersect(DVec2::Y, |v| v.y);
    let (n, t) = (1.48f64, 20.0);
    let root = (n * n - libm::sin(angle) * libm::sin(angle)).sqrt();
    let expected = t * (1.0 / root - n * n * libm::cos(angle) * libm::cos(angle) / (root * root * root));
    // Third-order aberrations of a pencil of 0.01 mm over 400 mm: 1e-9 of the 400 mm.
    assert!((tangential - sagittal - expected).abs() < 1e-5, "{} {expected}", tangential - sagittal);
    // Both are behind the focus without the plate.
    assert!(sagittal > 400.0 && tangential > sagittal, "{sagittal} {tangential}");
}

/// The spread of random sets tells the error of their mean, and the target of noise is met.
#[test]
fn the_error_estimate_is_the_error() {
    // The level's error is the same in all pictures: the coarsest will do.
    let mut plain = scene(32, 6, FLAT, BOARD);
    plain.accuracy = Accuracy::draft();
    let lens = Lens::Thin(ThinLens::new(2.0, 600.0, Aperture::Circle, 35.0));
    let of = |quadrature| {
        render_wanted(&with(&plain, Effects { lens, quadrature, ..Effects::default() }), Outputs { truth: false }, &())
    };
    let truth = of(Quadrature { points: 2048, ..Quadrature::default() });
    assert!(truth.noise.is_none() && truth.account.noise.is_none());
    let mean_square = |values: &mut dyn Iterator<Item = f64>| {
        let values: Vec<f64> = values.collect();
        values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64
    };
    let few = Quadrature { points: 16, replicates: 16, noise: None, seed: 7, ..Quadrature::default() };
    let film = of(few);
    assert_eq!(film.account.passes, 16 * 16);
    // All pixels share the shifts of a set, so a picture's error is one draw of few. The mean square of 12 draws strays by
    // sqrt(2 / 12) of itself, the spread of 16 sets by sqrt(2 / 15), over 12 draws again: three times that is below 1.3.
    let (mut error, mut told) = (0.0, 0.0);
    for seed in 0..12 {
        let film = of(Quadrature { seed, ..few });
        let pixels = film.radiance.data().iter().zip(truth.radiance.data());
        error += mean_square(&mut pixels.map(|(a, b)| f64::from(a - b))) / 12.0;
        told += mean_square(&mut film.noise.as_ref().unwrap().data().iter().map(|v| f64::from(*v))) / 12.0;
    }
    println!("standard error of 16 sets of 16 points: told {:.2e}, found {:.2e}", told.sqrt(), error.sqrt());
    assert!(error < 2.3 * told && told < 2.3 * error, "{error} {told}");
    // Twice the error of 16 sets is all but surely reached by fewer, and reported.
    let target = 2.0 * film.account.noise.unwrap();
    let stopped = of(Quadrature { noise: Some(target), ..few });
    let sets = stopped.account.passes / 16;
    assert!((4..16).contains(&sets) && stopped.account.noise.unwrap() <= target, "{sets}");
    // The same seed makes the same picture, another does not.
    assert!(of(few).radiance == film.radiance);
    assert!(of(Quadrature { seed: 8, ..few }).radiance != film.radiance);
}

/// Out of focus an edge is where it was, however few points the pupil has: without a prism each of them moves the picture
/// by its own share of the blur, and their middle is on the axis.
#[test]
fn an_edge_out_of_focus_stays_in_its_place() {
    let board = "columns = 2\nrows = 1\nsquare_mm = 1000.0\nposition_mm = [1.3, 0.0, 1000.0]\nmargin_mm = 0";
    let plain = scene(192, 6, NO_GLASS, board);
    let sharp = picture(&built(&plain));
    let row = |picture: &Raster<f32>, j| picture.row(j).iter().map(|v| f64::from(*v)).sum::<f64>();
    let polygon = |blades| Aperture::Polygon { blades, rotation_rad: 0.2 };
    for aperture in [Aperture::Circle, polygon(3), polygon(5), polygon(6), polygon(7)] {
        let lens = Lens::Thin(ThinLens::new(2.0, 600.0, aperture, 35.0));
        for (points, replicates) in [(1, 1), (7, 1), (16, 1), (64, 1), (16, 4)] {
            let quadrature = Quadrature { points, replicates, ..Quadrature::default() };
            let found = picture(&with(&plain, Effects { lens, quadrature, ..Effects::default() }));
            for j in 0..6 {
                let moved_px = (row(&found, j) - row(&sharp, j)).abs() / 0.8;
                // 192 radiances, each rounded to f32 in its pass and in the mean.
                assert!(moved_px < 192.0 * f64::from(f32::EPSILON), "{aperture:?} {points} {j}: {moved_px} px");
            }
        }
    }
}

/// A picture that is the same upside down is so out of focus as well.
#[test]
fn a_symmetric_picture_stays_symmetric() {
    let lens = Lens::Thin(ThinLens::new(2.0, 600.0, Aperture::Circle, 35.0));
    let telecentric = Lens::Telecentric(Telecentric { magnification: 0.05, na: 0.01, focus_mm: 400.0 });
    let quadrature = Quadrature { points: 8, ..Quadrature::default() };
    for lens in [lens, telecentric] {
        let effects = Effects { lens, quadrature, ..Effects::default() };
        for prism in [NO_GLASS, FLAT, FREEFORM] {
            let found = picture(&with(&scene(96, 54, prism, BOARD), effects.clone()));
            for (a, b) in found.data().iter().zip(found.data().iter().rev()) {
                // Two maps, each within 1e-8 px of its rays and their bends within 5e-6 px, of a contrast of 0.8 along two
                // lines; and roundings to f32.
                assert!((a - b).abs() < 4.0 * 5e-6 * 0.8 + 4.0 * f32::EPSILON, "{prism}: {a} {b}");
            }
        }
    }
}
