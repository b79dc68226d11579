//! Runs that are stopped at any moment: every file is the old one or the new one.

use super::place::{OLD, Place, WRITERS, ignores_interrupts, skipped};
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::process::{Child, Command, Stdio};
use std::time::Instant;

/// A report without the times in it, which differ from run to run.
fn without_times(bytes: &[u8]) -> Option<serde_json::Value> {
    fn strip(value: &mut serde_json::Value) {
        match value {
            serde_json::Value::Object(map) => {
                map.retain(|key, _| key != "timing_s");
                map.values_mut().for_each(strip);
            }
            serde_json::Value::Array(items) => items.iter_mut().for_each(strip),
            _ => (),
        }
    }
    let mut value = serde_json::from_slice(bytes).ok()?;
    strip(&mut value);
    Some(value)
}

/// Whether two files say the same.
fn same(name: &str, a: &[u8], b: &[u8]) -> bool {
    if name == "report.json" { without_times(a).is_some_and(|x| Some(x) == without_times(b)) } else { a == b }
}

fn signal(child: &Child, name: &str) {
    let done = Command::new("kill").arg(name).arg(child.id().to_string()).status();
    assert!(done.is_ok(), "there is no kill command");
}

/// Stops every writing verb at `times` moments spread over its run, by `name`d signal; every file must be the old one or
/// the new one, whole. Returns how many files in the making were left behind.
fn stopped(name: &str, times: u32) -> usize {
    let place = Place::new();
    assert!(place.output(&["render", "scene.toml", "--out", "picture.png"]).status.success());
    let (mut stopped, mut left) = (0, 0);
    for (args, files) in WRITERS {
        let _ = fs::remove_dir_all(place.path("out"));
        fs::create_dir(place.path("out")).expect("it is made");
        let started = Instant::now();
        let done = place.output(args);
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        let whole_run = started.elapsed();
        let read = |file: &str| fs::read(place.path("out").join(file)).expect("it is there");
        let new: BTreeMap<&str, Vec<u8>> = files.iter().map(|file| (*file, read(file))).collect();
        for k in 0..times {
            for file in files {
                fs::write(place.path("out").join(file), OLD).expect("it is written");
            }
            let mut child =
                place.command(args).stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the command starts");
            // Moments over the whole run, none at a round place.
            std::thread::sleep(whole_run.mul_f64((f64::from(k) + 0.618) / f64::from(times)));
            signal(&child, name);
            let status = child.wait().expect("it ends");
            stopped += usize::from(status.signal().is_some());
            for file in files {
                let found = read(file);
                assert!(
                    found == OLD || same(file, &found, &new[file]),
                    "{file} of {args:?} is neither old nor new after {name} at {k}/{times}: {} bytes",
                    found.len()
                );
            }
            let entries = fs::read_dir(place.path("out")).expect("it can be listed").flatten();
            for entry in entries.filter(|e| !files.iter().any(|f| e.file_name() == *f)) {
                left += 1;
                fs::remove_file(entry.path()).expect("it can be removed");
            }
        }
    }
    assert!(stopped > times as usize, "only {stopped} runs were stopped before their end");
    left
}

#[test]
fn killed_at_any_moment_every_file_is_whole() {
    let left = stopped("-KILL", 8);
    if cfg!(target_os = "linux") {
        // Only a kill between naming and renaming over the old file, some 20 us of a run, can leave one.
        assert!(left <= 1, "{left} files in the making were left behind");
    }
}

#[test]
fn interrupted_at_any_moment_nothing_is_left_behind() {
    let heeds =
        Command::new("env").args(["--default-signal=INT", "true"]).status().is_ok_and(|status| status.success());
    if ignores_interrupts() && !heeds {
        skipped("the tests were started with SIGINT ignored, their children inherit that, and `env` cannot undo it");
        return;
    }
    let left = stopped("-INT", 4);
    if cfg!(target_os = "linux") {
        assert!(left <= 1, "{left} files in the making were left behind");
    }
}
