//! The ranges of the values of a scene that was made in code, by the schema of the file and in its units.

use super::law::PrismLaw;
use super::limits::FOCAL_RATIO;
use super::model::*;
use super::schema::SCHEMA;
use super::source::ValueSource;
use super::structure::{change, item_schema, of_wrong_length, out_of_range, tag, too_short_or_long};
use super::texture_spec::TextureSpec;
use crate::error::Error;
use crate::geom::Pose;
use crate::raster::Raster;
use crate::surface::mesh::Triangles;
use crate::surface::shape::{PolynomialPatch, RevolvedPatch};
use crate::texture::MOST_TEXELS;
use glam::{DMat3, DVec2, DVec3};
use serde_json::Value;

/// Relative rounding of a value that was converted from the unit of the file and is converted back.
const ROUNDING: f64 = 4.0 * f64::EPSILON;
/// Rounding of the axes of a rotation that is a product of a few others.
const AXES: f64 = 1e-9;

/// Judges values by the schema.
pub(super) struct Ranges<'a> {
    source: &'a dyn ValueSource,
    /// What the scene's prism is called.
    kind: &'static str,
}

impl<'a> Ranges<'a> {
    pub(super) fn new(source: &'a dyn ValueSource, prism: &PrismSpec) -> Self {
        let kind = match prism {
            PrismSpec::None => "none",
            PrismSpec::Flat(_) => "flat",
            PrismSpec::Freeform(..) => "freeform",
            PrismSpec::Polynomial(_) => "polynomial",
            PrismSpec::Revolved(_) => "revolved",
            PrismSpec::PointCloud(_) => "point_cloud",
            PrismSpec::Mesh(_) => "mesh",
        };
        Self { source, kind }
    }

    /// What the schema says of `key`: of alternatives the prism's own, or the table.
    fn schema(&self, key: &str) -> &'static Value {
        let mut schema: &Value = &SCHEMA;
        for step in key.split('.') {
            let (name, indices) = step.split_once('[').unwrap_or((step, ""));
            if let Some(all) = schema["oneOf"].as_array() {
                let own = |one: &&Value| match tag(one) {
                    Some((_, kind)) => kind == self.kind,
                    None => one["type"] == "object",
                };
                schema = all.iter().find(own).unwrap_or(&Value::Null);
            }
            schema = &schema["properties"][name];
            for index in indices.split(['[', ']']).filter_map(|digits| digits.parse().ok()) {
                schema = item_schema(schema, index);
            }
        }
        schema
    }

    /// The help for the value at `key`; an item of a list has no words of its own, and the list's serve.
    fn help(&self, key: &str) -> String {
        let whole = key.trim_end_matches(|c: char| c == '[' || c == ']' || c.is_ascii_digit());
        let own = self.schema(key);
        if own.get("description").is_some() { change(key, own) } else { change(whole, self.schema(whole)) }
    }

    /// The error that the value at `key` breaks `rule`.
    pub(super) fn refuse(&self, key: &str, rule: String, help: &str) -> Error {
        self.source.refuse(key, rule, help)
    }

    /// A number in the unit of the file.
    pub(super) fn number(&self, key: &str, value: f64) -> Result<(), Error> {
        match out_of_range(value, self.schema(key)) {
            None => Ok(()),
            Some(wanted) => {
                let rule = format!("`{key}` is {value}, and must be {wanted}");
                Err(self.source.refuse(key, rule, &self.help(key)))
            }
        }
    }

    /// A number that was converted to the unit of the file: it may be a rounding beyond a bound.
    pub(super) fn converted(&self, key: &str, value: f64) -> Result<(), Error> {
        let near = [value * (1.0 - ROUNDING), value * (1.0 + ROUNDING)];
        if near.into_iter().any(|value| out_of_range(value, self.schema(key)).is_none()) {
            return Ok(());
        }
        self.number(key, value)
    }

    /// A number that may be left out.
    pub(super) fn optional(&self, key: &str, value: Option<f64>) -> Result<(), Error> {
        value.map_or(Ok(()), |value| self.number(key, value))
    }

    /// A whole number.
    pub(super) fn count(&self, key: &str, value: usize) -> Result<(), Error> {
        self.number(key, value as f64)
    }

    /// Each number of a list, and how many there are.
    pub(super) fn list(&self, key: &str, values: &[f64]) -> Result<(), Error> {
        self.length(key, values.len())?;
        values.iter().enumerate().try_for_each(|(i, value)| self.number(&format!("{key}[{i}]"), *value))
    }

    /// How many items a list has.
    pub(super) fn length(&self, key: &str, count: usize) -> Result<(), Error> {
        match of_wrong_length(count, self.schema(key)) {
            None => Ok(()),
            Some(wanted) => {
                let rule = format!("`{key}` has {count} values, and must have {wanted}");
                Err(self.source.refuse(key, rule, &self.help(key)))
            }
        }
    }

    /// How long a word is.
    pub(super) fn word(&self, key: &str, word: &str) -> Result<(), Error> {
        match too_short_or_long(word, self.schema(key)) {
            None => Ok(()),
            Some(found) => Err(self.source.refuse(key, format!("`{key}` has {found}"), &self.help(key))),
        }
    }

    /// A vector in mm.
    pub(super) fn vector(&self, key: &str, vector: DVec3) -> Result<(), Error> {
        self.list(key, &vector.to_array())
    }

    /// Angles about three axes, in rad.
    pub(super) fn tilt(&self, key: &str, tilt_rad: DVec3) -> Result<(), Error> {
        let mut degrees = tilt_rad.to_array().map(f64::to_degrees).into_iter().enumerate();
        degrees.try_for_each(|(i, value)| self.converted(&format!("{key}[{i}]"), value))
    }

    /// The place of a thing of the table `table`, and a rotation that is one.
    fn pose(&self, table: &str, pose: &Pose) -> Result<(), Error> {
        self.vector(&format!("{table}.position_mm"), pose.translation_mm)?;
        self.rotation(&format!("{table}.tilt_deg"), &pose.rotation)
    }

    /// A rotation that is one, which the angles at `key` make.
    fn rotation(&self, key: &str, rotation: &DMat3) -> Result<(), Error> {
        let gram = rotation.transpose() * *rotation;
        if gram.abs_diff_eq(DMat3::IDENTITY, AXES) && rotation.determinant() > 0.0 {
            return Ok(());
        }
        let rule = format!("`{key}` makes a matrix that is no rotation: its axes are {rotation}");
        Err(self.source.refuse(key, rule, "make the pose by `Pose::new`, from a position and angles"))
    }

    pub(super) fn camera(&self, camera: &CameraSpec) -> Result<(), Error> {
        self.number("camera.focal_length_mm", camera.focal_length_mm)?;
        self.count("camera.width_px", camera.width_px)?;
        self.count("camera.height_px", camera.height_px)?;
        self.converted("camera.pixel_pitch_um", camera.pitch_mm * 1000.0)?;
        self.vector("camera.position_mm", camera.position_mm)?;
        let CalibrationSpec { principal_px, rotation, distortion, focal_ratio } = camera.calibration;
        if let Some(principal_px) = principal_px {
            self.list("camera.principal_point_px", &principal_px.to_array())?;
        }
        self.rotation("camera.rotation_deg", &rotation)?;
        self.list("camera.distortion", &distortion.coefficients())?;
        if (1.0 / FOCAL_RATIO..=FOCAL_RATIO).contains(&focal_ratio) {
            return Ok(());
        }
        let rule = format!(
            "the ratio fy / fx of `camera.calibration` is {focal_ratio}, and must be at least {} and at most {FOCAL_RATIO}",
            1.0 / FOCAL_RATIO
        );
        Err(self.source.refuse("camera.calibration", rule, "give 1 for square pixels"))
    }

    /// The board or the object of the table `key`.
    pub(super) fn board(&self, key: &str, board: &BoardSpec) -> Result<(), Error> {
        self.count(&format!("{key}.columns"), board.columns)?;
        self.count(&format!("{key}.rows"), board.rows)?;
        self.number(&format!("{key}.square_mm"), board.square_mm)?;
        self.number(&format!("{key}.margin_mm"), board.margin_mm)?;
        self.pose(key, &board.world_from_board)?;
        self.number(&format!("{key}.black"), board.black)?;
        self.number(&format!("{key}.white"), board.white)
    }

    /// The texture that stands at `key`.
    pub(super) fn texture(&self, key: &str, texture: &TextureSpec) -> Result<(), Error> {
        match texture {
            TextureSpec::Chart => Ok(()),
            TextureSpec::Noise { finest_mm, .. } => self.number(&format!("{key}.finest_mm"), *finest_mm),
            TextureSpec::Image(image) => {
                self.word(&format!("{key}.image"), &image.file)?;
                self.number(&format!("{key}.width_mm"), image.width_mm)?;
                self.light(&format!("{key}.image"), &image.light)
            }
        }
    }

    /// The light of a picture: not below 0, and not more than a texture may have.
    fn light(&self, key: &str, light: &Raster<f32>) -> Result<(), Error> {
        let (rule, help) = if light.data().is_empty() || light.data().len() > MOST_TEXELS {
            (format!("has {} pixels, and must have 1 to {MOST_TEXELS}", light.data().len()), "take fewer pixels")
        } else if let Some(value) = light.data().iter().find(|v| !(**v >= 0.0 && v.is_finite())) {
            (format!("has a pixel of {value}, and light is finite and not below 0"), "correct the picture")
        } else {
            return Ok(());
        };
        Err(self.source.refuse(key, format!("`{key}` {rule}"), help))
    }

    pub(super) fn prism(&self, prism: &PrismSpec) -> Result<(), Error> {
        if let Some(body) = prism.body() {
            self.number("prism.index", body.index)?;
            self.number("prism.outer_index", body.outer_index)?;
            self.number("prism.wavelength_nm", body.wavelength_nm)?;
            self.pose("prism", &body.world_from_prism)?;
            if let Some(law) = &body.law {
                self.list("prism.law.f_mm", &law.focal_mm)?;
            }
            let mut law = body.law.iter().flat_map(PrismLaw::keys);
            law.try_for_each(|(key, value)| self.converted(&format!("prism.law.{key}"), value))?;
        }
        match prism {
            PrismSpec::None => Ok(()),
            PrismSpec::Flat(flat) => self.biprism(flat),
            PrismSpec::Freeform(flat, settings) => {
                self.biprism(flat)?;
                self.count("prism.design.degree", settings.degree)?;
                self.optional("prism.design.virtual_camera_z_mm", settings.virtual_camera_z_mm)?;
                self.number("prism.design.step_px", settings.step_px)?;
                self.optional("prism.design.aperture", settings.goal.f_number)?;
                self.number("prism.design.spot_weight", settings.goal.spot_weight)?;
                self.number("prism.design.z_min_mm", settings.goal.z_min_mm)?;
                self.number("prism.design.depth_mm", settings.goal.depth_mm)
            }
            PrismSpec::Polynomial(prism) => {
                self.patch("prism.front", &prism.front)?;
                self.patch("prism.back", &prism.back)
            }
            PrismSpec::Revolved(prism) => {
                self.revolved("prism.front", &prism.front)?;
                self.revolved("prism.back", &prism.back)
            }
            PrismSpec::PointCloud(prism) => {
                for (at, cloud) in [("prism.front", &prism.front), ("prism.back", &prism.back)] {
                    self.count(&format!("{at}.degree"), cloud.degree)?;
                    self.finite(&format!("{at}.file"), &cloud.points_mm)?;
                }
                Ok(())
            }
            PrismSpec::Mesh(prism) => {
                self.mesh("prism.front", &prism.front)?;
                self.mesh("prism.back", &prism.back)
            }
        }
    }

    fn biprism(&self, prism: &BiprismSpec) -> Result<(), Error> {
        self.number("prism.ridge_distance_mm", prism.ridge_distance_mm)?;
        self.number("prism.thickness_mm", prism.thickness_mm)?;
        match prism.facet_angle_rad {
            None => Ok(()),
            Some(angle) => self.converted("prism.facet_angle_deg", angle.to_degrees()),
        }
    }

    fn patch(&self, at: &str, patch: &PolynomialPatch) -> Result<(), Error> {
        self.list(&format!("{at}.centre_mm"), &patch.sag.centre())?;
        self.list(&format!("{at}.scale_mm"), &patch.sag.scale())?;
        let [lower, upper]: [DVec2; 2] = [patch.domain.min, patch.domain.max];
        for (i, bounds) in [[lower.x, upper.x], [lower.y, upper.y]].iter().enumerate() {
            self.list(&format!("{at}.domain_mm[{i}]"), bounds)?;
        }
        let mut terms = patch.sag.terms().enumerate();
        terms.try_for_each(|(i, (_, _, c))| self.number(&format!("{at}.terms[{i}][2]"), c))
    }

    fn revolved(&self, at: &str, patch: &RevolvedPatch) -> Result<(), Error> {
        self.vector(&format!("{at}.origin_mm"), patch.point_mm)?;
        self.vector(&format!("{at}.axis"), patch.axis)?;
        self.list(&format!("{at}.along_mm"), &patch.profile.ends())?;
        self.converted(&format!("{at}.azimuth_deg"), patch.azimuth_rad.to_degrees())?;
        self.list(&format!("{at}.profile_mm"), patch.profile.coefficients())
    }

    fn finite(&self, key: &str, points_mm: &[DVec3]) -> Result<(), Error> {
        match points_mm.iter().enumerate().find(|(_, point)| !point.is_finite()) {
            None => Ok(()),
            Some((i, point)) => {
                let rule = format!("`{key}`: point {i} is {point}, and must be finite");
                Err(self.source.refuse(key, rule, "remove or correct the point"))
            }
        }
    }

    fn mesh(&self, key: &str, mesh: &Triangles) -> Result<(), Error> {
        self.finite(key, &mesh.points_mm)?;
        self.finite(key, &mesh.point_normals)?;
        let count = mesh.points_mm.len();
        let (rule, help) = if mesh.point_normals.len() != count {
            (format!("has {} normals for {count} corners", mesh.point_normals.len()), "give every corner its normal")
        } else if let Some(i) = mesh.triangles.iter().position(|t| t.iter().any(|corner| *corner as usize >= count)) {
            (format!("has a triangle, number {i}, with a corner that is not there"), "number the corners from 0")
        } else {
            return Ok(());
        };
        Err(self.source.refuse(key, format!("`{key}` {rule}"), help))
    }
}
