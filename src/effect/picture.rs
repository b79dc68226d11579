//! A picture in linear light, grey and, where the sensor tells them apart, in colours.

use crate::raster::Raster;
use crate::raster::transfer::luminance;

/// A picture in linear light, of full scale 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// One value a pixel: what is measured in.
    pub grey: Raster<f32>,
    /// Red, green and blue of each pixel, where the sensor tells them apart.
    pub colour: Option<Raster<[f32; 3]>>,
}

impl Picture {
    /// A picture without colours.
    pub fn of_grey(grey: Raster<f32>) -> Self {
        Self { grey, colour: None }
    }

    /// A picture of colours; its grey is their luminance.
    pub fn of_colours(colour: Raster<[f32; 3]>) -> Self {
        let grey = colour.map(|[r, g, b]| luminance(r.into(), g.into(), b.into()) as f32);
        Self { grey, colour: Some(colour) }
    }
}

/// One picture of three channels of one size.
pub fn merged([r, g, b]: [Raster<f32>; 3]) -> Raster<[f32; 3]> {
    let pixels = r.data().iter().zip(g.data()).zip(b.data());
    Raster::from_data(r.width(), r.height(), pixels.map(|((r, g), b)| [*r, *g, *b]).collect())
}
