//! Where an effect takes hold.

/// Where an effect takes hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Hook {
    /// The instrument itself, through and through: its rays, what is true of its pictures, and what is aimed at.
    Instrument,
    /// The picture becomes a mean over variants of the instrument.
    Ray,
    /// A smooth factor of each ray's light.
    Transport,
    /// A function of the whole picture.
    Film,
}
