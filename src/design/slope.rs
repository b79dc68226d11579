//! The slopes of the two freeform surfaces where one ray meets them: Eqs. 1-4 of the design paper.

use super::virtual_camera::VirtualCamera;
use glam::DVec3;
use std::fmt;

/// Smallest denominator at which a slope is still given, as a fraction of its value at normal incidence, k - 1. With the
/// cosine of the angle of incidence outside the glass the denominators are |N1| cos and |N2| cos, and |N1|, |N2| >= k - 1.
pub(super) const SMALLEST_COSINE: f64 = 1e-4;

/// Which parameter of the image plane a path of the march follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PathParameter {
    /// t = u: along a row.
    U,
    /// t = v: along a column.
    V,
}

/// Why no pair of surfaces can go on at a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Singular {
    /// The front would have to bend its ray by more than a ray at grazing incidence is bent: i . N1 reaches 0.
    FrontGrazing,
    /// The back would have to bend its ray by more than one at the critical angle: i'' . N2 reaches 0.
    BackCritical,
    /// The front has reached the pinhole or the back has reached the front: no glass is left between them.
    NoGlass,
}

impl fmt::Display for Singular {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::FrontGrazing => "the ray would graze the front surface",
            Self::BackCritical => "the ray would reach the critical angle at the back surface",
            Self::NoGlass => "the back surface would touch the front surface",
        })
    }
}

/// d(p_z)/dt and d(p'_z)/dt at the pixel (`u_mm`, `v_mm`), for `z` = [p_z, p'_z], the z of P on the ray from O and of P' on
/// the ray through O' in mm.
///
/// With the unit vectors i = a/|a|, i' = (P' - P)/|P' - P|, i'' = g/|g|, the surfaces' normals are parallel to
/// N1 = i - k i' and N2 = k i' - i''. A path on a surface is at right angles to its normal; for P = p_z a and
/// P' = O' + (p'_z - z_O') g that gives
///
/// ```text
/// d(p_z)/dt  = - p_z            (a_t . N1) / (a . N1)
/// d(p'_z)/dt = - (p'_z - z_O')  (g_t . N2) / (g . N2)
/// ```
///
/// Domain of validity: k > 1, glass between P and P', and both surfaces able to bend the ray by as much as the design
/// needs.
///
/// # Errors
/// The [`Singular`] condition at the border of that domain.
#[inline]
pub fn slope(
    camera: &VirtualCamera,
    along: PathParameter,
    u_mm: f64,
    v_mm: f64,
    z: [f64; 2],
) -> Result<[f64; 2], Singular> {
    // Find the rays before and behind the prism, and the way in the glass between them.
    let a = camera.outer_direction(u_mm, v_mm);
    let g = camera.virtual_direction(u_mm, v_mm);
    let depth = z[1] - camera.centre_mm.z;
    let through = camera.centre_mm + g * depth - a * z[0];
    if !(z[0] > 0.0 && through.z > 0.0) {
        return Err(Singular::NoGlass);
    }

    // Find the surfaces' normals by Snell's law in vector form.
    let i = a.normalize();
    let i_virtual = g.normalize();
    let k_i_glass = through * (camera.index_ratio / through.length());
    let n1 = i - k_i_glass;
    let n2 = k_i_glass - i_virtual;

    // Refuse normals that no refraction makes: N1 points against the ray and N2 along it, as long as the surfaces can
    // bend the rays.
    let smallest = SMALLEST_COSINE * (camera.index_ratio - 1.0);
    if i.dot(n1) > -smallest {
        return Err(Singular::FrontGrazing);
    }
    if i_virtual.dot(n2) < smallest {
        return Err(Singular::BackCritical);
    }

    // Find the slopes of paths at right angles to the normals; a_t = g_t = t/f along the axis of t.
    let (n1_t, n2_t) = match along {
        PathParameter::U => (n1.x, n2.x),
        PathParameter::V => (n1.y, n2.y),
    };
    let f = camera.focal_length_mm;
    Ok([-z[0] * n1_t / (f * a.dot(n1)), -depth * n2_t / (f * g.dot(n2))])
}

/// |OP| + k |PP'| - |P'O'|, in mm of outer medium: the same at every point of an exact design.
#[inline]
pub fn optical_path_mm(camera: &VirtualCamera, front_mm: DVec3, back_mm: DVec3) -> f64 {
    front_mm.length() + camera.index_ratio * (back_mm - front_mm).length() - (back_mm - camera.centre_mm).length()
}

#[cfg(test)]
mod tests {
    use super::super::virtual_camera::tests::{paper_camera, paper_prism};
    use super::super::virtual_camera::virtual_camera;
    use super::*;

    fn paper() -> VirtualCamera {
        virtual_camera(&paper_camera(), &paper_prism(), 0.0).unwrap()
    }

    #[test]
    fn the_surfaces_start_as_the_flat_prism() {
        let c = paper();
        let [front, back] = slope(&c, PathParameter::U, 0.0, 0.0, [c.front_mm.z, c.back_mm.z]).unwrap();
        // Along u the facet's point moves in x by dP_x = (p_z + (b + u) dp_z) / f, and its z by tan(alpha) times that.
        let dx = (c.front_mm.z + c.half_centre_mm * front) / c.focal_length_mm;
        assert!((front - libm::tan(c.alpha_rad) * dx).abs() < 1e-13, "{front}");
        assert!(back.abs() < 1e-13, "{back}");
        // Both surfaces are symmetric in y.
        assert_eq!(slope(&c, PathParameter::V, 0.0, 0.0, [c.front_mm.z, c.back_mm.z]).unwrap(), [-0.0, -0.0]);
    }

    #[test]
    fn a_stated_facet_angle_is_the_front_s_slope() {
        let prism = crate::scene::BiprismSpec { facet_angle_rad: Some(0.25), ..paper_prism() };
        let c = virtual_camera(&paper_camera(), &prism, 0.0).unwrap();
        let [front, _] = slope(&c, PathParameter::U, 0.0, 0.0, [c.front_mm.z, c.back_mm.z]).unwrap();
        let dx = (c.front_mm.z + c.half_centre_mm * front) / c.focal_length_mm;
        assert!((front / dx - libm::tan(0.25)).abs() < 1e-13);
    }

    #[test]
    fn the_optical_path_is_stationary_along_the_slope() {
        let c = paper();
        let (u, v, z) = (1.7, -2.1, [79.1, 87.3]);
        let path = |u: f64, v: f64, z: [f64; 2]| {
            let back = c.centre_mm + c.virtual_direction(u, v) * (z[1] - c.centre_mm.z);
            optical_path_mm(&c, c.outer_direction(u, v) * z[0], back)
        };
        let h = 1e-4;
        for (along, du, dv) in [(PathParameter::U, h, 0.0), (PathParameter::V, 0.0, h)] {
            let s = slope(&c, along, u, v, z).unwrap();
            let ahead = path(u + du, v + dv, [z[0] + h * s[0], z[1] + h * s[1]]);
            let behind = path(u - du, v - dv, [z[0] - h * s[0], z[1] - h * s[1]]);
            // Fermat's principle; rounding of 1e-14 mm over 2e-4 mm, and a third derivative times h^2 far below it.
            assert!(((ahead - behind) / (2.0 * h)).abs() < 1e-9);
        }
    }

    #[test]
    fn each_singular_condition_is_named() {
        let c = paper();
        // P on the ray of the half image's centre and P' far aside or behind.
        assert_eq!(slope(&c, PathParameter::U, 0.0, 0.0, [90.0, 87.0]), Err(Singular::NoGlass));
        assert_eq!(slope(&c, PathParameter::U, 0.0, 0.0, [-1.0, 87.0]), Err(Singular::NoGlass));
        assert_eq!(slope(&c, PathParameter::U, 0.0, 0.0, [f64::NAN, 87.0]), Err(Singular::NoGlass));
        // The limit of either surface is acos(1/k) = 47.5 deg between its two rays. A shift of O' by 8 mm (10 mm) turns the
        // ray in the glass, from P at z = 80 to P' at 87, to 48.8 (55.0) deg from +z and so 44.5 (50.7) deg from i.
        let shifted = |x| VirtualCamera { centre_mm: c.centre_mm + DVec3::new(x, 0.0, 0.0), ..c };
        assert_eq!(slope(&shifted(8.0), PathParameter::U, 0.0, 0.0, [80.0, 87.0]), Err(Singular::BackCritical));
        assert_eq!(slope(&shifted(10.0), PathParameter::U, 0.0, 0.0, [80.0, 87.0]), Err(Singular::FrontGrazing));
    }
}
