//! The traced instrument: the path of a ray from a pixel through the prism to the board, with its differentials.

use super::board::Board;
use super::camera::Camera;
use super::clip::Opening;
use super::plate::plate;
use crate::accuracy::Accuracy;
use crate::effect::Effects;
use crate::geom::Ray;
use crate::optics::fate::Fate;
use crate::prism::biprism::Prism;
use crate::prism::payload::{Differentials, Path, Payload};
use crate::prism::side::Side;
use crate::scene;
use crate::texture::Plate;
use glam::{DMat2, DVec2};
use std::sync::{Arc, OnceLock};

/// The instrument of one scene. Camera, prism and stop are always those that its effects make of the ideal camera and of the
/// prism as it is meant to be.
#[derive(Debug, Clone, PartialEq)]
pub struct System {
    /// The camera as the scene states it.
    pub(super) camera_spec: scene::CameraSpec,
    /// The camera.
    pub(super) camera: Camera,
    /// The glass as it is made and mounted, if there is any.
    pub(super) prism: Option<Prism>,
    /// The glass as it is meant to be.
    pub(super) designed: Option<Arc<Prism>>,
    /// The board.
    pub(super) board: Board,
    /// What it shows in place of its squares, where it has a texture.
    pub(super) plate: Option<Arc<Plate>>,
    /// Objects besides the board.
    pub(super) objects: Arc<[SeenObject]>,
    /// The instruments before each of them.
    pub(super) layers: Layers,
    /// An opening before the camera, through which all rays must go.
    pub(super) stop: Option<Opening>,
    /// What is asked of each ray.
    pub(super) accuracy: Accuracy,
    /// What the picture shows besides geometry.
    pub(super) effects: Effects,
}

/// An object besides the board.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SeenObject {
    board: Board,
    plate: Option<Arc<Plate>>,
}

/// The instruments before each object, which are made when they are first asked for. What is made of an instrument has its own.
#[derive(Debug, Default)]
pub(super) struct Layers(OnceLock<Vec<System>>);

impl Clone for Layers {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl PartialEq for Layers {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// What a pixel position sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoardHit {
    /// Position on the board, in mm, in the board's frame.
    pub board_mm: DVec2,
    /// The side of the prism it was seen through.
    pub side: Side,
}

/// A board hit and how it moves with the pixel position (ray differentials).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Footprint {
    /// What the position itself sees.
    pub sight: BoardHit,
    /// d board_mm / d px: the columns are the steps for one pixel to the right and one down, in mm/px.
    pub jacobian: DMat2,
}

impl System {
    /// The ideal instrument: without effects, and with the glass as it is meant to be.
    pub(super) fn ideal(scene: &scene::Scene, designed: Option<Prism>) -> Self {
        Self {
            camera_spec: scene.camera,
            camera: Camera::new(&scene.camera, None),
            designed: designed.clone().map(Arc::new),
            prism: designed,
            board: Board::new(&scene.board),
            plate: scene.texture.as_ref().map(|texture| plate(texture, &scene.board)),
            objects: (scene.objects.iter())
                .map(|object| SeenObject {
                    board: Board::new(&object.plate),
                    plate: object.texture.as_ref().map(|texture| plate(texture, &object.plate)),
                })
                .collect(),
            layers: Layers::default(),
            stop: None,
            accuracy: scene.accuracy,
            effects: Effects::default(),
        }
    }

    /// The camera as the scene states it.
    pub fn camera_spec(&self) -> &scene::CameraSpec {
        &self.camera_spec
    }

    /// The camera.
    #[inline(always)]
    pub fn camera(&self) -> &Camera {
        &self.camera
    }

    /// The glass as it is made and mounted, if there is any.
    #[inline(always)]
    pub fn prism(&self) -> Option<&Prism> {
        self.prism.as_ref()
    }

    /// The glass as it is meant to be, if there is any.
    pub fn designed(&self) -> Option<&Prism> {
        self.designed.as_deref()
    }

    /// The board.
    #[inline(always)]
    pub fn board(&self) -> &Board {
        &self.board
    }

    /// What the board shows in place of its squares, where it has a texture.
    #[inline(always)]
    pub fn plate(&self) -> Option<&Plate> {
        self.plate.as_deref()
    }

    /// The same instrument before each of the objects besides the board, in their place.
    pub fn layers(&self) -> &[Self] {
        self.layers.0.get_or_init(|| {
            let before = |object: &SeenObject| {
                let (board, plate) = (object.board, object.plate.clone());
                Self { board, plate, objects: Arc::from([]), ..self.clone() }
            };
            self.objects.iter().map(before).collect()
        })
    }

    /// Half the width and height of the board, with its margin, in mm.
    pub fn half_plate_mm(&self) -> DVec2 {
        let pattern = &self.board.pattern;
        self.plate().map_or(0.5 * pattern.squares_mm() + pattern.margin_mm, Plate::half_mm)
    }

    /// What a ray behind the prism sees: the number of the object from 1 on, or 0 for the plane of the board, which lies behind all
    /// objects where it is beside the board; and the place on it, in mm in its frame, with the distance to it along the ray.
    ///
    /// # Errors
    /// [`Fate::PastBoard`] of a ray that meets no object and never meets the board's plane.
    pub fn nearest(&self, ray: &Ray) -> Result<(usize, DVec2, f64), Fate> {
        let own = self.board.intersect(ray);
        let on_plate = |system: &Self, mm: DVec2| mm.abs().cmple(system.half_plate_mm()).all();
        let mut nearest = own.ok().filter(|(mm, _)| on_plate(self, *mm)).map(|(mm, t_mm)| (0, mm, t_mm));
        for (k, layer) in self.layers().iter().enumerate() {
            let Ok((mm, t_mm)) = layer.board.intersect(ray) else { continue };
            if on_plate(layer, mm) && nearest.is_none_or(|(_, _, before)| t_mm < before) {
                nearest = Some((k + 1, mm, t_mm));
            }
        }
        nearest.map_or_else(|| own.map(|(mm, t_mm)| (0, mm, t_mm)), Ok)
    }

    /// The shortest distance of lines on the board, in mm: the side of a square, or what is finest in its texture.
    pub fn feature_mm(&self) -> f64 {
        let own = self.plate().map_or(self.board.pattern.square_mm, Plate::feature_mm);
        self.layers().iter().map(Self::feature_mm).fold(own, f64::min)
    }

    /// An opening before the camera, through which all rays must go.
    pub fn stop(&self) -> Option<&Opening> {
        self.stop.as_ref()
    }

    /// What is asked of each ray.
    #[inline(always)]
    pub fn accuracy(&self) -> &Accuracy {
        &self.accuracy
    }

    /// What the picture shows besides geometry. Effects of the instrument are built into camera, prism and stop; of the
    /// others rays do not know: what is traced, seen and aimed at here goes through the middle of the pupil, in light of the
    /// scene's own index.
    #[inline(always)]
    pub fn effects(&self) -> &Effects {
        &self.effects
    }

    /// This instrument with `effects` in place of its own: the prism as they make it of the one that is meant, with camera
    /// and stop to them.
    #[must_use]
    pub fn with_effects(&self, effects: &Effects) -> Self {
        let stop = effects.clipping.and_then(|clipping| clipping.stop);
        Self {
            camera: Camera::new(&self.camera_spec, effects.lens.telecentric()),
            prism: self.designed.as_ref().map(|prism| prism.with_effects(effects)),
            stop: stop.map(|stop| Opening::new(&stop, &self.camera_spec)),
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

    /// This instrument without effects: central, with the glass as it is meant to be, and no stop.
    #[must_use]
    pub fn without_effects(&self) -> Self {
        self.with_effects(&Effects::default())
    }

    /// This instrument with another camera before the same glass.
    #[must_use]
    pub fn with_camera(&self, camera: &scene::CameraSpec) -> Self {
        Self { camera_spec: *camera, ..self.clone() }.with_effects(&self.effects)
    }

    /// This instrument before another board.
    #[must_use]
    pub fn with_board(&self, board: &scene::BoardSpec) -> Self {
        Self { board: Board::new(board), ..self.clone() }
    }

    /// This instrument before another board, whose texture, where it has one, is the same.
    #[must_use]
    pub(super) fn before(&self, board: &scene::BoardSpec) -> Self {
        let plate =
            self.plate().map(|plate| Arc::new(plate.with_radiance([board.black, board.white, board.background])));
        Self { plate, ..self.with_board(board) }
    }

    /// This ideal instrument before the board of `scene`, which differs from its own in that alone.
    #[must_use]
    pub fn with_texture(&self, scene: &scene::Scene) -> Self {
        let plate = scene.texture.as_ref().map(|texture| plate(texture, &scene.board));
        Self { board: Board::new(&scene.board), plate, ..self.clone() }
    }

    /// This instrument with something else asked of each ray.
    #[must_use]
    pub fn with_accuracy(&self, accuracy: Accuracy) -> Self {
        Self { accuracy, ..self.clone() }
    }

    /// This instrument in a later frame: with other noise on the same specimen; itself for 0.
    #[must_use]
    pub fn in_frame(&self, later: u32) -> Self {
        Self { effects: self.effects.in_frame(later), ..self.clone() }
    }

    /// This instrument with a lens that does not diffract.
    #[must_use]
    pub fn without_diffraction(&self) -> Self {
        Self { effects: Effects { diffraction: None, ..self.effects.clone() }, ..self.clone() }
    }

    /// This instrument with a sensor that is neither uneven nor noisy.
    #[must_use]
    pub fn without_noise(&self) -> Self {
        Self { effects: self.effects.without_noise(), ..self.clone() }
    }

    /// Whether the picture is its own mirror image, bit for bit: camera, prism and board have the plane x = 0 as their
    /// plane of symmetry, and no pixel lies across it.
    pub fn is_mirror_symmetric(&self) -> bool {
        self.camera.keeps_mirror_images() && self.has_symmetric_scenery()
    }

    /// Whether the light on its pixels is its own mirror image, all effects included and a pixel on the plane x = 0 too, to
    /// the accuracy of its level and of the points that it is sampled by.
    pub fn receives_mirror_images(&self) -> bool {
        self.camera.is_mirror_symmetric() && self.has_symmetric_scenery() && self.effects.keep_mirror_images()
    }

    /// Whether prism and board have the plane x = 0 as their plane of symmetry.
    fn has_symmetric_scenery(&self) -> bool {
        let board = &self.board.pattern;
        self.plate.is_none()
            && self.objects.is_empty()
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
    pub(crate) fn land(&self, ray: &Ray, side: Side, differentials: &Differentials) -> Result<Footprint, Fate> {
        let (board_mm, t_mm) = self.board.intersect(ray)?;
        let steps = differentials.transferred(ray, t_mm, self.board.normal());
        let jacobian = DMat2::from_cols(self.board.vector(steps[0]), self.board.vector(steps[1]));
        Ok(Footprint { sight: BoardHit { board_mm, side }, jacobian })
    }
}
