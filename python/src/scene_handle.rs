//! A scene that Python holds: its text, its values, and the instrument once it was asked for.

use crate::failure::failure;
use crate::long_call::aside;
use biprism::accuracy::{Accuracy, Level};
use biprism::scene::{self, Override};
use biprism::system::in_light::in_light_of;
use biprism::system::{DesignStore, build_from};
use biprism::{Error, Scene, System};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

/// A scene that never changes.
#[pyclass(frozen, module = "biprism._core")]
pub(crate) struct SceneHandle(Arc<HeldScene>);

/// What is held of a scene.
pub(crate) struct HeldScene {
    text: String,
    place: String,
    folder: Option<PathBuf>,
    pub(crate) scene: Scene,
    /// Shared by scenes that were made of each other.
    pub(crate) designs: Arc<DesignStore>,
    system: OnceLock<Arc<System>>,
}

impl HeldScene {
    fn new(text: String, place: String, folder: Option<PathBuf>, scene: Scene) -> Self {
        Self { text, place, folder, scene, designs: Arc::default(), system: OnceLock::new() }
    }

    /// What it is called in messages.
    pub(crate) fn place(&self) -> &Path {
        Path::new(&self.place)
    }

    /// The instrument, which is built once.
    ///
    /// # Errors
    /// When it cannot be designed or built.
    pub(crate) fn system(&self) -> Result<Arc<System>, Error> {
        match self.system.get() {
            Some(system) => Ok(Arc::clone(system)),
            None => self.built(&self.scene).map(|system| Arc::clone(self.system.get_or_init(|| Arc::new(system)))),
        }
    }

    /// The instrument at this accuracy, or at that of the scene.
    pub(crate) fn system_at(&self, accuracy: Option<Accuracy>) -> Result<Arc<System>, Error> {
        match accuracy {
            None => self.system(),
            Some(accuracy) => self.built(&Scene { accuracy, ..self.scene.clone() }).map(Arc::new),
        }
    }

    /// The instrument in light of one wavelength, or in that of its scene.
    pub(crate) fn system_in(&self, wavelength_nm: Option<f64>) -> Result<Arc<System>, Error> {
        let own = self.system()?;
        wavelength_nm.map_or(Ok(Arc::clone(&own)), |nm| in_light_of(&own, &self.scene, nm).map(Arc::new))
    }

    /// The instrument of `scene`, which is this one or differs in what no design depends on.
    pub(crate) fn built(&self, scene: &Scene) -> Result<System, Error> {
        build_from(scene, &self.designs)
            .map_err(|problem| Error { place: format!("{}: {}", self.place, problem.place), ..problem })
    }
}

/// The accuracy of this level, or for this target.
pub(crate) fn accuracy(level: Option<&str>, target_px: Option<f64>) -> PyResult<Option<Accuracy>> {
    match (level, target_px) {
        (None, target_px) => Ok(target_px.map(Accuracy::for_target)),
        (Some(name), _) => match Level::ALL.into_iter().find(|level| level.name() == name) {
            Some(level) => Ok(Some(level.accuracy())),
            None => Err(PyValueError::new_err(format!("no accuracy is called {name:?}"))),
        },
    }
}

#[pymethods]
impl SceneHandle {
    /// The scene of a text; `place` names it in messages, `folder` is where the files that it names are.
    #[staticmethod]
    fn of_text(py: Python<'_>, text: String, place: String, folder: Option<PathBuf>) -> PyResult<Self> {
        aside(py, move |_| {
            let scene = scene::parse(&text, &place, folder.as_deref())?;
            Ok(Self(Arc::new(HeldScene::new(text, place, folder, scene))))
        })
    }

    /// The scene of values, given as JSON.
    #[staticmethod]
    fn of_values(py: Python<'_>, json: &str, place: String, folder: Option<PathBuf>) -> PyResult<Self> {
        let values = table(json)?;
        aside(py, move |_| {
            let scene = scene::from_values(&values, &place, folder.as_deref())?;
            let text = scene::replaced("", &place, &values)?;
            Ok(Self(Arc::new(HeldScene::new(text, place, folder, scene))))
        })
    }

    /// The same with other values, given as JSON by their keys.
    fn with_values(&self, py: Python<'_>, json: &str) -> PyResult<Self> {
        let (values, own) = (table(json)?, Arc::clone(&self.0));
        aside(py, move |_| {
            let HeldScene { text, place, folder, .. } = &*own;
            let refused = |rule| Error::new(place, rule, "give keys as in prism.index or board.position_mm[2]");
            let values = values.into_iter().map(|(key, value)| Override::of_value(&key, value));
            let values = values.collect::<Result<Vec<_>, _>>().map_err(refused)?;
            let scene = scene::parse_with(text, place, folder.as_deref(), &values)?;
            let text = scene::text_with(text, place, &values)?;
            let made = HeldScene::new(text, place.clone(), folder.clone(), scene);
            let designs = Arc::clone(&own.designs);
            Ok(Self(Arc::new(HeldScene { designs, ..made })))
        })
    }

    /// Whether both have the same values.
    fn equals(&self, other: &Self) -> bool {
        self.0.scene == other.0.scene
    }

    #[getter]
    fn text(&self) -> &str {
        &self.0.text
    }

    #[getter]
    fn place(&self) -> &str {
        &self.0.place
    }

    #[getter]
    fn folder(&self) -> Option<String> {
        self.0.folder.as_ref().map(|folder| folder.display().to_string())
    }

    #[getter]
    fn name(&self) -> &str {
        &self.0.scene.name
    }

    #[getter]
    fn prism(&self) -> &'static str {
        self.0.scene.prism.kind()
    }

    #[getter]
    fn size_px(&self) -> (usize, usize) {
        (self.0.scene.camera.width_px, self.0.scene.camera.height_px)
    }

    /// The values that the text states, as JSON.
    fn values_json(&self, py: Python<'_>) -> PyResult<String> {
        let values = scene::sorted_values(&self.0.text, &self.0.place).map_err(|error| failure(py, &error))?;
        Ok(values.to_string())
    }
}

impl SceneHandle {
    /// What is held, for another thread.
    pub(crate) fn held(&self) -> Arc<HeldScene> {
        Arc::clone(&self.0)
    }
}

/// A table of JSON.
fn table(json: &str) -> PyResult<Map<String, Value>> {
    serde_json::from_str(json).map_err(|error| PyValueError::new_err(format!("no table of values: {error}")))
}

/// The text of the scene file at `path`.
#[pyfunction]
pub(crate) fn file_text(py: Python<'_>, path: PathBuf) -> PyResult<String> {
    scene::text(&path).map_err(|error| failure(py, &error))
}
