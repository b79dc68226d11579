//! How much a change of light grows on its way to the output: by a lamp that lights more than the reference, and by the sensor.

use super::instrument::System;
use super::radiance_range::{Bound, SMALL_GRID, extremes, grid};
use crate::effect::{BoardPoint, Effects, Hook, LightPath, Sensor};
use crate::scene::Scene;
use glam::DVec2;
use rayon::prelude::*;

/// Variants over which the lamp's light is looked at.
const VARIANTS: usize = 16;
/// Deviates beyond which the uneven gain of a pixel is not expected: one of 10^7 pixels.
const PRNU_DEVIATES: f64 = 5.5;

/// How changes of the light of a scene grow, whichever effect makes them.
pub(super) struct OutputGain {
    /// The most by which the lamp multiplies a radiance that the picture sees, and any on the plane of the board.
    pub(super) lamp: f64,
    pub(super) lamp_anywhere: f64,
    /// The sensor, where one acts, and the least and the most light that reaches it.
    sensor: Option<(Sensor, [f64; 2])>,
}

impl OutputGain {
    /// That of a scene whose instrument without effects is `ideal`.
    pub(super) fn of(ideal: &System, scene: &Scene) -> Self {
        let (effects, board) = (&scene.effects, &scene.board);
        let lamp_anywhere = lamp_gain_anywhere(ideal, effects);
        let darkest = || board.black.min(board.white).min(board.background) * least_throughput(ideal, effects);
        // Glass and ghosts share what comes in.
        let behind = effects.ghosts.map_or(0.0, |ghosts| ghosts.behind);
        let brightest = board.black.max(board.white).max(board.background).max(behind) * lamp_anywhere;
        Self {
            lamp: lamp_gain(ideal, effects),
            lamp_anywhere,
            sensor: (effects.sensor.filter(|sensor| !sensor.is_nothing()))
                .map(|sensor| (sensor, [darkest(), brightest])),
        }
    }

    /// What a change of the light is at the output.
    pub(super) fn at_output(&self, bound: Bound) -> Bound {
        self.sensor.as_ref().map_or(bound, |(sensor, light)| behind_sensor(sensor, bound, *light))
    }
}

/// The most by which the lamp of `effects` multiplies a radiance that the picture sees, at least 1.
fn lamp_gain(ideal: &System, effects: &Effects) -> f64 {
    lamp_range(ideal, effects).map_or(1.0, |[_, most]| most.max(1.0))
}

/// The least and the most by which the lamp of `effects` multiplies a radiance that the picture sees, rays straying by every
/// effect that lets them stray; `None` without a lamp. Its light falls with the distance from its foot on the board, so that
/// of a rectangle of the board the places nearest to it and farthest from it tell.
pub(super) fn lamp_range(ideal: &System, effects: &Effects) -> Option<[f64; 2]> {
    let lamp = effects.lamp.filter(|lamp| !lamp.is_nothing())?;
    let system = ideal.with_effects(&effects.only(|row| row.hook != Hook::Transport && row.hook != Hook::Film));
    let board = system.board();
    let foot = board.local(lamp.position_mm).truncate();
    let at = |board_mm: DVec2| {
        let landing = Some(BoardPoint { point_mm: board.world(board_mm), normal: board.normal() });
        lamp.throughput(&LightPath { image_cos: 1.0, crossings: &[], landing })
    };
    let range = |system: &System| {
        let seen = |px: &DVec2| {
            let (ray, _) = system.exit_ray(*px).ok()?;
            board.intersect(&ray).ok().map(|(board_mm, _)| board_mm)
        };
        let places: Vec<DVec2> = grid(system, SMALL_GRID).par_iter().filter_map(seen).collect();
        let low = places.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let high = places.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        if places.is_empty() {
            return [1.0; 2];
        }
        // A step of the grid wider, for what is seen between its places.
        let step = (high - low) / (SMALL_GRID[1] - 1) as f64;
        let (low, high) = (low - step, high + step);
        let farthest = DVec2::select((foot - low).abs().cmpge((foot - high).abs()), low, high);
        [at(farthest), at(foot.clamp(low, high))]
    };
    let variants = system.effects().variants(0).some(VARIANTS);
    // What never meets the board's plane is lit as the reference place is.
    let all = variants.iter().map(|variant| range(&system.variant(variant)));
    Some(all.fold([1.0; 2], |[least, most], [low, high]| [f64::min(least, low), f64::max(most, high)]))
}

/// The most by which it multiplies a radiance anywhere on the plane of the board, where ghosts may be of any place: at the
/// foot of the lamp.
fn lamp_gain_anywhere(ideal: &System, effects: &Effects) -> f64 {
    let Some(lamp) = effects.lamp.filter(|lamp| !lamp.is_nothing()) else { return 1.0 };
    let board = ideal.board();
    let normal = board.normal();
    let height = (lamp.position_mm - board.pattern.world_from_board.translation_mm).dot(normal);
    let foot = BoardPoint { point_mm: lamp.position_mm - normal * height, normal };
    lamp.throughput(&LightPath { image_cos: 1.0, crossings: &[], landing: Some(foot) }).max(1.0)
}

/// The least share of a radiance that the transport effects of `effects` leave, over the picture; 0 where rays may end.
fn least_throughput(ideal: &System, effects: &Effects) -> f64 {
    let system = ideal.with_effects(&effects.only(|row| row.hook != Hook::Film));
    let least = |system: &System| {
        let places = grid(system, SMALL_GRID);
        if places.iter().any(|px| system.trace(*px).is_err()) {
            return 0.0;
        }
        let values: Vec<f64> = places.par_iter().map(|px| system.throughput(*px)).collect();
        let (_, step) = extremes(&values, SMALL_GRID);
        (values.iter().copied().fold(f64::INFINITY, f64::min) - step).max(0.0)
    };
    let variants = system.effects().variants(0).some(VARIANTS);
    variants.iter().map(|variant| least(&system.variant(variant))).fold(f64::INFINITY, f64::min)
}

/// What a change of the light by `bound.grey` is behind `sensor`, where light is `darkest` at least and `brightest` at most:
/// of the value that is expected, without noise. The steps of a converter count in full, for any change may be the one that makes one.
fn behind_sensor(sensor: &Sensor, bound: Bound, [darkest, brightest]: [f64; 2]) -> Bound {
    if bound.grey == 0.0 {
        return bound;
    }
    // From radiance to the output before the gamma, and its steps.
    let (gain, dark, step) = match &sensor.adc {
        None => (1.0, sensor.dark_e / sensor.white_e, 0.0),
        Some(adc) => {
            let per_e = adc.gain_dn_per_e / adc.largest_dn();
            let dark = sensor.dark_e * per_e + adc.black_level_dn / adc.largest_dn();
            (sensor.white_e * per_e, dark, 1.0 / adc.largest_dn())
        }
    };
    let uneven = PRNU_DEVIATES * sensor.prnu;
    let change = bound.grey * gain * (1.0 + uneven) + step;

    // The gamma is steepest at the darkest value or at the brightest.
    let power = 1.0 / sensor.gamma;
    let spread = (1.0 - uneven).max(0.0);
    let lowest = if sensor.is_random() { 0.0 } else { (darkest * gain * spread + dark - change).max(0.0) };
    let rise = |from: f64| libm::pow(from + change, power) - libm::pow(from, power);
    // A converter ends at full scale.
    let most = brightest * gain * (1.0 + uneven) + dark;
    let most = if sensor.adc.is_some() { most.min(1.0) } else { most };
    let highest = (most.max(1.0) - change).max(0.0);
    Bound { grey: rise(lowest).max(rise(highest)), ..bound }
}
