//! Light to film.

mod border;
pub mod coverage;
mod cover;
mod cut;
mod divided;
mod draft;
mod film;
mod ghosts;
mod looks;
mod map;
mod mapped;
mod passes;
mod piece;
mod plan;
mod reference;
mod settled;
mod strips;
pub mod supersample;
mod third;
mod tile;

use crate::accuracy::{Level, Sampling};
use crate::effect::Hook;
use crate::optics::fate::Fate;
use crate::raster::Raster;
use crate::system::{Side, System};
use plan::BAND_ROWS;
use rayon::prelude::*;
use std::ops::Range;

pub use plan::Plan;
pub use strips::{STRIP_ROWS, Strip, render_strips, strip_rows};

/// A rendered picture with its own account.
#[derive(Debug, Clone, PartialEq)]
pub struct Film {
    /// Mean radiance over each pixel, of full scale 1; what film effects make of it, where there are some.
    pub radiance: Raster<f32>,
    /// The same of red, green and blue, where the sensor tells them apart.
    pub colour: Option<Raster<[f32; 3]>>,
    /// Standard error of the radiance, estimated from the spread of random sets of samples; `None` where there is one set or
    /// nothing is sampled.
    pub noise: Option<Raster<f32>>,
    /// What happened to each pixel's centre ray; 0 x 0 where [`Wanted`] leaves it out.
    pub class: Raster<Class>,
    /// The board position that each pixel's centre sees, in mm; (0, 0) where `class` is no side; 0 x 0 where [`Wanted`]
    /// leaves it out.
    pub board_mm: Raster<[f32; 2]>,
    /// How much work it was.
    pub counts: Counts,
    /// What was promised, and what was found.
    pub account: Account,
}

/// The accuracy of a picture: what its level promises, and what was found while it was made. All in px, of positions as the
/// geometry of each of its pictures has them: neither samples of a pupil, slopes or wavelengths nor film effects count here.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Account {
    /// The level.
    pub level: Level,
    /// What was asked for, where the level was chosen by that.
    pub target_px: Option<f64>,
    /// No edge or corner is farther from its place in the reference.
    pub promise_px: f64,
    /// Largest difference between the map and the rays that checked it; 0 where all pixels were traced.
    pub map_px: f64,
    /// Estimate of what the bend of the map inside a pixel moves lines by, at most. Of the reference: by how
    /// much the map strays from a linear one inside its smallest parts, at most.
    pub bend_px: f64,
    /// Patches of the map.
    pub patches: usize,
    /// Share of the pixels for which the map stands; the others were traced.
    pub mapped: f64,
    /// Pictures that the picture is the mean of.
    pub passes: usize,
    /// Standard error of a pixel in the worst block of 16 x 16 px, of full scale 1, where random sets tell it.
    pub noise: Option<f64>,
    /// Pixels of the picture for which all this does not hold: see [`Counts::unpromised_pixels`].
    #[serde(skip_serializing_if = "is_zero")]
    pub unpromised_pixels: u64,
}

/// Whether nothing was counted.
#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks for it")]
fn is_zero(count: &u64) -> bool {
    *count == 0
}

impl Account {
    /// The accuracy achieved, as far as the picture itself can tell.
    pub fn achieved_px(&self) -> f64 {
        self.map_px + self.bend_px
    }
}

impl std::fmt::Display for Account {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { level, promise_px, map_px, bend_px, patches, mapped, .. } = self;
        write!(f, "{}", level.name())?;
        if let Some(target_px) = self.target_px {
            write!(f, ", the cheapest level that keeps to {target_px:.0e} px")?;
        }
        let achieved_px = self.achieved_px();
        if *promise_px == 0.0 {
            write!(f, ": the judge of the other levels, off by {achieved_px:.1e} px of geometry")
        } else if achieved_px <= *promise_px {
            write!(f, ": promises {promise_px:.0e} px of geometry and keeps to {achieved_px:.1e} px")
        } else {
            write!(f, ": promises {promise_px:.0e} px of geometry, but reaches only {achieved_px:.1e} px")
        }?;
        match patches {
            0 => write!(f, " (every pixel traced)"),
            _ => write!(
                f,
                " (map of {patches} {} for {:.1} % of the pixels, off by {map_px:.1e} px; bend inside pixels {bend_px:.1e} px)",
                if *patches == 1 { "patch" } else { "patches" },
                100.0 * mapped
            ),
        }?;
        if self.passes > 1 {
            write!(f, "; that is each of {} pictures, of which this is the mean", self.passes)?;
        }
        match self.noise {
            Some(noise) => write!(f, ", with a standard error of {noise:.1e} of full scale in the worst block"),
            None if self.passes > 1 => write!(f, ", and their sampling not counted"),
            None => Ok(()),
        }?;
        match self.unpromised_pixels {
            0 => Ok(()),
            1 => write!(f, "; without 1 pixel at a border of the light, which holds no promise"),
            n => write!(f, "; without {n} pixels at borders of the light, which hold no promise"),
        }
    }
}

/// What of a [`Film`] is asked for besides the radiance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Wanted {
    /// The ground truth of every pixel: `class` and `board_mm`.
    pub truth: bool,
}

/// What a ray came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Class {
    /// It saw the board's plane through the left side.
    Left = 0,
    /// It saw the board's plane through the right side.
    Right = 1,
    /// It met no surface where one is given.
    Missed = 2,
    /// It was totally reflected.
    TotalReflection = 3,
    /// The solver gave it up.
    NotConverged = 4,
    /// It never meets the board's plane.
    PastBoard = 5,
    /// It met the rim of the glass, a ridge that is not sharp, or a stop.
    Clipped = 6,
}

impl Class {
    /// The side through which the board's plane was seen, if it was.
    #[inline(always)]
    pub fn side(self) -> Option<Side> {
        match self {
            Self::Left => Some(Side::Left),
            Self::Right => Some(Side::Right),
            _ => None,
        }
    }

    /// The class of the mirror image.
    fn mirrored(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Right => Self::Left,
            dark => dark,
        }
    }
}

impl From<Fate> for Class {
    fn from(fate: Fate) -> Self {
        match fate {
            Fate::Missed => Self::Missed,
            Fate::TotalReflection => Self::TotalReflection,
            Fate::NotConverged => Self::NotConverged,
            Fate::PastBoard => Self::PastBoard,
            Fate::Clipped => Self::Clipped,
        }
    }
}

/// How much work a picture was; the same for any number of threads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
pub struct Counts {
    /// Rays traced to the board or to their fate.
    pub rays: u64,
    /// Pixels whose value needed an area integral.
    pub edge_pixels: u64,
    /// Pixels that were divided because the map bends in them.
    pub divided_pixels: u64,
    /// Pixels whose division ended at the most parts allowed, before they kept to what is asked for.
    pub capped_pixels: u64,
    /// Pixels cut by the ridge or by the border of a fate.
    pub cut_pixels: u64,
    /// Pixels that hold no promise: those beside or under the border of a fate, which may be curved or have corners, and those
    /// whose division along a ridge ended at the most parts allowed. It is told with the accuracy of the picture, not here.
    #[serde(skip)]
    pub unpromised_pixels: u64,
}

impl std::ops::AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.rays += other.rays;
        self.edge_pixels += other.edge_pixels;
        self.divided_pixels += other.divided_pixels;
        self.capped_pixels += other.capped_pixels;
        self.cut_pixels += other.cut_pixels;
        self.unpromised_pixels += other.unpromised_pixels;
    }
}

/// The account of a part of a picture.
#[derive(Debug, Clone, Copy, Default)]
struct Work {
    counts: Counts,
    bend_px: f64,
}

impl Work {
    /// What planning took.
    fn of(plan: &Plan) -> Self {
        Self { counts: Counts { rays: plan.rays, ..Counts::default() }, bend_px: 0.0 }
    }

    /// The account of the whole picture of `plan`.
    fn account(&self, plan: &Plan) -> Account {
        let halves = if plan.mirrored { 2 } else { 1 };
        Account { unpromised_pixels: halves * self.counts.unpromised_pixels, ..plan.account(self.bend_px) }
    }
}

impl std::ops::AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        self.counts += other.counts;
        self.bend_px = self.bend_px.max(other.bend_px);
    }
}

/// The rows of a picture that one thread makes, written where they stay.
struct Band<'a> {
    /// Columns of the picture.
    width: usize,
    /// The picture's row that is the band's first.
    first_row: usize,
    radiance: &'a mut [f32],
    truth: Option<Truth<'a>>,
}

/// Ground truth of a band.
struct Truth<'a> {
    class: &'a mut [Class],
    board_mm: &'a mut [[f32; 2]],
}

impl Band<'_> {
    fn rows(&self) -> usize {
        self.radiance.len() / self.width
    }

    /// Copies the right half over the left half, mirrored.
    fn mirror(&mut self) {
        let half = self.width / 2;
        for row in self.radiance.chunks_exact_mut(self.width) {
            let (left, right) = row.split_at_mut(half);
            left.iter_mut().rev().zip(right).for_each(|(l, r)| *l = *r);
        }
        if let Some(truth) = &mut self.truth {
            for row in truth.class.chunks_exact_mut(self.width) {
                let (left, right) = row.split_at_mut(half);
                left.iter_mut().rev().zip(right).for_each(|(l, r)| *l = r.mirrored());
            }
            for row in truth.board_mm.chunks_exact_mut(self.width) {
                let (left, right) = row.split_at_mut(half);
                left.iter_mut().rev().zip(right).for_each(|(l, r)| *l = [-r[0], r[1]]);
            }
        }
    }
}

/// The picture that `system` takes, with its ground truth; `progress` hears how many more pixels are done,
/// from any thread.
pub fn render(system: &System, progress: &(dyn Fn(usize) + Sync)) -> Film {
    render_wanted(system, Wanted { truth: true }, progress)
}

/// The picture that `system` takes, with what is wanted of it; `progress` as in [`render`].
pub fn render_wanted(system: &System, wanted: Wanted, progress: &(dyn Fn(usize) + Sync)) -> Film {
    if system.effects.act_by(Hook::Film) {
        film::developed(system, wanted, progress)
    } else {
        light(system, wanted, progress)
    }
}

/// The light that reaches the film; arguments as of [`render_wanted`].
fn light(system: &System, wanted: Wanted, progress: &(dyn Fn(usize) + Sync)) -> Film {
    if system.effects.averages() {
        passes::mean(system, &|replicate| system.effects.variants(replicate), wanted, progress)
    } else {
        picture(&Plan::new(system), wanted, progress)
    }
}

/// The picture of a plan, one pass without film effects, with what is wanted of it; `progress` as in [`render`].
pub fn picture(plan: &Plan, wanted: Wanted, progress: &(dyn Fn(usize) + Sync)) -> Film {
    let [_, height] = plan.system.camera.size_px();
    let (Strip { radiance, colour, noise, class, board_mm }, done) = rows(plan, 0..height, wanted, progress);
    let mut work = Work::of(plan);
    work += done;
    Film { radiance, colour, noise, class, board_mm, counts: work.counts, account: work.account(plan) }
}

/// The `rows` of the picture of a plan, the first of which is a multiple of [`BAND_ROWS`], and the work they were; `wanted`
/// and `progress` as in [`picture`].
fn rows(plan: &Plan, rows: Range<usize>, wanted: Wanted, progress: &(dyn Fn(usize) + Sync)) -> (Strip, Work) {
    let [width, _] = plan.system.camera.size_px();
    let truth_size = if wanted.truth { [width, rows.len()] } else { [0, 0] };
    let mut radiance = Raster::filled(width, rows.len(), 0.0);
    let mut class = Raster::filled(truth_size[0], truth_size[1], Class::Left);
    let mut board_mm = Raster::filled(truth_size[0], truth_size[1], [0.0; 2]);
    let size = width * BAND_ROWS;
    let mut truths = class.data_mut().chunks_mut(size).zip(board_mm.data_mut().chunks_mut(size));
    let bands: Vec<Band> = (radiance.data_mut().chunks_mut(size).enumerate())
        .map(|(k, radiance)| {
            let truth = truths.next().map(|(class, board_mm)| Truth { class, board_mm });
            Band { width, first_row: rows.start + k * BAND_ROWS, radiance, truth }
        })
        .collect();
    let done: Vec<Work> = bands
        .into_par_iter()
        .with_max_len(1)
        .map(|mut band| {
            let work = render_band(plan, &mut band);
            progress(band.radiance.len());
            work
        })
        .collect();
    let mut work = Work::default();
    done.into_iter().for_each(|w| work += w);
    (Strip { radiance, colour: None, noise: None, class, board_mm }, work)
}

// Apart, so that its instructions can be counted by its name.
#[inline(never)]
fn render_band(plan: &Plan, band: &mut Band) -> Work {
    if plan.system.accuracy.sampling == Sampling::SingleRays {
        return reference::render(plan, band);
    }
    let mut work = Work::default();
    for patch in &plan.patches {
        work += mapped::render(plan, patch, band);
    }
    for region in &plan.traced {
        let rows = region.rows.start.max(band.first_row)..region.rows.end.min(band.first_row + band.rows());
        work += tile::render(plan, &plan::Region { columns: region.columns.clone(), rows }, band);
    }
    if plan.mirrored {
        band.mirror();
    }
    work
}

#[cfg(test)]
mod tests;
