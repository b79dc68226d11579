//! What an instrument sees in the light of its scene: at one wavelength the trace itself, in light of several the mean of
//! their traces, weighted by what the sensor receives of each, as it is in the grey picture.

use super::instrument::{BoardHit, System};
use crate::effect::dispersion::Wavelength;
use crate::error::Error;
use crate::geom::Ray;
use crate::optics::fate::Fate;
use crate::prism::payload::Path;
use crate::prism::side::Side;
use crate::scene::Scene;
use glam::{DVec2, DVec3};
use std::borrow::Cow;

/// The instrument in each of the wavelengths that stand for the light, through the middle of the pupil.
#[derive(Debug, Clone)]
pub struct InLight<'a> {
    /// Share of the grey picture and instrument, the largest share first.
    lights: Vec<(f64, Cow<'a, System>)>,
}

impl<'a> InLight<'a> {
    /// The instrument in the light of its scene; in that of the scene's own index where the scene calls for no dispersion.
    pub fn new(system: &'a System) -> Self {
        let mut lights = system.wavelengths();
        lights.sort_by(|a, b| b.0.total_cmp(&a.0));
        Self { lights }
    }

    /// Share and instrument of each wavelength, the largest share first.
    pub fn lights(&self) -> &[(f64, Cow<'a, System>)] {
        &self.lights
    }

    /// The instrument in light of the wavelength with the largest share: what sides and fates are told by.
    pub fn main(&self) -> &System {
        &self.lights[0].1
    }

    /// The number of what `px` sees, 0 for the plane of the board and 1 on for objects, by the ray of the main wavelength.
    ///
    /// # Errors
    /// The fate of that ray.
    pub fn nearest(&self, px: DVec2) -> Result<usize, Fate> {
        let (ray, _) = self.main().exit_ray(px)?;
        self.main().nearest(&ray).map(|(object, ..)| object)
    }

    /// What `px` sees: the side of the main wavelength, and the mean board position of those that pass the same side.
    ///
    /// # Errors
    /// The fate of the main wavelength's ray.
    pub fn trace(&self, px: DVec2) -> Result<BoardHit, Fate> {
        let main = self.main().trace(px)?;
        if self.lights.len() == 1 {
            return Ok(main);
        }
        let seen = |system: &System| system.trace(px).ok().filter(|hit| hit.side == main.side).map(|hit| hit.board_mm);
        Ok(BoardHit { board_mm: self.mean(seen).unwrap_or(main.board_mm), ..main })
    }

    /// The ray of `px` behind the prism when it passes `side`, continued beyond the ridge as if that side went on. The mean of
    /// rays is the line of the mean positions in every plane across z.
    ///
    /// # Errors
    /// The fate of the main wavelength's ray.
    pub fn exit_ray_through(&self, px: DVec2, side: Side) -> Result<Ray, Fate> {
        let main = self.main().exit_ray_through(px, side)?;
        if self.lights.len() == 1 {
            return Ok(main);
        }
        let rays = |system: &System| system.exit_ray_through(px, side).ok();
        let slope = self.mean(|system| rays(system).map(|ray| ray.direction.truncate() / ray.direction.z));
        let origin = self
            .mean(|system| rays(system).map(|ray| ray.at((main.origin.z - ray.origin.z) / ray.direction.z).truncate()));
        Ok(match slope.zip(origin) {
            Some((slope, origin)) => {
                Ray { origin: origin.extend(main.origin.z), direction: slope.extend(1.0).normalize() }
            }
            None => main,
        })
    }

    /// The refraction points on the way of `px`, in the world, and the ray behind the prism with its side: as
    /// [`System::path`], each point and direction the mean over the wavelengths that take the main one's way.
    pub fn path(&self, px: DVec2) -> (Path, Result<(Ray, Side), Fate>) {
        let (mut path, end) = self.main().path(px);
        if self.lights.len() == 1 {
            return (path, end);
        }

        // Keep the wavelengths that take the same way.
        let paths: Vec<(f64, Path)> = self
            .lights
            .iter()
            .map(|(share, system)| (*share, system.path(px)))
            .filter(|(_, (other, other_end))| {
                let alike = match (&end, other_end) {
                    (Ok((_, a)), Ok((_, b))) => a == b,
                    (Err(a), Err(b)) => a == b,
                    _ => false,
                };
                alike && other.points.len() == path.points.len()
            })
            .map(|(share, (other, _))| (share, other))
            .collect();

        // Take the mean of points and directions, each with its share.
        let total: f64 = paths.iter().map(|(share, _)| share).sum();
        let mean = |of: &dyn Fn(&Path) -> DVec3| paths.iter().map(|(share, p)| of(p) * *share).sum::<DVec3>() / total;
        for k in 0..path.points.len() {
            path.points[k] = mean(&|p| p.points[k]);
        }
        for k in 0..path.directions.len() {
            path.directions[k] = mean(&|p| p.directions[k]).normalize();
        }
        let end = end.map(|(ray, side)| (self.exit_ray_through(px, side).unwrap_or(ray), side));
        (path, end)
    }

    /// The mean of a position over the wavelengths that have it.
    fn mean(&self, of: impl Fn(&System) -> Option<DVec2>) -> Option<DVec2> {
        let (mut sum, mut shares) = (DVec2::ZERO, 0.0);
        for (share, system) in &self.lights {
            if let Some(value) = of(system) {
                sum += value * *share;
                shares += share;
            }
        }
        (shares > 0.0).then(|| sum / shares)
    }
}

/// The light in which `system`, the instrument of `scene`, sees what is true of its picture, in words for a report: that of
/// the scene's own index, one line, or a band.
pub(crate) fn light_name(scene: &Scene, system: &System) -> String {
    let waves = system.effects().dispersion.as_ref().filter(|dispersion| !dispersion.is_nothing());
    let nm: Vec<f64> = waves.map_or_else(Vec::new, |d| d.waves.iter().map(|wave| wave.wavelength_nm).collect());
    match (&nm[..], scene.prism.body()) {
        ([], None) => "light of any wavelength".to_owned(),
        ([], Some(body)) => format!("light of {} nm, to which the scene's index belongs", body.wavelength_nm),
        ([line], _) => format!("light of {line} nm"),
        (waves, _) => {
            let (low, high) = waves.iter().fold((f64::INFINITY, 0.0f64), |(l, h), nm| (l.min(*nm), h.max(*nm)));
            format!(
                "light of {} wavelengths from {low:.1} to {high:.1} nm: the mean position, weighted by what the sensor receives",
                waves.len()
            )
        }
    }
}

/// `system`, the instrument of `scene`, in light of one wavelength in vacuum, in nm, whatever light the scene has.
///
/// # Errors
/// When the scene has no glass of a name, whose index that wavelength could change, and where its formula does not hold there.
pub fn in_light_of(system: &System, scene: &Scene, wavelength_nm: f64) -> Result<System, Error> {
    let refused = |rule: String| {
        let help = "give `prism.glass` a name of docs/effects.md, or leave the wavelength out";
        Error::new(format!("the wavelength of {wavelength_nm} nm"), rule, help)
    };
    let Some(body) = scene.prism.body() else {
        return Err(refused(format!("scene \"{}\" has no glass that a wavelength could change", scene.name)));
    };
    let Some(glass) = body.glass else {
        let rule =
            format!("`prism.index` of scene \"{}\" is a number, which says nothing of other wavelengths", scene.name);
        return Err(refused(rule).of_key("prism.index"));
    };
    let index = |nm: f64| glass.index(nm).map_err(|error| refused(error.to_string()));
    let index_shift = index(wavelength_nm)? - index(body.wavelength_nm)?;
    Ok(system.at_wavelength(&Wavelength { wavelength_nm, index_shift, weights: [1.0; 3] }))
}
