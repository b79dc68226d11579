//! The prism by its surfaces: what operands are put into.

use crate::design::{self, DesignInput, VIRTUAL_CAMERA_Z_MM};
use crate::error::Error;
use crate::scene::{BiprismSpec, DesignedSurface, GlassSpec, PolynomialSpec, PrismSpec, RevolvedSpec, Scene};
use crate::surface::shape::PolynomialPatch;
use crate::system::{facet_angle_rad, polynomials_of};

/// Surfaces of revolution are made larger by this many mm where they can be, or by the next.
const ROOM_MM: [f64; 4] = [2.0, 1.0, 0.5, 0.0];

/// `scene` with a prism that is given by its surfaces: a design is made, points are fitted, once, and a flat prism has its angle stated.
/// Surfaces are larger than they were, so that rays that an error leads astray find glass as well.
///
/// # Errors
/// When the prism cannot be designed or fitted.
pub fn made_of_surfaces(scene: &Scene) -> Result<Scene, Error> {
    let prism = match &scene.prism {
        PrismSpec::Freeform(flat, settings) => {
            let input = DesignInput {
                camera: scene.camera,
                prism: *flat,
                settings: *settings,
                virtual_camera_z_mm: VIRTUAL_CAMERA_Z_MM,
            };
            let body = GlassSpec { solid: Some(scene.prism.is_solid()), ..flat.body };
            match settings.surface {
                DesignedSurface::Revolved => revolved(&input, body)?,
                DesignedSurface::Polynomial => {
                    let designed = design::freeform(&input)?;
                    let body = GlassSpec { law: body.law.or_else(|| Some(designed.law())), ..body };
                    with_room(designed.prism(body))
                }
            }
        }
        PrismSpec::Flat(flat) => {
            let angle = facet_angle_rad(flat, &scene.camera)?;
            PrismSpec::Flat(BiprismSpec { facet_angle_rad: Some(angle), ..*flat })
        }
        PrismSpec::PointCloud(clouds) => with_room(polynomials_of(clouds)?.0),
        PrismSpec::Polynomial(prism) => with_room(prism.clone()),
        PrismSpec::Revolved(_) | PrismSpec::Mesh(_) | PrismSpec::None => scene.prism.clone(),
    };
    Ok(Scene { prism, ..scene.clone() })
}

fn with_room(prism: PolynomialSpec) -> PrismSpec {
    let larger = |patch: PolynomialPatch| {
        let spare_mm = patch.domain.size().max_element();
        PolynomialPatch { domain: patch.domain.grown(spare_mm), ..patch }
    };
    PrismSpec::Polynomial(PolynomialSpec { front: larger(prism.front), back: larger(prism.back), body: prism.body })
}

/// Surfaces of revolution with as much room as their profiles have.
fn revolved(input: &DesignInput, body: GlassSpec) -> Result<PrismSpec, Error> {
    let made = ROOM_MM.iter().find_map(|spare_mm| design::revolved_by(input, *spare_mm).ok());
    let ([front, back], law) = match made {
        Some(made) => made,
        None => design::revolved_by(input, 0.0)?,
    };
    let body = GlassSpec { law: body.law.or(Some(law)), ..body };
    Ok(PrismSpec::Revolved(RevolvedSpec { body, front, back }))
}
