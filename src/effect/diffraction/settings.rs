//! The settings of diffraction.

/// Wavelength times f-number is at most this many px.
pub const LARGEST_SCALE_PX: f64 = 32.0;
/// The side of a cell, as a share of the geometric mean of the pattern's scale and the larger one of it and the active side:
/// what edges within cells make of the picture falls as the square of it, and is then some 7e-4 of the contrast.
const CELL_SHARE: f64 = 0.08;
/// The most cells along each side of a pixel.
const MOST_CELLS: usize = 64;
/// Squares smaller than a pixel make patterns of their own with pixels, and with cells that are not much smaller: so many cells lie
/// along the side of a square, if that asks for no more than the other number along that of a pixel.
const CELLS_PER_SQUARE: f64 = 4.0;
const MOST_FOR_SQUARES: f64 = 16.0;
/// Below this scale, in px, what diffraction adds is taken from the pattern of this scale, in proportion.
const LEAST_SCALE_PX: f64 = 0.02;
/// The picture is rendered at least this many times the pattern's scale beyond its border, and this many pixels more.
const MARGIN: (f64, usize) = (8.0, 8);
/// Light from beyond this many times the pattern's scale makes 5e-4 of the contrast at a border, and 1e-3 in a corner, whatever is there.
const FAR: f64 = 130.0;

/// The lens as diffraction sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Diffraction {
    /// Wavelength in vacuum, in nm.
    pub wavelength_nm: f64,
    /// Distance from the exit pupil to the sensor over the diameter of the pupil: the working f-number.
    pub f_number: f64,
    /// Side of a pixel, in mm.
    pub pitch_mm: f64,
}

impl Diffraction {
    /// Wavelength times f-number over the pitch: the unit of all lengths of the pattern, in px.
    pub fn scale_px(&self) -> f64 {
        self.wavelength_nm * 1e-6 * self.f_number / self.pitch_mm
    }

    /// Whether it changes nothing.
    pub fn is_nothing(&self) -> bool {
        self.scale_px() == 0.0
    }

    /// The scale of the pattern by which light is spread, in px, and the share of that picture; the rest is the light that the
    /// active squares receive without it. The light that leaves a square is in proportion to the scale while it is small.
    pub fn spread_scale(&self) -> (f64, f64) {
        let scale = self.scale_px();
        (scale.max(LEAST_SCALE_PX), (scale / LEAST_SCALE_PX).min(1.0))
    }

    /// Cells along each side of a pixel with an active square of side `active` px, from which pixels that are not evenly lit
    /// are spread, in a picture whose smallest squares are of `square_px`: 1, or an even number.
    pub fn cells(&self, active: f64, square_px: f64) -> usize {
        let (scale, share) = self.spread_scale();
        // Of a small share, errors are a small share.
        let cells = (share.sqrt() / (CELL_SHARE * (scale * scale.max(active)).sqrt())).ceil();
        let small = if square_px < 1.0 { (CELLS_PER_SQUARE / square_px).ceil().min(MOST_FOR_SQUARES) } else { 1.0 };
        let cells = cells.max(small);
        if cells <= 1.0 { 1 } else { (cells.min(MOST_CELLS as f64) as usize).next_multiple_of(2) }
    }

    /// Pixels beyond the border of a picture whose light reaches it: those that are always rendered where the glass is given, and
    /// those from beyond which hardly any comes.
    pub fn margins_px(&self) -> [usize; 2] {
        [MARGIN.0, FAR].map(|scales| (scales * self.scale_px()).ceil() as usize + MARGIN.1)
    }
}
