//! Settings of the corner detector.

/// The least visible share of a corner's window.
pub const LEAST_VISIBLE: f64 = 0.5;

/// How the blur of the picture is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Blur {
    /// One blur across each family of lines, estimated from the picture: right for most pictures.
    Common,
    /// A Gaussian of this standard deviation, in px; 0 is a picture that only the pixel's square has smoothed.
    Known(f64),
    /// Each corner has its own: for a blur that changes over the picture. The slowest.
    PerCorner,
}

/// Where light that is not even becomes so.
///
/// The blur takes light from the brighter side: on the board it moves every corner by its variance times the relative
/// change of the light a px (a blur of 1 px, and light that falls by 40 % over 500 px: 0.0008 px), and the fit takes that
/// back. A picture does not tell which it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UnevenLight {
    /// The board is lit unevenly.
    OnBoard,
    /// The lens or the sensor darkens a part of the picture that is already blurred: vignetting.
    InCamera,
}

/// Settings of [`detect`](super::detect).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Half the window of a corner as a share of the step to its neighbours, in 0.1..=0.5. A larger one is less noisy;
    /// above 0.5 neighbours would share pixels and their errors. Of squares of more than 89 px a window of 40 px to each side is
    /// taken, or of six blurs where these are more.
    pub window: f64,
    /// The blur.
    pub blur: Blur,
    /// Where the light varies.
    pub light: UnevenLight,
    /// A grid has at least so many corners; also at least three columns and three rows.
    pub min_corners: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self { window: 0.45, blur: Blur::Common, light: UnevenLight::OnBoard, min_corners: 9 }
    }
}
