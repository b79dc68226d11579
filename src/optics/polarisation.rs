//! Polarised light along a ray: two incoherent fields, each a complex vector across the ray.
//!
//! Unpolarised light is two fields of half the power across each other; every surface acts on both, with the plane of
//! incidence that it has there. So no average is taken before the end, and the planes of incidence of several surfaces
//! need not agree.

use super::fresnel::{Amplitudes, Interface, Polarisation};
use glam::DVec3;
use nalgebra::Complex;

/// Light of a known power along a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    /// Real and imaginary parts of the two fields; the power is the sum of their squares.
    fields: [[DVec3; 2]; 2],
}

/// Which light counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PolarisationState {
    /// All of it.
    Unpolarised,
    /// What a polariser in front of the lens lets through, its electric field along the image's x, less its part along the
    /// ray.
    X,
    /// Along the image's y, turned onto the ray likewise.
    Y,
}

/// What a surface makes of a beam: the two beams and the power of each.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Split {
    /// Sent back.
    pub reflected: Beam,
    /// Let through; of no power where the reflection is total.
    pub transmitted: Beam,
}

impl Beam {
    /// Light of power 1 along the unit vector `direction`.
    pub fn new(direction: DVec3, light: PolarisationState) -> Self {
        // The axes of the image, turned onto the ray: each loses its part along the ray. On an oblique ray they are not
        // across each other any more, so that unpolarised light is taken along x and across both.
        let onto = |axis: DVec3| (axis - direction * direction.dot(axis)).try_normalize().unwrap_or(DVec3::Z);
        let x = onto(DVec3::X);
        let fields = match light {
            PolarisationState::Unpolarised => [x * 0.5f64.sqrt(), direction.cross(x) * 0.5f64.sqrt()],
            PolarisationState::X => [x, DVec3::ZERO],
            PolarisationState::Y => [onto(DVec3::Y), DVec3::ZERO],
        };
        Self { fields: fields.map(|field| [field, DVec3::ZERO]) }
    }

    /// Its power.
    pub fn power(&self) -> f64 {
        self.fields.iter().flatten().map(|part| part.length_squared()).sum()
    }

    /// The beam with its power times `share`.
    #[must_use]
    pub fn dimmed(&self, share: f64) -> Self {
        let root = share.sqrt();
        Self { fields: self.fields.map(|field| field.map(|part| part * root)) }
    }

    /// The beam seen from a turned frame.
    #[must_use]
    pub fn turned(&self, turn: impl Fn(DVec3) -> DVec3) -> Self {
        Self { fields: self.fields.map(|field| field.map(&turn)) }
    }

    /// The two beams behind a surface of unit normal `normal`, met along `incoming` and left along `reflected` and, where
    /// there is such a ray, `refracted`; all are unit vectors.
    pub fn split(
        &self,
        interface: &Interface,
        normal: DVec3,
        incoming: DVec3,
        reflected: DVec3,
        refracted: Option<DVec3>,
    ) -> Split {
        let [s, p] = amplitudes(interface, normal, incoming, refracted);
        let across = across(incoming, normal);
        let frame = PolarisationFrame { across, p_in: across.cross(incoming) };
        let transmitted = match refracted {
            Some(refracted) => self.sent([s.transmitted, p.transmitted], &frame, across.cross(refracted)),
            None => Self { fields: [[DVec3::ZERO; 2]; 2] },
        };
        Split { reflected: self.sent([s.reflected, p.reflected], &frame, across.cross(reflected)), transmitted }
    }

    /// What is let through of [`Beam::split`].
    #[must_use]
    pub fn through(&self, interface: &Interface, normal: DVec3, incoming: DVec3, refracted: DVec3) -> Self {
        let [s, p] = amplitudes(interface, normal, incoming, Some(refracted));
        let across = across(incoming, normal);
        let frame = PolarisationFrame { across, p_in: across.cross(incoming) };
        self.sent([s.transmitted, p.transmitted], &frame, across.cross(refracted))
    }

    /// The fields times the amplitudes of s and p, the latter along `p_out` afterwards.
    fn sent(&self, [s, p]: [Complex<f64>; 2], frame: &PolarisationFrame, p_out: DVec3) -> Self {
        let field = |field: &[DVec3; 2]| {
            let along = |axis: DVec3| Complex::new(field[0].dot(axis), field[1].dot(axis));
            let (s, p) = (along(frame.across) * s, along(frame.p_in) * p);
            [frame.across * s.re + p_out * p.re, frame.across * s.im + p_out * p.im]
        };
        Self { fields: [field(&self.fields[0]), field(&self.fields[1])] }
    }
}

/// The directions of s and p of light that comes in.
struct PolarisationFrame {
    across: DVec3,
    p_in: DVec3,
}

fn amplitudes(interface: &Interface, normal: DVec3, incoming: DVec3, refracted: Option<DVec3>) -> [Amplitudes; 2] {
    let cos_in = normal.dot(incoming).abs().min(1.0);
    let cos_out = refracted.map(|refracted| normal.dot(refracted).abs().min(1.0));
    [Polarisation::S, Polarisation::P].map(|of| interface.amplitudes(of, cos_in, cos_out))
}

/// The unit vector across the plane of incidence; along the normal, where there is no such plane, any one across the ray.
fn across(incoming: DVec3, normal: DVec3) -> DVec3 {
    let cross = incoming.cross(normal);
    // Taken twice, it is across the ray to the last digits, however small the angle.
    let once = cross.try_normalize().unwrap_or_else(|| incoming.any_orthonormal_vector());
    (once - incoming * once.dot(incoming)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::snell::refract;
    use proptest::prelude::*;

    fn mirrored(incoming: DVec3, normal: DVec3) -> DVec3 {
        incoming - normal * (2.0 * incoming.dot(normal))
    }

    fn split(beam: &Beam, interface: &Interface, incoming: DVec3, normal: DVec3) -> Split {
        let refracted = refract(incoming, normal, interface.n_in / interface.n_out).map(|r| r.direction);
        beam.split(interface, normal, incoming, mirrored(incoming, normal), refracted)
    }

    /// A polariser's field is its axis less the part along the ray: in the plane of both, and across the ray.
    #[test]
    fn both_axes_of_the_image_are_turned_onto_the_ray_alike() {
        let direction = DVec3::new(0.3, -0.4, 0.8).normalize();
        for (light, axis) in [(PolarisationState::X, DVec3::X), (PolarisationState::Y, DVec3::Y)] {
            let [field, _] = Beam::new(direction, light).fields[0];
            assert!(field.dot(direction).abs() < 1e-15 && field.dot(direction.cross(axis)).abs() < 1e-15, "{field}");
            assert!(field.dot(axis) > 0.0 && (field.length() - 1.0).abs() < 1e-15, "{field}");
        }
    }

    #[test]
    fn unpolarised_light_is_the_mean_of_both() {
        let (incoming, normal) = (DVec3::new(0.3, -0.5, 0.8).normalize(), DVec3::new(-0.2, 0.1, 1.0).normalize());
        let interface = Interface::bare(1.0, 1.48);
        let parts = split(&Beam::new(incoming, PolarisationState::Unpolarised), &interface, incoming, normal);
        let mean = interface.unpolarised(incoming.dot(normal));
        assert!((parts.reflected.power() - mean.reflected).abs() < 1e-15);
        assert!((parts.transmitted.power() - mean.transmitted).abs() < 1e-15);
    }

    /// In the plane y = 0 the field along y is s and the field along x is p.
    #[test]
    fn the_axes_of_the_image_are_s_and_p_in_the_middle_row() {
        let (incoming, normal) = (DVec3::new(0.3, 0.0, 1.0).normalize(), DVec3::Z);
        let interface = Interface::bare(1.0, 1.6);
        for (light, polarisation) in [(PolarisationState::X, Polarisation::P), (PolarisationState::Y, Polarisation::S)]
        {
            let parts = split(&Beam::new(incoming, light), &interface, incoming, normal);
            let wanted = interface.shares(polarisation, incoming.z);
            assert!((parts.transmitted.power() - wanted.transmitted).abs() < 1e-15, "{light:?}");
        }
    }

    fn unit() -> impl Strategy<Value = DVec3> {
        (-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64)
            .prop_filter_map("a direction needs a length", |(x, y, z)| DVec3::new(x, y, z).try_normalize())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        /// At the critical angle, to within 32 ulp of the sine, nothing is lost either.
        #[test]
        fn power_is_kept_at_the_critical_angle(eta in 1.0001..4.0f64, ulps in -32..=32i64, azimuth in 0.0..7.0f64) {
            let sine = f64::from_bits(((1.0 / eta).to_bits() as i64 + ulps) as u64);
            let cos = ((1.0 - sine) * (1.0 + sine)).sqrt();
            let incoming = DVec3::new(sine * libm::cos(azimuth), sine * libm::sin(azimuth), cos);
            let layer = Some((crate::optics::fresnel::Layer { index: 1.38, thickness_nm: 100.0 }, 550.0));
            for interface in [Interface::bare(eta, 1.0), Interface { n_in: eta, n_out: 1.0, layer }] {
                let parts = split(&Beam::new(incoming, PolarisationState::Unpolarised), &interface, incoming, DVec3::Z);
                let sum = parts.reflected.power() + parts.transmitted.power();
                prop_assert!((sum - 1.0).abs() < 1e-14, "{sum}");
            }
        }

        /// Near the normal there is hardly a plane of incidence, and the fields stay across their rays.
        #[test]
        fn power_is_kept_near_the_normal(normal in unit(), lean in unit(), exponent in -18.0..-6.0f64) {
            let incoming = (normal + lean * libm::pow(10.0, exponent)).normalize();
            let parts = split(&Beam::new(incoming, PolarisationState::Unpolarised), &Interface::bare(1.0, 1.5), incoming, normal);
            prop_assert!((parts.reflected.power() - 0.04).abs() < 1e-12, "{}", parts.reflected.power());
            prop_assert!((parts.transmitted.power() - 0.96).abs() < 1e-12);
            for part in parts.transmitted.fields.iter().flatten() {
                prop_assert!(part.dot(incoming).abs() < 1e-6 && part.dot(normal).abs() < 1e-5);
            }
        }

        /// No power is lost, whatever became of the beam before: through five surfaces in a row.
        #[test]
        fn power_is_kept(start in unit(), normals in prop::collection::vec(unit(), 5), n in 1.0..3.0f64, back in any::<bool>()) {
            let (mut direction, mut beam) = (start, Beam::new(start, PolarisationState::Unpolarised));
            for (k, normal) in normals.into_iter().enumerate() {
                let ratio = if k % 2 == 0 { (1.0, n) } else { (n, 1.0) };
                let interface = Interface::bare(ratio.0, ratio.1);
                let refracted = refract(direction, normal, interface.n_in / interface.n_out).map(|r| r.direction);
                let reflected = mirrored(direction, normal);
                let parts = beam.split(&interface, normal, direction, reflected, refracted);
                let sum = parts.reflected.power() + parts.transmitted.power();
                prop_assert!((sum - beam.power()).abs() < 1e-14, "{sum} of {}", beam.power());
                (direction, beam) = match refracted {
                    Some(refracted) if !back => (refracted, parts.transmitted),
                    _ => (reflected, parts.reflected),
                };
                for part in beam.fields.iter().flatten() {
                    prop_assert!(part.dot(direction).abs() < 1e-14, "a field is across its ray");
                }
            }
        }
    }
}
