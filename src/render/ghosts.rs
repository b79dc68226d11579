//! Ghosts: the light of reflections in the glass, added to the picture.

use super::board_face::{BoardFace, faces, point_radiance};
use super::film::Film;
use super::pixel::square;
use crate::effect::{BoardPoint, Ghosts, LightPath};
use crate::optics::fate::Fate;
use crate::optics::polarisation::PolarisationState;
use crate::prism::reflections::{Exit, GlassBody};
use crate::surface::face::Face;
use crate::system::System;
use glam::DVec2;
use rayon::prelude::*;

/// Pixels along the side of a block: where light takes the same routes to all its corners, it does to all its pixels.
const BLOCK: usize = 8;
/// Blocks that cannot be interpolated are quartered down to this many pixels along their sides.
const SMALLEST: usize = 2;
/// A block may see this much beyond what its corners see, as a share of it.
const MARGIN: f64 = 0.5;
/// The light of a pixel may be off by this, of full scale 1, through the bend of a block: less than a step of 16 bits.
const BEND: f64 = 1e-5;

/// Adds the light of ghosts to the picture of one pass of `system`, where some act.
///
/// Between the corners of a block, powers and places on the board are taken as linear, and each pixel as the exact mean
/// of the board over what it sees; where that does not hold, over quarters of it, the smallest of which are sampled: where
/// routes differ, and beside the ridge.
pub(super) fn add(system: &System, film: &mut Film) {
    let Some(pass) = GhostPass::new(system) else { return };

    // Trace the ghosts at the corners of all blocks.
    let width = film.radiance.width();
    let corners = pass.corners();
    let columns = width.div_ceil(BLOCK) + 1;

    // Add the ghosts' light block by block.
    let rows = film.radiance.data_mut().par_chunks_mut(width * BLOCK).enumerate();
    let rays: Vec<u64> = rows
        .map(|(j, rows)| {
            let of_block = |i: usize| {
                let at = |di: usize, dj: usize| corners[(j + dj) * columns + i + di].as_slice();
                let corners = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
                pass.light(
                    &GhostSquare { first: [i * BLOCK, j * BLOCK], size: BLOCK, corners },
                    &mut |[x, y], light| {
                        let pixel = &mut rows[(y - j * BLOCK) * width + x];
                        *pixel = (f64::from(*pixel) + light) as f32;
                    },
                )
            };
            (0..columns - 1).map(of_block).sum()
        })
        .collect();

    // Count the rays.
    film.counts.rays += corners.len() as u64 + rays.iter().sum::<u64>();
}

/// A square of pixels, and the ghosts at its corners.
struct GhostSquare<'a> {
    /// Column and row of its first pixel.
    first: [usize; 2],
    /// Pixels along its side.
    size: usize,
    /// At the upper left, upper right, lower left and lower right corner.
    corners: [&'a [Ghost]; 4],
}

/// Ghosts over a block of pixels.
struct GhostBlock {
    /// Pixels along its side.
    size: f64,
    /// The light, at the four corners, of all ghosts that are of one radiance over the block.
    constant: [f64; 4],
    /// The others: powers, and places on the board in squares, at the four corners.
    edges: Vec<([f64; 4], [DVec2; 4])>,
}

impl GhostBlock {
    /// The mean radiance of all ghosts over the square of side `active` in the middle of the pixel whose corner lies at
    /// `offset` from that of the block.
    fn pixel(&self, face: &BoardFace<'_>, offset: DVec2, active: f64) -> f64 {
        let size = self.size;
        let light = between(self.constant, (offset + 0.5) / size);
        let edges = self.edges.iter().map(|(powers, places)| {
            let outline = square(0.5 * active).map(|c| between(*places, (offset + 0.5 + c) / size));
            let middle = 0.25 * ((outline[0] + outline[2]) + (outline[1] + outline[3]));
            let reach = outline.iter().fold(DVec2::ZERO, |reach, p| reach.max((*p - middle).abs()));
            let radiance = face
                .constant(middle, reach)
                .or_else(|| face.mean_over(&outline))
                .unwrap_or_else(|| face.radiance(middle));
            between(*powers, (offset + 0.5) / size) * radiance
        });
        light + edges.sum::<f64>()
    }
}

/// The upper left corner of a pixel, in px.
fn place(pixel: [usize; 2]) -> DVec2 {
    DVec2::from_array(pixel.map(|n| n as f64))
}

/// The value at `at`, from 0 to 1, between those at the upper left, upper right, lower left and lower right corner.
fn between<T>([a, b, c, d]: [T; 4], at: DVec2) -> T
where
    T: Copy + std::ops::Add<Output = T> + std::ops::Sub<Output = T> + std::ops::Mul<f64, Output = T>,
{
    let (upper, lower) = (a + (b - a) * at.x, c + (d - c) * at.x);
    upper + (lower - upper) * at.y
}

/// What is fixed for a picture of ghosts.
struct GhostPass<'a> {
    system: &'a System,
    ghosts: Ghosts,
    body: GlassBody,
    light: PolarisationState,
    face: BoardFace<'a>,
    /// That and what the objects show.
    faces: Vec<BoardFace<'a>>,
    /// The largest radiance that there is.
    brightest: f64,
    /// The side of the square in the middle of a pixel that receives light, in px.
    active: f64,
    /// Columns and rows of the picture.
    size_px: [usize; 2],
}

/// A ghost at one place of the picture.
struct Ghost {
    /// The faces that its light met.
    route: u64,
    seen: GhostTarget,
    /// Its power, of 1 that would come in.
    power: f64,
}

/// What a ghost is of.
#[derive(Clone, Copy, PartialEq)]
enum GhostTarget {
    /// Something of the same radiance everywhere.
    Uniform(f64),
    /// A place on the plane of the board, in mm.
    Board(DVec2),
}

impl<'a> GhostPass<'a> {
    fn new(system: &'a System) -> Option<Self> {
        let ghosts = system.effects().ghosts.filter(|ghosts| !ghosts.is_nothing())?;
        let light = system.effects().fresnel?.light;
        let boards = std::iter::once(system).chain(system.layers()).map(|one| &one.board().pattern);
        let radiances = boards.flat_map(|board| [board.black, board.white, board.background]);
        let brightest = radiances.fold(ghosts.behind, f64::max);
        let active = system.effects().active_side();
        Some(Self {
            system,
            ghosts,
            body: system.body()?,
            light,
            face: BoardFace::new(system),
            faces: faces(system),
            brightest,
            active,
            size_px: system.camera().size_px(),
        })
    }

    /// All ghosts at the corners of all blocks, row by row.
    fn corners(&self) -> Vec<Vec<Ghost>> {
        let [columns, rows] = self.size_px.map(|n| n.div_ceil(BLOCK) + 1);
        (0..columns * rows).into_par_iter().map(|k| self.at([k % columns * BLOCK, k / columns * BLOCK])).collect()
    }

    /// All ghosts at the upper left corner of a pixel.
    fn at(&self, pixel: [usize; 2]) -> Vec<Ghost> {
        let mut ghosts = Vec::new();
        self.trace(place(pixel), |ghost| ghosts.push(ghost));
        ghosts
    }

    /// Tells the mean light of all ghosts in each pixel of a square, and says how many rays that took.
    fn light(&self, square: &GhostSquare<'_>, tell: &mut dyn FnMut([usize; 2], f64)) -> u64 {
        let GhostSquare { first: [left, top], size, corners } = *square;
        let [width, height] = self.size_px;
        let pixels = || (top..height.min(top + size)).flat_map(|y| (left..width.min(left + size)).map(move |x| [x, y]));

        // Sample where there may be an object between the corners.
        let sampled = |tell: &mut dyn FnMut([usize; 2], f64)| {
            pixels().for_each(|pixel| tell(pixel, self.sampled(place(pixel))));
            (pixels().count() * self.ghosts.samples * self.ghosts.samples) as u64
        };
        if self.faces.len() > 1 {
            return sampled(tell);
        }

        // Interpolate between the corners.
        let half = size / 2;
        let middle = self.at([left + half, top + half]);
        if let Some(block) = self.block(square, &middle) {
            let first = place([left, top]);
            pixels().for_each(|pixel| tell(pixel, block.pixel(&self.face, place(pixel) - first, self.active)));
            return 1;
        }
        if size <= SMALLEST {
            return 1 + sampled(tell);
        }

        // Go on with the quarters.
        let at = |i: usize, j: usize| self.at([left + i * half, top + j * half]);
        let [a, b, c, d] = corners;
        let [upper, lower, before, behind] = [at(1, 0), at(1, 2), at(0, 1), at(2, 1)];
        let quarters = [
            [a, &upper, &before, &middle],
            [&upper, b, &middle, &behind],
            [&before, &middle, c, &lower],
            [&middle, &behind, &lower, d],
        ];
        let quarter = |(k, corners): (usize, [&[Ghost]; 4])| {
            let first = [left + k % 2 * half, top + k / 2 * half];
            let inside = first[0] < width && first[1] < height;
            if inside { self.light(&GhostSquare { first, size: half, corners }, tell) } else { 0 }
        };
        5 + quarters.into_iter().enumerate().map(quarter).sum::<u64>()
    }

    /// The ghosts of a square of pixels, given those at its middle; `None` where they bend too much, or where light takes
    /// several routes.
    fn block(&self, square: &GhostSquare<'_>, middle: &[Ghost]) -> Option<GhostBlock> {
        // Compare the routes of light to the corners and to the middle.
        let (size, corners) = (square.size as f64, square.corners);
        let [a, others @ ..] = corners;
        let same = |other: &[Ghost]| other.len() == a.len() && other.iter().zip(a).all(|(o, a)| o.route == a.route);
        if !(others.into_iter().all(same) && same(middle)) {
            return None;
        }

        // Interpolate each ghost over the block, and add up the errors at the middle.
        let squares = self.face.squares_per_mm();
        let mut block = GhostBlock { size, constant: [0.0; 4], edges: Vec::new() };
        let mut bend = 0.0;
        for (k, middle) in middle.iter().enumerate() {
            // Compare the power at the middle with the interpolated one.
            let powers = corners.map(|corner| corner[k].power);
            let seen = corners.map(|corner| corner[k].seen);
            bend += (between(powers, DVec2::splat(0.5)) - middle.power).abs() * self.brightest;

            // Tell a ghost of one radiance from one with edges of the pattern in it.
            let radiance = match (seen, middle.seen) {
                (
                    [GhostTarget::Board(a), GhostTarget::Board(b), GhostTarget::Board(c), GhostTarget::Board(d)],
                    GhostTarget::Board(middle_mm),
                ) => {
                    // Interpolate the board points, and compare them at the middle.
                    let places = [a, b, c, d].map(|mm| mm * squares);
                    let off = (between(places, DVec2::splat(0.5)) - middle_mm * squares).abs();

                    // Find whether the block, and a margin around it, sees one radiance.
                    let (low, high) =
                        places[1..].iter().fold((places[0], places[0]), |(l, h), p| (l.min(*p), h.max(*p)));
                    let constant = self.face.constant(0.5 * (low + high), (0.5 + MARGIN) * (high - low));
                    if constant.is_none() {
                        // What a pixel sees moves by this share of itself.
                        bend += middle.power * self.brightest * (off / ((high - low) / size)).max_element();
                        block.edges.push((powers, places));
                    }
                    constant
                }

                // Demand that what is uniform be the same at all places.
                ([one @ GhostTarget::Uniform(radiance), others @ ..], at_middle) => {
                    if others.iter().any(|other| *other != one) || at_middle != one {
                        return None;
                    }
                    Some(radiance)
                }
                _ => return None,
            };

            // Add its light at the corners, where it is of one radiance.
            if let Some(radiance) = radiance {
                block.constant.iter_mut().zip(powers).for_each(|(sum, power)| *sum += power * radiance);
            }
        }
        (bend <= BEND).then_some(block)
    }

    /// The mean radiance of all ghosts over the square that receives light of the pixel whose corner is `corner`.
    fn sampled(&self, corner: DVec2) -> f64 {
        let n = self.ghosts.samples;
        let at = |k: usize| DVec2::new((k % n) as f64 + 0.5, (k / n) as f64 + 0.5) / n as f64;
        let mut sum = 0.0;
        for k in 0..n * n {
            self.trace(corner + 0.5 + (at(k) - 0.5) * self.active, |ghost| {
                let radiance = match ghost.seen {
                    GhostTarget::Uniform(radiance) => radiance,
                    GhostTarget::Board(mm) => self.face.at(mm),
                };
                sum += ghost.power * radiance;
            });
        }
        sum / (n * n) as f64
    }

    /// Tells of every ghost at an image position.
    fn trace(&self, px: DVec2, mut tell: impl FnMut(Ghost)) {
        self.system.reflected(px, self.light, self.body, &self.ghosts, |exit| {
            // Of what sends no light it does not matter where it is.
            if exit.last.face == Face::Back || self.ghosts.behind != 0.0 {
                tell(self.ghost(exit, px));
            }
        });
    }

    /// What light that leaves the glass sees, weakened as all light at `px` is: by everything but the glass.
    fn ghost(&self, exit: &Exit, px: DVec2) -> Ghost {
        let Self { system, ghosts, face, .. } = self;
        let (seen, board_point) = if exit.last.face == Face::Front {
            (GhostTarget::Uniform(ghosts.behind), None)
        } else {
            let nearest = if self.faces.len() > 1 { system.nearest(&exit.ray) } else { Err(Fate::PastBoard) };
            match nearest.or_else(|_| system.board().intersect(&exit.ray).map(|(mm, t_mm)| (0, mm, t_mm))) {
                Ok((object @ 1.., _, t_mm)) => {
                    let normal = system.layers()[object - 1].board().normal();
                    let seen = GhostTarget::Uniform(point_radiance(system, &self.faces, &exit.ray));
                    (seen, Some(BoardPoint { point_mm: exit.ray.at(t_mm), normal }))
                }
                Ok((_, board_mm, t_mm)) => {
                    let board_point = BoardPoint { point_mm: exit.ray.at(t_mm), normal: system.board().normal() };
                    (GhostTarget::Board(board_mm), Some(board_point))
                }
                Err(_) => (GhostTarget::Uniform(face.background()), None),
            }
        };
        let path = LightPath { image_cos: system.camera().image_cos(px), crossings: &[], landing: board_point };
        Ghost { route: exit.route, seen, power: exit.power * system.effects().throughput(&path) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::Accuracy;
    use crate::effect::{Effects, Fresnel, Lamp};
    use crate::render::Plan;
    use crate::render::bands::picture;
    use crate::render::film::Outputs;
    use crate::render::tests::{built, instruments, scene};
    use glam::DVec3;

    /// Blocks against a picture of which every pixel is sampled finely.
    #[test]
    fn blocks_show_the_ghosts_of_every_pixel() {
        let lamp = Lamp::new(DVec3::new(-400.0, 300.0, 200.0), 0.9, DVec3::new(0.0, 0.0, 1000.0), DVec3::Z);
        let ghosts = Ghosts { bounces: 4, least_power: 1e-9, behind: 0.2, samples: 4 };
        let effects = Effects {
            fresnel: Some(Fresnel { light: PolarisationState::Unpolarised }),
            ghosts: Some(ghosts),
            lamp: Some(lamp),
            ..Effects::default()
        };
        let board = "columns = 41\nrows = 41\nsquare_mm = 10.0\nposition_mm = [0.0, 0.0, 1000.0]\nbackground = 0.0";
        let flat = |degrees: f64, index: f64| {
            let text = format!(
                "kind = \"flat\"\nfacet_angle_deg = {degrees}\nindex = {index}\nridge_distance_mm = 78.472\nthickness_mm = 8.545"
            );
            (text.clone(), built(&scene(90, 60, &text, board), Accuracy::exact()))
        };
        let some = instruments(Accuracy::exact(), 1).into_iter().step_by(5);
        for (name, system) in some.chain([flat(0.0, 1.48), flat(0.0, 2.4), flat(1.0, 2.4)]) {
            let system = system.with_effects(&effects);
            let Some(pass) = GhostPass::new(&system) else { continue };
            let plain = picture(&Plan::new(&system), Outputs { truth: false }, &());
            let mut with = plain.clone();
            add(&system, &mut with);
            let [width, height] = system.camera().size_px();
            if name.contains("facet_angle_deg = 0\nindex = 1.48") {
                // Only the ridge parts the routes of light in a plate.
                let sampled = BLOCK * height * ghosts.samples * ghosts.samples;
                assert!((with.counts.rays - plain.counts.rays) as usize <= sampled + 200, "{name}");
            }
            let (mut sum, mut count) = (0.0, 0.0);
            for (j, i) in (0..height).step_by(5).flat_map(|j| (0..width).step_by(3).map(move |i| (j, i))) {
                let found = f64::from(with.radiance.get(i, j)) - f64::from(plain.radiance.get(i, j));
                let wanted = pass.sampled(DVec2::new(i as f64, j as f64));
                // Rounding of two pictures to f32, of radiances up to 2; the bend; and an edge of a ghost of 3 % among 4 x
                // 4 samples, which count it to an eighth.
                let bound = 2.5e-7 + 2.0 * BEND + 0.03 * 0.8 / 8.0;
                assert!((found - wanted).abs() < bound, "({i}, {j}): {found} {wanted}\n{name}");
                (sum, count) = (sum + (found - wanted), count + 1.0);
            }
            // Samples err either way, at one pixel in ten.
            assert!((sum / count).abs() < 1e-4, "{name}: {}", sum / count);
        }
    }
}
