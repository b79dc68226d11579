//! `biprism design`: the freeform prism of a scene, as scene text and as points.

use super::args::DesignArgs;
use super::outcome::Outcome;
use super::{files, output};
use crate::design::{self, DesignInput, VIRTUAL_CAMERA_Z_MM, text};
use crate::error::Error;
use crate::io::atomic::write_atomically;
use crate::io::point_cloud::Surface;
use crate::io::point_grid;
use crate::prism::biprism::with_room_for;
use crate::scene::{DesignSettings, MarchOrder, PrismSpec};

pub(super) fn run(args: &DesignArgs) -> Result<Outcome, Error> {
    let scene = crate::scene::load(&args.scene)?;
    let (prism, mut settings) = match &scene.prism {
        PrismSpec::Flat(flat) => (*flat, DesignSettings::default()),
        PrismSpec::Freeform(flat, settings) => (*flat, *settings),
        _ => {
            return Err(Error::new(
                args.scene.display(),
                "`prism.kind` must be \"flat\" or \"freeform\" for a prism to be designed",
                "state index, ridge_distance_mm and thickness_mm, with kind = \"freeform\"",
            ));
        }
    };
    if args.y_then_x {
        settings.order = MarchOrder::YThenX;
    }
    let input = DesignInput { camera: scene.camera, prism, settings, virtual_camera_z_mm: VIRTUAL_CAMERA_Z_MM };
    let designed = design::freeform(&input)?;
    files::folder(&args.out)?;
    let body = prism.body;
    // As large as the rays of the scene need it, not those of the design alone.
    let exported = with_room_for(designed.prism(body), &prism, &scene.effects);
    let text = text::scene_prism(&exported.front, &exported.back, &body);
    files::text(&args.out.join("prism.toml"), &text)?;
    write_atomically(&args.out.join("cloud.csv"), |out| point_grid::write_csv(&designed.cloud, out))?;
    write_atomically(&args.out.join("front.ply"), |out| point_grid::write_ply(&designed.cloud, Surface::Front, out))?;
    write_atomically(&args.out.join("back.ply"), |out| point_grid::write_ply(&designed.cloud, Surface::Back, out))?;
    let (camera, front, back) = (&designed.camera, &designed.front, &designed.back);
    if args.json {
        let figures = serde_json::json!({
            "facet_angle_deg": camera.alpha_rad.to_degrees(),
            "half_angle_deg": camera.delta_rad.to_degrees(),
            "baseline_mm": camera.baseline_mm(),
            "virtual_camera_mm": camera.centre_mm.to_array(),
            "points": designed.cloud.len(),
            "optical_path_spread_mm": designed.optical_path_spread_mm,
            "front": {"rms_mm": front.rms_mm, "max_mm": front.max_mm, "condition": front.condition},
            "back": {"rms_mm": back.rms_mm, "max_mm": back.max_mm, "condition": back.condition},
        });
        output::stdout(&format!("{figures:#}\n"))?;
    } else {
        let lines = [
            format!("facet angle             {:.5} deg", camera.alpha_rad.to_degrees()),
            format!("baseline                {:.4} mm", camera.baseline_mm()),
            format!("points                  {}", designed.cloud.len()),
            format!("optical path, spread    {:.1e} mm", designed.optical_path_spread_mm),
            format!("front fit, RMS and max  {:.2e}, {:.2e} mm", front.rms_mm, front.max_mm),
            format!("back fit, RMS and max   {:.2e}, {:.2e} mm", back.rms_mm, back.max_mm),
        ];
        output::stdout(&(lines.join("\n") + "\n"))?;
    }
    for name in ["prism.toml", "cloud.csv", "front.ply", "back.ply"] {
        output::stderr(&format!("wrote {}", args.out.join(name).display()));
    }
    output::stderr("prism.toml is the [prism] part of a scene: put it beside a camera and a board");
    Ok(Outcome::Done)
}
