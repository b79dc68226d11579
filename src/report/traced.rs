//! What is found of a pixel position that is traced, or of a board point that is aimed at, as text, as JSON and as a record of a table.

use crate::io::npy::NpyField;
use crate::num::simd::LANES;
use crate::optics::fate::Fate;
use crate::render::{Class, WayToBoard, WayTracer};
use crate::system::aim::Aimer;
use crate::system::{BoardHit, InLight, Side};
use glam::{DVec2, DVec3};
use serde_json::json;
use std::fmt::Write as _;

/// A ray from the camera, with every point on its way, in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TracedRay {
    px: DVec2,
    /// The side that it came in through, where that is known.
    side: Option<Side>,
    /// Where it landed on the board's plane, in mm of the board and of the world.
    landed: Result<(DVec2, DVec3), Fate>,
    /// Point and direction of the front, point of the back, and the direction behind the prism, where they are.
    way: [Option<DVec3>; 4],
    /// The face that reflects it totally.
    reflected_at: Option<&'static str>,
}

/// The pixel that sees a point of the board through one side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AimedPoint {
    side: Side,
    board_mm: DVec2,
    /// Its position, and whether it is on the sensor and on the side's own part of it.
    seen_at: Result<(DVec2, bool), Fate>,
}

impl TracedRay {
    /// The first line of the text.
    pub(crate) const COLUMNS: &str = "x_px,y_px,side,fate,u_mm,v_mm,world_x_mm,world_y_mm,world_z_mm,\
front_x_mm,front_y_mm,front_z_mm,inner_dx,inner_dy,inner_dz,back_x_mm,back_y_mm,back_z_mm,exit_dx,exit_dy,exit_dz";

    /// The fields of a record: NaN where there is nothing, the side as 0 left, 1 right, 2 not known, the class as in the EXR.
    pub const FIELDS: [NpyField; 9] = [
        NpyField::F64("pixel_px", 2),
        NpyField::F64("board_mm", 2),
        NpyField::F64("world_mm", 3),
        NpyField::F64("front_mm", 3),
        NpyField::F64("inner_direction", 3),
        NpyField::F64("back_mm", 3),
        NpyField::F64("exit_direction", 3),
        NpyField::U32("side"),
        NpyField::U32("class"),
    ];

    /// Traces a pixel position.
    pub fn new(light: &InLight<'_>, px: DVec2) -> Self {
        let system = light.main();
        let (path, end) = light.path(px);
        let landed = match light.lights() {
            [_] => end.and_then(|(ray, side)| system.board().intersect(&ray).map(|(mm, _)| (mm, side))),
            // On a tilted board the mean of positions is not where the mean ray lands.
            _ => light.trace(px).map(|hit| (hit.board_mm, hit.side)),
        };
        // A ray that ended in the glass came in through the side of its first point.
        let entered = || Some(system.prism()?.side_at(*path.points.first()?));
        let side = match (&landed, &end) {
            (Ok((_, side)), _) | (Err(_), Ok((_, side))) => Some(*side),
            (Err(_), Err(_)) => entered(),
        };
        let reflected_at = match path.points.len() {
            n if landed != Err(Fate::TotalReflection) || n == path.directions.len() => None,
            1 => Some("front"),
            _ => Some("back"),
        };
        let point = |k: usize| path.points.get(k).copied();
        let exit = end.ok().map(|(ray, _)| ray.direction);
        let way = [point(0), path.directions.first().copied(), point(1), exit];
        let landed = landed.map(|(mm, _)| (mm, system.board().world(mm)));
        Self { px, side, landed, way, reflected_at }
    }

    /// Traces pixel positions, by packets where `ways` has them, with the same bits; gives each with its number, in any order.
    pub fn each(light: &InLight<'_>, ways: &WayTracer<'_>, places: &[DVec2], mut give: impl FnMut(usize, Self)) {
        // Light of several wavelengths is a mean of rays.
        if light.lights().len() > 1 {
            return places.iter().enumerate().for_each(|(k, px)| give(k, Self::new(light, *px)));
        }

        // A packet is of rays through one side, which mostly is that of their half of the picture.
        let board = light.main().board();
        let middle_px = 0.5 * light.main().camera().size_px()[0] as f64;
        let halves: [Vec<usize>; 2] = (0..places.len()).partition(|k| places[*k].x < middle_px).into();
        for numbers in halves.iter().flat_map(|half| half.chunks(LANES)) {
            let packet = std::array::from_fn(|k| places[numbers[k.min(numbers.len() - 1)]]);
            for ((k, px), way) in numbers.iter().zip(packet).zip(ways.trace(&packet)) {
                let ray = match way {
                    Some(WayToBoard { inside, behind, hit: BoardHit { board_mm, side } }) => Self {
                        px,
                        side: Some(side),
                        landed: Ok((board_mm, board.world(board_mm))),
                        way: [inside.origin, inside.direction, behind.origin, behind.direction].map(Some),
                        reflected_at: None,
                    },
                    None => Self::new(light, px),
                };
                give(*k, ray);
            }
        }
    }

    fn fate(&self) -> &'static str {
        self.landed.map_or_else(Fate::name, |_| "board")
    }

    /// The place in the world, and what is on the way there.
    fn places(&self) -> [Option<DVec3>; 5] {
        let [front, inner, back, exit] = self.way;
        [self.landed.ok().map(|(_, world)| world), front, inner, back, exit]
    }

    /// Appends a line without its end.
    pub fn text(&self, line: &mut String) {
        append(line, self.px.x);
        line.push(',');
        append(line, self.px.y);
        let _ = write!(line, ",{},{}", self.side.map_or("", side_name), self.fate());
        match self.landed {
            Ok((mm, _)) => append_all(line, &mm.to_array()),
            Err(_) => line.push_str(",,"),
        }
        for point in self.places() {
            match point {
                Some(point) => append_all(line, &point.to_array()),
                None => line.push_str(",,,"),
            }
        }
    }

    /// Appends an object of JSON.
    pub fn json(&self, text: &mut String) {
        let [world, front, inner, back, exit] = self.places().map(|point| point.map(|point| point.to_array()));
        let _ = write!(
            text,
            "{}",
            json!({
                "pixel_px": self.px.to_array(), "side": self.side.map(side_name), "fate": self.fate(),
                "reflected_at": self.reflected_at,
                "board_mm": self.landed.ok().map(|(mm, _)| mm.to_array()), "world_mm": world,
                "front_mm": front, "inner_direction": inner, "back_mm": back, "exit_direction": exit,
            })
        );
    }

    /// Appends a record of [`TracedRay::FIELDS`].
    pub fn record(&self, bytes: &mut Vec<u8>) {
        let board_mm = self.landed.map_or(DVec2::NAN, |(mm, _)| mm);
        let flat = [self.px.x, self.px.y, board_mm.x, board_mm.y];
        bytes.extend_from_slice(flat.map(f64::to_le_bytes).as_flattened());
        let places = self.places().map(|point| point.unwrap_or(DVec3::NAN).to_array().map(f64::to_le_bytes));
        bytes.extend_from_slice(places.as_flattened().as_flattened());
        let class = match (self.landed, self.side) {
            (Ok(_), Some(side)) => Class::from(side),
            (Ok(_), None) => Class::Missed,
            (Err(fate), _) => Class::from(fate),
        };
        bytes.extend_from_slice([side_number(self.side), class as u32].map(u32::to_le_bytes).as_flattened());
    }
}

impl AimedPoint {
    /// The first line of the text.
    pub(crate) const COLUMNS: &str = "side,u_mm,v_mm,fate,x_px,y_px,seen";

    /// The fields of a record: NaN where no pixel sees the point, the side as 0 left and 1 right, the class as in the EXR, and 1 where
    /// the pixel is on the sensor and looks through that side.
    pub const FIELDS: [NpyField; 5] = [
        NpyField::F64("board_mm", 2),
        NpyField::F64("pixel_px", 2),
        NpyField::U32("side"),
        NpyField::U32("class"),
        NpyField::U32("seen"),
    ];

    /// Seeks the pixel.
    pub fn new(aimer: &Aimer<'_>, side: Side, board_mm: DVec2) -> Self {
        Self { side, board_mm, seen_at: aimer.aim(board_mm, side).map(|px| (px, aimer.sees(px, side))) }
    }

    fn fate(&self) -> &'static str {
        self.seen_at.map_or_else(Fate::name, |_| "board")
    }

    /// Appends a line without its end.
    pub fn text(&self, line: &mut String) {
        line.push_str(side_name(self.side));
        append_all(line, &self.board_mm.to_array());
        let _ = write!(line, ",{}", self.fate());
        match self.seen_at {
            Ok((px, seen)) => {
                append_all(line, &px.to_array());
                let _ = write!(line, ",{seen}");
            }
            Err(_) => line.push_str(",,,"),
        }
    }

    /// Appends an object of JSON.
    pub fn json(&self, text: &mut String) {
        let px = self.seen_at.ok().map(|(px, _)| px.to_array());
        let seen = self.seen_at.ok().map(|(_, seen)| seen);
        let (side, mm) = (side_name(self.side), self.board_mm.to_array());
        let found = json!({ "side": side, "board_mm": mm, "fate": self.fate(), "pixel_px": px, "seen": seen });
        let _ = write!(text, "{found}");
    }

    /// Appends a record of [`AimedPoint::FIELDS`].
    pub fn record(&self, bytes: &mut Vec<u8>) {
        let px = self.seen_at.map_or(DVec2::NAN, |(px, _)| px);
        for value in [self.board_mm, px].iter().flat_map(DVec2::as_ref) {
            bytes.extend(value.to_le_bytes());
        }
        let class = self.seen_at.map_or_else(Class::from, |_| Class::from(self.side));
        let seen = self.seen_at.is_ok_and(|(_, seen)| seen);
        for value in [side_number(Some(self.side)), class as u32, u32::from(seen)] {
            bytes.extend(value.to_le_bytes());
        }
    }
}

fn side_name(side: Side) -> &'static str {
    if side == Side::Left { "left" } else { "right" }
}

fn side_number(side: Option<Side>) -> u32 {
    match side {
        Some(Side::Left) => 0,
        Some(Side::Right) => 1,
        None => 2,
    }
}

/// Appends the numbers, each behind a comma.
fn append_all(line: &mut String, values: &[f64]) {
    for &value in values {
        line.push(',');
        append(line, value);
    }
}

/// Appends a shortest text that is read back as `value`, in the notation of `{:?}`; where two are as near, `{:?}` may write the other.
fn append(line: &mut String, value: f64) {
    if value == 0.0 || (1e-4..1e16).contains(&value.abs()) {
        line.push_str(zmij::Buffer::new().format_finite(value));
    } else {
        let _ = write!(line, "{value:?}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Packets through sheets and planes, turned and not, of one light and of several, on the sensor and beside it, have the bits of
    /// single rays, and fill all but a few.
    #[test]
    fn each_ray_is_as_it_is_alone() {
        for (case, packed) in [
            ("prism_flat", true),
            ("prism_freeform", true),
            ("prism_tilted", true),
            ("prism_revolved", true),
            ("effect_dispersion", false),
        ] {
            let path = format!("{}/scenes/cases/{case}.toml", env!("CARGO_MANIFEST_DIR"));
            let system = crate::system::build(&crate::scene::load(path.as_ref()).unwrap()).unwrap();
            let light = InLight::new(&system);
            let ways = WayTracer::new(light.main());
            let place = |k: usize| {
                let part = |alpha: f64| 1.1 * (alpha * k as f64).fract() - 0.05;
                let size = system.camera().size_px().map(|n| n as f64);
                DVec2::from(size) * DVec2::new(part(0.754_877_666), part(0.569_840_291))
            };
            let places: Vec<DVec2> = (0..403).map(place).collect();
            let mut together = vec![None; places.len()];
            TracedRay::each(&light, &ways, &places, |k, ray| together[k] = Some(ray));
            let alone: Vec<Option<TracedRay>> = places.iter().map(|px| Some(TracedRay::new(&light, *px))).collect();
            assert_eq!(format!("{together:?}"), format!("{alone:?}"), "{case}");
            let by_packets = places.iter().filter(|px| ways.trace(&[**px; LANES])[0].is_some()).count();
            assert!(!packed || by_packets > 300, "{case}: {by_packets}");
        }
    }

    /// Numbers of every size, and those at which the notation changes.
    #[test]
    fn numbers_are_read_back_and_as_short_as_they_can_be() {
        let mut bits = 1u64;
        let random = (0..20_000).map(|k| {
            bits = bits.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let magnitude = (bits >> 11) as f64 * libm::ldexp(1.0, (bits % 200) as i32 - 150);
            if k % 2 == 0 { magnitude } else { -magnitude }
        });
        let edges =
            [0.0, -0.0, 1.0, -1.0, 960.5, 1e-4, 1e-5, 1e15, 1e16, 1e17, 0.1, 1e300, 5e-324, f64::NAN, f64::INFINITY];
        let near = edges.iter().flat_map(|v| [v.next_up(), v.next_down()]);
        for value in random.chain(edges).chain(near) {
            let mut line = String::new();
            append(&mut line, value);
            // The last digit of two that are as near may differ.
            let standard = format!("{value:?}");
            let (digits, _) = line.split_at(line.len() - 1);
            assert!(line.len() == standard.len() && standard.starts_with(digits), "{line} {standard}");
            let read: f64 = line.parse().unwrap();
            assert!(read.to_bits() == value.to_bits() || (read.is_nan() && value.is_nan()), "{line} {standard}");
        }
    }
}
