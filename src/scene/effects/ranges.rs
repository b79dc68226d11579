//! The ranges of the settings of effects that were made in code.

use crate::effect::clipping::{Clipping, Outline};
use crate::effect::manufacture::{Manufacture, SurfaceError};
use crate::effect::thin_lens::{Aperture, ThinLens};
use crate::effect::{Dispersion, Effects, Lens, Sensor};
use crate::error::Error;
use crate::optics::fresnel::Layer;
use crate::scene::ranges::Ranges;
use std::f64::consts::TAU;

impl Ranges<'_> {
    /// Every setting of `effects`.
    pub(in crate::scene) fn effects(&self, effects: &Effects) -> Result<(), Error> {
        match &effects.lens {
            Lens::Pinhole => {}
            Lens::Thin(lens) => self.thin_lens(lens)?,
            Lens::Telecentric(lens) => {
                self.number("effect.telecentric.magnification", lens.magnification)?;
                self.number("effect.telecentric.na", lens.na)?;
                self.number("effect.telecentric.focus_mm", lens.focus_mm)?;
            }
        }
        if let Some(clipping) = &effects.clipping {
            self.clipping(clipping)?;
        }
        if let Some(errors) = &effects.manufacture {
            self.manufacture(errors)?;
        }
        if let Some(rough) = &effects.roughness {
            let [front, back] = rough.slope.map(|slope| libm::atan(slope).to_degrees());
            self.converted("effect.roughness.front_slope_deg", front)?;
            self.converted("effect.roughness.back_slope_deg", back)?;
        }
        self.optional("effect.cos4.exponent", effects.cos4.map(|cos4| cos4.exponent))?;
        if let Some(lamp) = &effects.lamp {
            self.vector("effect.lamp.position_mm", lamp.position_mm)?;
            self.number("effect.lamp.share", lamp.share)?;
        }
        self.glass(effects)?;
        if let Some(diffraction) = &effects.diffraction {
            self.number("effect.diffraction.f_number", diffraction.f_number)?;
            self.number("effect.diffraction.wavelength_nm", diffraction.wavelength_nm)?;
        }
        if let Some(sensor) = &effects.sensor {
            self.sensor(sensor)?;
        }
        self.count("quadrature.points", effects.quadrature.points)?;
        self.count("quadrature.replicates", effects.quadrature.replicates)?;
        self.optional("quadrature.noise", effects.quadrature.noise)?;
        self.optional("effects.auto.grey", effects.auto.and_then(|auto| auto.grey))?;
        self.optional("effects.auto.px", effects.auto.and_then(|auto| auto.px))
    }

    /// What the glass does to light.
    fn glass(&self, effects: &Effects) -> Result<(), Error> {
        if let Some(coating) = &effects.coating {
            self.number("effect.coating.index", coating.layer.index)?;
            self.layer(coating.layer)?;
        }
        self.optional("effect.absorption.per_mm", effects.absorption.map(|absorption| absorption.per_mm))?;
        if let Some(ghosts) = &effects.ghosts {
            self.number("effect.ghosts.bounces", f64::from(ghosts.bounces))?;
            self.number("effect.ghosts.least_power", ghosts.least_power)?;
            self.number("effect.ghosts.behind", ghosts.behind)?;
            self.count("effect.ghosts.samples", ghosts.samples)?;
        }
        match &effects.dispersion {
            None => Ok(()),
            Some(Dispersion { waves, .. }) => {
                let waves: Vec<f64> = waves.iter().map(|wave| wave.wavelength_nm).collect();
                self.list("effect.dispersion.lines_nm", &waves)
            }
        }
    }

    /// A layer may be as thick as a file may say, or as a quarter of a wavelength that it may say.
    fn layer(&self, layer: Layer) -> Result<(), Error> {
        let quarter_wave_nm = 4.0 * layer.index * layer.thickness_nm;
        match self.converted("effect.coating.quarter_wave_nm", quarter_wave_nm) {
            Ok(()) => Ok(()),
            Err(_) => self.number("effect.coating.thickness_nm", layer.thickness_nm),
        }
    }

    /// A lens without an aperture is a pinhole, and has no f-number.
    fn thin_lens(&self, lens: &ThinLens) -> Result<(), Error> {
        if lens.radius_mm != 0.0 {
            self.converted("effect.thin_lens.f_number", 0.5 * lens.focal_mm / lens.radius_mm)?;
        }
        self.number("effect.thin_lens.focus_mm", lens.focus_mm)?;
        match lens.aperture {
            Aperture::Circle => Ok(()),
            Aperture::Polygon { blades, rotation_rad } => {
                self.count("effect.thin_lens.blades", blades)?;
                self.converted("effect.thin_lens.rotation_deg", rotation_rad.to_degrees())
            }
        }
    }

    fn clipping(&self, clipping: &Clipping) -> Result<(), Error> {
        match clipping.outline {
            None => {}
            Some(Outline::Rectangle { half_mm }) => {
                self.list("effect.clipping.rim.sides_mm", &(2.0 * half_mm).to_array())?;
            }
            Some(Outline::Circle { radius_mm }) => self.number("effect.clipping.rim.diameter_mm", 2.0 * radius_mm)?,
        }
        self.number("effect.clipping.chamfer_mm", clipping.chamfer_mm)?;
        self.optional("effect.clipping.stop.at_mm", clipping.stop.map(|stop| stop.distance_mm))?;
        self.optional("effect.clipping.stop.diameter_mm", clipping.stop.map(|stop| 2.0 * stop.radius_mm))
    }

    fn manufacture(&self, errors: &Manufacture) -> Result<(), Error> {
        self.vector("effect.manufacture.decentre_mm", errors.prism.decentre_mm)?;
        self.tilt("effect.manufacture.tilt_deg", errors.prism.tilt_rad)?;
        self.number("effect.manufacture.thickness_mm", errors.thickness_mm)?;
        self.number("effect.manufacture.index", errors.index)?;
        self.surface_error("effect.manufacture.front", &errors.front)?;
        self.surface_error("effect.manufacture.back", &errors.back)
    }

    fn surface_error(&self, at: &str, error: &SurfaceError) -> Result<(), Error> {
        self.vector(&format!("{at}.decentre_mm"), error.place.decentre_mm)?;
        self.tilt(&format!("{at}.tilt_deg"), error.place.tilt_rad)?;
        let Some(figure) = &error.figure else { return Ok(()) };
        let key = format!("{at}.zernike.terms");
        for (_, _, c) in figure.sag.terms() {
            if !c.is_finite() {
                let rule = format!("`{key}` sum up to a polynomial with a coefficient {c}, which must be finite");
                return Err(self.refuse(&key, rule, "give smaller terms"));
            }
        }
        self.length(&format!("{at}.waves"), figure.waves.len())?;
        figure.waves.iter().enumerate().try_for_each(|(i, wave)| {
            let key = |name: &str| format!("{at}.waves[{i}].{name}");
            self.converted(&key("amplitude_um"), wave.amplitude_mm * 1000.0)?;
            self.converted(&key("period_mm"), TAU / wave.rad_per_mm.length())?;
            self.converted(&key("phase_deg"), wave.phase_rad.to_degrees())
        })
    }

    fn sensor(&self, sensor: &Sensor) -> Result<(), Error> {
        self.number("effect.sensor.frame", f64::from(sensor.frame))?;
        self.number("effect.sensor.fill_factor", sensor.fill_factor)?;
        if let Some(bayer) = &sensor.bayer {
            self.list("effect.sensor.transmission", &bayer.transmission)?;
        }
        self.number("effect.sensor.white_e", sensor.white_e)?;
        self.number("effect.sensor.prnu", sensor.prnu)?;
        self.number("effect.sensor.dark_e", sensor.dark_e)?;
        self.number("effect.sensor.dsnu_e", sensor.dsnu_e)?;
        self.number("effect.sensor.read_noise_e", sensor.read_noise_e)?;
        // An infinite well is one that is left out.
        self.optional("effect.sensor.full_well_e", Some(sensor.full_well_e).filter(|e| *e != f64::INFINITY))?;
        if let Some(adc) = &sensor.adc {
            self.number("effect.sensor.adc_bits", f64::from(adc.bits))?;
            self.number("effect.sensor.black_level_dn", adc.black_level_dn)?;
            self.above_zero("effect.sensor.gain_dn_per_e", adc.gain_dn_per_e)?;
        }
        self.number("effect.sensor.gamma", sensor.gamma)
    }

    /// A gain that is left out may be any that the well and the converter give.
    fn above_zero(&self, key: &str, value: f64) -> Result<(), Error> {
        if value > 0.0 && value.is_finite() {
            return Ok(());
        }
        Err(self.refuse(key, format!("`{key}` is {value}, and must be a finite number, above 0"), "give another gain"))
    }
}
