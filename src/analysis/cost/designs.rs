//! The design of the prism: integrator, step and degree, against how well its rays meet in one point.

use super::detector::true_reprojection_rms_px;
use super::settings::CostSettings;
use super::time::{Spread, Taken};
use crate::analysis::half_image::{HalfFrame, virtual_camera};
use crate::analysis::truth;
use crate::design::{DesignInput, FreeformDesign, VIRTUAL_CAMERA_Z_MM, freeform_by};
use crate::geom::Ray;
use crate::metrics::ray_bundle::axis_crossings;
use crate::num::ode::Integrator;
use crate::scene::{PrismSpec, Scene};
use crate::system::aim::Aimer;
use crate::system::{self, System};
use crate::vision::half::Half;
use glam::{DVec2, DVec3};

/// One design.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct DesignSetting {
    /// What was turned: the integrator's name, or the degree.
    pub knob: &'static str,
    /// To what, in words.
    pub value: String,
    /// To what, as a number: the step in um on the sensor, the tolerance in mm, or the degree.
    pub number: f64,
    /// CPU time of the design with its fit, in ms.
    pub time_ms: Spread,
    /// The same, over that of the yardstick at one ray a pixel of the scene's picture.
    pub yardsticks: Spread,
    /// Points of the integration.
    pub points: usize,
    /// Largest less smallest optical path over the points: the error of the integration, in mm.
    pub optical_path_spread_mm: f64,
    /// Root mean square of the fits' residuals, the worse of front and back, in mm.
    pub fit_rms_mm: f64,
    /// Mean distance, along the axis of the virtual camera, between its centre and where the rays behind the prism, drawn
    /// backwards, come nearest to the axis, in mm: Fig. 4(b) of the design paper.
    pub axis_mean_abs_mm: Option<f64>,
    /// RMS distance of the board's corners, at their exact positions in the right half, from where the designed virtual
    /// camera sees them, in px.
    pub reprojection_rms_px: Option<f64>,
}

/// Tolerances of the adaptive integrator, in mm.
const TOLERANCES_MM: [f64; 4] = [1e-3, 1e-6, 1e-9, 1e-12];

/// A design of the study.
#[derive(Debug, Clone)]
pub(super) struct DesignPlan {
    knob: &'static str,
    value: String,
    number: f64,
    input: DesignInput,
    integrator: Integrator,
}

/// Every integrator at every step, and every degree; none where the scene does not design its prism.
pub(super) fn all(scene: &Scene, settings: &CostSettings) -> Vec<DesignPlan> {
    let PrismSpec::Freeform(prism, own) = &scene.prism else { return Vec::new() };
    let input =
        DesignInput { camera: scene.camera, prism: *prism, settings: *own, virtual_camera_z_mm: VIRTUAL_CAMERA_Z_MM };
    let pitch_um = 1e3 * scene.camera.pitch_mm;
    let mut plans = Vec::new();
    for (knob, integrator) in
        [("euler", Integrator::Euler), ("midpoint", Integrator::Midpoint), ("rk4", Integrator::Rk4)]
    {
        for &step_um in &settings.steps_um {
            let mut input = input;
            input.settings.step_px = step_um / pitch_um;
            plans.push(DesignPlan { knob, value: format!("{step_um} um"), number: step_um, input, integrator });
        }
    }
    // From point to point of the coarsest grid the adaptive pair chooses its own steps.
    let coarsest = settings.steps_um.iter().copied().fold(0.0, f64::max);
    for tolerance in TOLERANCES_MM {
        let mut input = input;
        input.settings.step_px = coarsest / pitch_um;
        let integrator = Integrator::DormandPrince(tolerance);
        let value = format!("{tolerance:.0e} mm");
        plans.push(DesignPlan { knob: "dormand_prince", value, number: tolerance, input, integrator });
    }
    for &degree in &settings.degrees {
        let mut input = input;
        input.settings.degree = degree;
        let (value, number) = (degree.to_string(), degree as f64);
        plans.push(DesignPlan { knob: "degree", value, number, input, integrator: Integrator::Rk4 });
    }
    plans
}

impl DesignPlan {
    /// Computes the design; `None` of a prism that does not exist.
    pub(super) fn make(&self) -> Option<FreeformDesign> {
        freeform_by(&self.input, self.integrator).ok()
    }

    /// What the design costs, given the times of [`DesignPlan::make`], and how good it is; `None` where there is none.
    pub(super) fn judged(&self, scene: &Scene, taken: &Taken) -> Option<DesignSetting> {
        let design = self.make()?;
        let mut made = scene.clone();
        made.prism = PrismSpec::Polynomial(design.prism(self.input.prism.body));
        let system = system::build(&made).ok()?;
        let frame = HalfFrame::new(&system, Half::Right);
        let corners = truth::corners(&system, &Aimer::new(&system), &frame)?;
        Some(DesignSetting {
            knob: self.knob,
            value: self.value.clone(),
            number: self.number,
            time_ms: taken.spread_ms(1.0),
            yardsticks: taken.in_yardsticks((scene.camera.width_px * scene.camera.height_px) as f64),
            points: design.cloud.len(),
            optical_path_spread_mm: design.optical_path_spread_mm,
            fit_rms_mm: design.front.rms_mm.max(design.back.rms_mm),
            axis_mean_abs_mm: axis_mean_abs_mm(&system, &frame, scene.analysis.grid),
            reprojection_rms_px: true_reprojection_rms_px(&system, &frame, &corners),
        })
    }
}

/// Over a grid of `n` x `n` rays in the half.
fn axis_mean_abs_mm(system: &System, frame: &HalfFrame, n: usize) -> Option<f64> {
    let axis = Ray { origin: virtual_camera(system, frame).ok()?.centre_mm(), direction: DVec3::Z };
    let place = |k: usize| (k as f64 + 0.5) / n as f64;
    let rays: Vec<Ray> = (0..n * n)
        .filter_map(|k| {
            let px = frame.full(frame.size_px * DVec2::new(place(k % n), place(k / n)));
            system.exit_ray(px).ok().map(|(ray, _)| ray)
        })
        .collect();
    axis_crossings(&rays, &axis).ok().map(|crossings| crossings.mean_abs_mm)
}
