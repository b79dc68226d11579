//! Draft pixels of a patch of the map: f32, and coverage to first order.
//!
//! The mean of a product of two square waves over a pixel is taken as the product of their means, each that of a line that
//! is straight in the pixel: exact where only one line crosses. Pixels that two lines cross are handed back. The map's
//! derivatives are those of the middle of a run of blocks.

use super::checkerboard::Square;

/// What rounding in f32 makes of a position within a few squares, in px, for squares of at most 256 px.
const ROUNDING_PX: f64 = 1e-4;
/// 1.5 * 2^23: numbers near it are 1 apart.
const UNITS: f32 = 12_582_912.0;

/// Estimate of what is wrong with a pixel's value, in shares of its contrast, given how far the map strays from its tangent
/// in a pixel, in px: derivatives are taken 64 px from where they hold at most, over which a side of a pixel's footprint
/// changes by 4 * 64 times as much, and the share of a pixel by an eighth of that.
pub(super) fn error_px(stray_px: f64) -> f64 {
    33.0 * stray_px + ROUNDING_PX
}

/// The map over a run of blocks: derivatives to the right, down, and twice to the right, in squares and px.
#[derive(Debug, Clone, Copy)]
pub(super) struct Steps {
    pub(super) down: [f64; 2],
    pub(super) bend: [f64; 2],
}

/// A wave across one axis over a block of pixels.
struct AxisWave {
    middle: f32,
    slope: f32,
    half_bend: f32,
    /// Half the sum and half the difference of the sides of a pixel's footprint, in squares.
    wide: f32,
    narrow: f32,
    inverse_long: f32,
    inverse_both: f32,
}

impl AxisWave {
    #[inline(always)]
    fn new(middle: f64, slope: f64, down: f64, bend: f64, active: f64) -> Self {
        let (x, y) = ((active * slope).abs(), (active * down).abs());
        // A line along a side of the pixel leaves no share to the other side.
        let (long, short) = (x.max(y), x.min(y).max(1e-9));
        Self {
            middle: middle as f32,
            slope: slope as f32,
            half_bend: (0.5 * bend) as f32,
            wide: (0.5 * (long + short)) as f32,
            narrow: (0.5 * (long - short)) as f32,
            inverse_long: (1.0 / long) as f32,
            inverse_both: (0.5 / (long * short)) as f32,
        }
    }

    /// How much of the pixel `d` px from the block's middle lies beyond the nearest line, and the bits whose highest is set
    /// in odd squares.
    #[inline(always)]
    fn beyond(&self, d: f32) -> (f32, u32) {
        let u = self.middle + d * (self.slope + d * self.half_bend);
        let marked = u + UNITS;
        let line = 0.5 - (u - (marked - UNITS)).abs();
        let rest = self.wide - line;
        let across = 0.5 - line * self.inverse_long;
        let corner = rest * rest * self.inverse_both;
        let share = if line < self.narrow { across } else { corner };
        (if rest > 0.0 { share } else { 0.0 }, marked.to_bits() << 31)
    }
}

/// The pixels of a block.
pub(super) struct DraftBlock {
    pub(super) value: [f32; BLOCK],
    /// Whether a line passes through the pixel.
    pub(super) lined: [bool; BLOCK],
    /// Whether two lines do, and the value is not to be used.
    pub(super) crossed: [bool; BLOCK],
}

/// The pixels of a block whose middle sees `square` and steps from it to the right by `slope`.
#[inline(always)]
pub(super) fn block(square: &Square, slope: [f64; 2], steps: &Steps, active: f64) -> DraftBlock {
    let wave =
        |axis: usize| AxisWave::new(square.offset[axis], slope[axis], steps.down[axis], steps.bend[axis], active);
    let waves = [wave(0), wave(1)];
    let (mean, contrast) = (square.mean as f32, square.contrast as f32);
    let mut out = DraftBlock { value: [0.0; BLOCK], lined: [false; BLOCK], crossed: [false; BLOCK] };
    for i in 0..BLOCK {
        let d = i as f32 + 0.5 - 0.5 * BLOCK as f32;
        let ((bu, su), (bv, sv)) = (waves[0].beyond(d), waves[1].beyond(d));
        let product = contrast * (1.0 - 2.0 * bu) * (1.0 - 2.0 * bv);
        out.value[i] = mean + f32::from_bits(product.to_bits() ^ ((su ^ sv) & (1 << 31)));
        out.lined[i] = bu + bv > 0.0;
        out.crossed[i] = bu * bv > 0.0;
    }
    out
}

/// Pixels of a row that are filled at once when no line of the pattern can touch them.
pub(super) const BLOCK: usize = 16;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Pose;
    use crate::render::checkerboard::Checkerboard;
    use crate::scene::BoardSpec;
    use glam::DVec2;

    /// Against the exact mean over the pixel's parallelogram.
    #[test]
    fn pixels_that_one_line_crosses_have_their_mean() {
        let pattern = Checkerboard::new(&BoardSpec {
            columns: 40,
            rows: 40,
            square_mm: 1.0,
            margin_mm: 0.0,
            world_from_board: Pose::IDENTITY,
            black: 0.1,
            white: 0.9,
            background: 0.4,
        });
        let (mut lines, mut handed_back) = (0, 0);
        for k in 0..2000 {
            let wave = |n: usize| libm::sin((k * n) as f64);
            let middle = 15.0 * DVec2::new(wave(13), wave(17));
            let (right, down) = (0.05 * DVec2::new(wave(3), wave(5)), 0.05 * DVec2::new(wave(7), wave(11)));
            let square = pattern.square(middle, DVec2::splat(1.0)).expect("amid the squares");
            let steps = Steps { down: down.to_array(), bend: [0.0; 2] };
            let out = block(&square, right.to_array(), &steps, 1.0);
            lines += out.lined.iter().filter(|lined| **lined).count();
            for (i, value) in out.value.into_iter().enumerate() {
                let seen = middle + right * (i as f64 + 0.5 - 0.5 * BLOCK as f64);
                let (a, b) = (0.5 * right, 0.5 * down);
                let polygon = [seen - a - b, seen + a - b, seen + a + b, seen - a + b];
                let Some(mean) = pattern.mean_over(&polygon) else { continue };
                if out.crossed[i] {
                    handed_back += 1;
                } else {
                    // 2^-24 of numbers up to 8, over a footprint that may be a hundredth of 0.05 squares wide.
                    assert!((f64::from(value) - mean).abs() < 1e-3, "{k} {i}: {value} {mean}");
                }
            }
        }
        assert!(lines > 2000 && handed_back > 20, "{lines} {handed_back}");
    }
}
