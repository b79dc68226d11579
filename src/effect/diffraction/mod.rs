//! Diffraction at the lens's round aperture: the picture is convolved with the Airy pattern, and each pixel's active square
//! collects what falls on it.
//!
//! M. Born, E. Wolf, Principles of Optics (7th ed.), 8.5.2 (the pattern and its encircled energy); J. W. Goodman,
//! Introduction to Fourier Optics (4th ed.), 7.3 (the transfer function of an incoherent, aberration-free system).
//!
//! The light of each pixel is taken as even over it and spread by [`PixelSpread`], over the whole picture; where it is not
//! even, [`CellSpread`] spreads by how much its cells differ from that, but for ghosts. From a wavelength times f-number of
//! 0.1 px on and for fill factors from 0.05 on, pixels are then off by at most 1e-3 of the contrast, and half-bright places
//! by 1e-3 px where squares are as large as the pattern: the tests hold it against integrals and Fourier series of the transfer
//! function. Below 0.1 px it is up to 2e-3 at fill factors from 0.25 on, and 5e-3 from 0.05 on.
//!
//! Beyond the picture light is rendered as far as [`Diffraction::margins_px`], as the number of pixels or the glass allows; farther
//! out it is taken as the mirror image of what is rendered. Where it is unlike that, pixels at the border are off by up to
//! 2 / (pi^3 d) of the contrast for d times the pattern's scale, and twice that in a corner: 5e-4 in small pictures, 4e-4 in
//! 1920 x 1080 pixels at a scale of 1 px, and up to 0.8 % where the scale is a thirtieth of the picture or the glass is small;
//! where it is given nowhere beyond the border, up to half of the contrast.
//!
//! One wavelength serves the whole picture, 550 nm unless the scene says otherwise: light of many wavelengths, as of
//! dispersion, is spread by one pattern.

mod cells;
mod cosines;
mod spread;
mod transfer;

pub use cells::CellSpread;
pub use spread::LightSpread;
pub use transfer::PixelSpread;

#[cfg(test)]
mod tests;
mod airy;
mod settings;

pub use airy::{FIRST_ZERO, airy, encircled_energy, leaving_square, mtf};
pub use settings::{Diffraction, LARGEST_SCALE_PX};
