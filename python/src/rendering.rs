//! Pictures of a scene, and what is true of their pixels.

use crate::long_call::long_call;
use crate::picture_in::plane;
use crate::scene_handle::{SceneHandle, accuracy};
use biprism::analysis::stereo_truth::StereoTruth;
use biprism::glam::DVec2;
use biprism::progress::Observer;
use biprism::raster::Raster;
use biprism::render::{Class, Outputs, render_wanted};
use biprism::report::design;
use numpy::PyArray3;
use numpy::ndarray::Array3;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use serde_json::json;

/// An array of a picture of several values a pixel.
fn layers<'py, T: numpy::Element + Copy, const N: usize>(
    py: Python<'py>,
    raster: Raster<[T; N]>,
) -> Bound<'py, PyArray3<T>> {
    let shape = (raster.height(), raster.width(), N);
    let values = raster.into_data().into_flattened();
    PyArray3::from_owned_array(py, Array3::from_shape_vec(shape, values).expect("as many values as pixels"))
}

/// The picture of a scene: `radiance`, with `class`, `board_mm` and `object` where the truth is wanted, `colour` and `noise` where there
/// are some, and `account` as JSON.
#[pyfunction]
pub(crate) fn render<'py>(
    py: Python<'py>,
    scene: &SceneHandle,
    level: Option<&str>,
    target_px: Option<f64>,
    with_truth: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let (held, accuracy) = (scene.held(), accuracy(level, target_px)?);
    let film = long_call(py, move |stopper| {
        let system = held.system_at(accuracy)?;
        Ok(render_wanted(&system, Outputs { truth: with_truth }, stopper))
    })?;
    let accuracy = design::accuracy(&film.account, &film.counts);
    let account = json!({ "accuracy": accuracy, "counts": film.counts, "unmet": accuracy.unmet() });
    let planes = PyDict::new(py);
    planes.set_item("radiance", plane(py, film.radiance))?;
    planes.set_item("account", account.to_string())?;
    if let (Some(class), Some(board_mm)) = (film.class, film.board_mm) {
        // As in the EXR: NaN where no side sees the board.
        let seen = board_mm.data().iter().zip(class.data());
        let seen = seen.map(|(mm, class)| if class.side().is_some() { *mm } else { [f32::NAN; 2] }).collect();
        planes.set_item("board_f32", layers(py, Raster::from_data(class.width(), class.height(), seen)))?;
        planes.set_item("side", plane(py, class.map(|class| class as u8)))?;
    }
    if let Some(object) = film.object {
        planes.set_item("object", plane(py, object))?;
    }
    if let Some(colour) = film.colour {
        planes.set_item("colour", layers(py, colour))?;
    }
    if let Some(noise) = film.noise {
        planes.set_item("noise", plane(py, noise))?;
    }
    Ok(planes)
}

/// What the centre of every pixel sees on the board, in mm, each traced at f64; NaN where no side sees it.
#[pyfunction]
pub(crate) fn truth<'py>(
    py: Python<'py>,
    scene: &SceneHandle,
    level: Option<&str>,
    target_px: Option<f64>,
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let (held, accuracy) = (scene.held(), accuracy(level, target_px)?);
    let board_mm = long_call(py, move |stopper| {
        let system = held.system_at(accuracy)?;
        let truth = StereoTruth::new(&system);
        let [width, height] = [held.scene.camera.width_px, held.scene.camera.height_px];
        let seen = |i: usize, j: usize| {
            let seen = truth.seen(DVec2::new(i as f64 + 0.5, j as f64 + 0.5));
            match seen {
                Ok((_, hit)) if Class::from(hit.side).side().is_some() => hit.board_mm.to_array(),
                _ => [f64::NAN; 2],
            }
        };
        let row = |j: usize| {
            stopper.pixels(width);
            (0..width).map(|i| seen(i, j)).collect::<Vec<_>>()
        };
        let rows: Vec<Vec<[f64; 2]>> = (0..height).into_par_iter().map(row).collect();
        Ok(Raster::from_data(width, height, rows.concat()))
    })?;
    Ok(layers(py, board_mm))
}
