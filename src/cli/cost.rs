//! `biprism cost`: what accuracy costs in time, as numbers and as a curve.

use super::args::CostArgs;
use super::machine::machine;
use super::outcome::Outcome;
use super::progress::Progress;
use super::{files, origin, output};
use crate::analysis::cost::{CostSettings, cost};
use crate::error::Error;
use crate::report::cost::{CostReport, csv, table};
use crate::report::figures::cost;
use crate::report::page;
use std::path::Path;

pub(super) fn run(args: &CostArgs) -> Result<Outcome, Error> {
    let scene = files::scene(args.scene.as_deref(), &args.values)?;
    files::checkerboard(&scene, args.scene.as_deref().unwrap_or(Path::new("")))?;
    let names = [
        "cost.html",
        "cost.json",
        "cost.csv",
        "cost.png",
        "cost.svg",
        "cost_design.png",
        "cost_design.svg",
        "cost_mesh.png",
        "cost_mesh.svg",
        "cost_effects.png",
        "cost_effects.svg",
    ];
    files::outputs(&args.out, &names)?;
    let preset = if args.quick { CostSettings::quick() } else { CostSettings::default() };
    let settings = CostSettings { repetitions: usize::from(args.repetitions), ..preset };
    let progress = Progress::new(1);
    progress.begin(&scene.name, "design");
    let system = files::build(&scene, args.scene.as_deref().unwrap_or(Path::new("scenes/paper.toml")))?;
    let study = cost(&scene, &system, &settings, &progress.watch(&scene.name));
    drop(progress);

    let machine = machine();
    let json = CostReport::new(&scene.name, &machine, &study).to_json();
    let mut written = ["cost.json", "cost.csv", "cost.html"].map(|name| args.out.join(name)).to_vec();
    files::text(&written[0], &json)?;
    files::text(&written[1], &csv::text(&study))?;
    let title = cost::title(&scene.name, &study);
    files::text(&written[2], &page::cost::page(&title, &scene.name, &machine, &study, &origin::origin()))?;
    let drawing = cost::pictures(&scene.name, &machine, &study);
    written.extend(files::figure(&args.out, "cost", &drawing, &title)?);
    if !study.meshes.is_empty() {
        let drawing = cost::meshes(&scene.name, &machine, &study);
        written.extend(files::figure(&args.out, "cost_mesh", &drawing, &cost::mesh_title(&scene.name))?);
    }
    if !study.designs.is_empty() {
        let drawing = cost::designs(&scene.name, &machine, &study);
        written.extend(files::figure(&args.out, "cost_design", &drawing, &cost::design_title(&scene.name))?);
    }
    if !study.effects.is_empty() {
        let drawing = cost::effects(&scene.name, &machine, &study);
        written.extend(files::figure(&args.out, "cost_effects", &drawing, &cost::effect_title(&scene.name))?);
    }
    output::stdout(&if args.json { json } else { table::text(&scene.name, &machine, &study) })?;
    written.iter().for_each(|path| output::stderr(&format!("wrote {}", path.display())));
    Ok(Outcome::Done)
}
