//! What the surfaces of the glass reflect is missing behind it.

use super::coating::Coating;
use super::journey::LightPath;
use crate::optics::fresnel::Interface;
use crate::optics::polarisation::{Beam, PolarisationState};

/// Fresnel's loss at every surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fresnel {
    /// Which light counts.
    pub light: PolarisationState,
}

impl Fresnel {
    /// The share of the light that all surfaces on the way let through. The field is carried from surface to surface, each
    /// with its own plane of incidence; light runs the other way, which changes nothing (reciprocity: Born & Wolf, 1.5.2,
    /// and the matrix of a lossless layer has the same transmittance from both sides).
    pub fn throughput(&self, journey: &LightPath, coating: Option<&Coating>) -> f64 {
        let Some(first) = journey.crossings.first() else { return 1.0 };
        let start = Beam::new(first.incoming, self.light);
        let mut beam = start;
        for (k, crossing) in journey.crossings.iter().enumerate() {
            let interface = match coating {
                Some(coating) => coating.interface(crossing.eta, k > 0),
                None => Interface::bare(crossing.eta, 1.0),
            };
            if interface.is_absent() {
                continue;
            }
            beam = beam.through(&interface, crossing.normal, crossing.incoming, crossing.outgoing);
        }
        beam.power() / start.power()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::fresnel::Layer;
    use crate::optics::refraction::Refraction;
    use crate::optics::snell::refract;
    use glam::DVec3;

    /// A ray through a plate, its normal at `degrees` in the plane y = 0.
    fn plate(degrees: f64, n: f64) -> [Refraction; 2] {
        let incoming = DVec3::Z;
        let (sin, cos) = libm::sincos(degrees.to_radians());
        let normal = DVec3::new(sin, 0.0, -cos);
        let crossing = |incoming, eta, way_mm| {
            let out = refract(incoming, normal, eta).expect("no total reflection in a plate");
            let (cos_in, cos_out) = (out.cos_in, out.cos_out);
            Refraction { incoming, outgoing: out.direction, normal: out.normal, cos_in, cos_out, eta, way_mm }
        };
        let first = crossing(incoming, 1.0 / n, 80.0);
        [first, crossing(first.outgoing, n, 8.0)]
    }

    fn throughput(degrees: f64, light: PolarisationState, coating: Option<&Coating>) -> f64 {
        let crossings = plate(degrees, 1.48);
        Fresnel { light }.throughput(&LightPath { image_cos: 1.0, crossings: &crossings, landing: None }, coating)
    }

    #[test]
    fn a_plate_met_straight_lets_its_closed_form_through() {
        let r = 0.48 / 2.48;
        for light in [PolarisationState::Unpolarised, PolarisationState::X, PolarisationState::Y] {
            assert!((throughput(0.0, light, None) - (1.0 - r * r) * (1.0 - r * r)).abs() < 1e-15);
        }
    }

    /// At Brewster's angle all of p goes through both surfaces: a pile of plates is a polariser.
    #[test]
    fn at_brewsters_angle_p_is_not_lost() {
        let degrees = libm::atan(1.48).to_degrees();
        assert!((throughput(degrees, PolarisationState::X, None) - 1.0).abs() < 1e-14);
        let r = (1.0 - 1.48 * 1.48) / (1.0 + 1.48 * 1.48);
        let s: f64 = (1.0 - r * r) * (1.0 - r * r);
        assert!((throughput(degrees, PolarisationState::Y, None) - s).abs() < 1e-14);
        // Unpolarised light is the mean of both over the whole way, not surface by surface.
        assert!((throughput(degrees, PolarisationState::Unpolarised, None) - 0.5 * (1.0 + s)).abs() < 1e-14);
    }

    #[test]
    fn a_quarter_wave_of_the_geometric_mean_loses_nothing() {
        let layer = Layer::quarter_wave(1.48f64.sqrt(), 550.0);
        let coating = Coating { layer, outer_index: 1.0, wavelength_nm: 550.0 };
        assert!((throughput(0.0, PolarisationState::Unpolarised, Some(&coating)) - 1.0).abs() < 1e-14);
        let thin = Coating { layer: Layer { thickness_nm: 0.0, ..layer }, ..coating };
        assert!(
            (throughput(40.0, PolarisationState::Y, Some(&thin)) - throughput(40.0, PolarisationState::Y, None)).abs()
                < 1e-15
        );
    }

    #[test]
    fn without_glass_nothing_is_lost() {
        let none = LightPath { image_cos: 1.0, crossings: &[], landing: None };
        let air = plate(30.0, 1.0);
        let air = LightPath { crossings: &air, ..none };
        for journey in [none, air] {
            assert_eq!(Fresnel { light: PolarisationState::Unpolarised }.throughput(&journey, None), 1.0);
        }
    }
}
