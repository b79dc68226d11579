//! The spot of a thin lens behind which a prism stands, at its best focus.

use super::bench::{Bench, tangents};
use crate::effect::Effects;
use crate::error::Error;
use crate::geom::Ray;
use glam::{DVec2, DVec3};

/// The f-number where a scene states none.
pub const F_NUMBER: f64 = 8.0;
/// Rings of the pupil; 4 (2 k + 1) points on ring k, equal areas.
const RINGS: usize = 4;
/// Places along each side of a half.
const FIELDS: usize = 9;
/// Steps of Newton's method on the focus, of which the spot is nearly a parabola.
const STEPS: usize = 4;
/// Step of its difference, in 1/mm: a thousandth of a dioptre.
const STEP_PER_MM: f64 = 1e-6;

/// The spot of a point at the board's distance over the right half.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spot {
    /// The f-number of the lens.
    pub f_number: f64,
    /// Whether the scene states it.
    pub stated: bool,
    /// Distance of the points from the camera, in mm.
    pub depth_mm: f64,
    /// sqrt(mean |x - mean x|^2) over pupil and field with the lens focused at that distance in air, in px.
    pub rms_px: f64,
    /// The same with the lens refocused for the least of it.
    pub best_rms_px: f64,
    /// The refocusing, in dioptres: below 0 to a nearer plane, as glass that spreads light asks for it.
    pub refocus_dpt: f64,
}

/// The spot at the aperture of the scene's thin lens, or of [`F_NUMBER`], of points `depth_mm` from the camera.
pub(super) fn spot(bench: &Bench<'_>, effects: &Effects, focal_length_mm: f64, depth_mm: f64) -> Result<Spot, Error> {
    let thin = effects.lens.thin().filter(|lens| lens.radius_mm > 0.0);
    let f_number = thin.map_or(F_NUMBER, |lens| 0.5 * lens.focal_mm / lens.radius_mm);
    let radius_mm = thin.map_or(0.5 * focal_length_mm / f_number, |lens| lens.radius_mm);
    let pupil = pupil(radius_mm);

    // Refocus by Newton's method: positions are nearly linear in 1/distance.
    let start = 1.0 / depth_mm;
    let first = positions(bench, &pupil, start, depth_mm)?;
    let (mut focus, mut here) = (start, first.clone());
    for _ in 0..STEPS {
        let there = positions(bench, &pupil, focus + STEP_PER_MM, depth_mm)?;
        let steps: Vec<DVec2> = here.iter().zip(&there).map(|(a, b)| (*b - *a) / STEP_PER_MM).collect();
        let over: f64 = here.iter().zip(&steps).map(|(x, s)| x.dot(*s)).sum();
        let under: f64 = steps.iter().map(|s| s.length_squared()).sum();
        focus -= over / under;
        here = positions(bench, &pupil, focus, depth_mm)?;
    }
    let rms = |positions: &[DVec2]| {
        (positions.iter().map(|x| x.length_squared()).sum::<f64>() / positions.len() as f64).sqrt()
    };
    Ok(Spot {
        f_number,
        stated: thin.is_some(),
        depth_mm,
        rms_px: rms(&first),
        best_rms_px: rms(&here),
        refocus_dpt: 1000.0 * (start - focus),
    })
}

/// Points of equal areas of a disk.
fn pupil(radius_mm: f64) -> Vec<DVec2> {
    let ring = |k: usize| {
        let count = 4 * (2 * k + 1);
        // The mean square radius of the ring.
        let radius = radius_mm * ((k * k + k) as f64 + 0.5).sqrt() / RINGS as f64;
        (0..count).map(move |j| {
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * (j as f64 + 0.5) / count as f64);
            radius * DVec2::new(cos, sin)
        })
    };
    (0..RINGS).flat_map(ring).collect()
}

/// Where the rays of each field's pupil are seen at `depth_mm`, from their centroid, in px, with the lens focused at 1/`focus`.
fn positions(bench: &Bench<'_>, pupil: &[DVec2], focus: f64, depth_mm: f64) -> Result<Vec<DVec2>, Error> {
    let half = &bench.halves[1];
    let mut all = Vec::new();
    for place_px in bench.places(FIELDS) {
        let chief = bench.ray(&half.frame, place_px);
        let slope = chief.direction.truncate() / chief.direction.z;
        let of = |at: &DVec2| {
            let direction = (slope - *at * focus).extend(1.0).normalize();
            let ray = Ray { origin: chief.origin + DVec3::new(at.x, at.y, 0.0), direction };
            let out = bench.passed(&ray, half.frame.side(), &mut ())?;
            Ok(tangents(&half.camera, &out, 1.0 / depth_mm) * half.camera.focal_px)
        };
        let seen = pupil.iter().map(of).collect::<Result<Vec<DVec2>, Error>>()?;
        let centroid = seen.iter().sum::<DVec2>() / seen.len() as f64;
        all.extend(seen.iter().map(|x| *x - centroid));
    }
    Ok(all)
}
