//! The compiled part of the Python package `biprism`: calls into the crate, with arrays and text in and out.
//!
//! `biprism/__init__.py` gives them names, types and docstrings; nobody else calls this module.

mod command;
mod failure;
mod half_corners;
mod long_call;
mod picture_in;
mod records;
mod rendering;
mod scene_handle;
mod studies;

use pyo3::prelude::*;

#[pymodule(gil_used = false)]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("VERSION", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<scene_handle::SceneHandle>()?;
    module.add_function(wrap_pyfunction!(command::command, module)?)?;
    module.add_function(wrap_pyfunction!(scene_handle::file_text, module)?)?;
    module.add_function(wrap_pyfunction!(picture_in::read, module)?)?;
    module.add_function(wrap_pyfunction!(picture_in::light, module)?)?;
    module.add_function(wrap_pyfunction!(half_corners::corners, module)?)?;
    module.add_function(wrap_pyfunction!(half_corners::corners_on_board, module)?)?;
    module.add_function(wrap_pyfunction!(half_corners::read_corners, module)?)?;
    module.add_function(wrap_pyfunction!(records::trace, module)?)?;
    module.add_function(wrap_pyfunction!(records::aim, module)?)?;
    module.add_function(wrap_pyfunction!(rendering::render, module)?)?;
    module.add_function(wrap_pyfunction!(rendering::truth, module)?)?;
    module.add_function(wrap_pyfunction!(studies::measure, module)?)?;
    module.add_function(wrap_pyfunction!(studies::compare, module)?)?;
    module.add_function(wrap_pyfunction!(studies::figures, module)?)?;
    module.add_function(wrap_pyfunction!(studies::design, module)?)?;
    module.add_function(wrap_pyfunction!(studies::rectify, module)?)?;
    module.add_function(wrap_pyfunction!(studies::optiland, module)?)
}
