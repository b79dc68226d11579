//! Corners of pictures as records, and records as corners.

use crate::long_call::long_call;
use crate::picture_in::{picture_in, sized};
use crate::scene_handle::SceneHandle;
use biprism::analysis::corners_on_board::detected;
use biprism::glam::{DMat2, DVec2};
use biprism::io::corners::{CornerView, ListedCorner, Quality};
use biprism::progress::Observer;
use biprism::vision::half::{Half, HalfImage};
use biprism::vision::{Polarity, Settings, detect, turned_like};
use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use serde_json::{Value, json};
use std::path::PathBuf;

/// Names of the views, by their numbers in records.
const VIEWS: [&str; 3] = ["left", "right", "whole"];

/// Records as bytes, and what else is known of each view, as JSON.
type Found<'py> = (Bound<'py, PyArray1<u8>>, String);

/// The records of all views: view u8, index 2 i32, position 2 f64, covariance 4 f64, contrast and residual f64, polarity u8.
fn found<'py>(py: Python<'py>, views: &[CornerView]) -> PyResult<Found<'py>> {
    let mut bytes = Vec::new();
    for view in views {
        let number = VIEWS.iter().position(|name| *name == view.name).ok_or_else(|| {
            PyValueError::new_err(format!("a view is called {:?}, and must be left, right or whole", view.name))
        })?;
        for corner in &view.corners {
            record(number as u8, corner, &mut bytes);
        }
    }
    let told = |view: &CornerView| {
        let rejected: serde_json::Map<String, Value> =
            view.rejected.iter().map(|(reason, n)| (reason.clone(), json!(n))).collect();
        json!({ "view": view.name, "corners": view.corners.len(), "rejected": rejected, "blur_px": view.blur_px,
            "lean_px": view.lean_px, "marked_squares": view.marked_squares })
    };
    let told: Vec<Value> = views.iter().map(told).collect();
    Ok((PyArray1::from_vec(py, bytes), Value::Array(told).to_string()))
}

/// Appends a record; what is not known of a corner is NaN, its polarity 2.
fn record(view: u8, corner: &ListedCorner, bytes: &mut Vec<u8>) {
    bytes.push(view);
    corner.index.iter().for_each(|k| bytes.extend(k.to_le_bytes()));
    let [covariance, contrast, residual] = match &corner.quality {
        Some(q) => [q.covariance_px2.to_cols_array(), [q.contrast; 4], [q.residual; 4]],
        None => [[f64::NAN; 4]; 3],
    };
    let position = corner.position_px.to_array();
    let numbers = position.iter().chain(&covariance).chain(&contrast[..1]).chain(&residual[..1]);
    numbers.for_each(|value| bytes.extend(value.to_le_bytes()));
    bytes.push(match corner.quality.map(|q| q.polarity) {
        Some(Polarity::Main) => 0,
        Some(Polarity::Anti) => 1,
        None => 2,
    });
}

/// The corners of a picture of linear light: of each half, or of the whole.
#[pyfunction]
pub(crate) fn corners<'py>(py: Python<'py>, picture: PyReadonlyArray2<'py, f32>, whole: bool) -> PyResult<Found<'py>> {
    let picture = picture_in(&picture);
    let views = long_call(py, move |stopper| {
        let settings = Settings::default();
        if whole {
            return Ok(vec![CornerView::new("whole", 0, &detect(&picture, None, &settings))]);
        }
        let [left, right] = Half::BOTH.map(|half| {
            stopper.stage("detect");
            let half = HalfImage::cut(&picture, half);
            (half.first_column, detect(&half.image, None, &settings))
        });
        // Number the second half as the first.
        let turned = turned_like(&left.1, right.1);
        Ok(vec![CornerView::new("left", left.0, &left.1), CornerView::new("right", right.0, &turned)])
    })?;
    found(py, &views)
}

/// The same of a picture of a scene, by the columns and rows of its board.
#[pyfunction]
pub(crate) fn corners_on_board<'py>(
    py: Python<'py>,
    scene: &SceneHandle,
    picture: PyReadonlyArray2<'py, f32>,
) -> PyResult<Found<'py>> {
    let (held, picture) = (scene.held(), picture_in(&picture));
    let views = long_call(py, move |_| {
        sized(&picture, &held.scene)?;
        held.has_checkerboard()?;
        Ok(detected(&*held.system()?, &picture))
    })?;
    found(py, &views)
}

/// The corners of a file.
#[pyfunction]
pub(crate) fn read_corners<'py>(py: Python<'py>, path: PathBuf) -> PyResult<Found<'py>> {
    let views = long_call(py, move |_| biprism::io::corners::read(&path))?;
    found(py, &views)
}

/// Corners that Python gives: view, index, position, covariance and polarity of each, the last two as in [`record`].
#[derive(FromPyObject)]
pub(crate) struct GivenCorners<'py> {
    #[pyo3(item)]
    view: PyReadonlyArray1<'py, u8>,
    #[pyo3(item)]
    index: PyReadonlyArray2<'py, i32>,
    #[pyo3(item)]
    position_px: PyReadonlyArray2<'py, f64>,
    #[pyo3(item)]
    covariance_px2: PyReadonlyArray3<'py, f64>,
    #[pyo3(item)]
    polarity: PyReadonlyArray1<'py, u8>,
}

/// The views of corners that Python gives.
pub(crate) fn views_of(given: &GivenCorners<'_>) -> PyResult<Vec<CornerView>> {
    let (view, index, position) = (given.view.as_array(), given.index.as_array(), given.position_px.as_array());
    let (covariance, polarity) = (given.covariance_px2.as_array(), given.polarity.as_array());
    let n = view.len();
    let shapes = [index.dim() == (n, 2), position.dim() == (n, 2), covariance.dim() == (n, 2, 2), polarity.len() == n];
    if shapes.contains(&false) || view.iter().any(|k| usize::from(*k) >= VIEWS.len()) {
        return Err(PyValueError::new_err("no records of corners"));
    }
    if let Some(amiss) = polarity.iter().find(|polarity| **polarity > 2) {
        let rule = format!("a corner's polarity is {amiss}, and must be 0, 1, or 2 where it is not known");
        return Err(PyValueError::new_err(rule));
    }
    let listed = |k: usize| {
        let covariance_px2 = DMat2::from_cols_array(&[0, 1, 2, 3].map(|at| covariance[[k, at / 2, at % 2]]));
        let polarity = [Polarity::Main, Polarity::Anti].get(usize::from(polarity[k])).copied();
        let known = polarity.filter(|_| !covariance_px2.is_nan());
        let quality = known.map(|polarity| Quality { covariance_px2, contrast: 1.0, residual: 0.0, polarity });
        let position_px = DVec2::new(position[[k, 0]], position[[k, 1]]);
        ListedCorner { index: [index[[k, 0]], index[[k, 1]]], position_px, quality }
    };
    let of = |number: usize| {
        let corners: Vec<ListedCorner> = (0..n).filter(|k| usize::from(view[*k]) == number).map(listed).collect();
        CornerView { index_origin: None, ..CornerView::of_board(VIEWS[number], corners) }
    };
    Ok((0..VIEWS.len()).map(of).filter(|view| !view.corners.is_empty()).collect())
}
