//! The sensor: from light to numbers, by the linear model of EMVA Standard 1288 (release 4.0, chapters 2 and 4) with the
//! steps that a camera adds around it.

mod bayer;

pub use bayer::{Bayer, Demosaic, Order};

#[cfg(test)]
mod tests;
mod response;

pub use response::{Adc, Sensor};
