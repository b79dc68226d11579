//! Prisms measured, compared, designed and rectified: reports as JSON.

use crate::half_corners::{GivenCorners, views_of};
use crate::long_call::{Stopper, long_call};
use crate::picture_in::{picture_in, plane, sized};
use crate::scene_handle::{HeldScene, SceneHandle};
use biprism::analysis::budget;
use biprism::analysis::compare::{JudgeOptions, judge_built, judge_design, named_apart, prisms};
use biprism::analysis::fit_shift::fit_shifts;
use biprism::analysis::judge;
use biprism::analysis::listed_corners::lattices;
use biprism::analysis::photograph::photograph;
use biprism::analysis::rectify::{Rectifier, SourceMap, Sources};
use biprism::analysis::view::{DetectedLattice, detect, place};
use biprism::cli::batch;
use biprism::progress::Observer;
use biprism::report::export::optiland::OptilandPrism;
use biprism::report::json::{Design, Report, SchemaName, to_text};
use biprism::report::rectify::{RectifiedScene, stereo_text};
use biprism::report::{self, comparison, design as design_report};
use biprism::scene::Scene;
use biprism::system::Side;
use biprism::{Error, System};
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeMap;
use std::sync::Arc;

impl HeldScene {
    /// Refuses a board that is no checkerboard.
    pub(crate) fn has_checkerboard(&self) -> Result<(), Error> {
        has_checkerboard(&self.scene)
    }
}

fn has_checkerboard(scene: &Scene) -> Result<(), Error> {
    let Some(texture) = &scene.texture else { return Ok(()) };
    let rule = format!("`board.texture` is {}, and corners are looked for on a checkerboard", texture.words());
    Err(Error::new(format!("scene {}", scene.name), rule, "take `texture` out of `[board]`").of_key("board.texture"))
}

/// The report of a picture, or of corners, of a scene.
#[pyfunction]
pub(crate) fn measure(
    py: Python<'_>,
    scene: &SceneHandle,
    picture: Option<PyReadonlyArray2<'_, f32>>,
    corners: Option<GivenCorners<'_>>,
    own: bool,
    with_budget: bool,
) -> PyResult<String> {
    let held = scene.held();
    let picture = picture.map(|picture| picture_in(&picture));
    let views = corners.map_or(Ok(Vec::new()), |corners| views_of(&corners))?;
    long_call(py, move |stopper| {
        held.has_checkerboard()?;
        prisms(&held.scene)?;
        picture.as_ref().map_or(Ok(()), |picture| sized(picture, &held.scene))?;
        let system = held.system()?;
        let lattices = match &picture {
            Some(picture) => detect(&system, picture, stopper),
            None => lattices(&"the corners", &system, &views)?,
        };
        let entry = measured((&held.scene, &system), &lattices, own, with_budget, stopper)?;
        let report = Report { schema: SchemaName::V1, scene: held.scene.name.clone(), designs: vec![entry] };
        Ok(to_text(&report))
    })
}

/// What the report says of one picture's corners.
fn measured(
    (scene, system): (&Scene, &System),
    lattices: &[DetectedLattice; 2],
    own: bool,
    with_budget: bool,
    stopper: &Stopper,
) -> Result<Design, Error> {
    let (judgement, pose) = if own {
        let view = place(system, lattices, true, stopper);
        stopper.stage("measure");
        (judge::measure(scene, system, view, &[]), None)
    } else {
        photograph(scene, system, lattices, stopper).judged()
    };
    let pitch_mm = scene.camera.pitch_mm;
    let entry = design_report::entry(scene.prism.kind(), &judgement, &BTreeMap::new(), BTreeMap::new(), pitch_mm);
    let mut entry = match own {
        true => design_report::of_own_picture(entry, scene, system),
        false => design_report::of_photograph(entry, pose.as_ref()),
    };
    if with_budget {
        stopper.stage("budget");
        entry.error_budget = Some(report::budget::entry(&budget::budget(scene, system, &judgement.view, stopper)?));
    }
    entry.surface_fits = fit_shifts(scene, system).map(|fits| report::fit::entry(&fits));
    Ok(entry)
}

/// The report of the prisms of one scene, or of the prism of each of several.
#[pyfunction]
pub(crate) fn compare(py: Python<'_>, scenes: Vec<PyRef<'_, SceneHandle>>, with_budget: bool) -> PyResult<String> {
    let held: Vec<Arc<HeldScene>> = scenes.iter().map(|scene| scene.held()).collect();
    let options = JudgeOptions { budget: with_budget };
    long_call(py, move |stopper| {
        held.iter().try_for_each(|held| held.has_checkerboard())?;
        let mut designs = Vec::new();
        if let [held] = &held[..] {
            for (name, scene) in prisms(&held.scene)? {
                let system = held.built(&scene)?;
                let judged = judge_built(&name, scene, system, options, stopper)?;
                designs.push(comparison::entry(&judged, BTreeMap::new()));
            }
        } else {
            let scenes: Vec<Scene> = held.iter().map(|held| held.scene.clone()).collect();
            let fallbacks = vec!["scene"; scenes.len()];
            for (name, scene) in named_apart(&fallbacks, scenes)? {
                let judged = judge_design(&name, scene, options, stopper)?;
                designs.push(comparison::entry(&judged, BTreeMap::new()));
            }
        }
        let mut names: Vec<&str> = held.iter().map(|held| held.scene.name.as_str()).collect();
        names.dedup();
        Ok(to_text(&Report { schema: SchemaName::V1, scene: names.join(", "), designs }))
    })
}

/// The figures of a verb of `biprism batch`, of one scene.
#[pyfunction]
pub(crate) fn figures(py: Python<'_>, scene: &SceneHandle, verb: String) -> PyResult<String> {
    let held = scene.held();
    long_call(py, move |_| {
        let figures = batch::figures(&verb, held.scene.clone(), held.place(), &held.designs)?;
        Ok(figures.to_string())
    })
}

/// The figures of a design and the text of its `[prism]`, as JSON.
#[pyfunction]
pub(crate) fn design(py: Python<'_>, scene: &SceneHandle, verb: String) -> PyResult<(String, String, String)> {
    let held = scene.held();
    long_call(py, move |_| {
        let (figures, prism) = batch::designed(&verb, held.scene.clone(), held.place())?;
        let values = biprism::scene::sorted_values(&prism, "prism.toml")?;
        Ok((figures.to_string(), prism, values["prism"].to_string()))
    })
}

/// The rectified pair: maps for both halves, the report as JSON, and the pair for OpenCV.
#[pyfunction]
pub(crate) fn rectify<'py>(
    py: Python<'py>,
    scene: &SceneHandle,
    depth_mm: Option<f64>,
    residuals_at_mm: Vec<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let held = scene.held();
    let (maps, report, stereo) = long_call(py, move |stopper| {
        let system = held.system()?;
        let rectifier = Rectifier::new(&system, depth_mm.unwrap_or_else(|| Rectifier::board_depth_mm(&system)))?;
        let sources = Sources::new(&rectifier);
        let maps = [0, 1].map(|k| sources.map(k, stopper));
        let depths = residuals_at_mm.iter().copied().chain([f64::INFINITY]);
        let residuals: Vec<_> = depths.map(|depth_mm| rectifier.residual(depth_mm)).collect();
        let found = RectifiedScene { scene: &held.scene, rectifier: &rectifier, maps: &maps, residuals: &residuals };
        let report = found.json().to_string();
        Ok((maps, report, stereo_text(&rectifier)))
    })?;
    let planes = PyDict::new(py);
    for (half, SourceMap { x, y, .. }) in ["left", "right"].into_iter().zip(maps) {
        planes.set_item(format!("{half}_x"), plane(py, x))?;
        planes.set_item(format!("{half}_y"), plane(py, y))?;
    }
    planes.set_item("report", report)?;
    planes.set_item("stereo", stereo)?;
    Ok(planes)
}

/// Optiland's file of a half (0 left, 1 right), as JSON.
#[pyfunction]
pub(crate) fn optiland(py: Python<'_>, scene: &SceneHandle, side: u8) -> PyResult<String> {
    let held = scene.held();
    let (side, half) = if side == 0 { (Side::Left, "left") } else { (Side::Right, "right") };
    long_call(py, move |_| {
        let system = held.system()?;
        if system.effects().manufacture.is_some() {
            let rule =
                "`[effect.manufacture]` moves and bends the surfaces, and a lens file has them as they are meant to be";
            let help = "take it out: scene.replace({\"effect.manufacture\": None})";
            return Err(Error::new(held.place().display(), rule, help).of_key("effect.manufacture"));
        }
        let name = format!("{}, {half} half", held.scene.name);
        let wavelength_nm = held.scene.prism.body().map_or(biprism::optics::medium::D_NM, |body| body.wavelength_nm);
        let file = OptilandPrism::new(&system)?.json(side, &name, wavelength_nm)?;
        Ok(file.to_string())
    })
}
