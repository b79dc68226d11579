//! Does every effect change the picture by what theory says, and nothing else?

use crate::instruments::{BOARD, FLAT, FREEFORM, NO_GLASS, built, edge_integral, picture, scene, scene_from, with};
use biprism::accuracy::{Accuracy, Level};
use biprism::effect::thin_lens::Aperture;
use biprism::effect::{
    Clipping, EffectId, Effects, Hook, Lens, Manufacture, Quadrature, Sensor, TABLE, Telecentric, ThinLens, Variant,
};
use biprism::render::{self, Class, Film, Outputs, Plan, render, render_wanted};
use biprism::scene::{self, Scene};

use glam::{DVec2, DVec3};
use std::path::Path;

/// Takes the strength of an effect away.
type Zero = fn(&mut Effects);

/// A zero for every effect.
const ZEROES: [(&str, Zero); 14] = [
    ("thin_lens", |e| {
        if let Lens::Thin(lens) = &mut e.lens {
            lens.radius_mm = 0.0;
        }
    }),
    // A telecentric lens is another camera at any strength.
    ("telecentric", |e| e.lens = Lens::Pinhole),
    ("clipping", |e| e.clipping.iter_mut().for_each(|e| *e = Clipping::default())),
    ("manufacture", |e| e.manufacture.iter_mut().for_each(|e| *e = Manufacture::default())),
    ("roughness", |e| e.roughness.iter_mut().for_each(|e| e.slope = [0.0; 2])),
    ("cos4", |e| e.cos4.iter_mut().for_each(|e| e.exponent = 0.0)),
    ("lamp", |e| e.lamp.iter_mut().for_each(|e| e.share = 0.0)),
    ("diffraction", |e| e.diffraction.iter_mut().for_each(|e| e.f_number = 0.0)),
    ("sensor", |e| {
        e.sensor.iter_mut().for_each(|e| *e = Sensor { seed: e.seed, white_e: e.white_e, ..Sensor::IDEAL });
    }),
    // Reflection has no strength but that of the indices: see `tests/light.rs`.
    ("fresnel", |e| e.fresnel = None),
    ("coating", |e| e.coating.iter_mut().for_each(|e| e.layer.thickness_nm = 0.0)),
    ("absorption", |e| e.absorption.iter_mut().for_each(|e| e.per_mm = 0.0)),
    ("ghosts", |e| e.ghosts.iter_mut().for_each(|e| e.bounces = 0)),
    ("dispersion", |e| {
        e.dispersion.iter_mut().for_each(|e| e.waves.iter_mut().for_each(|wave| wave.index_shift = 0.0));
    }),
];

fn bits(film: &Film) -> (Vec<u32>, &[Class], Vec<[u32; 2]>) {
    let radiance = film.radiance.data().iter().map(|v| v.to_bits()).collect();
    let (class, board_mm) = (film.class.as_ref().unwrap(), film.board_mm.as_ref().unwrap());
    (radiance, class.data(), board_mm.data().iter().map(|p| p.map(f32::to_bits)).collect())
}

fn case(key: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/cases/effect_{key}.toml"));
    scene::load(&path).unwrap_or_else(|problem| panic!("{problem}"))
}

/// Strength 0 is absent, bit for bit; strength as in the case is not; and only its own effect acts in a case.
#[test]
fn an_effect_acts_when_it_is_called_for_and_not_otherwise() {
    for row in &TABLE {
        let scene = case(row.key());
        let acting: Vec<&str> = scene.effects.acting().map(|row| row.key()).collect();
        let base = row.needs.map(EffectId::key);
        assert_eq!(acting, base.into_iter().chain([row.key()]).collect::<Vec<_>>());
        let bare = Effects { fresnel: scene.effects.fresnel.filter(|_| base == Some("fresnel")), ..Effects::default() };
        let absent = render(&with(&scene, bare), &());
        let mut zero = scene.effects.clone();
        let (_, take_away) = ZEROES.iter().find(|(key, _)| *key == row.key()).expect("a zero for each effect");
        take_away(&mut zero);
        let zero = render(&with(&scene, zero), &());
        assert!(bits(&zero) == bits(&absent) && zero.counts == absent.counts, "{}", row.key());
        let acted = render(&built(&scene), &());
        assert!(acted.radiance != absent.radiance, "{} changes nothing", row.key());
        // What is true of a picture does not depend on what dims its light, but on the instrument and on the light's colour.
        let own = row.hook != Hook::Instrument && row.id != EffectId::Dispersion;
        assert!(!own || (bits(&acted).1 == bits(&absent).1 && bits(&acted).2 == bits(&absent).2), "{}", row.key());
    }
}

#[test]
fn every_effect_has_its_table_in_the_schema() {
    let schema: serde_json::Value = serde_json::from_str(&scene::schema_json()).unwrap();
    let mut keys: Vec<&str> = TABLE.iter().map(|row| row.key()).collect();
    let mut tables: Vec<&str> =
        schema["properties"]["effect"]["properties"].as_object().unwrap().keys().map(String::as_str).collect();
    keys.sort_unstable();
    tables.sort_unstable();
    assert_eq!(keys, tables);
}

/// A scene that says `effects = "none"` is as good as one without tables.
#[test]
fn effects_none_switches_all_of_them_off() {
    let text = |effects: &str, tables: &str| {
        format!(
            "name = \"t\"\n{effects}\n[camera]\nfocal_length_mm = 35\nwidth_px = 64\nheight_px = 36\n\
             pixel_pitch_um = 165\n[prism]\nkind = \"none\"\n[board]\n{BOARD}\n{tables}"
        )
    };
    let tables = "[effect.cos4]\n[effect.thin_lens]\nf_number = 2\nfocus_mm = 500\n";
    let parsed = |effects, tables| scene::parse(&text(effects, tables), "test", None).unwrap_or_else(|p| panic!("{p}"));
    assert_eq!(parsed("effects = \"none\"", tables), parsed("", ""));
    assert_eq!(parsed("effects = \"all\"", tables), parsed("", tables));
    assert_ne!(parsed("", tables), parsed("", ""));
}

/// Surroundings of one radiance stay so through every effect that takes no light away, at every level of accuracy.
#[test]
fn a_white_furnace_stays_white() {
    // Ghosts bring back what surfaces reflect: see `tests/light.rs`; what is clipped is gone.
    let keeps = |key| !["ghosts", "clipping"].contains(&key);
    for row in TABLE.iter().filter(|row| row.hook != Hook::Transport && keeps(row.key())) {
        let mut scene = case(row.key());
        scene.board.black = 0.7;
        scene.board.white = 0.7;
        scene.board.background = 0.7;
        scene.effects.quadrature.points = 4;
        let camera = &mut scene.camera;
        (camera.width_px, camera.height_px, camera.pitch_mm) = (6, 3, 20.0 * camera.pitch_mm);
        // Of a sensor's picture only the mean is even, and that is judged with its noise.
        if scene.effects.is_random() {
            continue;
        }
        for level in Level::ALL {
            let system = built(&scene).with_accuracy(level.accuracy());
            for value in picture(&system).data() {
                // Each of the passes rounds to f32, and so does their sum.
                assert!((value - 0.7).abs() <= 2.0 * f32::EPSILON, "{} {level:?}: {value}", row.key());
            }
        }
    }
}

/// For every effect the test that holds what it does to a closed form or to an independent number.
const THEORY: [(&str, &str, &str); 14] = [
    ("lamp", "effects", "a_lamp_lights_each_place_by_its_distance_and_angle"),
    ("fresnel", "light", "the_picture_is_weaker_by_the_closed_form"),
    ("coating", "light", "a_layer_acts_at_its_own_wavelength"),
    ("absorption", "light", "glass_absorbs_along_its_length"),
    ("ghosts", "light", "the_ghost_of_a_plate_lies_where_its_two_reflections_send_it"),
    ("dispersion", "light", "colours_part_as_snells_law_says"),
    ("manufacture", "made", "surfaces_out_of_place_are_turned_planes"),
    ("roughness", "made", "a_rough_surface_blurs_by_its_slopes"),
    ("clipping", "lens", "a_chamfer_is_a_black_band_of_its_width"),
    ("telecentric", "lens", "telecentric_blur_is_the_cone_of_its_aperture"),
    ("thin_lens", "effects", "defocus_is_the_blur_circle_of_the_thin_lens_equation"),
    ("cos4", "effects", "light_falls_by_the_fourth_power_of_the_cosine"),
    ("diffraction", "film", "a_rendered_edge_is_blurred_as_the_transfer_function_says"),
    ("sensor", "film", "a_rendered_wall_shows_the_noise_of_its_electrons"),
];

#[test]
fn every_effect_has_its_test_of_theory() {
    for row in &TABLE {
        let (_, file, test) = THEORY.iter().find(|(key, ..)| *key == row.key()).expect("a test for each effect");
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/{file}.rs"));
        let text = std::fs::read_to_string(path).unwrap();
        assert!(text.contains(&format!("#[test]\nfn {test}()")), "{}: {file} {test}", row.key());
    }
}

/// A straight edge out of focus has the profile that the thin lens equation gives: that of a disk of the diameter
/// D s' |1/focus - 1/depth|, averaged over each pixel.
#[test]
fn defocus_is_the_blur_circle_of_the_thin_lens_equation() {
    // One edge in the middle of the picture, black to the left.
    let board = "columns = 2\nrows = 1\nsquare_mm = 1000.0\nposition_mm = [0.0, 0.0, 1000.0]\nmargin_mm = 0";
    let plain = scene(192, 1, NO_GLASS, board);
    let pitch_mm = plain.camera.pitch_mm;
    for (f_number, focus_mm) in [(2.0, 600.0), (1.4, 700.0), (2.0, 1800.0)] {
        let lens = ThinLens::new(f_number, focus_mm, Aperture::Circle, 35.0);
        let radius_px = 0.5 * lens.blur_mm(1000.0, 35.0) / pitch_mm;
        assert!(radius_px > 2.0, "{radius_px}");
        let points = 1024;
        let quadrature = Quadrature { points, ..Quadrature::default() };
        let system = with(&plain, Effects { lens: Lens::Thin(lens), quadrature, ..Effects::default() });
        let found = picture(&system);
        for (i, value) in found.row(0).iter().enumerate() {
            let place = |x: f64| (x - 96.0) / radius_px;
            let (from, to) = (place(i as f64), place(i as f64 + 1.0));
            let white = (edge_integral(to) - edge_integral(from)) * radius_px;
            let expected = 0.05 + 0.8 * white;
            // n points of an even set count an area to log(n) / n of it, at worst.
            let bound = 0.8 * libm::log(points as f64) / points as f64;
            assert!((f64::from(*value) - expected).abs() < bound, "{i}: {value} {expected}");
        }
    }
}

/// In focus, an edge is as sharp as through the pinhole.
#[test]
fn the_plane_in_focus_is_sharp() {
    let plain = scene(192, 108, NO_GLASS, BOARD);
    let lens = ThinLens::new(2.0, 1000.0, Aperture::Circle, 35.0);
    let system = with(&plain, Effects { lens: Lens::Thin(lens), ..Effects::default() });
    let (sharp, found) = (picture(&built(&plain)), picture(&system));
    for (a, b) in sharp.data().iter().zip(found.data()) {
        // Every point of the pupil sees the same place, to the rounding of f32.
        assert!((a - b).abs() < 4.0 * f32::EPSILON, "{a} {b}");
    }
}

/// The error of the mean over n points of the pupil falls nearly as 1/n: n^-1 log n is what even sets reach for a
/// blurred edge, n^-1/2 what random ones do.
#[test]
fn depth_of_field_converges_faster_than_random_points() {
    // The level's error is the same in all pictures: the coarsest will do.
    let mut plain = scene(64, 18, FLAT, BOARD);
    plain.accuracy = Accuracy::draft();
    let lens = ThinLens::new(2.0, 500.0, Aperture::Circle, 35.0);
    let by = |points: usize| {
        let quadrature = Quadrature { points, ..Quadrature::default() };
        picture(&with(&plain, Effects { lens: Lens::Thin(lens), quadrature, ..Effects::default() }))
    };
    // The mean over a sunflower of points (Vogel, Mathematical Biosciences 44 (1979) 179), made without the program's own
    // set: of that the error could fall towards a wrong picture.
    let system = with(&plain, Effects { lens: Lens::Thin(lens), ..Effects::default() });
    let golden_rad = std::f64::consts::PI * (3.0 - 5.0f64.sqrt());
    let mut reference = vec![0.0; 64 * 18];
    let many = 2048;
    for k in 0..many {
        let radius_mm = lens.radius_mm * ((f64::from(k) + 0.5) / f64::from(many)).sqrt();
        let (sin, cos) = libm::sincos(golden_rad * f64::from(k));
        let pupil = radius_mm * DVec2::new(cos, sin);
        let variant = Variant { pupil, slopes: [DVec2::ZERO; 2], wave: None, grey: 1.0, colour: None };
        let film = render::picture(&Plan::new(&system.variant(&variant)), Outputs { truth: false }, &());
        reference.iter_mut().zip(film.radiance.data()).for_each(|(sum, v)| *sum += f64::from(*v) / f64::from(many));
    }
    let error = |points: usize| {
        let found = by(points);
        let squares = found.data().iter().zip(&reference).map(|(a, b)| (f64::from(*a) - b) * (f64::from(*a) - b));
        (squares.sum::<f64>() / reference.len() as f64).sqrt()
    };
    let (few, many) = (error(8), error(128));
    let order = libm::log(few / many) / libm::log(16.0);
    println!("rms error of 8 and 128 points of the pupil: {few:.2e}, {many:.2e}, order {order:.2}");
    assert!(order > 0.75, "order {order}: {few} at 8 points, {many} at 128");
}

/// Points that stand for the parts of the pupil around them are off by three quarters or less of what they are without, whatever the
/// lens and the way of the board's lines, even of a wide pupil whose ridge is everywhere; and as they grow many, they give the same picture.
#[test]
fn points_that_stand_for_their_parts_tell_more() {
    let thin = |f_number, aperture| Lens::Thin(ThinLens::new(f_number, 500.0, aperture, 35.0));
    let hexagon = Aperture::Polygon { blades: 6, rotation_rad: 0.0 };
    let cone = Lens::Telecentric(Telecentric { magnification: 2.5, na: 0.02, focus_mm: 190.0 });
    let near = "columns = 41\nrows = 41\nsquare_mm = 1.0\nposition_mm = [0.0, 0.0, 200.0]";
    let coarse = "columns = 21\nrows = 21\nsquare_mm = 20.0\nposition_mm = [0.0, 0.0, 1000.0]";
    let turned = format!("{coarse}\ntilt_deg = [0.0, 0.0, 20.0]");
    let cases = [
        (FLAT, coarse, thin(2.0, Aperture::Circle)),
        (FREEFORM, turned.as_str(), thin(2.8, hexagon)),
        (FLAT, near, cone),
    ];
    for (prism, board, lens) in cases {
        let mut plain = scene(192, 108, prism, board);
        plain.accuracy = Accuracy::draft();
        let by = |points: usize, fill: bool| {
            let quadrature = Quadrature { points, fill, ..Quadrature::default() };
            picture(&with(&plain, Effects { lens, quadrature, ..Effects::default() }))
        };
        let reference = by(1024, false);
        let error = |points: usize, fill: bool| {
            let squares = by(points, fill)
                .data()
                .iter()
                .zip(reference.data())
                .map(|(a, b)| f64::from(a - b) * f64::from(a - b))
                .sum::<f64>();
            (squares / reference.data().len() as f64).sqrt()
        };
        let by_points = |fill: bool| [16, 32].map(|points| error(points, fill));
        let (filled, others, many) = (by_points(true), by_points(false), error(256, true));
        println!("16 and 32 points: filled {filled:?}, others {others:?}; 256 filled {many:.2e}");
        assert!((0..2).all(|k| filled[k] < 0.75 * others[k]) && many < 0.2 * filled[0], "{lens:?}");
    }
}

/// cos^4 of the angle to the axis, to the rounding of f32; behind a prism as without one, for the law is the lens's.
#[test]
fn light_falls_by_the_fourth_power_of_the_cosine() {
    for prism in [NO_GLASS, FLAT, FREEFORM] {
        let plain = scene(192, 108, prism, BOARD);
        let effects = Effects { cos4: Some(biprism::effect::Cos4 { exponent: 4.0 }), ..Effects::default() };
        let (before, after) = (picture(&built(&plain)), picture(&with(&plain, effects)));
        for (j, i) in (0..108).flat_map(|j| (0..192).map(move |i| (j, i))) {
            let at = DVec2::new(f64::from(i) + 0.5 - 96.0, f64::from(j) + 0.5 - 54.0) * plain.camera.pitch_mm / 35.0;
            let square = 1.0 + at.length_squared();
            let factor = 1.0 / (square * square);
            let (before, after) = (before.get(i as usize, j as usize), after.get(i as usize, j as usize));
            let expected = f64::from(before) * factor;
            // Beside the ridge each piece of a pixel has a factor of its own, which differs by 2e-4 over a pixel here.
            let bound = if (95..97).contains(&i) { 2e-4 } else { f64::from(f32::EPSILON) };
            assert!((f64::from(after) - expected).abs() <= bound * expected, "({i}, {j}): {after} {expected}");
        }
    }
}

/// A thin lens loses light towards the rim by the same law, each point of its aperture by its own angle: the mean of
/// cos^4 over a disk of radius a at the distance d, on the axis, is d^2 / (d^2 + a^2).
#[test]
fn the_law_holds_for_every_point_of_a_pupil() {
    let flat = "columns = 3\nrows = 3\nsquare_mm = 2000\nposition_mm = [0.0, 0.0, 1000.0]\nblack = 1\nwhite = 1";
    let plain = scene(331, 1, NO_GLASS, flat);
    let lens = ThinLens::new(1.0, 1e12, Aperture::Circle, 35.0);
    let cos4 = Some(biprism::effect::Cos4 { exponent: 4.0 });
    let effects = Effects {
        lens: Lens::Thin(lens),
        cos4,
        quadrature: Quadrature { points: 1024, ..Quadrature::default() },
        ..Effects::default()
    };
    let found = f64::from(picture(&with(&plain, effects)).get(165, 0));
    // The integral of 2 r / (1 + r^2)^2 over 0..t is t^2 / (1 + t^2), over the area t^2: 1 / (1 + t^2), with t = a/d = 1/2.
    assert!((found - 0.8).abs() < 1e-5, "{found}");
}

/// Every pixel gets what its own place on the board gets from the lamp.
#[test]
fn a_lamp_lights_each_place_by_its_distance_and_angle() {
    let lamp = "[effect.lamp]\nposition_mm = [-300, 200, 100]\nshare = 0.75\n";
    let board = format!("{BOARD}\ntilt_deg = [10.0, -25.0, 3.0]");
    let lit = scene_from(288, 162, "", FREEFORM, &format!("{board}\n{lamp}"));
    let dark = scene(288, 162, FREEFORM, &board);
    let (before, after) = (render(&built(&dark), &()), render(&built(&lit), &()));
    let pose = lit.board.world_from_board;
    let at = |mm: [f32; 2]| {
        let way = DVec3::new(-300.0, 200.0, 100.0) - pose.point(DVec3::new(f64::from(mm[0]), f64::from(mm[1]), 0.0));
        way.dot(pose.rotation.z_axis).abs() / (way.length_squared() * way.length())
    };
    let places = before.board_mm.as_ref().unwrap().data();
    for (k, (before, after)) in before.radiance.data().iter().zip(after.radiance.data()).enumerate() {
        let seen = places[k];
        if (143..145).contains(&(k % 288)) {
            continue;
        }
        let factor = 0.25 + 0.75 * at(seen) / at([0.0, 0.0]);
        let expected = f64::from(*before) * factor;
        // Positions of the truth are f32: 1e-7 of 200 mm over 1 m; radiances too.
        assert!((f64::from(*after) - expected).abs() < 4e-7 * expected, "{k}: {after} {expected}");
    }
}

/// A lamp so near that its light falls steeply across a pixel: each gets the mean over its places, cut by the ground ridge or
/// not.
#[test]
fn a_lamp_close_to_the_board_lights_all_places_of_a_pixel() {
    const PLACES: usize = 96;
    let lamp = "[effect.lamp]\nposition_mm = [25, 30, 980]\n[effect.clipping]\nchamfer_mm = 0.05\n";
    let board = BOARD.replace("square_mm = 10.0", "square_mm = 80.0\ntilt_deg = [0.0, 0.0, 7.0]");
    let system = built(&scene_from(16, 9, "", FLAT, &format!("{board}\n{lamp}")));
    let board = system.board().pattern;
    let light = |px: DVec2| {
        let Ok(sight) = system.trace(px) else { return 0.0 };
        let cell =
            (sight.board_mm / board.square_mm + DVec2::new(board.columns as f64, board.rows as f64) / 2.0).floor();
        let black = (cell.x + cell.y).rem_euclid(2.0) == 0.0;
        system.throughput(px) * if black { board.black } else { board.white }
    };
    let found = picture(&system);
    let brightest = found.data().iter().fold(0.0f32, |most, v| most.max(*v));
    let mut worst: f64 = 0.0;
    for (k, value) in found.data().iter().enumerate() {
        let corner = DVec2::new((k % 16) as f64, (k / 16) as f64);
        let place = |i: usize| (DVec2::new((i % PLACES) as f64, (i / PLACES) as f64) + 0.5) / PLACES as f64;
        let mean = (0..PLACES * PLACES).map(|i| light(corner + place(i))).sum::<f64>() / (PLACES * PLACES) as f64;
        worst = worst.max((f64::from(*value) - mean).abs() / f64::from(brightest));
    }
    // Places in a row see an edge a hundredth of a pixel off at most, and its slant makes up for most of that.
    println!("{worst:.1e} of the brightest pixel");
    assert!(worst < 3e-3, "{worst}");
}

/// Wavelengths are fixed: a second set of random points would be the first picture once more.
#[test]
fn what_draws_no_points_takes_one_set() {
    let mut scene = case("dispersion");
    let of = |scene: &Scene| render_wanted(&built(scene), Outputs { truth: false }, &());
    let once = of(&scene);
    scene.effects.quadrature.replicates = 8;
    let film = of(&scene);
    assert_eq!(film.account.passes, once.account.passes);
    assert!(film.noise.is_none() && film.account.noise.is_none());
    assert!(film.radiance == once.radiance);
}
