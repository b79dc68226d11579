//! `biprism check`: what a scene holds, without a picture of it.

use super::args::CheckArgs;
use super::outcome::Outcome;
use super::plan::TimedEstimate;
use super::progress::Progress;
use super::{files, output};
use crate::analysis::fit_shift::fit_shifts;
use crate::analysis::half_image::{HalfFrame, NoPinhole, virtual_camera, virtual_camera_made};
use crate::error::Error;
use crate::metrics::pinhole::Pinhole;
use crate::report::fit;
use crate::scene::{Scene, TextureSpec};
use crate::system::auto;
use crate::system::crossing::Crossing;
use crate::system::{self, System};
use crate::vision::half::Half;
use glam::DVec3;
use serde_json::{Value, json};

pub(super) fn run(args: &CheckArgs) -> Result<Outcome, Error> {
    let scene = files::load(&args.scene, &args.values)?;
    let progress = Progress::new(0);
    progress.begin(&scene.name, "build");
    let ideal = files::named(&args.scene, system::ideal(&scene))?;
    progress.begin(&scene.name, "effects");
    let verdicts = auto::verdicts(&ideal, &scene);
    let system = ideal.with_effects(&auto::settled(&verdicts, &scene));
    files::named(&args.scene, system::require_light(&scene, &system))?;
    progress.begin(&scene.name, "time");
    let plan = TimedEstimate::new(&scene, &ideal, &system, verdicts);
    let doubts = system::doubts(&scene, &system);
    let crossing = Crossing::of(&system);
    let fits = fit_shifts(&scene, &system).map(|fits| fit::entry(&fits));
    drop(progress);
    let found = json!({
        "scene": scene.name,
        "prism": scene.prism.kind(),
        "size_px": [scene.camera.width_px, scene.camera.height_px],
        "board": {
            "squares": [scene.board.columns, scene.board.rows],
            "centre_mm": scene.board.world_from_board.translation_mm.to_array(),
            "texture": scene.texture.as_ref().map(TextureSpec::words),
        },
        "plan": plan.json(),
        "doubts": doubts,
        "surface_fits": fits,
        "columns_through_other_half": crossing.map(|crossing| crossing.columns),
        "solid": crossing.map(|crossing| crossing.solid || crossing.harmless),
        "halves": { "left": half(&system, Half::Left), "right": half(&system, Half::Right) },
    });
    if args.json {
        output::stdout(&format!("{found:#}\n"))?;
    } else {
        let mut text = format!("{} can be rendered\n", files::shown(&args.scene));
        text += &format!("prism   {}\n", scene.prism.kind());
        text += &format!("sensor  {} x {} px\n", scene.camera.width_px, scene.camera.height_px);
        text += &board(&scene);
        for half in Half::BOTH {
            let frame = HalfFrame::new(&system, half);
            let [made, designed] = [virtual_camera_made(&system, &frame), virtual_camera(&system, &frame)].map(told);
            text += &format!("{:7} virtual camera {made}", half.name());
            text += &if made == designed { "\n".to_owned() } else { format!(" as made, {designed} as designed\n") };
        }
        if let Some(words) = crossing.and_then(|crossing| crossing.words()) {
            text += &format!("glass   {words}\n");
        }
        for line in fits.iter().flat_map(fit::words) {
            text += &format!("fit     {line}\n");
        }
        text += &plan.text();
        output::stdout(&text)?;
        doubts.iter().for_each(|doubt| output::stderr(&format!("note: {doubt}")));
    }
    if !plan.in_reach() {
        output::unmet(&format!("{}: the target that it asks for is out of reach", files::shown(&args.scene)));
    }
    Ok(if plan.in_reach() { Outcome::Done } else { Outcome::Unmet })
}

/// What the board shows, and where it is.
fn board(scene: &Scene) -> String {
    let board = &scene.board;
    let centre = board.world_from_board.translation_mm;
    let shown = match &scene.texture {
        None => format!("{} x {} squares of {} mm", board.columns, board.rows, board.square_mm),
        Some(texture) => {
            let size_mm = texture.size_mm(board.squares_mm());
            format!("{}, {} x {} mm", texture.words(), size_mm.x, size_mm.y)
        }
    };
    format!("board   {shown}, centre at {centre} mm\n")
}

/// The virtual cameras of a half, as made and as designed, for JSON.
fn half(system: &System, half: Half) -> Value {
    let frame = HalfFrame::new(system, half);
    let designed = virtual_camera(system, &frame).ok().map(|camera| camera.centre_mm().to_array());
    match virtual_camera_made(system, &frame) {
        Ok(camera) => {
            json!({ "virtual_camera_mm": camera.centre_mm().to_array(), "designed_camera_mm": designed })
        }
        Err(NoPinhole::Ends(fate)) => json!({ "central_ray": fate.name(), "designed_camera_mm": designed }),
        Err(NoPinhole::Telecentric) => json!({ "camera": "telecentric" }),
    }
}

/// Where a virtual camera is, or why there is none.
fn told(camera: Result<Pinhole, NoPinhole>) -> String {
    match camera {
        Ok(camera) => {
            let at = camera.centre_mm() + DVec3::ZERO;
            format!("at ({:.4}, {:.4}, {:.4}) mm", at.x, at.y, at.z)
        }
        Err(why) => format!("none: {why}"),
    }
}
