//! The bench on which a prism is looked at: the halves of its picture, and the rays that it sends on.

use crate::analysis::half_image::{HalfFrame, row_shift, virtual_camera};
use crate::error::Error;
use crate::geom::Ray;
use crate::metrics::pinhole::Pinhole;
use crate::metrics::row_law::RowShift;
use crate::optics::fate::Fate;
use crate::prism::payload::{Payload, RefractionEvent};
use crate::prism::surface_modifier::SurfaceModifier;
use crate::system::{Prism, Side, System};
use crate::vision::half::Half;
use glam::{DMat2, DVec2, DVec3};

/// One half of the picture with what it is meant to be.
#[derive(Debug, Clone)]
pub(super) struct HalfBench {
    pub(super) frame: HalfFrame,
    pub(super) camera: Pinhole,
    pub(super) rows: Option<RowShift>,
}

/// An instrument with both halves of its picture.
#[derive(Debug, Clone)]
pub(super) struct Bench<'a> {
    pub(super) system: &'a System,
    pub(super) halves: [HalfBench; 2],
}

/// Why a prism cannot be looked at: a ray of the picture ends so.
pub(super) fn ended(fate: Fate) -> Error {
    Error::new(
        "the prism",
        format!("a ray of the picture does not pass it ({})", fate.name()),
        "give surfaces that reach as far as the rays of both halves, and a glass that is thick enough",
    )
}

impl<'a> Bench<'a> {
    /// # Errors
    /// When a half has no virtual camera.
    pub(super) fn new(system: &'a System) -> Result<Self, Error> {
        let half = |half: Half| {
            let frame = HalfFrame::new(system, half);
            let camera = virtual_camera(system, &frame).map_err(|why| {
                Error::new(
                    "the prism",
                    format!("a half has no virtual camera: {}", why.reason()),
                    "give a pinhole camera",
                )
            })?;
            Ok(HalfBench { rows: row_shift(system, &frame), frame, camera })
        };
        Ok(Self { system, halves: [half(Half::Left)?, half(Half::Right)?] })
    }

    /// The glass.
    pub(super) fn prism(&self) -> Result<&Prism, Error> {
        prism(self.system)
    }

    /// Places of an `n` x `n` grid over a half, its borders included, in the half's own px.
    pub(super) fn places(&self, n: usize) -> Vec<DVec2> {
        places(self.system, n)
    }

    /// The ray of the camera at a place of a half.
    pub(super) fn ray(&self, frame: &HalfFrame, place_px: DVec2) -> Ray {
        ray(self.system, frame.side(), place_px)
    }

    /// A ray behind the prism, by its own side however it meets the ridge.
    pub(super) fn passed<C: Payload>(&self, ray: &Ray, side: Side, carry: &mut C) -> Result<Ray, Error> {
        passed(self.system, ray, side, carry)
    }
}

fn prism(system: &System) -> Result<&Prism, Error> {
    system.prism().ok_or_else(|| Error::new("the scene", "it has no prism", "give it one"))
}

/// [`Bench::places`] of any instrument.
pub(super) fn places(system: &System, n: usize) -> Vec<DVec2> {
    let [width, height] = system.camera().size_px().map(|n| n as f64);
    let share = |k: usize| k as f64 / (n - 1) as f64;
    (0..n * n).map(|k| DVec2::new(0.5 * width * share(k % n), height * share(k / n))).collect()
}

/// [`Bench::ray`] of any instrument.
pub(super) fn ray(system: &System, side: Side, place_px: DVec2) -> Ray {
    // The middle of an odd width is at half a pixel.
    let [width, _] = system.camera().size_px();
    let left_px = if side == Side::Left { 0.0 } else { 0.5 * width as f64 };
    system.camera().plain_ray(place_px + DVec2::new(left_px, 0.0))
}

/// [`Bench::passed`] of any instrument.
pub(super) fn passed<C: Payload>(system: &System, ray: &Ray, side: Side, carry: &mut C) -> Result<Ray, Error> {
    let residual_mm = system.accuracy().surface_residual_mm;
    prism(system)?.pass_through(ray, side, residual_mm, carry).map_err(ended)
}

/// Where a ray behind the prism is seen by a virtual camera, as tangents to its axis, at the distance 1/`inverse_mm`; 0 is
/// infinity.
pub(super) fn tangents(camera: &Pinhole, ray: &Ray, inverse_mm: f64) -> DVec2 {
    let own = ray.moved(&camera.camera_from_world);
    let slope = own.direction.truncate() / own.direction.z;
    (own.origin.truncate() - slope * own.origin.z) * inverse_mm + slope
}

/// Where a ray met the front and the back of the prism, in its frame.
#[derive(Debug, Clone, Default)]
pub(super) struct Meetings(pub(super) Vec<Meeting>);

/// A place of a surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Meeting {
    pub(super) at_mm: DVec3,
    /// The angle of the normal to the z axis, in rad.
    pub(super) slope_rad: f64,
    /// The principal curvatures, the larger first, in 1/mm; above 0 where the surface bends towards +z.
    pub(super) curvatures_per_mm: [f64; 2],
}

impl Payload for Meetings {
    fn refracted(&mut self, event: &RefractionEvent<'_, impl SurfaceModifier>) {
        let (hit, at_mm) = (event.hit, event.ray.at(event.hit.t_mm));
        let normal = hit.normal;
        // The shape operator in two directions along the surface: where it bends towards +z, a normal that points there turns back.
        let a = normal.any_orthonormal_vector();
        let b = normal.cross(a);
        let [da, db] = [a, b].map(|step| event.surface.normal_change(hit, at_mm, normal, step));
        let shape = DMat2::from_cols(DVec2::new(da.dot(a), da.dot(b)), DVec2::new(db.dot(a), db.dot(b)));
        let mean = -0.5 * (shape.x_axis.x + shape.y_axis.y) * normal.z.signum();
        let apart = (mean * mean - shape.determinant()).max(0.0).sqrt();
        self.0.push(Meeting {
            at_mm,
            slope_rad: libm::acos(normal.z.abs().min(1.0)),
            curvatures_per_mm: [mean + apart, mean - apart],
        });
    }

    fn moved(&mut self, _: &crate::geom::Pose) {}
}
