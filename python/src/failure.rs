//! Errors of the crate as `biprism.SceneError`.

use biprism::Error;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;

/// The class, which Python defines.
static SCENE_ERROR: PyOnceLock<Py<PyType>> = PyOnceLock::new();

/// The exception that says what `error` says.
pub(crate) fn failure(py: Python<'_>, error: &Error) -> PyErr {
    let made = SCENE_ERROR.import(py, "biprism._errors", "SceneError").and_then(|class| {
        let fields = (&error.place, error.line(), error.column(), &error.key, &error.rule, &error.help);
        class.call1((fields.0, fields.1, fields.2, fields.3, fields.4, fields.5, error.render(false)))
    });
    made.map_or_else(|problem| problem, PyErr::from_value)
}
