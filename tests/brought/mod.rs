//! What users bring: files too large or too short for what they announce, names that are inputs and outputs at once.

mod pictures;

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

const CAMERA: &str = "name = \"small\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = 64\nheight_px = 36\n\
    pixel_pitch_um = 165\n";
const FLAT: &str = "[prism]\nkind = \"flat\"\nindex = 1.48\nridge_distance_mm = 78.472\nthickness_mm = 8.545\n";
const BOARD: &str = "[board]\ncolumns = 21\nrows = 21\nsquare_mm = 20.0\nposition_mm = [0.0, 0.0, 1000.0]\n";

struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    /// A folder with a scene in it.
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        fs::write(folder.path().join("scene.toml"), format!("{CAMERA}{FLAT}{BOARD}")).expect("it is written");
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn run(&self, args: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_biprism"));
        command.current_dir(self.folder.path()).args(args).stdin(Stdio::null()).output().expect("the command starts")
    }

    /// The words of a run that must be refused.
    fn refused(&self, args: &[&str]) -> String {
        let output = self.run(args);
        let words = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{args:?}: {words}");
        assert!(words.contains("help") && !words.contains("panicked"), "{args:?}: {words}");
        words
    }
}

/// Nothing that a run has read is written over, whatever it is called; nor are two outputs one file.
#[test]
fn what_was_read_is_never_written_over() {
    let place = Place::new();
    let copy = |from: &str, to: &str| fs::copy(place.path(from), place.path(to)).expect("it is there");
    assert!(place.run(&["render", "scene.toml", "--out", "a.png", "--out", "a.exr"]).status.success());
    assert!(place.run(&["corners", "a.png", "--out", "a.csv"]).status.success());
    copy("scene.toml", "prism.toml");
    copy("scene.toml", "report.json");
    copy("scene.toml", "cost.csv");
    copy("scene.toml", "scene.png");
    fs::create_dir(place.path("sub")).expect("a folder");
    let mut inputs = vec!["scene.toml", "prism.toml", "report.json", "cost.csv", "scene.png", "a.csv"];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("../scene.toml", place.path("sub/flat.png")).expect("a link");
        std::os::unix::fs::symlink("scene.png", place.path("link.png")).expect("a link");
        fs::hard_link(place.path("scene.png"), place.path("hard.png")).expect("a link");
        inputs.extend(["sub/flat.png", "link.png", "hard.png"]);
    }
    let before: Vec<Vec<u8>> = inputs.iter().map(|name| fs::read(place.path(name)).expect("it is there")).collect();
    let mut cases = vec![
        vec!["design", "prism.toml", "--out", "."],
        vec!["compare", "report.json", "--out", "."],
        vec!["cost", "cost.csv", "--out", ".", "--quick"],
        vec!["render", "scene.png", "--out", "scene.png"],
        vec!["render", "scene.png", "--out", "sub/../scene.png"],
        vec!["corners", "a.csv", "--out", "a.csv"],
        vec!["corners", "a.csv", "--out", "./a.csv"],
    ];
    if cfg!(unix) {
        cases.push(vec!["compare", "scene.toml", "--out", "sub"]);
        cases.push(vec!["render", "scene.png", "--out", "link.png"]);
        cases.push(vec!["render", "link.png", "--out", "scene.png"]);
        cases.push(vec!["render", "scene.png", "--out", "hard.png"]);
    }
    for args in cases {
        let words = place.refused(&args);
        assert!(words.contains("was read in this run"), "{args:?}: {words}");
    }
    for (name, bytes) in inputs.iter().zip(before) {
        assert!(fs::read(place.path(name)).expect("it is there") == bytes, "{name} was touched");
    }
    for second in ["b.png", "./b.png", "sub/../b.png"] {
        let words = place.refused(&["render", "scene.toml", "--out", "b.png", "--out", second]);
        assert!(words.contains("twice"), "{words}");
    }
    assert!(!place.path("b.png").exists() && !place.path("comparison.png").exists());
}

/// The clouds of a scene are read as well as the scene.
#[test]
fn clouds_and_meshes_are_not_written_over() {
    let place = Place::new();
    let cloud: String = (0..400)
        .map(|k| {
            let (x, y) = (f64::from(k % 20) - 1.0, f64::from(k / 20) - 10.0);
            format!("{x} {y} {}\n", 80.0 + 0.15 * x)
        })
        .collect();
    fs::write(place.path("front.xyz"), &cloud).expect("it is written");
    let plane: String = (0..400).map(|k| format!("{} {} 90\n", k % 20 - 1, k / 20 - 10)).collect();
    fs::write(place.path("back.png.xyz"), plane).expect("it is written");
    let prism = "[prism]\nkind = \"point_cloud\"\nindex = 1.48\nfront = { file = \"front.xyz\", degree = 2 }\n\
                 back = { file = \"back.png.xyz\", degree = 2 }\n";
    fs::write(place.path("cloud.toml"), format!("{CAMERA}{prism}{BOARD}")).expect("it is written");
    // Through a link, for a picture's name ends otherwise.
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("front.xyz", place.path("picture.png")).expect("a link");
        let words = place.refused(&["render", "cloud.toml", "--out", "picture.png"]);
        assert!(words.contains("was read in this run"), "{words}");
        assert_eq!(fs::read_to_string(place.path("front.xyz")).expect("it is there"), cloud);
    }
    assert!(place.run(&["render", "cloud.toml", "--out", "other.png"]).status.success());
}

/// Goldens are read and rewritten by right; a case is not.
#[test]
fn goldens_may_be_rewritten() {
    let place = Place::new();
    fs::create_dir(place.path("cases")).expect("a folder");
    fs::rename(place.path("scene.toml"), place.path("cases/small.toml")).expect("moved");
    let update = || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_biprism"));
        command.current_dir(place.folder.path()).args(["golden", "cases"]).env("UPDATE_GOLDEN", "1").env_remove("CI");
        let output = command.output().expect("it starts");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    assert!(update().contains("1 updated"));
    let record = place.path("golden/small.json");
    let changed = fs::read_to_string(&record).expect("it is there").replace("missed", "mixed");
    fs::write(&record, changed).expect("it is written");
    assert!(update().contains("1 updated"));
    assert!(fs::read_to_string(&record).expect("it is there").contains("missed"));
}

/// What spreadsheets and editors of other systems make of a table.
#[test]
fn a_corner_file_may_have_a_byte_order_mark_and_other_line_ends() {
    let place = Place::new();
    assert!(place.run(&["render", "scene.toml", "--out", "a.png"]).status.success());
    for ending in ["csv", "json", "yml"] {
        let name = format!("a.{ending}");
        assert!(place.run(&["corners", "a.png", "--out", &name]).status.success());
        let plain = fs::read_to_string(place.path(&name)).expect("it is there");
        let changed = format!("b.{ending}");
        fs::write(place.path(&changed), format!("\u{feff}{}", plain.replace('\n', "\r\n"))).expect("it is written");
        let [before, after] = [&name, &changed].map(|name| place.run(&["corners", name]));
        assert!(after.status.success(), "{}", String::from_utf8_lossy(&after.stderr));
        assert_eq!(before.stdout, after.stdout, "{ending}");
    }
}

#[test]
fn a_place_in_a_corner_file_is_told_once() {
    let place = Place::new();
    let head = "# pixel centre: (i + 0.5, j + 0.5)\n";
    fs::write(place.path("a.csv"), format!("{head}half,column,row,x_px,y_px\nleft,0.5,0,1,1\n")).expect("written");
    let words = place.refused(&["corners", "a.csv"]);
    assert!(words.contains("--> a.csv:3:6\n"), "{words}");
    fs::write(place.path("a.json"), "{\n\"pixel_centre\": 3}").expect("written");
    let words = place.refused(&["corners", "a.json"]);
    assert!(words.contains("--> a.json:2:") && !words.contains("a.json:2:2:"), "{words}");
}

#[test]
fn a_folder_named_as_a_surface_is_told() {
    let place = Place::new();
    fs::create_dir(place.path("cloud.csv")).expect("a folder");
    let prism = "[prism]\nkind = \"point_cloud\"\nindex = 1.48\nfront = { file = \"cloud.csv\", degree = 2 }\n\
                 back = { file = \"cloud.csv\", degree = 2 }\n";
    fs::write(place.path("cloud.toml"), format!("{CAMERA}{prism}{BOARD}")).expect("it is written");
    let words = place.refused(&["check", "cloud.toml"]);
    assert!(words.contains("is a directory"), "{words}");
}

#[test]
fn computed_numbers_are_rounded_in_messages() {
    let place = Place::new();
    let near = BOARD.replace("1000.0]", "80.3]");
    fs::write(place.path("near.toml"), format!("{CAMERA}{FLAT}position_mm = [0.0, 0.0, 9.1]\n{near}"))
        .expect("written");
    let words = place.refused(&["check", "near.toml"]);
    let digits = words.split(|c: char| !c.is_ascii_digit()).map(str::len).max();
    assert!(words.contains("the glass ends at 87.017") && digits <= Some(9), "{words}");
}

/// A scene from standard input, for every verb that takes one; files that it names are beside the user.
#[test]
fn a_scene_may_come_from_stdin() {
    let place = Place::new();
    let scene = fs::read_to_string(place.path("scene.toml")).expect("it is there");
    let piped = |args: &[&str]| {
        use std::io::Write;
        let mut command = Command::new(env!("CARGO_BIN_EXE_biprism"));
        command.current_dir(place.folder.path()).args(args);
        let mut child =
            command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts");
        // A refusal may come before all is read.
        let _ = child.stdin.take().expect("a pipe").write_all(scene.as_bytes());
        child.wait_with_output().expect("it ends")
    };
    fs::write(place.path("points.csv"), "20,18\n").expect("it is written");
    assert!(place.run(&["render", "scene.toml", "--out", "a.png"]).status.success());
    for args in [
        &["check", "-"][..],
        &["render", "-", "--out", "new/b.png"],
        &["compare", "-", "--out", "out"],
        &["design", "-", "--out", "out"],
        &["trace", "-", "--points", "points.csv"],
        &["measure", "a.png", "--scene", "-"],
        &["cost", "-", "--quick", "--repetitions", "1"],
    ] {
        let output = piped(args);
        // In so few pixels no corners are found, so that nothing is judged.
        let code = i32::from(["compare", "measure"].contains(&args[0]));
        assert_eq!(output.status.code(), Some(code), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    }
    assert!(
        fs::read(place.path("new/b.png")).expect("its folder is made") == fs::read(place.path("a.png")).expect("it is")
    );
    let both = piped(&["trace", "-"]);
    assert!(both.status.code() == Some(2) && String::from_utf8_lossy(&both.stderr).contains("stdin"));
}

/// Where a ray is totally reflected, and on which side.
#[test]
fn a_totally_reflected_ray_is_followed_to_where_it_is() {
    let place = Place::new();
    // In the middle of the picture rays pass.
    let steep = FLAT.replace("thickness_mm = 8.545", "thickness_mm = 80.0\nfacet_angle_deg = -40.0");
    let steep = steep.replace("index = 1.48", "index = 2.4");
    fs::write(place.path("steep.toml"), format!("{CAMERA}{steep}{BOARD}")).expect("it is written");
    fs::write(place.path("points.csv"), "2,18\n62,18\n").expect("it is written");
    let output = place.run(&["trace", "steep.toml", "--points", "points.csv", "--json"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let rays: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    for (k, side) in ["left", "right"].into_iter().enumerate() {
        let ray = &rays[k];
        assert_eq!((&ray["fate"], &ray["side"]), (&"total_reflection".into(), &side.into()), "{ray}");
        assert_eq!(ray["reflected_at"], "back");
        // The base of the prism is the plane z = 158.472.
        assert!((ray["back_mm"][2].as_f64().expect("a place") - 158.472).abs() < 1e-9, "{ray}");
        assert!(ray["exit_direction"].is_null() && ray["inner_direction"].is_array());
    }
}
