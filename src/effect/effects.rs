//! The effects that a scene calls for, with their settings.

use super::absorption::Absorption;
use super::clipping::Clipping;
use super::coating::Coating;
use super::cos4::Cos4;
use super::diffraction::Diffraction;
use super::dispersion::Dispersion;
use super::fresnel::Fresnel;
use super::ghosts::Ghosts;
use super::hook::Hook;
use super::journey::LightPath;
use super::lamp::Lamp;
use super::lens::Lens;
use super::manufacture::Manufacture;
use super::picture::Picture;
use super::pupil::Pupil;
use super::quadrature::{Points, Quadrature, turned};
use super::roughness::Roughness;
use super::sensor::Sensor;
use super::telecentric::Telecentric;
use super::variant::{Variant, Variants};
use crate::raster::Raster;
use crate::raster::transfer::decoded;
use crate::surface::face::Face;
use glam::DVec2;
use std::borrow::Cow;

/// The effects that a scene calls for, with their settings; `None` is absent.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Effects {
    /// The lens of the camera.
    pub lens: Lens,
    /// What keeps rays from passing.
    pub clipping: Option<Clipping>,
    /// The prism as built.
    pub manufacture: Option<Manufacture>,
    /// Rough surfaces.
    pub roughness: Option<Roughness>,
    /// The natural fall of light towards the rim of the picture.
    pub cos4: Option<Cos4>,
    /// The board lit by a lamp.
    pub lamp: Option<Lamp>,
    /// What the surfaces of the glass reflect is missing behind it.
    pub fresnel: Option<Fresnel>,
    /// A layer on every surface of the glass; of no use without `fresnel`.
    pub coating: Option<Coating>,
    /// What the glass absorbs.
    pub absorption: Option<Absorption>,
    /// What the surfaces of the glass reflect arrives elsewhere; of no use without `fresnel`.
    pub ghosts: Option<Ghosts>,
    /// Light of many wavelengths.
    pub dispersion: Option<Dispersion>,
    /// Diffraction at the aperture.
    pub diffraction: Option<Diffraction>,
    /// A sensor that is not ideal.
    pub sensor: Option<Sensor>,
    /// How ray effects are sampled.
    pub quadrature: Quadrature,
    /// Effects that change less than this are left out; `None` keeps all.
    pub auto: Option<Threshold>,
}

/// What may be left out: effects that together change neither a pixel nor an edge by more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Threshold {
    /// Change of a pixel, of full scale 1; `None` where any will do.
    pub grey: Option<f64>,
    /// Move of an edge, in px; `None` where any will do.
    pub px: Option<f64>,
}

impl Threshold {
    /// A change as a share of what may be left out: above 1 where it may not.
    pub fn share(&self, grey: f64, px: f64) -> f64 {
        let of = |limit: Option<f64>, value: f64| match limit {
            None => 0.0,
            Some(_) if value == 0.0 => 0.0,
            Some(limit) => value / limit,
        };
        of(self.grey, grey).max(of(self.px, px))
    }
}

impl Default for Threshold {
    /// Half a step of an 8-bit picture, and a hundredth of a pixel.
    fn default() -> Self {
        Self { grey: Some(0.5 / 255.0), px: Some(0.01) }
    }
}

/// The tangent by which a slope of a surface bends a ray that comes along the axis: Snell's law.
pub(super) fn bent_by(slope: f64, index_ratio: f64) -> f64 {
    let tilt = libm::atan(slope);
    libm::tan(tilt - libm::asin((libm::sin(tilt) / index_ratio).min(1.0))).abs()
}

impl Effects {
    /// How far rays of the variants may stray, in mm, from those of the instrument itself in a prism whose surfaces reach
    /// `reach_mm` from its axis, with a way of `way_mm` through glass of `index_ratio` to its surroundings.
    pub fn spare_mm(&self, reach_mm: f64, way_mm: f64, index_ratio: f64) -> f64 {
        // A glass between lens and focus meets less than the aperture.
        let pupil_mm = match self.lens {
            Lens::Pinhole => 0.0,
            Lens::Thin(lens) => lens.radius_mm,
            Lens::Telecentric(lens) => lens.focus_mm * Telecentric::tangents(DVec2::new(lens.na, 0.0)).x,
        };
        // What a slope of the back does is done behind the glass.
        let draws = self.sets() as f64 * self.quadrature.points as f64;
        let rough = self.roughness.map_or(0.0, |rough| rough.steepest(Face::Front, draws));
        let stray_mm = self.manufacture.as_ref().map_or(0.0, |made| made.stray_mm(reach_mm, way_mm));
        let waves = self.dispersion.iter().flat_map(|dispersion| &dispersion.waves);
        // A tangent of 1 or less, times d tan(r) = -tan(r) dn / n.
        let shift_mm = way_mm * waves.fold(0.0f64, |most, wave| most.max(wave.index_shift.abs()));
        // The rest allows for refraction, and for rays that come aslant.
        stray_mm + shift_mm + 1.25 * (pupil_mm + way_mm * bent_by(rough, index_ratio))
    }

    /// Whether the picture is a mean over variants of the instrument.
    pub fn averages(&self) -> bool {
        self.act_by(Hook::Ray) || self.dimensions() > 0
    }

    /// Dimensions of the cube that the variants are drawn from, two for a pupil of finite size and two for each rough
    /// surface.
    pub fn dimensions(&self) -> usize {
        2 * (usize::from(self.lens.has_pupil()) + self.roughness.map_or(0, |rough| rough.rough()))
    }

    /// Sets of points that the picture is the mean of, at most: one where nothing is drawn from them.
    pub fn sets(&self) -> usize {
        if self.dimensions() > 0 { self.quadrature.replicates } else { 1 }
    }

    /// Whether they treat mirror images in the plane x = 0 alike, noise aside, where camera, glass and board do.
    pub fn keep_mirror_images(&self) -> bool {
        let aperture = match self.lens {
            Lens::Thin(lens) => lens.is_nothing() || lens.aperture.is_mirror_symmetric(),
            Lens::Telecentric(_) | Lens::Pinhole => true,
        };
        aperture && self.manufacture.is_none() && self.lamp.is_none_or(|lamp| lamp.position_mm.x == 0.0)
    }

    /// Into how many equal parts of a full turn the pupil and the slopes may be cut that are all alike.
    fn turns(&self) -> usize {
        match self.lens {
            Lens::Thin(lens) if !lens.is_nothing() => lens.aperture.turns(),
            _ => 2,
        }
    }

    /// The variant of point k of a set, in the given one of its `turns`. Of the first pair of coordinates the points fill one
    /// turn; slopes are distributed alike in all directions, and turn with the pupil.
    fn at(&self, set: &Points, k: usize, turn: usize, turns: usize, plain: Variant) -> Variant {
        let mut next = 0;
        let mut two = || {
            next += 2;
            DVec2::new(set.at(k, next - 2), set.at(k, next - 1))
        };
        let within = DVec2::new(1.0, 1.0 / turns as f64);
        let pupil = match &self.lens {
            lens if !lens.has_pupil() => DVec2::ZERO,
            Lens::Pinhole => DVec2::ZERO,
            Lens::Thin(lens) => lens.pupil_mm(two() * within),
            Lens::Telecentric(lens) => lens.sines(two() * within),
        };
        // The half with negative slopes along x.
        let mut within = if self.lens.has_pupil() { DVec2::ONE } else { DVec2::new(0.5, 1.0) };
        let mut slopes = plain.slopes;
        if let Some(rough) = &self.roughness {
            for face in Face::ALL.into_iter().filter(|face| rough.slope[*face as usize] > 0.0) {
                slopes[face as usize] = rough.slopes(face, two() * within);
                within = DVec2::ONE;
            }
        }
        Variant { pupil: turned(pupil, turn, turns), slopes: slopes.map(|slope| turned(slope, turn, turns)), ..plain }
    }

    /// The variants of the instrument whose weighted mean is the picture, by set number `replicate` of points; one that is
    /// the instrument itself where no ray effect acts.
    pub fn variants(&self, replicate: usize) -> Variants<'_> {
        let plain = Variant { pupil: DVec2::ZERO, slopes: [DVec2::ZERO; 2], wave: None, grey: 1.0, colour: None };
        let points = match self.dimensions() {
            0 => vec![plain],
            dimensions => {
                let turns = self.turns();
                let set = Points::new(&self.quadrature, dimensions, replicate, turns);
                let count = set.count() * turns;
                let of = |k: usize| self.at(&set, k / turns, k % turns, turns, plain);
                let mut points: Vec<Variant> =
                    (0..count).map(|k| Variant { grey: 1.0 / count as f64, ..of(k) }).collect();
                if let Some(pupil) = self.filled_pupil() {
                    let places: Vec<DVec2> = points.iter().map(|point| point.pupil).collect();
                    let even = pupil.evened_out(places, turns);
                    points.iter_mut().zip(even).for_each(|(point, place)| point.pupil = place);
                }
                points
            }
        };
        Variants::new(points, self.dispersion.as_ref().filter(|dispersion| !dispersion.is_nothing()))
    }

    /// The pupil whose points stand for the parts of it around them, where they do.
    pub fn filled_pupil(&self) -> Option<Pupil> {
        let alone = self.dimensions() == 2 && self.sets() == 1;
        self.lens.pupil().filter(|_| self.quadrature.fill && alone)
    }

    /// These effects in light of one wavelength.
    #[must_use]
    pub fn at_wavelength(&self, wavelength_nm: f64) -> Self {
        let coating = self.coating.map(|coating| Coating { wavelength_nm, ..coating });
        Self { coating, ..self.clone() }
    }

    /// The share of its light that is left to a ray along its light path: the product of all transport effects.
    pub fn throughput(&self, journey: &LightPath) -> f64 {
        let mut throughput = 1.0;
        if let Some(lamp) = &self.lamp {
            throughput *= lamp.throughput(journey);
        }
        if let Some(fresnel) = &self.fresnel {
            throughput *= fresnel.throughput(journey, self.coating.as_ref());
        }
        if let Some(absorption) = &self.absorption {
            throughput *= absorption.throughput(journey);
        }
        if let Some(cos4) = &self.cos4 {
            throughput *= cos4.throughput(journey);
        }
        throughput
    }

    /// The side of the square in the middle of a pixel over which its light is to be rendered, in px. Diffraction lets light
    /// cross its border, so that the whole pixel is rendered, and collects over the square itself.
    pub fn active_side(&self) -> f64 {
        if self.diffracting().is_some() { 1.0 } else { self.collecting_side() }
    }

    /// Whether the picture is drawn at random.
    pub fn is_random(&self) -> bool {
        self.sensor.is_some_and(|sensor| sensor.is_random())
    }

    /// The same effects in a later frame of the same specimen; themselves for 0.
    #[must_use]
    pub fn in_frame(&self, later: u32) -> Self {
        let sensor = self.sensor.map(|sensor| Sensor { frame: sensor.frame.wrapping_add(later), ..sensor });
        Self { sensor, ..self.clone() }
    }

    /// The same effects with a sensor that is neither uneven nor noisy.
    #[must_use]
    pub fn without_noise(&self) -> Self {
        let quiet = |sensor| Sensor { prnu: 0.0, dsnu_e: 0.0, shot_noise: false, read_noise_e: 0.0, ..sensor };
        Self { sensor: self.sensor.map(quiet), ..self.clone() }
    }

    /// The linear light, but for a factor and an offset, of a picture that the sensor has coded by its gamma; of colours, whose
    /// coded luminance is what is kept, only as far as they have the same edges.
    pub fn decoded<'a>(&self, picture: &'a Raster<f32>) -> Cow<'a, Raster<f32>> {
        match self.sensor.map(|sensor| sensor.gamma).filter(|gamma| *gamma != 1.0) {
            Some(gamma) => Cow::Owned(decoded(picture, gamma)),
            None => Cow::Borrowed(picture),
        }
    }

    /// What the sensor makes of the light that its pixels collect.
    pub fn develop(&self, light: Picture) -> Picture {
        match &self.sensor {
            Some(sensor) => sensor.expose(&light),
            None => light,
        }
    }

    /// Diffraction, where it acts.
    pub fn diffracting(&self) -> Option<&Diffraction> {
        self.diffraction.as_ref().filter(|diffraction| !diffraction.is_nothing())
    }

    /// The side of the square in the middle of a pixel that collects light, in px.
    pub fn collecting_side(&self) -> f64 {
        self.sensor.map_or(1.0, |sensor| sensor.active_side())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::table::TABLE;
    use crate::effect::thin_lens::{self, ThinLens};
    use glam::DVec2;

    #[test]
    fn keys_differ_and_nothing_acts_by_default() {
        for (k, row) in TABLE.iter().enumerate() {
            assert!(std::ptr::eq(row.id.row(), row) && row.id as usize == k, "{}", row.key());
            assert_eq!(serde_json::json!(row.id), row.key());
            assert!(TABLE[..k].iter().all(|other| other.key() != row.key()), "{}", row.key());
            assert!(!(row.acts)(&Effects::default()), "{}", row.key());
        }
        assert_eq!(
            Effects::default().variants(0).iter().collect::<Vec<_>>(),
            [Variant { pupil: DVec2::ZERO, slopes: [DVec2::ZERO; 2], wave: None, grey: 1.0, colour: None }]
        );
    }

    #[test]
    fn weights_of_the_variants_sum_up_to_one() {
        let lens = ThinLens::new(2.8, 1000.0, thin_lens::Aperture::Circle, 35.0);
        for points in [1, 2, 7, 64] {
            let quadrature = Quadrature { points, ..Quadrature::default() };
            let effects = Effects { lens: Lens::Thin(lens), quadrature, ..Effects::default() };
            let variants = effects.variants(0);
            // In pairs.
            assert_eq!(variants.len(), points.next_multiple_of(2));
            let sum: f64 = variants.iter().map(|v| v.grey).sum();
            // One rounding for each term.
            assert!((sum - 1.0).abs() <= variants.len() as f64 * f64::EPSILON, "{sum}");
        }
    }
}
