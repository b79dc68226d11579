//! The ring test: whether the picture around a point alternates bright, dark, bright, dark, by the harmonics of a
//! circle.

use crate::num::simd::{Kernel, widest};
use crate::raster::Raster;
use glam::DVec2;

/// Samples on the ring.
const SAMPLES: usize = 32;
/// Radius of the ring, in px.
pub(super) const RADIUS_PX: f64 = 4.5;
/// The least share of the second harmonic in the power of harmonics 1 to 8: a crossing at 90 deg has 0.9, one of 50
/// deg 0.7, an edge 0, a square's corner 0.3. (A line has 0.8; it has no saddle.)
const SHARE: f64 = 0.55;
/// Taps to one side of the Gaussian of 0.8 px that quiets the samples.
const TAPS: isize = 2;
const SIGMA_PX: f64 = 0.8;
/// Pixels to one side that the samples reach after smoothing.
const REACH: isize = 6;
const SIDE: usize = (2 * REACH + 1) as usize;
const RAW_SIDE: usize = SIDE + 2 * TAPS as usize;

/// What the ring around a crossing shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ring {
    /// Direction of the bright lobes, in rad, in `[-pi/2, pi/2]`; it turns by 90 deg from a corner to its neighbour.
    pub(super) lobe_rad: f64,
    /// Magnitude of the second harmonic, in the unit of the picture.
    pub(super) amplitude: f64,
    /// Unit vectors along the four arms (edges) that leave the crossing, by rising angle; opposite arms are two apart.
    pub(super) arms: [DVec2; 4],
}

/// Harmonics whose power is summed, and the one of a crossing.
const HARMONICS: usize = 8;
const SECOND: usize = 2;
/// Lanes of a sum.
const LANES: usize = 4;

/// The fixed numbers of the test: computed once for a picture.
#[derive(Debug)]
pub(super) struct RingTest {
    circle: [DVec2; SAMPLES],
    /// Cosines and sines of each harmonic, from the first on, at the samples.
    waves: [[[f64; SAMPLES]; 2]; HARMONICS],
    kernel: [f64; TAPS as usize + 1],
}

impl RingTest {
    pub(super) fn new() -> Self {
        let circle = std::array::from_fn(|i| {
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * i as f64 / SAMPLES as f64);
            DVec2::new(cos, sin)
        });
        let raw: [f64; TAPS as usize + 1] =
            std::array::from_fn(|i| libm::exp(-0.5 * (i * i) as f64 / (SIGMA_PX * SIGMA_PX)));
        let sum = raw[0] + 2.0 * raw[1..].iter().sum::<f64>();
        let wave = |k: usize| [0, 1].map(|axis| std::array::from_fn(|i| circle[i * k % SAMPLES][axis]));
        Self { circle, waves: std::array::from_fn(|k| wave(k + 1)), kernel: raw.map(|v| v / sum) }
    }

    /// The ring around `position`, or `None` where it shows no crossing of two edges. The border pixel stands for
    /// what lies outside the picture.
    pub(super) fn test(&self, image: &Raster<f32>, position: DVec2) -> Option<Ring> {
        let values = widest(RingSamples { test: self, image, position });

        // Compare the second harmonic with the power of all, which only grows: most places are told by the first of them.
        let harmonic = |k: usize| self.waves[k - 1].each_ref().map(|wave| 2.0 / SAMPLES as f64 * dot(wave, &values));
        let power = |[x, y]: [f64; 2]| x * x + y * y;
        let second = DVec2::from_array(harmonic(SECOND));
        let own = second.length_squared();
        let mut total = 0.0;
        for k in 1..=HARMONICS {
            total += if k == SECOND { own } else { power(harmonic(k)) };
            if own <= SHARE * total {
                return None;
            }
        }

        // Where the ring crosses its middle level, it crosses an edge.
        let (low, high) = values.iter().fold((values[0], values[0]), |(low, high), &v| (v.min(low), v.max(high)));
        let middle = 0.5 * (low + high);
        let mut arms = [DVec2::ZERO; 4];
        let mut count = 0;
        for i in 0..SAMPLES {
            let (a, b) = (values[i] - middle, values[(i + 1) % SAMPLES] - middle);
            if (a < 0.0) != (b < 0.0) {
                if count == 4 {
                    return None;
                }
                arms[count] = self.circle[i].lerp(self.circle[(i + 1) % SAMPLES], a / (a - b)).normalize();
                count += 1;
            }
        }
        let lobe_rad = 0.5 * libm::atan2(second.y, second.x);
        (count == 4).then_some(Ring { lobe_rad, amplitude: second.length(), arms })
    }
}

/// Four lanes, summed in a fixed order.
#[inline(always)]
fn dot(a: &[f64; SAMPLES], b: &[f64; SAMPLES]) -> f64 {
    let mut sums = [0.0; LANES];
    for i in (0..SAMPLES).step_by(LANES) {
        for lane in 0..LANES {
            sums[lane] += a[i + lane] * b[i + lane];
        }
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}

/// The smoothed picture on the ring around a position.
struct RingSamples<'a> {
    test: &'a RingTest,
    image: &'a Raster<f32>,
    position: DVec2,
}

impl Kernel for RingSamples<'_> {
    type Out = [f64; SAMPLES];

    #[inline(always)]
    fn run(self) -> [f64; SAMPLES] {
        // Take the pixels around it, in the picture or its border's.
        let Self { test: RingTest { circle, kernel, .. }, image, position } = self;
        let (width, height) = (image.width() as isize, image.height() as isize);
        let (ci, cj) = (position.x.floor() as isize, position.y.floor() as isize);
        let left = ci - REACH - TAPS;
        let inside = left >= 0 && left + (RAW_SIDE as isize) <= width;
        let mut rows = [[0.0f64; SIDE]; RAW_SIDE];
        for (r, row) in rows.iter_mut().enumerate() {
            let source = image.row((cj - REACH - TAPS + r as isize).clamp(0, height - 1) as usize);
            let raw: [f64; RAW_SIDE] = if inside {
                let source = &source[left as usize..][..RAW_SIDE];
                std::array::from_fn(|c| f64::from(source[c]))
            } else {
                std::array::from_fn(|c| f64::from(source[(left + c as isize).clamp(0, width - 1) as usize]))
            };

            // Smooth them along the row.
            for (c, out) in row.iter_mut().enumerate() {
                *out =
                    kernel[0] * raw[c + 2] + kernel[1] * (raw[c + 1] + raw[c + 3]) + kernel[2] * (raw[c] + raw[c + 4]);
            }
        }

        // Smooth them across the rows.
        let mut smooth = [[0.0f64; SIDE]; SIDE];
        for (r, out) in smooth.iter_mut().enumerate() {
            for (c, out) in out.iter_mut().enumerate() {
                *out = kernel[0] * rows[r + 2][c]
                    + kernel[1] * (rows[r + 1][c] + rows[r + 3][c])
                    + kernel[2] * (rows[r][c] + rows[r + 4][c]);
            }
        }

        // Interpolate them on the ring.
        let corner = DVec2::new((ci - REACH) as f64 + 0.5, (cj - REACH) as f64 + 0.5);
        let mut values = [0.0; SAMPLES];
        for (value, direction) in values.iter_mut().zip(circle) {
            let at = position + *direction * RADIUS_PX - corner;
            // A cast cuts off: the ring lies on the positive side.
            let (i, j) = ((at.x as usize).min(SIDE - 2), (at.y as usize).min(SIDE - 2));
            let (fx, fy) = (at.x - i as f64, at.y - j as f64);
            let (above, below) = (&smooth[j], &smooth[j + 1]);
            let [one, other] = [above[i] + fx * (above[i + 1] - above[i]), below[i] + fx * (below[i + 1] - below[i])];
            *value = one + fy * (other - one);
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(f: impl Fn(f64, f64) -> f32) -> Raster<f32> {
        Raster::from_data(
            32,
            32,
            (0..1024).map(|k| f((k % 32) as f64 + 0.5 - 16.0, (k / 32) as f64 + 0.5 - 16.0)).collect(),
        )
    }

    #[test]
    fn a_crossing_passes_and_shows_its_bright_lobes_and_arms() {
        let image = picture(|x, y| if x * y > 0.0 { 0.9 } else { 0.1 });
        let ring = RingTest::new().test(&image, DVec2::splat(16.0)).unwrap();
        assert!((ring.lobe_rad - std::f64::consts::FRAC_PI_4).abs() < 1e-9);
        for expected in [DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y, DVec2::X] {
            assert!(ring.arms.iter().any(|arm| (*arm - expected).length() < 1e-6), "{expected}");
        }
        assert!((ring.arms[0] + ring.arms[2]).length() < 1e-6);
    }

    #[test]
    fn an_edge_a_square_and_a_flat_field_fail() {
        let shapes: [fn(f64, f64) -> f32; 3] =
            [|x, _| (x > 0.0) as u8 as f32, |x, y| (x > 0.0 && y > 0.0) as u8 as f32, |_, _| 0.5];
        for shape in shapes {
            assert_eq!(RingTest::new().test(&picture(shape), DVec2::splat(16.0)), None);
        }
    }
}
