//! Pictures of a checkerboard as cameras and printers make them: ink that spreads, any symmetric blur, a stated exposure, a
//! tone curve, eight bits. The corners stay where [`Scene`] has them.
//!
//! A square that grows by the same on all sides keeps the middle between two of a colour, which is the corner. The picture is
//! summed over a lattice of parts of a pixel, each with its own share of light: no formula of the detector is used.

use super::board::Scene;
use biprism::raster::Raster;
use glam::DVec2;
use rayon::prelude::*;

/// Parts of a pixel along each axis.
const PARTS: usize = 4;

/// A blur that is alike to both sides of every line through its middle; lengths in px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kernel {
    /// A Gaussian of this standard deviation.
    Gaussian(f64),
    /// A disc of this radius: a lens out of focus.
    Disc(f64),
    /// A square of this side, turned by this angle in rad.
    Square(f64, f64),
    /// A line of this length at this angle in rad: motion.
    Line(f64, f64),
    /// A perfect lens: its first dark ring has this radius.
    Airy(f64),
}

/// A board, what its ink did, and the blur of the picture.
#[derive(Debug, Clone)]
pub struct Twin {
    /// Where the board lies; its own blur and shade are not used.
    pub scene: Scene,
    /// By how much of a square the edges of black squares lie outside them.
    pub ink: f64,
    /// The blur.
    pub kernel: Kernel,
}

impl Twin {
    /// A board of `inner` corners on white paper, squares of `step` px, turned by 3 deg and tilted by 8.
    pub fn board(inner: [usize; 2], step: f64) -> Self {
        let size = DVec2::new((inner[0] + 1) as f64, (inner[1] + 1) as f64);
        let side = |n: usize| ((n + 2) as f64 * step * 1.12) as usize + 24;
        let mut scene = Scene::view(side(inner[0]), side(inner[1]), step, 3.0, 8.0, DVec2::new(3.25, -4.63));
        scene.board_from_image = glam::DMat3::from_translation(size * 0.5) * scene.board_from_image;
        scene.size = Some(size);
        Self { scene, ink: 0.0, kernel: Kernel::Gaussian(1.0) }
    }

    /// The same board turned and tilted by other angles in deg, whole in a picture as wide as its diagonal.
    pub fn posed(inner: [usize; 2], step: f64, roll: f64, tilt: f64) -> Self {
        let size = DVec2::new((inner[0] + 1) as f64, (inner[1] + 1) as f64);
        let side = ((size + 1.0).length() * step) as usize + 20;
        let mut scene = Scene::view(side, side, step, roll, tilt, DVec2::new(3.25, -4.63));
        scene.board_from_image = glam::DMat3::from_translation(size * 0.5) * scene.board_from_image;
        scene.size = Some(size);
        Self { scene, ..Self::board(inner, step) }
    }

    /// The picture in linear radiance, between the scene's levels.
    pub fn render(&self) -> Raster<f32> {
        let (width, height) = (self.scene.width, self.scene.height);
        let kernel = self.kernel.taps();
        let reach = (kernel.len() - PARTS).div_ceil(2 * PARTS);
        let (columns, rows) = ((width + 2 * reach) * PARTS, (height + 2 * reach) * PARTS);
        let fine: Vec<f32> = (0..columns * rows)
            .into_par_iter()
            .map(|k| {
                let place = DVec2::new((k % columns) as f64 + 0.5, (k / columns) as f64 + 0.5) / PARTS as f64;
                self.bright(place - reach as f64) as f32
            })
            .collect();
        let [dark, light] = self.scene.levels;
        let data = (0..width * height).into_par_iter().map(|k| {
            let (x, y) = ((k % width) * PARTS, (k / width) * PARTS);
            let offset = reach * PARTS - (kernel.len() - PARTS) / 2;
            let row = |j: usize| &fine[(y + offset + j) * columns + x + offset..];
            let sum: f64 = kernel
                .iter()
                .enumerate()
                .map(|(j, taps)| taps.iter().zip(row(j)).map(|(a, b)| a * f64::from(*b)).sum::<f64>())
                .sum();
            (dark + (light - dark) * sum) as f32
        });
        Raster::from_data(width, height, data.collect())
    }

    /// The bright share of a part of a pixel around an image position.
    fn bright(&self, p: DVec2) -> f64 {
        let board = self.scene.board(p);
        let side = 1.0 / PARTS as f64;
        let (right, below) = (self.scene.board(p + DVec2::X * side), self.scene.board(p + DVec2::Y * side));
        // The part's extent along each axis of the board.
        let extent = (right - board).abs() + (below - board).abs();
        let size = self.scene.size.unwrap_or(DVec2::splat(f64::INFINITY));
        let dark = |even: f64| {
            let share = |u: f64, parity: f64, w: f64, size: f64| {
                // The nearest square of this parity along this axis, grown by the ink.
                let cell = 2.0 * ((u - parity - 0.5) * 0.5).round() + parity;
                if cell < 0.0 || cell + 1.0 > size {
                    return 0.0;
                }
                let covered = |edge: f64| (edge / w + 0.5).clamp(0.0, 1.0);
                covered(u - (cell - self.ink)) * covered(cell + 1.0 + self.ink - u)
            };
            share(board.x, even, extent.x, size.x) * share(board.y, 1.0 - even, extent.y, size.y)
        };
        // Squares of both kinds overlap where ink spreads.
        let (a, b) = (dark(0.0), dark(1.0));
        1.0 - (a + b - a * b)
    }
}

impl Kernel {
    /// Weights over parts, of a pixel's square under the blur; their sum is 1.
    fn taps(self) -> Vec<Vec<f64>> {
        let reach = match self {
            Self::Gaussian(s) => 5.0 * s,
            Self::Disc(r) => r,
            Self::Square(a, _) => 0.71 * a,
            Self::Line(l, _) => 0.5 * l,
            Self::Airy(r) => 5.0 * r,
        };
        let half = (reach * PARTS as f64).ceil() as i32 + 1;
        // The point spread, by points within each part.
        let points = 6;
        let spread = |i: i32, j: i32| -> f64 {
            (0..points * points)
                .map(|k| {
                    let at = |k: i32| (f64::from(k) + 0.5) / f64::from(points) - 0.5;
                    self.at(DVec2::new(f64::from(i) + at(k % points), f64::from(j) + at(k / points)) / PARTS as f64)
                })
                .sum()
        };
        let mut point: Vec<Vec<f64>> = (-half..=half).map(|j| (-half..=half).map(|i| spread(i, j)).collect()).collect();
        if let Self::Line(length, angle) = self {
            point.iter_mut().for_each(|row| row.fill(0.0));
            let (sin, cos) = libm::sincos(angle);
            let n = 4000;
            for k in 0..n {
                let t = ((f64::from(k) + 0.5) / f64::from(n) - 0.5) * length * PARTS as f64;
                // Shared among four parts in proportion, so that the line's middle stays.
                let at = DVec2::new(t * cos, t * sin) + f64::from(half);
                let (low, part) = (at.floor(), at.fract());
                for (dx, wx) in [(0, 1.0 - part.x), (1, part.x)] {
                    for (dy, wy) in [(0, 1.0 - part.y), (1, part.y)] {
                        point[low.y as usize + dy][low.x as usize + dx] += wx * wy;
                    }
                }
            }
        }
        let whole: f64 = point.iter().flatten().sum::<f64>() * (PARTS * PARTS) as f64;
        let n = point.len() + PARTS - 1 + usize::from((point.len() + PARTS - 1) % 2 != PARTS % 2);
        let mut taps = vec![vec![0.0; n]; n];
        for (j, row) in point.iter().enumerate() {
            for (i, v) in row.iter().enumerate() {
                for line in &mut taps[j..j + PARTS] {
                    line[i..i + PARTS].iter_mut().for_each(|t| *t += v / whole);
                }
            }
        }
        taps
    }

    /// The point spread, but for a factor.
    fn at(self, p: DVec2) -> f64 {
        match self {
            Self::Gaussian(s) => libm::exp(-0.5 * p.length_squared() / (s * s)),
            Self::Disc(r) => f64::from(u8::from(p.length() < r)),
            Self::Square(a, angle) => {
                let (sin, cos) = libm::sincos(angle);
                let q = DVec2::new(cos * p.x + sin * p.y, cos * p.y - sin * p.x).abs();
                f64::from(u8::from(q.max_element() < 0.5 * a))
            }
            Self::Line(..) => 0.0,
            Self::Airy(r) => {
                let v = 3.831_705_970_207_512 * p.length() / r;
                let amplitude = if v < 1e-6 { 0.5 } else { libm::j1(v) / v };
                amplitude * amplitude
            }
        }
    }
}

/// A tone curve, from light 0..1 to code 0..1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tone {
    Linear,
    Srgb,
    Rec709,
    Gamma(f64),
    /// sRGB and then 3 v^2 - 2 v^3, mixed in by this share.
    S(f64),
}

impl Tone {
    pub fn encode(self, v: f64) -> f64 {
        match self {
            Self::Linear => v,
            Self::Srgb if v <= 0.003_130_8 => 12.92 * v,
            Self::Srgb => 1.055 * libm::pow(v, 1.0 / 2.4) - 0.055,
            Self::Rec709 if v < 0.018 => 4.5 * v,
            Self::Rec709 => 1.099 * libm::pow(v, 0.45) - 0.099,
            Self::Gamma(g) => libm::pow(v, 1.0 / g),
            Self::S(share) => {
                let s = Self::Srgb.encode(v);
                s + share * (s * s * (3.0 - 2.0 * s) - s)
            }
        }
    }

    pub fn decode(self, code: f64) -> f64 {
        match self {
            Self::Linear => code,
            Self::Srgb if code <= 0.040_45 => code / 12.92,
            Self::Srgb => libm::pow((code + 0.055) / 1.055, 2.4),
            Self::Rec709 if code < 0.081 => code / 4.5,
            Self::Rec709 => libm::pow((code + 0.099) / 1.099, 1.0 / 0.45),
            Self::Gamma(g) => libm::pow(code, g),
            Self::S(_) => unreachable!("no reader knows it"),
        }
    }
}

/// Light that a camera took `exposure` times as strong and less `black`, as eight bits by `tone`, read as `read`.
pub fn photographed(light: &Raster<f32>, exposure: f64, black: f64, tone: Tone, read: Tone) -> Raster<f32> {
    light.map(|v| {
        let v = (exposure * f64::from(v) - black).clamp(0.0, 1.0);
        read.decode((tone.encode(v) * 255.0).round() / 255.0) as f32
    })
}
