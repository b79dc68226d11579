//! Do the oracle's tables belong to this program, and does the whole command agree with them?
//!
//! The tables in `tests/oracle/` are made by `make_tables.py` (mpmath, 50 digits), whose command stands in each header.
//! `tests/hard_cases.rs` holds every function against them; here it is the command line that is asked.

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
            assert!(text.starts_with("# made by: python3 tests/oracle/make_tables.py (mpmath "), "{}", path.display());
            assert!(text.len() < 100_000, "{} is not small", path.display());
        }
    }
    assert_eq!(tables, 5);
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

/// The prism of the tables is the one that the paper's scene asks for today: the same terms, each to the rounding of a
/// fit of a million points (condition number 1e3).
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
        let words = text.split(|c: char| !(c.is_ascii_alphanumeric() || "+-.".contains(c)));
        words.filter_map(|word| word.parse().ok()).collect()
    };
    let (made, committed) = (numbers(&out.path().join("prism.toml")), numbers(&folder().join("prism.toml")));
    assert_eq!(made.len(), committed.len());
    for (a, b) in made.iter().zip(&committed) {
        assert!((a - b).abs() <= 1e-11, "{a:?}, and the committed prism has {b:?}");
    }
}
