//! What polynomials leave of the points that a prism's surfaces are fitted to, over their degree.

use crate::design::fit::{SurfaceFit, coefficients, fit_degrees};
use crate::design::{self, DesignInput};
use crate::error::Error;
use crate::num::powers::Powers;
use crate::scene::{CloudSpec, DesignedSurface, PrismSpec, Scene};
use crate::surface::face::Face;
use glam::{DVec2, DVec3};

/// The lowest and the highest degree that are tried besides that of the prism itself.
const DEGREES: [usize; 2] = [2, 9];

/// What the polynomial of a degree leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DegreeFit {
    /// The surface.
    pub face: Face,
    /// Total degree.
    pub degree: usize,
    /// Whether the prism has this one.
    pub own: bool,
    /// Coefficients that are fitted.
    pub coefficients: usize,
    /// Points that they are fitted to.
    pub points: usize,
    /// Root mean square of the residuals along z, in mm.
    pub rms_mm: f64,
    /// Largest residual along z, in mm.
    pub max_mm: f64,
}

/// The fits of a prism's surfaces.
#[derive(Debug, Clone, PartialEq)]
pub enum DegreeFits {
    /// Over the degree, front and back; degrees that the points do not determine are left out.
    Fitted(Vec<DegreeFit>),
    /// There are none, and why.
    NotFitted(&'static str),
}

/// The fits of the prism of `scene`.
///
/// # Errors
/// When the prism is designed, and there is no such design.
pub(crate) fn degree_fits(scene: &Scene) -> Result<DegreeFits, Error> {
    match &scene.prism {
        PrismSpec::Freeform(_, settings) if settings.surface == DesignedSurface::Revolved => {
            Ok(DegreeFits::NotFitted("its surfaces are of revolution, and no polynomials"))
        }
        PrismSpec::Freeform(_, settings) => designed(scene, settings.degree),
        PrismSpec::PointCloud(clouds) => {
            let of = |face, cloud: &CloudSpec| one(face, (&cloud.points_mm, &[]), cloud.degree, cloud.powers(), None);
            Ok(DegreeFits::Fitted([of(Face::Front, &clouds.front), of(Face::Back, &clouds.back)].concat()))
        }
        PrismSpec::None | PrismSpec::Flat(_) => Ok(DegreeFits::NotFitted("its surfaces are planes")),
        PrismSpec::Polynomial(_) => Ok(DegreeFits::NotFitted("the scene states its polynomials, and no points")),
        PrismSpec::Revolved(_) => Ok(DegreeFits::NotFitted("the scene states its surfaces of revolution")),
        PrismSpec::Mesh(_) => Ok(DegreeFits::NotFitted("its surfaces are triangles")),
    }
}

fn designed(scene: &Scene, degree: usize) -> Result<DegreeFits, Error> {
    let none =
        DegreeFits::NotFitted("its polynomials are found by least squares of the rays, and go through no points");
    let Some(input) = DesignInput::of(scene) else { return Ok(none) };
    let integrator = design::stated_integrator(&input.settings);
    let Some(points) = design::fitted_points(&input, integrator)? else { return Ok(none) };
    let ([front_mm, back_mm], [front, back]) = (points.surfaces_mm(), points.centres_mm());
    let weights = points.weights();
    let of = |face, points: &[DVec3], centre| one(face, (points, &weights), degree, Powers::EvenInY, Some(centre));
    Ok(DegreeFits::Fitted([of(Face::Front, &front_mm, front), of(Face::Back, &back_mm, back)].concat()))
}

fn one(face: Face, points: (&[DVec3], &[f64]), own: usize, kept: Powers, centre: Option<DVec2>) -> Vec<DegreeFit> {
    let mut degrees: Vec<usize> = (DEGREES[0]..=DEGREES[1]).collect();
    if !degrees.contains(&own) {
        degrees.push(own);
        degrees.sort_unstable();
    }
    let named = |(degree, fit): (&usize, SurfaceFit)| DegreeFit {
        face,
        degree: *degree,
        own: *degree == own,
        coefficients: coefficients(*degree, kept),
        points: fit.points,
        rms_mm: fit.rms_mm,
        max_mm: fit.max_mm,
    };
    let found = fit_degrees(points, &degrees, kept, centre);
    degrees.iter().zip(found).filter_map(|(degree, fit)| fit.ok().map(|fit| named((degree, fit)))).collect()
}
