//! The film: the rendered picture, its ground truth, and the report of its accuracy.

use crate::accuracy::{Level, keeps_to};
use crate::optics::fate::Fate;
use crate::raster::Raster;
use crate::system::Side;
use std::ops::Range;

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
    /// What happened to each pixel's centre ray; `None` where [`Outputs`] leaves it out.
    pub class: Option<Raster<Class>>,
    /// The board position that each pixel's centre sees, in mm; (0, 0) where `class` is no side; `None` where [`Outputs`]
    /// leaves it out.
    pub board_mm: Option<Raster<[f32; 2]>>,
    /// The number of what each pixel's centre sees, 0 for the board's plane and 1 on for the objects, whose frame `board_mm` is
    /// then in; `None` where the scene has no objects, and where [`Outputs`] leaves it out.
    pub object: Option<Raster<u32>>,
    /// How much work it was.
    pub counts: Counts,
    /// What was promised, and what was found.
    pub account: AccuracyReport,
}

impl Film {
    /// The part without `frame` pixels on every side, of a film without truth.
    pub(super) fn without_frame(self, frame: usize) -> Self {
        Self {
            radiance: self.radiance.without_frame(frame),
            colour: self.colour.map(|colour| colour.without_frame(frame)),
            noise: self.noise.map(|noise| noise.without_frame(frame)),
            ..self
        }
    }

    /// What happened to the centre ray of pixel (i, j), where that was asked for.
    pub fn class_at(&self, i: usize, j: usize) -> Option<Class> {
        self.class.as_ref().map(|class| class.get(i, j))
    }
}

/// The accuracy of a picture: what its level promises, and what was found while it was rendered. All in px, of positions as the
/// geometry of each of its pictures has them: neither samples of a pupil, slopes or wavelengths nor film effects count here.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct AccuracyReport {
    /// The level.
    pub level: Level,
    /// The target, where the level was chosen by one.
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
    /// What that should have been at most, where it was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise_target: Option<f64>,
    /// Pixels of the picture for which all this does not hold: see [`Counts::unpromised_pixels`].
    #[serde(skip_serializing_if = "is_zero")]
    pub unpromised_pixels: u64,
}

/// Whether nothing was counted.
#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks for it")]
pub(crate) fn is_zero(count: &u64) -> bool {
    *count == 0
}

impl AccuracyReport {
    /// The accuracy achieved, as far as the picture itself can tell.
    pub fn achieved_px(&self) -> f64 {
        self.map_px + self.bend_px
    }

    /// Whether what was asked for is kept, where something was, and told by what the picture holds.
    pub fn keeps_to_target(&self) -> bool {
        self.target_px.is_none_or(|target_px| keeps_to(target_px, self.achieved_px()))
    }
}

impl std::fmt::Display for AccuracyReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // Name the level, and the target that it was chosen by.
        let Self { level, promise_px, map_px, bend_px, patches, mapped, .. } = self;
        write!(f, "{}", level.name())?;
        if let Some(target_px) = self.target_px {
            match self.keeps_to_target() {
                true => write!(f, ", the cheapest level that keeps to {target_px:.0e} px"),
                false => write!(f, ", which does not keep to {target_px:.0e} px: out of reach"),
            }?;
        }

        // Compare the promise with what was achieved.
        let achieved_px = self.achieved_px();
        if *promise_px == 0.0 {
            write!(f, ": the judge of the other levels, off by {achieved_px:.1e} px of geometry")
        } else if achieved_px <= *promise_px {
            write!(f, ": promises {promise_px:.0e} px of geometry and keeps to {achieved_px:.1e} px")
        } else {
            write!(f, ": promises {promise_px:.0e} px of geometry, but reaches only {achieved_px:.1e} px")
        }?;

        // Say how the geometry was sampled.
        match patches {
            0 => write!(f, " (every pixel traced)"),
            _ => write!(
                f,
                " (map of {patches} {} for {:.1} % of the pixels, off by {map_px:.1e} px; bend inside pixels {bend_px:.1e} px)",
                if *patches == 1 { "patch" } else { "patches" },
                100.0 * mapped
            ),
        }?;

        // Say what the mean over passes adds.
        if self.passes > 1 {
            write!(f, "; that is each of {} pictures, of which this is the mean", self.passes)?;
        }
        match self.noise {
            Some(noise) => write!(f, ", with a standard error of {noise:.1e} of full scale in the worst block"),
            None if self.passes > 1 => write!(f, ", and their sampling not counted"),
            None => Ok(()),
        }?;

        // Count what holds no promise.
        match self.unpromised_pixels {
            0 => Ok(()),
            1 => {
                write!(
                    f,
                    "; without 1 pixel whose borders or kinks are not followed to the end, which holds no promise"
                )
            }
            n => write!(
                f,
                "; without {n} pixels whose borders or kinks are not followed to the end, which hold no promise"
            ),
        }
    }
}

/// What of a [`Film`] is wanted besides the radiance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Outputs {
    /// The ground truth of every pixel: `class` and `board_mm`.
    pub truth: bool,
}

/// The end of a pixel's centre ray.
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

    /// The class with all from which no light comes as one, [`Class::Clipped`].
    pub(super) fn by_light(self) -> Self {
        match self {
            Self::Left | Self::Right | Self::PastBoard => self,
            Self::Missed | Self::TotalReflection | Self::NotConverged | Self::Clipped => Self::Clipped,
        }
    }

    /// The class of the mirror image.
    pub(super) fn mirrored(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Right => Self::Left,
            ended => ended,
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
    /// Pixels whose division ended at the most parts allowed, before they kept to the bound.
    pub capped_pixels: u64,
    /// Pixels cut by the ridge or by the border of a fate.
    pub cut_pixels: u64,
    /// Pixels that hold no promise: those whose division along borders ended at the most
    /// parts allowed, and those in which more creases or kinks of triangles matter than are followed. It is told with the accuracy of the picture, not
    /// here.
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

/// Rows of a picture; fields as those of [`Film`].
#[derive(Debug, Clone, PartialEq)]
pub struct Strip {
    /// Mean radiance over each pixel.
    pub radiance: Raster<f32>,
    /// The same of red, green and blue.
    pub colour: Option<Raster<[f32; 3]>>,
    /// Standard error of the radiance.
    pub noise: Option<Raster<f32>>,
    /// What happened to each pixel's centre ray.
    pub class: Option<Raster<Class>>,
    /// The board position that it sees, in mm.
    pub board_mm: Option<Raster<[f32; 2]>>,
    /// The number of what it sees.
    pub object: Option<Raster<u32>>,
}

impl Strip {
    /// Some columns as a picture of their own.
    #[must_use]
    pub fn columns(&self, columns: Range<usize>) -> Self {
        let Range { start, end } = columns;
        Self {
            radiance: self.radiance.columns(start, end),
            colour: self.colour.as_ref().map(|colour| colour.columns(start, end)),
            noise: self.noise.as_ref().map(|noise| noise.columns(start, end)),
            class: self.class.as_ref().map(|class| class.columns(start, end)),
            board_mm: self.board_mm.as_ref().map(|board_mm| board_mm.columns(start, end)),
            object: self.object.as_ref().map(|object| object.columns(start, end)),
        }
    }
}

impl From<&Film> for Strip {
    /// The whole picture as one strip.
    fn from(film: &Film) -> Self {
        Self {
            radiance: film.radiance.clone(),
            colour: film.colour.clone(),
            noise: film.noise.clone(),
            class: film.class.clone(),
            board_mm: film.board_mm.clone(),
            object: film.object.clone(),
        }
    }
}
