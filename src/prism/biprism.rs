//! The biprism: two sides, each a front and a back surface between the same media.

use super::packet::PackedBiprism;
use super::payload::Payload;
use super::refract_at::pass;
use super::side::Side;
use super::surface_modifier::{Imperfections, SurfaceModifier};
use crate::design::cloud_fit::FitResiduals;
use crate::effect::{Clipping, Effects};
use crate::geom::{Pose, Ray};
use crate::optics::fate::Fate;
use crate::scene;
use crate::surface::face::Face;
use crate::surface::hit::Hit;
use crate::surface::shape::{PolynomialSurface, Surface};
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// A biprism: rays enter through the front of one side and leave through the back of the same side.
#[derive(Debug, Clone, PartialEq)]
pub struct Prism {
    /// Between the world and the prism's frame; `None` where the two are the same, so that no rounding enters.
    pub(crate) poses: Option<[Pose; 2]>,
    /// Front and back of the left, then of the right side.
    pub(crate) sides: [[Surface; 2]; 2],
    /// n_outer / n_glass
    eta_in: f64,
    /// n_glass / n_outer
    eta_out: f64,
    /// n_outer, n_glass
    indices: [f64; 2],
    /// What front and back do besides, if anything.
    imperfections: Option<Box<[Imperfections; 2]>>,
    /// Whether the left side is the mirror image of the right one.
    symmetric: bool,
    /// Whether each back bounds the glass of its own half only.
    solid: bool,
    /// How well front and back go through the points that they were fitted to, where they were.
    fits: Option<Arc<[FitResiduals; 2]>>,
    /// What the halves of the picture are meant to be, where it is known.
    law: Option<scene::PrismLaw>,
}

impl Prism {
    /// The glass of `body` between `sides`, front and back of the left and then of the right one, mirror images of each other.
    pub fn new(body: &scene::GlassSpec, sides: [[Surface; 2]; 2]) -> Self {
        let pose = body.world_from_prism;
        let poses = (!pose.is_identity()).then(|| [pose, pose.inverse()]);
        let indices = [body.outer_index, body.index];
        Self {
            poses,
            sides,
            eta_in: indices[0] / indices[1],
            eta_out: indices[1] / indices[0],
            indices,
            imperfections: None,
            symmetric: true,
            solid: false,
            fits: None,
            law: body.law,
        }
    }

    /// The same glass where its index is greater by `shift`, as it is at another wavelength.
    #[must_use]
    pub fn with_index_shift(&self, shift: f64) -> Self {
        let [outer, glass] = [self.indices[0], self.indices[1] + shift];
        Self { eta_in: outer / glass, eta_out: glass / outer, indices: [outer, glass], ..self.clone() }
    }

    /// The same glass with other surfaces, which need not be mirror images, somewhere else.
    pub(super) fn rebuilt(self, poses: Option<[Pose; 2]>, sides: [[Surface; 2]; 2]) -> Self {
        Self { poses, sides, symmetric: false, ..self }
    }

    /// The same glass with its surfaces continued beyond where they were given, where their formulas go on there.
    #[must_use]
    pub fn continued(&self) -> Self {
        let sides = self.sides.each_ref().map(|side| side.each_ref().map(Surface::continued));
        Self { sides, ..self.clone() }
    }

    /// How well front and back go through the points that they were fitted to; `None` where they were not.
    pub fn fits(&self) -> Option<&[FitResiduals; 2]> {
        self.fits.as_deref()
    }

    /// What the halves of the picture are meant to be, where the scene states it or the design aims at it.
    pub fn law(&self) -> Option<&scene::PrismLaw> {
        self.law.as_ref()
    }

    /// This prism, of which is known how well front and back go through the points that they were fitted to.
    #[must_use]
    pub fn with_fits(self, fits: [FitResiduals; 2]) -> Self {
        Self { fits: Some(Arc::new(fits)), ..self }
    }

    /// This prism, whose left side need not be the mirror image of the right one.
    #[must_use]
    pub fn asymmetric(self) -> Self {
        Self { symmetric: false, ..self }
    }

    /// This prism as one piece of glass, where `solid`: light leaves it through the back of the half in which it does.
    #[must_use]
    pub fn with_solid(self, solid: bool) -> Self {
        Self { solid: solid && !self.has_one_back(), ..self }
    }

    /// Whether light leaves through the back of the half in which it does, and not through that of the facet by which it
    /// came, and the two differ.
    pub fn is_solid(&self) -> bool {
        self.solid
    }

    /// Whether its surfaces refract by their shapes alone, without rims, flaws of their finish and the like.
    pub fn is_ideal(&self) -> bool {
        self.imperfections.is_none()
    }

    /// Whether both halves have one and the same back, so that it does not matter whose light leaves through.
    pub fn has_one_back(&self) -> bool {
        let [left, right] = Side::ALL.map(|side| self.surface(side, Face::Back));
        left == right || (self.symmetric && right.is_own_mirror_image())
    }

    /// From the world to the prism's frame.
    pub fn prism_from_world(&self) -> Pose {
        self.poses.map_or(Pose::IDENTITY, |[_, prism_from_world]| prism_from_world)
    }

    /// This ideal prism of polynomials with another front or back.
    #[must_use]
    pub fn with_patch(&self, face: Face, patch: &scene::PolynomialPatch) -> Self {
        let mut prism = self.clone();
        for (side, mirrored) in prism.sides.iter_mut().zip([true, false]) {
            side[face as usize] = Surface::Freeform(PolynomialSurface::new(patch, mirrored));
        }
        prism
    }

    /// Refractive indices of the surroundings and of the glass.
    pub fn indices(&self) -> [f64; 2] {
        self.indices
    }

    /// This ideal prism with what `effects` say of it.
    #[must_use]
    pub fn with_effects(&self, effects: &Effects) -> Self {
        let made = match effects.manufacture.as_ref().filter(|errors| !errors.is_nothing()) {
            Some(errors) => self.made(errors),
            None => self.clone(),
        };
        let clip = effects.clipping.filter(|clipping| !clipping.is_nothing());
        made.with_imperfections(clip, [DVec2::ZERO; 2])
    }

    /// The same prism with `slopes` added to those of the front and the back wherever light is refracted.
    #[must_use]
    pub fn with_slopes(&self, slopes: [DVec2; 2]) -> Self {
        let clip = self.imperfections.as_ref().and_then(|both| both[0].clip);
        self.clone().with_imperfections(clip, slopes)
    }

    fn with_imperfections(self, clip: Option<Clipping>, slopes: [DVec2; 2]) -> Self {
        let both = Face::ALL.map(|face| Imperfections { face, clip, slope: slopes[face as usize] });
        let imperfections = (!both.iter().all(Imperfections::is_nothing)).then(|| Box::new(both));
        Self { imperfections, ..self }
    }

    /// Whether the two sides are mirror images of each other in the world's plane x = 0, bit for bit.
    pub fn keeps_mirror_images(&self) -> bool {
        self.symmetric
            && self.imperfections.iter().flat_map(|both| both.iter()).all(|one| one.slope == DVec2::ZERO)
            && self.poses.is_none_or(|poses| poses.iter().all(Pose::keeps_mirror_images))
    }

    /// The prism for packets of rays, each surface laid out by `shape`; `None` where `shape` is for some surface, where a
    /// part of the surfaces is clipped or rough, or where glass and surroundings have one index, which refraction treats apart.
    pub fn for_packets<S>(&self, shape: impl Fn(&Surface) -> Option<S>) -> Option<PackedBiprism<S>> {
        let side = |[front, back]: &[Surface; 2]| Some([shape(front)?, shape(back)?]);
        let sides = [side(&self.sides[0])?, side(&self.sides[1])?];
        let eta = [self.eta_in, self.eta_out];
        let packed = PackedBiprism { poses: self.poses, sides, eta, solid: self.solid };
        (eta != [1.0, 1.0] && self.imperfections.is_none()).then_some(packed)
    }

    /// The ray behind the prism and the side that it passed, both in the world.
    #[inline(always)]
    pub fn pass<C: Payload>(&self, ray: &Ray, residual_mm: f64, carry: &mut C) -> Result<(Ray, Side), Fate> {
        match &self.imperfections {
            None => self.pass_modified(ray, residual_mm, carry, &[(); 2]),
            Some(both) => self.pass_imperfect(ray, residual_mm, carry, both),
        }
    }

    /// Apart, so that the way of a ray through ideal surfaces is as short as if there were no others.
    #[inline(never)]
    fn pass_imperfect<C: Payload>(
        &self,
        ray: &Ray,
        residual_mm: f64,
        carry: &mut C,
        imperfections: &[Imperfections; 2],
    ) -> Result<(Ray, Side), Fate> {
        self.pass_modified(ray, residual_mm, carry, imperfections)
    }

    #[inline(always)]
    fn pass_modified<C: Payload>(
        &self,
        ray: &Ray,
        residual_mm: f64,
        carry: &mut C,
        modifiers: &[impl SurfaceModifier; 2],
    ) -> Result<(Ray, Side), Fate> {
        let own = self.enter(ray, carry);
        let (side, meeting) = self.first_facet(&own, residual_mm)?;
        modifiers[0].pass(|| own.at(meeting.t_mm))?;
        self.refract(&own, side, &meeting, residual_mm, carry, modifiers).map(|out| (out, side))
    }

    /// Whether light goes on from this place (in the prism's frame) of the front or the back.
    pub(crate) fn passes_at(&self, face: Face, at_mm: DVec3) -> bool {
        self.imperfections.as_ref().is_none_or(|both| both[face as usize].passes_at(at_mm))
    }

    /// The normal by which the front or the back refracts.
    pub(crate) fn normal(&self, face: Face, meeting: &Hit) -> DVec3 {
        self.imperfections.as_ref().map_or(meeting.normal, |both| both[face as usize].normal(meeting))
    }

    /// The ray behind the prism when it passes `side`, whether or not it meets that side of the ridge, and unclipped.
    pub fn pass_through<C: Payload>(
        &self,
        ray: &Ray,
        side: Side,
        residual_mm: f64,
        carry: &mut C,
    ) -> Result<Ray, Fate> {
        let own = self.enter(ray, carry);
        let meeting = self.surface(side, Face::Front).intersect(&own, residual_mm)?;
        match &self.imperfections {
            None => self.refract(&own, side, &meeting, residual_mm, carry, &[(); 2]),
            Some(both) => {
                let unclipped = both.map(|one| Imperfections { clip: None, ..one });
                self.refract(&own, side, &meeting, residual_mm, carry, &unclipped)
            }
        }
    }

    /// The side whose glass holds a place of the world.
    pub fn side_at(&self, world_mm: DVec3) -> Side {
        let own_mm = self.poses.map_or(world_mm, |[_, prism_from_world]| prism_from_world.point(world_mm));
        if own_mm.x < 0.0 { Side::Left } else { Side::Right }
    }

    /// Where a ray of the world meets the front of a side, in the prism's frame, in mm.
    pub(crate) fn met_mm(&self, ray: &Ray, side: Side, residual_mm: f64) -> Option<DVec3> {
        let own = self.enter(ray, &mut ());
        self.surface(side, Face::Front).intersect(&own, residual_mm).ok().map(|met| own.at(met.t_mm))
    }

    /// The front or back surface of a side, in the prism's frame.
    pub fn surface(&self, side: Side, face: Face) -> &Surface {
        &self.sides[side as usize][face as usize]
    }

    /// The ray behind the prism when other shapes stand in for the surfaces of `side`: `intersect` says where a ray, in the
    /// prism's frame, meets the front or the back.
    pub fn pass_shapes(
        &self,
        ray: &Ray,
        side: Side,
        mut intersect: impl FnMut(Face, &Ray) -> Result<Hit, Fate>,
    ) -> Result<Ray, Fate> {
        let own = self.enter(ray, &mut ());
        let [front, back] = &self.sides[side as usize];
        let met = intersect(Face::Front, &own)?;
        let inside = pass(&own, front, &(), &met, self.eta_in, &mut ())?;
        let met = intersect(Face::Back, &inside)?;
        let out = pass(&inside, back, &(), &met, self.eta_out, &mut ())?;
        Ok(self.poses.map_or(out, |[world_from_prism, _]| out.moved(&world_from_prism)))
    }

    #[inline(always)]
    fn enter<C: Payload>(&self, ray: &Ray, carry: &mut C) -> Ray {
        match &self.poses {
            None => *ray,
            Some([_, prism_from_world]) => {
                carry.moved(prism_from_world);
                ray.moved(prism_from_world)
            }
        }
    }

    #[inline(always)]
    fn refract<C: Payload>(
        &self,
        ray: &Ray,
        side: Side,
        front: &Hit,
        residual_mm: f64,
        carry: &mut C,
        modifiers: &[impl SurfaceModifier; 2],
    ) -> Result<Ray, Fate> {
        let [facet, base] = &self.sides[side as usize];
        let [on_front, on_back] = modifiers;
        let out = pass(ray, facet, on_front, front, self.eta_in, carry).and_then(|inside| {
            let (base, meeting) = if self.solid {
                self.back_behind(&inside, side, residual_mm)?
            } else {
                (base, base.intersect(&inside, residual_mm)?)
            };
            on_back.pass(|| inside.at(meeting.t_mm))?;
            pass(&inside, base, on_back, &meeting, self.eta_out, carry)
        });
        match &self.poses {
            None => out,
            Some([world_from_prism, _]) => {
                // What was carried so far goes back to the world also when the ray ends inside.
                carry.moved(world_from_prism);
                out.map(|out| out.moved(world_from_prism))
            }
        }
    }
}
