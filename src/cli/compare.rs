//! `biprism compare`: the main job, from a prism to a verdict.

use super::args::CompareArgs;
use super::expect::expectations;
use super::outcome::Outcome;
use super::progress::Progress;
use super::{accuracy, files, output};
use crate::analysis::budget::{self, Budget};
use crate::analysis::fit_shift::fit_shifts;
use crate::analysis::judge::{Judgement, fates, judge, other_depth};
use crate::error::Error;
use crate::io::{Notes, png};
use crate::plot::canvas;
use crate::render::Film;
use crate::report::figures::budget::BudgetInput;
use crate::report::figures::comparison::{self, ComparisonInput, CornerMark, FigureRow, Panel};
use crate::report::{self, design, json, table};
use crate::scene::{DesignSettings, PrismSpec, Scene};
use crate::system::doubts;
use glam::DVec2;
use std::path::Path;

/// One prism, judged.
struct Judged {
    name: &'static str,
    film: Film,
    judgement: Judgement,
    budget: Option<Budget>,
}

pub(super) fn run(args: &CompareArgs) -> Result<Outcome, Error> {
    let scene = accuracy::asked(files::scene(args.scene.as_deref())?, args.target_px);
    let prisms = two_prisms(&scene)?;
    files::folder(&args.out)?;
    let pixels = (scene.camera.width_px * scene.camera.height_px) as u64;
    let own_depth = scene.board.world_from_board.translation_mm.z - scene.camera.position_mm.z;
    let boards = 1 + scene.analysis.depths_mm.iter().filter(|&&depth| other_depth(depth, own_depth)).count() as u64;
    let pictures = boards + if args.budget { budget::pictures(&scene.effects) } else { 0 };
    let mut progress = Progress::new(prisms.len() as u64 * pictures * pixels);
    let mut judged = Vec::new();
    let mut designs = Vec::new();
    let mut written = Vec::new();
    let mut notes = Vec::new();
    for (name, scene) in &prisms {
        progress.begin(name, "design");
        let system = files::build(scene, args.scene.as_deref().unwrap_or(Path::new("scenes/paper.toml")))?;
        let rendered = progress.handle();
        let (film, judgement) = judge(scene, &system, &mut |step| progress.begin(name, step), &rendered);
        let budget = if args.budget {
            progress.begin(name, "budget");
            Some(budget::budget(scene, &system, &judgement.view, &rendered)?)
        } else {
            None
        };
        progress.begin(name, "write");
        for ending in ["png", "exr"] {
            let path = args.out.join(format!("{name}.{ending}"));
            files::picture(&path, scene, &system, &film)?;
            written.push(path);
        }
        let timing = progress.take_seconds();
        let entry = design::entry(name, &judgement, &fates(&film.class), timing, scene.camera.pitch_mm);
        designs.push(json::Design {
            accuracy: Some(accuracy::entry(&film.account, &film.counts)),
            error_budget: budget.as_ref().map(report::budget::entry),
            surface_fits: fit_shifts(scene, &system).map(|fits| report::fit::entry(&fits)),
            ..entry
        });
        notes.extend(doubts(scene, &system).into_iter().map(|doubt| format!("note: {name}: {doubt}")));
        judged.push(Judged { name, film, judgement, budget });
    }
    progress.begin("both", "figure");
    let verdict = table::verdict(&designs);
    if let [first, second] = &judged[..] {
        let path = args.out.join("comparison.png");
        comparison_figure(&path, &scene, [first, second], &designs, &verdict)?;
        written.push(path);
    }
    if args.budget {
        let path = args.out.join("budget.png");
        budget_figure(&path, &scene, &judged)?;
        written.push(path);
    }
    drop(progress);
    let report = json::Report { schema: json::SchemaName::V1, scene: scene.name.clone(), designs };
    let text = json::to_text(&report);
    written.push(args.out.join("report.json"));
    files::text(&args.out.join("report.json"), &text)?;
    let expected = expectations(&scene, &report)?;
    output::stdout(&if args.json { text } else { format!("{}\n\n{verdict}\n", table::text(&report.designs)) })?;
    report.designs.iter().flat_map(table::warnings).for_each(|warning| output::stderr(&warning));
    let fits = report.designs.iter().filter_map(|design| design.surface_fits.as_ref()).flat_map(report::fit::words);
    fits.for_each(|line| output::stderr(&format!("fit of the {line}")));
    notes.iter().for_each(|note| output::stderr(note));
    for path in written {
        output::stderr(&format!("wrote {}", path.display()));
    }
    let kept = judged.iter().map(|j| accuracy::told(j.name, &j.film.account, &j.film.counts));
    Ok(kept.fold(expected, Outcome::and))
}

/// The scene with its flat prism and with its freeform prism. A prism given by its surfaces has no flat twin and is
/// judged alone.
fn two_prisms(scene: &Scene) -> Result<Vec<(&'static str, Scene)>, Error> {
    let with = |prism: PrismSpec| Scene { prism, ..scene.clone() };
    Ok(match &scene.prism {
        PrismSpec::Flat(flat) => {
            vec![("flat", scene.clone()), ("freeform", with(PrismSpec::Freeform(*flat, DesignSettings::default())))]
        }
        PrismSpec::Freeform(flat, _) => vec![("flat", with(PrismSpec::Flat(*flat))), ("freeform", scene.clone())],
        PrismSpec::Polynomial(_) | PrismSpec::PointCloud(_) | PrismSpec::Mesh(_) => {
            vec![(files::prism_name(&scene.prism), scene.clone())]
        }
        PrismSpec::None => {
            return Err(Error::new(
                format!("scene {}", scene.name),
                "`prism.kind` is \"none\", and there is no prism to judge",
                "give the scene a prism, or use `biprism render`",
            ));
        }
    })
}

/// `comparison.png`: two prisms side by side.
fn comparison_figure(
    path: &Path,
    scene: &Scene,
    judged: [&Judged; 2],
    designs: &[json::Design],
    verdict: &str,
) -> Result<(), Error> {
    let marks = judged.map(|j| corner_marks(&j.judgement));
    let panels = [0, 1].map(|k| Panel {
        name: format!("{} prism", judged[k].name),
        picture: &judged[k].film.radiance,
        corners: &marks[k],
    });
    let seam_px = 0.5 * scene.camera.width_px as f64;
    let rows = table::rows(designs).into_iter();
    let rows =
        rows.map(|row| FigureRow { label: row.short_label, values: [row.short[0].clone(), row.short[1].clone()] });
    let input = ComparisonInput {
        title: format!(
            "{}: {} mm squares at {} mm, seen through two prisms",
            scene.name,
            scene.board.square_mm,
            scene.board.world_from_board.translation_mm.z - scene.camera.position_mm.z
        ),
        arrow_gain: comparison::suitable_gain(&panels, seam_px),
        panels,
        seam_px,
        figures: rows.collect(),
        verdict: verdict.to_owned(),
        width_px: 2000,
    };
    let drawn = canvas::raster(&comparison::draw(&input));
    png::write_rgb(path, &drawn, &Notes::default())
}

/// `budget.png`: where the error of each corner comes from.
fn budget_figure(path: &Path, scene: &Scene, judged: &[Judged]) -> Result<(), Error> {
    let budgets: Vec<(String, &Budget)> =
        judged.iter().filter_map(|j| Some((format!("{} prism", j.name), j.budget.as_ref()?))).collect();
    let Some(first) = judged.first() else { return Ok(()) };
    let full = |k: usize, px: DVec2| first.judgement.view.halves[k].frame.full(px);
    let camera = &scene.camera;
    let input = BudgetInput {
        title: format!("{}: where the error of a corner comes from", scene.name),
        picture_px: DVec2::new(camera.width_px as f64, camera.height_px as f64),
        seam_px: 0.5 * camera.width_px as f64,
        rows: report::budget::rows(&budgets, full),
        width_px: 2000,
    };
    png::write_rgb(path, &canvas::raster(&crate::report::figures::budget::draw(&input)), &Notes::default())
}

/// Detected corners of both halves with their deviation from the designed virtual camera.
fn corner_marks(judgement: &Judgement) -> Vec<CornerMark> {
    let board = &judgement.view.board;
    let of_half = |half: &crate::analysis::view::HalfView| {
        let Some(camera) = half.camera else { return Vec::new() };
        let mark = |f: &crate::analysis::board_indexing::Found| {
            let [column, row] = f.index.map(f64::from);
            let ideal = camera.project(board.world(board.corner_at(column, row)))?;
            Some(CornerMark {
                index: f.index,
                position_px: half.frame.full(f.position_px),
                error_px: f.position_px - ideal,
            })
        };
        half.found.iter().filter_map(mark).collect()
    };
    judgement.view.halves.iter().flat_map(of_half).collect()
}
