//! `biprism compare`: the main job, from a prism to a verdict.

use super::args::CompareArgs;
use super::expect::expectations;
use super::outcome::Outcome;
use super::progress::Progress;
use super::{accuracy, files, output};
use crate::analysis::compare::{JudgeOptions, judge_design, pixels, prisms};
use crate::error::Error;
use crate::report::{self, budget, comparison, json, picture, table};
use crate::system::doubts;
use std::path::Path;

pub(super) fn run(args: &CompareArgs) -> Result<Outcome, Error> {
    let scene = accuracy::asked(files::scene(args.scene.as_deref())?, args.target_px);
    let prisms = prisms(&scene)?;
    outputs(&args.out, &prisms)?;
    let options = JudgeOptions { budget: args.budget };
    let progress = Progress::new(prisms.len() as u64 * pixels(&scene, options));
    let mut judged = Vec::new();
    let mut designs = Vec::new();
    let mut written = Vec::new();
    for (name, scene) in prisms {
        let design = judge_design(name, scene, options, &progress.watch(name));
        let design = files::named(args.scene.as_deref().unwrap_or(Path::new("scenes/paper.toml")), design)?;
        progress.begin(name, "write");
        for ending in ["png", "exr"] {
            let path = args.out.join(format!("{name}.{ending}"));
            files::print_clamped(&path, picture::write(&path, &design.scene, &design.system, &design.film)?);
            written.push(path);
        }
        designs.push(comparison::entry(&design, progress.take_seconds()));
        judged.push(design);
    }
    progress.begin("both", "figure");
    let verdict = table::verdict(&designs);
    if let [first, second] = &judged[..] {
        written.push(args.out.join("comparison.png"));
        let figure = comparison::figure(&scene, [first, second], &designs, &verdict);
        files::drawing(&args.out.join("comparison.png"), &figure)?;
    }
    if let Some(figure) = budget::figure(&scene, &judged).filter(|_| args.budget) {
        written.push(args.out.join("budget.png"));
        files::drawing(&args.out.join("budget.png"), &figure)?;
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
    for design in &judged {
        let doubts = doubts(&design.scene, &design.system);
        doubts.iter().for_each(|doubt| output::stderr(&format!("note: {}: {doubt}", design.name)));
    }
    for path in written {
        output::stderr(&format!("wrote {}", path.display()));
    }
    let kept = judged.iter().map(|j| accuracy::told(j.name, &j.film.account, &j.film.counts));
    let nothing = report.designs.iter().all(|design| design.not_judged.is_some());
    let judged = if nothing { Outcome::Unmet } else { Outcome::Done };
    Ok(kept.fold(expected.and(judged), Outcome::and))
}

/// That every file of the comparison may be written to `folder`, which is made.
fn outputs(folder: &Path, prisms: &[(&'static str, crate::scene::Scene)]) -> Result<(), Error> {
    let pictures = prisms.iter().flat_map(|(name, _)| ["png", "exr"].map(|ending| format!("{name}.{ending}")));
    let others = ["comparison.png", "budget.png", "report.json"].map(str::to_owned);
    let names: Vec<String> = pictures.chain(others).collect();
    files::outputs(folder, &names.iter().map(String::as_str).collect::<Vec<_>>()).map(drop)
}
