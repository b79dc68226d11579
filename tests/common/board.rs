//! Pictures of a checkerboard whose corners are known: an exact renderer, independent of the crate's own.
//!
//! The mean of the pattern s(u) s(v), with s = 1, -1 on alternate unit intervals, over a polygon of the board is a
//! contour integral (Green): the integral of S(u) s(v) dv along its sides, with the triangular wave S' = s, which is
//! exact when each side is cut where it crosses a line of the board.

use biprism::raster::Raster;
use glam::{DMat2, DMat3, DVec2, DVec3};
use rayon::prelude::*;

/// What a pixel shows before any blur.
enum Seen {
    /// All over the same radiance.
    Even(f64),
    /// In each of its parts its own, row by row.
    Parts(Vec<f64>),
}

/// A board seen by a camera.
#[derive(Debug, Clone)]
pub struct Scene {
    pub width: usize,
    pub height: usize,
    /// Squares from straight image positions, as homogeneous coordinates.
    pub board_from_image: DMat3,
    /// Bends straight lines by this many px (sagitta over half the picture), across x and across y.
    pub bend_px: DVec2,
    /// The pattern covers squares `0..size.x` by `0..size.y`; the rest is light. `None`: it covers everything.
    pub size: Option<DVec2>,
    /// Dark and light.
    pub levels: [f64; 2],
    /// Gaussian blur, in px.
    pub sigma_px: f64,
    /// The light falls by this share from the middle to the corner of the picture, and by half of it from left to right.
    pub shade: f64,
    /// Whether it does so in the camera, behind the blur, and not on the board.
    pub vignetted: bool,
}

impl Scene {
    /// A board of square size `step` px, turned by `roll` deg, tilted by `tilt` deg about the vertical axis and seen
    /// from `distance` picture widths, whose corner (0, 0) is the middle of the picture plus `shift`.
    pub fn view(width: usize, height: usize, step: f64, roll: f64, tilt: f64, shift: DVec2) -> Self {
        let (sin, cos) = libm::sincos(roll.to_radians());
        let turn = DMat3::from_cols(DVec3::new(cos, sin, 0.0), DVec3::new(-sin, cos, 0.0), DVec3::Z);
        // X right, z away; a plane tilted about y at depth f, so that the middle keeps its scale.
        let (sin, cos) = libm::sincos(tilt.to_radians());
        let f = 1.5 * width as f64;
        // Board point (X, Y) px -> (X cos, Y, f + X sin) -> f x / z + middle.
        let tilted = DMat3::from_cols(DVec3::new(f * cos, 0.0, sin), DVec3::new(0.0, f, 0.0), DVec3::new(0.0, 0.0, f));
        let middle = DVec2::new(width as f64, height as f64) * 0.5 + shift;
        let placed = DMat3::from_cols(DVec3::X, DVec3::Y, middle.extend(1.0));
        let scale = DMat3::from_diagonal(DVec3::new(step, step, 1.0));
        Self {
            width,
            height,
            board_from_image: (placed * tilted * turn * scale).inverse(),
            bend_px: DVec2::ZERO,
            size: None,
            levels: [0.05, 0.85],
            sigma_px: 0.0,
            shade: 0.0,
            vignetted: false,
        }
    }

    /// The straight position that is seen at an image position: a bend of second and third order.
    fn straight(&self, p: DVec2) -> DVec2 {
        let half = DVec2::new(self.width as f64, self.height as f64) * 0.5;
        let q = (p - half) / half;
        let bend = |t: f64, s: f64| t * t * (1.0 + 0.2 * t) * (1.0 + 0.3 * s);
        p + DVec2::new(self.bend_px.x * bend(q.y, q.x), self.bend_px.y * bend(q.x, -q.y))
    }

    /// The board point, in squares, seen at an image position.
    pub fn board(&self, p: DVec2) -> DVec2 {
        let h = self.board_from_image * self.straight(p).extend(1.0);
        h.truncate() / h.z
    }

    fn jacobian(&self, p: DVec2) -> DMat2 {
        let h = 1e-4;
        let by = |d: DVec2| (self.board(p + d * h) - self.board(p - d * h)) / (2.0 * h);
        DMat2::from_cols(by(DVec2::X), by(DVec2::Y))
    }

    /// The image position of a board point, by Newton's method.
    pub fn image(&self, board: DVec2) -> Option<DVec2> {
        let h = self.board_from_image.inverse() * board.extend(1.0);
        if h.z <= 0.0 {
            return None;
        }
        let mut p = h.truncate() / h.z;
        for _ in 0..60 {
            let step = self.jacobian(p).inverse() * (board - self.board(p));
            p += step.clamp_length_max(20.0);
            if step.length() < 1e-11 {
                return Some(p);
            }
        }
        None
    }

    /// Every inner corner in the picture: lattice indices and image position.
    pub fn corners(&self) -> Vec<([i32; 2], DVec2)> {
        let edge = DVec2::new(self.width as f64, self.height as f64);
        // The board's extent in the picture, from its border pixels.
        let border: Vec<DVec2> = (0..=40)
            .flat_map(|k| {
                let t = f64::from(k) / 40.0;
                [DVec2::new(t, 0.0), DVec2::new(t, 1.0), DVec2::new(0.0, t), DVec2::new(1.0, t)]
            })
            .map(|t| self.board(t * edge))
            .collect();
        let low = border.iter().fold(DVec2::INFINITY, |m, p| m.min(*p)).floor();
        let high = border.iter().fold(DVec2::NEG_INFINITY, |m, p| m.max(*p)).ceil();
        let (low, high) = match self.size {
            Some(size) => (low.max(DVec2::ONE), high.min(size - 1.0)),
            None => (low, high),
        };
        let range = |a: f64, b: f64| a as i32..=b as i32;
        range(low.x, high.x)
            .flat_map(|i| range(low.y, high.y).map(move |j| [i, j]))
            .filter_map(|index| Some((index, self.image(DVec2::new(index[0].into(), index[1].into()))?)))
            .filter(|(_, p)| p.min_element() > 0.0 && (edge - *p).min_element() > 0.0)
            .collect()
    }

    /// The share of a corner's window (0.45 squares to each side) that lies in the picture.
    pub fn visible(&self, index: [i32; 2]) -> f64 {
        let edge = DVec2::new(self.width as f64, self.height as f64);
        let inside = (0..400)
            .filter(|k| {
                let t = |i: i32| (f64::from(i) + 0.5) / 20.0 * 0.9 - 0.45;
                let at = DVec2::new(f64::from(index[0]) + t(k % 20), f64::from(index[1]) + t(k / 20));
                self.image(at).is_some_and(|p| p.min_element() > 0.0 && (edge - p).min_element() > 0.0)
            })
            .count();
        inside as f64 / 400.0
    }

    /// The narrowest distance, in px, between parallel lines of the board at a corner.
    pub fn spacing(&self, index: [i32; 2]) -> f64 {
        let at = |x: i32, y: i32| self.image(DVec2::new(f64::from(index[0] + x), f64::from(index[1] + y)));
        let Some((a, b)) = at(0, 0).zip(at(1, 0)).zip(at(0, 1)).map(|((o, x), y)| (x - o, y - o)) else { return 0.0 };
        a.perp_dot(b).abs() / a.length().max(b.length())
    }

    /// The picture in linear radiance.
    pub fn render(&self) -> Raster<f32> {
        // Parts average the pattern before the blur, which adds up to a sixth of a part's square to the blur's variance,
        // depending on where in a part an edge falls: with a sixth of the blur, 0.2 % of the blur. Of a blur below 0.1 px, which
        // hardly shows, a sixtieth of a pixel will do.
        let even = if self.sigma_px == 0.0 { 1 } else { (6.0 / self.sigma_px).ceil().clamp(4.0, 60.0) as usize };
        let parts = if self.shade == 0.0 { even } else { even.max(4) };
        // What lies beyond the picture blurs into it.
        let margin = (6.0 * self.sigma_px).ceil() as usize;
        let kernel = self.kernel(parts, margin);
        let rows = self.height + 2 * margin;
        let narrow: Vec<Vec<f64>> =
            (0..rows).into_par_iter().flat_map_iter(|row| self.narrow_rows(row, parts, margin, &kernel)).collect();
        let data = (0..self.height * self.width).into_par_iter().map(|k| {
            let (i, j) = (k % self.width, k / self.width);
            let mean: f64 = kernel.iter().enumerate().map(|(r, weight)| weight * narrow[j * parts + r][i]).sum();
            if self.vignetted {
                // At the pixel's middle: over a pixel that moves an edge by a twelfth of the light's change a px.
                (mean * self.light(DVec2::new(i as f64 + 0.5, j as f64 + 0.5))) as f32
            } else {
                mean as f32
            }
        });
        Raster::from_data(self.width, self.height, data.collect())
    }

    /// The light at an image position.
    fn light(&self, p: DVec2) -> f64 {
        let edge = DVec2::new(self.width as f64, self.height as f64) * 0.5;
        let q = (p - edge) / edge;
        (1.0 - 0.5 * self.shade * q.length_squared()) * (1.0 - 0.25 * self.shade * q.x)
    }

    /// Weights of the parts of a row in a pixel: a Gaussian, summed over the pixel.
    fn kernel(&self, parts: usize, margin: usize) -> Vec<f64> {
        let reach = margin * parts;
        let sigma = (self.sigma_px * parts as f64).max(1e-9);
        let gauss: Vec<f64> = (0..=reach).map(|i| libm::exp(-0.5 * (i as f64 / sigma) * (i as f64 / sigma))).collect();
        let whole = gauss[0] + 2.0 * gauss[1..].iter().sum::<f64>();
        let mut kernel = vec![0.0; 2 * reach + parts];
        for part in 0..parts {
            for (k, slot) in kernel[part..part + 2 * reach + 1].iter_mut().enumerate() {
                *slot += gauss[k.abs_diff(reach)] / whole / parts as f64;
            }
        }
        kernel
    }

    /// The rows of parts of a row of pixels, blurred along x, of pixels as they are in the picture.
    fn narrow_rows(&self, row: usize, parts: usize, margin: usize, kernel: &[f64]) -> Vec<Vec<f64>> {
        let whole: Vec<f64> = kernel.chunks_exact(parts).map(|weights| weights.iter().sum()).collect();
        let pixels = self.pixel_row(row, parts, margin);
        let blurred = |r: usize, i: usize| {
            let of = |(k, whole): (usize, &f64)| match &pixels[i + k] {
                Seen::Even(radiance) => whole * radiance,
                Seen::Parts(fine) => {
                    kernel[k * parts..].iter().zip(&fine[r * parts..][..parts]).map(|(a, b)| a * b).sum::<f64>()
                }
            };
            whole.iter().enumerate().map(of).sum()
        };
        (0..parts).map(|r| (0..self.width).map(|i| blurred(r, i)).collect()).collect()
    }

    /// The radiance, before any blur, of a row of pixels.
    fn pixel_row(&self, row: usize, parts: usize, margin: usize) -> Vec<Seen> {
        let side = 1.0 / parts as f64;
        let radiance = |pattern: f64| self.levels[0] + (self.levels[1] - self.levels[0]) * 0.5 * (1.0 + pattern);
        let columns = self.width + 2 * margin;
        let place = |i: usize, j: usize| DVec2::new(i as f64, j as f64) - margin as f64;
        let corners = [row, row + 1].map(|j| (0..=columns).map(|i| self.board(place(i, j))).collect::<Vec<_>>());
        let is_even = self.shade == 0.0 || self.vignetted;
        let pixel = |i: usize| {
            let seen = [corners[0][i], corners[0][i + 1], corners[1][i], corners[1][i + 1]];
            let alone = self.alone(seen);
            if let (true, Some(pattern)) = (is_even, alone) {
                return Seen::Even(radiance(pattern));
            }
            let at = |x: usize, y: usize| place(i, row) + DVec2::new(x as f64, y as f64) * side;
            let n = if alone.is_some() { 0 } else { parts + 1 };
            let lattice: Vec<DVec2> = (0..n * n).map(|k| self.board(at(k % n, k / n))).collect();
            let part = |k: usize| {
                let (x, y) = (k % parts, k / parts);
                let quad = || [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)].map(|(x, y)| lattice[y * n + x]);
                let pattern = alone.unwrap_or_else(|| self.mean(quad(), at(x, y), side));
                radiance(pattern) * if is_even { 1.0 } else { self.light(at(x, y) + 0.5 * side) }
            };
            Seen::Parts((0..parts * parts).map(part).collect())
        };
        (0..columns).map(pixel).collect()
    }

    /// The pattern of a whole pixel whose corners see these places, where it sees one square alone.
    fn alone(&self, seen: [DVec2; 4]) -> Option<f64> {
        let cell = seen[0].floor();
        let inside = self.size.is_none_or(|size| cell.min_element() >= 0.0 && (size - cell).min_element() >= 1.0);
        (inside && seen.iter().all(|p| p.floor() == cell)).then(|| sign(cell.x) * sign(cell.y))
    }

    /// The mean pattern over the square of side `side` at `origin`, whose corners see `quad` on the board.
    fn mean(&self, quad: [DVec2; 4], origin: DVec2, side: f64) -> f64 {
        let cell = quad[0].floor();
        let low = quad.iter().fold(DVec2::INFINITY, |m, p| m.min(*p));
        let high = quad.iter().fold(DVec2::NEG_INFINITY, |m, p| m.max(*p));
        if let Some(size) = self.size {
            if high.x < 0.0 || high.y < 0.0 || low.x > size.x || low.y > size.y {
                return 1.0;
            }
            if low.x < 0.0 || low.y < 0.0 || high.x > size.x || high.y > size.y {
                return self.border(origin, side, size);
            }
        }
        if low.floor() == cell && high.floor() == cell {
            return sign(cell.x) * sign(cell.y);
        }
        // A map that is not affine weighs the parts of a pixel unevenly: 3 x 3 parts bring that below 1e-5 px.
        let n = if side < 1.0 { 1 } else { 3 };
        let corner = |a: usize, b: usize| self.board(origin + DVec2::new(a as f64, b as f64) * (side / n as f64));
        let sum: f64 = (0..n * n)
            .map(|k| {
                let (a, b) = (k % n, k / n);
                polygon_mean([corner(a, b), corner(a + 1, b), corner(a + 1, b + 1), corner(a, b + 1)])
            })
            .sum();
        sum / (n * n) as f64
    }

    /// A square that the border of the board crosses, by samples: no corner is measured there.
    fn border(&self, origin: DVec2, side: f64, size: DVec2) -> f64 {
        let n = 8;
        let sum: f64 = (0..n * n)
            .map(|k| {
                let at = DVec2::new((k % n) as f64 + 0.5, (k / n) as f64 + 0.5) * (side / n as f64);
                let p = self.board(origin + at);
                let inside = p.min_element() >= 0.0 && (size - p).min_element() >= 0.0;
                if inside { sign(p.x.floor()) * sign(p.y.floor()) } else { 1.0 }
            })
            .sum();
        sum / (n * n) as f64
    }
}

fn sign(cell: f64) -> f64 {
    if (cell * 0.5).fract() == 0.0 { 1.0 } else { -1.0 }
}

/// The integral of the square wave: 0 at even, 1 at odd integers.
fn triangle(u: f64) -> f64 {
    let t = u - 2.0 * (u * 0.5).floor();
    if t <= 1.0 { t } else { 2.0 - t }
}

/// The mean of the pattern over a quadrilateral of the board.
pub fn polygon_mean(quad: [DVec2; 4]) -> f64 {
    let (mut integral, mut area) = (0.0, 0.0);
    for k in 0..4 {
        let (p, q) = (quad[k], quad[(k + 1) % 4]);
        area += 0.5 * (p.x * q.y - q.x * p.y);
        let mut cuts = vec![0.0, 1.0];
        for (a, b) in [(p.x, q.x), (p.y, q.y)] {
            let (low, high) = (a.min(b), a.max(b));
            let mut line = low.floor() + 1.0;
            while line < high {
                cuts.push((line - a) / (b - a));
                line += 1.0;
            }
        }
        cuts.sort_by(f64::total_cmp);
        for pair in cuts.windows(2) {
            let (a, b) = (p.lerp(q, pair[0]), p.lerp(q, pair[1]));
            integral += 0.5 * (triangle(a.x) + triangle(b.x)) * sign((0.5 * (a.y + b.y)).floor()) * (b.y - a.y);
        }
    }
    integral / area
}

/// Normal deviates from a seed: SplitMix64 and Box-Muller.
pub struct Noise(u64);

impl Noise {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Uniform in (0, 1).
    pub fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64 + 1e-17
    }

    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * libm::log(self.uniform())).sqrt();
        radius * libm::cos(std::f64::consts::TAU * self.uniform())
    }

    /// The picture with noise of a standard deviation.
    pub fn added(&mut self, image: &Raster<f32>, sigma: f64) -> Raster<f32> {
        let data = image.data().iter().map(|&v| (f64::from(v) + sigma * self.normal()) as f32).collect();
        Raster::from_data(image.width(), image.height(), data)
    }
}
