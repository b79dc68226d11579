//! The wave error over the pupil: how far the optical paths of a pencil are from those of a perfect one.

use super::lens::RelayLens;
use super::pencil::{Pencil, PencilRay, at_plane};
use crate::num::zernike::{ZernikeSeries, nodes};
use crate::optics::fate::Fate;
use glam::DVec2;

/// Highest degree of the series.
const MOST_DEGREE: usize = 36;
/// The degree with which the search begins.
const FIRST_DEGREE: usize = 12;
/// What the series may leave of the mean square, in waves: a contrast to 1e-6.
const LEFT_WAVES: f64 = 1e-7;

/// The wave error over the pupil of a lens that is focused on a plane, as a series that is held against rays.
#[derive(Debug, Clone, PartialEq)]
pub struct WaveError {
    lens: RelayLens,
    focus_mm: f64,
    /// In waves, in the plane `focus_mm`.
    series: ZernikeSeries,
    /// Root mean square over the pupil, from its mean and its tilt, which but moves the image, in waves.
    pub rms_waves: f64,
    /// What the series leaves, root mean square at rays between those that it was made of, in waves.
    pub left_waves: f64,
}

/// Why there is no wave error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NoWave {
    /// The ray at this place of the pupil (1 at the rim) does not leave the prism.
    Ray(DVec2, Fate),
    /// A series of the highest degree leaves this much, in waves.
    NotSmooth(f64),
}

impl WaveError {
    /// The wave error of `pencil` for a lens that is focused on the plane `focus_mm` of the world's z.
    ///
    /// Paths are counted to the wave front about C, the place where the chief ray meets that plane, which is at infinity behind the lens:
    /// W(p) = |SP| n + |PQ| k + (C - Q) . d, for the ray of direction d that leaves the back at Q.
    ///
    /// # Errors
    /// As [`NoWave`].
    pub fn new(pencil: &Pencil, lens: &RelayLens, focus_mm: f64) -> Result<Self, NoWave> {
        let chief = pencil.pupil(lens.na, &[DVec2::ZERO]).map_err(|(p, fate)| NoWave::Ray(p, fate))?[0];
        let centre = at_plane(&chief.exit, focus_mm).extend(focus_mm);
        let outside = pencil.prism().indices()[0];
        let wave = |ray: &PencilRay| {
            let beyond = outside * (centre - ray.exit.origin).dot(ray.exit.direction);
            (ray.optical_path_mm + beyond) / lens.wavelength_mm
        };
        let waves = |degree: usize| -> Result<Vec<f64>, NoWave> {
            let places: Vec<DVec2> = nodes(degree).iter().map(|node| node.at).collect();
            let rays = pencil.pupil(lens.na, &places).map_err(|(p, fate)| NoWave::Ray(p, fate))?;
            Ok(rays.iter().map(wave).map(|w| w - wave(&chief)).collect())
        };

        // Raise the degree until rays between those of the series agree with it.
        let mut degree = FIRST_DEGREE;
        let mut values = waves(degree)?;
        loop {
            let series = ZernikeSeries::new(degree, &values);
            let next = degree + 8;
            let between = waves(next)?;
            let mean = |of: &dyn Fn(DVec2, f64) -> f64| -> f64 {
                nodes(next).iter().zip(&between).map(|(node, value)| node.weight * of(node.at, *value)).sum()
            };
            let left_waves = mean(&|at, value| (series.at(at) - value) * (series.at(at) - value)).sqrt();
            if left_waves < LEFT_WAVES {
                // The mean square of a coordinate over the disc is 1/4.
                let middle = mean(&|_, value| value);
                let tilt = 4.0 * DVec2::new(mean(&|at, value| at.x * value), mean(&|at, value| at.y * value));
                let rms_waves =
                    mean(&|at, value| (value - middle - tilt.dot(at)) * (value - middle - tilt.dot(at))).sqrt();
                return Ok(Self { lens: *lens, focus_mm, series, rms_waves, left_waves });
            }
            if next > MOST_DEGREE {
                return Err(NoWave::NotSmooth(left_waves));
            }
            (degree, values) = (next, between);
        }
    }

    /// The lens.
    pub fn lens(&self) -> &RelayLens {
        &self.lens
    }

    /// The wave error at a place of the pupil (1 at the rim), in waves, with the lens focused on the plane `focus_mm` instead.
    pub fn waves(&self, place: DVec2, focus_mm: f64) -> f64 {
        self.series_waves(place) + self.defocus(focus_mm) * self.along(place)
    }

    /// The wave error with the lens focused as asked, in waves.
    pub(super) fn series_waves(&self, place: DVec2) -> f64 {
        self.series.at(place)
    }

    /// How far the plane `focus_mm` is from the one in focus, in waves.
    pub(super) fn defocus(&self, focus_mm: f64) -> f64 {
        (focus_mm - self.focus_mm) / self.lens.wavelength_mm
    }

    /// The cosine to the axis of the ray at a place of the pupil: what its path changes by where the plane in focus moves by 1.
    pub(super) fn along(&self, place: DVec2) -> f64 {
        (1.0 - self.lens.na * self.lens.na * place.length_squared()).sqrt()
    }
}
