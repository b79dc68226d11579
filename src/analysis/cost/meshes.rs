//! The prism as triangles: what a renderer of meshes pays and loses.

use super::corners::{Corners, Mark};
use super::time::{Spread, timed};
use super::{Settings, Shifts, shift_px};
use crate::optics::mesh::Normals;
use crate::system::mesh::Tessellated;
use crate::system::{Side, System};
use glam::DVec2;

/// A tessellation of the right side of the prism.
#[derive(Debug, Clone, PartialEq)]
pub struct Meshed {
    /// Triangles of front and back together.
    pub triangles: usize,
    /// Which normals refract.
    pub normals: Normals,
    /// Time to tessellate and to build the hierarchies, in ms.
    pub build_ms: f64,
    /// CPU time of one ray a pixel, over both halves, in ms: from a sample of pixels.
    pub time_ms: Spread,
    /// Shifts of the corners in the right half; `None` where some ray is lost.
    pub corners_px: Option<Shifts>,
    /// Rays of the sample that met no triangle.
    pub lost: usize,
}

/// Pixels along each side of the sample that is timed.
const SAMPLE: usize = 128;

/// Every tessellation, with flat and with smooth normals; none without a prism.
pub(super) fn all(system: &System, corners: &Corners, settings: &Settings) -> Vec<Meshed> {
    let kinds = [Normals::Flat, Normals::Smooth];
    let sizes = settings.triangles.iter().flat_map(|&n| kinds.map(|normals| (n, normals)));
    sizes.filter_map(|(n, normals)| one(system, corners, settings, n, normals)).collect()
}

fn one(system: &System, corners: &Corners, settings: &Settings, triangles: usize, normals: Normals) -> Option<Meshed> {
    let (build_ms, mesh) = timed(|| Tessellated::new(system, triangles, normals));
    let mesh = mesh?;
    let [width, height] = system.camera.size_px().map(|n| n as f64);
    let at = |k: usize| {
        let place = DVec2::new((k % SAMPLE) as f64 + 0.5, (k / SAMPLE) as f64 + 0.5) / SAMPLE as f64;
        DVec2::new(0.5 * width * (1.0 + place.x), height * place.y)
    };
    let mut lost = 0;
    let times: Vec<f64> = (0..settings.repetitions.max(1))
        .map(|_| {
            let (ms, missed) = timed(|| (0..SAMPLE * SAMPLE).filter(|&k| mesh.look(at(k)).is_err()).count());
            lost = missed;
            ms
        })
        .collect();
    let shift = |m: &Mark| mesh.look(m.px).ok().map(|seen| shift_px(m.jacobian, seen - m.board_mm));
    let right = corners.marks.iter().filter(|m| m.side == Side::Right);
    let shifts = right.map(shift).collect::<Option<Vec<f64>>>();
    Some(Meshed {
        triangles: mesh.triangles(),
        normals,
        build_ms,
        time_ms: Spread::of(&times).scaled(width * height / (SAMPLE * SAMPLE) as f64),
        corners_px: shifts.and_then(|s| Shifts::of(&s)),
        lost,
    })
}
