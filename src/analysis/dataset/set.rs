//! A set, and its pictures one by one.

use super::draw::{self, LookDraw};
use super::plan::{BoardLook, DatasetPlan, DrawRange};
use crate::analysis::half_image::HalfFrame;
use crate::analysis::truth::{self, TrueCorners};
use crate::effect::Sensor;
use crate::error::Error;
use crate::scene::{BoardSpec, Scene, TextureSpec};
use crate::system::aim::Aimer;
use crate::system::{System, build_before, ideal};
use crate::vision::half::Half;
use serde_json::{Map, Value, json};

/// A set of pictures of the instrument of a scene.
#[derive(Debug)]
pub struct Dataset {
    plan: DatasetPlan,
    /// The scene's own instrument.
    system: System,
    /// What the board may show.
    looks: Vec<LookedAt>,
}

/// A scene whose board shows one look.
#[derive(Debug)]
struct LookedAt {
    /// The look, where it is not the scene's own.
    look: Option<BoardLook>,
    scene: Scene,
    /// Its instrument without effects.
    ideal: System,
}

/// A picture of a set that is to be taken.
#[derive(Debug)]
pub struct DatasetPose {
    /// Its number, from 0 on.
    pub number: u32,
    /// What its scene has other than the scene of the set, by key; null of a key that it lacks.
    pub values: Map<String, Value>,
    /// Angle between the board's normal and +z, and turn about the normal before that, in deg, where they were drawn.
    pub tilt_and_roll_deg: Option<[f64; 2]>,
    /// What the board shows, where it is not the scene's own.
    pub look: Option<BoardLook>,
    /// Factor on the light of the board.
    pub exposure: f64,
    /// Standard deviation of the noise of a read-out, of full scale 1, where it was drawn.
    pub noise: Option<f64>,
    /// Its scene.
    pub scene: Scene,
    /// Its instrument.
    pub system: System,
    /// The inner corners of the board in the left and the right half, by their places on it.
    pub corners: [TrueCorners; 2],
}

impl Dataset {
    /// The set of `plan`, of `scene` as it was read. The prism is designed here.
    ///
    /// # Errors
    /// When there is no such instrument, or one of the looks cannot be.
    pub fn new(scene: &Scene, plan: DatasetPlan) -> Result<Self, Error> {
        let ideal = ideal(scene)?;
        let system = build_before(&ideal, scene)?;
        let asked: Vec<Option<BoardLook>> = match &plan.looks[..] {
            [] => vec![None],
            looks => looks.iter().copied().map(Some).collect(),
        };
        let looked = |look: Option<BoardLook>| {
            let texture = look.map_or_else(|| scene.texture.clone(), |look| texture(look, scene, plan.seed));
            let scene = Scene { texture, ..scene.clone() };
            scene.check()?;
            Ok(LookedAt { look, ideal: ideal.with_texture(&scene), scene })
        };
        let looks = asked.into_iter().map(looked).collect::<Result<_, Error>>()?;
        Ok(Self { plan, system, looks })
    }

    /// The scene's own instrument.
    pub fn system(&self) -> &System {
        &self.system
    }

    /// What is drawn.
    pub fn plan(&self) -> &DatasetPlan {
        &self.plan
    }

    /// The picture of this number; the same whatever others are made.
    ///
    /// # Errors
    /// When no place is found for the board, the scene of the picture cannot be, or its board has too many corners.
    pub fn pose(&self, number: u32) -> Result<DatasetPose, Error> {
        let named = |problem: Error| Error { place: format!("pose {number}: {}", problem.place), ..problem };
        let draws = LookDraw::new(self.plan.seed, number);
        let kinds = self.looks.len();
        let looked = &self.looks[((draws.look * kinds as f64) as usize).min(kinds - 1)];
        let mut scene = looked.scene.clone();
        let mut values = Map::new();

        // Place the board.
        let drawn = draw::place(&self.plan, &self.system, &scene.board, number)?;
        values.insert("board.position_mm".to_owned(), json!(drawn.place.position_mm.to_array()));
        values.insert("board.tilt_deg".to_owned(), json!(drawn.place.tilt_deg.to_array()));
        scene.board.world_from_board = drawn.place.pose();

        // Give it its look, its light, and noise of its own.
        if looked.look.is_some() {
            values.insert("board.texture".to_owned(), scene.texture.as_ref().map_or(Value::Null, texture_value));
        }
        let drawn_from = |range: Option<DrawRange>, share: f64| range.map(|range| range.at(share));
        let exposure = drawn_from(self.plan.exposure, draws.exposure);
        if let Some(exposure) = exposure {
            expose(&mut scene.board, exposure, &mut values);
        }
        let noise = drawn_from(self.plan.noise, draws.noise);
        put_noise(&mut scene, noise, draws.frame, &mut values);

        // Build its instrument, and find the corners.
        scene.check().map_err(named)?;
        let system = build_before(&looked.ideal, &scene).map_err(named)?;
        let corners = corners(&system).map_err(named)?;
        let (tilt_and_roll_deg, exposure) = (drawn.tilt_and_roll_deg, exposure.unwrap_or(1.0));
        let look = looked.look;
        Ok(DatasetPose { number, values, tilt_and_roll_deg, look, exposure, noise, scene, system, corners })
    }
}

/// The texture of the board of `scene` that has this look.
fn texture(look: BoardLook, scene: &Scene, seed: u64) -> Option<TextureSpec> {
    match (look, &scene.texture) {
        (BoardLook::Squares, _) => None,
        (BoardLook::Chart, _) => Some(TextureSpec::Chart),
        (BoardLook::Noise, Some(own @ TextureSpec::Noise { .. })) => Some(own.clone()),
        (BoardLook::Noise, _) => {
            let finest_mm = TextureSpec::usual_finest_mm(scene.board.square_mm);
            Some(TextureSpec::Noise { seed: seed as u32, finest_mm })
        }
    }
}

/// A built-in texture as a scene file has it; null of a picture, whose file the scene names.
fn texture_value(texture: &TextureSpec) -> Value {
    match texture {
        TextureSpec::Chart => json!("chart"),
        TextureSpec::Noise { seed, finest_mm } => json!({ "pattern": "noise", "seed": seed, "finest_mm": finest_mm }),
        TextureSpec::Image(_) => Value::Null,
    }
}

/// Puts the board and its background in `exposure` times their light.
fn expose(board: &mut BoardSpec, exposure: f64, values: &mut Map<String, Value>) {
    for (key, radiance) in
        [("black", &mut board.black), ("white", &mut board.white), ("background", &mut board.background)]
    {
        *radiance *= exposure;
        values.insert(format!("board.{key}"), json!(*radiance));
    }
}

/// Gives the sensor the `noise` that was drawn, where it was, and where it is random the number of an exposure of its own.
fn put_noise(scene: &mut Scene, noise: Option<f64>, frame: u32, values: &mut Map<String, Value>) {
    if let Some(noise) = noise {
        let own = scene.effects.sensor.unwrap_or(Sensor::IDEAL);
        let sensor = Sensor { read_noise_e: noise * own.white_e, ..own };
        values.insert("effect.sensor.white_e".to_owned(), json!(sensor.white_e));
        values.insert("effect.sensor.shot_noise".to_owned(), json!(sensor.shot_noise));
        values.insert("effect.sensor.read_noise_e".to_owned(), json!(sensor.read_noise_e));
        scene.effects.sensor = Some(sensor);
    }
    if let Some(sensor) = scene.effects.sensor.as_mut().filter(|sensor| sensor.is_random()) {
        sensor.frame = frame;
        values.insert("effect.sensor.frame".to_owned(), json!(frame));
    }
}

/// The corners in the left and the right half.
fn corners(system: &System) -> Result<[TrueCorners; 2], Error> {
    let aimer = Aimer::new(system);
    let of = |half| {
        truth::corners(system, &aimer, &HalfFrame::new(system, half)).ok_or_else(|| {
            let rule = "a half sees more corners of the board than are told apart";
            Error::new("board.square_mm", rule, "give larger squares, or smaller distances")
        })
    };
    Ok([of(Half::Left)?, of(Half::Right)?])
}
