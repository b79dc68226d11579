//! A plate with a texture on it, before a background.

use super::chart::{self, Chart};
use super::convex::{Convex, bounds, signed_area};
use super::texels::Texels;
use glam::DVec2;
use std::sync::Arc;

/// What a plate shows, as values of which 0 is its black and 1 its white.
#[derive(Debug, Clone, PartialEq)]
pub enum Texture {
    /// A picture.
    Picture(Texels),
    /// A chart.
    Chart(Chart),
}

impl Texture {
    /// Columns and rows.
    fn size(&self) -> DVec2 {
        match self {
            Self::Picture(texels) => texels.size(),
            Self::Chart(chart) => chart.size(),
        }
    }

    fn at(&self, place: DVec2) -> f64 {
        match self {
            Self::Picture(texels) => texels.at(place),
            Self::Chart(chart) => chart.at(place),
        }
    }

    fn integral(&self, polygon: &Convex) -> f64 {
        match self {
            Self::Picture(texels) => texels.integral(polygon.vertices()),
            Self::Chart(chart) => chart.integral(polygon),
        }
    }
}

/// A plate in its own frame: its middle the origin, x along columns, y down rows. Places are in mm.
#[derive(Debug, Clone, PartialEq)]
pub struct Plate {
    texture: Arc<Texture>,
    /// Half the size of the texture.
    texture_mm: DVec2,
    /// Half the size with the margin.
    plate_mm: DVec2,
    /// Columns and rows a mm.
    per_mm: DVec2,
    black: f64,
    white: f64,
    background: f64,
}

impl Plate {
    /// A plate of the size of `half_mm` to both sides of its middle, with a white margin about it, whose values 0 and 1 are
    /// `radiance[0]` and `radiance[1]`, before a background of `radiance[2]`.
    pub fn new(texture: Texture, half_mm: DVec2, margin_mm: f64, radiance: [f64; 3]) -> Self {
        let per_mm = texture.size() / (2.0 * half_mm);
        let [black, white, background] = radiance;
        let texture = Arc::new(texture);
        Self { texture, texture_mm: half_mm, plate_mm: half_mm + margin_mm, per_mm, black, white, background }
    }

    /// The same plate in another light: with the radiance of 0 and 1 and of the background as in [`Plate::new`].
    #[must_use]
    pub fn with_radiance(&self, [black, white, background]: [f64; 3]) -> Self {
        Self { black, white, background, ..self.clone() }
    }

    /// Half the size of the plate with its margin, in mm.
    pub fn half_mm(&self) -> DVec2 {
        self.plate_mm
    }

    /// The shortest distance of lines that it shows, in mm: a texel; of a chart, whose stars have none, a small part of a cell.
    pub fn feature_mm(&self) -> f64 {
        let cell_mm = 1.0 / self.per_mm.max_element();
        match &*self.texture {
            Texture::Picture(_) => cell_mm,
            Texture::Chart(_) => cell_mm * chart::FEATURE,
        }
    }

    fn radiance(&self, value: f64) -> f64 {
        self.black + (self.white - self.black) * value
    }

    /// The radiance at a place.
    pub fn at(&self, mm: DVec2) -> f64 {
        let outside = |half: DVec2| mm.abs().cmpgt(half).any();
        if outside(self.plate_mm) {
            self.background
        } else if outside(self.texture_mm) {
            self.white
        } else {
            self.radiance(self.texture.at((mm + self.texture_mm) * self.per_mm))
        }
    }

    /// The mean radiance over a convex polygon of up to 8 vertices, exact but for rounding; `None` where its area vanishes against
    /// its length or the rounding of its vertices.
    pub fn mean_over(&self, polygon_mm: &[DVec2]) -> Option<f64> {
        // Turn down an area of mere rounding.
        let ([low, high], signed_area) = (bounds(polygon_mm), signed_area(polygon_mm));
        let area = signed_area.abs();
        let extent = high - low;
        let rounding = 64.0 * f64::EPSILON * low.abs().max(high.abs()).max_element();
        if extent.max_element() < 1e4 * rounding || area < 1e-9 * extent.length_squared() || !area.is_finite() {
            return None;
        }

        // Beyond the plate there is the background alone, rounded as the sum at the end would be.
        if low.cmpgt(self.plate_mm).any() || high.cmplt(-self.plate_mm).any() {
            return Some(self.background * area / area);
        }

        // Integrate over a polygon that lies on a picture as a whole: the one of all pixels but a few.
        if let Texture::Picture(texels) = &*self.texture
            && (-self.texture_mm).cmple(low).all()
            && high.cmple(self.texture_mm).all()
        {
            let mut places = [DVec2::ZERO; 8];
            places.iter_mut().zip(polygon_mm).for_each(|(to, mm)| *to = (*mm + self.texture_mm) * self.per_mm);
            let integral = signed_area.signum() * texels.integral(&places[..polygon_mm.len()]);
            let light = integral / (self.per_mm.x * self.per_mm.y);
            return Some((self.black * area + (self.white - self.black) * light) / area);
        }

        // Integrate what of it lies on the texture.
        let whole = Convex::new(polygon_mm);
        let on_texture = whole.within(-self.texture_mm, self.texture_mm);
        let covered = on_texture.area();
        let light = if covered > 0.0 {
            let places = on_texture.map(|mm| (mm + self.texture_mm) * self.per_mm);
            self.texture.integral(&places) / (self.per_mm.x * self.per_mm.y)
        } else {
            0.0
        };
        let on_plate = whole.within(-self.plate_mm, self.plate_mm).area();

        // Add the margin and the background.
        let sum = self.black * covered + (self.white - self.black) * light;
        Some((sum + self.white * (on_plate - covered) + self.background * (area - on_plate)) / area)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Raster;
    use crate::texture::TexelFilter;

    fn plate() -> Plate {
        let picture = Raster::from_data(4, 2, vec![0.0, 1.0, 0.5, 0.25, 1.0, 0.0, 0.75, 0.5]);
        let texture = Texture::Picture(Texels::new(picture, TexelFilter::Nearest));
        Plate::new(texture, DVec2::new(20.0, 10.0), 5.0, [0.1, 0.9, 0.3])
    }

    #[test]
    fn texture_margin_and_background_lie_where_they_should() {
        let plate = plate();
        let near = |a: f64, b: f64| (a - b).abs() < 1e-15;
        assert!(near(plate.at(DVec2::new(-15.0, -5.0)), 0.1) && near(plate.at(DVec2::new(-5.0, -5.0)), 0.9));
        assert!(near(plate.at(DVec2::new(15.0, 5.0)), 0.5) && near(plate.at(DVec2::new(22.0, 0.0)), 0.9));
        assert!(near(plate.at(DVec2::new(26.0, 0.0)), 0.3) && plate.feature_mm() == 10.0);
        assert_eq!(plate.half_mm(), DVec2::new(25.0, 15.0));
    }

    /// A square over four texels; one over the corner of the texture: a quarter on its last texel, the rest on the margin; one over the
    /// corner of the plate; and one that is larger than all. The first and the last of either orientation.
    #[test]
    fn means_are_weighted_by_area() {
        let plate = plate();
        let square = |middle: DVec2, half: f64| {
            [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|p| middle + DVec2::from(p) * half)
        };
        let near = |outline: &[DVec2], value: f64| {
            let mean = plate.mean_over(outline).expect("it has an area");
            assert!((mean - value).abs() < 1e-14, "{mean} {value}");
        };
        let amid = square(DVec2::ZERO, 2.0);
        near(&amid, 0.1 + 0.8 * 0.25 * (1.0 + 0.5 + 0.0 + 0.75));
        near(&[amid[3], amid[2], amid[1], amid[0]], 0.55);
        near(&square(DVec2::new(20.0, 10.0), 2.0), 0.25 * 0.5 + 0.75 * 0.9);
        near(&square(DVec2::new(25.0, 15.0), 2.0), 0.25 * 0.9 + 0.75 * 0.3);
        let all = square(DVec2::ZERO, 50.0);
        let texture = 0.1 + 0.8 * 0.5;
        let mean = (800.0 * texture + (1500.0 - 800.0) * 0.9 + (10_000.0 - 1500.0) * 0.3) / 10_000.0;
        near(&all, mean);
        near(&[all[3], all[2], all[1], all[0]], mean);
        assert_eq!(plate.mean_over(&[DVec2::ZERO, DVec2::X, DVec2::new(2.0, 0.0)]), None);
    }
}
