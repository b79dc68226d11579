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
        let taps = self.kernel.taps();
        let n = taps.rows.len();
        let reach = (n - PARTS).div_ceil(2 * PARTS);
        let offset = reach * PARTS - (n - PARTS) / 2;
        let fine = self.bright_parts(reach);
        // Where a blur is a product of one along x and one along y, rows are blurred first, and then columns.
        let rows: Vec<Vec<f64>> = match &taps.product {
            None => Vec::new(),
            Some(line) => {
                fine.par_iter().map(|row| (0..width).map(|i| sum(line, &row[i * PARTS + offset..])).collect()).collect()
            }
        };
        let [dark, light] = self.scene.levels;
        let data = (0..width * height).into_par_iter().map(|k| {
            let (i, y) = (k % width, k / width * PARTS + offset);
            let share: f64 = match &taps.product {
                Some(line) => line.iter().zip(&rows[y..]).map(|(a, row)| a * row[i]).sum(),
                None => {
                    let of = |(row, (from, taps)): (&Vec<f64>, &(usize, Vec<f64>))| {
                        sum(taps, &row[i * PARTS + offset + from..])
                    };
                    fine[y..].iter().zip(&taps.rows).map(of).sum()
                }
            };
            (dark + (light - dark) * share) as f32
        });
        Raster::from_data(width, height, data.collect())
    }

    /// The bright share of every part of the picture's pixels and of `reach` pixels around it, row by row.
    fn bright_parts(&self, reach: usize) -> Vec<Vec<f64>> {
        let part = 1.0 / PARTS as f64;
        let [columns, rows] = [self.scene.width, self.scene.height].map(|pixels| pixels + 2 * reach);
        let board =
            |x: usize, y: usize| self.scene.board(DVec2::new(x as f64 + 0.5, y as f64 + 0.5) * part - reach as f64);
        let of_pixels = |row: usize| {
            let mut parts = vec![vec![0.0; columns * PARTS]; PARTS];
            for column in 0..columns {
                let (x, y) = (column * PARTS, row * PARTS);
                let corners = [(0, 0), (PARTS, 0), (0, PARTS), (PARTS, PARTS)].map(|(i, j)| board(x + i, y + j));
                if let Some(even) = self.even(corners) {
                    parts.iter_mut().for_each(|parts| parts[x..x + PARTS].fill(even));
                    continue;
                }
                let seen: [[DVec2; PARTS + 1]; PARTS + 1] =
                    std::array::from_fn(|j| std::array::from_fn(|i| board(x + i, y + j)));
                for (j, parts) in parts.iter_mut().enumerate() {
                    for (i, share) in parts[x..x + PARTS].iter_mut().enumerate() {
                        let here = seen[j][i];
                        *share = self.bright(here, (seen[j][i + 1] - here).abs() + (seen[j + 1][i] - here).abs());
                    }
                }
            }
            parts
        };
        (0..rows).into_par_iter().flat_map_iter(of_pixels).collect()
    }

    /// What all of a pixel shows whose corners see these places, where they lie within one square by more than the pixel and the ink.
    fn even(&self, corners: [DVec2; 4]) -> Option<f64> {
        let low = corners.iter().fold(DVec2::INFINITY, |m, p| m.min(*p));
        let high = corners.iter().fold(DVec2::NEG_INFINITY, |m, p| m.max(*p));
        let room = (high - low) + self.ink.abs();
        let cell = (low - room).floor();
        let size = self.scene.size.unwrap_or(DVec2::splat(f64::INFINITY));
        let is_one = (high + room).floor() == cell && cell.min_element() >= 0.0 && (size - cell).min_element() >= 1.0;
        is_one.then(|| f64::from(u8::from((cell.x + cell.y) % 2.0 == 0.0)))
    }

    /// The bright share of a part of a pixel whose middle sees `board`, and which extends over `extent` along the board's axes.
    fn bright(&self, board: DVec2, extent: DVec2) -> f64 {
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

/// The sum of parts by their weights.
fn sum(weights: &[f64], parts: &[f64]) -> f64 {
    // Eight sums side by side do not wait for each other.
    let mut sums = [0.0; 8];
    let (eights, rest) = weights.as_chunks::<8>();
    for (a, b) in eights.iter().zip(parts.as_chunks::<8>().0) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    let rest: f64 = rest.iter().zip(&parts[8 * eights.len()..]).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}

/// Weights over parts, of a pixel's square under a blur; their sum is 1.
struct Taps {
    /// Of each row, those that are not zero, and the place of the first of them.
    rows: Vec<(usize, Vec<f64>)>,
    /// Where the weights are a product: its factor along x, which is that along y.
    product: Option<Vec<f64>>,
}

impl Kernel {
    fn taps(self) -> Taps {
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
            for (i, v) in row.iter().enumerate().filter(|(_, v)| **v > 0.0) {
                for line in &mut taps[j..j + PARTS] {
                    line[i..i + PARTS].iter_mut().for_each(|t| *t += v / whole);
                }
            }
        }
        let is_product = matches!(self, Self::Gaussian(_)) || matches!(self, Self::Square(_, 0.0));
        let product = is_product.then(|| taps.iter().map(|row| row.iter().sum()).collect());
        let trimmed = |row: Vec<f64>| {
            let from = row.iter().position(|v| *v > 0.0).unwrap_or(n);
            let end = row.iter().rposition(|v| *v > 0.0).map_or(from, |last| last + 1);
            (from, row[from..end].to_vec())
        };
        Taps { rows: taps.into_iter().map(trimmed).collect(), product }
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
    let decoded: Vec<f32> = (0..=255).map(|code| read.decode(f64::from(code) / 255.0) as f32).collect();
    light.map(|v| {
        let v = (exposure * f64::from(v) - black).clamp(0.0, 1.0);
        decoded[(tone.encode(v) * 255.0).round() as usize]
    })
}
