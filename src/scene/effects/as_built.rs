//! The prism as built, as a scene file writes it: its departures from the nominal prism.

use super::rules;
use crate::effect::manufacture::{Displacement, Manufacture, SurfaceError};
use crate::effect::roughness::Roughness;
use crate::error::Error;
use crate::num::bernstein::MAX_DEGREE;
use crate::scene::document::Document;
use crate::scene::limits::*;
use crate::scene::model::PrismSpec;
use crate::surface::figure_error::{FigureError, SurfaceWave, zernike};
use glam::{DVec2, DVec3};
use schemars::JsonSchema;
use serde::Deserialize;

#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct ManufactureFile {
    /// Shift [x, y, z] of the whole prism in its own frame, in mm.
    #[schemars(inner(range(min = -LONGEST_MM, max = LONGEST_MM)))]
    pub(super) decentre_mm: [f64; 3],
    /// Tilt [rx, ry, rz] of the whole prism about the middle of its front, about the fixed x, then y, then z axis, in deg.
    #[schemars(inner(range(min = -TILT_DEG, max = TILT_DEG)))]
    pub(super) tilt_deg: [f64; 3],
    /// What the glass is too thick by, in mm.
    #[schemars(range(min = -LONGEST_MM, max = LONGEST_MM))]
    pub(super) thickness_mm: f64,
    /// What the refractive index is too large by.
    #[schemars(range(min = -LARGEST_INDEX, max = LARGEST_INDEX))]
    pub(super) index: f64,
    /// Errors of the front, both facets together.
    pub(super) front: SurfaceErrorFile,
    /// Errors of the back.
    pub(super) back: SurfaceErrorFile,
}

#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct SurfaceErrorFile {
    /// Shift [x, y, z] of the surface, in mm.
    #[schemars(inner(range(min = -LONGEST_MM, max = LONGEST_MM)))]
    pub(super) decentre_mm: [f64; 3],
    /// Tilt [rx, ry, rz] of the surface about its middle, in deg.
    #[schemars(inner(range(min = -TILT_DEG, max = TILT_DEG)))]
    pub(super) tilt_deg: [f64; 3],
    /// Error of its height as Zernike terms.
    pub(super) zernike: Option<ZernikeFile>,
    /// Waves across it, as tools leave them.
    #[schemars(length(max = WAVINESS))]
    pub(super) waves: Vec<WaveFile>,
}

/// A sum of Zernike terms over a disk about the z axis of the prism's frame.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ZernikeFile {
    /// Radius of the disk, in mm.
    #[schemars(range(min = SHORTEST_MM, max = LONGEST_MM))]
    pub(super) radius_mm: f64,
    /// The terms [n, m, c]: order, frequency (negative for sines), and root mean square over the disk in um.
    #[schemars(length(min = 1, max = TERMS))]
    pub(super) terms: Vec<ZernikeTermFile>,
}

#[derive(Debug, Deserialize, JsonSchema)]
pub(super) struct ZernikeTermFile(
    #[schemars(range(max = MAX_DEGREE))] pub(super) usize,
    #[schemars(range(min = -(MAX_DEGREE as i32), max = MAX_DEGREE))] pub(super) i32,
    #[schemars(range(min = -LONGEST_MM, max = LONGEST_MM))] pub(super) f64,
);

/// A wave: amplitude times the cosine of the phase along it.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct WaveFile {
    /// Amplitude, half the height from trough to crest, in um.
    #[schemars(range(min = 0, max = LONGEST_MM))]
    pub(super) amplitude_um: f64,
    /// Distance from crest to crest, in mm.
    #[schemars(range(min = SHORTEST_MM, max = LONGEST_MM))]
    pub(super) period_mm: f64,
    /// Direction in which it runs, from +x to +y, in deg.
    #[serde(default)]
    #[schemars(range(min = -TILT_DEG, max = TILT_DEG))]
    pub(super) direction_deg: f64,
    /// Its phase at the origin, in deg: 0 for a crest.
    #[serde(default)]
    #[schemars(range(min = -TILT_DEG, max = TILT_DEG))]
    pub(super) phase_deg: f64,
}

#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub(super) struct RoughnessFile {
    /// Root mean square slope of the front along each axis, in deg.
    #[schemars(range(min = 0, max = ROUGHEST_DEG))]
    pub(super) front_slope_deg: f64,
    /// Root mean square slope of the back along each axis, in deg.
    #[schemars(range(min = 0, max = ROUGHEST_DEG))]
    pub(super) back_slope_deg: f64,
}

pub(super) fn roughness(file: &RoughnessFile) -> Roughness {
    Roughness { slope: [file.front_slope_deg, file.back_slope_deg].map(|deg| libm::tan(deg.to_radians())) }
}

pub(super) fn manufacture(
    document: &Document,
    file: &ManufactureFile,
    prism: &PrismSpec,
) -> Result<Manufacture, Error> {
    rules::index_stays(document, file.index, prism)?;
    Ok(Manufacture {
        prism: displacement(file.decentre_mm, file.tilt_deg),
        front: surface(document, "effect.manufacture.front", &file.front, prism)?,
        back: surface(document, "effect.manufacture.back", &file.back, prism)?,
        thickness_mm: file.thickness_mm,
        index: file.index,
    })
}

fn displacement(decentre_mm: [f64; 3], tilt_deg: [f64; 3]) -> Displacement {
    Displacement {
        decentre_mm: DVec3::from_array(decentre_mm),
        tilt_rad: DVec3::from_array(tilt_deg.map(f64::to_radians)),
    }
}

fn surface(document: &Document, path: &str, file: &SurfaceErrorFile, prism: &PrismSpec) -> Result<SurfaceError, Error> {
    let place = displacement(file.decentre_mm, file.tilt_deg);
    if file.zernike.is_none() && file.waves.is_empty() {
        return Ok(SurfaceError { place, figure: None });
    }
    rules::figure_has_base(document, path, prism)?;
    let terms = file.zernike.iter().flat_map(|z| &z.terms).map(|&ZernikeTermFile(n, m, um)| (n, m, um / 1000.0));
    let terms: Vec<_> = terms.collect();
    for (i, &(n, m, _)) in terms.iter().enumerate() {
        if m.unsigned_abs() as usize > n || (n - m.unsigned_abs() as usize) % 2 == 1 {
            let at = format!("{path}.zernike.terms[{i}]");
            let rule = format!("`{at}` has n = {n} and m = {m}, and there is no such Zernike polynomial");
            let help = "give m = -n, -n + 2, ... n";
            return Err(document.fault(&at, rule, help));
        }
    }
    let radius_mm = file.zernike.as_ref().map_or(1.0, |z| z.radius_mm);
    let sag = zernike(radius_mm, &terms).expect("the terms were judged above");
    let wave = |wave: &WaveFile| {
        let (sin, cos) = libm::sincos(wave.direction_deg.to_radians());
        SurfaceWave {
            amplitude_mm: wave.amplitude_um / 1000.0,
            rad_per_mm: DVec2::new(cos, sin) * (std::f64::consts::TAU / wave.period_mm),
            phase_rad: wave.phase_deg.to_radians(),
        }
    };
    Ok(SurfaceError { place, figure: Some(FigureError { sag, waves: file.waves.iter().map(wave).collect() }) })
}
