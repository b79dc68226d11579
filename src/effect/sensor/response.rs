//! The sensor's response: noise, full well, analogue-to-digital conversion.

use super::bayer::Bayer;
use crate::effect::picture::{Picture, merged};
use crate::num::deviates::Stream;
use crate::raster::Raster;
use rayon::prelude::*;

/// A sensor. [`Sensor::IDEAL`] leaves a picture as it is; each field adds one thing.
///
/// In this order: the colour filter, the light's electrons, their uneven gain (PRNU), dark signal, shot noise, the full
/// well, uneven offset (DSNU) and read noise, gain and black level, rounding and the limits of the ADC, demosaicking,
/// gamma.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensor {
    /// Names the specimen: it fixes the uneven gain and offset, and with `frame` the noise.
    pub seed: u64,
    /// Number of the exposure: another frame has other shot and read noise on the same specimen.
    pub frame: u32,
    /// The part of a pixel's area that collects light: a square in its middle. See [`Sensor::active_side`].
    pub fill_factor: f64,
    /// Colour filters over the pixels.
    pub bayer: Option<Bayer>,
    /// Electrons that radiance 1 frees in a pixel during the exposure.
    pub white_e: f64,
    /// Standard deviation of the pixels' gain, of 1: photo response non-uniformity.
    pub prnu: f64,
    /// Mean electrons that come without light.
    pub dark_e: f64,
    /// Whether electrons come at random, as they do.
    pub shot_noise: bool,
    /// Electrons that a pixel holds; more are lost.
    pub full_well_e: f64,
    /// Standard deviation of the pixels' offset, in electrons: dark signal non-uniformity, at the read-out.
    pub dsnu_e: f64,
    /// Standard deviation of the noise of a read-out, in electrons.
    pub read_noise_e: f64,
    /// How electrons become numbers; without it a value is electrons over `white_e`.
    pub adc: Option<Adc>,
    /// The picture holds value^(1 / gamma).
    pub gamma: f64,
}

/// An analogue to digital converter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Adc {
    /// Its numbers (DN) are the whole ones of 0 ..= 2^bits - 1; a picture holds their share of the largest.
    pub bits: u32,
    /// Numbers an electron: the system gain K of EMVA 1288.
    pub gain_dn_per_e: f64,
    /// Number of no electrons.
    pub black_level_dn: f64,
}

impl Adc {
    /// The largest number.
    pub fn largest_dn(&self) -> f64 {
        ((1u64 << self.bits) - 1) as f64
    }

    /// Rounds to the nearest number (halves away from 0) within the limits.
    fn convert(&self, electrons: f64) -> f64 {
        let dn = (self.black_level_dn + self.gain_dn_per_e * electrons).round().clamp(0.0, self.largest_dn());
        dn / self.largest_dn()
    }
}

/// What the random numbers of a pixel are for. The fixed pattern is that of frame 0.
#[derive(Debug, Clone, Copy)]
pub(super) enum Purpose {
    FixedPattern = 0,
    Shot = 1,
    Read = 2,
}

impl Sensor {
    /// The sensor that changes nothing.
    pub const IDEAL: Self = Self {
        seed: 0,
        frame: 0,
        fill_factor: 1.0,
        bayer: None,
        white_e: 1.0,
        prnu: 0.0,
        dark_e: 0.0,
        shot_noise: false,
        full_well_e: f64::INFINITY,
        dsnu_e: 0.0,
        read_noise_e: 0.0,
        adc: None,
        gamma: 1.0,
    };

    /// Whether it leaves a picture as it is.
    pub fn is_nothing(&self) -> bool {
        let Self { seed, frame, white_e, .. } = *self;
        // Electrons without an effect, and numbers for what is not drawn, change nothing.
        *self == Self { seed, frame, white_e, ..Self::IDEAL }
    }

    /// Whether another seed makes another picture.
    pub fn is_random(&self) -> bool {
        self.prnu > 0.0 || self.dsnu_e > 0.0 || self.shot_noise || self.read_noise_e > 0.0
    }

    /// The side of a pixel's active square, of the pitch: the square root of the fill factor. It is no matter of this
    /// chain: the mean of the picture over each pixel must be taken over that square.
    pub fn active_side(&self) -> f64 {
        self.fill_factor.sqrt()
    }

    /// What the sensor makes of `light`. With colour filters it sees one colour a pixel (grey light is all of them), and
    /// the raw mosaic is grey; without filters it sees what there is. The bits depend on the light, the seed and the
    /// frame, and on nothing else.
    pub fn expose(&self, light: &Picture) -> Picture {
        if (Self { fill_factor: 1.0, ..*self }).is_nothing() {
            return light.clone();
        }
        let (grey, size) = (&light.grey, [light.grey.width(), light.grey.height()]);
        let radiance = |k: usize| light.colour.as_ref().map_or([grey.data()[k]; 3], |colour| colour.data()[k]);
        let raw = match (&self.bayer, &light.colour) {
            (Some(bayer), _) => {
                bayer.developed(self.channel(0, size, |k| bayer.through(k % size[0], k / size[0], radiance(k))))
            }
            (None, None) => Picture::of_grey(self.channel(0, size, |k| f64::from(grey.data()[k]))),
            (None, Some(colour)) => {
                let channel = |c: usize| self.channel(c as u32, size, |k| f64::from(colour.data()[k][c]));
                Picture::of_colours(merged([0, 1, 2].map(channel)))
            }
        };
        match raw {
            linear if self.gamma == 1.0 => linear,
            Picture { colour: Some(colour), .. } => Picture::of_colours(colour.map(|v| v.map(|v| self.encoded(v)))),
            Picture { grey, colour: None } => Picture::of_grey(grey.map(|v| self.encoded(v))),
        }
    }

    /// One channel of pixels, read out.
    fn channel(&self, channel: u32, size: [usize; 2], radiance: impl Fn(usize) -> f64 + Sync) -> Raster<f32> {
        let pixels = (0..size[0] * size[1]).into_par_iter();
        let values = pixels.map(|k| self.read_out(radiance(k), k as u32, channel) as f32).collect();
        Raster::from_data(size[0], size[1], values)
    }

    /// The value that a pixel of the given radiance is read out as.
    fn read_out(&self, radiance: f64, pixel: u32, channel: u32) -> f64 {
        let stream = |purpose: Purpose| {
            let frame = if matches!(purpose, Purpose::FixedPattern) { 0 } else { self.frame };
            Stream::new(self.seed, 3 * purpose as u32 + channel, frame, pixel)
        };
        let uneven = self.prnu > 0.0 || self.dsnu_e > 0.0;
        let [gain, offset] = if uneven { stream(Purpose::FixedPattern).normals() } else { [0.0; 2] };
        let mean_e = (self.white_e * radiance * (1.0 + self.prnu * gain)).max(0.0) + self.dark_e;
        let collected_e = if self.shot_noise { stream(Purpose::Shot).poisson(mean_e) } else { mean_e };
        let noise = if self.read_noise_e > 0.0 { stream(Purpose::Read).normals()[0] } else { 0.0 };
        let read_e = collected_e.min(self.full_well_e) + self.dsnu_e * offset + self.read_noise_e * noise;
        match &self.adc {
            Some(adc) => adc.convert(read_e),
            None => read_e / self.white_e,
        }
    }

    fn encoded(&self, value: f32) -> f32 {
        libm::pow(f64::from(value).max(0.0), 1.0 / self.gamma) as f32
    }
}
