//! How evenly lit pixels share their light.

use super::airy::mtf;
use super::cosines::Cosines;
use crate::raster::Raster;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Intervals along each axis of the table of aliases, over the squares of up to half a wave a pixel, by which their sum is
/// nearly linear: interpolated so, it is right to 2e-4.
const TABLE: usize = 32;

/// What diffraction and the active squares make of a picture of evenly lit pixels, by its waves.
///
/// A wave that pixels carry stands for all waves that look alike at their centres, whole numbers of waves a pixel apart.
/// Each of them is lit with the sinc of the pixel, weakened by the transfer function, and collected with the sinc of the
/// active square; the factor is the sum of all. The one below half a wave a pixel has the cusp of the transfer function
/// at 0, from which the far light of the pattern comes; the others make a smooth sum, which is tabulated.
#[derive(Debug, Clone)]
pub struct PixelSpread {
    optics: Optics,
    /// The sum of the others, at squares of 0 ... TABLE intervals along x and y, row by row.
    aliases: Vec<f64>,
}

/// The transfer functions of one wave.
///
/// The light is known by its means over cells. At a place that may be anywhere in a cell, an edge is blurred twice by the
/// cell: when its mean is taken, and when the mean is taken as even light. The sinc of the cell is divided out twice for
/// that; what remains depends on where in a cell the edge lies, and is of no sign on average.
#[derive(Debug, Clone, Copy)]
pub(super) struct Optics {
    /// Wavelength times f-number, in px.
    pub(super) scale: f64,
    /// The sides of the active square, of what is evenly lit, and of a cell, in px.
    pub(super) active: f64,
    pub(super) even: f64,
    pub(super) cell: f64,
}

impl Optics {
    /// What is left of the wave of `nu` per px.
    fn of(&self, [x, y]: [f64; 2]) -> f64 {
        mtf(self.scale * (x * x + y * y).sqrt()) * self.along(x) * self.along(y)
    }

    /// The sincs along one axis.
    pub(super) fn along(&self, nu: f64) -> f64 {
        // Waves of less than two cells are not known by them.
        let cell = sinc((self.cell * nu).abs().min(0.5));
        sinc(self.active * nu) * sinc(self.even * nu) / (cell * cell)
    }
}

impl PixelSpread {
    /// For wavelength times f-number in px, and for pixels with an active square of side `active` px in their middle and so
    /// many cells along each side.
    ///
    /// # Panics
    /// When the scale is not above 0, `active` not within (0, 1], or there are no cells.
    pub fn new(scale: f64, active: f64, cells: usize) -> Self {
        assert!(scale > 0.0, "wavelength x f-number of {scale} px");
        assert!(active > 0.0 && active <= 1.0, "an active side of {active} px");
        assert!(cells > 0, "no cells");
        let optics = Optics { scale, active, even: 1.0, cell: 1.0 / cells as f64 };
        let most = (1.0 / scale + 0.5).floor();
        let numbers = (-most as i64..=most as i64).map(|m| m as f64);
        let nu = |k: usize| 0.5 * (k as f64 / TABLE as f64).sqrt();
        let sum = |x: f64, y: f64| -> f64 {
            let along: Vec<[f64; 2]> = numbers.clone().map(|m| [y + m, optics.along(y + m)]).collect();
            let of_column = |m: f64| -> f64 {
                let (x, across) = (x + m, optics.along(x + m));
                let others = along.iter().filter(|[other, _]| m != 0.0 || *other != y);
                across * others.map(|[y, along]| along * mtf(scale * (x * x + y * y).sqrt())).sum::<f64>()
            };
            numbers.clone().map(of_column).sum()
        };
        // Both axes are alike.
        let rows: Vec<Vec<f64>> =
            (0..=TABLE).into_par_iter().map(|j| (0..=j).map(|i| sum(nu(i), nu(j))).collect()).collect();
        let value = |i: usize, j: usize| if i <= j { rows[j][i] } else { rows[i][j] };
        let aliases = (0..=TABLE).flat_map(|j| (0..=TABLE).map(move |i| (i, j))).map(|(i, j)| value(i, j)).collect();
        Self { optics, aliases }
    }

    /// What is left of the wave of `nu` per px along x and y, each from 0 to 1/2.
    fn factor(&self, nu: [f64; 2]) -> f64 {
        let place = nu.map(|nu| 4.0 * TABLE as f64 * nu * nu);
        let [i, j] = place.map(|t| (t as usize).min(TABLE - 1));
        let [u, v] = [place[0] - i as f64, place[1] - j as f64];
        let row = |j: usize| {
            let at = j * (TABLE + 1) + i;
            self.aliases[at] + u * (self.aliases[at + 1] - self.aliases[at])
        };
        self.optics.of(nu) + row(j) + v * (row(j + 1) - row(j))
    }

    /// The picture after diffraction. Beyond its border it goes on as its mirror image, by half a pixel: no light is lost
    /// there, and none is made. The bits are the same for any number of threads.
    pub fn spread(&self, picture: &Raster<f32>) -> Raster<f64> {
        let size = [picture.width(), picture.height()];
        let values = picture.data().iter().map(|v| f64::from(*v)).collect();
        let factor =
            |k: usize, l: usize| self.factor([k as f64 / (2 * size[0]) as f64, l as f64 / (2 * size[1]) as f64]);
        Raster::from_data(size[0], size[1], Cosines::new(size).filtered(values, factor))
    }
}

fn sinc(x: f64) -> f64 {
    let v = PI * x;
    if v.abs() < 1e-8 { 1.0 } else { libm::sin(v) / v }
}
