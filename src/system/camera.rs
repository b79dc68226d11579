//! The camera: image positions to rays.

use crate::effect::{Telecentric, ThinLens};
use crate::geom::{CalibratedPinhole, Ray};
use crate::num::simd::{LANES, Lanes};
use crate::prism::lanes::{Rays, Vectors};
use crate::prism::payload::Differentials;
use crate::scene;
use glam::{DVec2, DVec3};

/// How far left of the picture's middle a ray of a calibrated camera may be by rounding and still belong to the right half, in px.
const ON_THE_MIDDLE_PX: f64 = 1e-9;

/// A camera that looks along +z, its image un-inverted: a pinhole, or a telecentric lens; or a pinhole as a calibration has it,
/// which may be turned and distort the picture.
///
/// Every image position has a ray, inside the sensor or not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    position_mm: DVec3,
    projection: Projection,
    /// The principal point: the image position whose ray runs along the axis; the centre of the sensor for a plain pinhole.
    centre_px: DVec2,
    /// Tangent of the image-side angle less that of the object-side one: how a lens turns rays through this point of it.
    turn: DVec2,
    size_px: [usize; 2],
}

/// How rays belong to image positions.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Projection {
    /// All start at one point.
    Pinhole {
        /// Tangent of the field angle per pixel: pitch / focal length.
        tangent_per_px: f64,
    },
    /// All run in one direction.
    Telecentric {
        /// Steps of their origins per pixel: pitch / magnification.
        mm_per_px: f64,
        /// The unit direction.
        direction: DVec3,
    },
    /// All start at one point, and a calibration tells where they run.
    Calibrated {
        pinhole: CalibratedPinhole,
        /// Tangent of the field angle per pixel of the plain pinhole.
        tangent_per_px: f64,
        /// How far right of the principal point the middle of the picture is, as a distorted tangent.
        middle: f64,
    },
}

impl Camera {
    /// The camera of a scene, with a telecentric lens where one is given.
    pub fn new(camera: &scene::CameraSpec, telecentric: Option<&Telecentric>) -> Self {
        let tangent_per_px = camera.pitch_mm / camera.focal_length_mm;
        let projection = match (telecentric, camera.calibrated()) {
            (None, None) => Projection::Pinhole { tangent_per_px },
            (None, Some(pinhole)) => {
                let middle = (camera.middle_px() - camera.principal_px()).x * pinhole.tangent_per_px.x;
                Projection::Calibrated { pinhole, tangent_per_px, middle }
            }
            (Some(lens), _) => {
                Projection::Telecentric { mm_per_px: camera.pitch_mm / lens.magnification, direction: DVec3::Z }
            }
        };
        Self {
            position_mm: camera.position_mm,
            projection,
            centre_px: camera.principal_px(),
            turn: DVec2::ZERO,
            size_px: [camera.width_px, camera.height_px],
        }
    }

    /// What one point of the aperture of `lens`, in mm from the place of the pinhole, sees: a pinhole there, its principal
    /// point shifted so that every image position sees the same point of the plane in focus as before.
    #[must_use]
    pub fn through(&self, lens: &ThinLens, point_mm: DVec2) -> Self {
        if let Projection::Calibrated { pinhole, tangent_per_px, middle } = self.projection {
            // The principal point stays, for the picture is distorted about it.
            let lean = point_mm / lens.focus_mm;
            let pinhole = CalibratedPinhole { lean: pinhole.lean + lean, ..pinhole };
            return Self {
                position_mm: self.position_mm + pinhole.rotation * point_mm.extend(0.0),
                projection: Projection::Calibrated { pinhole, tangent_per_px, middle },
                turn: self.turn + (point_mm / lens.focal_mm - lean),
                ..*self
            };
        }
        Self {
            position_mm: self.position_mm + point_mm.extend(0.0),
            centre_px: self.centre_px + point_mm / (lens.focus_mm * self.per_px()),
            turn: self.turn + point_mm / lens.focal_mm,
            ..*self
        }
    }

    /// What `lens`, whose camera this is, sees in one direction of its cones, given by its sines: every image position the
    /// same point of the plane in focus as before.
    #[must_use]
    pub fn along(&self, lens: &Telecentric, sines: DVec2) -> Self {
        let mm_per_px = self.per_px();
        let direction = sines.extend((1.0 - sines.length_squared()).sqrt());
        Self {
            projection: Projection::Telecentric { mm_per_px, direction },
            centre_px: self.centre_px + Telecentric::tangents(sines) * (lens.focus_mm / mm_per_px),
            ..*self
        }
    }

    /// Tangent of the field angle per pixel of a plain pinhole, mm per pixel of a telecentric lens.
    fn per_px(&self) -> f64 {
        match self.projection {
            Projection::Pinhole { tangent_per_px: step }
            | Projection::Telecentric { mm_per_px: step, .. }
            | Projection::Calibrated { tangent_per_px: step, .. } => step,
        }
    }

    /// The same camera with `n` x `n` pixels in place of each.
    #[must_use]
    pub fn sampled(&self, n: usize) -> Self {
        let [width, height] = self.size_px;
        let n_px = n as f64;
        let projection = match self.projection {
            Projection::Pinhole { tangent_per_px } => Projection::Pinhole { tangent_per_px: tangent_per_px / n_px },
            Projection::Telecentric { mm_per_px, direction } => {
                Projection::Telecentric { mm_per_px: mm_per_px / n_px, direction }
            }
            Projection::Calibrated { pinhole, tangent_per_px, middle } => {
                Projection::Calibrated { pinhole: pinhole.sampled(n_px), tangent_per_px: tangent_per_px / n_px, middle }
            }
        };
        Self { projection, centre_px: self.centre_px * n_px, size_px: [width * n, height * n], ..*self }
    }

    /// The same camera with a sensor of `size_px` of its own pixels, from pixel `first` on.
    #[must_use]
    pub fn window(&self, first: [usize; 2], size_px: [usize; 2]) -> Self {
        Self { centre_px: self.centre_px - DVec2::from_array(first.map(|n| n as f64)), size_px, ..*self }
    }

    /// The same camera with a sensor that has `frame` more pixels on every side.
    #[must_use]
    pub fn framed(&self, frame: usize) -> Self {
        Self { centre_px: self.centre_px + frame as f64, size_px: self.size_px.map(|n| n + 2 * frame), ..*self }
    }

    /// Whether mirror images in the plane x = 0 have mirrored rays, bit for bit, and no pixel lies across it.
    pub fn keeps_mirror_images(&self) -> bool {
        self.is_mirror_symmetric() && self.size_px[0].is_multiple_of(2)
    }

    /// Whether mirror images in the plane x = 0 have mirrored rays.
    pub fn is_mirror_symmetric(&self) -> bool {
        let width = self.size_px[0];
        let upright = match self.projection {
            Projection::Pinhole { .. } => true,
            Projection::Telecentric { direction, .. } => direction.x == 0.0,
            // What rounding leaves of a symmetry is not known.
            Projection::Calibrated { .. } => false,
        };
        upright && self.position_mm.x == 0.0 && self.centre_px.x == 0.5 * width as f64
    }

    /// Columns and rows of the sensor.
    pub fn size_px(&self) -> [usize; 2] {
        self.size_px
    }

    /// The pinhole, or the middle of the plane from which distances to a telecentric lens are counted, in the world.
    pub fn position_mm(&self) -> DVec3 {
        self.position_mm
    }

    /// Whether its axis runs along z through the middle of the sensor, and nothing distorts its picture.
    pub fn is_plain(&self) -> bool {
        !matches!(self.projection, Projection::Calibrated { .. })
    }

    /// Whether straight lines are seen as straight lines.
    pub fn keeps_lines(&self) -> bool {
        match self.projection {
            Projection::Pinhole { .. } | Projection::Telecentric { .. } => true,
            Projection::Calibrated { pinhole, .. } => pinhole.keeps_lines(),
        }
    }

    /// Where the plain pinhole of the same place and focal length, whose axis runs along z through the middle of the picture,
    /// would see what this camera sees at `px`: `px` itself for a plain pinhole and a telecentric lens. Infinite for a ray that
    /// runs across z.
    pub fn rectified(&self, px: DVec2) -> DVec2 {
        match self.projection {
            Projection::Pinhole { .. } | Projection::Telecentric { .. } => px,
            Projection::Calibrated { pinhole, tangent_per_px, .. } => {
                let direction = pinhole.direction(px - self.centre_px);
                self.middle_px() + direction.truncate() / direction.z / tangent_per_px
            }
        }
    }

    /// The inverse of [`Camera::rectified`]: where this camera sees what the plain pinhole sees at `px`; `None` behind it.
    pub fn unrectified(&self, px: DVec2) -> Option<DVec2> {
        match self.projection {
            Projection::Pinhole { .. } | Projection::Telecentric { .. } => Some(px),
            Projection::Calibrated { pinhole, tangent_per_px, .. } => {
                let direction = ((px - self.middle_px()) * tangent_per_px).extend(1.0);
                pinhole.project(direction).map(|place_px| self.centre_px + place_px)
            }
        }
    }

    /// The ray of the plain pinhole of the same place and focal length, or this camera's own where it is telecentric.
    pub fn plain_ray(&self, px: DVec2) -> Ray {
        match self.projection {
            Projection::Pinhole { .. } | Projection::Telecentric { .. } => self.ray(px),
            Projection::Calibrated { tangent_per_px, .. } => Ray {
                origin: self.position_mm,
                direction: ((px - self.middle_px()) * tangent_per_px).extend(1.0).normalize(),
            },
        }
    }

    fn middle_px(&self) -> DVec2 {
        DVec2::from_array(self.size_px.map(|n| n as f64)) * 0.5
    }

    /// Tangent of the field angle per pixel, pitch over focal length, of the plain pinhole; `None` for a telecentric lens.
    pub fn tangent_per_px(&self) -> Option<f64> {
        match self.projection {
            Projection::Pinhole { tangent_per_px } | Projection::Calibrated { tangent_per_px, .. } => {
                Some(tangent_per_px)
            }
            Projection::Telecentric { .. } => None,
        }
    }

    /// Whether a ray of this camera belongs to the right half of the picture, its middle included.
    #[inline(always)]
    pub fn is_right(&self, ray: &Ray) -> bool {
        match self.projection {
            Projection::Pinhole { .. } => ray.direction.x >= 0.0,
            Projection::Telecentric { .. } => ray.origin.x >= self.position_mm.x,
            Projection::Calibrated { pinhole, middle, .. } => {
                let seen = pinhole.project(ray.direction).map(|place_px| place_px.x * pinhole.tangent_per_px.x);
                seen.is_some_and(|seen| seen >= middle - ON_THE_MIDDLE_PX * pinhole.tangent_per_px.x)
            }
        }
    }

    /// Cosine of the angle to the axis at which light reaches an image position, as far as it weakens the light: the
    /// directions of a telecentric lens are chosen in proportion to what they give. A lens that distorts does so before its
    /// pupil: on the sensor's side light runs straight from there to the image position.
    pub fn image_cos(&self, px: DVec2) -> f64 {
        match self.projection {
            Projection::Pinhole { tangent_per_px } => {
                let t = (px - self.centre_px) * tangent_per_px + self.turn;
                1.0 / (1.0 + t.length_squared()).sqrt()
            }
            Projection::Calibrated { pinhole, .. } => {
                let t = (px - self.centre_px) * pinhole.tangent_per_px + self.turn;
                1.0 / (1.0 + t.length_squared()).sqrt()
            }
            Projection::Telecentric { .. } => 1.0,
        }
    }

    /// The ray of an image position.
    #[inline(always)]
    pub fn ray(&self, px: DVec2) -> Ray {
        let t = (px - self.centre_px) * self.per_px();
        match self.projection {
            Projection::Pinhole { .. } => {
                Ray { origin: self.position_mm, direction: DVec3::new(t.x, t.y, 1.0).normalize() }
            }
            Projection::Telecentric { direction, .. } => Ray { origin: self.position_mm + t.extend(0.0), direction },
            Projection::Calibrated { .. } => self.calibrated_ray(px),
        }
    }

    // Apart, so that the loops of plain cameras stay as they are.
    #[inline(never)]
    fn calibrated_ray(&self, px: DVec2) -> Ray {
        let Projection::Calibrated { pinhole, .. } = &self.projection else { return self.ray(px) };
        Ray { origin: self.position_mm, direction: pinhole.direction(px - self.centre_px) }
    }

    /// The rays of a packet of image positions, with the bits of [`Camera::ray`].
    #[inline(always)]
    pub fn rays(&self, px: [Lanes; 2]) -> Rays {
        let scale = Lanes::splat(self.per_px());
        let x = (px[0] - Lanes::splat(self.centre_px.x)) * scale;
        let y = (px[1] - Lanes::splat(self.centre_px.y)) * scale;
        let position = Vectors::splat(self.position_mm);
        match self.projection {
            Projection::Pinhole { .. } => {
                Rays { origin: position, direction: Vectors { x, y, z: Lanes::splat(1.0) }.normalize() }
            }
            Projection::Telecentric { direction, .. } => {
                let origin = Vectors { x: position.x + x, y: position.y + y, z: position.z };
                Rays { origin, direction: Vectors::splat(direction) }
            }
            Projection::Calibrated { .. } => {
                let directions: [DVec3; LANES] =
                    std::array::from_fn(|k| self.calibrated_ray(DVec2::new(px[0].0[k], px[1].0[k])).direction);
                let lane = |pick: fn(&DVec3) -> f64| Lanes::of(|k| pick(&directions[k]));
                Rays { origin: position, direction: Vectors { x: lane(|d| d.x), y: lane(|d| d.y), z: lane(|d| d.z) } }
            }
        }
    }

    /// How the ray of `px` changes with the position.
    #[inline(always)]
    pub fn differentials(&self, px: DVec2) -> Differentials {
        if let Projection::Calibrated { pinhole, .. } = &self.projection {
            return Differentials { origin: [DVec3::ZERO; 2], direction: pinhole.differentials(px - self.centre_px) };
        }
        let s = self.per_px();
        let (right, down) = (DVec3::new(s, 0.0, 0.0), DVec3::new(0.0, s, 0.0));
        if let Projection::Telecentric { .. } = self.projection {
            return Differentials { origin: [right, down], direction: [DVec3::ZERO; 2] };
        }
        let t = (px - self.centre_px) * s;
        let a = DVec3::new(t.x, t.y, 1.0);
        let length = a.length();
        let d = a / length;
        let turn = |step: DVec3| (step - d * d.dot(step)) / length;
        Differentials { origin: [DVec3::ZERO; 2], direction: [turn(right), turn(down)] }
    }
}

#[cfg(test)]
#[path = "camera_tests.rs"]
mod tests;
