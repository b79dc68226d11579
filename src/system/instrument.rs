//! The instrument: camera, prism, board and effects, and the way of a ray through them.

use super::board::Board;
use super::camera::Camera;
use super::clip::Opening;
use crate::accuracy::Accuracy;
use crate::effect::Effects;
use crate::geom::Ray;
use crate::optics::fate::Fate;
use crate::prism::biprism::{Prism, Side};
use crate::prism::payload::{Differentials, Path, Payload};
use crate::scene;
use glam::{DMat2, DVec2};
use std::sync::Arc;

/// The instrument of one scene.
#[derive(Debug, Clone, PartialEq)]
pub struct System {
    /// The camera.
    pub camera: Camera,
    /// The glass as it is made and mounted, if there is any.
    pub prism: Option<Prism>,
    /// The glass as it is meant to be.
    pub designed: Option<Arc<Prism>>,
    /// The board.
    pub board: Board,
    /// An opening before the camera, through which all rays must go.
    pub stop: Option<Opening>,
    /// What is asked of each ray.
    pub accuracy: Accuracy,
    /// What the picture shows besides geometry. Effects of the instrument are built into camera, prism and stop; of the
    /// others rays do not know: what is traced, seen and aimed at here goes through the middle of the pupil, in light of the
    /// scene's own index.
    pub effects: Effects,
}

/// What a pixel position sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoardHit {
    /// Position on the board, in mm, in the board's frame.
    pub board_mm: DVec2,
    /// The side of the prism it was seen through.
    pub side: Side,
}

/// A sight and how it moves with the pixel position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Footprint {
    /// What the position itself sees.
    pub sight: BoardHit,
    /// d board_mm / d px: the columns are the steps for one pixel to the right and one down, in mm/px.
    pub jacobian: DMat2,
}

impl System {
    /// This ideal instrument, whose camera is `camera`, with `effects`.
    #[must_use]
    pub fn with_effects(&self, effects: &Effects, camera: &scene::CameraSpec) -> Self {
        let stop = effects.clipping.and_then(|clipping| clipping.stop);
        Self {
            camera: Camera::new(camera, effects.telecentric.as_ref()),
            prism: self.prism.as_ref().map(|prism| prism.with_effects(effects)),
            stop: stop.map(|stop| Opening::new(&stop, camera)),
            effects: effects.clone(),
            ..self.clone()
        }
    }

    /// This instrument with `prism`, as it is meant to be, in place of its own.
    #[must_use]
    pub fn with_prism(&self, prism: &Prism) -> Self {
        let designed = Some(Arc::new(prism.clone()));
        Self { prism: Some(prism.with_effects(&self.effects)), designed, ..self.clone() }
    }

    /// This instrument without effects, whose camera is `camera`: central, with the glass as it is meant to be, and no stop.
    #[must_use]
    pub fn without_effects(&self, camera: &scene::CameraSpec) -> Self {
        let ideal = Self { prism: self.designed.as_deref().cloned(), ..self.clone() };
        ideal.with_effects(&Effects::default(), camera)
    }

    /// Whether the picture is its own mirror image, bit for bit: camera, prism and board have the plane x = 0 as their
    /// plane of symmetry, and no pixel lies across it.
    pub fn is_mirror_symmetric(&self) -> bool {
        let board = &self.board.pattern;
        self.camera.keeps_mirror_images()
            && self.prism.as_ref().is_none_or(Prism::keeps_mirror_images)
            && board.columns % 2 == 1
            && board.world_from_board.keeps_mirror_images()
    }

    /// What the image position `px` sees.
    #[inline]
    pub fn trace(&self, px: DVec2) -> Result<BoardHit, Fate> {
        let (ray, side) = self.exit(self.camera.ray(px), &mut ())?;
        self.board.intersect(&ray).map(|(board_mm, _)| BoardHit { board_mm, side })
    }

    /// How far right of the ridge the ray of `px` meets the front of `side`, continued beyond the ridge, along x of the
    /// prism's frame, in mm; `None` where there is no such place.
    pub fn front_x_mm(&self, px: DVec2, side: Side) -> Option<f64> {
        let prism = self.prism.as_ref()?;
        prism.met_mm(&self.camera.ray(px), side, self.accuracy.surface_residual_mm).map(|at| at.x)
    }

    /// What the image position `px` sees, and how that moves with the position.
    #[inline]
    pub fn footprint(&self, px: DVec2) -> Result<Footprint, Fate> {
        let mut differentials = self.camera.differentials(px);
        let (ray, side) = self.exit(self.camera.ray(px), &mut differentials)?;
        self.land(&ray, side, &differentials)
    }

    /// [`System::footprint`] through a given side, continued beyond the ridge as if that side went on.
    pub fn footprint_through(&self, px: DVec2, side: Side) -> Result<Footprint, Fate> {
        let mut differentials = self.camera.differentials(px);
        let ray = self.exit_through(px, side, &mut differentials)?;
        self.land(&ray, side, &differentials)
    }

    /// The ray of `px` behind the prism when it passes `side`, continued beyond the ridge as if that side went on.
    pub fn exit_ray_through(&self, px: DVec2, side: Side) -> Result<Ray, Fate> {
        self.exit_through(px, side, &mut ())
    }

    fn exit_through<C: Payload>(&self, px: DVec2, side: Side, carry: &mut C) -> Result<Ray, Fate> {
        let ray = self.camera.ray(px);
        match &self.prism {
            None => Ok(ray),
            Some(prism) => prism.pass_through(&ray, side, self.accuracy.surface_residual_mm, carry),
        }
    }

    /// The ray of `px` behind the prism, in the world, with the side that it passed.
    pub fn exit_ray(&self, px: DVec2) -> Result<(Ray, Side), Fate> {
        self.exit(self.camera.ray(px), &mut ())
    }

    /// The refraction points on the way of `px`, in the world, and the ray behind the prism.
    pub fn path(&self, px: DVec2) -> (Path, Result<(Ray, Side), Fate>) {
        let mut path = Path::default();
        let end = self.exit(self.camera.ray(px), &mut path);
        (path, end)
    }

    /// Whether a ray of the camera ends at the stop.
    #[inline(always)]
    pub(super) fn stops(&self, ray: &Ray) -> bool {
        self.stop.as_ref().is_some_and(|stop| stop.margin_mm(ray) < 0.0)
    }

    #[inline(always)]
    pub(crate) fn exit<C: Payload>(&self, ray: Ray, carry: &mut C) -> Result<(Ray, Side), Fate> {
        if self.stops(&ray) {
            return Err(Fate::Clipped);
        }
        match &self.prism {
            // Without glass there are no sides; the image's own halves stand in for them.
            None => Ok((ray, if self.camera.is_right(&ray) { Side::Right } else { Side::Left })),
            Some(prism) => prism.pass(&ray, self.accuracy.surface_residual_mm, carry),
        }
    }

    #[inline(always)]
    fn land(&self, ray: &Ray, side: Side, differentials: &Differentials) -> Result<Footprint, Fate> {
        let (board_mm, t_mm) = self.board.intersect(ray)?;
        let steps = differentials.transferred(ray, t_mm, self.board.normal());
        let jacobian = DMat2::from_cols(self.board.vector(steps[0]), self.board.vector(steps[1]));
        Ok(Footprint { sight: BoardHit { board_mm, side }, jacobian })
    }
}
