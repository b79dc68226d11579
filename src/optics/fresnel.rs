//! What a surface reflects and what it lets through: Fresnel's formulas, bare or under a single layer.
//!
//! Both are one formula. With the tilted admittances a in front of the surface and b behind it (n cos for light polarised
//! across the plane of incidence, s; cos / n for light polarised in it, p), a lossless layer of characteristic matrix
//! [[A, i beta], [i gamma, A]], A^2 + beta gamma = 1, has (Macleod, Thin-Film Optical Filters, 2.6; Born & Wolf, 1.6.2)
//!
//! ```text
//! r = (A (a - b) + i (a b beta - gamma)) / (A (a + b) + i (a b beta + gamma)),   t = 2 sqrt(a b) / (the same)
//! ```
//!
//! and no layer is A = 1, beta = gamma = 0. Here t is the amplitude whose square is the share of the power let through,
//! so that |r|^2 + |t|^2 = 1. Signs are those of r_s = -r_p at normal incidence on a bare surface in the frame of
//! [`super::polarisation`], which turns the p direction with the ray.

use nalgebra::Complex;

/// A single layer on a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layer {
    /// Its refractive index.
    pub index: f64,
    /// Its thickness, in nm.
    pub thickness_nm: f64,
}

/// A surface as light meets it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interface {
    /// Refractive index in front, where the light comes from.
    pub n_in: f64,
    /// Refractive index behind.
    pub n_out: f64,
    /// What lies between, with the wavelength in vacuum, in nm; `None` for a bare surface.
    pub layer: Option<(Layer, f64)>,
}

/// Shares of the power.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shares {
    /// Reflected.
    pub reflected: f64,
    /// Let through.
    pub transmitted: f64,
}

/// Complex amplitudes of one polarisation, of unit power coming in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Amplitudes {
    /// Reflected.
    pub reflected: Complex<f64>,
    /// Let through.
    pub transmitted: Complex<f64>,
}

/// The direction of the electric field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Polarisation {
    /// Across the plane of incidence.
    S,
    /// In the plane of incidence.
    P,
}

/// What a polarisation makes of an angle of incidence: admittances, and the layer's matrix.
struct Matching {
    /// Admittance in front.
    a: f64,
    /// Admittance behind; for total reflection it is imaginary, and this is its size.
    b: f64,
    diagonal: f64,
    beta: f64,
    gamma: f64,
}

/// Beyond this exponent of decay in a layer nothing measurable tunnels through, and cosh has no square in f64.
const OPAQUE: f64 = 300.0;

impl Interface {
    /// A bare surface.
    pub fn bare(n_in: f64, n_out: f64) -> Self {
        Self { n_in, n_out, layer: None }
    }

    /// Whether there is nothing to meet: the same medium on both sides and no layer.
    pub fn is_absent(&self) -> bool {
        self.n_in == self.n_out && self.layer.is_none_or(|(layer, _)| layer.thickness_nm == 0.0)
    }

    /// The cosine of refraction of light that comes in at `cos_in`; `None` for total reflection.
    pub fn cos_out(&self, cos_in: f64) -> Option<f64> {
        let square = self.square_of_cos_out(cos_in);
        (square >= 0.0).then(|| square.sqrt())
    }

    fn square_of_cos_out(&self, cos_in: f64) -> f64 {
        let eta = self.n_in / self.n_out;
        1.0 - eta * eta * (1.0 - cos_in * cos_in)
    }

    /// Shares of the power of one polarisation at the cosine of incidence `cos_in`, 0..=1.
    pub fn shares(&self, polarisation: Polarisation, cos_in: f64) -> Shares {
        self.shares_at(polarisation, cos_in, self.cos_out(cos_in))
    }

    /// [`Interface::shares`] where the cosine of refraction is known, as it is of a traced ray; `None` for total reflection.
    pub fn shares_at(&self, polarisation: Polarisation, cos_in: f64, cos_out: Option<f64>) -> Shares {
        let nothing = Shares { reflected: 1.0, transmitted: 0.0 };
        let Some(cos_out) = cos_out else { return nothing };
        let Some(m) = self.matching(polarisation, cos_in, cos_out) else { return nothing };
        let (difference, sum) = (m.numerator(), m.denominator());
        let all = sum.norm_sqr();
        if all == 0.0 {
            // Grazing light at a surface between equal media: it is not there.
            return Shares { reflected: 0.0, transmitted: 1.0 };
        }
        Shares { reflected: difference.norm_sqr() / all, transmitted: 4.0 * m.a * m.b / all }
    }

    /// Shares of unpolarised light at the cosine of incidence `cos_in`: the mean of both polarisations.
    pub fn unpolarised(&self, cos_in: f64) -> Shares {
        let [s, p] = [Polarisation::S, Polarisation::P].map(|polarisation| self.shares(polarisation, cos_in));
        Shares { reflected: 0.5 * (s.reflected + p.reflected), transmitted: 0.5 * (s.transmitted + p.transmitted) }
    }

    /// Amplitudes of one polarisation at the cosine of incidence `cos_in`, 0..=1, and the cosine of refraction, `None` for
    /// total reflection, whose |r| is 1.
    pub fn amplitudes(&self, polarisation: Polarisation, cos_in: f64, cos_out: Option<f64>) -> Amplitudes {
        let zero = Complex::new(0.0, 0.0);
        let mirror = Amplitudes { reflected: Complex::new(-1.0, 0.0), transmitted: zero };
        let size = cos_out.unwrap_or_else(|| self.square_of_cos_out(cos_in).min(0.0).abs().sqrt());
        let Some(m) = self.matching(polarisation, cos_in, size) else { return mirror };
        if cos_out.is_none() {
            // b is -i b: numerator and denominator are complex conjugates of each other.
            let numerator = Complex::new(m.a * (m.diagonal + m.b * m.beta), m.diagonal * m.b - m.gamma);
            let all = numerator.norm_sqr();
            return if all > 0.0 { Amplitudes { reflected: numerator * numerator / all, ..mirror } } else { mirror };
        }
        let denominator = m.denominator();
        if denominator.norm_sqr() == 0.0 {
            return Amplitudes { reflected: zero, transmitted: Complex::new(1.0, 0.0) };
        }
        Amplitudes {
            reflected: m.numerator() / denominator,
            transmitted: Complex::new(2.0 * (m.a * m.b).sqrt(), 0.0) / denominator,
        }
    }

    /// `None` where the layer lets nothing through.
    fn matching(&self, polarisation: Polarisation, cos_in: f64, cos_out: f64) -> Option<Matching> {
        let Self { n_in, n_out, layer } = *self;
        let admittance = |n: f64, cos: f64| match polarisation {
            Polarisation::S => n * cos,
            Polarisation::P => cos / n,
        };
        // Of an imaginary cosine -i c the admittance is -i n c, or -i c / n.
        let (a, b) = (admittance(n_in, cos_in), admittance(n_out, cos_out));
        let bare = Matching { a, b, diagonal: 1.0, beta: 0.0, gamma: 0.0 };
        let Some((Layer { index, thickness_nm }, wavelength_nm)) = layer else { return Some(bare) };
        // (n cos)^2 in the layer, below 0 where light only tunnels through it.
        let square = index * index - n_in * n_in * (1.0 - cos_in) * (1.0 + cos_in);
        let depth = std::f64::consts::TAU * thickness_nm / wavelength_nm;
        let phase = depth * square.abs().sqrt();
        if square < 0.0 && phase > OPAQUE {
            return None;
        }
        let (sine, diagonal) = if square < 0.0 { (libm::sinh(phase), libm::cosh(phase)) } else { libm::sincos(phase) };
        let sinc = if phase == 0.0 { 1.0 } else { sine / phase };
        // sin(phase) over the layer's admittance, and times it: both stay finite where that admittance is 0.
        let (beta, gamma) = match polarisation {
            Polarisation::S => (depth * sinc, depth * sinc * square),
            Polarisation::P => (depth * sinc * (index * index), depth * sinc * (square / (index * index))),
        };
        Some(Matching { diagonal, beta, gamma, ..bare })
    }
}

impl Matching {
    fn numerator(&self) -> Complex<f64> {
        Complex::new(self.diagonal * (self.a - self.b), self.a * self.b * self.beta - self.gamma)
    }

    fn denominator(&self) -> Complex<f64> {
        Complex::new(self.diagonal * (self.a + self.b), self.a * self.b * self.beta + self.gamma)
    }
}

impl Layer {
    /// The layer of index `index` that is a quarter of a wavelength thick at `wavelength_nm`, for light along its normal.
    pub fn quarter_wave(index: f64, wavelength_nm: f64) -> Self {
        Self { index, thickness_nm: 0.25 * wavelength_nm / index }
    }
}

/// The share of the light that is left after `length_mm` of a medium of absorption coefficient `per_mm`: Beer and
/// Lambert's law.
pub fn left_after(per_mm: f64, length_mm: f64) -> f64 {
    libm::exp(-per_mm * length_mm)
}

/// The absorption coefficient, in 1/mm, of a medium whose internal transmittance over `length_mm` is `transmittance`.
pub fn absorption_per_mm(transmittance: f64, length_mm: f64) -> f64 {
    -libm::log(transmittance) / length_mm
}

#[cfg(test)]
mod tests {
    use super::*;
    use Polarisation::{P, S};
    use proptest::prelude::*;

    #[test]
    fn along_the_normal_reflection_is_the_textbook_one() {
        for (n_in, n_out) in [(1.0, 1.48), (1.5168, 1.0), (1.0, 2.4), (1.333, 1.0)] {
            let r = (n_in - n_out) / (n_in + n_out);
            for polarisation in [S, P] {
                let s = Interface::bare(n_in, n_out).shares(polarisation, 1.0);
                // Four roundings of each share.
                assert!((s.reflected - r * r).abs() < 1e-15 && (s.transmitted - (1.0 - r * r)).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn at_brewsters_angle_p_is_not_reflected() {
        let (n_in, n_out): (f64, f64) = (1.0, 1.5);
        let cos = n_in / (n_in * n_in + n_out * n_out).sqrt();
        let interface = Interface::bare(n_in, n_out);
        assert!(interface.shares(P, cos).reflected < 1e-30);
        // For s the closed form there: r = (n_in^2 - n_out^2) / (n_in^2 + n_out^2).
        let r: f64 = (1.0 - 2.25) / 3.25;
        assert!((interface.shares(S, cos).reflected - r * r).abs() < 1e-15);
    }

    /// Born & Wolf, 1.5.2, Eqs. 20 and 21, in sines and tangents of the angles.
    #[test]
    fn oblique_reflection_is_the_sine_and_tangent_law() {
        for degrees in [5.0, 22.5, 45.0, 70.0, 89.0f64] {
            let (i, n) = (degrees.to_radians(), 1.62);
            let t = libm::asin(libm::sin(i) / n);
            let r_s = -libm::sin(i - t) / libm::sin(i + t);
            let r_p = libm::tan(i - t) / libm::tan(i + t);
            let interface = Interface::bare(1.0, n);
            let close = |a: f64, b: f64| (a - b).abs() < 1e-14;
            assert!(close(interface.shares(S, libm::cos(i)).reflected, r_s * r_s));
            assert!(close(interface.shares(P, libm::cos(i)).reflected, r_p * r_p));
            assert!(close(interface.amplitudes(S, libm::cos(i), interface.cos_out(libm::cos(i))).reflected.re, r_s));
            assert!(close(interface.amplitudes(P, libm::cos(i), interface.cos_out(libm::cos(i))).reflected.re, r_p));
        }
    }

    #[test]
    fn the_quarter_wave_layer_of_the_geometric_mean_reflects_nothing() {
        let (n_out, wavelength_nm) = (1.5168f64, 550.0);
        let matched = Layer::quarter_wave(n_out.sqrt(), wavelength_nm);
        let interface = |layer| Interface { n_in: 1.0, n_out, layer: Some((layer, wavelength_nm)) };
        assert!(interface(matched).unpolarised(1.0).reflected < 1e-30);
        // MgF2: R = ((n_in n_out - n^2) / (n_in n_out + n^2))^2.
        let index = 1.38f64;
        let r = (n_out - index * index) / (n_out + index * index);
        let mgf2 = interface(Layer::quarter_wave(index, wavelength_nm));
        assert!((mgf2.unpolarised(1.0).reflected - r * r).abs() < 1e-15);
        // Half a wave is as if absent.
        let half = interface(Layer { index, thickness_nm: 0.5 * wavelength_nm / index });
        let bare = Interface::bare(1.0, n_out).unpolarised(1.0).reflected;
        assert!((half.unpolarised(1.0).reflected - bare).abs() < 1e-15);
    }

    /// Airy's sum over the reflections inside the layer, independent of the matrix (Born & Wolf, 1.6.4, Eq. 60).
    #[test]
    fn a_layer_is_the_sum_of_its_inner_reflections() {
        let (layer, wavelength_nm) = (Layer { index: 1.38, thickness_nm: 143.0 }, 486.1);
        for cos_in in [1.0, 0.9, 0.5, 0.1f64] {
            for polarisation in [S, P] {
                let whole = Interface { n_in: 1.0, n_out: 1.7, layer: Some((layer, wavelength_nm)) };
                let cos_layer = (1.0f64 - (1.0 - cos_in * cos_in) / (1.38 * 1.38)).sqrt();
                let amplitude = |interface: Interface, cos: f64| {
                    interface.amplitudes(polarisation, cos, interface.cos_out(cos)).reflected
                };
                let r12 = amplitude(Interface::bare(1.0, 1.38), cos_in);
                let r23 = amplitude(Interface::bare(1.38, 1.7), cos_layer);
                let turn = -2.0 * std::f64::consts::TAU * 1.38 * 143.0 * cos_layer / wavelength_nm;
                let turn = Complex::new(libm::cos(turn), libm::sin(turn));
                let sum = (r12 + r23 * turn) / (r12 * r23 * turn + 1.0);
                assert!((amplitude(whole, cos_in) - sum).norm_sqr() < 1e-28);
                assert!((whole.shares(polarisation, cos_in).reflected - sum.norm_sqr()).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn no_thickness_is_no_layer_to_the_last_bit() {
        for k in 0..=1000 {
            let cos_in = f64::from(k) / 1000.0;
            for (n_in, n_out) in [(1.0, 1.48), (1.48, 1.0)] {
                let layer = Layer { index: 1.38, thickness_nm: 0.0 };
                let coated = Interface { n_in, n_out, layer: Some((layer, 550.0)) };
                for polarisation in [S, P] {
                    let bare = Interface::bare(n_in, n_out);
                    assert_eq!(coated.shares(polarisation, cos_in), bare.shares(polarisation, cos_in));
                    let cos_out = bare.cos_out(cos_in);
                    let [a, b] = [coated, bare].map(|i| i.amplitudes(polarisation, cos_in, cos_out));
                    assert_eq!(a, b);
                }
            }
        }
    }

    /// Light tunnels through a thin gap: at 45 degrees between two prisms of 1.5 with an air gap (Born & Wolf, 1.6.4).
    #[test]
    fn light_tunnels_through_a_thin_gap_only() {
        let gap = |thickness_nm| {
            let layer = Some((Layer { index: 1.0, thickness_nm }, 500.0));
            Interface { n_in: 1.5, n_out: 1.5, layer }.shares(S, 0.5f64.sqrt())
        };
        assert!(gap(0.0).transmitted == 1.0);
        assert!(gap(50.0).transmitted > 0.5 && gap(1000.0).transmitted < 1e-3);
        assert_eq!(gap(1e9), Shares { reflected: 1.0, transmitted: 0.0 });
        // T = 1 / (1 + F sinh^2), F = ((a^2 + k^2) / (2 a k))^2 with a = n cos, k = sqrt(n^2 sin^2 - 1).
        let (a2, k2) = (1.125, 0.125f64);
        let sinh = libm::sinh(std::f64::consts::TAU * 200.0 / 500.0 * k2.sqrt());
        let expected = 1.0 / (1.0 + (a2 + k2) * (a2 + k2) / (4.0 * a2 * k2) * sinh * sinh);
        assert!((gap(200.0).transmitted - expected).abs() < 1e-14);
    }

    /// Phases of total reflection (Born & Wolf, 1.5.4, Eq. 60), and under a layer Airy's sum over its inner reflections.
    #[test]
    fn total_reflection_turns_the_phase_by_its_closed_form() {
        let (n, cos_in) = (1.5f64, 0.5f64);
        let sine2 = 0.75;
        let root = (sine2 - 1.0 / (n * n)).sqrt();
        let bare = Interface::bare(n, 1.0);
        for (polarisation, tangent) in [(S, root / cos_in), (P, n * n * root / cos_in)] {
            let r = bare.amplitudes(polarisation, cos_in, None).reflected;
            let angle = 2.0 * libm::atan(tangent);
            assert!((r - Complex::new(libm::cos(angle), libm::sin(angle))).norm_sqr() < 1e-28, "{r}");
        }
        let (layer, wavelength_nm) = (Layer { index: 1.38, thickness_nm: 143.0 }, 486.1);
        let coated = Interface { n_in: n, n_out: 1.0, layer: Some((layer, wavelength_nm)) };
        let cos_layer = (1.0 - sine2 * n * n / (1.38 * 1.38)).sqrt();
        let turn = -2.0 * std::f64::consts::TAU * 1.38 * 143.0 * cos_layer / wavelength_nm;
        let turn = Complex::new(libm::cos(turn), libm::sin(turn));
        for polarisation in [S, P] {
            let r12 = Interface::bare(n, 1.38).amplitudes(polarisation, cos_in, Some(cos_layer)).reflected;
            let r23 = Interface::bare(1.38, 1.0).amplitudes(polarisation, cos_layer, None).reflected;
            let sum = (r12 + r23 * turn) / (r12 * r23 * turn + 1.0);
            assert!((coated.amplitudes(polarisation, cos_in, None).reflected - sum).norm_sqr() < 1e-28);
        }
    }

    #[test]
    fn absorption_undoes_itself() {
        let per_mm = absorption_per_mm(0.98, 10.0);
        assert!((left_after(per_mm, 10.0) - 0.98).abs() < 1e-15);
        assert!((left_after(per_mm, 25.0) - libm::pow(0.98, 2.5)).abs() < 1e-15);
        assert_eq!(left_after(0.0, 1e9), 1.0);
        assert_eq!(absorption_per_mm(1.0, 10.0), 0.0);
    }

    /// Cosines from 0 to 1, a third of them within 1e-16 ..= 1e-3 of grazing or of the critical angle of `n_in` / `n_out`.
    fn cosine(n_in: f64, n_out: f64) -> impl Strategy<Value = f64> {
        (0.0..=1.0f64, 0..6u8, -16.0..-3.0f64).prop_map(move |(cos, kind, exponent)| {
            let small = libm::pow(10.0, exponent);
            let critical = (1.0 - (n_out / n_in) * (n_out / n_in)).max(0.0).sqrt();
            match kind {
                0 => small,
                1 => (critical * (1.0 + small)).min(1.0),
                2 => critical * (1.0 - small),
                _ => cos,
            }
        })
    }

    fn media() -> impl Strategy<Value = (f64, f64, f64)> {
        (1.0..4.0f64, 1.0..4.0f64, 0..5u8).prop_flat_map(|(n_in, n_out, kind)| {
            let n_out = if kind == 0 { n_in } else { n_out };
            (Just(n_in), Just(n_out), cosine(n_in, n_out))
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]

        /// Nothing is lost: both shares come from formulas of their own.
        #[test]
        fn shares_add_up_to_one(
            (n_in, n_out, cos_in) in media(),
            index in 1.0..4.0f64,
            thickness_nm in prop_oneof![Just(0.0), 0.0..2000.0f64],
            coated in any::<bool>(),
        ) {
            let layer = coated.then_some((Layer { index, thickness_nm }, 550.0));
            let interface = Interface { n_in, n_out, layer };
            for polarisation in [S, P] {
                let shares = interface.shares(polarisation, cos_in);
                prop_assert!((shares.reflected + shares.transmitted - 1.0).abs() < 1e-14, "{shares:?}");
                prop_assert!(shares.reflected >= 0.0 && shares.transmitted >= 0.0);
                let amplitudes = interface.amplitudes(polarisation, cos_in, interface.cos_out(cos_in));
                prop_assert!((amplitudes.reflected.norm_sqr() - shares.reflected).abs() < 1e-14);
                prop_assert!((amplitudes.transmitted.norm_sqr() - shares.transmitted).abs() < 1e-14);
            }
        }

        /// The same surface from behind lets as much through (reciprocity).
        #[test]
        fn both_ways_let_as_much_through((n_in, n_out, cos_in) in media(), index in 1.0..3.0f64) {
            let layer = Some((Layer { index, thickness_nm: 100.0 }, 550.0));
            let forth = Interface { n_in, n_out, layer };
            let back = Interface { n_in: n_out, n_out: n_in, layer };
            // Towards the critical angle or grazing one way is ill-conditioned: its cosine has lost the digits.
            if let Some(cos_out) = forth.cos_out(cos_in).filter(|cos_out| cos_out.min(cos_in) > 1e-3) {
                for polarisation in [S, P] {
                    let (a, b) = (forth.shares(polarisation, cos_in), back.shares(polarisation, cos_out));
                    prop_assert!((a.transmitted - b.transmitted).abs() < 1e-9, "{a:?} {b:?}");
                }
            }
        }
    }
}
