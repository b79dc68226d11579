//! `biprism render`: the picture of a scene.

use super::args::RenderArgs;
use super::progress::Progress;
use super::{Outcome, accuracy, files, say};
use crate::analysis::judge::fates;
use crate::problem::Problem;
use crate::{render, scene};

pub(super) fn run(args: &RenderArgs) -> Result<Outcome, Problem> {
    let scene = accuracy::asked(scene::load(&args.scene)?, args.target_px);
    args.out.iter().try_for_each(|path| files::picture_name(path))?;
    let mut progress = Progress::new((scene.camera.width_px * scene.camera.height_px) as u64);
    progress.begin(&scene.name, "design");
    let system = files::build(&scene, &args.scene)?;
    progress.begin(&scene.name, "render");
    let film = render::render(&system, &progress.handle());
    progress.begin(&scene.name, "write");
    for path in &args.out {
        files::picture(path, &scene, &system, &film)?;
    }
    let seconds = progress.take_seconds();
    drop(progress);
    if args.json {
        let done = serde_json::json!({
            "scene": scene.name,
            "size_px": [scene.camera.width_px, scene.camera.height_px],
            "fates": fates(&film),
            "counts": film.counts,
            "accuracy": accuracy::entry(&film.account, &film.counts),
            "timing_s": seconds,
        });
        say::data(&format!("{done:#}\n"))?;
    } else {
        for path in &args.out {
            say::words(&format!("wrote {}", path.display()));
        }
        for (fate, n) in fates(&film).into_iter().filter(|(_, n)| *n > 0) {
            say::words(&format!("{n} pixels never see the board: {fate}"));
        }
    }
    Ok(accuracy::told(&scene.name, &film.account, &film.counts))
}
