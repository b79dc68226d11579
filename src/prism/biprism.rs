//! The prism as two sides, each a front and a back surface between the same media.

use super::finish::{Finish, Unideal};
use super::first_face::RIDGE_ROUNDINGS;
use super::packet::PackedBiprism;
use super::payload::Payload;
use super::refract_at::pass;
use super::surface_modifier::Relief;
use crate::design::cloud_fit::{CloudFitInput, FitResiduals, fit_cloud};
use crate::design::{DesignInput, VIRTUAL_CAMERA_Z_MM};
use crate::effect::Effects;
use crate::error::Error;
use crate::geom::{Pose, Ray, Rect};
use crate::optics::fate::Fate;
use crate::surface::hit::Hit;
use crate::surface::mesh::{Mesh, Triangles};
use crate::surface::shape::{PolynomialSurface, Surface};
use crate::{design, scene};
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// The facet angle that the scene states, or else the angle of Eq. 5.
///
/// # Errors
/// When Eq. 5 has no solution for these media and this camera.
pub fn facet_angle_rad(flat: &scene::BiprismSpec, camera: &scene::CameraSpec) -> Result<f64, Error> {
    match flat.facet_angle_rad {
        Some(angle) => Ok(angle),
        None => design::angle::facet_angle_rad(flat.body.index / flat.body.outer_index, camera.half_centre_rad()),
    }
}

/// A designed prism, larger than the rays of its design on every side, so that rays that stray from them by `effects` find
/// glass as well.
#[must_use]
pub fn with_room_for(
    mut designed: scene::PolynomialSpec,
    flat: &scene::BiprismSpec,
    effects: &Effects,
) -> scene::PolynomialSpec {
    let reach_mm = |domain: Rect| domain.min.abs().max(domain.max.abs()).length();
    let reach_mm = reach_mm(designed.front.domain).max(reach_mm(designed.back.domain));
    let spare_mm = effects.spare_mm(reach_mm, flat.thickness_mm, flat.body.index / flat.body.outer_index);
    for patch in [&mut designed.front, &mut designed.back] {
        patch.domain = patch.domain.grown(spare_mm);
    }
    designed
}

/// The polynomial of a user's cloud, the `key` surface of a prism, and what it leaves.
fn fitted(key: &str, cloud: &scene::CloudSpec) -> Result<(scene::PolynomialPatch, FitResiduals), Error> {
    fit_cloud(&CloudFitInput {
        points_mm: &cloud.points_mm,
        degree: cloud.degree,
        powers: cloud.powers(),
        max_residual_mm: cloud.max_residual_mm,
        name: &format!("`prism.{key}` ({})", cloud.file),
    })
}

/// A side of the prism: x < 0 or x >= 0 in its own frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Side {
    /// x < 0
    Left,
    /// x >= 0
    Right,
}

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
    /// What the surfaces do besides, if anything.
    finish: Option<Box<Unideal>>,
    /// Whether the left side is the mirror image of the right one.
    symmetric: bool,
    /// How well front and back go through the points that they were fitted to, where they were.
    fits: Option<Arc<[FitResiduals; 2]>>,
}

impl Prism {
    /// The prism of a scene as it is meant to be; `None` where the scene has none. A designed one is made larger than the
    /// rays of the design on every side, so that rays that stray from them by `effects` find glass as well.
    ///
    /// # Errors
    /// When a design is asked for that does not exist.
    pub fn build(
        prism: &scene::PrismSpec,
        camera: &scene::CameraSpec,
        effects: &Effects,
    ) -> Result<Option<Self>, Error> {
        match prism {
            scene::PrismSpec::None => Ok(None),
            scene::PrismSpec::Flat(flat) => Self::flat(flat, camera).map(Some),
            scene::PrismSpec::Freeform(flat, settings) => {
                let input = DesignInput {
                    camera: *camera,
                    prism: *flat,
                    settings: *settings,
                    virtual_camera_z_mm: VIRTUAL_CAMERA_Z_MM,
                };
                let designed = design::freeform(&input)?.prism(flat.body);
                Ok(Some(Self::polynomial(&with_room_for(designed, flat, effects))))
            }
            scene::PrismSpec::Polynomial(p) => Ok(Some(Self::polynomial(p))),
            scene::PrismSpec::PointCloud(clouds) => {
                let (front, front_fit) = fitted("front", &clouds.front)?;
                let (back, back_fit) = fitted("back", &clouds.back)?;
                let prism = Self::polynomial(&scene::PolynomialSpec { body: clouds.body, front, back });
                Ok(Some(Self { fits: Some(Arc::new([front_fit, back_fit])), ..prism }))
            }
            scene::PrismSpec::Mesh(m) => {
                let meshes = |own: [&Triangles; 2]| own.map(|t| Arc::new(Mesh::new(t.clone(), m.normals)));
                let side = |own: [Arc<Mesh>; 2], mirrored| own.map(|mesh| Surface::Mesh { mesh, mirrored });
                let right = meshes([&m.front, &m.back]);
                let left = match &m.left {
                    None => side(right.clone(), true),
                    Some([front, back]) => side(meshes([front, back]), false),
                };
                let prism = Self::new(&m.body, [left, side(right, false)]);
                Ok(Some(Self { symmetric: m.left.is_none(), ..prism }))
            }
        }
    }

    fn flat(flat: &scene::BiprismSpec, camera: &scene::CameraSpec) -> Result<Self, Error> {
        let (sin, cos) = libm::sincos(facet_angle_rad(flat, camera)?);
        let ridge = DVec3::new(0.0, 0.0, flat.ridge_distance_mm);
        let base = Surface::Plane {
            point: DVec3::new(0.0, 0.0, flat.ridge_distance_mm + flat.thickness_mm),
            normal: DVec3::Z,
        };
        // The facet z = D + |x| tan(alpha) has the gradient (-sign(x) sin(alpha), 0, cos(alpha)).
        let facet = |sign: f64| Surface::Plane { point: ridge, normal: DVec3::new(-sign * sin, 0.0, cos) };
        Ok(Self::new(&flat.body, [[facet(-1.0), base.clone()], [facet(1.0), base]]))
    }

    fn polynomial(p: &scene::PolynomialSpec) -> Self {
        let side =
            |mirrored| [&p.front, &p.back].map(|patch| Surface::Freeform(PolynomialSurface::new(patch, mirrored)));
        Self::new(&p.body, [side(true), side(false)])
    }

    fn new(body: &scene::GlassSpec, sides: [[Surface; 2]; 2]) -> Self {
        let pose = body.world_from_prism;
        let poses = (!pose.is_identity()).then(|| [pose, pose.inverse()]);
        let indices = [body.outer_index, body.index];
        Self {
            poses,
            sides,
            eta_in: indices[0] / indices[1],
            eta_out: indices[1] / indices[0],
            indices,
            finish: None,
            symmetric: true,
            fits: None,
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

    /// How well front and back go through the points that they were fitted to; `None` where they were not.
    pub fn fits(&self) -> Option<&[FitResiduals; 2]> {
        self.fits.as_deref()
    }

    /// From the world to the prism's frame.
    pub fn prism_from_world(&self) -> Pose {
        self.poses.map_or(Pose::IDENTITY, |[_, prism_from_world]| prism_from_world)
    }

    /// This ideal prism of polynomials with another front (0) or back (1).
    #[must_use]
    pub fn with_patch(&self, which: usize, patch: &scene::PolynomialPatch) -> Self {
        let mut prism = self.clone();
        for (side, mirrored) in prism.sides.iter_mut().zip([true, false]) {
            side[which] = Surface::Freeform(PolynomialSurface::new(patch, mirrored));
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
        made.finished(Unideal { clip, slopes: [DVec2::ZERO; 2] })
    }

    /// The same prism with `slopes` added to those of the front and the back wherever light is refracted.
    #[must_use]
    pub fn with_slopes(&self, slopes: [DVec2; 2]) -> Self {
        let clip = self.finish.as_ref().and_then(|finish| finish.clip);
        self.clone().finished(Unideal { clip, slopes })
    }

    fn finished(self, finish: Unideal) -> Self {
        Self { finish: (finish != Unideal::default()).then(|| Box::new(finish)), ..self }
    }

    /// Whether the two sides are mirror images of each other in the world's plane x = 0, bit for bit.
    pub fn keeps_mirror_images(&self) -> bool {
        self.symmetric
            && self.finish.as_ref().is_none_or(|finish| finish.slopes == [DVec2::ZERO; 2])
            && self.poses.is_none_or(|poses| poses.iter().all(Pose::keeps_mirror_images))
    }

    /// The prism for packets of rays, each surface laid out by `shape`; `None` where `shape` is for some surface, where a
    /// part of the surfaces is clipped or rough, or where glass and surroundings have one index, which refraction treats apart.
    pub fn for_packets<S>(&self, shape: impl Fn(&Surface) -> Option<S>) -> Option<PackedBiprism<S>> {
        let side = |[front, back]: &[Surface; 2]| Some([shape(front)?, shape(back)?]);
        let sides = [side(&self.sides[0])?, side(&self.sides[1])?];
        let eta = [self.eta_in, self.eta_out];
        (eta != [1.0, 1.0] && self.finish.is_none()).then_some(PackedBiprism { poses: self.poses, sides, eta })
    }

    /// The ray behind the prism and the side that it passed, both in the world.
    #[inline(always)]
    pub fn pass<C: Payload>(&self, ray: &Ray, residual_mm: f64, carry: &mut C) -> Result<(Ray, Side), Fate> {
        match &self.finish {
            None => self.pass_finished(ray, residual_mm, carry, &()),
            Some(finish) => self.pass_unideal(ray, residual_mm, carry, finish),
        }
    }

    /// Apart, so that the way of a ray through ideal surfaces is as short as if there were no others.
    #[inline(never)]
    fn pass_unideal<C: Payload>(
        &self,
        ray: &Ray,
        residual_mm: f64,
        carry: &mut C,
        finish: &Unideal,
    ) -> Result<(Ray, Side), Fate> {
        self.pass_finished(ray, residual_mm, carry, finish)
    }

    #[inline(always)]
    fn pass_finished<C: Payload>(
        &self,
        ray: &Ray,
        residual_mm: f64,
        carry: &mut C,
        finish: &impl Finish,
    ) -> Result<(Ray, Side), Fate> {
        let own = self.enter(ray, carry);
        let (side, meeting) = self.first_facet(&own, residual_mm)?;
        finish.keep(0, &own, &meeting)?;
        self.refract(&own, side, &meeting, residual_mm, carry, finish).map(|out| (out, side))
    }

    /// Whether light goes on from this place (in the prism's frame) of the front (0) or the back (1).
    pub(crate) fn passes_at(&self, which: usize, at_mm: DVec3) -> bool {
        self.finish.as_ref().is_none_or(|finish| finish.passes_at(which, at_mm))
    }

    /// The normal by which the front (0) or the back (1) refracts.
    pub(crate) fn normal(&self, which: usize, meeting: &Hit) -> DVec3 {
        self.finish.as_ref().map_or(meeting.normal, |finish| finish.relief(which).normal(meeting))
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
        let meeting = self.sides[side as usize][0].intersect(&own, residual_mm)?;
        match &self.finish {
            None => self.refract(&own, side, &meeting, residual_mm, carry, &()),
            Some(finish) => {
                let unclipped = Unideal { clip: None, ..**finish };
                self.refract(&own, side, &meeting, residual_mm, carry, &unclipped)
            }
        }
    }

    /// Where a ray of the world meets the front of a side, in the prism's frame, in mm.
    pub(crate) fn met_mm(&self, ray: &Ray, side: Side, residual_mm: f64) -> Option<DVec3> {
        let own = self.enter(ray, &mut ());
        self.sides[side as usize][0].intersect(&own, residual_mm).ok().map(|met| own.at(met.t_mm))
    }

    /// The front (0) or back (1) surface of a side, in the prism's frame.
    pub fn surface(&self, side: Side, which: usize) -> &Surface {
        &self.sides[side as usize][which]
    }

    /// The ray behind the prism when other shapes stand in for the surfaces of `side`: `intersect` says where a ray, in the
    /// prism's frame, meets the front (0) or the back (1).
    pub fn pass_shapes(
        &self,
        ray: &Ray,
        side: Side,
        mut intersect: impl FnMut(usize, &Ray) -> Result<Hit, Fate>,
    ) -> Result<Ray, Fate> {
        let own = self.enter(ray, &mut ());
        let [front, back] = &self.sides[side as usize];
        let met = intersect(0, &own)?;
        let inside = pass(&own, front, &(), &met, self.eta_in, &mut ())?;
        let met = intersect(1, &inside)?;
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

    /// The side whose facet the ray (in the prism's frame) meets first, on that side's own half.
    #[inline(always)]
    fn first_facet(&self, ray: &Ray, residual_mm: f64) -> Result<(Side, Hit), Fate> {
        let (x, dx) = (ray.origin.x, ray.direction.x);
        // A ray that never changes the sign of x can meet one side only.
        if x >= 0.0 && dx >= 0.0 {
            return self.sides[1][0].intersect(ray, residual_mm).map(|m| (Side::Right, m));
        }
        if x <= 0.0 && dx < 0.0 {
            return self.sides[0][0].intersect(ray, residual_mm).map(|m| (Side::Left, m));
        }
        let right = self.sides[1][0].intersect(ray, residual_mm).map(|m| (Side::Right, m));
        let left = self.sides[0][0].intersect(ray, residual_mm).map(|m| (Side::Left, m));
        let right_is_own = right.is_ok_and(|(_, m)| ray.at(m.t_mm).x >= 0.0);
        let left_is_own = left.is_ok_and(|(_, m)| ray.at(m.t_mm).x < 0.0);
        match (left_is_own, right_is_own) {
            (true, true) => left.and_then(|l| right.map(|r| if l.1.t_mm < r.1.t_mm { l } else { r })),
            (true, false) => left,
            (false, true) => right,
            (false, false) => match (right, left) {
                // Both sides meet in the ridge: a ray that finds neither on its own half went through the ridge itself,
                // to within the rounding of x.
                (Ok((_, m)), Ok(_)) if ray.at(m.t_mm).x.abs() <= RIDGE_ROUNDINGS * (x.abs() + m.t_mm) => right,
                _ => Err(right.err().or(left.err()).unwrap_or(Fate::Missed)),
            },
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
        finish: &impl Finish,
    ) -> Result<Ray, Fate> {
        let [facet, base] = &self.sides[side as usize];
        let out = pass(ray, facet, &finish.relief(0), front, self.eta_in, carry).and_then(|inside| {
            let meeting = base.intersect(&inside, residual_mm)?;
            finish.keep(1, &inside, &meeting)?;
            pass(&inside, base, &finish.relief(1), &meeting, self.eta_out, carry)
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
