//! The studies of one half of one instrument: spot, foci over the field, contrast.

use super::field_curvature::{Foci, foci};
use super::lens::{RelayLens, disc};
use super::mtf::{Contrast, contrasts};
use super::pencil::{Pencil, PencilRay};
use super::spot::{PencilSpot, best_focus_mm};
use super::wave_error::{NoWave, WaveError};
use crate::analysis::half_image::{HalfFrame, virtual_camera};
use crate::error::Error;
use crate::geom::Ray;
use crate::optics::fate::Fate;
use crate::system::{Prism, Side, System};
use crate::vision::half::Half;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Rings of the pupil.
const RINGS: usize = 16;
/// Rays along each side of a half image.
const HALF_IMAGE: usize = 64;
/// Planes through the focus, and pixels along a line of the field.
const ALONG: usize = 41;
/// Frequencies from 0 to the cut-off, closer together where contrast falls first.
const FREQUENCIES: usize = 49;

/// What is asked of the lens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelaySettings {
    /// The lens.
    pub lens: RelayLens,
    /// z of the world of the plane in focus, in mm; the plane of O' where none is given.
    pub focus_mm: Option<f64>,
    /// How far beyond the camera's pinhole along +z the object is, in mm.
    pub object_mm: f64,
    /// How far beside it the points of the field are, in mm.
    pub field_mm: f64,
}

/// The design paper's lens: magnification, numerical aperture and wavelength as it prints them, an ideal lens in the place of one
/// that it does not give, focused on the plane of O'; the object is the camera's pinhole.
pub const PAPER: RelaySettings = RelaySettings {
    lens: RelayLens { na: 0.09, magnification: 0.55, wavelength_mm: 486.1327e-6 },
    focus_mm: None,
    object_mm: 0.0,
    field_mm: 1.0,
};

/// A half of an instrument, ready to be studied.
#[derive(Debug, Clone)]
pub(crate) struct RelayHalf<'a> {
    system: &'a System,
    /// The glass as made, its surfaces continued beyond where they were given.
    prism: Prism,
    side: Side,
    settings: RelaySettings,
    /// The plane in focus, z of the world in mm.
    pub focus_mm: f64,
}

/// The spot of the object and of its neighbours.
#[derive(Debug, Clone, PartialEq)]
pub struct SpotStudy {
    /// With the lens focused as asked.
    pub focused: PencilSpot,
    /// With the lens where the spot is smallest.
    pub best: PencilSpot,
    /// With the lens focused as asked, of the rays of the half image alone: 64 x 64, each for an equal part of it. `None` where one of
    /// them does not pass.
    pub half_image: Option<PencilSpot>,
    /// Planes and the root mean square about the centroid in them, in mm.
    pub through_focus: Vec<[f64; 2]>,
    /// Over the field.
    pub field: Vec<FieldSpot>,
    /// The share of the pupil's rays that meet a surface beyond where it was given, and continue by its formula.
    pub beyond: f64,
}

/// The spot of a point of the field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FieldSpot {
    /// Its place beside the object, in mm.
    pub beside_mm: DVec2,
    /// Root mean square about the centroid with the lens focused as asked, in mm.
    pub rms_mm: f64,
    /// The plane in which it is smallest.
    pub best_focus_mm: f64,
    /// The root mean square in it, in mm.
    pub best_rms_mm: f64,
}

/// The contrast of the object and of its neighbours.
#[derive(Debug, Clone, PartialEq)]
pub struct MtfStudy {
    /// Root mean square of the wave error from its mean and its tilt, in waves.
    pub rms_waves: f64,
    /// What the series of the wave error leaves, in waves.
    pub left_waves: f64,
    /// With the lens focused as asked.
    pub focused: Vec<Contrast>,
    /// With the lens where the spot is smallest.
    pub best: Vec<Contrast>,
    /// Planes and the contrast in them at [`MtfStudy::probe_per_mm`].
    pub through_focus: Vec<(f64, Contrast)>,
    /// Places beside the object and the contrast there at that frequency.
    pub field: Vec<(DVec2, Contrast)>,
    /// A quarter of the cut-off, in cycles/mm of the image.
    pub probe_per_mm: f64,
}

impl<'a> RelayHalf<'a> {
    /// The half on `side` of `system`.
    ///
    /// # Errors
    /// Where there is no prism, no plane of O', or the lens cannot be.
    pub(crate) fn new(system: &'a System, side: Side, settings: RelaySettings) -> Result<Self, Error> {
        let half = if side == Side::Left { Half::Left } else { Half::Right };
        let focus_mm = match settings.focus_mm {
            Some(focus) => focus,
            None => {
                virtual_camera(system, &HalfFrame::new(system, half))
                    .map_err(|why| {
                        let help = "state the plane in focus with --focus-mm";
                        Error::new("the half image", format!("it has no virtual camera: {}", why.reason()), help)
                    })?
                    .centre_mm()
                    .z
            }
        };
        let none = || Error::new("the scene", "it has no prism to look through", "give the scene a prism");
        let prism = system.prism().ok_or_else(none)?.continued();
        Ok(Self { system, prism, side, settings, focus_mm })
    }

    fn pencil(&self, beside_mm: DVec2) -> Pencil<'_> {
        Pencil::new(self.system, &self.prism, self.side, beside_mm.extend(self.settings.object_mm))
    }

    /// The share of the pupil's rays that meet a surface beyond where it was given.
    fn beyond(&self, rays: &[PencilRay]) -> f64 {
        let Some(prism) = self.system.prism() else { return 0.0 };
        let given = Pencil::new(self.system, prism, self.side, DVec3::Z * self.settings.object_mm);
        rays.iter().filter(|ray| given.at(ray.start).is_err()).count() as f64 / rays.len().max(1) as f64
    }

    /// The spot of the rays of the half image, with the lens focused as asked.
    fn half_image(&self, pencil: &Pencil) -> Option<PencilSpot> {
        let camera = self.system.camera();
        let [width, height] = camera.size_px().map(|n| n as f64);
        let first = if self.side == Side::Left { 0.0 } else { 0.5 * width };
        let share = |k: usize| (k as f64 + 0.5) / HALF_IMAGE as f64;
        let ray = |k: usize| {
            let [across, down] = [k % HALF_IMAGE, k / HALF_IMAGE].map(share);
            let direction = camera.ray(DVec2::new(first + 0.5 * width * across, height * down)).direction;
            pencil.at(direction.truncate() / direction.z).ok()
        };
        let rays: Vec<PencilRay> = (0..HALF_IMAGE * HALF_IMAGE).map(ray).collect::<Option<_>>()?;
        Some(PencilSpot::new(&rays, &pencil.at(pencil.middle()).ok()?.exit, self.focus_mm))
    }

    /// Nine places: the object, and those `field_mm` beside it along x, y and both.
    fn places(&self) -> Vec<DVec2> {
        let step = self.settings.field_mm;
        (0..9).map(|k| DVec2::new((k % 3) as f64 - 1.0, (k / 3) as f64 - 1.0) * step).collect()
    }

    /// The planes about the best focus that show the way to it and a few depths of focus.
    fn planes(&self, best_mm: f64) -> Vec<f64> {
        let lens = &self.settings.lens;
        let reach = (1.5 * (best_mm - self.focus_mm).abs()).max(4.0 * lens.wavelength_mm / (lens.na * lens.na));
        (0..ALONG).map(|k| best_mm + reach * (2.0 * k as f64 / (ALONG - 1) as f64 - 1.0)).collect()
    }

    fn rays(&self, pencil: &Pencil) -> Result<(Vec<PencilRay>, Ray), Error> {
        let rays = pencil.pupil(self.settings.lens.na, &disc(RINGS)).map_err(|(p, fate)| vignetted(p, fate))?;
        let chief = pencil.pupil(self.settings.lens.na, &[DVec2::ZERO]).map_err(|(p, fate)| vignetted(p, fate))?[0];
        Ok((rays, chief.exit))
    }

    /// The spot of the object, through focus and over the field.
    ///
    /// # Errors
    /// Where a ray of the pupil does not pass.
    pub(crate) fn spot(&self) -> Result<SpotStudy, Error> {
        let pencil = self.pencil(DVec2::ZERO);
        let (rays, chief) = self.rays(&pencil)?;
        let best_mm = best_focus_mm(&rays).ok_or_else(parallel)?;
        let at = |focus: f64| PencilSpot::new(&rays, &chief, focus);
        let field = |beside_mm: DVec2| {
            let (rays, chief) = self.rays(&self.pencil(beside_mm))?;
            let best_focus_mm = best_focus_mm(&rays).ok_or_else(parallel)?;
            let rms = |focus: f64| PencilSpot::new(&rays, &chief, focus).rms_mm;
            Ok(FieldSpot { beside_mm, rms_mm: rms(self.focus_mm), best_focus_mm, best_rms_mm: rms(best_focus_mm) })
        };
        Ok(SpotStudy {
            focused: at(self.focus_mm),
            best: at(best_mm),
            half_image: self.half_image(&pencil),
            through_focus: self.planes(best_mm).into_iter().map(|z| [z, at(z).rms_mm]).collect(),
            field: self
                .places()
                .into_par_iter()
                .map(field)
                .collect::<Vec<_>>()
                .into_iter()
                .collect::<Result<_, Error>>()?,
            beyond: self.beyond(&rays),
        })
    }

    /// The foci along the middle row and the middle column of the half image.
    ///
    /// # Errors
    /// Where a ray does not pass, or the camera is no pinhole.
    pub(crate) fn foci(&self) -> Result<[Vec<Foci>; 2], Error> {
        let pencil = self.pencil(DVec2::ZERO);
        let camera = self.system.camera();
        let tangent_per_px = camera.tangent_per_px().ok_or_else(|| {
            Error::new("the camera", "it is telecentric, and its rays meet in no point", "leave out effect.telecentric")
        })?;
        let [width, height] = camera.size_px().map(|n| n as f64);
        let reach = [DVec2::new(0.25 * width, 0.0), DVec2::new(0.0, 0.5 * height)];
        let line = |reach: DVec2| -> Result<Vec<Foci>, Error> {
            let at = |k: usize| {
                let px = reach * (2.0 * k as f64 / (ALONG - 1) as f64 - 1.0);
                foci(&pencil, 1.0 / tangent_per_px, px).map_err(|fate| {
                    let rule = format!("the ray of the pixel {px} px from the half image's middle {}", ends(fate));
                    Error::new("the half image", rule, "use a scene whose half images are filled")
                })
            };
            (0..ALONG).map(at).collect()
        };
        Ok([line(reach[0])?, line(reach[1])?])
    }

    /// The contrast of the object over frequency, through focus and over the field.
    ///
    /// # Errors
    /// Where a ray of the pupil does not pass, or the wave error is no smooth function of the pupil.
    pub(crate) fn mtf(&self) -> Result<MtfStudy, Error> {
        let lens = &self.settings.lens;
        let at = |beside: DVec2| -> Result<(WaveError, Vec<PencilRay>), Error> {
            let pencil = self.pencil(beside);
            let wave = WaveError::new(&pencil, lens, self.focus_mm).map_err(|why| match why {
                NoWave::Ray(place, fate) => vignetted(place, fate),
                NoWave::NotSmooth(left) => Error::new(
                    "the wave error",
                    format!("it is not smooth over the pupil (a series leaves {left:.1e} waves)"),
                    "use a smaller --na, or the prism's surfaces without kinks",
                ),
            })?;
            Ok((wave, self.rays(&pencil)?.0))
        };
        let (wave, rays) = at(DVec2::ZERO)?;
        let best_mm = best_focus_mm(&rays).ok_or_else(parallel)?;
        let too_fast = || {
            let rule = "the wave error changes too fast over the pupil for its contrast";
            Error::new("the wave error", rule, "use a smaller --na")
        };
        let at_frequency = |wave: &WaveError, rays: &[PencilRay], frequency: f64, focus: &[f64]| {
            contrasts(wave, rays, frequency, focus).ok_or_else(too_fast)
        };

        // Go over frequency, for both planes at once, through focus and over the field.
        let cut_off = lens.cut_off_per_mm();
        let both = |k: usize| {
            let share = k as f64 / (FREQUENCIES - 1) as f64;
            at_frequency(&wave, &rays, cut_off * share * share, &[self.focus_mm, best_mm])
        };
        let curves: Vec<Vec<Contrast>> =
            (0..FREQUENCIES).into_par_iter().map(both).collect::<Vec<_>>().into_iter().collect::<Result<_, Error>>()?;
        let probe_per_mm = 0.25 * cut_off;
        let planes = self.planes(best_mm);
        let through_focus = at_frequency(&wave, &rays, probe_per_mm, &planes)?;
        let neighbour = |beside: DVec2| {
            let (wave, rays) = at(beside)?;
            Ok((beside, at_frequency(&wave, &rays, probe_per_mm, &[self.focus_mm])?[0]))
        };
        Ok(MtfStudy {
            rms_waves: wave.rms_waves,
            left_waves: wave.left_waves,
            focused: curves.iter().map(|curve| curve[0]).collect(),
            best: curves.iter().map(|curve| curve[1]).collect(),
            through_focus: planes.into_iter().zip(through_focus).collect(),
            field: self
                .places()
                .into_par_iter()
                .map(neighbour)
                .collect::<Vec<_>>()
                .into_iter()
                .collect::<Result<_, Error>>()?,
            probe_per_mm,
        })
    }
}

fn ends(fate: Fate) -> &'static str {
    match fate {
        Fate::Missed => "misses the prism",
        Fate::TotalReflection => "is totally reflected",
        Fate::NotConverged => "is not found",
        Fate::PastBoard => "turns back",
        Fate::Clipped => "is clipped",
    }
}

fn vignetted(place: DVec2, fate: Fate) -> Error {
    let rule = format!("the ray at ({:.2}, {:.2}) of the pupil {}", place.x, place.y, ends(fate));
    Error::new("the lens behind the prism", rule, "use a smaller aperture with --na")
}

fn parallel() -> Error {
    Error::new(
        "the pencil",
        "its rays are parallel behind the prism, and meet nowhere",
        "move the object with --object-mm",
    )
}
