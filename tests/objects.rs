//! Are scenes with several planes rendered as the nearest of them looks, to the promise of each level, and is their truth true?

use crate::command::{biprism, text};
use crate::instruments::{BOARD, FLAT, FREEFORM, NO_GLASS, built, picture};
use biprism::accuracy::{Accuracy, Level};
use biprism::analysis::stereo_truth::StereoTruth;
use biprism::geom::{Pose, Ray};
use biprism::io::exr::{ChannelSamples, read_channels};
use biprism::render::render;
use biprism::render::supersample::{SamplePlaces, supersampled};
use biprism::scene::{self, Scene};
use biprism::system::System;
use biprism::system::aim::Aimer;
use exr::meta::MetaData;
use exr::prelude::{AttributeValue, Text};
use glam::{DVec2, DVec3};
use std::fs;

const SAMPLES: usize = 64;

/// A nearer plane of noise, a plane of squares that passes through it, and one behind the board.
const OBJECTS: &str = "[[object]]\ncolumns = 4\nrows = 3\nsquare_mm = 30.0\nposition_mm = [-40.0, 5.0, 800.0]\n\
                       tilt_deg = [0.0, 15.0, 10.0]\ntexture = { pattern = \"noise\", finest_mm = 9.0 }\n\
                       [[object]]\ncolumns = 3\nrows = 5\nsquare_mm = 25.0\nmargin_mm = 6.0\nposition_mm = [-20.0, 0.0, 805.0]\n\
                       tilt_deg = [0.0, -35.0, 0.0]\n\
                       [[object]]\ncolumns = 9\nrows = 9\nsquare_mm = 40.0\nposition_mm = [150.0, 0.0, 1300.0]\n";

/// A scene over the paper's field.
fn scene_of(size: [usize; 2], prism: &str, board: &str, more: &str) -> Scene {
    scene_over(10560.0, size, prism, board, more)
}

/// A scene over so many um of the sensor.
fn scene_over(width_um: f64, size: [usize; 2], prism: &str, board: &str, more: &str) -> Scene {
    let pitch_um = width_um / size[0] as f64;
    let text = format!(
        "name = \"test\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = {}\nheight_px = {}\npixel_pitch_um = {pitch_um}\n\
         [prism]\n{prism}\n[board]\n{board}\n{more}\n",
        size[0], size[1]
    );
    scene::parse(&text, "test", None).unwrap_or_else(|problem| panic!("{problem}\n{text}"))
}

/// A board that leaves the middle of what lies behind it to be seen at its right.
fn small_board() -> String {
    BOARD.replace("columns = 41", "columns = 9") + "\ntexture = { pattern = \"noise\", finest_mm = 12.0 }"
}

/// Against 4096 samples a pixel, each of the nearest plane; a pixel with an edge misses it by half a sample along it. Levels against a
/// judge of a millionth of a pixel.
#[test]
fn pictures_are_the_means_of_samples_of_the_nearest() {
    let judge = Accuracy { bend_px: 1e-6, max_division: 1024, ..Accuracy::exact() };
    for prism in [NO_GLASS, FREEFORM] {
        let scene = scene_of([18, 4], prism, &small_board(), OBJECTS);
        let samples = supersampled(&built(&scene), SAMPLES, SamplePlaces::Grid);
        let reference = render(&built(&scene).with_accuracy(judge), &());
        for level in [Level::Draft, Level::Standard, Level::Exact] {
            let system = built(&scene).with_accuracy(level.accuracy());
            let own = render(&system, &());
            let mut beyond = 0;
            for ((own, sample), judge) in own.radiance.data().iter().zip(samples.data()).zip(reference.radiance.data())
            {
                // Up to four edges in a pixel, of the whole contrast.
                let off = f64::from((own - sample).abs());
                assert!(off < 4.0 * 0.4 / SAMPLES as f64, "{level:?} {prism}: {off:e}");
                let moved = (f64::from((own - judge).abs()) - 1e-7) / (0.8 * 2f64.sqrt());
                beyond += u64::from(moved > 2.0 * system.accuracy().promise_px);
            }
            // The ridge lies between two columns, so that no pixel has both it and an edge.
            let unpromised = own.account.unpromised_pixels + reference.account.unpromised_pixels;
            assert!(beyond == 0 && unpromised == 0, "{level:?} {prism}: {beyond} beyond, {unpromised} unpromised");
            assert!(own.object.is_some_and(|object| (0..4).all(|k| object.data().contains(&k))), "{level:?} {prism}");
        }
    }
}

/// Planes that pass through each other in the outer half of a pixel at the border of the picture, where no centre shows it.
#[test]
fn planes_that_cross_at_the_border_are_told_apart() {
    let scene = scene_over(5280.0, [18, 4], FREEFORM, &small_board(), OBJECTS);
    let samples = supersampled(&built(&scene), SAMPLES, SamplePlaces::Grid);
    let own = picture(&built(&scene));
    let off = own.data().iter().zip(samples.data()).map(|(own, sample)| (own - sample).abs()).fold(0.0, f32::max);
    assert!(off < 4.0 * 0.4 / SAMPLES as f32, "{off:e}");
}

/// The reference, ray by ray, against samples, without glass: up to sixteen edges in a pixel.
#[test]
fn the_reference_is_the_mean_of_samples_of_the_nearest() {
    let scene = scene_of([6, 2], NO_GLASS, &small_board(), OBJECTS);
    let samples = supersampled(&built(&scene), 4 * SAMPLES, SamplePlaces::Grid);
    let own = render(&built(&scene).with_accuracy(Accuracy::reference()), &());
    for (own, sample) in own.radiance.data().iter().zip(samples.data()) {
        assert!((own - sample).abs() < 4.0 * 0.4 / SAMPLES as f32, "{own} {sample}");
    }
}

/// What a ray meets first of planes that end, by rotations and divisions of its own.
fn nearest(scene: &Scene, ray: &Ray) -> Option<(usize, DVec3)> {
    let plates = std::iter::once((&scene.board, scene.board.squares_mm()))
        .chain(scene.objects.iter().map(|object| (&object.plate, object.size_mm())));
    let mut found: Option<(usize, f64)> = None;
    let mut plane = None;
    for (k, (plate, size_mm)) in plates.enumerate() {
        let Pose { rotation, translation_mm } = plate.world_from_board;
        let (right, down, normal) = (rotation.x_axis, rotation.y_axis, rotation.z_axis);
        let t = normal.dot(translation_mm - ray.origin) / normal.dot(ray.direction);
        let off = ray.origin + ray.direction * t - translation_mm;
        plane = plane.or(Some(t));
        let half = 0.5 * size_mm + plate.margin_mm;
        let on = off.dot(right).abs() <= half.x && off.dot(down).abs() <= half.y;
        if t > 0.0 && on && found.is_none_or(|(_, before)| t < before) {
            found = Some((k, t));
        }
    }
    found.or(plane.map(|t| (0, t))).map(|(k, t)| (k, ray.origin + ray.direction * t))
}

fn centre(k: usize, width: usize) -> DVec2 {
    DVec2::new((k % width) as f64 + 0.5, (k / width) as f64 + 0.5)
}

fn world(system: &System, object: usize, mm: DVec2) -> DVec3 {
    let board = if object == 0 { system.board() } else { system.layers()[object - 1].board() };
    board.world(mm)
}

/// Numbers and places of every pixel, by the ray behind the prism.
#[test]
fn the_truth_is_that_of_the_nearest() {
    for prism in [NO_GLASS, FREEFORM] {
        let scene = scene_of([60, 34], prism, &small_board(), OBJECTS);
        for level in [Level::Standard, Level::Exact] {
            let system = built(&scene).with_accuracy(level.accuracy());
            let film = render(&system, &());
            let (object, places) = (film.object.unwrap(), film.board_mm.unwrap());
            for k in 0..60 * 34 {
                let Ok((ray, _)) = system.exit_ray(centre(k, 60)) else { continue };
                let (wanted, at) = nearest(&scene, &ray).unwrap();
                assert_eq!(object.data()[k] as usize, wanted, "{prism} {level:?} {k}");
                let mm = places.data()[k].map(f64::from);
                assert!(world(&system, wanted, DVec2::from(mm)).distance(at) < 1e-3, "{prism} {level:?} {k}");
            }
        }
    }
}

/// The other pixel sees the same point of the same thing; and where there is none, no pixel of the other side does.
#[test]
fn what_is_hidden_from_one_half_has_no_other_pixel() {
    let scene = scene_of([60, 34], FREEFORM, &small_board(), OBJECTS);
    let system = built(&scene);
    let truth = StereoTruth::new(&system);
    let points: Vec<_> = (0..34).flat_map(|j| truth.row(j, 0..60)).map(|point| point.unwrap()).collect();
    let (mut both, mut hidden) = (0, 0);
    for (k, point) in points.iter().enumerate() {
        let at = world(&system, point.object, point.hit.board_mm);
        let (ray, _) = system.exit_ray(centre(k, 60)).unwrap();
        assert!(nearest(&scene, &ray).is_some_and(|(object, seen)| object == point.object && seen.distance(at) < 1e-9));
        match point.other_px {
            Some(px) => {
                both += 1;
                let (ray, side) = system.exit_ray(px).unwrap();
                let (object, seen) = nearest(&scene, &ray).unwrap();
                assert!(object == point.object && side != point.hit.side && seen.distance(at) < 1e-8, "{k}: {point:?}");
            }
            None => {
                hidden += usize::from(point.object == 0 && point.hit.board_mm.abs().max_element() < 75.0);
                // Through the other side it lies beyond the sensor or the ridge, or behind something else.
                let layer = if point.object == 0 { &system } else { &system.layers()[point.object - 1] };
                let Ok(px) = Aimer::new(layer).aim(point.hit.board_mm, point.hit.side.other()) else { continue };
                let seen = system.exit_ray(px).ok().filter(|(_, side)| *side != point.hit.side);
                let inside = px.cmpge(DVec2::ZERO).all() && px.cmple(DVec2::new(60.0, 34.0)).all();
                let object = seen.and_then(|(ray, _)| nearest(&scene, &ray)).map(|(object, _)| object);
                assert!(!inside || object != Some(point.object), "{k}: {point:?} {px}");
            }
        }
    }
    assert!(both > 500 && hidden > 10, "{both} {hidden}");
}

/// An object that hides all else is rendered as the board in its place, with every kind of effect; one that is hidden, or out of
/// sight, changes nothing.
#[test]
fn an_object_before_all_is_as_the_board_in_its_place() {
    let keys =
        "columns = 61\nrows = 41\nsquare_mm = 12.0\nposition_mm = [3.0, 2.0, 700.0]\ntilt_deg = [6.0, -9.0, 12.0]";
    let glass = FREEFORM.replace("1.48", "1.5168\nglass = \"N-BK7\"");
    for effects in [
        "",
        "[effect.thin_lens]\nf_number = 4.0\nfocus_mm = 900.0\n[quadrature]\npoints = 4",
        "[effect.diffraction]\nf_number = 8.0",
        "[effect.dispersion]\nlines_nm = [486.1, 656.3]\nresponse = \"nikon_d5100\"",
        "[effect.cos4]\n[effect.fresnel]\n[effect.sensor]\nfill_factor = 0.5",
    ] {
        let board = scene_of([40, 8], &glass, &format!("{keys}\nmargin_mm = 0.0"), effects);
        let before = scene_of([40, 8], &glass, BOARD, &format!("{effects}\n[[object]]\n{keys}"));
        let behind = scene_of(
            [40, 8],
            &glass,
            &format!("{keys}\nmargin_mm = 0.0"),
            &format!(
                "{effects}\n[[object]]\ncolumns = 3\nrows = 3\nsquare_mm = 20.0\nposition_mm = [0.0, 0.0, 1500.0]"
            ),
        );
        let [board, before, behind] = [board, before, behind].map(|scene| render(&built(&scene), &()));
        for other in [before, behind] {
            let pairs = board.radiance.data().iter().zip(other.radiance.data());
            // Maps of other halves, and f32. Pixels without promise are told.
            let beyond = pairs.filter(|(a, b)| (**a - **b).abs() > 2e-5).count() as u64;
            assert!(beyond <= other.account.unpromised_pixels, "{effects}: {beyond} of {}", other.account);
        }
    }
}

/// Ghosts of what stands where the board stood are those of the board, but for samples; of glass that reflects a sixth of the light at
/// each surface, so that they are bright.
#[test]
fn ghosts_are_of_the_nearest() {
    let keys =
        "columns = 61\nrows = 41\nsquare_mm = 60.0\nposition_mm = [3.0, 2.0, 900.0]\ntilt_deg = [6.0, -9.0, 12.0]";
    let effects = "[effect.fresnel]\n[effect.ghosts]\nsamples = 8";
    let glass = FLAT.replace("index = 1.48", "index = 2.4\nfacet_angle_deg = 1.0");
    let board = picture(&built(&scene_of([40, 8], &glass, &format!("{keys}\nmargin_mm = 0.0"), effects)));
    let dark = BOARD.to_owned() + "\nblack = 0.0\nwhite = 0.0\nbackground = 0.3";
    let own = picture(&built(&scene_of([40, 8], &glass, &dark, &format!("{effects}\n[[object]]\n{keys}"))));
    let most = board.data().iter().zip(own.data()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(most < 2e-3, "{most:e}");
}

/// The order in which objects stand in the file is none.
#[test]
fn the_order_of_objects_is_of_no_account() {
    let [first, second, third] = OBJECTS.split("[[object]]").skip(1).collect::<Vec<_>>()[..] else { panic!("three") };
    let turned = format!("[[object]]{third}[[object]]{second}[[object]]{first}");
    let [a, b] = [OBJECTS, &turned].map(|objects| picture(&built(&scene_of([40, 8], FLAT, &small_board(), objects))));
    let most = a.data().iter().zip(b.data()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(most < 1e-6, "{most:e}");
}

#[test]
fn objects_that_cannot_be_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let object = "[[object]]\ncolumns = 4\nrows = 3\nsquare_mm = 30.0\nposition_mm = [0.0, 0.0, ";
    for (objects, rule) in [
        (format!("{object}60.0]"), "`object[0].position_mm` puts a corner of the object at z = 60"),
        (
            format!("{object}900.0]\n{object}-10.0]"),
            "`object[1].position_mm` puts a corner of the object at a depth of -10",
        ),
        (format!("{object}900.0]\nbackground = 0.1"), "`object[0].background` is not a key"),
        (format!("{object}900.0]\ntexture = {{ image = \"none.png\" }}"), "`object[0].texture.image` is \"none.png\""),
        (format!("{object}900.0]\n").repeat(33), "`object` has 33 values"),
    ] {
        let scene = format!(
            "name = \"test\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = 64\nheight_px = 36\npixel_pitch_um = 165.0\n\
             [prism]\n{FLAT}\n[board]\n{BOARD}\n{objects}\n"
        );
        fs::write(folder.path().join("scene.toml"), scene).unwrap();
        let run = biprism(folder.path(), &["check", "scene.toml"]);
        assert!(run.status.code() == Some(2) && text(&run.stderr).contains(rule), "{rule}: {}", text(&run.stderr));
    }
}

/// Points, depths and numbers in the files, by rays of the test's own.
#[test]
fn files_tell_which_object_is_seen_and_where() {
    let folder = tempfile::tempdir().unwrap();
    let text_of = format!(
        "name = \"test\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = 60\nheight_px = 34\npixel_pitch_um = 176.0\n\
         [prism]\n{FREEFORM}\n[board]\n{}\n{OBJECTS}",
        small_board()
    );
    fs::write(folder.path().join("scene.toml"), &text_of).unwrap();
    let outs = ["--out", "a.exr", "--out", "a.npy"];
    let done = biprism(folder.path(), &[&["render", "scene.toml", "--stereo"][..], &outs].concat());
    assert!(done.status.success() && text(&done.stderr).contains("may hide corners"), "{}", text(&done.stderr));
    let names = ["object", "P.X", "P.Y", "P.Z", "Z"];
    let channels = read_channels(&folder.path().join("a.exr"), &names).unwrap();
    let values: Vec<Vec<f64>> = (channels.iter())
        .map(|channel| match &channel.samples {
            ChannelSamples::F32(plane) => plane.data().iter().map(|v| f64::from(*v)).collect(),
            ChannelSamples::U32(plane) => plane.data().iter().map(|v| f64::from(*v)).collect(),
        })
        .collect();
    let bytes = fs::read(folder.path().join("a.npy")).unwrap();
    let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    assert!(str::from_utf8(&bytes[10..start]).unwrap().contains("('seen_by', '<u4'), ('object', '<u4')]"));
    let records: Vec<&[u8]> = bytes[start..].chunks_exact(76).collect();

    let meta = MetaData::read_from_file(folder.path().join("a.exr"), true).unwrap();
    let Some(AttributeValue::Text(notes)) = meta.headers[0].own_attributes.other.get(&Text::from("biprism")) else {
        panic!("notes")
    };
    let notes: serde_json::Value = serde_json::from_str(&notes.to_string()).unwrap();
    let axis = |object: usize, name: &str| {
        DVec3::from_array([0, 1, 2].map(|k| notes["world_from_board"][object][name][k].as_f64().unwrap()))
    };

    let scene = scene::parse(&text_of, "test", None).unwrap();
    let system = built(&scene);
    assert_eq!(records.len(), 60 * 34);
    for (k, record) in records.iter().enumerate() {
        let (ray, _) = system.exit_ray(centre(k, 60)).unwrap();
        let (object, at) = nearest(&scene, &ray).unwrap();
        let told = u32::from_le_bytes(*record[72..].first_chunk().unwrap());
        assert!(told as usize == object && values[0][k] == f64::from(told), "{k}: {told} {object}");
        let off = DVec3::new(values[1][k], values[2][k], values[3][k]) - at;
        // f32 of places of up to 1300 mm.
        assert!(off.abs().max_element() < 1e-3 && (values[4][k] - at.z).abs() < 1e-3, "{k}: {off}");
        let mm = [0, 8].map(|at| f64::from_le_bytes(*record[at..].first_chunk().unwrap()));
        assert!(world(&system, object, DVec2::from(mm)).distance(at) < 1e-9, "{k}");
        let noted = axis(object, "origin_mm") + axis(object, "u") * mm[0] + axis(object, "v") * mm[1];
        assert!(noted.distance(at) < 1e-9, "{k}: {noted}");
    }
}

/// In a larger picture, which the map stands for, it is that of rays.
#[test]
fn maps_and_rays_agree() {
    let scene = scene_of([480, 68], FREEFORM, &small_board(), &format!("{OBJECTS}[effect.cos4]"));
    let [map, rays] = [Level::Standard, Level::Exact].map(|level| {
        let film = render(&built(&scene).with_accuracy(level.accuracy()), &());
        (film.account.mapped, film)
    });
    assert!(map.0 > 0.9 && rays.0 == 0.0, "{} {}", map.0, rays.0);
    let pairs = map.1.radiance.data().iter().zip(rays.1.radiance.data());
    let most = pairs.map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max);
    assert!(most < 2.0 * 1e-5 * 0.8 * 2f64.sqrt(), "{most:e}");
    assert_eq!(map.1.object, rays.1.object);
}
