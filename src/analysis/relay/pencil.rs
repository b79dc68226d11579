//! A pencil: the rays of one point through one half of the prism.

use crate::geom::Ray;
use crate::optics::fate::Fate;
use crate::optics::refraction::Refraction;
use crate::prism::biprism::Prism;
use crate::prism::payload::{Differentials, Payload, Refractions};
use crate::system::{Side, System};
use glam::{DMat2, DVec2, DVec3};
use rayon::prelude::*;

/// A hit may lie this far from its surface, in mm: some roundings of the lengths of a prism.
const RESIDUAL_MM: f64 = 1e-12;
/// Newton's method gives up after this many steps.
const MAX_STEPS: usize = 40;
/// A ray is aimed to this, as sine of its direction: some roundings.
const AIMED: f64 = 1e-15;

/// The rays of one point through one side of the prism, continued beyond the ridge as if that side went on.
#[derive(Debug, Clone, Copy)]
pub struct Pencil<'a> {
    prism: &'a Prism,
    side: Side,
    source_mm: DVec3,
    /// Tangents of the direction of the half image's middle, where searches start.
    middle: DVec2,
}

/// A ray of a pencil behind the prism.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PencilRay {
    /// Tangents dx/dz and dy/dz of the direction in which it left the source.
    pub start: DVec2,
    /// From where it leaves the back, in the world, in mm.
    pub exit: Ray,
    /// From the source to the back, each length times its index, in mm.
    pub optical_path_mm: f64,
    /// Its two refractions, in the world.
    pub refractions: [Refraction; 2],
}

/// A ray with its derivatives by its start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FanRay {
    /// From where it leaves the back, in the world, in mm.
    pub exit: Ray,
    /// The derivatives of the exit ray by the two tangents of its start, at the back: of its origin across the ray and of its direction.
    pub fans: [[DVec3; 2]; 2],
}

impl<'a> Pencil<'a> {
    /// The pencil of the point `offset_mm` from the pinhole of the camera of `system` through `prism`.
    pub fn new(system: &System, prism: &'a Prism, side: Side, offset_mm: DVec3) -> Self {
        let [width, height] = system.camera().size_px().map(|n| n as f64);
        let quarter = if side == Side::Left { 0.25 } else { 0.75 };
        let middle = system.camera().ray(DVec2::new(quarter * width, 0.5 * height)).direction;
        let source_mm = system.camera().position_mm() + offset_mm;
        Self { prism, side, source_mm, middle: middle.truncate() / middle.z }
    }

    /// The prism.
    pub fn prism(&self) -> &Prism {
        self.prism
    }

    /// Tangents of the direction of the half image's middle.
    pub fn middle(&self) -> DVec2 {
        self.middle
    }

    fn ray(&self, start: DVec2) -> Ray {
        Ray { origin: self.source_mm, direction: start.extend(1.0).normalize() }
    }

    /// The ray behind the prism that left the source in the direction of the tangents `start`, with what it carries.
    pub(super) fn passed<C: Payload>(&self, start: DVec2, carry: &mut C) -> Result<Ray, Fate> {
        self.prism.pass_through(&self.ray(start), self.side, RESIDUAL_MM, carry)
    }

    /// The ray that leaves the source in the direction of the tangents `start`.
    ///
    /// # Errors
    /// Its fate, where it does not leave the prism.
    pub fn at(&self, start: DVec2) -> Result<PencilRay, Fate> {
        let mut passed = Refractions::default();
        let exit = self.passed(start, &mut passed)?;
        let refractions = passed.crossings().ok_or(Fate::Missed)?;
        let [outside, glass] = self.prism.indices();
        let optical_path_mm = outside * refractions[0].way_mm + glass * refractions[1].way_mm;
        Ok(PencilRay { start, exit, optical_path_mm, refractions })
    }

    /// The same with its derivatives.
    ///
    /// # Errors
    /// Its fate, where it does not leave the prism.
    pub fn fans(&self, start: DVec2) -> Result<FanRay, Fate> {
        let ray = self.ray(start);
        let along = start.extend(1.0).length();
        let step = |axis: DVec3| (axis - ray.direction * ray.direction.dot(axis)) / along;
        let mut carried = Differentials { origin: [DVec3::ZERO; 2], direction: [step(DVec3::X), step(DVec3::Y)] };
        let exit = self.passed(start, &mut carried)?;
        let across = |v: DVec3| v - exit.direction * exit.direction.dot(v);
        let fans = [0, 1].map(|k| [across(carried.origin[k]), carried.direction[k]]);
        Ok(FanRay { exit, fans })
    }

    /// The ray that has the sines `sines` of its direction behind the prism, along x and y of the world: what the lens takes in at
    /// that place of its pupil. The search starts from the tangents `from`, and halves a step that does not improve.
    ///
    /// # Errors
    /// [`Fate::NotConverged`] when there is none; the fate of a ray on the way.
    pub fn aimed(&self, sines: DVec2, from: DVec2) -> Result<PencilRay, Fate> {
        let off = |fan: &FanRay| fan.exit.direction.truncate() - sines;
        let (mut start, mut here) = (from, self.fans(from)?);
        for _ in 0..MAX_STEPS {
            let left = off(&here);
            let [x, y] = here.fans.map(|[_, turn]| turn.truncate());
            let jacobian = DMat2::from_cols(x, y);
            if jacobian.determinant() == 0.0 {
                break;
            }
            let mut step = jacobian.inverse() * -left;
            let better = loop {
                match self.fans(start + step) {
                    Ok(fan) if off(&fan).length() < left.length() => break Some(fan),
                    _ if step.length() < f64::EPSILON * (1.0 + start.length()) => break None,
                    _ => step *= 0.5,
                }
            };
            match better {
                Some(fan) => (start, here) = (start + step, fan),
                None if left.length() < 1e3 * AIMED => return self.at(start),
                None => break,
            }
            if off(&here).length() <= AIMED {
                return self.at(start);
            }
        }
        Err(Fate::NotConverged)
    }

    /// The rays at places of the pupil, in their order, each by its own search from the middle one.
    ///
    /// # Errors
    /// The fate of the first that does not leave the prism, with its place.
    pub fn pupil(&self, na: f64, places: &[DVec2]) -> Result<Vec<PencilRay>, (DVec2, Fate)> {
        let middle = self.aimed(DVec2::ZERO, self.middle).map_err(|fate| (DVec2::ZERO, fate))?;
        let [x, y] = self.fans(middle.start).map_err(|fate| (DVec2::ZERO, fate))?.fans.map(|[_, turn]| turn.truncate());
        let guess = DMat2::from_cols(x, y).inverse();
        let aimed = |p: &DVec2| {
            let sines = *p * na;
            let near = middle.start + guess * sines;
            self.aimed(sines, near).or_else(|_| self.aimed(sines, middle.start)).map_err(|fate| (*p, fate))
        };
        places.par_iter().map(aimed).collect::<Vec<_>>().into_iter().collect()
    }
}

/// Where the line of a ray meets the plane at `z_mm`.
pub fn at_plane(ray: &Ray, z_mm: f64) -> DVec2 {
    (ray.origin + ray.direction * ((z_mm - ray.origin.z) / ray.direction.z)).truncate()
}
