//! The scene parser: a scene file in, a [`Scene`] out, with every default filled and every unit converted.
//!
//! ```text
//! file --document::read--> text --document--> keys and values with their places --structure (by the schema)-->
//!   SceneFile, as written --check (units, defaults, pairs of values)--> Scene --physics (feasibility)--> Scene
//! ```
//!
//! Each arrow stops at the first fault, with a [`Error`] that points at the line.

mod document;
mod effects;
mod limits;
mod law;
mod body_keys;
mod prism_tables;
mod schema;
mod structure;
mod suggest;
mod sweep;
mod source;
mod rules;
mod ranges;
mod in_code;
mod tidy;
mod check;
mod physics;
mod design_rules;
mod design_model;
mod model;
mod camera;
mod camera_keys;
mod surface_files;
mod surface_keys;
mod texture_spec;
mod texture_keys;
mod object_keys;
mod given_text;
mod overrides;
mod replaced;

pub use design_model::{DesignGoal, DesignSettings, DesignedSurface, MarchOrder, Method, Objective, Rear};
pub use law::PrismLaw;
pub(crate) use limits::DESIGN_DEGREE;
pub use model::{
    Analysis, BiprismSpec, BoardPose, BoardSpec, CalibrationSpec, CameraSpec, CloudSpec, Encoding, Expect, GlassSpec,
    MeshSpec, ObjectSpec, PointCloudSpec, PolynomialSpec, PrismSpec, RevolvedSpec, Scene,
};

pub use crate::num::curve::ChebyshevCurve;
pub use crate::surface::mesh::{Normals, Triangles};
pub use crate::surface::shape::{PolynomialPatch, RevolvedPatch};
pub use crate::texture::TexelFilter;
pub use overrides::Override;
pub use replaced::{has_no_effects, replaced, sorted_values};
pub use schema::schema_json;
pub use sweep::Sweep;
pub use texture_spec::{ImageSpec, TextureSpec};

use crate::error::Error;
use serde_json::{Map, Value};
use std::io::Read;
use std::path::Path;

/// Read and check the scene file at `path`.
///
/// # Errors
/// The first fault as a [`Error`]: the file cannot be read, is above 4 MiB or not UTF-8, or [`parse`] refuses it.
pub fn load(path: &Path) -> Result<Scene, Error> {
    parse(&text(path)?, &path.display().to_string(), path.parent())
}

/// The text of the scene file at `path`, which [`parse`] takes.
///
/// # Errors
/// The file cannot be read, is above 4 MiB or not UTF-8.
pub fn text(path: &Path) -> Result<String, Error> {
    document::read(path)
}

/// The same of an input that `place` names in messages.
///
/// # Errors
/// As [`text`].
pub fn text_of(input: impl Read, place: &str) -> Result<String, Error> {
    document::text_of(input, place)
}

/// Read and check a scene from `input`; `place` names it in messages, and files that it names are looked for in `folder`.
///
/// # Errors
/// As [`load`].
pub fn read(input: impl Read, place: &str, folder: Option<&Path>) -> Result<Scene, Error> {
    parse(&text_of(input, place)?, place, folder)
}

/// Check the scene `text`. `place` names it in messages; `folder` is where the files that it names are sought
/// (`None`: it may name none).
///
/// # Errors
/// The first fault as a [`Error`] that points at its line: not TOML, an unknown or missing key, a wrong type, a value
/// out of range, or an instrument that cannot be.
pub fn parse(text: &str, place: &str, folder: Option<&Path>) -> Result<Scene, Error> {
    parse_with(text, place, folder, &[])
}

/// [`parse`] with `values` in place of those in the text, one after the other.
///
/// # Errors
/// As [`parse`]; a fault of such a value names it as it was given, and not a line of the text.
pub fn parse_with(text: &str, place: &str, folder: Option<&Path>, values: &[Override]) -> Result<Scene, Error> {
    let given = overrides::given(values, text.len(), place)?;
    checked(&document::Document::parse(text, place)?.with(&given)?, folder)
}

/// A scene from its `values`: tables, lists, numbers and words, by the keys of a scene file.
///
/// # Errors
/// As [`parse`], without a line.
pub fn from_values(values: &Map<String, Value>, place: &str, folder: Option<&Path>) -> Result<Scene, Error> {
    let values = values.iter().map(|(key, value)| Override::of_value(key, value.clone()));
    let values = values
        .collect::<Result<Vec<_>, _>>()
        .map_err(|rule| Error::new(place, rule, "give the tables of a scene: camera, prism, board"))?;
    let given = overrides::given(&values, 0, place)?;
    checked(&document::Document::blank(place).with(&given)?, folder)
}

/// The scene `text` with `values` in place of its own, as a text; its comments are kept where there are none.
///
/// # Errors
/// When the text is not TOML, or there is no place for a value in it; the scene is not checked.
pub fn text_with(text: &str, place: &str, values: &[Override]) -> Result<String, Error> {
    if values.is_empty() {
        return Ok(text.to_owned());
    }
    let given = overrides::given(values, text.len(), place)?;
    document::Document::parse(text, place)?.with(&given)?.to_text()
}

fn checked(document: &document::Document, folder: Option<&Path>) -> Result<Scene, Error> {
    structure::check(document, &schema::SCHEMA)?;
    let file = document.values()?;
    let mut scene = check::scene(document, file, folder)?;
    effects::rules::fill_fits(document, &scene)?;
    scene.analysis.depths_mm = physics::check(document, &scene)?;
    Ok(scene)
}
