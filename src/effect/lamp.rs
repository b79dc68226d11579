//! The board lit by a point lamp.

use super::journey::LightPath;
use glam::DVec3;

/// A point lamp before a matt board, and light from all around.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lamp {
    /// Place of the lamp in the world, in mm.
    pub position_mm: DVec3,
    /// The lamp's share of the light at the reference place, in 0..=1; the rest is the same everywhere.
    pub share: f64,
    /// cos / d^2 at the reference place, in 1/mm^2: the radiances of a scene are those seen there.
    pub reference_per_mm2: f64,
}

impl Lamp {
    /// A lamp at `position_mm` that gives the `share` of the light at `place_mm` of a plane with the unit normal `normal`.
    pub fn new(position_mm: DVec3, share: f64, place_mm: DVec3, normal: DVec3) -> Self {
        Self { position_mm, share, reference_per_mm2: irradiance(position_mm, place_mm, normal) }
    }

    /// Whether it changes nothing.
    pub fn is_nothing(&self) -> bool {
        self.share == 0.0
    }

    /// The light at the place that the ray meets over that at the reference place. What lies around the board's plate is
    /// taken to lie in its plane; what never meets the plane is lit as the reference.
    pub fn throughput(&self, journey: &LightPath) -> f64 {
        journey.landing.map_or(1.0, |at| {
            let there = irradiance(self.position_mm, at.point_mm, at.normal);
            (1.0 - self.share) + self.share * (there / self.reference_per_mm2)
        })
    }
}

/// Irradiance at a place by a lamp of intensity 1: Lambert's cosine over the square of the distance, in 1/mm^2.
fn irradiance(lamp_mm: DVec3, place_mm: DVec3, normal: DVec3) -> f64 {
    let way = lamp_mm - place_mm;
    let square = way.length_squared();
    normal.dot(way).abs() / (square * square.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::BoardPoint;

    /// Over a plane at the height h, at r from the foot: h^3 / (h^2 + r^2)^(3/2), cos^3 of the angle at the lamp.
    #[test]
    fn light_falls_by_the_cube_of_the_cosine_at_the_lamp() {
        let lamp = Lamp::new(DVec3::new(0.0, 0.0, 400.0), 1.0, DVec3::new(0.0, 0.0, 1000.0), DVec3::Z);
        for r in [0.0, 100.0, 600.0] {
            let landing = Some(BoardPoint { point_mm: DVec3::new(0.0, r, 1000.0), normal: DVec3::Z });
            let throughput = lamp.throughput(&LightPath { image_cos: 1.0, crossings: &[], landing });
            let cos = 600.0 / (600.0f64 * 600.0 + r * r).sqrt();
            assert!((throughput - cos * cos * cos).abs() < 4.0 * f64::EPSILON, "{r}: {throughput}");
        }
    }
}
