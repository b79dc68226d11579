//! Is what a picture says of its stereo pair true: depth, distance, the pixel of the other half, disparity, who sees what?

use crate::command::{biprism, text};
use crate::instruments::{BOARD, FLAT, FREEFORM, NO_GLASS, built, scene_from};
use biprism::analysis::stereo_truth::{StereoPoint, StereoTruth};
use biprism::io::exr::{ChannelSamples, read_channels};
use biprism::optics::fate::Fate;
use biprism::scene::{self, Scene};
use biprism::system::{Side, System};
use glam::{DVec2, DVec3};
use std::fs;
use std::path::Path;

const WIDTH: usize = 48;
const HEIGHT: usize = 28;

/// Prisms and boards, the last ones with a prism off the middle and with a camera that is turned and distorts.
fn scenes() -> Vec<Scene> {
    let posed = BOARD.replace("[0.0, 0.0, 1000.0]", "[5.0, 3.0, 900.0]\ntilt_deg = [8.0, -31.0, 27.0]");
    let shifted = FLAT.to_owned() + "\nposition_mm = [0.8, 0.3, 0.0]\ntilt_deg = [0.5, -0.8, 1.5]";
    let turned =
        "position_mm = [0.3, 0.1, -2.0]\nrotation_deg = [0.4, -0.3, 0.5]\ndistortion = [0.1, 0.0, 0.0, 0.0, 0.0]";
    let of = |camera: &str, prism: &str, board: &str| scene_from(WIDTH, HEIGHT, camera, prism, board);
    vec![of("", FREEFORM, BOARD), of("", FLAT, &posed), of("", &shifted, &posed), of(turned, FREEFORM, &posed)]
}

fn centre(k: usize) -> DVec2 {
    DVec2::new((k % WIDTH) as f64 + 0.5, (k / WIDTH) as f64 + 0.5)
}

/// All pixels as the files have them: row by row, each search from the pixel before.
fn all(system: &System) -> Vec<Result<StereoPoint, Fate>> {
    let truth = StereoTruth::new(system);
    (0..HEIGHT).flat_map(|j| truth.row(j, 0..WIDTH)).collect()
}

/// What a ray of the other pixel sees is the same point, through the other side, and from there the first pixel is found again.
#[test]
fn the_other_pixel_sees_the_same_point() {
    for scene in scenes() {
        let system = built(&scene);
        let truth = StereoTruth::new(&system);
        let half = (WIDTH / 2) as f64;
        let mut both = 0;
        for (k, point) in all(&system).iter().enumerate() {
            let Ok(point) = point else { continue };
            let Some(other_px) = point.other_px else { continue };
            both += 1;
            let seen = system.trace(other_px).unwrap();
            assert!(seen.side == point.hit.side.other());
            // Newton's method ends below 1e-11 px of some 10 mm each, and positions round to 1e-13 mm.
            assert!(seen.board_mm.distance(point.hit.board_mm) < 1e-9, "{k}: {seen:?} {point:?}");
            let back = truth.at(other_px, None).unwrap();
            assert!(back.other_px.unwrap().distance(centre(k)) < 1e-9, "{k}: {back:?}");

            // Left less right, each in its own half.
            let (left, right) =
                if point.hit.side == Side::Left { (centre(k), other_px) } else { (other_px, centre(k)) };
            let expected = left - (right - DVec2::new(half, 0.0));
            for own in [point, &back] {
                assert!(own.disparity_px.unwrap().distance(expected) < 1e-9, "{k}: {own:?} {expected}");
            }
        }
        assert!(both > WIDTH * HEIGHT / 2, "{both}");
    }
}

/// Where one half alone is said to see a point, no centre of a pixel of the other one sees it or what lies within a quarter of a
/// pixel of it.
#[test]
fn what_one_half_alone_sees_no_pixel_of_the_other_does() {
    let mut alone = 0;
    for scene in scenes() {
        let system = built(&scene);
        let seen: Vec<_> = (0..WIDTH * HEIGHT).filter_map(|k| system.footprint(centre(k)).ok()).collect();
        for point in all(&system).into_iter().flatten().filter(|point| point.other_px.is_none()) {
            alone += 1;
            for other in seen.iter().filter(|other| other.sight.side != point.hit.side) {
                let off_px = other.jacobian.inverse() * (point.hit.board_mm - other.sight.board_mm);
                assert!(off_px.abs().max_element() > 0.25, "{point:?} {other:?}");
            }
        }
        // Without glass there are no two sides that see the same.
        let plain = built(&scene_from(WIDTH, HEIGHT, "", NO_GLASS, BOARD));
        assert!(all(&plain).into_iter().flatten().all(|point| point.disparity_px.is_none()));
    }
    assert!(alone > 100, "{alone}");
}

/// Depth and distance by the point itself, in the frame of a camera that is turned.
#[test]
fn depth_is_along_the_axis_of_the_camera() {
    for scene in scenes() {
        let system = built(&scene);
        let origin = scene.camera.position_mm;
        let rotation = scene.camera.calibration.rotation;
        for point in all(&system).into_iter().flatten() {
            let own: DVec3 = rotation.transpose() * (system.board().world(point.hit.board_mm) - origin);
            assert!((own.z - point.z_mm).abs() < 1e-9 && (own.length() - point.distance_mm).abs() < 1e-9, "{point:?}");
        }
    }
    let plain = built(&scenes()[0]);
    assert!(all(&plain).into_iter().flatten().all(|point| (point.z_mm - 1000.0).abs() < 1e-9));
}

/// A prism whose epipolar lines are the rows: no vertical disparity on a tilted board, and one disparity for each depth in each
/// row, as its law has it, but for what is cut of its surfaces.
#[test]
fn the_exact_prism_has_no_vertical_disparity() {
    let text = include_str!("../scenes/exact.toml");
    let mut scene = scene::parse(text, "exact.toml", None).unwrap();
    (scene.camera.width_px, scene.camera.height_px, scene.camera.pitch_mm) = (WIDTH, HEIGHT, 10.56 / WIDTH as f64);
    scene.board.world_from_board.rotation = biprism::geom::Pose::new(DVec3::ZERO, DVec3::new(0.2, -0.5, 0.1)).rotation;
    let system = built(&scene);
    let disparities: Vec<DVec2> = all(&system).into_iter().flatten().filter_map(|point| point.disparity_px).collect();
    assert!(disparities.len() > WIDTH * HEIGHT / 2);
    let worst = disparities.iter().fold(0.0f64, |most, px| most.max(px.y.abs()));
    // 1e-4 px of a sensor of 1920 columns.
    assert!(worst < 1e-4 * WIDTH as f64 / 1920.0, "{worst:e}");
}

/// A channel of an EXR, of either type.
fn plane(path: &Path, name: &str) -> (usize, Vec<f64>) {
    match &read_channels(path, &[name]).unwrap()[0].samples {
        ChannelSamples::F32(plane) => (plane.width(), plane.data().iter().map(|v| f64::from(*v)).collect()),
        ChannelSamples::U32(plane) => (plane.width(), plane.data().iter().map(|v| f64::from(*v)).collect()),
    }
}

fn same(a: f64, b: f64) -> bool {
    (a.is_nan() && b.is_nan()) || a == b
}

const NAMES: [&str; 14] = [
    "Y",
    "board.U",
    "board.V",
    "P.X",
    "P.Y",
    "P.Z",
    "class",
    "Z",
    "distance",
    "other.X",
    "other.Y",
    "disparity.X",
    "disparity.Y",
    "seen_by",
];

/// The halves of a picture with its truth are its columns; only the other pixel is counted in the other half. The table has what
/// the channels have, to an f32.
#[test]
fn halves_are_the_columns_of_the_whole() {
    for width in [36usize, 37] {
        let folder = tempfile::tempdir().unwrap();
        let pitch_um = 10560.0 / width as f64;
        let text_of = format!(
            "name = \"small\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = {width}\nheight_px = 20\npixel_pitch_um = {pitch_um}\n\
             [prism]\n{FREEFORM}\n[board]\n{BOARD}\ntexture = \"noise\"\n"
        );
        fs::write(folder.path().join("scene.toml"), text_of).unwrap();
        let run = |args: &[&str]| {
            let outs = ["--out", "a.exr", "--out", "a.npy", "--out", "a.png"];
            let done = biprism(folder.path(), &[&["render", "scene.toml", "--stereo"], args, &outs].concat());
            assert!(done.status.success(), "{}", text(&done.stderr));
        };
        run(&[]);
        run(&["--halves"]);
        let at = |name: &str| folder.path().join(name);
        let columns = width / 2;
        for (half, first, other) in [("left", 0, width.div_ceil(2)), ("right", width.div_ceil(2), 0)] {
            for name in &NAMES {
                let (own_width, own) = plane(&at(&format!("a_{half}.exr")), name);
                let (_, whole) = plane(&at("a.exr"), name);
                assert!(own_width == columns && own.len() == columns * 20);
                let shift = if *name == "other.X" { other as f64 } else { 0.0 };
                for (k, value) in own.iter().enumerate() {
                    let expected = whole[k / columns * width + first + k % columns];
                    let told = match *name {
                        "other.X" => {
                            same(*value, expected) && value.is_nan() || (value + shift - expected).abs() < 1e-5
                        }
                        _ => same(*value, expected),
                    };
                    assert!(told, "{name} {k}: {value} {expected}");
                }
            }
            let (png, _) = biprism::io::read(&at(&format!("a_{half}.png")), None).unwrap();
            let (whole, _) = biprism::io::read(&at("a.png"), None).unwrap();
            assert_eq!(png, whole.columns(first, first + columns));
            table(&at(&format!("a_{half}.npy")), columns, &at(&format!("a_{half}.exr")));
        }
        table(&at("a.npy"), width, &at("a.exr"));
    }
}

/// The table holds what the channels hold.
fn table(path: &Path, columns: usize, exr: &Path) {
    let bytes = fs::read(path).unwrap();
    let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let header = str::from_utf8(&bytes[10..start]).unwrap();
    let fields = "[('board_mm', '<f8', (2,)), ('class', '<u4'), ('Z_mm', '<f8'), ('distance_mm', '<f8'), \
                  ('other_px', '<f8', (2,)), ('disparity_px', '<f8', (2,)), ('seen_by', '<u4')]";
    assert!(header.contains(fields) && header.contains(&format!("'shape': (20, {columns})")), "{header}");
    assert_eq!(bytes.len() - start, 72 * 20 * columns);
    let place = [0, 8, 20, 28, 36, 44, 52, 60];
    let names = ["board.U", "board.V", "Z", "distance", "other.X", "other.Y", "disparity.X", "disparity.Y"];
    let (seen_by, disparity) = (plane(exr, "seen_by").1, plane(exr, "disparity.X").1);
    for (name, at) in names.into_iter().zip(place) {
        let channel = plane(exr, name).1;
        for (k, record) in bytes[start..].chunks_exact(72).enumerate() {
            let value = f64::from_le_bytes(*record[at..].first_chunk().unwrap());
            let off = (value - channel[k]).abs();
            assert!((value.is_nan() && channel[k].is_nan()) || off <= 1e-5 * value.abs().max(10.0), "{name} {k}");
            let seen = u32::from_le_bytes(*record[68..].first_chunk().unwrap());
            assert!(f64::from(seen) == seen_by[k] && (seen == 3) != disparity[k].is_nan(), "{k}");
        }
    }
}
