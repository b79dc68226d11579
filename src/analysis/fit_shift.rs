//! What the misfit of a prism's surfaces to their points moves in the picture.

use crate::design::cloud_fit::FitResiduals;
use crate::design::fit::fit_powers;
use crate::num::poly2::Poly2;
use crate::scene::{CloudSpec, PolynomialPatch, PrismSpec, Scene};
use crate::surface::face::Face;
use crate::surface::shape::Surface;
use crate::system::{Prism, Side, System};
use glam::{DVec2, DVec3};

/// The fit of one surface and what it moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitShift {
    /// How well the polynomial goes through its points.
    pub residuals: FitResiduals,
    /// How far a sag higher by 1 mm moves the board's point in the picture, in px a mm: on the ray of the picture that
    /// passes nearest to the worst point, through the inverse of its footprint (mm on the board a px). `None` where no ray
    /// passes.
    pub px_per_mm: Option<f64>,
    /// The largest shift of the picture, in px, when the surface is fitted with two degrees more: what the misfit does by
    /// its slopes, as far as the points tell. `None` where they do not determine so many coefficients twice over.
    pub finer_px: Option<f64>,
}

/// Rays of the picture that are asked, along its width and its height.
const RAYS: [usize; 2] = [20, 12];
/// By how much a sag is raised to see what it moves, in mm.
const RAISED_MM: f64 = 1e-4;
/// Degrees more than the fit has.
const MORE_DEGREES: usize = 2;
/// Points that the finer fit goes through; of larger clouds every n-th is taken.
const POINTS: usize = 20_000;

/// Front and back of an instrument whose prism was fitted to clouds of points.
pub fn fit_shifts(scene: &Scene, system: &System) -> Option<[FitShift; 2]> {
    let PrismSpec::PointCloud(clouds) = &scene.prism else { return None };
    let prism = system.designed()?;
    let fits = prism.fits()?;
    Some(Face::ALL.map(|face| {
        let cloud = [&clouds.front, &clouds.back][face as usize];
        FitShift {
            residuals: fits[face as usize],
            px_per_mm: px_per_mm(system, prism, face, fits[face as usize].worst_mm),
            finer_px: finer_px(system, prism, face, cloud),
        }
    }))
}

/// The rays of a grid over the picture that pass, by their places.
fn passing(system: &System) -> impl Iterator<Item = DVec2> {
    let size = DVec2::from_array(system.camera().size_px().map(|n| n as f64));
    let place = |k: usize| DVec2::new((k % RAYS[0]) as f64 + 0.5, (k / RAYS[0]) as f64 + 0.5);
    let grid = DVec2::new(RAYS[0] as f64, RAYS[1] as f64);
    (0..RAYS[0] * RAYS[1]).map(move |k| size * place(k) / grid).filter(|px| system.footprint(*px).is_ok())
}

/// How far the picture of what `px` sees moves from one instrument to the other, in px.
fn shift_px(from: &System, to: &System, px: DVec2) -> Option<f64> {
    let here = from.footprint(px).ok()?;
    let there = to.footprint_through(px, here.sight.side).ok()?;
    let moved = here.jacobian.inverse() * (there.sight.board_mm - here.sight.board_mm);
    moved.is_finite().then(|| moved.length())
}

fn px_per_mm(system: &System, prism: &Prism, face: Face, worst_mm: DVec3) -> Option<f64> {
    let Surface::Freeform(sheet) = prism.surface(Side::Right, face) else { return None };
    let (sag, domain) = (sheet.sag(), sheet.domain());
    let coefficients: Vec<_> = sag.terms().collect();
    let raised = |m: usize, n: usize| {
        let own = coefficients.iter().find(|t| (t.0, t.1) == (m, n)).map_or(0.0, |t| t.2);
        if m + n == 0 { own + RAISED_MM } else { own }
    };
    let sag = Poly2::new(sag.degree(), sag.centre(), sag.scale(), raised);
    let raised = system.with_prism(&prism.with_patch(face, &PolynomialPatch { sag, domain }));
    let prism_from_world = prism.prism_from_world();
    let distance = |px: &DVec2| {
        let met = system.path(*px).0.points.get(face as usize).map(|p| prism_from_world.point(*p));
        // A place of the left half is the mirror image of one of the right.
        met.map_or(f64::INFINITY, |p| DVec2::new(p.x.abs(), p.y).distance_squared(worst_mm.truncate()))
    };
    let nearest = passing(system).min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    shift_px(system, &raised, nearest).map(|px| px / RAISED_MM)
}

fn finer_px(system: &System, prism: &Prism, face: Face, cloud: &CloudSpec) -> Option<f64> {
    let stride = cloud.points_mm.len().div_ceil(POINTS).max(1);
    let points: Vec<DVec3> = cloud.points_mm.iter().copied().step_by(stride).collect();
    let fitted = |degree: usize| {
        let found = fit_powers(&points, degree, cloud.powers(), None).ok()?;
        let determined = points.len() >= 2 * crate::design::fit::coefficients(degree, cloud.powers());
        determined.then(|| system.with_prism(&prism.with_patch(face, &found.patch)))
    };
    let (own, finer) = (fitted(cloud.degree)?, fitted(cloud.degree + MORE_DEGREES)?);
    passing(system).filter_map(|px| shift_px(&own, &finer, px)).reduce(f64::max)
}
