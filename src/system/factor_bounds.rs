//! Bounds of what factors of light change: those of an effect itself, and those that rays meet which stray by an effect.

use super::instrument::System;
use super::radiance_range::{Bound, RadianceRange, SMALL_GRID, extremes, grid};
use crate::effect::{EffectId, EffectRow, Effects, Hook, Variant};
use glam::DVec2;
use rayon::prelude::*;

/// Variants that are compared at most, spread over all of them.
const VARIANTS: usize = 64;
/// Of them, those whose slopes over the picture are compared.
const SLOPES: usize = 8;

/// An instrument without an effect and the same with it, with the share of the picture that both have.
pub(super) struct PairedVariants {
    pub(super) share: f64,
    pub(super) without: System,
    pub(super) with: System,
}

impl PairedVariants {
    /// The variants of both instruments one by one, where they are as many, or else all of `with` beside `without` itself.
    pub(super) fn all(without: &System, with: &System) -> Vec<Self> {
        let of = |system: &System| system.effects().variants(0).some(VARIANTS);
        let plain = Variant { grey: 1.0, ..Effects::default().variants(0).get(0) };
        let (before, after) = (of(without), of(with));
        let paired = before.len() == after.len();
        let total: f64 = after.iter().map(|variant| variant.grey).sum();
        let pair = |(k, variant): (usize, &Variant)| Self {
            share: variant.grey / total,
            without: without.variant(if paired { &before[k] } else { &plain }),
            with: with.variant(variant),
        };
        after.iter().enumerate().map(pair).collect()
    }
}

/// What the factors of light that `with` has and `without` has not change at most, over places of a grid: a pixel is a mean
/// over the variants of what each leaves.
pub(super) fn factors(pairs: &[PairedVariants], light: RadianceRange, size: [usize; 2]) -> Bound {
    // Find the change of a pixel.
    let places = grid(&pairs[0].with, size);
    let change = |px: &DVec2| {
        let one = |pair: &PairedVariants| pair.share * (pair.with.throughput(*px) - pair.without.throughput(*px));
        pairs.iter().map(one).fold([0.0f64; 2], |[size, sum], change| [size + change.abs(), sum + change])
    };
    let changes: Vec<[f64; 2]> = places.par_iter().map(change).collect();
    // A change may have another sign at the next place.
    let [(largest, step), (_, signed)] =
        [0, 1].map(|k| extremes(&changes.iter().map(|c| c[k]).collect::<Vec<_>>(), size));
    let step = step.max(signed);

    // Find the share by which the factor changes from one pixel to the next.
    let few: Vec<&PairedVariants> = pairs.iter().step_by(pairs.len().div_ceil(SLOPES)).collect();
    let slope = |px: &DVec2| few.iter().map(|pair| slope(pair, *px)).fold(0.0, f64::max);
    let (steepest, steps) = extremes(&places.par_iter().map(slope).collect::<Vec<_>>(), size);
    let px = if light.edge > 0.0 { (steepest + steps) * light.mean / light.edge } else { 0.0 };
    Bound { grey: light.brightest * (largest + step), px }
}

fn slope(pair: &PairedVariants, px: DVec2) -> f64 {
    let ratio = |px: DVec2| pair.with.throughput(px) / pair.without.throughput(px);
    let along = |step: DVec2| 0.5 * (ratio(px + step) - ratio(px - step));
    DVec2::new(along(DVec2::X), along(DVec2::Y)).length() / ratio(px)
}

/// What the factors of light change that rays meet which stray by the effect of `row`: of every transport effect of
/// `effects` by itself.
pub(super) fn strayed(ideal: &System, effects: &Effects, row: &EffectRow, light: RadianceRange) -> Bound {
    let mut sum = Bound { grey: 0.0, px: 0.0 };
    for factor in effects.acting().filter(|other| other.hook == Hook::Transport && other.needs.is_none()) {
        let has = |other: &EffectRow| {
            let stands_on = other.hook == Hook::Transport && other.needs == Some(factor.id);
            other.id == EffectId::Telecentric || other.id == factor.id || stands_on
        };
        let without = ideal.with_effects(&effects.only(has));
        let with = ideal.with_effects(&effects.only(|other| other.id == row.id || has(other)));
        let own = factors(&PairedVariants::all(&without, &with), light, SMALL_GRID);
        sum = Bound { grey: sum.grey + own.grey, px: sum.px + own.px };
    }
    sum
}
