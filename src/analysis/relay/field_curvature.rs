//! Field curvature: where the neighbours of a chief ray meet it, over the field.

use super::pencil::Pencil;
use crate::geom::{Pose, Ray};
use crate::optics::fate::Fate;
use crate::prism::payload::{Payload, RefractionEvent};
use crate::prism::surface_modifier::SurfaceModifier;
use glam::{DMat3, DVec2, DVec3};

/// The wave front about a ray: its curvature across the ray, a symmetric map W with W d = 0, in 1/mm; a wave that spreads from a point
/// L before has 1/L.
///
/// Coddington's equations for any surface and any ray: with the unit normal n along the light and the surface's curvature C across
/// n, n1 W1 + (n1 cos1 - n2 cos2) C = n2 W2 for all pairs of tangents of the surface (D. G. Burkhard, D. L. Shealy, "Simplified
/// formula for the illuminance in an optical system", Applied Optics 20, 1981, 897).
#[derive(Debug, Clone, Copy, PartialEq)]
struct WaveFront {
    /// None at the source, where it is a point.
    curvature: Option<DMat3>,
}

impl Payload for WaveFront {
    fn refracted(&mut self, event: &RefractionEvent<'_, impl SurfaceModifier>) {
        let &RefractionEvent { ray, surface, modifier, hit, eta, out } = event;

        // Carry the wave front to the surface.
        let across = DMat3::IDENTITY - outer(ray.direction, ray.direction);
        let before = match self.curvature {
            None => across * (1.0 / hit.t_mm),
            Some(w) => w * (DMat3::IDENTITY + w * hit.t_mm).inverse(),
        };

        // Refract it, by two tangents of the surface whose parts across the ray behind it are unit vectors.
        let [e, f] = perpendicular(out.direction);
        let tangents = [e, f].map(|v| v - out.direction * (v.dot(out.normal) / out.direction.dot(out.normal)));
        let point = ray.at(hit.t_mm);
        let turns = tangents.map(|t| modifier.normal_change(surface, hit, point, out.normal, t));
        let power = eta * out.cos_in - out.cos_out;
        let form = |i: usize, j: usize| {
            let bend = 0.5 * (turns[i].dot(tangents[j]) + turns[j].dot(tangents[i]));
            eta * tangents[i].dot(before * tangents[j]) + power * bend
        };
        let mixed = outer(e, f) + outer(f, e);
        self.curvature = Some(outer(e, e) * form(0, 0) + mixed * form(0, 1) + outer(f, f) * form(1, 1));
    }

    fn moved(&mut self, a_from_b: &Pose) {
        if let Some(w) = &mut self.curvature {
            let turn =
                DMat3::from_cols(a_from_b.vector(DVec3::X), a_from_b.vector(DVec3::Y), a_from_b.vector(DVec3::Z));
            *w = turn * *w * turn.transpose();
        }
    }
}

fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// Two unit vectors across `direction` and each other.
fn perpendicular(direction: DVec3) -> [DVec3; 2] {
    let (e, f) = direction.any_orthonormal_pair();
    [e, f]
}

/// The foci of the neighbours of a chief ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foci {
    /// The place of the pixel from the half image's middle, in px.
    pub from_middle_px: DVec2,
    /// Angle of the chief ray to +z behind the prism, in deg.
    pub angle_deg: f64,
    /// z in the world of the foci of the fans along u and along v, where the neighbours come nearest to the chief ray, in mm. On the
    /// line v = 0 of a symmetric half these are the tangential and the sagittal focus.
    pub fans_mm: [f64; 2],
    /// z of the two focal lines, the nearer to the prism first, in mm: the foci of the principal curvatures, whichever way they lie.
    pub principal_mm: [f64; 2],
    /// Where a pinhole of the camera's focal length sees the exit ray at infinity, less the place of the pixel, in px.
    pub distortion_px: DVec2,
}

/// The foci about the ray of `pencil` through the pixel that is `from_middle_px` from the middle of the half image of a camera of the
/// focal length `focal_px`.
///
/// # Errors
/// The fate of the ray, where it does not leave the prism.
pub fn foci(pencil: &Pencil, focal_px: f64, from_middle_px: DVec2) -> Result<Foci, Fate> {
    let start = pencil.middle() + from_middle_px / focal_px;
    let (exit, wave) = wave_front(pencil, start)?;
    let fans = pencil.fans(start)?.fans;

    // A neighbour at X with the direction d + W X meets the chief ray nearest at t = -(X . W X)/(W X . W X).
    let focus = |t_mm: f64| exit.at(t_mm).z;
    let fans_mm = fans.map(|[place, _]| {
        let turn = wave * place;
        focus(-place.dot(turn) / turn.length_squared())
    });
    let [e, f] = perpendicular(exit.direction);
    let [a, b, c] = [e.dot(wave * e), e.dot(wave * f), f.dot(wave * f)];
    let (middle, spread) = (0.5 * (a + c), libm::hypot(0.5 * (a - c), b));
    let mut principal_mm = [middle + spread, middle - spread].map(|w| focus(-1.0 / w));
    principal_mm.sort_by(|x, y| y.total_cmp(x));

    let tangents = exit.direction.truncate() / exit.direction.z;
    Ok(Foci {
        from_middle_px,
        angle_deg: libm::atan(tangents.length()).to_degrees(),
        fans_mm,
        principal_mm,
        distortion_px: tangents * focal_px - from_middle_px,
    })
}

/// The exit ray and the curvature of its wave front there.
fn wave_front(pencil: &Pencil, start: DVec2) -> Result<(Ray, DMat3), Fate> {
    let mut wave = WaveFront { curvature: None };
    let exit = pencil.passed(start, &mut wave)?;
    wave.curvature.map(|w| (exit, w)).ok_or(Fate::Missed)
}
