//! The march: integrates both surfaces of the design, point by point, from the central ray of the half image.

use super::point_grid::PointGrid;
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
    Ok(PointGrid { camera: *target, pitch_mm: camera.pitch_mm, order: settings.order, u_px, v_px, z_mm })
}

/// Where the march makes points.
struct GridLayout {
    /// Offsets of columns and rows from the half image's centre, in px.
    u_px: Vec<f64>,
    v_px: Vec<f64>,
    /// Steps from one grid point to the next.
    hops: usize,
}

impl GridLayout {
    /// The grid of [`march`].
    fn new(camera: &CameraSpec, settings: &DesignSettings) -> Result<Self, Error> {
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
mod tests {
    use super::super::virtual_camera::tests::{paper_camera, paper_prism};
    use super::super::virtual_camera::virtual_camera;
    use super::*;
    use crate::scene::{BiprismSpec, Method};
    use glam::DVec3;

    const SETTINGS: DesignSettings =
        DesignSettings { order: MarchOrder::XThenY, degree: 5, method: Method::Rk4, step_px: 1.0 };

    fn paper_cloud(order: MarchOrder, step_px: f64, integrator: Integrator) -> PointGrid {
        let target = virtual_camera(&paper_camera(), &paper_prism(), 0.0).unwrap();
        march(&paper_camera(), &target, &DesignSettings { order, step_px, ..SETTINGS }, integrator).unwrap()
    }

    fn spread(cloud: &PointGrid) -> f64 {
        let [low, high] = cloud.optical_path_range_mm();
        high - low
    }

    #[test]
    fn the_optical_path_is_the_same_at_a_million_points() {
        for order in [MarchOrder::XThenY, MarchOrder::YThenX] {
            let cloud = paper_cloud(order, 1.0, Integrator::Rk4);
            assert_eq!((cloud.columns(), cloud.rows(), cloud.len()), (961, 1081, 961 * 1081));
            // 1000 steps, each rounded to some ulp (1.4e-14 mm) of lengths of 90 mm.
            assert!(spread(&cloud) < 1e-11, "{order:?}: {:e}", spread(&cloud));
        }
    }

    #[test]
    fn the_optical_path_converges_with_the_order_of_the_method() {
        for (integrator, order) in [(Integrator::Euler, 1.0), (Integrator::Midpoint, 2.0)] {
            // 1 and 0.5 px are one grid with one and two steps between its points.
            for pair in [[16.0, 8.0], [1.0, 0.5]] {
                let [coarse, fine] = pair.map(|step| spread(&paper_cloud(MarchOrder::XThenY, step, integrator)));
                let found = libm::log2(coarse / fine);
                assert!((found - order).abs() < 0.1, "{integrator:?}: {found}");
            }
        }
    }

    #[test]
    fn adaptive_steps_meet_the_classical_ones() {
        let [a, b] =
            [Integrator::Rk4, Integrator::DormandPrince(1e-13)].map(|i| paper_cloud(MarchOrder::XThenY, 16.0, i));
        let apart = a.z_mm.iter().zip(&b.z_mm).flat_map(|(a, b)| [a[0] - b[0], a[1] - b[1]]);
        assert!(apart.fold(0.0, |m: f64, d| m.max(d.abs())) < 1e-10);
    }

    #[test]
    fn both_orders_agree_on_the_centre_lines_only() {
        let [a, b] = [MarchOrder::XThenY, MarchOrder::YThenX].map(|order| paper_cloud(order, 8.0, Integrator::Rk4));
        let (column, row) = (a.columns() / 2, a.rows() / 2);
        for i in 0..a.columns() {
            assert!((a.at(i, row).front_mm - b.at(i, row).front_mm).length() < 1e-11);
        }
        for i in 0..a.rows() {
            assert!((a.at(column, i).back_mm - b.at(column, i).back_mm).length() < 1e-11);
        }
        // Two surfaces cannot meet three conditions: elsewhere the orders differ, and by far more than rounding.
        assert!((a.at(0, 0).front_mm - b.at(0, 0).front_mm).length() > 1e-3);
    }

    #[test]
    fn points_lie_on_their_rays_and_mirror_in_y() {
        for order in [MarchOrder::XThenY, MarchOrder::YThenX] {
            let cloud = paper_cloud(order, 16.0, Integrator::Rk4);
            let last = cloud.rows() - 1;
            for (column, row) in [(0, 0), (3, 7), (cloud.columns() - 1, last)] {
                let p = cloud.at(column, row);
                assert_eq!(p.u_px, cloud.u_px[column]);
                assert_eq!(p.v_px, cloud.v_px[row]);
                let ray = DVec3::new((2.64 + p.u_px * 0.0055) / 35.0, p.v_px * 0.0055 / 35.0, 1.0);
                assert!((p.front_mm - ray * p.front_mm.z).length() < 1e-13);
                let mirrored = cloud.at(column, last - row);
                assert_eq!(mirrored.front_mm * DVec3::new(1.0, -1.0, 1.0), p.front_mm);
                assert_eq!(mirrored.back_mm * DVec3::new(1.0, -1.0, 1.0), p.back_mm);
            }
            assert_eq!(cloud.points().nth(cloud.columns() + 2).unwrap(), cloud.at(2, 1));
        }
    }

    #[test]
    fn the_half_image_is_covered_for_odd_sizes_and_any_step() {
        let target = virtual_camera(&paper_camera(), &paper_prism(), 0.0).unwrap();
        for (width_px, height_px, step_px) in
            [(1919, 1079, 7.0), (1920, 1080, 1.7), (192, 108, 0.3), (37, 21, 3.0), (1, 1, 1.0)]
        {
            let camera = CameraSpec { width_px, height_px, ..paper_camera() };
            let cloud = march(&camera, &target, &DesignSettings { step_px, ..SETTINGS }, Integrator::Rk4).unwrap();
            let corner = cloud.at(cloud.columns() - 1, 0);
            assert_eq!((corner.u_px, corner.v_px), (width_px as f64 / 4.0, -(height_px as f64) / 2.0));
            assert!(cloud.spacing_px().iter().all(|s| *s <= step_px.max(1.0) * (1.0 + 1e-12)));
            let centre = cloud.at(cloud.columns() / 2, cloud.rows() / 2);
            assert_eq!((centre.u_px, centre.v_px, centre.front_mm), (0.0, 0.0, target.front_mm));
        }
    }

    #[test]
    fn any_number_of_threads_gives_the_same_bits() {
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| paper_cloud(MarchOrder::XThenY, 8.0, Integrator::Rk4))
        };
        let one = with(1);
        for threads in [2, 5] {
            assert_eq!(with(threads), one);
        }
    }

    #[test]
    fn a_field_too_wide_for_the_glass_is_a_problem_that_says_where_and_why() {
        // At f = 5 mm the half image's corner is 46 deg off the axis and the thin edge of the prism runs out of glass.
        let camera = CameraSpec { focal_length_mm: 5.0, ..paper_camera() };
        let prism = BiprismSpec { thickness_mm: 80.0, ..paper_prism() };
        let target = virtual_camera(&camera, &prism, 0.0).unwrap();
        let settings = DesignSettings { step_px: 8.0, ..SETTINGS };
        let problem = march(&camera, &target, &settings, Integrator::Rk4).unwrap_err();
        assert!(problem.rule.contains("px from the half image's centre"), "{}", problem.rule);
        assert!(problem.rule.contains("surface"), "{}", problem.rule);
    }

    #[test]
    fn impossible_steps_are_problems() {
        let target = virtual_camera(&paper_camera(), &paper_prism(), 0.0).unwrap();
        for step_px in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-4, 1e-300] {
            let settings = DesignSettings { step_px, ..SETTINGS };
            let problem = march(&paper_camera(), &target, &settings, Integrator::Rk4).unwrap_err();
            assert!(problem.rule.contains("step_px"), "{step_px}: {}", problem.rule);
        }
        let camera = CameraSpec { width_px: 50_000, height_px: 50_000, ..paper_camera() };
        assert!(march(&camera, &target, &SETTINGS, Integrator::Rk4).unwrap_err().rule.contains("may make 16000000"));
        let camera = CameraSpec { height_px: 0, ..paper_camera() };
        assert!(march(&camera, &target, &SETTINGS, Integrator::Rk4).unwrap_err().rule.contains("1920 x 0"));
    }
}
