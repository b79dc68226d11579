//! Fresnel's formulas: reflectance and transmittance of a surface, bare or under a single layer.
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
pub(crate) fn left_after(per_mm: f64, length_mm: f64) -> f64 {
    libm::exp(-per_mm * length_mm)
}

/// The absorption coefficient, in 1/mm, of a medium whose internal transmittance over `length_mm` is `transmittance`.
pub fn absorption_per_mm(transmittance: f64, length_mm: f64) -> f64 {
    -libm::log(transmittance) / length_mm
}

#[cfg(test)]
#[path = "fresnel_tests.rs"]
mod tests;
