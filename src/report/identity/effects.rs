//! The effects of an instrument.

use super::canonical::{Canonical, CanonicalObject};
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

/// The effects that are there.
pub(super) fn effects(effects: &Effects) -> CanonicalObject<'_> {
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
    object()
        .maybe("thin_lens", lens.thin().copied().map(thin_lens))
        .maybe("telecentric", lens.telecentric().copied().map(telecentric))
        .maybe("clipping", clipping.map(clip))
        .maybe("manufacture", manufacture.as_ref().map(made))
        .maybe("roughness", roughness.map(|Roughness { slope }| object().with("slope", slope)))
        .maybe("cos4", cos4.map(|Cos4 { exponent }| object().with("exponent", exponent)))
        .maybe("lamp", lamp.map(lit))
        .maybe("fresnel", fresnel.map(|Fresnel { light }| object().with("polarisation", polarisation(light))))
        .maybe("coating", coating.map(coated))
        .maybe("absorption", absorption.map(|Absorption { per_mm }| object().with("per_mm", per_mm)))
        .maybe("ghosts", ghosts.map(ghost))
        .maybe("dispersion", dispersion.as_ref().map(dispersed))
        .maybe("diffraction", diffraction.map(diffracted))
        .maybe("sensor", sensor.map(sensed))
        .with("quadrature", sampled(quadrature))
        .maybe("auto", auto.map(|Threshold { grey, px }| object().maybe("grey", grey).maybe("px", px)))
}

fn object<'a>() -> CanonicalObject<'a> {
    CanonicalObject::default()
}

fn thin_lens<'a>(lens: ThinLens) -> CanonicalObject<'a> {
    let ThinLens { focus_mm, focal_mm, radius_mm, aperture } = lens;
    let aperture = match aperture {
        Aperture::Circle => object().with("shape", "circle"),
        Aperture::Polygon { blades, rotation_rad } => {
            object().with("shape", "polygon").with("blades", blades).with("rotation_rad", rotation_rad)
        }
    };
    object()
        .with("focus_mm", focus_mm)
        .with("focal_mm", focal_mm)
        .with("radius_mm", radius_mm)
        .with("aperture", aperture)
}

fn telecentric<'a>(Telecentric { magnification, na, focus_mm }: Telecentric) -> CanonicalObject<'a> {
    object().with("magnification", magnification).with("na", na).with("focus_mm", focus_mm)
}

fn clip<'a>(clipping: Clipping) -> CanonicalObject<'a> {
    let Clipping { outline, chamfer_mm, stop } = clipping;
    let outline = outline.map(|outline| match outline {
        Outline::Rectangle { half_mm } => object().with("shape", "rectangle").with("half_mm", half_mm),
        Outline::Circle { radius_mm } => object().with("shape", "circle").with("radius_mm", radius_mm),
    });
    let stop = stop
        .map(|Stop { distance_mm, radius_mm }| object().with("distance_mm", distance_mm).with("radius_mm", radius_mm));
    object().maybe("outline", outline).with("chamfer_mm", chamfer_mm).maybe("stop", stop)
}

fn made(made: &Manufacture) -> CanonicalObject<'_> {
    let Manufacture { prism, front, back, thickness_mm, index } = made;
    object()
        .with("prism", displaced(prism))
        .with("front", erred(front))
        .with("back", erred(back))
        .with("thickness_mm", *thickness_mm)
        .with("index", *index)
}

fn displaced<'a>(Displacement { decentre_mm, tilt_rad }: &Displacement) -> CanonicalObject<'a> {
    object().with("decentre_mm", *decentre_mm).with("tilt_rad", *tilt_rad)
}

fn erred(SurfaceError { place, figure }: &SurfaceError) -> CanonicalObject<'_> {
    let wave = |SurfaceWave { amplitude_mm, rad_per_mm, phase_rad }: &SurfaceWave| {
        object().with("amplitude_mm", *amplitude_mm).with("rad_per_mm", *rad_per_mm).with("phase_rad", *phase_rad)
    };
    let figure = figure.as_ref().map(|FigureError { sag, waves }| {
        object().with("sag", sag).with("waves", waves.iter().map(wave).collect::<Canonical<'_>>())
    });
    object().with("place", displaced(place)).maybe("figure", figure)
}

fn lit<'a>(Lamp { position_mm, share, reference_per_mm2 }: Lamp) -> CanonicalObject<'a> {
    object().with("position_mm", position_mm).with("share", share).with("reference_per_mm2", reference_per_mm2)
}

fn polarisation(light: PolarisationState) -> &'static str {
    match light {
        PolarisationState::Unpolarised => "unpolarised",
        PolarisationState::X => "x",
        PolarisationState::Y => "y",
    }
}

fn coated<'a>(coating: Coating) -> CanonicalObject<'a> {
    let Coating { layer: Layer { index, thickness_nm }, outer_index, wavelength_nm } = coating;
    object()
        .with("index", index)
        .with("thickness_nm", thickness_nm)
        .with("outer_index", outer_index)
        .with("wavelength_nm", wavelength_nm)
}

fn ghost<'a>(Ghosts { bounces, least_power, behind, samples }: Ghosts) -> CanonicalObject<'a> {
    object()
        .with("bounces", f64::from(bounces))
        .with("least_power", least_power)
        .with("behind", behind)
        .with("samples", samples)
}

fn dispersed<'a>(Dispersion { waves, colour }: &Dispersion) -> CanonicalObject<'a> {
    let wave = |Wavelength { wavelength_nm, index_shift, weights }: &Wavelength| {
        object().with("wavelength_nm", *wavelength_nm).with("index_shift", *index_shift).with("weights", *weights)
    };
    object().with("waves", waves.iter().map(wave).collect::<Canonical<'_>>()).with("colour", *colour)
}

fn diffracted<'a>(Diffraction { wavelength_nm, f_number, pitch_mm }: Diffraction) -> CanonicalObject<'a> {
    object().with("wavelength_nm", wavelength_nm).with("f_number", f_number).with("pitch_mm", pitch_mm)
}

fn sensed<'a>(sensor: Sensor) -> CanonicalObject<'a> {
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
    let adc = adc.map(|Adc { bits, gain_dn_per_e, black_level_dn }| {
        object()
            .with("bits", f64::from(bits))
            .with("gain_dn_per_e", gain_dn_per_e)
            .with("black_level_dn", black_level_dn)
    });
    object()
        .with("seed", seed.to_string().as_str())
        .with("frame", frame)
        .with("fill_factor", fill_factor)
        .maybe("bayer", bayer.map(filtered))
        .with("white_e", white_e)
        .with("prnu", prnu)
        .with("dark_e", dark_e)
        .with("shot_noise", shot_noise)
        .maybe("full_well_e", full_well_e.is_finite().then_some(full_well_e))
        .with("dsnu_e", dsnu_e)
        .with("read_noise_e", read_noise_e)
        .maybe("adc", adc)
        .with("gamma", gamma)
}

fn filtered<'a>(Bayer { order, transmission, demosaic }: Bayer) -> CanonicalObject<'a> {
    let order = match order {
        Order::Rggb => "rggb",
        Order::Bggr => "bggr",
        Order::Grbg => "grbg",
        Order::Gbrg => "gbrg",
    };
    let demosaic = match demosaic {
        Demosaic::Raw => "raw",
        Demosaic::Bilinear => "bilinear",
    };
    object().with("order", order).with("transmission", transmission).with("demosaic", demosaic)
}

fn sampled<'a>(Quadrature { points, replicates, noise, seed, fill }: &Quadrature) -> CanonicalObject<'a> {
    object()
        .with("points", *points)
        .with("replicates", *replicates)
        .maybe("noise", *noise)
        .with("seed", seed.to_string().as_str())
        .maybe("fill", fill.then_some(true))
}
