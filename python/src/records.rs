//! Pixels traced to the board, and board points aimed at, as records.

use crate::long_call::long_call;
use crate::scene_handle::SceneHandle;
use biprism::glam::DVec2;
use biprism::io::npy::NpyField;
use biprism::progress::Observer;
use biprism::report::traced::{AimedPoint, TracedRay};
use biprism::system::aim::Aimer;
use biprism::system::{InLight, Side};
use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;

/// Points between two looks at whether anybody waits.
const AT_ONCE: usize = 1 << 15;
/// Answers that a thread makes at once.
const PIECE: usize = 1 << 10;

/// Name, type and length of each field of a record.
type Described = Vec<(&'static str, &'static str, usize)>;
/// Records as bytes, with their fields.
type Records<'py> = (Bound<'py, PyArray1<u8>>, Described);

fn described(fields: &[NpyField]) -> Described {
    let described = |field: &NpyField| match *field {
        NpyField::F64(name, count) => (name, "<f8", count),
        NpyField::U32(name) => (name, "<u4", 1),
    };
    fields.iter().map(described).collect()
}

/// The bytes of `answer` for every point, in their order.
fn answers<T: Sync>(points: &[T], observer: &dyn Observer, answer: impl Fn(&T, &mut Vec<u8>) + Sync) -> Vec<u8> {
    let mut bytes = Vec::new();
    for some in points.chunks(AT_ONCE) {
        observer.pixels(some.len());
        let piece = |piece: &[T]| {
            let mut bytes = Vec::new();
            piece.iter().for_each(|point| answer(point, &mut bytes));
            bytes
        };
        let pieces: Vec<Vec<u8>> = some.par_chunks(PIECE).map(piece).collect();
        pieces.iter().for_each(|piece| bytes.extend_from_slice(piece));
    }
    bytes
}

/// The rows of an array of two columns.
fn pairs(array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<DVec2>> {
    let view = array.as_array();
    if view.ncols() != 2 {
        return Err(PyValueError::new_err(format!("positions have {} columns, and must have 2", view.ncols())));
    }
    Ok(view.rows().into_iter().map(|row| DVec2::new(row[0], row[1])).collect())
}

/// Where pixel positions lead, in the light of the scene or of one wavelength, as records of [`TracedRay::FIELDS`].
#[pyfunction]
pub(crate) fn trace<'py>(
    py: Python<'py>,
    scene: &SceneHandle,
    px: PyReadonlyArray2<'py, f64>,
    wavelength_nm: Option<f64>,
) -> PyResult<Records<'py>> {
    let (held, px) = (scene.held(), pairs(&px)?);
    let bytes = long_call(py, move |stopper| {
        let system = held.system_in(wavelength_nm)?;
        let light = InLight::new(&system);
        Ok(answers(&px, stopper, |px, bytes| TracedRay::new(&light, *px).record(bytes)))
    })?;
    Ok((PyArray1::from_vec(py, bytes), described(&TracedRay::FIELDS)))
}

/// Which pixel positions see board points, each through its side (0 left, 1 right), as records of [`AimedPoint::FIELDS`].
#[pyfunction]
pub(crate) fn aim<'py>(
    py: Python<'py>,
    scene: &SceneHandle,
    sides: PyReadonlyArray1<'py, u8>,
    board_mm: PyReadonlyArray2<'py, f64>,
    wavelength_nm: Option<f64>,
) -> PyResult<Records<'py>> {
    let (held, points, sides) = (scene.held(), pairs(&board_mm)?, sides.as_array());
    if sides.len() != points.len() || sides.iter().any(|side| *side > 1) {
        return Err(PyValueError::new_err("each point has a side, 0 for left or 1 for right"));
    }
    let side = |side: &u8| if *side == 0 { Side::Left } else { Side::Right };
    let asked: Vec<(Side, DVec2)> = sides.iter().map(side).zip(points).collect();
    let bytes = long_call(py, move |stopper| {
        let system = held.system_in(wavelength_nm)?;
        let aimer = Aimer::new(&system);
        Ok(answers(&asked, stopper, |(side, mm), bytes| AimedPoint::new(&aimer, *side, *mm).record(bytes)))
    })?;
    Ok((PyArray1::from_vec(py, bytes), described(&AimedPoint::FIELDS)))
}
