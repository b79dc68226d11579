//! Do the oracle's tables belong to this program, and does the whole program agree with them?
//!
//! The tables in `tests/oracle/` are made by `make_tables.py` (mpmath, 50 digits), `effects.py` (numpy), `camera.py` (OpenCV,
//! asked in `tests/camera.rs`) and `relay.py` (Optiland, asked in `tests/relay_oracle.rs`), whose command stands in each header. `tests/hard_cases.rs` holds every function against those of rays; here it is the command line that
//! is asked, and pictures with many effects are rendered.

use biprism::effect::{Effects, Quadrature};
use biprism::render::{Outputs, render_wanted};
use biprism::scene::{self, Scene};
use biprism::system::{self, System};
use glam::DVec2;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

fn folder() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/oracle"))
}

/// The rows of a table, each with its fields.
fn rows(name: &str) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(folder().join(name)).expect("the table is committed");
    let rows = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    rows.map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

#[test]
fn every_table_says_how_it_was_made() {
    let mut tables = 0;
    for entry in std::fs::read_dir(folder()).expect("the folder is committed") {
        let path = entry.expect("it can be listed").path();
        if path.extension().is_some_and(|e| e == "csv") {
            tables += 1;
            let text = std::fs::read_to_string(&path).expect("it is text");
            let makers = [
                "make_tables.py (mpmath ",
                "effects.py (numpy ",
                "camera.py (cv2 ",
                "relay.py (optiland ",
                "export.py (optiland ",
            ];
            let made_by = |maker: &&str| text.starts_with(&format!("# made by: python3 tests/oracle/{maker}"));
            assert!(makers.iter().any(made_by), "{}", path.display());
            assert!(text.len() < 100_000, "{} is not small", path.display());
        }
    }
    assert_eq!(tables, 12);
}

/// Traces the pixels of a table with the command, and holds what it prints against the table: positions on the board in
/// mm and directions behind the prism.
fn command_agrees(scene: &str, table: &str) {
    let rows = rows(table);
    let points: String = rows.iter().map(|row| format!("{},{}\n", row[0], row[1])).collect();
    let mut child = Command::new(env!("CARGO_BIN_EXE_biprism"))
        .args(["trace", scene])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("the command starts");
    child.stdin.take().expect("it is piped").write_all(points.as_bytes()).expect("it is read");
    let output = child.wait_with_output().expect("it ends");
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).expect("it is text");
    let mut lines = text.lines();
    let columns: Vec<&str> = lines.next().expect("a heading").split(',').collect();
    let column = |name: &str| columns.iter().position(|c| *c == name).expect("the column is there");
    for (row, line) in rows.iter().zip(lines) {
        let fields: Vec<&str> = line.split(',').collect();
        assert_eq!(fields[column("fate")], "board", "{line}");
        // A direction carries some 8 roundings of numbers up to 1; the board is 1000 mm away, and positions follow.
        for (k, (name, bound)) in
            [("u_mm", 2e-12), ("v_mm", 2e-12), ("exit_dx", 2e-15), ("exit_dy", 2e-15), ("exit_dz", 2e-15)]
                .into_iter()
                .enumerate()
        {
            let [found, exact] = [fields[column(name)], &row[k + 2]].map(|f| f.parse::<f64>().expect("a number"));
            assert!((found - exact).abs() <= bound, "{name} of {line}: {found:?}, and the table has {exact:?}");
        }
    }
}

fn with_paper_camera(prism: &str) -> tempfile::NamedTempFile {
    let mut file = tempfile::Builder::new().suffix(".toml").tempfile().expect("a temporary file");
    write!(
        file,
        "name = \"oracle\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = 1920\nheight_px = 1080\npixel_pitch_um = 5.5\n\
         {prism}\n[board]\ncolumns = 41\nrows = 41\nsquare_mm = 10.0\nposition_mm = [0.0, 0.0, 1000.0]\n"
    )
    .expect("it is written");
    file
}

#[test]
fn the_command_agrees_on_the_flat_prism() {
    let scene =
        with_paper_camera("[prism]\nkind = \"flat\"\nindex = 1.48\nridge_distance_mm = 78.472\nthickness_mm = 8.545");
    command_agrees(&scene.path().display().to_string(), "flat.csv");
}

#[test]
fn the_command_agrees_on_the_polynomial_prism() {
    let prism = std::fs::read_to_string(folder().join("prism.toml")).expect("it is committed");
    let scene = with_paper_camera(&prism);
    command_agrees(&scene.path().display().to_string(), "freeform.csv");
}

/// The prism of the tables is the one that the paper's scene asks for, but for how the fit weights its points: alike there, by
/// Simpson's rule today, which moves no term by more than what the fit leaves of a point.
#[test]
fn the_prism_of_the_tables_is_the_designed_one() {
    let out = tempfile::tempdir().expect("a temporary folder");
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/paper.toml");
    let done = Command::new(env!("CARGO_BIN_EXE_biprism"))
        .arg("design")
        .arg(scene)
        .arg("--out")
        .arg(out.path())
        .output()
        .expect("the command runs");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let numbers = |path: &Path| -> Vec<f64> {
        let text = std::fs::read_to_string(path).expect("it is there");
        // What the prism is meant to be is no part of the tables.
        let law = text
            .find("[prism.law]")
            .map_or(0..0, |at| at..at + text[at..].find("[prism.front]").expect("it comes next"));
        let text = text[..law.start].to_owned() + &text[law.end..];
        let words = text.split(|c: char| !(c.is_ascii_alphanumeric() || "+-.".contains(c)));
        words.filter_map(|word| word.parse().ok()).collect()
    };
    let (made, committed) = (numbers(&out.path().join("prism.toml")), numbers(&folder().join("prism.toml")));
    assert_eq!(made.len(), committed.len());
    for (a, b) in made.iter().zip(&committed) {
        // The fit leaves 1.6e-6 mm at most, by `biprism design`.
        assert!((a - b).abs() <= 1.6e-6, "{a:?}, and the committed prism has {b:?}");
    }
}

/// A scene of the oracle, with other effects.
fn oracle_scene(name: &str, change: impl Fn(&Effects) -> Effects) -> System {
    let scene = scene::load(&folder().join(name)).unwrap_or_else(|problem| panic!("{problem}"));
    let scene = Scene { effects: change(&scene.effects), ..scene };
    system::build(&scene).unwrap_or_else(|problem| panic!("{problem}"))
}

/// The largest and the root mean square difference between a picture and the `value` of a table's rows, of full scale 1, among
/// the columns of the picture from `first` on.
fn differences(system: &System, table: &str, value: impl Fn(&[f64]) -> f64, first: usize) -> [f64; 2] {
    let picture = render_wanted(system, Outputs { truth: false }, &()).radiance;
    let numbers = |row: &Vec<String>| row.iter().map(|v| v.parse::<f64>().expect("a number")).collect::<Vec<_>>();
    let rows: Vec<Vec<f64>> = rows(table).iter().map(numbers).filter(|row| row[0] >= first as f64).collect();
    let off = |row: &Vec<f64>| f64::from(picture.get(row[0] as usize, row[1] as usize)) - value(row);
    let squares: Vec<f64> = rows.iter().map(|row| off(row) * off(row)).collect();
    let most = squares.iter().fold(0.0, |most: f64, square| most.max(*square));
    [most.sqrt(), (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()]
}

/// Lens, dispersion, ghosts, Fresnel, absorption, cosine, lamp and sensor at once: what remains is the sampling of the pupil,
/// in which a ridge out of focus is a step where the picture's left sees it, and falls with more points.
#[test]
fn a_picture_with_all_effects_at_once_is_the_oracles() {
    let with = |points: usize, samples: usize| {
        oracle_scene("effects_scene.toml", |effects| Effects {
            quadrature: Quadrature { points, ..effects.quadrature },
            ghosts: effects.ghosts.map(|ghosts| biprism::effect::Ghosts { samples, ..ghosts }),
            ..effects.clone()
        })
    };
    let mut before = f64::INFINITY;
    for (points, most, rms) in [(32, 2e-2, 3e-3), (160, 2.5e-3, 5e-4)] {
        let found = differences(&with(points, 2), "effects.csv", |row| row[4], 0);
        println!("{points} points: {:.1e}, root mean square {:.1e}", found[0], found[1]);
        assert!(found[0] < most && found[1] < rms && found[1] < before, "{points} points: {found:?}");
        before = found[1];
    }
    let [most, _] = differences(&with(160, 2), "effects.csv", |row| row[4], 15);
    println!("160 points, without the ridge: {most:.1e}");
    assert!(most < 4e-4, "{most}");
}

/// The ghosts of a wedge, as a picture: 16 samples along a pixel leave w / 32 of an edge of ghosts of 6.5e-3.
#[test]
fn ghosts_of_a_wedge_are_the_oracles() {
    let system = oracle_scene("ghosts_scene.toml", Effects::clone);
    let sum = differences(&system, "ghosts_picture.csv", |row| row[2] + row[3], 0);
    let plain = oracle_scene("ghosts_scene.toml", |effects| Effects { ghosts: None, ..effects.clone() });
    let straight = differences(&plain, "ghosts_picture.csv", |row| row[2], 0);
    println!("with ghosts {:.1e}, root mean square {:.1e}; without {:.1e}", sum[0], sum[1], straight[0]);
    assert!(sum[0] < 2.5e-4 && sum[1] < 4e-5 && straight[0] < 2e-6, "{sum:?} {straight:?}");
}

/// Each ray that the glass of a wedge reflects, by its power, its direction and its place on the board.
#[test]
fn reflected_rays_are_the_oracles() {
    let system = oracle_scene("ghosts_scene.toml", Effects::clone);
    let (ghosts, light) = (system.effects().ghosts.unwrap(), system.effects().fresnel.unwrap().light);
    for row in rows("ghosts.csv") {
        let number = |k: usize| row[k].parse::<f64>().ok();
        let at = |k: usize| number(k).expect("a number");
        let mut nearest: Option<(f64, f64, Option<DVec2>)> = None;
        system.reflected(DVec2::new(at(0), at(1)), light, system.body().unwrap(), &ghosts, |exit| {
            let off = exit.ray.direction.distance(glam::DVec3::new(at(6), at(7), at(8)));
            if f64::from(exit.bounces) == at(2) && nearest.is_none_or(|(least, ..)| off < least) {
                let board_mm = system.board().intersect(&exit.ray).ok().map(|(board_mm, _)| board_mm);
                nearest = Some((off, exit.power, board_mm));
            }
        });
        let (off, power, board_mm) = nearest.expect("a ray of as many reflections");
        // Directions and powers after five surfaces, some ten roundings at each; the board is 700 mm away.
        assert!(off < 1e-14 && (power / at(3) - 1.0).abs() < 1e-12, "{row:?}: {off:e} {power:e}");
        if let Some((u, v)) = number(4).zip(number(5)) {
            let off_mm = board_mm.expect("it meets the board").distance(DVec2::new(u, v));
            assert!(off_mm < 1e-11, "{row:?}: {off_mm:e} mm");
        }
    }
}
