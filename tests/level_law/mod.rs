//! Does every level keep its promise in every pixel, whatever the scene?
//!
//! `LEVEL_LAW_SCENES` random scenes from number `LEVEL_LAW_FIRST` on are made, each from its number alone; with
//! `LEVEL_LAW_FOLDER` their texts are kept there.

pub(crate) mod dice;
mod scenes;

use crate::common::long_run::number;
use crate::instruments::{FLAT, FREEFORM, NO_GLASS, built, scene, scene_from};
use biprism::accuracy::{Accuracy, Level};
use biprism::render::{AccuracyReport, Film, render};
use biprism::system::System;
use rayon::prelude::*;
use std::fmt::{self, Display};

/// The first scene by default: faults that were found stand soon after it.
const FIRST: u64 = 850;
/// Scenes by default: what takes some seconds of one processor.
const SCENES: u64 = 24;
/// The reference is divided until the map strays from a linear one by less than this, in px: a tenth of the finest promise.
const JUDGE_PX: f64 = 1e-6;
/// Two radiances, each rounded to f32 by half of this.
const ROUNDING: f64 = f32::EPSILON as f64;
/// The levels that are judged.
const LEVELS: [Level; 3] = [Level::Draft, Level::Standard, Level::Exact];

/// One level in one scene against the reference.
struct Verdict {
    scene: String,
    account: AccuracyReport,
    /// Pixels in all, those that are farther off than their promise, and how many may be.
    pixels: usize,
    broken: u64,
    allowed: u64,
    /// The farthest of the pixels that are promised, as a shift of a line, in px, and where it is.
    shift_px: f64,
    at: [usize; 2],
}

impl Verdict {
    /// Whether no more pixels break the promise than were counted as without one, and the account says so.
    fn keeps(&self) -> bool {
        let account = &self.account;
        self.broken <= self.allowed && (self.allowed > 0 || account.achieved_px() <= account.promise_px)
    }
}

impl Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { scene, account, broken, allowed, shift_px, at: [x, y], .. } = self;
        write!(
            f,
            "scene {scene}: {broken} pixels are off, {allowed} may be, ({x}, {y}) by {shift_px:.2e} px; {account}"
        )
    }
}

/// The picture of a level against that of the reference.
fn judged(scene: &str, system: &System, level: Level, reference: &Film) -> Verdict {
    let film = render(&system.clone().with_accuracy(level.accuracy()), &());
    let board = &system.board().pattern;
    let lights = [board.black, board.white, board.background];
    let brightest = lights.iter().copied().fold(0.0, f64::max);
    // Where the light ends it is dark.
    let dark = reference.class.iter().flat_map(|class| class.data()).any(|class| class.side().is_none());
    let darkest = lights.iter().copied().fold(if dark { 0.0 } else { f64::INFINITY }, f64::min);
    // A line that moves by 1 px changes a pixel by at most its contrast times the pixel's diagonal.
    let per_px = (brightest - darkest) * 2.0f64.sqrt();
    let promise_px = film.account.promise_px + reference.account.bend_px;
    let width = film.radiance.width();
    let (mut broken, mut shift_px, mut at) = (0, 0.0, [0; 2]);
    for (k, (a, b)) in film.radiance.data().iter().zip(reference.radiance.data()).enumerate() {
        let off_px = (f64::from((a - b).abs()) - ROUNDING * brightest).max(0.0) / per_px;
        broken += u64::from(a.is_nan() || off_px > promise_px);
        if off_px > shift_px {
            (shift_px, at) = (off_px, [k % width, k / width]);
        }
    }
    // Where a half is the mirror image of the other, divisions are counted of one.
    let halves = if system.is_mirror_symmetric() { 2 } else { 1 };
    let Film { account, counts, .. } = film;
    let allowed = account.unpromised_pixels + halves * counts.capped_pixels + reference.counts.capped_pixels;
    Verdict { scene: scene.to_owned(), account, pixels: film.radiance.data().len(), broken, allowed, shift_px, at }
}

/// All levels in a scene.
fn verdicts(scene: &str, system: &System) -> [Verdict; 3] {
    let judge = Accuracy { bend_px: JUDGE_PX, ..Accuracy::reference() };
    let reference = render(&system.clone().with_accuracy(judge), &());
    LEVELS.map(|level| judged(scene, system, level, &reference))
}

/// Fails with the verdicts that do not keep the promise, and tells the worst of the others.
fn assert_kept(verdicts: &[Verdict]) {
    for level in LEVELS {
        let of_level: Vec<&Verdict> = verdicts.iter().filter(|verdict| verdict.account.level == level).collect();
        let pixels: usize = of_level.iter().map(|verdict| verdict.pixels).sum();
        let unpromised: u64 = of_level.iter().map(|verdict| verdict.account.unpromised_pixels).sum();
        println!("{}: {} scenes, {unpromised} of {pixels} pixels without promise", level.name(), of_level.len());
        let whole = of_level.iter().filter(|verdict| verdict.allowed == 0);
        if let Some(worst) = whole.max_by(|a, b| a.shift_px.total_cmp(&b.shift_px)) {
            println!("    worst: {worst}");
        }
    }
    let broken: Vec<String> = verdicts.iter().filter(|v| !v.keeps()).map(ToString::to_string).collect();
    assert!(broken.is_empty(), "{} promises are broken:\n{}", broken.len(), broken.join("\n"));
}

#[test]
fn every_pixel_keeps_the_promise_of_its_level() {
    let (first, count) = (number("LEVEL_LAW_FIRST", FIRST), number("LEVEL_LAW_SCENES", SCENES));
    let folder = std::env::var("LEVEL_LAW_FOLDER").ok();
    let found: Vec<Verdict> = (first..first + count)
        .into_par_iter()
        .filter_map(|number| {
            let (text, system) = scenes::scene(number)?;
            if let Some(folder) = &folder {
                std::fs::write(format!("{folder}/{number}.toml"), text).expect("the folder can be written to");
            }
            Some((number, system))
        })
        .flat_map_iter(|(number, system)| verdicts(&number.to_string(), &system))
        .collect();
    // Numbers drawn that make no instrument, or one through which no ray passes, are few.
    assert!(10 * found.len() as u64 >= 8 * 3 * count, "only {} of {count} scenes can be", found.len() / 3);
    assert_kept(&found);
}

/// Lines of the board on the sides of pixels, on the middle of the picture and on the ridge, which is there as well.
#[test]
fn lines_on_the_sides_of_pixels_are_where_they_are() {
    let mut found = Vec::new();
    for (width, height) in [(64, 12), (40, 8), (17, 9)] {
        for (prism, columns) in ["kind = \"none\"", FLAT].into_iter().flat_map(|p| (1..=6).map(move |n| (p, n))) {
            for pixels in [1.0, 4.0, 12.5] {
                let square_mm = pixels * 10.56 / width as f64 * 1000.0 / 35.0;
                let board = format!(
                    "columns = {columns}\nrows = 4\nsquare_mm = {square_mm:?}\nposition_mm = [0.0, 0.0, 1000.0]"
                );
                let name = format!("{width} x {height}, {columns} columns of {pixels} px, {prism}");
                found.extend(verdicts(&name, &built(&scene(width, height, prism, &board))));
            }
        }
    }
    assert_kept(&found);
}

/// A lens that bends the ridge, pictures that are nowhere symmetric, odd and even, and some that are large enough for a map.
#[test]
fn cameras_of_their_own_keep_the_promise() {
    const BARREL: &str = "distortion = [-2.0, 8.0, 0.0, 0.0, 0.0]";
    const LARGE: &str = "principal_point_px = [66.0, 30.0]\ndistortion = [-2.0, 8.0, 0.02, -0.03, 0.0]";
    const PINCUSHION: &str = "principal_point_px = [8.0, 5.1]\ndistortion = [1.5, 4.0, 0.02, -0.03, 0.0]";
    const ALL: &str = "principal_point_px = [10.7, 5.25]\nrotation_deg = [0.8, -1.1, 7.5]\n\
                       distortion = [-1.5, 3.0, 0.02, 0.04, 0.0]";
    let board =
        "columns = 12\nrows = 9\nsquare_mm = 21.0\nposition_mm = [4.0, 3.0, 1000.0]\ntilt_deg = [5.0, -8.0, 3.0]";
    let freeform = format!("{FREEFORM}\n[prism.design]\nstep_px = 4.0");
    let mut found = Vec::new();
    let small = [(BARREL, [24, 14]), (PINCUSHION, [17, 9]), (ALL, [20, 12])];
    let pairs = small.iter().flat_map(|camera| [NO_GLASS, FLAT, &freeform].map(|prism| (*camera, prism)));
    // One that is large enough for a map.
    for ((camera, [width, height]), prism) in pairs.chain([((LARGE, [144, 66]), FLAT)]) {
        let system = built(&scene_from(width, height, camera, prism, board));
        found.extend(verdicts(&format!("{width} x {height}, {camera}, {prism}"), &system));
    }
    assert_kept(&found);
}
