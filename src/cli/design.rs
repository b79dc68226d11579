//! `biprism design`: the freeform prism of a scene, as scene text and as points.

use super::args::DesignArgs;
use super::outcome::Outcome;
use super::progress::Progress;
use super::{files, output};
use crate::design::{self, DesignInput, MetLaw, text};
use crate::error::Error;
use crate::io::atomic::write_atomically;

use crate::io::point_grid::{write_csv, write_ply};
use crate::scene::{MarchOrder, PrismSpec};
use crate::surface::face::Face;
use crate::system::with_room_for;

pub(super) fn run(args: &DesignArgs) -> Result<Outcome, Error> {
    let mut scene = files::load(&args.scene)?;
    let mut input = DesignInput::of(&scene).ok_or_else(|| {
        Error::new(
            files::shown(&args.scene),
            "`prism.kind` must be \"flat\" or \"freeform\" for a prism to be designed",
            "state index, ridge_distance_mm and thickness_mm, with kind = \"freeform\"",
        )
    })?;
    input.settings.objective = args.objective.map_or(input.settings.objective, Into::into);
    input.settings.degree = args.degree.map_or(input.settings.degree, |degree| degree as usize);
    input.settings.goal.rear = args.rear.map_or(input.settings.goal.rear, Into::into);
    if args.y_then_x {
        input.settings.order = MarchOrder::YThenX;
    }
    // What the arguments say goes with what the scene says, or is refused.
    scene.prism = PrismSpec::Freeform(input.prism, input.settings);
    scene.check()?;
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
            "law": designed.met.as_ref().map(law_json),
        });
        output::stdout(&format!("{figures:#}\n"))?;
    } else {
        let mut lines = vec![
            format!("facet angle             {:.5} deg", camera.alpha_rad.to_degrees()),
            format!("baseline                {:.4} mm", camera.baseline_mm()),
            format!("points                  {}", cloud.len()),
            format!("optical path, spread    {:.1e} mm", designed.optical_path_spread_mm),
            format!("front fit, RMS and max  {:.2e}, {:.2e} mm", front.rms_mm, front.max_mm),
            format!("back fit, RMS and max   {:.2e}, {:.2e} mm", back.rms_mm, back.max_mm),
        ];
        lines.extend(designed.met.iter().flat_map(law_lines));
        output::stdout(&(lines.join("\n") + "\n"))?;
    }
    paths.iter().for_each(|path| output::stderr(&format!("wrote {}", path.display())));
    output::stderr("prism.toml is the [prism] part of a scene: put it beside a camera and a board");
    Ok(Outcome::Done)
}

/// The law that a design meets, and how well, for a reader.
fn law_lines(met: &MetLaw) -> Vec<String> {
    let law = &met.law;
    let [fx, fy] = law.focal_mm;
    let rows = if law.rows { ", each row shifted by its kappa" } else { "" };
    let mut lines = vec![
        format!("law, f_x and f_y         {fx:.5}, {fy:.5} mm{rows}"),
        format!(
            "law, c_x, z and toe      {:.5} mm, {:.4} mm, {:.5} deg",
            law.centre_x_mm,
            law.eye_mm[2],
            law.toe_rad.to_degrees()
        ),
    ];
    lines.extend(met.figures.iter().map(|at| {
        let depth = if at.depth_mm.is_finite() { format!("{} mm", at.depth_mm) } else { "infinity".to_owned() };
        format!(
            "missed at {depth:<14} u {:.1e}, v {:.1e} px RMS, {:.1e} px at most",
            at.rms_px[0], at.rms_px[1], at.max_px
        )
    }));
    if met.floor_reached {
        lines.push("a higher degree gains little: a floor of the objective".to_owned());
    }
    let spot = met.spot.as_ref();
    lines.extend(
        spot.map(|s| format!("spot                    {:.3} px RMS, refocused by {:.2} dpt", s.rms_px, s.refocus_dpt)),
    );
    lines
}

/// The same for a program.
fn law_json(met: &MetLaw) -> serde_json::Value {
    let law = &met.law;
    let figures = met.figures.iter().map(|at| {
        // Infinity is no number of JSON.
        let depth_mm = at.depth_mm.is_finite().then_some(at.depth_mm);
        serde_json::json!({"depth_mm": depth_mm, "rms_px": at.rms_px, "max_px": at.max_px})
    });
    serde_json::json!({
        "focal_mm": law.focal_mm,
        "centre_x_mm": law.centre_x_mm,
        "eye_mm": law.eye_mm,
        "toe_deg": law.toe_rad.to_degrees(),
        "rows": law.rows,
        "missed": figures.collect::<Vec<_>>(),
        "floor_reached": met.floor_reached,
        "spot_rms_px": met.spot.map(|spot| spot.rms_px),
        "refocus_dpt": met.spot.map(|spot| spot.refocus_dpt),
    })
}
