//! `biprism design`: the freeform prism of a scene, as scene text and as points.

use super::args::DesignArgs;
use super::outcome::Outcome;
use super::progress::Progress;
use super::{files, output};
use crate::design::{self, DesignInput, text};
use crate::error::Error;
use crate::io::atomic::write_atomically;

use crate::io::point_grid::{write_csv, write_ply};
use crate::scene::MarchOrder;
use crate::surface::face::Face;
use crate::system::with_room_for;

pub(super) fn run(args: &DesignArgs) -> Result<Outcome, Error> {
    let scene = files::load(&args.scene)?;
    let mut input = DesignInput::of(&scene).ok_or_else(|| {
        Error::new(
            files::shown(&args.scene),
            "`prism.kind` must be \"flat\" or \"freeform\" for a prism to be designed",
            "state index, ridge_distance_mm and thickness_mm, with kind = \"freeform\"",
        )
    })?;
    input.settings.objective = args.objective.map_or(input.settings.objective, Into::into);
    input.settings.degree = args.degree.map_or(input.settings.degree, |degree| degree as usize);
    if args.y_then_x {
        input.settings.order = MarchOrder::YThenX;
    }
    let paths = files::outputs(&args.out, &["prism.toml", "cloud.csv", "front.ply", "back.ply"])?;
    let progress = Progress::new(0);
    progress.begin(&scene.name, "design");
    let designed = design::freeform(&input)?;
    progress.begin(&scene.name, "write");
    let cloud = &designed.cloud;
    // As large as the rays of the scene need it, not those of the design alone.
    let body = input.prism.body;
    let exported = with_room_for(designed.prism(body), &input.prism, &scene.camera, &scene.effects);
    let text = text::scene_prism(&exported.front, &exported.back, &body);
    files::text(&paths[0], &text)?;
    write_atomically(&paths[1], |out| write_csv(cloud.points(), out))?;
    for (path, face) in [(&paths[2], Face::Front), (&paths[3], Face::Back)] {
        let size = [cloud.columns(), cloud.rows()];
        write_atomically(path, |out| write_ply(size, cloud.points(), face, out))?;
    }
    drop(progress);
    let (camera, front, back) = (&designed.camera, &designed.front, &designed.back);
    if args.json {
        let figures = serde_json::json!({
            "facet_angle_deg": camera.alpha_rad.to_degrees(),
            "half_angle_deg": camera.delta_rad.to_degrees(),
            "baseline_mm": camera.baseline_mm(),
            "virtual_camera_mm": camera.centre_mm.to_array(),
            "points": cloud.len(),
            "optical_path_spread_mm": designed.optical_path_spread_mm,
            "front": {"rms_mm": front.rms_mm, "max_mm": front.max_mm, "condition": front.condition},
            "back": {"rms_mm": back.rms_mm, "max_mm": back.max_mm, "condition": back.condition},
        });
        output::stdout(&format!("{figures:#}\n"))?;
    } else {
        let lines = [
            format!("facet angle             {:.5} deg", camera.alpha_rad.to_degrees()),
            format!("baseline                {:.4} mm", camera.baseline_mm()),
            format!("points                  {}", cloud.len()),
            format!("optical path, spread    {:.1e} mm", designed.optical_path_spread_mm),
            format!("front fit, RMS and max  {:.2e}, {:.2e} mm", front.rms_mm, front.max_mm),
            format!("back fit, RMS and max   {:.2e}, {:.2e} mm", back.rms_mm, back.max_mm),
        ];
        output::stdout(&(lines.join("\n") + "\n"))?;
    }
    paths.iter().for_each(|path| output::stderr(&format!("wrote {}", path.display())));
    output::stderr("prism.toml is the [prism] part of a scene: put it beside a camera and a board");
    Ok(Outcome::Done)
}
