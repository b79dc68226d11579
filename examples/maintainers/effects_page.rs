//! Makes `docs/effects.md` and its pictures: `cargo run --release --example effects_page`.
//!
//! One section for each row of the table of effects, from its case `scenes/cases/effect_<key>.toml`: the picture without
//! and with the effect, their difference, the settings, and the time of the design paper's picture with these effects
//! over the time of the same picture without, on one thread. The times of all effects are taken in turns, so that a busy
//! moment falls on all alike.

use biprism::analysis::cost::cpu_ms;
use biprism::effect::{EffectRow, Effects, TABLE};
use biprism::geom::Rect;
use biprism::io::Notes;
use biprism::io::png;
use biprism::num::stats::quantile;
use biprism::plot::canvas;
use biprism::plot::colour::{ACCENT, GREY, INK, Map, Rgb, srgb_from_linear};
use biprism::plot::drawing::{Drawing, Item, Stroke};
use biprism::plot::picture::{cut_out, grey, mapped};
use biprism::plot::text::{Align, Font};
use biprism::raster::Raster;
use biprism::render::{Film, Outputs, render_wanted};
use biprism::scene::{self, Scene};
use biprism::system::{self, System};
use glam::DVec2;
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// Each picture is taken so often; effects that take long, at least [`LEAST`] times.
const REPETITIONS: usize = 9;
const LEAST: usize = 3;
/// No effect is repeated once it has taken this long altogether, in ms.
const PATIENCE_MS: f64 = 20_000.0;

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = root.join("docs/effects");
    fs::create_dir_all(&folder).expect("the folder of documents can be written to");
    let cases: Vec<Case> = TABLE.iter().map(|row| Case::of(root, row)).collect();
    for case in &cases {
        let path = folder.join(format!("{}.png", case.row.key()));
        png::write_rgb(&path, &figure(case), &Notes::default()).unwrap_or_else(|problem| panic!("{problem}"));
        eprintln!("{}", path.display());
    }
    let costs = costs(root, &cases);
    let page = root.join("docs/effects.md");
    fs::write(&page, text(&cases, &costs)).expect("the page can be written");
    eprintln!("{}", page.display());
}

/// An effect and its case.
struct Case {
    row: &'static EffectRow,
    scene: Scene,
    /// The same but for the effect's own table; others that it needs are in both.
    without: Scene,
    /// The part of the file that calls for effects.
    settings: String,
}

impl Case {
    fn of(root: &Path, row: &'static EffectRow) -> Self {
        let name = format!("scenes/cases/effect_{}.toml", row.key());
        let file = fs::read_to_string(root.join(&name)).unwrap_or_else(|error| panic!("{name}: {error}"));
        let parsed = |text: &str| scene::parse(text, &name, None).unwrap_or_else(|problem| panic!("{problem}"));
        let own = |part: &&str| [']', '.'].iter().any(|end| part.starts_with(&format!("[effect.{}{end}", row.key())));
        let without = tables(&file).into_iter().filter(|part| !own(part)).collect::<String>();
        let asks = |part: &&str| part.starts_with("[effect.") || part.starts_with("[quadrature]");
        let asking = tables(&file).into_iter().filter(asks).map(str::trim);
        let settings = asking.collect::<Vec<_>>().join("\n\n");
        Self { row, scene: parsed(&file), without: parsed(&without), settings }
    }

    /// Without and with the effect.
    fn films(&self) -> [Film; 2] {
        [&self.without, &self.scene].map(film)
    }
}

/// The tables of a TOML file, each with its head; the first part is what stands before them.
fn tables(file: &str) -> Vec<&str> {
    let heads = file.match_indices("\n[").map(|(at, _)| at + 1);
    let ends: Vec<usize> = [0].into_iter().chain(heads).chain([file.len()]).collect();
    ends.windows(2).map(|pair| &file[pair[0]..pair[1]]).collect()
}

fn film(scene: &Scene) -> Film {
    let system = system::build(scene).unwrap_or_else(|problem| panic!("{problem}"));
    render_wanted(&system, Outputs { truth: false }, &())
}

/// Side of the sheet's margins and of the gaps between panels, in px.
const GAP_PX: f64 = 14.0;
/// Height of a line of words, in px.
const LINE_PX: f64 = 22.0;
const WORDS: Font = Font::regular(14.0);
/// A close-up shows a part of the picture so much enlarged, over the size of the picture.
const ENLARGED: usize = 5;

/// off | on | difference, whole and close up.
fn figure(case: &Case) -> Raster<Rgb> {
    let films = case.films();
    let [off, on] = films.each_ref().map(|film| &film.radiance);
    let change = Raster::from_data(
        on.width(),
        on.height(),
        on.data().iter().zip(off.data()).map(|(on, off)| f64::from(*on) - f64::from(*off)).collect(),
    );
    let most = change.data().iter().fold(f64::MIN_POSITIVE, |most: f64, d| most.max(d.abs()));
    let panels = [shown(&films[0]), shown(&films[1]), mapped(&change.map(|d| 0.5 + 0.5 * d / most), Map::Diverging)];
    let (width, height) = (off.width(), off.height());
    let (part_width, part_height) = (width / ENLARGED, height / ENLARGED);
    let [left, top] = liveliest(&change, part_width, part_height);

    let panel = DVec2::new(width as f64, height as f64);
    let column = |k: usize| GAP_PX + k as f64 * (panel.x + GAP_PX);
    let rows = [GAP_PX + 2.0 * LINE_PX, GAP_PX + 3.0 * LINE_PX + panel.y];
    let mut drawing = Drawing::new((column(3)) as u32, (rows[1] + panel.y + GAP_PX) as u32);
    let title = format!("{}: {}", case.row.key(), case.row.what);
    let baseline = |y: f64| y - 0.35 * LINE_PX;
    drawing.text(title, Font::bold(15.0), INK, DVec2::new(GAP_PX, baseline(GAP_PX + LINE_PX)), Align::Start);
    let captions = ["off".to_owned(), "on".to_owned(), format!("on less off, {}", range(most))];
    for (k, (whole, caption)) in panels.iter().zip(captions).enumerate() {
        drawing.text(caption, WORDS, INK, DVec2::new(column(k), baseline(rows[0])), Align::Start);
        let part = cut_out(whole, left, top, part_width, part_height);
        for (picture, y) in [(whole.clone(), rows[0]), (part, rows[1])] {
            let min = DVec2::new(column(k), y);
            // Blocks of whole pixels.
            let scale = (panel.x as usize / picture.width()) as f64;
            let size = DVec2::new(picture.width() as f64, picture.height() as f64) * scale;
            let rect = Rect { min, max: min + size };
            drawing.push(Item::Picture(rect, picture));
            drawing.frame(&rect, Stroke::solid(GREY, 1.0));
        }
        let corner = DVec2::new(column(k) + left as f64, rows[0] + top as f64);
        let size = DVec2::new(part_width as f64, part_height as f64);
        drawing.frame(&Rect { min: corner, max: corner + size }, Stroke::solid(ACCENT, 1.0));
    }
    let place = format!("the marked {part_width} x {part_height} px, {ENLARGED} times as large");
    drawing.text(place, WORDS, INK, DVec2::new(GAP_PX, baseline(rows[1])), Align::Start);
    canvas::raster(&drawing)
}

/// The picture as a screen shows it.
fn shown(film: &Film) -> Raster<Rgb> {
    match &film.colour {
        Some(colour) => colour.map(|v| v.map(|v| srgb_from_linear(v.into()))),
        None => grey(&film.radiance),
    }
}

/// The bounds of a colour scale about 0, of full scale 1.
fn range(most: f64) -> String {
    let decimals = (1.0 - libm::log10(most).floor()).clamp(0.0, 12.0) as usize;
    format!("blue -{most:.decimals$} to red +{most:.decimals$}")
}

/// First column and row of the window that holds the largest squares.
fn liveliest(change: &Raster<f64>, width: usize, height: usize) -> [usize; 2] {
    let energy = |x: usize, y: usize| -> f64 {
        (y..y + height).map(|j| change.row(j)[x..x + width].iter().map(|d| d * d).sum::<f64>()).sum()
    };
    let columns = (0..=change.width() - width).step_by(8);
    let windows = columns.flat_map(|x| (0..=change.height() - height).step_by(8).map(move |y| [x, y]));
    windows.map(|at| (energy(at[0], at[1]), at)).fold((-1.0, [0, 0]), |a, b| if b.0 > a.0 { b } else { a }).1
}

/// The time of a picture over that of the plain one in the same turn.
struct Cost {
    ratio: f64,
    /// A tenth of the turns lies below, a tenth above.
    spread: [f64; 2],
    turns: usize,
}

/// The time of the design paper's picture with each case's effects over that without; the last is the plain picture
/// against itself.
fn costs(root: &Path, cases: &[Case]) -> Vec<Cost> {
    let paper = scene::load(&root.join("scenes/paper.toml")).unwrap_or_else(|problem| panic!("{problem}"));
    let scenes: Vec<Scene> = (cases.iter().map(|case| case.scene.effects.clone()))
        .chain([Effects::default()])
        .map(|effects| Scene { effects, ..paper.clone() })
        .collect();
    let systems: Vec<_> =
        scenes.iter().map(|scene| system::build(scene).unwrap_or_else(|problem| panic!("{problem}"))).collect();
    let plain = systems.last().expect("the plain one is there").clone();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("one thread");
    let time_ms = |system: &System| {
        let picture = || std::hint::black_box(render_wanted(system, Outputs { truth: false }, &()));
        pool.install(|| cpu_ms(picture).0)
    };
    let (mut ratios, mut taken) = (vec![Vec::new(); systems.len()], vec![0.0; systems.len()]);
    for turn in 0..REPETITIONS {
        for (k, system) in systems.iter().enumerate() {
            if turn < LEAST || taken[k] < PATIENCE_MS {
                let (with, without) = (time_ms(system), time_ms(&plain));
                ratios[k].push(with / without);
                taken[k] += with;
            }
        }
        eprintln!("times: turn {} of {REPETITIONS}", turn + 1);
    }
    let quantile = |r: &[f64], q: f64| quantile(r, q).expect("at least one turn");
    let cost =
        |r: &Vec<f64>| Cost { ratio: quantile(r, 0.5), spread: [quantile(r, 0.1), quantile(r, 0.9)], turns: r.len() };
    ratios.iter().map(cost).collect()
}

fn text(cases: &[Case], costs: &[Cost]) -> String {
    let mut text = String::from(HEAD);
    for (case, cost) in cases.iter().zip(costs) {
        let EffectRow { hook, what, source, .. } = case.row;
        let key = case.row.key();
        let hook = serde_json::to_string(hook).expect("a word");
        let _ =
            writeln!(text, "| [{key}](#{key}) | {} | {what} | {} | {source} |", hook.trim_matches('"'), cost.words());
    }
    let plain = costs.last().expect("the plain one is there");
    let _ = writeln!(text, "| (none) | | the plain picture against itself | {} | |", plain.words());
    for (case, cost) in cases.iter().zip(costs) {
        let EffectRow { what, cost: why, .. } = case.row;
        let key = case.row.key();
        let _ = writeln!(text, "\n## {key}\n\n{}.\n", capital(what));
        let _ = writeln!(text, "![{what}: off, on, difference](effects/{key}.png)\n");
        let _ = writeln!(text, "`scenes/cases/effect_{key}.toml`:\n\n```toml\n{}\n```\n", case.settings);
        let _ = writeln!(text, "Time: {} the plain picture ({} turns); {why}.", cost.words(), cost.turns);
    }
    text
}

const HEAD: &str = "\
# What each effect does, and what it costs

Made by `cargo run --release --example effects_page`, from the table of effects and from its case scenes; do not edit.

A scene has an effect when it has the table `[effect.<key>]`, and pays for it only then. Below, each effect is added
alone: `off` is its case without the effect's own table, `on` is the case, both in sRGB; the difference is of linear
radiance, of full scale 1. The time is that of the design paper's picture (`scenes/paper.toml`, 1920 x 1080 px, level
`standard`) with the effects of the case, over that of the picture without any: processor time of one thread, the two
taken one right after the other, all effects in turns; the median of the turns, and what a tenth of them lies below and
above.

| effect | where | what | time | source |
|---|---|---|---|---|
";

impl Cost {
    fn words(&self) -> String {
        let [low, high] = self.spread.map(digits);
        format!("{} x ({low} to {high})", digits(self.ratio))
    }
}

/// Three digits, as many as repeated runs share.
fn digits(v: f64) -> String {
    match v {
        ..10.0 => format!("{v:.2}"),
        ..100.0 => format!("{v:.1}"),
        _ => format!("{v:.0}"),
    }
}

fn capital(words: &str) -> String {
    let mut letters = words.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}
