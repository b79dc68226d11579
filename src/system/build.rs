//! From a scene to its instrument.

use super::auto;
use super::board::Board;
use super::camera::Camera;
use super::instrument::System;
use super::light::require_light;
use crate::effect::Effects;
use crate::error::Error;
use crate::prism::biprism::Prism;
use crate::scene::Scene;
use std::sync::Arc;

/// Builds the instrument, designing the prism first where the scene asks for that, without the effects that the scene says
/// may be left out.
///
/// # Errors
/// When the prism cannot be designed from the scene's values, its surfaces miss their points by more than they may, or no
/// ray of the picture passes it.
pub fn build(scene: &Scene) -> Result<System, Error> {
    let ideal = ideal(scene)?;
    // To bound what every effect changes takes as long as a small picture.
    let verdicts = if scene.effects.auto.is_some() { auto::verdicts(&ideal, scene) } else { Vec::new() };
    let system = ideal.with_effects(&auto::settled(&verdicts, scene), &scene.camera);
    require_light(scene, &system)?;
    Ok(system)
}

/// The instrument of a scene without its effects, large enough for all of them.
///
/// # Errors
/// As [`build`].
pub fn ideal(scene: &Scene) -> Result<System, Error> {
    let prism = Prism::build(&scene.prism, &scene.camera, &scene.effects)?;
    Ok(System {
        camera: Camera::new(&scene.camera, None),
        designed: prism.clone().map(Arc::new),
        prism,
        board: Board::new(&scene.board),
        stop: None,
        accuracy: scene.accuracy,
        effects: Effects::default(),
    })
}
