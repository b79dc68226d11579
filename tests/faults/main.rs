//! Is every file whole, and every failure a sentence, when the world fails?

#![cfg(unix)]

mod place;
mod stopped;

use std::time::{Duration, Instant};

use place::{OLD, Place, SCENE, WRITERS, no_panic, skipped};
use std::fs;

use std::path::Path;
use std::process::{Command, Stdio};

#[test]
fn a_full_disk_is_a_sentence_and_the_old_file_stays() {
    let place = Place::new();
    fs::create_dir(place.path("out")).expect("it is made");
    assert!(place.output(&["render", "scene.toml", "--out", "picture.png"]).status.success());
    for (args, files) in WRITERS {
        fs::remove_dir_all(place.path("out")).expect("it is ours");
        fs::create_dir(place.path("out")).expect("it is made");
        for file in files {
            fs::write(place.path("out").join(file), OLD).expect("it is written");
        }
        // A file of at most one block of 512 (or 1024) bytes: what a full disk looks like, but for the signal that comes
        // with it.
        let script = format!("ulimit -f 1; exec {} \"$@\"", env!("CARGO_BIN_EXE_biprism"));
        let output = Command::new("sh")
            .current_dir(place.folder.path())
            .args(["-c", &script, "sh"])
            .args(args)
            .stdin(Stdio::null())
            .output()
            .expect("there is a shell");
        no_panic(&output);
        let words = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {words}");
        assert!(words.contains("cannot be written") && words.contains("help"), "{words}");
        let entries: Vec<_> = fs::read_dir(place.path("out")).expect("it can be listed").flatten().collect();
        for entry in entries {
            let name = entry.file_name().into_string().expect("it is ours");
            assert!(files.contains(&name.as_str()), "{name} was left behind");
            let content = fs::read(entry.path()).expect("it is there");
            // Small ones may have fitted.
            assert!(content == OLD || content.len() <= 1024, "{name} was touched");
        }
    }
}

/// The same on a file system of 64 KiB that is filled to the last page, or to the last but one.
#[test]
fn a_disk_that_is_truly_full_keeps_the_old_files() {
    let small_disk = "mount -t tmpfs -o size=64k none out";
    let may = Command::new("unshare").args(["-rm", "sh", "-c", "mount -t tmpfs -o size=64k none /mnt"]).output();
    if !may.is_ok_and(|output| output.status.success()) {
        skipped("this system lets nobody mount a small disk of their own");
        return;
    }
    let place = Place::new();
    fs::create_dir(place.path("out")).expect("it is made");
    fs::write(place.path("old"), OLD).expect("it is written");
    assert!(place.output(&["render", "scene.toml", "--out", "picture.png"]).status.success());
    for ((args, files), spare_pages) in WRITERS.iter().flat_map(|writer| [(writer, 0), (writer, 1)]) {
        // Prints the exit code, then what the disk holds; a file that is not the old one is named with its size.
        let script = format!(
            "{small_disk} && for f in {old}; do cp old out/$f; done; dd if=/dev/zero of=out/rest bs=4096 2>/dev/null; \
             truncate -s -$((4096 * {spare_pages})) out/rest; {biprism} \"$@\"; echo code $?; rm out/rest; \
             for f in out/* out/.[!.]*; do test -e $f && (cmp -s old $f || wc -c $f); done; true",
            old = files.join(" "),
            biprism = env!("CARGO_BIN_EXE_biprism"),
        );
        let output = Command::new("unshare")
            .current_dir(place.folder.path())
            .args(["-rm", "sh", "-c", &script, "sh"])
            .args(*args)
            .stdin(Stdio::null())
            .output()
            .expect("it was there before");
        no_panic(&output);
        let (found, words) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        let mut lines = found.lines().skip_while(|line| !line.starts_with("code "));
        // What is as small as a page may fit into the one that is left.
        match (lines.next(), spare_pages) {
            (Some("code 2"), _) => assert!(words.contains("cannot be written") && words.contains("help"), "{words}"),
            (Some("code 0"), 1) => {}
            (code, _) => panic!("{args:?}: {code:?} {words}"),
        }
        for line in lines {
            let (bytes, name) = line.split_once(" out/").expect("size and name");
            assert!(files.contains(&name), "{name} was left behind");
            assert!(spare_pages == 1 && bytes.parse::<usize>().is_ok_and(|n| n <= 4096), "{line} was touched");
        }
    }
}

#[test]
fn a_stdout_or_stderr_that_fails_is_no_panic() {
    if !Path::new("/dev/full").exists() {
        skipped("this system has no /dev/full");
        return;
    }
    let place = Place::new();
    assert!(place.output(&["render", "scene.toml", "--out", "picture.png"]).status.success());
    let full = || fs::OpenOptions::new().write(true).open("/dev/full").expect("it is a device");
    for args in [
        &["check", "scene.toml"][..],
        &["check", "scene.toml", "--json"],
        &["render", "scene.toml", "--out", "b.png", "--json"],
        &["corners", "picture.png"],
        &["measure", "picture.png", "--scene", "scene.toml"],
        &["measure", "picture.png", "--scene", "scene.toml", "--json"],
        &["design", "scene.toml", "--cloud", "csv,ply", "--out", "out"],
        &["compare", "scene.toml", "--pictures", "all", "--out", "out"],
        &["compare", "scene.toml", "--out", "out", "--json"],
        &["export", "scene.toml", "--format", "stl", "--out", "out", "--json"],
        &["completions", "bash"],
        &["man"],
        &["trace", "scene.toml"],
        &["analyse", "stability", "--only", "parallel"],
    ] {
        let output = place.command(args).stdout(full()).output().expect("the command starts");
        no_panic(&output);
        let words = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {words}");
        assert!(words.contains("stdout"), "{args:?}: {words}");
        let status = place.command(args).stdout(Stdio::null()).stderr(full()).status().expect("the command starts");
        assert_eq!(status.code(), Some(0), "{args:?} without a stderr");
    }
    let output = place.output(&["render", "scene.toml", "--out", "/dev/full"]);
    no_panic(&output);
    assert_eq!(output.status.code(), Some(2));
}

/// `>&-`: the data is lost, which must not look like success.
#[cfg(target_os = "linux")]
#[test]
fn a_closed_stdout_is_a_sentence() {
    let place = Place::new();
    let run = |args: &str, end: &str| {
        let script = format!("{} {args} {end}", env!("CARGO_BIN_EXE_biprism"));
        Command::new("sh").current_dir(place.folder.path()).args(["-c", &script]).output().expect("a shell")
    };
    for args in ["check scene.toml", "check scene.toml --json", "design scene.toml --out out"] {
        let output = run(args, ">&-");
        let words = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && words.contains("stdout"), "{args}: {words}");
        assert_eq!(run(args, ">/dev/null").status.code(), Some(0), "{args}");
    }
    // What prints nothing has lost nothing.
    assert_eq!(run("render scene.toml --out a.png", ">&-").status.code(), Some(0));
}

/// The end of memory is a sentence too, and leaves the old file; how much is left decides who meets it.
#[cfg(target_os = "linux")]
#[test]
fn the_end_of_memory_is_a_sentence() {
    let place = Place::new();
    let large = SCENE
        .replace("width_px = 240", "width_px = 9600")
        .replace("height_px = 135", "height_px = 5400")
        .replace("pixel_pitch_um = 44.0", "pixel_pitch_um = 1.1")
        .replace("freeform", "flat")
        .replace("[prism.design]\nstep_px = 4.0\n", "[effect.sensor]\ngamma = 2.2\n");
    fs::write(place.path("large.toml"), large).expect("it is written");
    fs::write(place.path("a.png"), OLD).expect("it is written");
    let mut ended = 0;
    for kib in [60_000, 150_000, 400_000, 600_000] {
        let script = format!(
            "ulimit -v {kib}; RAYON_NUM_THREADS=2 exec {} render large.toml --out a.png",
            env!("CARGO_BIN_EXE_biprism")
        );
        let output =
            Command::new("sh").current_dir(place.folder.path()).args(["-c", &script]).output().expect("a shell");
        no_panic(&output);
        let words = String::from_utf8_lossy(&output.stderr);
        let told = ["memory has run out", "no thread can be made"].iter().any(|told| words.contains(told));
        assert!(output.status.code() == Some(2) && told, "{kib} KiB: {:?} {words}", output.status);
        ended += usize::from(words.contains("memory has run out"));
        assert_eq!(fs::read(place.path("a.png")).expect("it is there"), OLD);
    }
    assert!(ended > 0, "memory never ran out");
    assert_eq!(fs::read_dir(place.folder.path()).expect("a folder").count(), 3, "something was left behind");
}

/// Any number of threads that is asked for ends in a picture or in a sentence.
#[cfg(target_os = "linux")]
#[test]
fn threads_that_cannot_be_made_are_no_panic() {
    let place = Place::new();
    let run = |limits: &str, threads: &str, end: &str| {
        let script = format!(
            "{limits} RAYON_NUM_THREADS={threads} exec {} render scene.toml --out {end}",
            env!("CARGO_BIN_EXE_biprism")
        );
        Command::new("sh").current_dir(place.folder.path()).args(["-c", &script]).output().expect("a shell")
    };
    let plain = run("", "1", "plain.png");
    assert!(plain.status.success(), "{}", String::from_utf8_lossy(&plain.stderr));
    let started = Instant::now();
    let many = run("", "100000", "many.png");
    let words = String::from_utf8_lossy(&many.stderr);
    assert!(many.status.success() && words.contains("256 threads are the most"), "{words}");
    assert!(started.elapsed() < Duration::from_secs(60));
    assert!(fs::read(place.path("plain.png")).expect("made") == fs::read(place.path("many.png")).expect("made"));
    for (kib, threads) in [(1_000_000, "500"), (400_000, "500"), (100_000, "64"), (40_000, "2")] {
        let output = run(&format!("ulimit -v {kib};"), threads, "few.png");
        no_panic(&output);
        let words = String::from_utf8_lossy(&output.stderr);
        assert!(matches!(output.status.code(), Some(0 | 2)), "{kib} KiB: {:?} {words}", output.status);
    }
    // A limit of processes, which root is not held to.
    let nobody = |rest: &[&str]| {
        fs::set_permissions(place.folder.path(), std::os::unix::fs::PermissionsExt::from_mode(0o755)).expect("ours");
        let user = ["--reuid=65534", "--regid=65534", "--clear-groups", "prlimit"];
        Command::new("setpriv").current_dir(place.folder.path()).args(user).args(rest).output()
    };
    let may = nobody(&["--nproc=64", env!("CARGO_BIN_EXE_biprism"), "--version"]);
    if !may.is_ok_and(|output| output.status.success()) {
        println!("skipped: the limit of processes, for no other user can be taken on here");
        return;
    }
    let output = nobody(&["--nproc=1", env!("CARGO_BIN_EXE_biprism"), "check", "scene.toml"]).expect("it was there");
    no_panic(&output);
    let words = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(2) && words.contains("no thread can be made"), "{words}");
}

/// A link is followed also where it names no file yet.
#[test]
fn a_dangling_link_gets_its_file() {
    let place = Place::new();
    std::os::unix::fs::symlink("real.png", place.path("link.png")).expect("a link");
    let output = place.output(&["render", "scene.toml", "--out", "link.png"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(fs::symlink_metadata(place.path("link.png")).expect("it is there").is_symlink());
    assert!(fs::read(place.path("real.png")).expect("it is made").starts_with(b"\x89PNG"));
    std::os::unix::fs::symlink("nowhere/real.png", place.path("astray.png")).expect("a link");
    let output = place.output(&["render", "scene.toml", "--out", "astray.png"]);
    assert_eq!(output.status.code(), Some(2));
}

/// What files are called never reaches the terminal as an order to it.
#[test]
fn names_are_printed_and_not_obeyed() {
    let place = Place::new();
    let name = "\u{1b}[31mred\u{7}\r\u{9b}2J\u{202e}.toml";
    fs::write(place.path(name), SCENE).expect("it is written");
    let picture = format!("{name}.png");
    let folder = format!("{name}.d");
    fs::write(place.path(&picture), "no picture").expect("it is written");
    for args in [
        &["check", name][..],
        &["check", &picture],
        &["check", "nothing\u{1b}[31m"],
        &["render", name, "--out", &format!("{picture}2.png")],
        &["render", name, "--out", "a\u{1b}[31m"],
        &["compare", name, "--out", &folder],
        &["design", name, "--out", &folder],
        &["corners", &picture],
        &["measure", &picture, "--scene", name],
        &["trace", name, "--points", &picture],
        &["golden", name],
        &["\u{1b}[31mverb"],
        &["check", "--\u{1b}[31m"],
    ] {
        let output = place.output(args);
        no_panic(&output);
        for bytes in [&output.stdout, &output.stderr] {
            let words = String::from_utf8_lossy(bytes);
            let obeyed = |c: char| (c.is_control() && c != '\n' && c != '\t') || c == '\u{202e}';
            assert!(!words.contains(obeyed), "{args:?}: {words:?}");
        }
    }
    assert!(place.path(&folder).join("report.json").exists(), "the files themselves are called as asked");
}

#[test]
fn a_reader_that_leaves_is_no_panic() {
    let place = Place::new();
    let script = format!("{} check scene.toml --json | true", env!("CARGO_BIN_EXE_biprism"));
    let output = Command::new("sh").current_dir(place.folder.path()).args(["-c", &script]).output().expect("a shell");
    no_panic(&output);
}

#[test]
fn folders_that_cannot_be_written_are_sentences() {
    let place = Place::new();
    assert!(place.output(&["render", "scene.toml", "--out", "picture.png"]).status.success());
    fs::write(place.path("file"), "not a folder").expect("it is written");
    // A read-only folder, a file for a folder, a folder that nobody may write to, root included.
    let shut = place.path("shut");
    fs::create_dir(&shut).expect("it is made");
    let mut permissions = fs::metadata(&shut).expect("it is there").permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&shut, permissions).expect("it is ours");
    let everywhere = fs::write(shut.join("probe"), "").is_ok();
    let mut folders = vec!["file", "file/deeper", "shut"];
    if Path::new("/proc/self").exists() {
        folders.push("/proc/self");
    } else {
        skipped("/proc/self, which this system lacks");
    }
    for folder in folders {
        let files = [format!("{folder}/a.png"), format!("{folder}/a.csv")];
        for args in [
            &["render", "scene.toml", "--out", &files[0]][..],
            &["corners", "picture.png", "--out", &files[1]],
            &["design", "scene.toml", "--out", folder],
            &["export", "scene.toml", "--format", "obj", "--out", folder],
            &["man", "--out", folder],
            &["compare", "scene.toml", "--out", folder],
        ] {
            let nobody = everywhere && folder == "shut";
            let output = if nobody { place.output_as_nobody(args) } else { place.output(args) };
            no_panic(&output);
            let words = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(2), "{args:?}: {words}");
            assert!(words.contains("help"), "{words}");
        }
    }
}

#[test]
fn a_folder_that_vanishes_is_a_sentence() {
    let place = Place::new();
    let (mut refused, mut at) = (0, Duration::from_millis(2));
    while at < Duration::from_millis(600) {
        let mut child = place
            .command(&["compare", "scene.toml", "--out", "out"])
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the command starts");
        std::thread::sleep(at);
        let _ = fs::remove_dir_all(place.path("out"));
        // It may be made again, and then is there in part.
        let output = {
            let _ = child.stdin.take();
            child.wait_with_output().expect("it ends")
        };
        no_panic(&output);
        match output.status.code() {
            Some(0) => (),
            Some(2) => refused += 1,
            other => panic!("{other:?}: {}", String::from_utf8_lossy(&output.stderr)),
        }
        at = at.mul_f64(1.6);
    }
    assert!(refused > 0, "the folder never vanished in time");
}

#[test]
fn truncated_inputs_are_sentences() {
    let place = Place::new();
    assert!(place.output(&["render", "scene.toml", "--out", "p.png", "--out", "p.exr"]).status.success());
    for name in ["scene.toml", "p.png", "p.exr"] {
        let whole = fs::read(place.path(name)).expect("it is there");
        for k in 0..12 {
            let cut = format!("cut_{name}");
            fs::write(place.path(&cut), &whole[..whole.len() * k / 12]).expect("it is written");
            let output =
                if name == "scene.toml" { place.output(&["check", &cut]) } else { place.output(&["corners", &cut]) };
            no_panic(&output);
            let code = output.status.code();
            // A scene may be whole without its last table.
            let whole_enough = name == "scene.toml" && code == Some(0);
            assert!(code == Some(2) || whole_enough, "{k}/12 of {name}: {}", String::from_utf8_lossy(&output.stderr));
        }
    }
}
