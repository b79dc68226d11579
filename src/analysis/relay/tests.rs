//! The paper's prisms against an independent program in numpy, which shares nothing with this one but the surfaces.

use super::field_curvature::foci;
use super::lens::{RelayLens, disc, perfect_contrast};
use super::mtf::{contrasts, diffraction};
use super::pencil::Pencil;
use super::spot::{PencilSpot, best_focus_mm};
use super::study::{RelayHalf, RelaySettings};
use super::wave_error::WaveError;
use crate::scene::{self, PrismSpec, Scene};
use crate::system::{self, Prism, Side, System};
use glam::{DVec2, DVec3};
use std::sync::LazyLock;

const LENS: RelayLens = RelayLens { na: 0.09, magnification: 0.55, wavelength_mm: 486.1327e-6 };

/// The flat prism of the paper, and the freeform one that the other program had: designed in steps of a pixel, with points that count
/// alike.
static PRISMS: LazyLock<[System; 2]> = LazyLock::new(|| {
    let text = include_str!("../../../scenes/paper.toml");
    let scene = scene::parse(text, "paper", None).unwrap_or_else(|problem| panic!("{problem}"));
    let PrismSpec::Freeform(flat, _) = &scene.prism else { panic!("it is designed") };
    let flat = Scene { prism: PrismSpec::Flat(*flat), ..scene.clone() };
    [flat, freeform_of_the_tables()].map(|scene| system::build(&scene).unwrap_or_else(|problem| panic!("{problem}")))
});

/// The paper's scene with the prism of the tables in `tests/oracle`.
pub(in crate::analysis) fn freeform_of_the_tables() -> Scene {
    let paper = include_str!("../../../scenes/paper.toml");
    let (before, rest) = paper.split_once("[prism]").expect("it has a prism");
    let (_, behind) = rest.split_once("[board]").expect("it has a board");
    let text = format!("{before}{}\n[board]{behind}", include_str!("../../../tests/oracle/prism.toml"));
    scene::parse(&text, "tables", None).unwrap_or_else(|problem| panic!("{problem}"))
}

/// The pencil of the pinhole, through surfaces that do not end: the lens takes in more than the half image.
fn pencil<'a>(system: &System, prism: &'a Prism) -> Pencil<'a> {
    Pencil::new(system, prism, Side::Right, DVec3::ZERO)
}

fn close(found: f64, wanted: f64, relative: f64) {
    assert!((found / wanted - 1.0).abs() < relative, "{found} for {wanted}");
}

#[test]
fn rays_are_those_of_another_tracer() {
    let wanted = [
        ([9.165275594585, -4.112445966208, 87.017], [0.03599397246095, -0.04821044217756], 91.053093813433),
        ([9.208559855513, -4.219726371064, 86.877594753477], [0.03698485743753, -0.04847511189361], 90.918873194953),
    ];
    for (system, (back, sines, path)) in PRISMS.iter().zip(wanted) {
        let prism = system.prism().expect("it has one").continued();
        let pencil = pencil(system, &prism);
        let ray = pencil.at(pencil.middle() + DVec2::new(1.3, -1.7) / 35.0).expect("it passes");
        assert!(ray.exit.origin.distance(DVec3::from_array(back)) < 1e-9, "{}", ray.exit.origin);
        assert!((ray.exit.direction.truncate() - DVec2::from_array(sines)).length() < 1e-12, "{}", ray.exit.direction);
        assert!((ray.optical_path_mm - path).abs() < 1e-9, "{}", ray.optical_path_mm);
    }
}

#[test]
fn spots_are_those_of_another_program() {
    let wanted = [
        ([59.13786047, 63.82580699, 120.4208249], [1.04552565, 46.37676485]),
        ([0.4351640339, 0.4352352925, 1.475288413], [-0.007753982451, 0.3395706417]),
    ];
    for (system, (fixed, best)) in PRISMS.iter().zip(wanted) {
        let prism = system.prism().expect("it has one").continued();
        let pencil = pencil(system, &prism);
        let rays = pencil.pupil(LENS.na, &disc(16)).expect("all pass");
        let chief = pencil.aimed(DVec2::ZERO, pencil.middle()).expect("it passes").exit;
        let scale = 1e3 * LENS.magnification;
        let spot = PencilSpot::new(&rays, &chief, 0.0);
        for (found, wanted) in [spot.rms_mm, spot.rms_about_chief_mm, spot.radius_mm].into_iter().zip(fixed) {
            close(found * scale, wanted, 1e-7);
        }
        let focus = best_focus_mm(&rays).expect("they are not parallel");
        assert!((focus - best[0]).abs() < 1e-7 * best[0].abs().max(1e-2), "{focus}");
        close(PencilSpot::new(&rays, &chief, focus).rms_mm * scale, best[1], 1e-7);
    }
}

/// Fig. 7 of the design paper in the reading that gives its 64.004 um: 64 x 64 rays of the half image, and no others.
#[test]
fn spots_of_the_half_image_are_those_of_another_program() {
    for (system, wanted) in PRISMS.iter().zip([63.64167575, 0.4927642312]) {
        let settings = RelaySettings { lens: LENS, focus_mm: Some(0.0), object_mm: 0.0, field_mm: 1.0 };
        for side in [Side::Left, Side::Right] {
            let half = RelayHalf::new(system, side, settings).expect("it is one");
            let spot = half.spot().expect("all pass").half_image.expect("all pass");
            close(spot.rms_mm * 1e3 * LENS.magnification, wanted, 1e-7);
        }
    }
}

#[test]
fn foci_are_those_of_another_program_and_of_close_rays() {
    let wanted = [
        [[-0.1255579678, 2.243184305], [-2.610485617, 1.472548421]],
        [[0.000137875928, -0.0001825026645], [0.003369684985, 0.0006114361945]],
    ];
    for (system, wanted) in PRISMS.iter().zip(wanted) {
        let prism = system.prism().expect("it has one").continued();
        let pencil = pencil(system, &prism);
        for (u, wanted) in [0.0, 2.64].into_iter().zip(wanted) {
            let found = foci(&pencil, 35.0, DVec2::new(u, 0.0)).expect("it passes").fans_mm;
            for (found, wanted) in found.into_iter().zip(wanted) {
                assert!((found - wanted).abs() < 1e-9, "{u}: {found} for {wanted}");
            }
        }
        for uv in [DVec2::new(1.3, -1.7), DVec2::new(-2.64, 2.97), DVec2::new(0.4, 2.0)] {
            let found = foci(&pencil, 35.0, uv).expect("it passes");
            // The derivatives that rays carry know nothing of wave fronts.
            let fan = pencil.fans(pencil.middle() + uv / 35.0).expect("it passes");
            for (focus, [place, turn]) in found.fans_mm.into_iter().zip(fan.fans) {
                let near = fan.exit.at(-place.dot(turn) / turn.length_squared()).z;
                assert!((focus - near).abs() < 1e-9, "{uv}: {focus} for {near}");
            }
        }
    }
}

/// Root mean square of the wave error over rings of rays, from its mean and its tilt along x.
fn sampled_rms(wave: &WaveError, rings: usize) -> f64 {
    let places = disc(rings);
    let waves: Vec<f64> = places.iter().map(|p| wave.waves(*p, 0.0)).collect();
    let count = waves.len() as f64;
    let mean = waves.iter().sum::<f64>() / count;
    let tilt = 4.0 * places.iter().zip(&waves).map(|(p, w)| p.x * w).sum::<f64>() / count;
    let square = |(p, w): (&DVec2, &f64)| (w - mean - tilt * p.x) * (w - mean - tilt * p.x);
    (places.iter().zip(&waves).map(square).sum::<f64>() / count).sqrt()
}

#[test]
fn contrasts_are_those_of_another_program() {
    let wanted = [
        (4.8827825, [[0.08461894, 0.00350508], [0.04353244, 0.00025847]]),
        (0.025974623, [[0.90551602, 0.90017241], [0.81154990, 0.79928028]]),
    ];
    close(perfect_contrast(LENS.wavelength_mm * 0.55 * 50.0 / LENS.na), 0.90552316, 1e-7);
    for (system, (waves, wanted)) in PRISMS.iter().zip(wanted) {
        let prism = system.prism().expect("it has one").continued();
        let pencil = pencil(system, &prism);
        let wave = WaveError::new(&pencil, &LENS, 0.0).expect("it is smooth");
        // The other program takes its mean over 40 rings of rays, which this one need not.
        close(sampled_rms(&wave, 40), waves, 1e-7);
        close(sampled_rms(&wave, 400), wave.rms_waves, 1e-5);
        let rays = pencil.pupil(LENS.na, &disc(16)).expect("all pass");
        for (frequency, wanted) in [50.0, 100.0].into_iter().zip(wanted) {
            let found = contrasts(&wave, &rays, frequency, &[0.0]).expect("it settles")[0];
            for (found, wanted) in found.diffraction.into_iter().zip(wanted) {
                assert!((found - wanted).abs() < 1e-6, "{frequency}: {found} for {wanted}");
            }
        }
        assert_eq!(diffraction(&wave, LENS.cut_off_per_mm(), DVec2::X, &[0.0]), Some(vec![0.0]));
    }
}
