//! The effects of an instrument.

use super::checksum::Checksum;
use crate::effect::clipping::{Outline, Stop};
use crate::effect::dispersion::Wavelength;
use crate::effect::manufacture::{Displacement, SurfaceError};
use crate::effect::sensor::{Adc, Bayer, Demosaic, Order};
use crate::effect::thin_lens::Aperture;
use crate::effect::{
    Absorption, Clipping, Coating, Cos4, Diffraction, Dispersion, Effects, Fresnel, Ghosts, Lamp, Manufacture,
    Quadrature, Roughness, Sensor, Telecentric, ThinLens, Threshold,
};
use crate::optics::fresnel::Layer;
use crate::optics::polarisation::PolarisationState;
use crate::surface::figure_error::{FigureError, SurfaceWave};

/// Adds all effects, those that are absent too.
pub(super) fn add(values: &mut Checksum, effects: &Effects) {
    let Effects {
        lens,
        clipping,
        manufacture,
        roughness,
        cos4,
        lamp,
        fresnel,
        coating,
        absorption,
        ghosts,
        dispersion,
        diffraction,
        sensor,
        quadrature,
        auto,
    } = effects;
    values.option(lens.thin().copied(), add_thin_lens);
    values.option(lens.telecentric().copied(), |values, Telecentric { magnification, na, focus_mm }| {
        values.numbers([magnification, na, focus_mm]);
    });
    values.option(*clipping, add_clipping);
    values.option(manufacture.as_ref(), add_manufacture);
    values.option(*roughness, |values, Roughness { slope }| values.numbers(slope));
    values.option(*cos4, |values, Cos4 { exponent }| values.number(exponent));
    values.option(*lamp, |values, Lamp { position_mm, share, reference_per_mm2 }| {
        values.point(position_mm);
        values.numbers([share, reference_per_mm2]);
    });
    values.option(*fresnel, |values, Fresnel { light }| values.word(polarisation(light)));
    values.option(*coating, |values, Coating { layer: Layer { index, thickness_nm }, outer_index, wavelength_nm }| {
        values.numbers([index, thickness_nm, outer_index, wavelength_nm]);
    });
    values.option(*absorption, |values, Absorption { per_mm }| values.number(per_mm));
    values.option(*ghosts, |values, Ghosts { bounces, least_power, behind, samples }| {
        values.numbers([f64::from(bounces), least_power, behind]);
        values.count(samples);
    });
    values.option(dispersion.as_ref(), |values, Dispersion { waves, colour }| {
        values.list(waves, |values, Wavelength { wavelength_nm, index_shift, weights }| {
            values.numbers([*wavelength_nm, *index_shift]);
            values.numbers(*weights);
        });
        values.flag(*colour);
    });
    values.option(*diffraction, |values, Diffraction { wavelength_nm, f_number, pitch_mm }| {
        values.numbers([wavelength_nm, f_number, pitch_mm]);
    });
    values.option(*sensor, add_sensor);
    add_quadrature(values, quadrature);
    values.option(*auto, |values, Threshold { grey, px }| {
        values.option(grey, Checksum::number);
        values.option(px, Checksum::number);
    });
}

fn add_thin_lens(values: &mut Checksum, lens: ThinLens) {
    let ThinLens { focus_mm, focal_mm, radius_mm, aperture } = lens;
    values.numbers([focus_mm, focal_mm, radius_mm]);
    match aperture {
        Aperture::Circle => values.word("circle"),
        Aperture::Polygon { blades, rotation_rad } => {
            values.word("polygon");
            values.count(blades);
            values.number(rotation_rad);
        }
    }
}

fn add_clipping(values: &mut Checksum, clipping: Clipping) {
    let Clipping { outline, chamfer_mm, stop } = clipping;
    values.option(outline, |values, outline| match outline {
        Outline::Rectangle { half_mm } => {
            values.word("rectangle");
            values.plane_point(half_mm);
        }
        Outline::Circle { radius_mm } => {
            values.word("circle");
            values.number(radius_mm);
        }
    });
    values.number(chamfer_mm);
    values.option(stop, |values, Stop { distance_mm, radius_mm }| values.numbers([distance_mm, radius_mm]));
}

fn add_manufacture(values: &mut Checksum, made: &Manufacture) {
    let Manufacture { prism, front, back, thickness_mm, index } = made;
    let displacement = |values: &mut Checksum, Displacement { decentre_mm, tilt_rad }: &Displacement| {
        values.point(*decentre_mm);
        values.point(*tilt_rad);
    };
    displacement(values, prism);
    for SurfaceError { place, figure } in [front, back] {
        displacement(values, place);
        values.option(figure.as_ref(), |values, FigureError { sag, waves }| {
            values.polynomial(sag);
            values.list(waves, |values, SurfaceWave { amplitude_mm, rad_per_mm, phase_rad }| {
                values.number(*amplitude_mm);
                values.plane_point(*rad_per_mm);
                values.number(*phase_rad);
            });
        });
    }
    values.numbers([*thickness_mm, *index]);
}

fn polarisation(light: PolarisationState) -> &'static str {
    match light {
        PolarisationState::Unpolarised => "unpolarised",
        PolarisationState::X => "x",
        PolarisationState::Y => "y",
    }
}

fn add_sensor(values: &mut Checksum, sensor: Sensor) {
    let Sensor {
        seed,
        frame,
        fill_factor,
        bayer,
        white_e,
        prnu,
        dark_e,
        shot_noise,
        full_well_e,
        dsnu_e,
        read_noise_e,
        adc,
        gamma,
    } = sensor;
    values.seed(seed);
    values.number(f64::from(frame));
    values.option(bayer, |values, Bayer { order, transmission, demosaic }| {
        values.word(match order {
            Order::Rggb => "rggb",
            Order::Bggr => "bggr",
            Order::Grbg => "grbg",
            Order::Gbrg => "gbrg",
        });
        values.numbers(transmission);
        values.word(match demosaic {
            Demosaic::Raw => "raw",
            Demosaic::Bilinear => "bilinear",
        });
    });
    values.numbers([fill_factor, white_e, prnu, dark_e, full_well_e, dsnu_e, read_noise_e, gamma]);
    values.flag(shot_noise);
    values.option(adc, |values, Adc { bits, gain_dn_per_e, black_level_dn }| {
        values.numbers([f64::from(bits), gain_dn_per_e, black_level_dn]);
    });
}

fn add_quadrature(values: &mut Checksum, quadrature: &Quadrature) {
    let Quadrature { points, replicates, noise, seed } = quadrature;
    values.count(*points);
    values.count(*replicates);
    values.option(*noise, Checksum::number);
    values.seed(*seed);
}
