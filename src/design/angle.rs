//! The facet angle that leaves the two virtual cameras parallel (Eq. 5 of the design paper, corrected).

use crate::error::Error;
use crate::optics::snell::straightening_facet_rad;

/// The facet angle alpha, in rad, at which a ray at `delta_rad` to the z axis travels along +z inside the glass.
///
/// `index_ratio` is k = n_glass / n_outside. Snell's law at the facet, k sin(alpha) = sin(alpha + delta), solved for
/// alpha:
///
/// ```text
/// alpha = atan( sin(delta) / (k - cos(delta)) )
/// ```
///
/// The paper prints Eq. 5 with the division after the arctangent, which misses Snell's law (8.91 deg where the paper
/// itself states 8.85 deg).
///
/// Domain of validity: 0 <= delta < pi/2 and k cos(delta) > 1. The angle of incidence alpha + delta is below pi/2 exactly
/// then: at k cos(delta) = 1 the ray grazes the facet, and for cos(delta) < k below it the formula's angle belongs to a ray
/// that meets the facet from inside. (k < cos(delta) would need a negative angle: a ridge that is farthest from the
/// camera, which is no biprism in the sense of [`crate::scene::BiprismSpec`].)
///
/// # Errors
/// A [`Error`] outside the domain.
pub fn facet_angle_rad(index_ratio: f64, delta_rad: f64) -> Result<f64, Error> {
    if !(0.0..std::f64::consts::FRAC_PI_2).contains(&delta_rad) {
        return Err(Error::new(
            "the camera",
            format!("the centre of a half image is seen at {} deg, and must be within 0 .. 90", delta_rad.to_degrees()),
            "check `camera.focal_length_mm`, `camera.width_px` and `camera.pixel_pitch_um`",
        ));
    }
    straightening_facet_rad(index_ratio, delta_rad).ok_or_else(|| {
        Error::new(
            "the prism",
            format!(
                "`prism.index` / `prism.outer_index` is {index_ratio}, and must be above {:.6} for a facet angle to exist \
                 that makes the views parallel (Eq. 5)",
                1.0 / libm::cos(delta_rad)
            ),
            "use a denser glass, a longer focal length, or state `prism.facet_angle_deg`",
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// tan(delta) of the paper's camera: a quarter of 1920 px of 5.5 um at 35 mm.
    fn paper_delta() -> f64 {
        libm::atan(0.0055 * 1920.0 / 4.0 / 35.0)
    }

    #[test]
    fn the_paper_s_facet_is_8_85_degrees() {
        assert!((paper_delta().to_degrees() - 4.31357).abs() < 5e-6);
        let alpha = facet_angle_rad(1.48, paper_delta()).unwrap().to_degrees();
        assert!((alpha - 8.85428).abs() < 5e-6, "{alpha}");
    }

    #[test]
    fn a_central_ray_needs_no_angle() {
        assert_eq!(facet_angle_rad(1.5, 0.0).unwrap(), 0.0);
    }

    #[test]
    fn impossible_input_is_a_problem_that_names_the_bound() {
        let delta = paper_delta();
        for k in [0.0, -1.5, 0.5, libm::cos(delta), 1.0, 1.0 / libm::cos(delta), f64::NAN, f64::INFINITY] {
            let problem = facet_angle_rad(k, delta).unwrap_err();
            assert!(problem.rule.contains("1.0028"), "{k}: {}", problem.rule);
        }
        for delta in [-1e-9, std::f64::consts::FRAC_PI_2, 3.0, f64::NAN] {
            assert!(facet_angle_rad(1.5, delta).is_err(), "{delta}");
        }
    }

    proptest! {
        #[test]
        fn snell_s_law_holds_at_the_facet(delta in 0.0..1.2f64, above in 1e-6..1.5f64) {
            let k = (1.0 + above) / libm::cos(delta);
            let alpha = facet_angle_rad(k, delta).unwrap();
            prop_assert!(alpha + delta < std::f64::consts::FRAC_PI_2);
            // A few roundings of numbers of order k.
            prop_assert!((k * libm::sin(alpha) - libm::sin(alpha + delta)).abs() < 8.0 * k * f64::EPSILON);
        }
    }
}
