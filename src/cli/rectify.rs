//! `biprism rectify`: the maps of both halves for `cv2.remap`, and the pair that they make for OpenCV.

use super::outcome::Outcome;
use super::prisms_args::few_depths;
use super::progress::Progress;
use super::rectify_args::RectifyArgs;
use super::{files, output};
use crate::analysis::rectify::{Rectifier, SourceMap, Sources};
use crate::error::Error;
use crate::io::{Notes, exr, npy};
use crate::progress::Observer;
use crate::report::rectify::{RectifiedScene, channels, stereo_text};

/// What is written, in this order.
const FILES: [&str; 7] =
    ["left_x.npy", "left_y.npy", "right_x.npy", "right_y.npy", "maps.exr", "stereo.yml", "rectify.json"];

pub(super) fn run(args: &RectifyArgs) -> Result<Outcome, Error> {
    few_depths("--residuals-at-mm", &args.residuals_at_mm)?;
    let scene = files::load(&args.scene, &args.values)?;
    let progress = Progress::new(0);
    progress.begin(&scene.name, "design");
    let system = files::build(&scene, &args.scene)?;
    progress.begin(&scene.name, "cameras");
    let depth_mm = args.depth_mm.unwrap_or_else(|| Rectifier::board_depth_mm(&system));
    let rectifier = files::named(&args.scene, Rectifier::new(&system, depth_mm))?;
    let paths = files::outputs(&args.out, &FILES)?;

    // Make the maps, and say what they leave.
    let watch = progress.watch(&scene.name);
    watch.stage_of("maps", 2 * rectifier.frames()[0].size_px.element_product() as usize);
    let sources = Sources::new(&rectifier);
    let maps = [0, 1].map(|k| sources.map(k, &watch));
    watch.stage("residuals");
    let depths = args.residuals_at_mm.iter().copied().chain([f64::INFINITY]);
    let residuals: Vec<_> = depths.map(|depth_mm| rectifier.residual(depth_mm)).collect();
    let found = RectifiedScene { scene: &scene, rectifier: &rectifier, maps: &maps, residuals: &residuals };
    let (json, table) = (format!("{:#}\n", found.json()), found.table());
    drop(progress);

    // Write them.
    let planes = maps.iter().flat_map(|SourceMap { x, y, .. }| [x, y]);
    for (path, plane) in paths.iter().zip(planes) {
        npy::write_plane(path, plane)?;
    }
    exr::write(&paths[4], channels(maps), &Notes::default())?;
    files::text(&paths[5], &stereo_text(&rectifier))?;
    files::text(&paths[6], &json)?;
    output::stdout(if args.json { &json } else { &table })?;
    paths.iter().for_each(|path| output::stderr(&format!("wrote {}", path.display())));
    Ok(Outcome::Done)
}
