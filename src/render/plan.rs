//! The render plan: everything that is fixed for a picture, decided before its first pixel.

use super::centre_rays::CentreTracer;
use super::checkerboard::Checkerboard;
use super::film::AccuracyReport;
use super::map::MapPatch;
use super::region::Region;
use super::seam_map::SeamMap;
use super::steepness::is_steep;
use super::tiling::{Tiling, certify};
use super::truncation_error;
use super::work::Work;
use crate::accuracy::{Accuracy, Sampling};
use crate::effect::Hook;
use crate::optics::fate::Fate;
use crate::render::film::Counts;
use crate::surface::face::Face;
use crate::surface::shape::Surface;
use crate::system::{Side, System};
use crate::texture::Plate;
use glam::DVec2;
use std::ops::Range;

/// Rows of a band, the part of a picture that one thread makes at a time: few enough to balance the load, many enough
/// for the extra row above and below to be cheap.
pub(super) const BAND_ROWS: usize = 48;

/// In a picture of at most so many pixels all of the glass may lie within one.
const FEW_PIXELS: usize = 150;

/// Facets of a surface up to which the creases between them are followed where triangles do not tell what is seen: beyond them they
/// fill the picture.
const MOST_FACETS: usize = 256;
/// What the map may stray from its expansion at the corners of a pixel, as a share of the bend allowed.
pub(super) const KINK_STRAY_SHARE: f64 = 0.5;
/// Pieces up to which kinks are followed, in the pixels in which they matter, and facets where triangles tell what is seen.
const MOST_PIECES: usize = 1 << 16;

/// Lines between the parts of surfaces of triangles: creases between facets, kinks between pieces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PartBorders {
    /// There are none.
    None,
    /// Pixels are cut along them.
    Few,
    /// There are so many that pixels in which they matter hold no promise.
    Many,
}

impl PartBorders {
    fn of(parts: usize, most: usize) -> Self {
        match parts {
            0 | 1 => Self::None,
            few if few <= most => Self::Few,
            _ => Self::Many,
        }
    }
}

/// The plan of a picture.
#[derive(Debug)]
pub struct Plan<'a> {
    /// The instrument.
    pub(super) system: &'a System,
    /// The board's radiance.
    pub(super) pattern: Checkerboard,
    /// What the board shows in place of its squares, where it has a texture.
    pub(super) plate: Option<&'a Plate>,
    /// The plans of the same picture before each of the objects besides the board.
    pub(super) objects: Vec<Plan<'a>>,
    /// How centres are traced.
    pub(super) centre_tracer: CentreTracer<'a>,
    /// Rectangles that a polynomial map stands for.
    pub(super) patches: Vec<MapPatch>,
    /// The columns that seams between ways through the glass pass through, where maps stand for them.
    pub(super) seams: Vec<SeamMap>,
    /// Rectangles whose every pixel is traced.
    pub(super) traced: Vec<Region>,
    /// What the Taylor expansions of traced pixels are wrong by, in px: see [`truncation_error`].
    pub(super) truncation_px: f64,
    /// Rays that planning took.
    pub(super) rays: u64,
    /// Whether the left half is copied from the right half, whose mirror image it is.
    pub(super) mirrored: bool,
    /// Whether transport effects change what pixels receive.
    pub(super) has_throughput: bool,
    /// Whether they change it so steeply that some pixels are taken by parts.
    pub(super) steep: bool,
    /// Whether nothing is wanted but the ground truth.
    pub(super) truth_alone: bool,
    /// The side of the square in the middle of a pixel that receives light, in px.
    pub(super) active: f64,
    /// Whether the ridge is seen as a straight line, being that of two planes or the picture's own middle.
    pub(super) straight_ridge: bool,
    /// Whether the picture has so few pixels that all of the glass may lie within one.
    pub(super) few_pixels: bool,
    /// The creases of the prism.
    pub(super) creases: PartBorders,
    /// Its kinks.
    pub(super) kinks: PartBorders,
    /// Whether the triangles of its meshes tell what a pixel sees.
    pub(super) by_triangles: bool,
}

impl<'a> Plan<'a> {
    /// Plans the picture of one pass of `system`, that of the instrument through the middle of its pupil: chooses the loops
    /// and, where its accuracy level samples by one, fits and checks the map.
    pub fn new(system: &'a System) -> Self {
        let sampling = system.accuracy().sampling;
        let has_throughput = system.effects().act_by(Hook::Transport);
        // Transport effects need not be symmetric.
        let mirrored = sampling != Sampling::SingleRays && !has_throughput && system.is_mirror_symmetric();
        Self::by(system, sampling, mirrored, 1).with_throughput()
    }

    /// The plan of a picture of `cells` x `cells` pixels to a real one, by a map that is not copied from its mirror image, of
    /// which parts can be rendered.
    pub(super) fn of_parts(system: &'a System, cells: usize) -> Self {
        Self::by(system, Sampling::Map, false, cells.div_ceil(2)).with_throughput()
    }

    /// The plan of the ground truth alone, without a picture.
    pub(super) fn of_truth(system: &'a System) -> Self {
        fn truth_alone(plan: Plan) -> Plan {
            Plan { truth_alone: true, objects: plan.objects.into_iter().map(truth_alone).collect(), ..plan }
        }
        truth_alone(Self::new(system))
    }

    /// The plan with the transport effects of its instrument.
    fn with_throughput(mut self) -> Self {
        self.objects = self.objects.into_iter().map(Self::with_throughput).collect();
        self.has_throughput = self.system.effects().act_by(Hook::Transport);
        self.steep = self.has_throughput && is_steep(self.system, &mut self.rays);
        self
    }

    /// A plan by a given way of sampling, of both halves or of the right one, which is then copied: the picture is the
    /// same. The smallest patches of a map are `grain` times as large as in a plain picture.
    pub(super) fn by(system: &'a System, sampling: Sampling, mirrored: bool, grain: usize) -> Self {
        let [width, height] = system.camera().size_px();
        let first = if mirrored { width / 2 } else { 0 };
        let all = Region { columns: first..width, rows: 0..height };
        let mut tiling = match sampling {
            Sampling::SingleRays | Sampling::Packets => Tiling { traced: vec![all], ..Tiling::default() },
            Sampling::Map => certify(system, first, grain),
        };
        let [facets, pieces] = system.most_parts();
        let by_triangles = system.is_told_by_triangles();
        let by_differences = sampling != Sampling::SingleRays && !tiling.traced.is_empty();
        let kinks = PartBorders::of(pieces, MOST_PIECES);
        let truncation_px = match (by_differences, kinks) {
            (false, _) => 0.0,
            (true, PartBorders::None) => truncation_error::of_differences_px(system, &mut tiling.rays),
            // Expansions stand where they hold.
            (true, _) => KINK_STRAY_SHARE * system.accuracy().bend_px,
        };
        Self {
            system,
            truncation_px,
            pattern: Checkerboard::new(&system.board().pattern),
            plate: system.plate(),
            objects: system.layers().iter().map(|layer| Self::by(layer, sampling, false, grain)).collect(),
            centre_tracer: CentreTracer::new(system, sampling != Sampling::SingleRays),
            patches: tiling.patches,
            seams: tiling.seams,
            traced: tiling.traced,
            rays: tiling.rays,
            mirrored,
            has_throughput: false,
            steep: false,
            truth_alone: false,
            active: system.effects().active_side(),
            few_pixels: width * height <= FEW_PIXELS,
            creases: PartBorders::of(facets, if by_triangles { MOST_PIECES } else { MOST_FACETS }),
            kinks,
            by_triangles,
            straight_ridge: system.prism().is_none_or(|prism| {
                let plane = |side| matches!(prism.surface(side, Face::Front), Surface::Plane { .. });
                system.camera().keeps_lines() && [Side::Left, Side::Right].into_iter().all(plane)
            }),
        }
    }

    /// What transport effects leave to `px` of what it sees; 1 without such effects.
    #[inline(always)]
    pub(super) fn throughput(&self, px: DVec2) -> f64 {
        if self.has_throughput { self.system.throughput(px) } else { 1.0 }
    }

    /// Multiplies pixels of a row, the first with its centre at `start`, by their throughput.
    pub(super) fn attenuate_row(&self, start: DVec2, row: &mut [f32], work: &mut Work) {
        work.counts.rays += row.len() as u64;
        for (i, value) in row.iter_mut().enumerate() {
            *value = (f64::from(*value) * self.system.throughput(start + DVec2::new(i as f64, 0.0))) as f32;
        }
    }

    /// The instrument of this pass.
    pub fn system(&self) -> &System {
        self.system
    }

    /// What the picture's own way of sampling says that `px` sees, in mm on the board: the map where it stands, the traced
    /// ray elsewhere.
    ///
    /// # Errors
    /// The fate of a ray that never reaches the board.
    pub fn trace(&self, px: DVec2) -> Result<DVec2, Fate> {
        let width = self.system.camera().size_px()[0] as f64;
        let inside = |region: &Region, px: DVec2| {
            let (columns, rows) = (&region.columns, &region.rows);
            let within = |v: f64, range: &Range<usize>| v >= range.start as f64 && v <= range.end as f64;
            within(px.x, columns) && within(px.y, rows)
        };
        let by_seam = |px: DVec2| self.seams.iter().find(|seam| inside(&seam.region, px)).map(|seam| seam.side_at(px));
        let by_patch = |px: DVec2| self.patches.iter().find(|patch| inside(&patch.region, px));
        let mapped = |px: DVec2| by_patch(px).or_else(|| by_seam(px)).map(|patch| patch.trace(px).0);
        let mm = 1.0 / self.pattern.squares_per_mm();
        if let Some(seen) = mapped(px) {
            return Ok(seen * mm);
        }
        if self.mirrored
            && let Some(seen) = mapped(DVec2::new(width - px.x, px.y))
        {
            return Ok(DVec2::new(-seen.x, seen.y) * mm);
        }
        self.system.trace(px).map(|hit| hit.board_mm)
    }

    /// The accuracy left to pixels by their Taylor expansions, whose third order is left out: that much less. Where
    /// nothing is left, such pixels are traced in parts.
    pub(super) fn less(&self, truncation_px: f64) -> Accuracy {
        Accuracy { bend_px: self.system.accuracy().bend_px - truncation_px, ..*self.system.accuracy() }
    }

    /// Whether pixels beside creases are cut along them.
    pub(super) fn follows_creases(&self) -> bool {
        self.creases == PartBorders::Few || (self.by_triangles && self.creases == PartBorders::Many)
    }

    /// The account of the planning.
    pub(super) fn work(&self) -> Work {
        Work { counts: Counts { rays: self.rays, ..Counts::default() }, bend_px: 0.0 }
    }

    /// What the picture promises and keeps, given the work on all its bands.
    pub(super) fn account_of(&self, work: &Work) -> AccuracyReport {
        let halves = if self.mirrored { 2 } else { 1 };
        AccuracyReport { unpromised_pixels: halves * work.counts.unpromised_pixels, ..self.account(work.bend_px) }
    }

    /// Everything that the map consists of.
    fn all_patches(&self) -> impl Iterator<Item = &MapPatch> {
        self.patches.iter().chain(self.seams.iter().flat_map(|seam| &seam.sides))
    }

    /// The largest error of a map, of the board and of objects.
    fn map_px(&self) -> f64 {
        let objects = self.objects.iter().map(Self::map_px);
        self.all_patches().map(|p| p.error_px).chain(objects).fold(0.0, f64::max)
    }

    /// What the picture promises and keeps, given the bend left inside its pixels.
    pub fn account(&self, bend_px: f64) -> AccuracyReport {
        let [width, height] = self.system.camera().size_px();
        let sides = if self.mirrored { 2 } else { 1 };
        let regions = self.patches.iter().map(|patch| &patch.region).chain(self.seams.iter().map(|seam| &seam.region));
        let mapped: usize = regions.map(|region| region.columns.len() * region.rows.len()).sum();
        let accuracy = &self.system.accuracy();
        let truncations = self.all_patches().map(|p| p.truncation_px).chain([self.truncation_px]);
        let truncation_px = truncations.filter(|truncation| *truncation < accuracy.bend_px).fold(0.0, f64::max);
        AccuracyReport {
            level: accuracy.level,
            target_px: accuracy.target_px,
            promise_px: accuracy.promise_px,
            map_px: self.map_px(),
            bend_px: bend_px + truncation_px,
            patches: sides * self.patches.len() + 2 * self.seams.len(),
            mapped: (sides * mapped) as f64 / (width * height) as f64,
            passes: 1,
            noise: None,
            noise_target: None,
            unpromised_pixels: 0,
        }
    }
}
