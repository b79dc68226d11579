//! A variant of the instrument: one sample of its ray effects. The picture is the weighted mean over variants.

use super::dispersion::{self, Dispersion};
use glam::DVec2;

/// One variant of the instrument, with one ray to each place of the picture like the plain one, and its share of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variant {
    /// The point of the pupil: in mm from its centre for a lens, as the sines of a direction for a telecentric one.
    pub pupil: DVec2,
    /// Slopes that are added to those of the front and the back where they refract.
    pub slopes: [DVec2; 2],
    /// The wavelength; `None` for the one to which the scene's index belongs.
    pub wave: Option<dispersion::Wavelength>,
    /// Its share of the grey picture; the shares of all variants sum up to 1.
    pub grey: f64,
    /// Its shares of red, green and blue, each of which sums up to 1; `None` in all variants where the sensor tells no
    /// colours apart.
    pub colour: Option<[f64; 3]>,
}

/// The variants of one set, each made when it is asked for: at every wavelength those of all points.
#[derive(Debug, Clone)]
pub struct Variants<'a> {
    points: Vec<Variant>,
    dispersion: Option<&'a Dispersion>,
}

impl<'a> Variants<'a> {
    /// The variants of `points`, whose shares sum up to 1, at every wavelength of `dispersion`.
    pub fn new(points: Vec<Variant>, dispersion: Option<&'a Dispersion>) -> Self {
        Self { points, dispersion }
    }

    /// These with other points of the pupil in place of theirs.
    #[must_use]
    pub fn with_pupils(mut self, other: impl Fn(DVec2) -> DVec2) -> Self {
        self.points.iter_mut().for_each(|point| point.pupil = other(point.pupil));
        self
    }

    /// How many there are.
    #[allow(clippy::len_without_is_empty, reason = "there is one at least")]
    pub fn len(&self) -> usize {
        self.points.len() * self.dispersion.map_or(1, |dispersion| dispersion.waves.len())
    }

    /// Variant `k` of them.
    ///
    /// # Panics
    /// When there are not so many.
    pub fn get(&self, k: usize) -> Variant {
        let point = self.points[k % self.points.len()];
        let Some(dispersion) = self.dispersion else { return point };
        let wave = dispersion.waves[k / self.points.len()];
        Variant {
            wave: Some(wave),
            grey: point.grey * wave.grey(),
            colour: dispersion.colour.then(|| wave.weights.map(|weight| point.grey * weight)),
            ..point
        }
    }

    /// All of them, one by one.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Variant> + '_ {
        (0..self.len()).map(|k| self.get(k))
    }

    /// At most `most` of them, evenly taken.
    pub fn some(&self, most: usize) -> Vec<Variant> {
        self.iter().step_by(self.len().div_ceil(most)).collect()
    }

    /// Whether each has shares of red, green and blue.
    pub fn in_colour(&self) -> bool {
        self.iter().take(1).all(|variant| variant.colour.is_some())
    }
}
