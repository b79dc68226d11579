//! The virtual camera of a half image, and the central ray from which the design starts.

use super::angle::facet_angle_rad;
use crate::error::Error;
use crate::scene::{BiprismSpec, CameraSpec};
use glam::DVec3;

/// The central ray of the right half image (x > 0) through the flat biprism, and the virtual camera O' behind it.
///
/// All points are in the prism's frame, in mm, with the camera's pinhole O at the origin. The left half is the mirror
/// image in the plane x = 0. The virtual camera looks along +z and shares the focal length and the pixel pitch of the
/// camera; the offset (u, v) of a pixel from the centre of the half image is the same in both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VirtualCamera {
    /// k = n_glass / n_outside.
    pub index_ratio: f64,
    /// f of the camera and of the virtual camera.
    pub focal_length_mm: f64,
    /// b, the offset of the half image's centre from the sensor's centre: a quarter of the sensor's width.
    pub half_centre_mm: f64,
    /// delta = atan(b / f), the central ray's angle to +z before the prism.
    pub delta_rad: f64,
    /// alpha, the facet angle.
    pub alpha_rad: f64,
    /// Q0, where the central ray enters the glass.
    pub front_mm: DVec3,
    /// Q0', where it leaves.
    pub back_mm: DVec3,
    /// O', the centre of projection.
    pub centre_mm: DVec3,
}

impl VirtualCamera {
    /// Distance between the two virtual cameras.
    pub fn baseline_mm(&self) -> f64 {
        2.0 * self.centre_mm.x
    }

    /// a(u, v) = ((b + u)/f, v/f, 1): the ray from O, scaled to z = 1, of the pixel at (`u_mm`, `v_mm`) from the
    /// half image's centre.
    #[inline(always)]
    pub fn outer_direction(&self, u_mm: f64, v_mm: f64) -> DVec3 {
        DVec3::new((self.half_centre_mm + u_mm) / self.focal_length_mm, v_mm / self.focal_length_mm, 1.0)
    }

    /// g(u, v) = (u/f, v/f, 1): the ray from O', scaled to z = 1, of the same pixel.
    #[inline(always)]
    pub fn virtual_direction(&self, u_mm: f64, v_mm: f64) -> DVec3 {
        DVec3::new(u_mm / self.focal_length_mm, v_mm / self.focal_length_mm, 1.0)
    }
}

/// The virtual camera of the right half for a flat biprism in front of `camera` (whose position is not used: the pinhole
/// is the origin of the prism's frame), with O' in the plane z = `centre_z_mm`. The paper leaves that plane open; 0, the
/// plane of O, reproduces its Table 1.
///
/// With the facet angle of Eq. 5 the central ray runs along +z in the glass and leaves the base undeviated. With another
/// angle it runs aslant, Q0' is where it meets the base plane, and the freeform back turns it to +z there, so the two
/// virtual cameras are parallel for any facet angle.
///
/// # Errors
/// A [`Error`] when no angle satisfies Eq. 5, the glass is no denser than its surroundings, a length is not positive, the
/// central ray misses the facet, or O' does not lie before the glass.
pub fn virtual_camera(camera: &CameraSpec, prism: &BiprismSpec, centre_z_mm: f64) -> Result<VirtualCamera, Error> {
    let index_ratio = index_ratio(camera, prism)?;

    // Find the central ray's angle, and the facet angle: given, or by Eq. 5.
    let half_centre_mm = camera.width_px as f64 * camera.pitch_mm / 4.0;
    let tan_delta = half_centre_mm / camera.focal_length_mm;
    let delta_rad = libm::atan(tan_delta);
    let alpha_rad = match prism.facet_angle_rad {
        Some(alpha) => alpha,
        None => facet_angle_rad(index_ratio, delta_rad)?,
    };
    check_facet_angle(alpha_rad, delta_rad)?;

    // Intersect the central ray with the facet z = D + x tan(alpha).
    let front_z = prism.ridge_distance_mm / (1.0 - tan_delta * libm::tan(alpha_rad));
    let front_mm = DVec3::new(front_z * tan_delta, 0.0, front_z);
    let base_z = prism.ridge_distance_mm + prism.thickness_mm;
    if front_z >= base_z {
        return Err(Error::new(
            "the prism",
            format!(
                "`prism.thickness_mm` is {}, and must be above {:.6}: the facet meets the base before the half image's \
                 central ray",
                prism.thickness_mm,
                front_z - prism.ridge_distance_mm
            ),
            "use a thicker prism or a smaller facet angle",
        ));
    }

    // Refract it, and intersect it with the base.
    let tan_in_glass = match prism.facet_angle_rad {
        None => 0.0,
        Some(_) => libm::tan(libm::asin(libm::sin(alpha_rad + delta_rad) / index_ratio) - alpha_rad),
    };
    let back_mm = DVec3::new(front_mm.x + (base_z - front_z) * tan_in_glass, 0.0, base_z);

    // Place the virtual camera on its continuation along z.
    if !(centre_z_mm.is_finite() && centre_z_mm < prism.ridge_distance_mm) {
        return Err(Error::new(
            "the prism",
            format!(
                "the virtual camera's z is {centre_z_mm} mm, and must be below `prism.ridge_distance_mm` = {}",
                prism.ridge_distance_mm
            ),
            "use 0, the plane of the camera's pinhole",
        ));
    }
    Ok(VirtualCamera {
        index_ratio,
        focal_length_mm: camera.focal_length_mm,
        half_centre_mm,
        delta_rad,
        alpha_rad,
        front_mm,
        back_mm,
        centre_mm: DVec3::new(back_mm.x, 0.0, centre_z_mm),
    })
}

/// n_glass / n_outside.
fn index_ratio(camera: &CameraSpec, prism: &BiprismSpec) -> Result<f64, Error> {
    positive("the camera", "camera.focal_length_mm", camera.focal_length_mm)?;
    positive("the camera", "camera.pixel_pitch_um", camera.pitch_mm)?;
    positive("the prism", "prism.ridge_distance_mm", prism.ridge_distance_mm)?;
    positive("the prism", "prism.thickness_mm", prism.thickness_mm)?;
    positive("the prism", "prism.outer_index", prism.body.outer_index)?;
    let index_ratio = prism.body.index / prism.body.outer_index;
    if !(index_ratio.is_finite() && index_ratio > 1.0) {
        return Err(Error::new(
            "the prism",
            format!("`prism.index` / `prism.outer_index` is {index_ratio}, and must be above 1"),
            "use a glass that is denser than its surroundings",
        ));
    }
    Ok(index_ratio)
}

fn check_facet_angle(alpha_rad: f64, delta_rad: f64) -> Result<(), Error> {
    let right_angle = std::f64::consts::FRAC_PI_2;
    if !(alpha_rad.abs() < right_angle && (alpha_rad + delta_rad).abs() < right_angle) {
        return Err(Error::new(
            "the prism",
            format!(
                "`prism.facet_angle_deg` is {}, and must leave the half image's central ray (at {:.4} deg) within 90 deg \
                 of the facet's normal",
                alpha_rad.to_degrees(),
                delta_rad.to_degrees()
            ),
            "lower the facet angle, or leave it out for the angle of Eq. 5",
        ));
    }
    Ok(())
}

fn positive(place: &str, key: &str, value: f64) -> Result<(), Error> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(Error::new(place, format!("`{key}` is {value}, and must be above 0"), format!("give `{key}` a positive value")))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::scene::CalibrationSpec;
    use crate::scene::GlassSpec;

    /// The camera of the paper.
    pub(in crate::design) fn paper_camera() -> CameraSpec {
        CameraSpec {
            position_mm: DVec3::ZERO,
            focal_length_mm: 35.0,
            width_px: 1920,
            height_px: 1080,
            pitch_mm: 0.0055,
            calibration: CalibrationSpec::default(),
        }
    }

    /// The flat prism that reproduces the flat row of the paper's Table 1.
    pub(in crate::design) fn paper_prism() -> BiprismSpec {
        BiprismSpec {
            body: GlassSpec::new(1.48, 1.0),
            ridge_distance_mm: 78.472,
            thickness_mm: 8.545,
            facet_angle_rad: None,
        }
    }

    #[test]
    fn the_central_ray_meets_the_facet_and_runs_along_z() {
        let v = virtual_camera(&paper_camera(), &paper_prism(), 0.0).unwrap();
        assert!((v.half_centre_mm - 2.64).abs() < 1e-15 && (v.delta_rad.to_degrees() - 4.31357).abs() < 5e-6);
        let facet_z = 78.472 + v.front_mm.x * libm::tan(v.alpha_rad);
        assert!((v.front_mm.z - facet_z).abs() < 2e-14);
        assert!((v.front_mm.x / v.front_mm.z - 2.64 / 35.0).abs() < 1e-16);
        assert_eq!(v.back_mm, DVec3::new(v.front_mm.x, 0.0, 78.472 + 8.545));
        assert_eq!(v.centre_mm, DVec3::new(v.front_mm.x, 0.0, 0.0));
        assert_eq!(v.baseline_mm(), 2.0 * v.front_mm.x);
    }

    #[test]
    fn the_angle_of_eq_5_stated_by_hand_gives_the_same_camera() {
        let implied = virtual_camera(&paper_camera(), &paper_prism(), 0.0).unwrap();
        let prism = BiprismSpec { facet_angle_rad: Some(implied.alpha_rad), ..paper_prism() };
        let stated = virtual_camera(&paper_camera(), &prism, 0.0).unwrap();
        assert!((stated.centre_mm - implied.centre_mm).length() < 1e-14);
    }

    #[test]
    fn a_glass_in_water_is_the_glass_of_their_ratio_in_air() {
        let body = GlassSpec { index: 1.48 * 1.33, outer_index: 1.33, ..paper_prism().body };
        let water = virtual_camera(&paper_camera(), &BiprismSpec { body, ..paper_prism() }, 0.0).unwrap();
        let air = virtual_camera(&paper_camera(), &paper_prism(), 0.0).unwrap();
        assert!((water.centre_mm - air.centre_mm).length() < 1e-13);
    }

    #[test]
    fn impossible_prisms_are_problems() {
        let flat = paper_prism();
        let body = |index| GlassSpec { index, ..flat.body };
        let cases = [
            (BiprismSpec { ridge_distance_mm: 0.0, ..flat }, "ridge_distance_mm"),
            (BiprismSpec { thickness_mm: -1.0, ..flat }, "thickness_mm"),
            (BiprismSpec { thickness_mm: 0.5, ..flat }, "thickness_mm"),
            (BiprismSpec { body: body(1.0), ..flat }, "prism.index"),
            (BiprismSpec { body: body(1.001), ..flat }, "Eq. 5"),
            (BiprismSpec { facet_angle_rad: Some(1.55), ..flat }, "facet_angle_deg"),
            (BiprismSpec { facet_angle_rad: Some(f64::NAN), ..flat }, "facet_angle_deg"),
        ];
        for (prism, word) in cases {
            let problem = virtual_camera(&paper_camera(), &prism, 0.0).unwrap_err();
            assert!(problem.rule.contains(word), "{word}: {}", problem.rule);
        }
        assert!(virtual_camera(&paper_camera(), &flat, 80.0).unwrap_err().rule.contains("virtual camera"));
    }
}
