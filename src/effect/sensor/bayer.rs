//! Colour filters over the pixels, and colours from them.
//!
//! B. E. Bayer, "Color imaging array", US patent 3971065 (1976).

use crate::effect::picture::Picture;
use crate::raster::Raster;

/// A mosaic of red, green and blue filters that repeats every two pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bayer {
    /// The filters of the first two pixels of the first row, then of the second.
    pub order: Order,
    /// The share of the light of their colour that the red, green and blue filters let through.
    pub transmission: [f64; 3],
    /// How colours are made of it.
    pub demosaic: Demosaic,
}

/// The filters of a mosaic's first two rows, named by their four first pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// Red, green; green, blue.
    Rggb,
    /// Blue, green; green, red.
    Bggr,
    /// Green, red; blue, green.
    Grbg,
    /// Green, blue; red, green.
    Gbrg,
}

/// How a mosaic becomes a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Demosaic {
    /// It stays as it is, one value a pixel.
    Raw,
    /// A pixel keeps its own colour and takes each other one as the mean of the nearest pixels that have it: two or four,
    /// and at the border those of them that exist.
    Bilinear,
}

impl Bayer {
    /// The colour of the filter over a pixel: 0 red, 1 green, 2 blue.
    pub fn colour(&self, column: usize, row: usize) -> usize {
        let first = match self.order {
            Order::Rggb => [0, 1, 1, 2],
            Order::Bggr => [2, 1, 1, 0],
            Order::Grbg => [1, 0, 2, 1],
            Order::Gbrg => [1, 2, 0, 1],
        };
        first[2 * (row % 2) + column % 2]
    }

    /// What the filter over a pixel lets through of `light`.
    pub(super) fn through(&self, column: usize, row: usize, light: [f32; 3]) -> f64 {
        let colour = self.colour(column, row);
        self.transmission[colour] * f64::from(light[colour])
    }

    /// The picture of a raw mosaic.
    pub(super) fn developed(&self, raw: Raster<f32>) -> Picture {
        match self.demosaic {
            Demosaic::Raw => Picture::of_grey(raw),
            Demosaic::Bilinear => Picture::of_colours(self.bilinear(&raw)),
        }
    }

    fn bilinear(&self, raw: &Raster<f32>) -> Raster<[f32; 3]> {
        let (width, height) = (raw.width(), raw.height());
        let pixel = |k: usize| {
            let (i, j) = (k % width, k / width);
            let (mut sum, mut count) = ([0.0; 3], [0.0; 3]);
            for y in j.saturating_sub(1)..height.min(j + 2) {
                for x in i.saturating_sub(1)..width.min(i + 2) {
                    let colour = self.colour(x, y);
                    sum[colour] += f64::from(raw.get(x, y));
                    count[colour] += 1.0;
                }
            }
            let own = self.colour(i, j);
            [0, 1, 2].map(|c| {
                // A colour that no neighbour has, in a picture one pixel wide, is that of the pixel itself.
                if c == own || count[c] == 0.0 { raw.get(i, j) } else { (sum[c] / count[c]) as f32 }
            })
        };
        Raster::from_data(width, height, (0..width * height).map(pixel).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ORDERS: [Order; 4] = [Order::Rggb, Order::Bggr, Order::Grbg, Order::Gbrg];

    fn bayer(order: Order) -> Bayer {
        Bayer { order, transmission: [1.0; 3], demosaic: Demosaic::Bilinear }
    }

    #[test]
    fn the_name_of_an_order_is_its_first_four_pixels() {
        for order in ORDERS {
            let letters: String =
                (0..4).map(|k| ["R", "g", "b"][bayer(order).colour(k % 2, k / 2)]).collect::<String>().to_lowercase();
            assert_eq!(letters, format!("{order:?}").to_lowercase());
        }
    }

    /// Planes are reproduced: the mean of opposite neighbours of a linear function is its value. At the border one of two
    /// is missing.
    #[test]
    fn linear_light_is_demosaicked_exactly_within_the_border() {
        for order in ORDERS {
            let bayer = bayer(order);
            let (width, height) = (9, 8);
            // Eighths: sums and means of them are exact.
            let light = |x: usize, y: usize| [x as f32 / 8.0, y as f32 / 4.0 + 1.0, (x + y) as f32 / 2.0];
            let raw = (0..width * height).map(|k| bayer.through(k % width, k / width, light(k % width, k / width)));
            let colour = bayer.bilinear(&Raster::from_data(width, height, raw.map(|v| v as f32).collect()));
            for y in 1..height - 1 {
                for x in 1..width - 1 {
                    assert_eq!(colour.get(x, y), light(x, y), "{order:?} ({x}, {y})");
                }
            }
        }
    }

    #[test]
    fn a_pixel_keeps_its_own_colour() {
        let raw = Raster::from_data(6, 5, (0..30).map(|k| ((k * 7) % 11) as f32).collect());
        for order in ORDERS {
            let colour = bayer(order).bilinear(&raw);
            for k in 0..30 {
                assert_eq!(colour.data()[k][bayer(order).colour(k % 6, k / 6)], raw.data()[k], "{order:?} {k}");
            }
        }
    }

    #[test]
    fn grey_stays_grey_on_any_size() {
        for (width, height) in [(1, 1), (1, 4), (5, 1), (2, 2), (7, 6)] {
            for order in ORDERS {
                let colour = bayer(order).bilinear(&Raster::filled(width, height, 0.3f32));
                assert!(colour.data().iter().all(|v| *v == [0.3; 3]), "{width} x {height} {order:?}");
            }
        }
    }
}
