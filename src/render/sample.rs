//! Small pieces of the work of a picture, by which its time is told without making it.

use super::band::Band;
use super::bands::{picture, render_band};
use super::centre_rays::CentreTracer;
use super::checkerboard::Checkerboard;
use super::diffraction::{add_cells, cells};
use super::film::{Film, Outputs};
use super::plan::Plan;
use super::region::Region;
use super::{ghosts, mapped};
use crate::accuracy::Sampling;
use crate::effect::diffraction::LightSpread;
use crate::system::System;
use glam::DVec2;

/// Rows of a piece that the map makes.
const MAPPED_ROWS: usize = 2;

/// How many pixels of a picture are made in each way; those copied from their mirror images are not counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PixelWork {
    /// By the certified map.
    pub mapped: usize,
    /// By rays.
    pub traced: usize,
}

/// A piece of a picture that was made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PieceOfWork {
    /// Whether the map made it.
    pub mapped: bool,
    /// Its pixels.
    pub pixels: usize,
    /// Estimate of what the bend of the map inside its pixels moves lines by, at most.
    pub bend_px: f64,
}

impl Plan<'_> {
    /// How the pixels of the picture are made.
    pub fn pixel_work(&self) -> PixelWork {
        let count = |regions: &mut dyn Iterator<Item = &Region>| -> usize {
            regions.map(|region| region.columns.len() * region.rows.len()).sum()
        };
        PixelWork {
            mapped: count(
                &mut self.patches.iter().map(|patch| &patch.region).chain(self.seams.iter().map(|s| &s.region)),
            ),
            traced: count(&mut self.traced.iter()),
        }
    }

    /// Makes the piece of the picture at `place`, each from 0 to 1 over the columns and rows that are made: two rows of a
    /// patch of the map, or a square of `side` traced pixels.
    pub fn sample(&self, place: DVec2, side: usize) -> PieceOfWork {
        let [width, height] = self.system.camera().size_px();
        let first = if self.mirrored { width / 2 } else { 0 };
        let at = |from: usize, to: usize, share: f64| (from + ((to - from) as f64 * share) as usize).min(to - 1);
        let (x, y) = (at(first, width, place.x), at(0, height, place.y));
        match self.patches.iter().find(|patch| patch.region.columns.contains(&x) && patch.region.rows.contains(&y)) {
            Some(patch) => {
                let rows = y..patch.region.rows.end.min(y + MAPPED_ROWS);
                let mut radiance = vec![0.0; width * rows.len()];
                let mut band =
                    Band { width, first_column: 0, first_row: rows.start, radiance: &mut radiance, truth: None };
                let work = mapped::render(self, patch, &mut band);
                let pixels = patch.region.columns.len() * rows.len();
                PieceOfWork { mapped: true, pixels, bend_px: work.bend_px }
            }
            None => self.traced_square([x, y], side),
        }
    }

    /// Makes a square of `side` traced pixels at `place`, each from 0 to 1 over the pixels that the plan traces, few as they may be; `None`
    /// where it traces none.
    pub fn sample_traced(&self, place: DVec2, side: usize) -> Option<PieceOfWork> {
        let pixels = |region: &Region| region.columns.len() * region.rows.len();
        let mut at = (place.x * self.pixel_work().traced as f64) as usize;
        for region in &self.traced {
            if at < pixels(region) {
                let row = ((place.y * region.rows.len() as f64) as usize).min(region.rows.len() - 1);
                let px = [region.columns.start + at / region.rows.len(), region.rows.start + row];
                return Some(self.traced_square(px, side));
            }
            at -= pixels(region);
        }
        None
    }

    fn traced_square(&self, first: [usize; 2], side: usize) -> PieceOfWork {
        let window = window(self.system, first, side);
        let [width, height] = window.camera().size_px();
        let mut radiance = vec![0.0; width * height];
        let mut band = Band { width, first_column: 0, first_row: 0, radiance: &mut radiance, truth: None };
        let work = render_band(&traced(self, &window), &mut band);
        PieceOfWork { mapped: false, pixels: width * height, bend_px: work.bend_px }
    }
}

/// The instrument with a sensor that is a square of `side` pixels of its own, or what of it there is, from pixel `first` on.
fn window(system: &System, first: [usize; 2], side: usize) -> System {
    let [width, height] = system.camera().size_px();
    let side = [side.min(width), side.min(height)];
    system.window([first[0].min(width - side[0]), first[1].min(height - side[1])], side)
}

/// The plan of all pixels of `window`, a part of the instrument of `plan`, by rays.
fn traced<'a>(plan: &Plan, window: &'a System) -> Plan<'a> {
    let [width, height] = window.camera().size_px();
    Plan {
        system: window,
        pattern: Checkerboard::new(&window.board().pattern),
        plate: window.plate(),
        objects: Vec::new(),
        centre_tracer: CentreTracer::new(window, window.accuracy().sampling != Sampling::SingleRays),
        patches: Vec::new(),
        seams: Vec::new(),
        traced: vec![Region { columns: 0..width, rows: 0..height }],
        truncation_px: plan.truncation_px,
        rays: 0,
        mirrored: false,
        has_throughput: plan.has_throughput,
        steep: plan.steep,
        truth_alone: false,
        active: plan.active,
        straight_ridge: plan.straight_ridge,
        few_pixels: plan.few_pixels,
        creases: plan.creases,
        kinks: plan.kinks,
        by_triangles: plan.by_triangles,
    }
}

/// A part of a picture to which ghosts are to be added.
#[derive(Debug)]
pub struct GhostSample {
    window: System,
    film: Film,
}

impl GhostSample {
    /// The square of `side` pixels of the instrument of `plan` at `place`, each from 0 to 1 over the picture.
    pub fn new(plan: &Plan, place: DVec2, side: usize) -> Self {
        let at = |n: usize, share: f64| ((n as f64 * share) as usize).min(n - 1);
        let [width, height] = plan.system.camera().size_px();
        let window = window(plan.system, [at(width, place.x), at(height, place.y)], side);
        let film = picture(&traced(plan, &window), Outputs { truth: false }, &());
        Self { window, film }
    }

    /// Adds them; returns how many pixels that were.
    pub fn add(&mut self) -> usize {
        ghosts::add(&self.window, &mut self.film);
        self.film.radiance.data().len()
    }
}

/// A part of a picture whose light is to be spread by diffraction.
#[derive(Debug)]
pub struct DiffractionSample {
    window: System,
    even: Film,
    spread: LightSpread,
}

impl DiffractionSample {
    /// The square of `side` pixels, or what there is of it, in the middle of the picture of a `system` that diffracts, in
    /// light of its first variant.
    ///
    /// # Panics
    /// When diffraction does not act.
    pub fn new(system: &System, side: usize) -> Self {
        let effects = system.effects();
        let lens = effects.diffracting().expect("diffraction acts");
        let window = window(system, system.camera().size_px().map(|n| n.saturating_sub(side) / 2), side);
        let instrument = window.variant(&effects.variants(0).get(0));
        let even = picture(&Plan::new(&instrument), Outputs { truth: false }, &());
        Self { window, even, spread: LightSpread::new(lens, effects.collecting_side(), cells(system)) }
    }

    /// Spreads its light, with the cells of `passes` variants; returns how many pixels that were.
    pub fn spread(&self, passes: usize) -> usize {
        let variant = self.window.effects().variants(0).get(0);
        let mut sum = self.spread.pixels.spread(&self.even.radiance);
        if let Some(cells) = &self.spread.cells {
            let variants = vec![(1.0, variant); passes];
            add_cells(&self.window, (&self.even, &variants), (cells, 0), std::slice::from_mut(&mut sum), &());
        }
        sum.data().len()
    }
}
