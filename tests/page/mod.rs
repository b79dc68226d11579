//! Does a page do what a person asks of it? In a real browser without a window, where there is one: Chromium, as Debian has it.
//! Where there is none each test says that it is skipped.

use crate::command::{as_is, biprism, text, tiny_scene};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Uses a page of a comparison as a person does, and writes what it found into the page.
const SELF_TEST: &str = include_str!("self_test.js");

/// Names under which the browser is installed.
const BROWSERS: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];

/// The browser, or a word that there is none.
fn browser() -> Option<&'static str> {
    let found = BROWSERS.into_iter().find(|name| Command::new(name).arg("--version").output().is_ok());
    if found.is_none() {
        eprintln!("skipped: none of {} is installed, and no page was opened", BROWSERS.join(", "));
    }
    found
}

/// What the page is after its scripts have run, on light or dark paper; nothing may be said on the console.
fn opened(browser: &str, page: &Path, dark: bool) -> String {
    let profile = tempfile::tempdir().expect("a folder");
    let mut command = Command::new(browser);
    command
        .args(["--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"])
        .args(["--disable-component-update", "--disable-sync", "--host-resolver-rules=MAP * ~NOTFOUND"])
        .args(["--enable-logging=stderr", "--window-size=1300,1100", "--virtual-time-budget=20000", "--dump-dom"])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg(format!("--blink-settings=preferredColorScheme={}", if dark { 0 } else { 1 }))
        .arg(format!("file://{}", page.display()));
    let output = command.output().expect("the browser runs");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let console: Vec<&str> = said.lines().filter(|line| line.contains("CONSOLE")).collect();
    assert!(console.is_empty(), "{console:?}");
    text(&output.stdout)
}

/// The page with the scripts of the test behind its own.
fn with_self_test(page: &Path) -> PathBuf {
    let own = fs::read_to_string(page).expect("the page is written");
    let path = page.with_extension("test.html");
    let (before, after) = own.rsplit_once("</body>").expect("a body");
    fs::write(&path, format!("{before}<script>{SELF_TEST}</script></body>{after}")).expect("written");
    path
}

/// What the self-test says on light and on dark paper.
fn passes(browser: &str, page: &Path) {
    let page = with_self_test(page);
    for (dark, passed) in [(false, "passed light"), (true, "passed dark")] {
        let dom = opened(browser, &page, dark);
        let result = dom.rsplit_once("<pre id=\"self-test\">").map_or("it did not end", |(_, rest)| rest);
        assert!(result.starts_with(passed), "{}", result.split("</pre>").next().unwrap_or_default());
    }
}

#[test]
fn the_page_of_a_comparison_can_be_looked_into() {
    let folder = tempfile::tempdir().expect("a folder");
    tiny_scene(folder.path(), as_is);
    let output = biprism(folder.path(), &["compare", "scene.toml", "--budget"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let page = folder.path().join("out/report.html");
    let written = fs::read_to_string(&page).expect("the page");

    // It needs nothing else, and says where it comes from.
    assert!(!written.contains("src=\"http") && !written.contains("href=\"http") && !written.contains("@import"));
    assert!(written.contains("biprism compare scene.toml --budget") && written.contains("ridge_distance_mm = 78.472"));
    assert!(written.contains("budget: optics") && written.len() < 1_000_000, "{}", written.len());
    let Some(browser) = browser() else { return };
    passes(browser, &page);
}

#[test]
fn the_page_of_a_measured_picture_can_be_looked_into() {
    let folder = tempfile::tempdir().expect("a folder");
    tiny_scene(folder.path(), as_is);
    let done = |args: &[&str]| {
        let output = biprism(folder.path(), args);
        assert!(output.status.success(), "{}", text(&output.stderr));
    };
    done(&["render", "scene.toml", "--out", "a.png"]);
    done(&["measure", "a.png", "--scene", "scene.toml", "--own", "--page", "a.html"]);
    done(&["corners", "a.png", "--scene", "scene.toml", "--out", "a.csv"]);
    done(&["measure", "a.csv", "--scene", "scene.toml", "--page", "b.html"]);
    let Some(browser) = browser() else { return };
    passes(browser, &folder.path().join("a.html"));

    // Corners without a picture have a page as well.
    assert!(opened(browser, &folder.path().join("b.html"), false).contains("data-ready=\"yes\""));
}

#[test]
fn the_page_of_a_study_has_its_tables_and_figures() {
    let folder = tempfile::tempdir().expect("a folder");
    tiny_scene(folder.path(), as_is);
    let output = biprism(folder.path(), &["analyse", "reprojection", "scene.toml"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let page = folder.path().join("out/reprojection.html");
    let written = fs::read_to_string(&page).expect("the page");
    assert!(written.contains("<svg") && written.contains("data-word=") && written.contains("analyse reprojection"));
    let Some(browser) = browser() else { return };
    assert!(opened(browser, &page, false).contains("<table>"));
}
