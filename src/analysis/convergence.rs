//! The design paper's Fig. 4(b): how far from O' the rays behind a designed prism meet the axis, over the step of its march.

use crate::design::fit::fit;
use crate::design::march::march;
use crate::design::virtual_camera::virtual_camera;
use crate::design::{DesignInput, FreeformDesign};
use crate::error::Error;
use crate::geom::Ray;
use crate::metrics::ray_bundle::axis_crossings;
use crate::num::ode::Integrator;
use crate::scene::{PrismSpec, Scene};
use crate::system::{self, Side};
use glam::{DVec2, DVec3};

/// Rays on each side of the central one, over the middle row of the half image.
const RAYS: usize = 20;

/// One march, to be fitted by each of the degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MarchPlan {
    /// How it steps.
    pub integrator: Integrator,
    /// The step on the sensor, in um; of adaptive steps the way that they divide.
    pub step_um: f64,
}

/// How far the rays of one march's prism miss.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisMiss {
    /// Total degree of the fitted polynomials.
    pub degree: usize,
    /// Mean over the rays of |z - z_O'|, where they come nearest to the axis of the virtual camera, in mm.
    pub mean_abs_mm: f64,
    /// Largest less smallest optical path over the marched points, in mm.
    pub path_spread_mm: f64,
}

/// Euler, midpoint, Runge-Kutta at steps from `coarsest_um` down to `finest_um`, each half the one before; the adaptive pair once.
pub fn plans(coarsest_um: f64, finest_um: f64) -> Vec<MarchPlan> {
    let halves = |k: i32| coarsest_um / f64::from(1 << k);
    let mut steps: Vec<f64> = (0..16).map(halves).take_while(|step| *step > finest_um * 1.05).collect();
    steps.push(finest_um);
    let fixed = [Integrator::Euler, Integrator::Midpoint, Integrator::Rk4];
    let of = |integrator| steps.iter().map(move |&step_um| MarchPlan { integrator, step_um });
    let adaptive = [1e-3, 1e-6, 1e-9, 1e-12]
        .map(|tolerance| MarchPlan { integrator: Integrator::DormandPrince(tolerance), step_um: coarsest_um });
    fixed.into_iter().flat_map(of).chain(adaptive).collect()
}

/// Marches the prism of `scene` as `plan` says, fits it by each of `degrees`, and traces the rays of the middle row.
///
/// # Errors
/// When the scene does not design its prism by a march, or there is none.
pub(crate) fn axis_misses(scene: &Scene, plan: MarchPlan, degrees: &[usize]) -> Result<Vec<AxisMiss>, Error> {
    let input = DesignInput::of(scene).ok_or_else(|| {
        let rule = "the prism is not designed, and nothing is marched";
        Error::new(format!("scene {}", scene.name), rule, "use a scene with `prism.kind` = \"freeform\"")
    })?;
    let mut settings = input.settings;
    settings.step_px = plan.step_um / (1e3 * scene.camera.pitch_mm);
    settings.degree = degrees.iter().copied().max().unwrap_or(settings.degree);
    let camera = virtual_camera(&input.camera, &input.prism, input.virtual_camera_z_mm)?;
    let cloud = march(&input.camera, &camera, &settings, plan.integrator)?;
    let [shortest, longest] = cloud.optical_path_range_mm();
    let [front_mm, back_mm] = [cloud.front_mm(), cloud.back_mm()];
    let one = |&degree: &usize| {
        let design = FreeformDesign {
            camera,
            front: fit(&front_mm, degree, Some(camera.front_mm.truncate()))?,
            back: fit(&back_mm, degree, Some(camera.back_mm.truncate()))?,
            optical_path_spread_mm: longest - shortest,
            cloud: cloud.clone(),
            met: None,
        };
        let made = Scene { prism: PrismSpec::Polynomial(design.prism(input.prism.body)), ..scene.clone() };
        let axis = Ray { origin: camera.centre_mm + scene.camera.position_mm, direction: DVec3::Z };
        let mean_abs_mm = mean_abs_mm(&made, &axis)?;
        Ok(AxisMiss { degree, mean_abs_mm, path_spread_mm: longest - shortest })
    };
    degrees.iter().map(one).collect()
}

/// Over the rays of the middle row of the right half, borders included, without the central one.
fn mean_abs_mm(scene: &Scene, axis: &Ray) -> Result<f64, Error> {
    let system = system::build(scene)?.without_effects();
    let [width, height] = system.camera().size_px().map(|n| n as f64);
    let place = |k: usize| (k as f64 / RAYS as f64 - 1.0) * 0.25 * width;
    let px = (0..=2 * RAYS).filter(|k| *k != RAYS).map(|k| DVec2::new(0.75 * width + place(k), 0.5 * height));
    let rays: Vec<Ray> = px.filter_map(|px| system.exit_ray_through(px, Side::Right).ok()).collect();
    let crossings = axis_crossings(&rays, axis).map_err(|why| {
        Error::new("the rays behind the prism", why.to_string(), "use a prism whose half images are filled")
    })?;
    Ok(crossings.mean_abs_mm)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An independent program's figures for the paper's prism, and the orders that the methods have.
    #[test]
    fn the_paper_s_march_converges_as_another_program_s() {
        let text = include_str!("../../scenes/paper.toml");
        let scene = crate::scene::parse(text, "paper", None).unwrap_or_else(|problem| panic!("{problem}"));
        for (integrator, step_um, wanted) in [
            (Integrator::Euler, 91.034_482_758_620_7, [0.088_167_1, 0.105_378]),
            (Integrator::Midpoint, 91.034_482_758_620_7, [3.906_81e-4, 3.792_39e-4]),
            (Integrator::Midpoint, 11.0, [1.089_7e-4, 5.536_73e-6]),
        ] {
            let found = axis_misses(&scene, MarchPlan { integrator, step_um }, &[5, 9]).expect("it exists");
            for (found, wanted) in found.iter().zip(wanted) {
                let relative = found.mean_abs_mm / wanted - 1.0;
                assert!(relative.abs() < 2e-5, "{integrator:?} at {step_um} um, degree {}", found.degree);
            }
        }
    }

    #[test]
    fn steps_go_down_to_the_finest_one() {
        let steps: Vec<f64> =
            plans(80.0, 3.0).iter().filter(|p| p.integrator == Integrator::Euler).map(|p| p.step_um).collect();
        assert_eq!(steps, [80.0, 40.0, 20.0, 10.0, 5.0, 3.0]);
        assert!(plans(80.0, 79.0).len() == 3 + 4);
    }
}
