//! Pictures that come in: arrays, and files.

use crate::long_call::long_call;
use biprism::Error;
use biprism::raster::Raster;
use biprism::raster::transfer::Transfer;
use numpy::{PyArray2, PyReadonlyArray2, ToPyArray, ndarray::Array2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::path::PathBuf;

/// The picture of an array, whatever its strides are; it is copied.
pub(crate) fn picture_in(array: &PyReadonlyArray2<'_, f32>) -> Raster<f32> {
    let view = array.as_array();
    let (height, width) = view.dim();
    Raster::from_data(width, height, view.iter().copied().collect())
}

/// An array of a picture's values, which are not copied.
pub(crate) fn plane<T: numpy::Element + Copy>(py: Python<'_>, raster: Raster<T>) -> Bound<'_, PyArray2<T>> {
    let shape = (raster.height(), raster.width());
    let array = Array2::from_shape_vec(shape, raster.into_data()).expect("a raster holds width x height values");
    PyArray2::from_owned_array(py, array)
}

/// The curve of that name.
pub(crate) fn transfer(name: &str) -> PyResult<Transfer> {
    match name {
        "linear" => Ok(Transfer::Linear),
        "srgb" => Ok(Transfer::Srgb),
        other => {
            Err(PyValueError::new_err(format!("the transfer curve is {other:?}, and must be \"linear\" or \"srgb\"")))
        }
    }
}

/// The picture in a file, as linear light; `curve` is the transfer curve where the file states none.
#[pyfunction]
pub(crate) fn read<'py>(py: Python<'py>, path: PathBuf, curve: Option<&str>) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let curve = curve.map(transfer).transpose()?;
    let picture = long_call(py, move |_| biprism::io::read(&path, curve).map(|(picture, _)| picture))?;
    Ok(plane(py, picture))
}

/// The linear light of values in [0, 1] that were stored by a curve.
#[pyfunction]
pub(crate) fn light<'py>(
    py: Python<'py>,
    stored: PyReadonlyArray2<'py, f64>,
    curve: &str,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let curve = transfer(curve)?;
    let decoded = stored.as_array().mapv(|value| curve.decode(value) as f32);
    Ok(decoded.to_pyarray(py))
}

/// Refuses a picture that is not of the size of the scene's.
///
/// # Errors
/// As said.
pub(crate) fn sized(picture: &Raster<f32>, scene: &biprism::Scene) -> Result<(), Error> {
    let (size, wanted) = ([picture.width(), picture.height()], [scene.camera.width_px, scene.camera.height_px]);
    if size == wanted {
        return Ok(());
    }
    let rule =
        format!("it has {} x {} pixels, and the scene's camera has {} x {}", size[0], size[1], wanted[0], wanted[1]);
    Err(Error::new("the picture", rule, "take the scene that the picture belongs to"))
}
