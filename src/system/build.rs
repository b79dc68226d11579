//! The builder: from a scene to its instrument.

use super::auto;
use super::design_store::{DesignStore, DesignedPolynomials};
use super::instrument::System;
use super::light::require_light;
use crate::design::cloud_fit::{FitResiduals, fit_cloud};
use crate::design::misfit::CloudFitInput;
use crate::design::{self, DesignInput, VIRTUAL_CAMERA_Z_MM};
use crate::effect::Effects;
use crate::error::Error;
use crate::geom::Rect;
use crate::prism::biprism::Prism;
use crate::scene::{
    BiprismSpec, CameraSpec, CloudSpec, DesignedSurface, GlassSpec, Objective, PointCloudSpec, PolynomialSpec,
    PrismSpec, RevolvedSpec, Scene,
};
use crate::surface::mesh::{Mesh, Triangles};
use crate::surface::shape::{PolynomialPatch, PolynomialSurface, RevolvedSurface, Surface};
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// A designed prism is made larger for a calibrated camera by at most this share of its reach: farther from the rays of the
/// design its polynomials are of no use, and rays miss it.
const MOST_ROOM: f64 = 0.25;
/// Parts of each side of the picture between the rays by which a calibrated camera is compared with the plain pinhole.
const BORDER_PARTS: usize = 16;

/// Builds the instrument, designing the prism first where the scene asks for that, without the effects that the scene says
/// may be left out.
///
/// # Errors
/// When the prism cannot be designed from the scene's values, its surfaces miss their points by more than they may, or no
/// ray of the picture passes it.
pub fn build(scene: &Scene) -> Result<System, Error> {
    build_from(scene, &DesignStore::default())
}

/// [`build`] with the designs of `designs`, to which those are added that it lacks.
///
/// # Errors
/// As [`build`].
pub fn build_from(scene: &Scene, designs: &DesignStore) -> Result<System, Error> {
    complete(ideal_from(scene, designs)?, scene)
}

/// The instrument of `scene` before its own board, from the `ideal` one of a scene that differs from it in place and light of the
/// board and in the sensor alone: what was designed or made of a texture there is not made again.
///
/// # Errors
/// As [`build`].
pub fn build_before(ideal: &System, scene: &Scene) -> Result<System, Error> {
    complete(ideal.before(&scene.board), scene)
}

/// The instrument of `scene` from its ideal one.
fn complete(ideal: System, scene: &Scene) -> Result<System, Error> {
    // To bound what every effect changes takes as long as a small picture.
    let verdicts = if scene.effects.auto.is_some() { auto::verdicts(&ideal, scene) } else { Vec::new() };
    let effects = auto::settled(&verdicts, scene);
    let system = match ideal.prism {
        Some(_) => ideal.with_effects(&effects),
        // What acts by the glass would only cost time.
        None => ideal.with_effects(&effects.without_glass()),
    };
    require_light(scene, &system)?;
    Ok(system)
}

/// The instrument of a scene without its effects, large enough for all of them.
///
/// # Errors
/// As [`build`].
pub fn ideal(scene: &Scene) -> Result<System, Error> {
    ideal_from(scene, &DesignStore::default())
}

fn ideal_from(scene: &Scene, designs: &DesignStore) -> Result<System, Error> {
    let prism = prism(scene, designs)?.map(|prism| prism.with_solid(scene.prism.is_solid()));
    Ok(System::ideal(scene, prism))
}

/// The prism of a scene as it is meant to be; `None` where the scene has none. A designed one is made larger than the
/// rays of the design on every side, so that rays that stray from them by `effects` find glass as well.
///
/// # Errors
/// When a design is asked for that does not exist.
fn prism(scene: &Scene, designs: &DesignStore) -> Result<Option<Prism>, Error> {
    let (camera, effects) = (&scene.camera, &scene.effects);
    match &scene.prism {
        PrismSpec::None => Ok(None),
        PrismSpec::Flat(spec) => flat(spec, camera).map(Some),
        PrismSpec::Freeform(flat, settings) => {
            let input = DesignInput {
                camera: *camera,
                prism: *flat,
                settings: *settings,
                virtual_camera_z_mm: VIRTUAL_CAMERA_Z_MM,
            };
            if settings.surface == DesignedSurface::Revolved {
                let made = designs.revolved(&input, effects, || revolved_with_room(&input, effects))?;
                return Ok(Some(revolved(&made)));
            }
            let DesignedPolynomials { front, back, law } = designs.polynomials(&input)?;
            // The march aims at what is assumed of a prism that states nothing.
            let aims = (settings.objective != Objective::March).then_some(law);
            let body = GlassSpec { law: flat.body.law.or(aims), ..flat.body };
            Ok(Some(polynomial(&with_room_for(PolynomialSpec { body, front, back }, flat, camera, effects))))
        }
        PrismSpec::Polynomial(p) => Ok(Some(polynomial(p))),
        PrismSpec::Revolved(p) => Ok(Some(revolved(p))),
        PrismSpec::PointCloud(clouds) => {
            let (prism, fits) = polynomials_of(clouds)?;
            Ok(Some(polynomial(&prism).with_fits(fits)))
        }
        PrismSpec::Mesh(m) => {
            let meshes = |own: [&Triangles; 2]| own.map(|t| Arc::new(Mesh::new(t.clone(), m.normals)));
            let side = |own: [Arc<Mesh>; 2], mirrored| own.map(|mesh| Surface::Mesh { mesh, mirrored });
            let right = meshes([&m.front, &m.back]);
            Ok(Some(match &m.left {
                None => Prism::new(&m.body, [side(right.clone(), true), side(right, false)]),
                Some([front, back]) => {
                    Prism::new(&m.body, [side(meshes([front, back]), false), side(right, false)]).asymmetric()
                }
            }))
        }
    }
}

/// A designed prism, larger than the rays of its design on every side, so that rays that stray from them by `effects`, and those
/// of a calibrated `camera`, which is not the plain pinhole of the design, find glass as well.
#[must_use]
pub fn with_room_for(
    mut designed: PolynomialSpec,
    flat: &BiprismSpec,
    camera: &CameraSpec,
    effects: &Effects,
) -> PolynomialSpec {
    let spare_mm = spare_mm([designed.front.domain, designed.back.domain], flat, camera, effects);
    for patch in [&mut designed.front, &mut designed.back] {
        patch.domain = patch.domain.grown(spare_mm);
    }
    designed
}

/// The surfaces of revolution of a design, as large as [`with_room_for`] makes polynomials.
///
/// # Errors
/// When they do not exist, or end within that room.
pub fn revolved_with_room(input: &DesignInput, effects: &Effects) -> Result<RevolvedSpec, Error> {
    let (designed, law) = design::revolved_by(input, 0.0)?;
    let regions = designed.map(|patch| RevolvedSurface::new(&patch, false).region());
    let ([front, back], _) = design::revolved_by(input, spare_mm(regions, &input.prism, &input.camera, effects))?;
    let body = GlassSpec { law: input.prism.body.law.or(Some(law)), ..input.prism.body };
    Ok(RevolvedSpec { body, front, back })
}

/// How far beyond their `domains` front and back of a design must reach, in mm.
fn spare_mm(domains: [Rect; 2], flat: &BiprismSpec, camera: &CameraSpec, effects: &Effects) -> f64 {
    let reach_mm = domains.map(|domain| domain.min.abs().max(domain.max.abs()).length());
    let reach_mm = reach_mm[0].max(reach_mm[1]);
    effects.spare_mm(reach_mm, flat.thickness_mm, flat.body.index / flat.body.outer_index)
        + stray_of_camera_mm(flat, camera).min(MOST_ROOM * reach_mm)
}

/// How far rays of a calibrated camera stray from those of the plain pinhole on the border of the picture, in mm at the base.
fn stray_of_camera_mm(flat: &BiprismSpec, camera: &CameraSpec) -> f64 {
    if camera.calibrated().is_none() {
        return 0.0;
    }
    let tangent = |camera: &CameraSpec, px: DVec2| {
        let direction = camera.direction(px);
        direction.truncate() / direction.z
    };
    let share = |k: usize| k as f64 / BORDER_PARTS as f64;
    let around = (0..=BORDER_PARTS).map(share).flat_map(|s| [[s, 0.0], [s, 1.0], [0.0, s], [1.0, s]]);
    let places = around.map(|place| 2.0 * camera.middle_px() * DVec2::from_array(place));
    let strays = places.map(|px| (tangent(camera, px) - tangent(&camera.plain(), px)).abs().max_element());
    strays.fold(0.0, f64::max) * (flat.ridge_distance_mm + flat.thickness_mm)
}

/// The polynomials of a user's clouds, and what they leave of front and back.
///
/// # Errors
/// When points do not determine a polynomial, or it misses them by more than it may.
pub fn polynomials_of(clouds: &PointCloudSpec) -> Result<(PolynomialSpec, [FitResiduals; 2]), Error> {
    let (front, front_fit) = fitted("front", &clouds.front)?;
    let (back, back_fit) = fitted("back", &clouds.back)?;
    Ok((PolynomialSpec { body: clouds.body, front, back }, [front_fit, back_fit]))
}

/// The polynomial of a user's cloud, the `key` surface of a prism, and what it leaves.
fn fitted(key: &str, cloud: &CloudSpec) -> Result<(PolynomialPatch, FitResiduals), Error> {
    fit_cloud(&CloudFitInput {
        points_mm: &cloud.points_mm,
        degree: cloud.degree,
        powers: cloud.powers(),
        max_residual_mm: cloud.max_residual_mm,
        name: &format!("`prism.{key}` ({})", cloud.file),
    })
}

fn flat(flat: &BiprismSpec, camera: &CameraSpec) -> Result<Prism, Error> {
    let (sin, cos) = libm::sincos(facet_angle_rad(flat, camera)?);
    let ridge = DVec3::new(0.0, 0.0, flat.ridge_distance_mm);
    let base =
        Surface::Plane { point: DVec3::new(0.0, 0.0, flat.ridge_distance_mm + flat.thickness_mm), normal: DVec3::Z };
    // The facet z = D + |x| tan(alpha) has the gradient (-sign(x) sin(alpha), 0, cos(alpha)).
    let facet = |sign: f64| Surface::Plane { point: ridge, normal: DVec3::new(-sign * sin, 0.0, cos) };
    Ok(Prism::new(&flat.body, [[facet(-1.0), base.clone()], [facet(1.0), base]]))
}

fn polynomial(p: &PolynomialSpec) -> Prism {
    let side = |mirrored| [&p.front, &p.back].map(|patch| Surface::Freeform(PolynomialSurface::new(patch, mirrored)));
    Prism::new(&p.body, [side(true), side(false)])
}

fn revolved(p: &RevolvedSpec) -> Prism {
    let part = |patch, mirrored| Surface::Revolved(Box::new(RevolvedSurface::new(patch, mirrored)));
    let side = |mirrored| [part(&p.front, mirrored), part(&p.back, mirrored)];
    Prism::new(&p.body, [side(true), side(false)])
}

/// The facet angle that the scene states, or else the angle of Eq. 5.
///
/// # Errors
/// When Eq. 5 has no solution for these media and this camera.
pub fn facet_angle_rad(flat: &BiprismSpec, camera: &CameraSpec) -> Result<f64, Error> {
    match flat.facet_angle_rad {
        Some(angle) => Ok(angle),
        None => design::angle::facet_angle_rad(flat.body.index / flat.body.outer_index, camera.half_centre_rad()),
    }
}
