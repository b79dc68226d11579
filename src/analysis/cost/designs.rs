//! The design of the prism: integrator, step and degree, against how well its rays meet in one point.

use super::Settings;
use super::time::timed;
use crate::analysis::nominal::{Frame, virtual_camera};
use crate::design::{DesignInput, VIRTUAL_CAMERA_Z_MM, freeform_by};
use crate::geom::Ray;
use crate::metrics::virtual_camera::axis_crossings;
use crate::num::ode::Integrator;
use crate::scene::{Prism, Scene};
use crate::system;
use crate::vision::half::Half;
use glam::{DVec2, DVec3};

/// One design.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    /// What was turned: the integrator's name, or the degree.
    pub knob: &'static str,
    /// To what, in words.
    pub value: String,
    /// To what, as a number: the step in um on the sensor, the tolerance in mm, or the degree.
    pub number: f64,
    /// CPU time of the design with its fit, in ms, taken once.
    pub time_ms: f64,
    /// Largest less smallest optical path over the points: the error of the integration, in mm.
    pub optical_path_spread_mm: f64,
    /// Root mean square of the fits' residuals, the worse of front and back, in mm.
    pub fit_rms_mm: f64,
    /// Mean distance, along the axis of the virtual camera, between its centre and where the rays behind the prism, drawn
    /// backwards, come nearest to the axis, in mm: Fig. 4(b) of the design paper.
    pub axis_mean_abs_mm: Option<f64>,
}

/// Tolerances of the adaptive integrator, in mm.
const TOLERANCES_MM: [f64; 4] = [1e-4, 1e-6, 1e-8, 1e-10];

/// Every integrator at every step, and every degree; none where the scene does not design its prism.
pub(super) fn all(scene: &Scene, settings: &Settings) -> Vec<Design> {
    let Prism::Freeform(prism, own) = &scene.prism else { return Vec::new() };
    let input =
        DesignInput { camera: scene.camera, prism: *prism, settings: *own, virtual_camera_z_mm: VIRTUAL_CAMERA_Z_MM };
    let pitch_um = 1e3 * scene.camera.pitch_mm;
    let mut designs = Vec::new();
    for (knob, integrator) in
        [("euler", Integrator::Euler), ("midpoint", Integrator::Midpoint), ("rk4", Integrator::Rk4)]
    {
        for &step_um in &settings.steps_um {
            let mut input = input;
            input.settings.step_px = step_um / pitch_um;
            designs.extend(one(scene, &input, integrator, knob, format!("{step_um} um"), step_um));
        }
    }
    for tolerance in TOLERANCES_MM {
        let integrator = Integrator::DormandPrince(tolerance);
        designs.extend(one(scene, &input, integrator, "dormand_prince", format!("{tolerance:.0e} mm"), tolerance));
    }
    for &degree in &settings.degrees {
        let mut input = input;
        input.settings.degree = degree;
        designs.extend(one(scene, &input, Integrator::Rk4, "degree", degree.to_string(), degree as f64));
    }
    designs
}

/// A design that exists; the others are left out.
fn one(
    scene: &Scene,
    input: &DesignInput,
    integrator: Integrator,
    knob: &'static str,
    value: String,
    number: f64,
) -> Option<Design> {
    let (time_ms, design) = timed(|| freeform_by(input, integrator));
    let design = design.ok()?;
    let mut made = scene.clone();
    made.prism = Prism::Polynomial(design.prism(input.prism.body));
    Some(Design {
        knob,
        value,
        number,
        time_ms,
        optical_path_spread_mm: design.optical_path_spread_mm,
        fit_rms_mm: design.front.rms_mm.max(design.back.rms_mm),
        axis_mean_abs_mm: axis_mean_abs_mm(&made),
    })
}

/// Over the scene's grid of rays in the right half.
fn axis_mean_abs_mm(scene: &Scene) -> Option<f64> {
    let system = system::build(scene).ok()?;
    let frame = Frame::new(&system, Half::Right);
    let axis = Ray { origin: virtual_camera(&system, &frame).ok()?.centre_mm(), direction: DVec3::Z };
    let n = scene.analysis.grid;
    let place = |k: usize| (k as f64 + 0.5) / n as f64;
    let rays: Vec<Ray> = (0..n * n)
        .filter_map(|k| {
            let px = frame.full(frame.size_px * DVec2::new(place(k % n), place(k / n)));
            system.exit_ray(px).ok().map(|(ray, _)| ray)
        })
        .collect();
    axis_crossings(&rays, &axis).ok().map(|crossings| crossings.mean_abs_mm)
}
