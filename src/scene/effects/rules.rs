//! What an effect and the rest of a scene say of each other, beyond the range of each value.

use crate::effect::clipping::Stop;
use crate::effect::diffraction::LARGEST_SCALE_PX;
use crate::effect::quadrature::LEAST_REPLICATES;
use crate::effect::sensor::Adc;
use crate::effect::{Diffraction, Quadrature, Telecentric};
use crate::error::Error;
use crate::num::curve::ChebyshevCurve;
use crate::optics::medium::Material;
use crate::optics::spectrum::WavelengthBand;
use crate::scene::limits::SMALLEST_INDEX;
use crate::scene::model::{BoardSpec, CameraSpec, GlassSpec, PolynomialSpec, PrismSpec, RevolvedSpec, Scene};
use crate::scene::source::ValueSource;
use crate::surface::shape::{PolynomialPatch, RevolvedSurface};
use glam::{DVec2, DVec3};

/// The cone behind a telecentric lens must be less than a half-space as well.
pub(in crate::scene) fn cone_behind(source: &dyn ValueSource, lens: &Telecentric) -> Result<(), Error> {
    let &Telecentric { magnification, na, .. } = lens;
    if na < magnification {
        return Ok(());
    }
    let rule = format!(
        "`effect.telecentric.na` is {na} and `magnification` is {magnification}: behind the lens the aperture would be \
         {}, and must be below 1",
        na / magnification
    );
    let help = "give a smaller `na`: behind a lens it is that before it over the magnification";
    Err(source.refuse("effect.telecentric.na", rule, help))
}

/// Places along the profile of a surface of revolution at which its depth is taken.
const PROFILE_PLACES: usize = 17;

/// What a stop must stand before, and how far along z that is from the camera, in mm: the ridge or the lowest place of the
/// front of the prism, or the middle of the board where there is none.
fn beyond_stop(camera: &CameraSpec, prism: &PrismSpec, board: &BoardSpec) -> (&'static str, f64) {
    let depth = |body: &GlassSpec, point: DVec3| body.world_from_prism.point(point).z - camera.position_mm.z;
    let mirrored = |point: DVec3| [point, DVec3::new(-point.x, point.y, point.z)];
    let lowest = |body: &GlassSpec, points: &mut dyn Iterator<Item = DVec3>| {
        let depths = points.flat_map(mirrored).map(|point| depth(body, point));
        ("front of the prism", depths.fold(f64::INFINITY, f64::min))
    };
    match prism {
        PrismSpec::None => ("board", board.world_from_board.translation_mm.z - camera.position_mm.z),
        PrismSpec::Flat(biprism) | PrismSpec::Freeform(biprism, _) => {
            ("ridge of the prism", depth(&biprism.body, DVec3::Z * biprism.ridge_distance_mm))
        }
        PrismSpec::Polynomial(PolynomialSpec { body, front: PolynomialPatch { sag, domain }, .. }) => {
            // The right half from the ridge on, at the corners and the middles between them.
            let from = DVec2::new(domain.min.x.max(0.0), domain.min.y);
            let place = |k: usize| from + (domain.max - from) * DVec2::new((k % 3) as f64, (k / 3) as f64) / 2.0;
            lowest(body, &mut (0..9).map(place).map(|at| at.extend(sag.value(at.x, at.y))))
        }
        PrismSpec::Revolved(RevolvedSpec { body, front, .. }) => {
            let places = ChebyshevCurve::nodes(front.profile.ends(), PROFILE_PLACES);
            let surface = RevolvedSurface::new(front, false);
            lowest(body, &mut places.into_iter().map(|s| surface.point_of_profile(s)).filter(|p| p.x >= 0.0))
        }
        PrismSpec::PointCloud(prism) => lowest(&prism.body, &mut prism.front.points_mm.iter().copied()),
        PrismSpec::Mesh(prism) => {
            let left = prism.left.iter().flat_map(|[front, _]| &front.points_mm);
            lowest(&prism.body, &mut prism.front.points_mm.iter().chain(left).copied())
        }
    }
}

/// A stop stands before the prism, or before the board where there is none.
pub(in crate::scene) fn stop_in_front(
    source: &dyn ValueSource,
    stop: &Stop,
    camera: &CameraSpec,
    prism: &PrismSpec,
    board: &BoardSpec,
) -> Result<(), Error> {
    let (what, distance_mm) = beyond_stop(camera, prism, board);
    // A stop that is turned with the camera reaches farther with one side of its rim.
    let along = camera.axis().z;
    let reach_mm = along * stop.distance_mm + (1.0 - along * along).max(0.0).sqrt() * stop.radius_mm;
    if reach_mm < distance_mm {
        return Ok(());
    }
    let rule = format!(
        "`effect.clipping.stop.at_mm` is {}, and the {what} is {distance_mm} mm before the camera: the stop stands \
         between the two",
        stop.distance_mm
    );
    Err(source.refuse("effect.clipping.stop.at_mm", rule, "give the stop a smaller distance"))
}

/// A target of noise needs sets enough to know the noise.
pub(in crate::scene) fn sets_tell_noise(source: &dyn ValueSource, quadrature: &Quadrature) -> Result<(), Error> {
    let replicates = quadrature.replicates;
    if quadrature.noise.is_none() || replicates >= LEAST_REPLICATES {
        return Ok(());
    }
    let rule = format!(
        "`quadrature.noise` asks for an error, and `replicates` allows {replicates} of the {LEAST_REPLICATES} sets or more \
         whose spread would tell it"
    );
    let help = "give the largest count of sets that you would wait for as `replicates`, such as 64";
    Err(source.refuse("quadrature.noise", rule, help))
}

/// Points of a pupil stand for the parts of it around them where nothing but the pupil is drawn, before one board, in one set.
pub(in crate::scene) fn fill_fits(source: &dyn ValueSource, scene: &Scene) -> Result<(), Error> {
    let effects = &scene.effects;
    if !effects.quadrature.fill {
        return Ok(());
    }
    let lens = effects.lens.thin().is_some() || effects.lens.telecentric().is_some();
    let refused = [
        (!lens, "the scene has no `[effect.thin_lens]` and no `[effect.telecentric]`"),
        (effects.roughness.is_some(), "`[effect.roughness]` is drawn from the same points"),
        (effects.clipping.is_some(), "`[effect.clipping]` makes borders that are blurred otherwise than the board"),
        (effects.ghosts.is_some(), "`[effect.ghosts]` are blurred otherwise than the board"),
        (effects.diffraction.is_some(), "`[effect.diffraction]` spreads the light of each point"),
        (!scene.objects.is_empty(), "`[[object]]` is blurred otherwise than the board"),
        (effects.quadrature.replicates > 1, "`quadrature.replicates` asks for sets whose mean is without bias"),
    ];
    let Some((_, reason)) = refused.into_iter().find(|(refused, _)| *refused) else { return Ok(()) };
    let rule = format!("`quadrature.fill` lets points of a pupil stand for the parts of it around them, and {reason}");
    Err(source.refuse("quadrature.fill", rule, "take `fill` out, and give more `points`"))
}

/// A table without which the one at `table` says nothing is missing.
pub(in crate::scene) fn needs_fresnel(source: &dyn ValueSource, table: &str) -> Error {
    let rule = format!("`[{table}]` is about light that surfaces reflect, and the scene has no `[effect.fresnel]`");
    source.refuse(table, rule, "add a table `[effect.fresnel]`: what surfaces reflect is missing behind")
}

/// The glass of `prism`, with a name, whose index is given where it is known.
pub(in crate::scene) fn named_glass<'a>(
    source: &dyn ValueSource,
    prism: &'a PrismSpec,
) -> Result<(&'static Material, &'a GlassSpec), Error> {
    let Some((glass, body)) = prism.body().and_then(|body| Some((body.glass?, body))) else {
        let rule = "`[effect.dispersion]` is about a glass, and `prism.glass` is left out".to_owned();
        let help = "add `glass = \"N-BK7\"`, or another glass, to `[prism]`";
        return Err(source.refuse("effect.dispersion", rule, help));
    };
    let [first, last] = glass.range_nm;
    if !(first..=last).contains(&body.wavelength_nm) {
        let rule = format!(
            "`prism.wavelength_nm` is {}, and the index of {} is known from {first} to {last} nm",
            body.wavelength_nm, glass.name
        );
        let help = format!("give the wavelength of `prism.index`, between {first} and {last} nm");
        return Err(source.refuse("prism.wavelength_nm", rule, &help));
    }
    Ok((glass, body))
}

/// The index of `glass` is known for the light at `key`.
pub(in crate::scene) fn glass_is_known(
    source: &dyn ValueSource,
    key: &str,
    band: WavelengthBand,
    glass: &Material,
) -> Result<(), Error> {
    let WavelengthBand { from_nm, to_nm } = band;
    let [first, last] = glass.range_nm;
    if from_nm >= first && to_nm <= last {
        return Ok(());
    }
    let rule = format!(
        "`{key}` runs from {from_nm} to {to_nm} nm, and the index of {} is known from {first} to {last} nm",
        glass.name
    );
    let help = format!("keep the light between {first} and {last} nm, or name another glass");
    let at = if source.gives(key) { key } else { "effect.dispersion" };
    Err(source.refuse(at, rule, &help))
}

/// The pattern of diffraction must not be so large that much of the light comes from far beyond the picture.
pub(in crate::scene) fn pattern_is_kept(source: &dyn ValueSource, diffraction: &Diffraction) -> Result<(), Error> {
    let scale_px = diffraction.scale_px();
    if scale_px <= LARGEST_SCALE_PX {
        return Ok(());
    }
    let rule = format!(
        "`effect.diffraction.f_number` is {}, and wavelength times f-number is then {scale_px:.3} px, above the \
         {LARGEST_SCALE_PX} px that are allowed",
        diffraction.f_number
    );
    Err(source.refuse("effect.diffraction.f_number", rule, "give a smaller `f_number`, or larger pixels"))
}

/// A lamp must stand on the side of the board that the camera sees.
pub(in crate::scene) fn lamp_lights(
    source: &dyn ValueSource,
    position_mm: DVec3,
    camera: &CameraSpec,
    board: &BoardSpec,
) -> Result<(), Error> {
    let (middle, normal) = (board.world_from_board.translation_mm, board.world_from_board.rotation.z_axis);
    let height = |point: DVec3| normal.dot(point - middle);
    if height(position_mm) * height(camera.position_mm) > 0.0 {
        return Ok(());
    }
    let rule = format!(
        "`effect.lamp.position_mm` is {:?}, and the lamp there does not light the side of the board that the camera sees",
        position_mm.to_array()
    );
    Err(source.refuse("effect.lamp.position_mm", rule, "put the lamp on the camera's side of the board's plane"))
}

/// A converter has numbers above its black level.
pub(in crate::scene) fn black_below_white(source: &dyn ValueSource, adc: &Adc) -> Result<(), Error> {
    if adc.black_level_dn < adc.largest_dn() {
        return Ok(());
    }
    let rule = format!(
        "`effect.sensor.black_level_dn` is {}, and the largest number of {} bits is {}",
        adc.black_level_dn,
        adc.bits,
        adc.largest_dn()
    );
    Err(source.refuse("effect.sensor.black_level_dn", rule, "give a lower black level, or more bits"))
}

/// The index of the glass as it was made, by `error` too large, must stay one.
pub(in crate::scene) fn index_stays(source: &dyn ValueSource, error: f64, prism: &PrismSpec) -> Result<(), Error> {
    let Some(body) = prism.body().filter(|body| body.index + error < SMALLEST_INDEX) else { return Ok(()) };
    let rule = format!(
        "`effect.manufacture.index` is {error}, and the index of the glass would be {}, below {SMALLEST_INDEX}",
        body.index + error
    );
    Err(source.refuse("effect.manufacture.index", rule, "give a smaller error of the index"))
}

/// Only a smooth surface has a figure that the errors at `path` can be added to.
pub(in crate::scene) fn figure_has_base(source: &dyn ValueSource, path: &str, prism: &PrismSpec) -> Result<(), Error> {
    if !matches!(prism, PrismSpec::Mesh(_)) {
        return Ok(());
    }
    let rule = format!("`{path}` has errors of figure, and a mesh has its figure in its points");
    let help = "take `zernike` and `waves` out, and give the files of the surface as it was made";
    Err(source.refuse(path, rule, help))
}
