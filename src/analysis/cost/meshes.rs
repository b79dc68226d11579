//! The prism as triangles: what a renderer of meshes pays and loses.

use super::corners::{Mark, ReferenceCorners};
use super::detector::rms_px;
use super::settings::CostSettings;
use super::shifts::{Shifts, shift_px};
use super::time::{Spread, Taken, cpu_ms};
use crate::analysis::half_image::{HalfFrame, virtual_camera};
use crate::surface::mesh::Normals;
use crate::system::tessellated::Tessellated;
use crate::system::{Side, System};
use crate::vision::half::Half;
use glam::DVec2;

/// A tessellation of the right side of the prism.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Meshed {
    /// Triangles of front and back together.
    pub triangles: usize,
    /// Which normals refract: `flat` or `smooth`.
    pub normals: &'static str,
    /// CPU time to tessellate and to build the hierarchies, in ms, taken once.
    pub build_ms: f64,
    /// CPU time of one ray a pixel, over both halves, in ms: from a sample of pixels.
    pub time_ms: Spread,
    /// The same, over that of the yardstick at one ray a pixel.
    pub yardsticks: Spread,
    /// Shifts of the corners in the right half; `None` where some ray is lost.
    pub corners_px: Option<Shifts>,
    /// RMS distance of the corners in the right half from where the designed virtual camera sees them, in px.
    pub reprojection_rms_px: Option<f64>,
    /// Rays of the sample that met no triangle.
    pub lost: usize,
}

/// Pixels along each side of the sample that is timed.
const SAMPLE: usize = 128;

/// A mesh to be studied.
#[derive(Debug)]
pub(super) struct MeshSetting<'a> {
    system: &'a System,
    tessellated: Tessellated<'a>,
    normals: Normals,
    build_ms: f64,
}

/// Every tessellation, with flat and with smooth normals; none without a prism.
pub(super) fn all<'a>(system: &'a System, settings: &CostSettings) -> Vec<MeshSetting<'a>> {
    let kinds = [Normals::Flat, Normals::Smooth];
    let sizes = settings.triangles.iter().flat_map(|&n| kinds.map(|normals| (n, normals)));
    let mesh = |(n, normals)| {
        let (build_ms, tessellated) = cpu_ms(|| Tessellated::new(system, n, normals));
        Some(MeshSetting { system, tessellated: tessellated?, normals, build_ms })
    };
    sizes.filter_map(mesh).collect()
}

impl MeshSetting<'_> {
    /// Traces the sample; returns how many of its rays are lost.
    pub(super) fn trace(&self) -> usize {
        let [width, height] = self.system.camera().size_px().map(|n| n as f64);
        let at = |k: usize| {
            let place = DVec2::new((k % SAMPLE) as f64 + 0.5, (k / SAMPLE) as f64 + 0.5) / SAMPLE as f64;
            DVec2::new(0.5 * width * (1.0 + place.x), height * place.y)
        };
        (0..SAMPLE * SAMPLE).filter(|&k| self.tessellated.trace(at(k)).is_err()).count()
    }

    /// What it costs, given the times of [`MeshSetting::trace`], and what it loses.
    pub(super) fn judged(&self, corners: &ReferenceCorners, taken: &Taken) -> Meshed {
        let [width, height] = self.system.camera().size_px();
        let pixels = (width * height) as f64;
        let seen = |m: &Mark| self.tessellated.trace(m.px).ok();
        let right: Vec<&Mark> = corners.marks.iter().filter(|m| m.side == Side::Right).collect();
        let shifts = right.iter().map(|m| Some(shift_px(m.jacobian, seen(m)? - m.board_mm)));
        let frame = HalfFrame::new(self.system, Half::Right);
        let residuals = |camera: crate::metrics::pinhole::Pinhole| {
            let residual = |m: &&Mark| {
                // Where the mesh shows the corner, to first order.
                let px = m.px - m.jacobian.inverse() * (seen(m)? - m.board_mm);
                Some(
                    frame.rectified(self.system.camera(), frame.own(px))
                        - camera.project(self.system.board().world(m.board_mm))?,
                )
            };
            right.iter().map(residual).collect::<Option<Vec<DVec2>>>()
        };
        Meshed {
            triangles: self.tessellated.triangles(),
            normals: match self.normals {
                Normals::Flat => "flat",
                Normals::Smooth => "smooth",
            },
            build_ms: self.build_ms,
            time_ms: taken.spread_ms(pixels / (SAMPLE * SAMPLE) as f64),
            yardsticks: taken.in_yardsticks((SAMPLE * SAMPLE) as f64),
            corners_px: shifts.collect::<Option<Vec<f64>>>().and_then(|s| Shifts::of(&s)),
            reprojection_rms_px: virtual_camera(self.system, &frame).ok().and_then(residuals).and_then(|r| rms_px(&r)),
            lost: self.trace(),
        }
    }
}
