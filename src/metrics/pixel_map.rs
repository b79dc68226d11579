//! A smooth map of the image, interpolated from scattered corners.

use super::deviation::{Unmeasurable, all_finite, at_least};
use crate::geom::Rect;
use crate::num::lsq;
use crate::num::poly2::Poly2;
use glam::DVec2;
use nalgebra::DMatrix;

/// The degree to use on half images of a prism. Through the flat prism of the design paper, of which the freeform one
/// is the gentler case, the map between the halves is kept to 1e-4 px RMS (degree 3: 4e-3 px; degree 5: 1e-6 px, but it
/// needs more corners than a half holds at half a metre, and lets more of their noise through).
pub const DEGREE: usize = 4;

/// A pixel and the value there: a position in another image in px, or on a board in mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Correspondence {
    /// Where, in px.
    pub image_px: DVec2,
    /// What, in its own unit.
    pub value: DVec2,
}

/// Two polynomials of the image position, fitted by least squares, and the rectangle they were fitted over.
#[derive(Debug, Clone, PartialEq)]
pub struct PixelMap {
    x: Poly2,
    y: Poly2,
    domain: Rect,
    rms: f64,
}

impl PixelMap {
    /// Fits polynomials of total degree `degree` to the samples. Inside a half the map through a prism is analytic, so
    /// a low degree serves; [`PixelMap::rms`] shows whether it did. Noise in the corners is averaged.
    ///
    /// # Errors
    /// [`Unmeasurable::TooFew`] unless there are twice as many samples as the (d + 1)(d + 2)/2 coefficients,
    /// [`Unmeasurable::NotFinite`], [`Unmeasurable::Fit`] when they lie on a curve of that degree (all on one line).
    ///
    /// # Panics
    /// When `degree` is above [`MAX_DEGREE`](crate::num::bernstein::MAX_DEGREE).
    pub fn fit(samples: &[Correspondence], degree: usize) -> Result<Self, Unmeasurable> {
        let coefficients = (degree + 1) * (degree + 2) / 2;
        at_least("corners of an interpolated image", samples.len(), 2 * coefficients)?;
        all_finite("corner", samples, |s| s.image_px.is_finite() && s.value.is_finite())?;
        let first = Rect { min: samples[0].image_px, max: samples[0].image_px };
        let domain = samples.iter().fold(first, |r, s| Rect { min: r.min.min(s.image_px), max: r.max.max(s.image_px) });
        let half = domain.size() / 2.0;
        if half.min_element() <= 0.0 || !half.is_finite() {
            return Err(Unmeasurable::Degenerate("the corners of an interpolated image lie on one line"));
        }
        let centre = (domain.min + half).to_array();
        let powers: Vec<(usize, usize)> = (0..=degree).flat_map(|n| (0..=degree - n).map(move |m| (m, n))).collect();
        let power = |base: f64, exponent: usize| (0..exponent).fold(1.0, |product, _| product * base);
        let design = DMatrix::from_fn(samples.len(), coefficients, |i, k| {
            let u = (samples[i].image_px - DVec2::from(centre)) / half;
            power(u.x, powers[k].0) * power(u.y, powers[k].1)
        });
        let values = DMatrix::from_fn(samples.len(), 2, |i, k| samples[i].value[k]);
        let solution = lsq::linear(&design, &values)?;
        let residual = (&design * &solution - values).norm_squared();
        let poly = |column: usize| {
            Poly2::new(degree, centre, half.to_array(), |m, n| {
                powers.iter().position(|p| *p == (m, n)).map_or(0.0, |row| solution[(row, column)])
            })
        };
        Ok(Self { x: poly(0), y: poly(1), domain, rms: (residual / samples.len() as f64).sqrt() })
    }

    /// The value at a pixel; `None` outside the rectangle spanned by the samples, where a polynomial must not be
    /// evaluated.
    pub fn at(&self, image_px: DVec2) -> Option<DVec2> {
        let [x, y] = image_px.to_array();
        self.domain.contains(image_px).then(|| DVec2::new(self.x.value(x, y), self.y.value(x, y)))
    }

    /// sqrt(sum |e|^2 / N) of the samples about the map, in the unit of the values: noise, or a degree too low.
    pub fn rms(&self) -> f64 {
        self.rms
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cubic(p: DVec2) -> DVec2 {
        let q = p / 500.0 - 1.0;
        DVec2::new(3.0 + q.x * q.x * q.y - 2.0 * q.y, q.x + q.y * q.y * q.y)
    }

    fn grid(n: usize) -> Vec<Correspondence> {
        let points = (0..n).flat_map(|j| (0..n).map(move |i| DVec2::new(100.0 * i as f64, 130.0 * j as f64)));
        points.map(|image_px| Correspondence { image_px, value: cubic(image_px) }).collect()
    }

    #[test]
    fn a_cubic_is_reproduced_between_its_samples_and_refused_outside() {
        let map = PixelMap::fit(&grid(8), 3).unwrap();
        let p = DVec2::new(333.3, 444.4);
        assert!((map.at(p).unwrap() - cubic(p)).length() < 1e-13);
        assert!(map.rms() < 1e-13);
        assert_eq!(map.at(DVec2::new(-1.0, 5.0)), None);
        assert_eq!(map.at(DVec2::NAN), None);
        // A degree too low shows in the residual.
        assert!(PixelMap::fit(&grid(8), 2).unwrap().rms() > 1e-3);
    }

    #[test]
    fn a_row_of_corners_is_no_image() {
        let row: Vec<_> = grid(8).into_iter().filter(|s| s.image_px.y == 0.0).collect();
        assert!(matches!(PixelMap::fit(&row, 1), Err(Unmeasurable::Degenerate(_))));
        let diagonal: Vec<_> = grid(20).into_iter().filter(|s| s.image_px.y == 1.3 * s.image_px.x).collect();
        assert!(matches!(PixelMap::fit(&diagonal, 1), Err(Unmeasurable::Fit(lsq::Failure::Singular { .. }))));
        assert!(matches!(PixelMap::fit(&grid(2), 3), Err(Unmeasurable::TooFew { found: 4, needed: 20, .. })));
    }
}
