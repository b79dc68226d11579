//! The march: integrates both surfaces of the design, point by point, from the central ray of the half image.

use super::point_grid::{PointGrid, TargetLaw};
use super::slope::{PathParameter, Singular, slope};
use super::virtual_camera::VirtualCamera;
use crate::error::Error;
use crate::num::ode::{Integrator, OdeError};
use crate::scene::{CameraSpec, DesignSettings, MarchOrder};
use rayon::prelude::*;

/// Most points of a grid: 16 bytes each, so 256 MB.
pub const MAX_POINTS: usize = 16_000_000;

/// Most steps of a march: a few minutes of one core.
pub const MAX_STEPS: usize = 1_000_000_000;

/// Both surfaces over the right half of the sensor of `camera`, whose virtual camera is `target`.
///
/// From the half image's centre the first march goes along the centre line to both borders, the second from each of its
/// points to the borders across. The half image reaches `width_px / 4` to each side and `height_px / 2` up and down; the grid
/// divides that distance evenly, at the largest spacing that is no longer than `settings.step_px` (or 1 px, if that is
/// longer), but into no fewer parts than the fit has degrees. Steps below 1 px divide the way from point to point.
/// `settings.method` is not used: `integrator` makes each step.
///
/// The lines of the second march are independent: the result has the same bits for any number of threads.
///
/// # Errors
/// A [`Error`] when the step is not positive, the grid has more than [`MAX_POINTS`], or no surface exists at a pixel.
pub fn march(
    camera: &CameraSpec,
    target: &VirtualCamera,
    settings: &DesignSettings,
    integrator: Integrator,
) -> Result<PointGrid, Error> {
    let GridLayout { u_px, v_px, hops } = GridLayout::new(camera, settings)?;
    let in_mm = |px: &[f64]| px.iter().map(|p| p * camera.pitch_mm).collect::<Vec<_>>();
    let (u_mm, v_mm) = (in_mm(&u_px), in_mm(&v_px));

    // March along the centre line.
    let (first, second) = match settings.order {
        MarchOrder::XThenY => (PathParameter::U, PathParameter::V),
        MarchOrder::YThenX => (PathParameter::V, PathParameter::U),
    };
    let (across, along) = match first {
        PathParameter::U => (&u_mm, &v_mm),
        PathParameter::V => (&v_mm, &u_mm),
    };
    let stopped = |at: Stopped| at.problem(camera.pitch_mm);
    let start = [target.front_mm.z, target.back_mm.z];
    let mut spine = vec![start; across.len()];
    march_line(target, integrator, GridLine { along: first, other_mm: 0.0, t_mm: across, hops }, &mut spine)
        .map_err(stopped)?;

    // March across it from every one of its points.
    let mut z_mm = vec![start; across.len() * along.len()];
    let ends: Vec<Result<(), Stopped>> = z_mm
        .par_chunks_mut(along.len())
        .zip(&spine)
        .zip(across)
        .map(|((line, &z), &other_mm)| {
            line[along.len() / 2] = z;
            march_line(target, integrator, GridLine { along: second, other_mm, t_mm: along, hops }, line)
        })
        .collect();

    // Report the first line that stopped, in the order of the lines and not of the threads.
    ends.into_iter().collect::<Result<(), _>>().map_err(stopped)?;
    Ok(PointGrid {
        camera: *target,
        pitch_mm: camera.pitch_mm,
        order: settings.order,
        law: TargetLaw::Pinhole,
        u_px,
        v_px,
        z_mm,
    })
}

/// Where the march makes points.
pub(super) struct GridLayout {
    /// Offsets of columns and rows from the half image's centre, in px.
    pub(super) u_px: Vec<f64>,
    pub(super) v_px: Vec<f64>,
    /// Steps from one grid point to the next.
    pub(super) hops: usize,
}

impl GridLayout {
    /// The grid of [`march`].
    pub(super) fn new(camera: &CameraSpec, settings: &DesignSettings) -> Result<Self, Error> {
        // Refuse a step or a sensor that is not positive.
        let (half_width, half_height) = (camera.width_px as f64 / 4.0, camera.height_px as f64 / 2.0);
        let step_px = settings.step_px;
        if !(step_px.is_finite() && step_px > 0.0) {
            return Err(Error::new(
                "the prism's design",
                format!("`prism.design.step_px` is {step_px}, and must be above 0"),
                "use 1, a step of one pixel",
            ));
        }
        if camera.width_px == 0 || camera.height_px == 0 {
            return Err(Error::new(
                "the camera",
                format!("the sensor has {} x {} px, and must have at least 1 x 1", camera.width_px, camera.height_px),
                "set `camera.width_px` and `camera.height_px`",
            ));
        }

        // Divide the half image evenly, and bound points and steps.
        let spacing_px = step_px.max(1.0);
        let parts = |half: f64| (half / spacing_px).ceil().max(settings.degree as f64).max(1.0);
        let points = (2.0 * parts(half_width) + 1.0) * (2.0 * parts(half_height) + 1.0);
        if points > MAX_POINTS as f64 {
            return Err(Error::new(
                "the prism's design",
                format!(
                    "a step of `prism.design.step_px` = {step_px} makes {points} points, and may make {MAX_POINTS}"
                ),
                format!("use a step of {:.2} px or more", spacing_px * (points / MAX_POINTS as f64).sqrt() * 1.01),
            ));
        }
        let hops = (spacing_px / step_px).ceil();
        if hops * points > MAX_STEPS as f64 {
            return Err(Error::new(
                "the prism's design",
                format!(
                    "`prism.design.step_px` = {step_px} makes {:.1e} steps, and may make {MAX_STEPS}",
                    hops * points
                ),
                format!("use a step of {:.4} px or more", points / MAX_STEPS as f64 * 1.01),
            ));
        }

        let u_px = nodes(half_width, parts(half_width) as usize);
        let v_px = nodes(half_height, parts(half_height) as usize);
        Ok(Self { u_px, v_px, hops: hops as usize })
    }
}

/// -half to half in 2 `parts` equal parts; the middle is exactly 0 and the two sides are mirror images.
fn nodes(half: f64, parts: usize) -> Vec<f64> {
    let side = (1..=parts).map(|i| half * i as f64 / parts as f64);
    side.clone().rev().map(|t| -t).chain([0.0]).chain(side).collect()
}

/// A row or a column of the grid.
#[derive(Debug, Clone, Copy)]
struct GridLine<'a> {
    along: PathParameter,
    /// The parameter that stays: v of a row, u of a column.
    other_mm: f64,
    /// The parameter that runs.
    t_mm: &'a [f64],
    /// Steps from one grid point to the next.
    hops: usize,
}

/// Where and why a march ended.
#[derive(Debug, Clone, Copy)]
struct Stopped {
    u_mm: f64,
    v_mm: f64,
    why: OdeError<Singular>,
}

impl Stopped {
    fn problem(self, pitch_mm: f64) -> Error {
        let why = match self.why {
            OdeError::Refused(singular) => singular.to_string(),
            OdeError::NoProgress => "adaptive steps make no progress".to_owned(),
        };
        Error::new(
            "the prism's design",
            format!(
                "no freeform surfaces exist beyond ({:.1}, {:.1}) px from the half image's centre: {why}",
                self.u_mm / pitch_mm,
                self.v_mm / pitch_mm
            ),
            "use a thicker prism, a longer focal length or a smaller sensor",
        )
    }
}

/// Marches from the middle of `z`, which holds the start, to both ends.
fn march_line(
    target: &VirtualCamera,
    integrator: Integrator,
    line: GridLine,
    z: &mut [[f64; 2]],
) -> Result<(), Stopped> {
    // Take the slopes as the right side of the differential equation along the line.
    let pixel = |t| match line.along {
        PathParameter::U => (t, line.other_mm),
        PathParameter::V => (line.other_mm, t),
    };
    let rate = |t, z| {
        let (u, v) = pixel(t);
        slope(target, line.along, u, v, z)
    };

    // Integrate from grid point to grid point.
    let middle = z.len() / 2;
    let mut go = |from: usize, to: usize| {
        let (t0, step) = (line.t_mm[from], (line.t_mm[to] - line.t_mm[from]) / line.hops as f64);
        z[to] = (0..line.hops).try_fold(z[from], |z, i| {
            let t = t0 + step * i as f64;
            integrator.advance(&rate, t, z, step).map_err(|why| {
                let (u_mm, v_mm) = pixel(t);
                Stopped { u_mm, v_mm, why }
            })
        })?;
        Ok(())
    };

    // Go from the middle to both ends.
    (middle + 1..line.t_mm.len()).try_for_each(|i| go(i - 1, i))?;
    (0..middle).rev().try_for_each(|i| go(i + 1, i))
}

#[cfg(test)]
#[path = "march_tests.rs"]
mod tests;
