//! What errors of manufacture do to the picture: as they are, to the rows of the pair, and after the pair is calibrated again.

use super::bench::{Bench, tangents};
use crate::effect::manufacture::{Displacement, SurfaceError};
use crate::effect::{Effects, Manufacture};
use crate::error::Error;
use crate::num::lsq;
use crate::system::System;
use glam::{DVec2, DVec3};
use nalgebra::DMatrix;

/// Places along each side of a half.
const PLACES: usize = 21;
/// A minute of arc, in rad.
const ARCMIN: f64 = std::f64::consts::PI / 10800.0;
/// 10 um, in mm.
const TEN_UM: f64 = 0.01;

/// What one error does: root mean squares over both halves, in px.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorSensitivity {
    /// What is wrong, and by how much.
    pub error: &'static str,
    /// How far pixels look aside at the board's distance, along the rows and across them.
    pub raw_px: DVec2,
    /// How far the right half looks aside there across the rows less the left one at the same place of the half image: vertical
    /// disparity.
    pub vertical_px: f64,
    /// What is left at both ends of the depths once pose, focal lengths and principal point of each half are fitted anew.
    pub recalibrated_px: f64,
}

/// An error by its name.
#[derive(Debug, Clone, Copy)]
pub struct NamedError {
    name: &'static str,
    of: fn() -> Manufacture,
}

fn whole(decentre_mm: DVec3, tilt_rad: DVec3) -> Manufacture {
    Manufacture { prism: Displacement { decentre_mm, tilt_rad }, ..Manufacture::default() }
}

fn back(decentre_mm: DVec3, tilt_rad: DVec3) -> Manufacture {
    let place = Displacement { decentre_mm, tilt_rad };
    Manufacture { back: SurfaceError { place, figure: None }, ..Manufacture::default() }
}

/// The errors of the table.
pub const ERRORS: [NamedError; 12] = [
    NamedError { name: "prism, decentre x 10 um", of: || whole(DVec3::X * TEN_UM, DVec3::ZERO) },
    NamedError { name: "prism, decentre y 10 um", of: || whole(DVec3::Y * TEN_UM, DVec3::ZERO) },
    NamedError { name: "prism, tilt about x 1'", of: || whole(DVec3::ZERO, DVec3::X * ARCMIN) },
    NamedError { name: "prism, tilt about y 1'", of: || whole(DVec3::ZERO, DVec3::Y * ARCMIN) },
    NamedError { name: "prism, roll about z 1'", of: || whole(DVec3::ZERO, DVec3::Z * ARCMIN) },
    NamedError { name: "rear, decentre x 10 um", of: || back(DVec3::X * TEN_UM, DVec3::ZERO) },
    NamedError { name: "rear, decentre y 10 um", of: || back(DVec3::Y * TEN_UM, DVec3::ZERO) },
    NamedError { name: "rear, tilt about x 1'", of: || back(DVec3::ZERO, DVec3::X * ARCMIN) },
    NamedError { name: "rear, tilt about y 1'", of: || back(DVec3::ZERO, DVec3::Y * ARCMIN) },
    NamedError { name: "rear, roll about z 1'", of: || back(DVec3::ZERO, DVec3::Z * ARCMIN) },
    NamedError { name: "thickness 10 um", of: || Manufacture { thickness_mm: TEN_UM, ..Manufacture::default() } },
    NamedError { name: "index 1e-3", of: || Manufacture { index: 1e-3, ..Manufacture::default() } },
];

/// The effects of all errors at once, at their worst: a prism with room for these has room for each.
pub(super) fn all_errors() -> Manufacture {
    let most = Displacement { decentre_mm: DVec3::splat(TEN_UM), tilt_rad: DVec3::splat(ARCMIN) };
    let back = SurfaceError { place: most, figure: None };
    Manufacture { prism: most, back, thickness_mm: TEN_UM, index: 1e-3, ..Manufacture::default() }
}

/// Root sum of squares of what is left after calibration.
pub fn recalibrated_rss_px(all: &[ErrorSensitivity]) -> f64 {
    all.iter().map(|s| s.recalibrated_px * s.recalibrated_px).sum::<f64>().sqrt()
}

/// What each of [`ERRORS`] does to the prism on the bench: seen at `depth_mm`, and calibrated from `z_min_mm` to infinity.
pub(super) fn sensitivities(bench: &Bench<'_>, z_min_mm: f64, depth_mm: f64) -> Result<Vec<ErrorSensitivity>, Error> {
    let distances = [1.0 / depth_mm, 1.0 / z_min_mm, 0.0];
    let ideal = bench.system.without_effects();
    let right = seen(&Bench { system: &ideal, ..bench.clone() }, distances)?;
    let one = |error: &NamedError| {
        let effects = Effects { manufacture: Some((error.of)()), ..Effects::default() };
        let wrong: System = ideal.with_effects(&effects);
        let wrong = seen(&Bench { system: &wrong, ..bench.clone() }, distances)?;
        compared(error.name, bench, &right, &wrong)
    };
    ERRORS.iter().map(one).collect()
}

/// What a place of a half sees at a distance.
#[derive(Debug, Clone, Copy)]
struct SeenAt {
    tangents: DVec2,
    inverse_mm: f64,
}

/// What the places of both halves see, by half and place, at each of the distances 1/`inverse_mm`.
fn seen(bench: &Bench<'_>, inverse_mm: [f64; 3]) -> Result<[Vec<[SeenAt; 3]>; 2], Error> {
    let mut halves = [Vec::new(), Vec::new()];
    for (half, all) in bench.halves.iter().zip(&mut halves) {
        for place_px in bench.places(PLACES) {
            let ray = bench.passed(&bench.ray(&half.frame, place_px), half.frame.side(), &mut ())?;
            let at = |inverse_mm: f64| SeenAt { tangents: tangents(&half.camera, &ray, inverse_mm), inverse_mm };
            all.push(inverse_mm.map(at));
        }
    }
    Ok(halves)
}

fn compared(
    error: &'static str,
    bench: &Bench<'_>,
    right: &[Vec<[SeenAt; 3]>; 2],
    wrong: &[Vec<[SeenAt; 3]>; 2],
) -> Result<ErrorSensitivity, Error> {
    // Take how far places look aside at each distance, in px.
    let moved = [0, 1].map(|k| {
        let focal_px = bench.halves[k].camera.focal_px;
        let of =
            |(a, b): (&[SeenAt; 3], &[SeenAt; 3])| [0, 1, 2].map(|at| (b[at].tangents - a[at].tangents) * focal_px);
        right[k].iter().zip(&wrong[k]).map(of).collect::<Vec<[DVec2; 3]>>()
    });
    let n = moved[0].len();
    let mean_square = |errors: &[DVec2]| errors.iter().map(|e| *e * *e).sum::<DVec2>() / errors.len() as f64;
    let both: Vec<DVec2> = moved.iter().flatten().map(|at| at[0]).collect();
    let apart: Vec<DVec2> = (0..n).map(|i| moved[1][i][0] - moved[0][i][0]).collect();

    // Calibrate each half over the ends of the depths.
    let mut left = 0.0;
    for k in 0..2 {
        let places: Vec<SeenAt> = right[k].iter().flat_map(|at| [at[1], at[2]]).collect();
        let errors: Vec<DVec2> = moved[k].iter().flat_map(|at| [at[1], at[2]]).collect();
        left += recalibrated(&places, &errors, bench.halves[k].camera.focal_px).map_err(|why| {
            Error::new("the prism", format!("a half cannot be calibrated: {why}"), "give a wider field")
        })? / 2.0;
    }
    Ok(ErrorSensitivity {
        error,
        raw_px: mean_square(&both).map(f64::sqrt),
        vertical_px: mean_square(&apart).y.sqrt(),
        recalibrated_px: left.sqrt(),
    })
}

/// The mean square of what is left of `moved` once a pinhole's ten numbers have taken what they can, to first order, in px^2.
fn recalibrated(seen: &[SeenAt], moved: &[DVec2], focal_px: DVec2) -> Result<f64, lsq::Failure> {
    let columns = DMatrix::from_fn(2 * seen.len(), 10, |row, k| {
        let SeenAt { tangents: t, inverse_mm } = seen[row / 2];
        // How a tangent moves when its point is turned or shifted: as d(x/z, y/z).
        let by_point = |d: DVec3| d.truncate() - t * d.z;
        let change = match k {
            0 => by_point(DVec3::X.cross(t.extend(1.0))),
            1 => by_point(DVec3::Y.cross(t.extend(1.0))),
            2 => by_point(DVec3::Z.cross(t.extend(1.0))),
            3..=5 => by_point(DVec3::AXES[k - 3]) * inverse_mm,
            6 => t.with_y(0.0),
            7 => t.with_x(0.0),
            8 => DVec2::X,
            _ => DVec2::Y,
        };
        (change * focal_px)[row % 2]
    });
    let values = DMatrix::from_fn(2 * seen.len(), 1, |row, _| moved[row / 2][row % 2]);
    let fitted = lsq::linear(&columns, &values)?;
    Ok((values - columns * fitted).norm_squared() / seen.len() as f64)
}
