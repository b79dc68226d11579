//! Random small scenes, biased to what is hard: lines of the pattern on the sides of pixels, on the ridge and on rims.

use super::dice::Dice;
use biprism::optics::fate::Fate;
use biprism::scene::{self, Scene};
use biprism::system::{self, Side, System};
use glam::{DVec2, DVec3};
use std::fmt::Write;
use std::path::Path;

/// The focal length and the width of the sensor of the paper, in mm.
const FOCAL_MM: f64 = 35.0;
const SENSOR_MM: f64 = 10.56;
/// Of the paper's prism, in mm.
const RIDGE_MM: f64 = 78.472;
const THICKNESS_MM: f64 = 8.545;
/// Slope of the paper's facets.
const FACET_SLOPE: f64 = 0.155_8;

/// A scene as text, of which all but the board's place is fixed.
struct Draft {
    camera: String,
    prism: String,
    effect: String,
    board: String,
    board_mm: DVec3,
    tilt_deg: DVec3,
    size_px: [usize; 2],
}

impl Draft {
    fn text(&self) -> String {
        let Self { camera, prism, effect, board, board_mm: at, tilt_deg: tilt, .. } = self;
        format!(
            "name = \"law\"\n[camera]\n{camera}[prism]\n{prism}[board]\n{board}position_mm = [{:?}, {:?}, {:?}]\n\
             tilt_deg = [{:?}, {:?}, {:?}]\n{effect}",
            at.x, at.y, at.z, tilt.x, tilt.y, tilt.z
        )
    }

    fn system(&self) -> Option<System> {
        system::build(&parsed(&self.text())?).ok()
    }
}

/// The scene of a text that the front door lets in.
fn parsed(text: &str) -> Option<Scene> {
    scene::parse(text, "law", Some(Path::new(env!("CARGO_MANIFEST_DIR")))).ok()
}

/// Scene `number` with its text; `None` where the numbers drawn make no instrument.
pub(super) fn scene(number: u64) -> Option<(String, System)> {
    let dice = &mut Dice::new(number);
    let [width, height] = size_px(dice);
    let pitch_mm = SENSOR_MM / width as f64;
    let (prism, glassy) = prism(dice, width);
    let mut draft = Draft {
        camera: camera(dice, [width, height], pitch_mm),
        effect: clipping(dice, glassy),
        prism,
        board: String::new(),
        board_mm: DVec3::new(0.0, 0.0, 1000.0),
        tilt_deg: DVec3::ZERO,
        size_px: [width, height],
    };
    let square_mm = square_mm(dice, pitch_mm);
    draft.board = board(dice, square_mm);
    if dice.chance(0.4) {
        draft.tilt_deg = DVec3::new(dice.within(40.0), dice.within(40.0), dice.of(&[0.0, 90.0, 45.0, 27.0, -3.0]));
    }
    if dice.chance(0.3) {
        draft.board_mm += DVec3::new(dice.within(200.0), dice.within(150.0), dice.within(300.0));
    } else if dice.chance(0.3) {
        draft.board_mm += square_mm * DVec3::new(dice.below(3) as f64, dice.below(3) as f64, 0.0) * 0.5;
    }
    if dice.chance(0.6) {
        let moved = tied(dice, &draft, square_mm);
        draft.board_mm = moved.unwrap_or(draft.board_mm);
    }
    Some((draft.text(), draft.system()?))
}

/// Few and many pixels, odd and even; now and then a picture that is large enough for a map.
fn size_px(dice: &mut Dice) -> [usize; 2] {
    if dice.chance(0.02) {
        return dice.of(&[[130, 64], [137, 67], [64, 36], [48, 27]]);
    }
    [dice.of(&[1, 2, 3, 4, 5, 8, 11, 16]), dice.of(&[1, 2, 3, 4, 7, 9])]
}

fn camera(dice: &mut Dice, [width, height]: [usize; 2], pitch_mm: f64) -> String {
    // Pixels of a small sensor are small as well in half of the scenes.
    let smaller = dice.of(&[1.0, 1.0, 0.1, 0.01]);
    let focal_mm = FOCAL_MM / smaller;
    let mut text = format!(
        "focal_length_mm = {focal_mm:?}\nwidth_px = {width}\nheight_px = {height}\npixel_pitch_um = {:?}\n",
        1000.0 * pitch_mm
    );
    if dice.chance(0.4) {
        let [x, y] = [dice.of(&[0.0, 0.0, 0.3, -1e-3]), dice.of(&[0.5, -1.4, 3.0, 1e-9])];
        let _ = writeln!(text, "position_mm = [{x:?}, {y:?}, 0.0]");
    }
    text
}

/// A prism of any kind, and whether there is glass.
fn prism(dice: &mut Dice, width: usize) -> (String, bool) {
    let index = dice.of(&[1.48, 1.48, 1.52, 1.8, 1.333]);
    let mut body = format!("index = {index:?}\n");
    if dice.chance(0.5) {
        let _ = writeln!(body, "position_mm = [{:?}, {:?}, 0.0]", dice.within(1.5), dice.within(1.0));
    }
    if dice.chance(0.4) {
        let [x, y, z] = [dice.within(3.0), dice.within(3.0), dice.of(&[0.0, 1.5, -7.0, 30.0, 1e-6])];
        let _ = writeln!(body, "tilt_deg = [{x:?}, {y:?}, {z:?}]");
    }
    let lengths = format!("ridge_distance_mm = {RIDGE_MM:?}\nthickness_mm = {THICKNESS_MM:?}\n");
    match dice.below(10) {
        0 | 1 => ("kind = \"none\"\n".to_owned(), false),
        2..=4 => {
            let facet = dice.of(&["", "", "facet_angle_deg = 3.0\n", "facet_angle_deg = -4.0\n"]);
            (format!("kind = \"flat\"\n{body}{lengths}{facet}"), true)
        }
        5 | 6 => {
            let (step_px, degree) = (0.1 * width as f64, 3 + dice.below(4));
            let design = format!("[prism.design]\nstep_px = {:?}\ndegree = {degree}\n", step_px.clamp(0.3, 60.0));
            (format!("kind = \"freeform\"\n{body}{lengths}{design}"), true)
        }
        7 | 8 => (format!("kind = \"polynomial\"\n{body}{}", sheets(dice)), true),
        _ => {
            let mesh = "scenes/cases/prism_mesh";
            (format!("kind = \"mesh\"\n{body}front = \"{mesh}/front.ply\"\nback = \"{mesh}/back.obj\"\n"), true)
        }
    }
}

/// Two sheets, of which a part of the picture may lie beyond the rim.
fn sheets(dice: &mut Dice) -> String {
    let patch = |dice: &mut Dice, z: f64, slope: f64| {
        let domain =
            [[dice.of(&[0.0, -0.2, 0.4, 1.0]), dice.from(3.0, 14.0)], [-dice.from(1.0, 9.0), dice.from(1.0, 9.0)]];
        let [bend_x, bend_y] = [dice.within(0.3), dice.within(0.3)];
        format!(
            "centre_mm = [6.0, 0.0]\nscale_mm = [6.0, 7.0]\ndomain_mm = {domain:?}\n\
             terms = [[0, 0, {:?}], [1, 0, {:?}], [2, 0, {bend_x:?}], [0, 2, {bend_y:?}], [1, 2, {:?}]]\n",
            z + 6.0 * slope,
            6.0 * slope,
            dice.within(0.01),
        )
    };
    let front = patch(dice, RIDGE_MM, FACET_SLOPE);
    let back = patch(dice, RIDGE_MM + THICKNESS_MM, 0.0);
    format!("[prism.front]\n{front}[prism.back]\n{back}")
}

/// Rims, ground ridges and stops, in a third of the scenes.
fn clipping(dice: &mut Dice, glassy: bool) -> String {
    if !dice.chance(0.3) {
        return String::new();
    }
    let mut text = "[effect.clipping]\n".to_owned();
    if glassy && dice.chance(0.4) {
        let _ = match dice.below(2) {
            0 => writeln!(text, "rim = {{ sides_mm = [{:?}, {:?}] }}", dice.from(2.0, 26.0), dice.from(2.0, 15.0)),
            _ => writeln!(text, "rim = {{ diameter_mm = {:?} }}", dice.from(2.0, 26.0)),
        };
    }
    if glassy && dice.chance(0.4) {
        let _ = writeln!(text, "chamfer_mm = {:?}", dice.of(&[0.01, 0.3, 1.0, 3.0]));
    }
    if dice.chance(0.4) {
        let _ = writeln!(text, "stop = {{ at_mm = 30.0, diameter_mm = {:?} }}", dice.from(1.0, 11.0));
    }
    text
}

/// Whole pixels, parts of them, or any width; without glass a pixel is `pitch_mm` times 1000 / 35 wide on the board.
fn square_mm(dice: &mut Dice, pitch_mm: f64) -> f64 {
    let pixel_mm = pitch_mm * 1000.0 / FOCAL_MM;
    match dice.below(4) {
        0 => pixel_mm * dice.of(&[1.0, 2.0, 3.0, 4.0, 6.0, 0.5]),
        1 => pixel_mm * dice.of(&[0.25, 0.1, 0.037]),
        _ => pixel_mm * dice.from(0.6, 12.0),
    }
}

fn board(dice: &mut Dice, square_mm: f64) -> String {
    let columns = dice.of(&[1, 2, 3, 4, 5, 8, 40, 41, 300]);
    let rows = dice.of(&[1, 2, 3, 4, 7, 8, 40, 41, 300]);
    let mut text = format!("columns = {columns}\nrows = {rows}\nsquare_mm = {square_mm:?}\n");
    if dice.chance(0.4) {
        let [black, white, background] = [dice.from(0.0, 1.0), dice.from(0.0, 1.0), dice.from(0.0, 1.0)];
        let _ = writeln!(text, "black = {black:?}\nwhite = {white:?}\nbackground = {background:?}");
    }
    if dice.chance(0.3) {
        let _ = writeln!(text, "margin_mm = {:?}", square_mm * dice.of(&[0.0, 0.5, 1e-3]));
    }
    text
}

/// The place of the board where a crossing of lines is seen at the corner of a pixel, by the ridge, or on a rim.
fn tied(dice: &mut Dice, draft: &Draft, square_mm: f64) -> Option<DVec3> {
    let system = draft.system()?;
    let [width, height] = draft.size_px;
    let row = dice.below(height + 1) as f64 + dice.of(&[0.0, 0.0, 0.5]);
    let column = if dice.chance(0.5) { 0.5 * width as f64 } else { dice.below(width + 1) as f64 };
    let px = DVec2::new(column, row);
    let px = if dice.chance(0.3) { changed(&system, px.y, width as f64).unwrap_or(px) } else { px };
    let side = dice.of(&[Side::Left, Side::Right]);
    let seen_mm = system.footprint_through(px, side).ok()?.sight.board_mm;
    let pose = system.board().pattern.world_from_board;
    // To the nearest line there is, by less than a square.
    let count = DVec2::new(system.board().pattern.columns as f64, system.board().pattern.rows as f64);
    let off = |seen: f64, count: f64| seen - ((seen / square_mm + 0.5 * count).round() - 0.5 * count) * square_mm;
    let off = DVec2::new(off(seen_mm.x, count.x), off(seen_mm.y, count.y));
    Some(pose.translation_mm + pose.rotation * off.extend(0.0))
}

/// A place in the row `y` where what becomes of rays changes.
fn changed(system: &System, y: f64, width: f64) -> Option<DVec2> {
    let kind = |x: f64| -> Result<Side, Fate> { system.trace(DVec2::new(x, y)).map(|hit| hit.side) };
    let steps = 40;
    let at = |k: usize| width * k as f64 / f64::from(steps);
    let k = (0..steps as usize).find(|&k| kind(at(k)) != kind(at(k + 1)))?;
    let (mut low, mut high) = (at(k), at(k + 1));
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if kind(middle) == kind(low) { low = middle } else { high = middle }
    }
    Some(DVec2::new(high, y))
}
