//! The names of the effects.

/// An effect, in the order in which light meets them; `id as usize` is its place in that order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EffectId {
    /// [`super::Lamp`]
    Lamp,
    /// [`super::Fresnel`]
    Fresnel,
    /// [`super::Coating`]
    Coating,
    /// [`super::Absorption`]
    Absorption,
    /// [`super::Ghosts`]
    Ghosts,
    /// [`super::Dispersion`]
    Dispersion,
    /// [`super::Manufacture`]
    Manufacture,
    /// [`super::Roughness`]
    Roughness,
    /// [`super::Clipping`]
    Clipping,
    /// [`super::Telecentric`]
    Telecentric,
    /// [`super::ThinLens`]
    ThinLens,
    /// [`super::Cos4`]
    Cos4,
    /// [`super::Diffraction`]
    Diffraction,
    /// [`super::Sensor`]
    Sensor,
}

impl EffectId {
    /// Its key: its table in a scene file is `[effect.<key>]`.
    pub fn key(self) -> &'static str {
        match self {
            Self::Lamp => "lamp",
            Self::Fresnel => "fresnel",
            Self::Coating => "coating",
            Self::Absorption => "absorption",
            Self::Ghosts => "ghosts",
            Self::Dispersion => "dispersion",
            Self::Manufacture => "manufacture",
            Self::Roughness => "roughness",
            Self::Clipping => "clipping",
            Self::Telecentric => "telecentric",
            Self::ThinLens => "thin_lens",
            Self::Cos4 => "cos4",
            Self::Diffraction => "diffraction",
            Self::Sensor => "sensor",
        }
    }
}
