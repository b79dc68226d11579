//! Scenes made in code.

use super::effects::rules as effect_rules;
use super::model::*;
use super::ranges::Ranges;
use super::source::{Code, ValueSource};
use super::{design_rules, physics, rules, texture_keys};
use crate::accuracy::Accuracy;
use crate::effect::{Effects, Lens};
use crate::error::Error;
use crate::optics::spectrum::WavelengthBand;

impl Scene {
    /// A scene with the defaults of a scene file: called `scene`, at the standard level, without effects. Whether it can be
    /// is judged by [`Scene::check`].
    pub fn new(camera: CameraSpec, prism: PrismSpec, board: BoardSpec) -> Self {
        Self {
            name: "scene".to_owned(),
            camera,
            prism,
            board,
            texture: None,
            objects: Vec::new(),
            board_pose: BoardPose::Stated,
            accuracy: Accuracy::standard(),
            effects: Effects::default(),
            encoding: Encoding::Srgb,
            analysis: Analysis::about(board.world_from_board.translation_mm.z - camera.position_mm.z),
            expect: Vec::new(),
        }
    }

    /// Applies every rule that [`super::parse`] applies to values: their ranges, what they say of each other, and whether
    /// the instrument can be.
    ///
    /// # Errors
    /// The first fault as an [`Error`] whose place is the scene's name and the key that the value has in a scene file, and
    /// whose number is in the unit of that key.
    pub fn check(&self) -> Result<(), Error> {
        let source = &Code(&self.name);
        self.check_ranges(source)?;

        // Judge what values say of each other.
        rules::name(source, &self.name)?;
        rules::picture_is_not_folded(source, "camera.distortion", &self.camera)?;
        rules::calibrated_pinhole(source, &self.camera, &self.effects)?;
        match &self.prism {
            PrismSpec::Freeform(_, settings) => {
                design_rules::goal(source, settings)?;
                rules::design(source, settings, &self.camera)?;
            }
            PrismSpec::Polynomial(prism) => {
                for (at, patch) in [("prism.front", &prism.front), ("prism.back", &prism.back)] {
                    rules::domain(source, at, &patch.domain)?;
                    for (i, (m, n, _)) in patch.sag.terms().enumerate() {
                        rules::term(source, &format!("{at}.terms[{i}]"), m, n)?;
                    }
                }
            }
            PrismSpec::Mesh(prism) if prism.body.solid.is_some() => return Err(rules::solid_mesh(source)),
            PrismSpec::Revolved(prism) => {
                rules::revolved(source, "prism.front", &prism.front)?;
                rules::revolved(source, "prism.back", &prism.back)?;
            }
            _ => {}
        }
        self.check_effects(source)?;
        effect_rules::fill_fits(source, self)?;
        rules::coded_once(source, self.encoding, &self.effects)?;
        self.expect.iter().enumerate().try_for_each(|(i, claim)| rules::claim(source, i, claim))?;

        // Judge how camera, prism and board stand to each other.
        physics::check(source, self).map(|_| ())
    }

    fn check_ranges(&self, source: &dyn ValueSource) -> Result<(), Error> {
        let ranges = Ranges::new(source, &self.prism);
        ranges.word("name", &self.name)?;
        ranges.optional("accuracy.target_px", self.accuracy.target_px)?;
        ranges.camera(&self.camera)?;
        ranges.prism(&self.prism)?;
        ranges.board("board", &self.board)?;
        ranges.number("board.background", self.board.background)?;
        ranges.length("object", self.objects.len())?;
        let objects = self.objects.iter().enumerate();
        objects.clone().try_for_each(|(k, object)| ranges.board(&format!("object[{k}]"), &object.plate))?;
        let textures = std::iter::once(("board.texture".to_owned(), &self.texture, &self.board))
            .chain(objects.map(|(k, object)| (format!("object[{k}].texture"), &object.texture, &object.plate)));
        for (key, texture, plate) in textures {
            if let Some(texture) = texture {
                ranges.texture(&key, texture)?;
                texture_keys::texels(source, &key, texture, plate)?;
            }
        }
        ranges.effects(&self.effects)?;
        ranges.list("analysis.depths_mm", &self.analysis.depths_mm)?;
        ranges.count("analysis.grid", self.analysis.grid)?;
        ranges.length("expect", self.expect.len())?;
        for (i, claim) in self.expect.iter().enumerate() {
            ranges.word(&format!("expect[{i}].value"), &claim.value)?;
            ranges.optional(&format!("expect[{i}].min"), claim.min)?;
            ranges.optional(&format!("expect[{i}].max"), claim.max)?;
        }
        Ok(())
    }

    fn check_effects(&self, source: &dyn ValueSource) -> Result<(), Error> {
        let effects = &self.effects;
        if effects.fresnel.is_none() {
            let alone = [("effect.coating", effects.coating.is_some()), ("effect.ghosts", effects.ghosts.is_some())];
            if let Some((table, _)) = alone.into_iter().find(|(_, given)| *given) {
                return Err(effect_rules::needs_fresnel(source, table));
            }
        }
        if let Lens::Telecentric(lens) = &effects.lens {
            effect_rules::cone_behind(source, lens)?;
        }
        if let Some(stop) = effects.clipping.and_then(|clipping| clipping.stop) {
            effect_rules::stop_in_front(source, &stop, &self.camera, &self.prism, &self.board)?;
        }
        if let Some(errors) = &effects.manufacture {
            effect_rules::index_stays(source, errors.index, &self.prism)?;
            for (at, error) in [("front", &errors.front), ("back", &errors.back)] {
                if error.figure.is_some() {
                    effect_rules::figure_has_base(source, &format!("effect.manufacture.{at}"), &self.prism)?;
                }
            }
        }
        if let Some(lamp) = &effects.lamp {
            effect_rules::lamp_lights(source, lamp.position_mm, &self.camera, &self.board)?;
        }
        if let Some(dispersion) = &effects.dispersion {
            let (glass, _) = effect_rules::named_glass(source, &self.prism)?;
            let waves = dispersion.waves.iter().map(|wave| wave.wavelength_nm);
            let band = WavelengthBand {
                from_nm: waves.clone().fold(f64::INFINITY, f64::min),
                to_nm: waves.fold(f64::NEG_INFINITY, f64::max),
            };
            effect_rules::glass_is_known(source, "effect.dispersion.lines_nm", band, glass)?;
        }
        if let Some(diffraction) = &effects.diffraction {
            effect_rules::pattern_is_kept(source, diffraction)?;
        }
        if let Some(adc) = effects.sensor.and_then(|sensor| sensor.adc) {
            effect_rules::black_below_white(source, &adc)?;
        }
        effect_rules::sets_tell_noise(source, &effects.quadrature)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::Ghosts;
    use crate::geom::Pose;
    use crate::scene;
    use glam::{DMat3, DVec3};
    use std::path::Path;

    fn camera() -> CameraSpec {
        CameraSpec {
            position_mm: DVec3::ZERO,
            focal_length_mm: 35.0,
            width_px: 192,
            height_px: 108,
            pitch_mm: 0.055,
            calibration: CalibrationSpec::default(),
        }
    }

    fn flat() -> PrismSpec {
        let body = GlassSpec::new(1.48, 1.0);
        PrismSpec::Flat(BiprismSpec { body, ridge_distance_mm: 78.472, thickness_mm: 8.545, facet_angle_rad: None })
    }

    fn board(z_mm: f64) -> BoardSpec {
        BoardSpec {
            columns: 9,
            rows: 9,
            square_mm: 20.0,
            margin_mm: 20.0,
            world_from_board: Pose::new(DVec3::new(0.0, 0.0, z_mm), DVec3::ZERO),
            black: 0.05,
            white: 0.85,
            background: 0.3,
        }
    }

    const TEXT: &str = "name = \"scene\"\n[camera]\nfocal_length_mm = 35\nwidth_px = 192\nheight_px = 108\n\
        pixel_pitch_um = 55\n[prism]\nkind = \"flat\"\nindex = 1.48\nridge_distance_mm = 78.472\nthickness_mm = 8.545\n\
        [board]\ncolumns = 9\nrows = 9\nsquare_mm = 20\nposition_mm = [0, 0, 1000]\n";

    #[test]
    fn a_scene_in_code_has_the_defaults_of_a_file() {
        assert_eq!(Scene::new(camera(), flat(), board(1000.0)), scene::parse(TEXT, "test", None).unwrap());
    }

    /// All that the front door lets in passes, whatever its effects.
    #[test]
    fn every_shipped_scene_passes() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
        let mut count = 0;
        for folder in [root.clone(), root.join("cases")] {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.extension().is_some_and(|ending| ending == "toml") {
                    scene::load(&path).unwrap().check().unwrap_or_else(|error| panic!("{}: {error}", path.display()));
                    count += 1;
                }
            }
        }
        assert!(count > 20, "only {count} scenes");
    }

    fn refused(change: impl FnOnce(&mut Scene)) -> (String, String) {
        let mut scene = Scene::new(camera(), flat(), board(1000.0));
        change(&mut scene);
        let error = scene.check().expect_err("the scene cannot be");
        assert!(!error.help.is_empty());
        (error.place, error.rule)
    }

    /// Place and rule of a value that is out of range, of two that do not go together, and of an instrument that cannot be.
    #[test]
    fn faults_name_the_scene_the_key_and_the_rule() {
        let said = refused(|scene| scene.board.square_mm = -1.0);
        let words = ["scene: board.square_mm", "`board.square_mm` is -1, and must be at least 1e-9 and at most 1e12"];
        assert_eq!([said.0.as_str(), said.1.as_str()], words);
        let said = refused(|scene| scene.camera.pitch_mm = f64::NAN);
        assert!(said.0 == "scene: camera.pixel_pitch_um" && said.1.contains("a finite number"), "{said:?}");
        let said = refused(|scene| scene.name = "Paper".to_owned());
        assert_eq!(said, ("Paper: name".to_owned(), "`name` is \"Paper\", and 'P' may not stand there".to_owned()));
        let ghosts = Ghosts { bounces: 4, least_power: 1e-6, behind: 0.0, samples: 2 };
        assert_eq!(refused(|scene| scene.effects.ghosts = Some(ghosts)).0, "scene: effect.ghosts");
        assert_eq!(refused(|scene| scene.board = board(80.0)).0, "scene: board.position_mm");
        assert_eq!(refused(|scene| scene.analysis.depths_mm.clear()).0, "scene: analysis.depths_mm");
        let mirror = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
        assert_eq!(refused(|scene| scene.board.world_from_board.rotation = mirror).0, "scene: board.tilt_deg");
        let deep = |scene: &mut Scene| scene.prism = PrismSpec::Flat(BiprismSpec { thickness_mm: 0.1, ..biprism() });
        assert_eq!(refused(deep).0, "scene: prism.thickness_mm");
    }

    fn biprism() -> BiprismSpec {
        let PrismSpec::Flat(biprism) = flat() else { unreachable!("it is flat") };
        biprism
    }
}
