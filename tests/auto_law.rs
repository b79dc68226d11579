//! Is a picture without what `effects = "auto"` leaves out the same within its threshold, whatever the scene?
//!
//! `AUTO_LAW_SCENES` random scenes from number `AUTO_LAW_FIRST` on are made, each from its number alone.

use crate::common::long_run::number;
use crate::instruments::built;
use crate::level_law::dice::Dice;
use biprism::accuracy::{Accuracy, Level};
use biprism::effect::Threshold;
use biprism::render::{Outputs, render_wanted};
use biprism::scene::{self, Scene};
use biprism::system::auto::{settled, verdicts};
use biprism::system::{self, System};
use rayon::prelude::*;
use std::fmt::Write;

/// Scenes by default: what takes a few seconds of one processor.
const SCENES: u64 = 24;
/// Lines lie within this of their places, in px.
const BEND_PX: f64 = 1e-5;

/// Scene `number` as text.
fn text(number: u64) -> String {
    let dice = &mut Dice::new(number);
    let board_z = 1000.0;
    let prism = match dice.below(5) {
        0 => "kind = \"none\"".to_owned(),
        k => {
            let tilted =
                if dice.chance(0.3) { "\ntilt_deg = [1.0, 2.0, 3.0]\nposition_mm = [0.5, 0.3, 0.0]" } else { "" };
            let kind = if k == 1 { "freeform" } else { "flat" };
            format!(
                "kind = \"{kind}\"\nindex = 1.5168\nglass = \"N-BK7\"\nridge_distance_mm = 78.472\nthickness_mm = 8.545{tilted}"
            )
        }
    };
    let square = dice.of(&[4.0, 20.0, 80.0]);
    let [black, white, background] = [dice.from(0.0, 0.3), dice.from(0.5, 1.0), dice.from(0.0, 1.0)];
    let mut text = format!(
        "name = \"auto\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = 8\nheight_px = 5\npixel_pitch_um = 880.0\n\
         [prism]\n{prism}\n[board]\ncolumns = 41\nrows = 41\nsquare_mm = {square:?}\n\
         position_mm = [3.0, 2.0, {board_z:?}]\nblack = {black:?}\nwhite = {white:?}\nbackground = {background:?}\n"
    );
    let glass = prism.contains("index");
    effects(dice, glass, &mut text);
    text
}

/// Any effects of any strength, the weak ones as often as the strong ones.
fn effects(dice: &mut Dice, glass: bool, text: &mut String) {
    fn decades(dice: &mut Dice, low: f64, high: f64) -> f64 {
        low * libm::pow(high / low, dice.share())
    }
    let mut add = |words: String| writeln!(text, "{words}").expect("text grows");
    if dice.chance(0.4) {
        let f_number = decades(dice, 1.2, 3000.0);
        let focus = dice.of(&[1000.0, 1000.0, 990.0, 600.0]);
        add(format!("[effect.thin_lens]\nf_number = {f_number:?}\nfocus_mm = {focus:?}"));
    }
    if dice.chance(0.4) {
        add(format!("[effect.cos4]\nexponent = {:?}", decades(dice, 1e-3, 4.0)));
    }
    if dice.chance(0.4) {
        let place = dice.of(&[[60.0, 0.0, 980.0], [-300.0, 100.0, 300.0], [20.0, -30.0, 940.0]]);
        add(format!("[effect.lamp]\nposition_mm = {place:?}\nshare = {:?}", decades(dice, 1e-4, 1.0)));
    }
    if dice.chance(0.3) {
        add(format!("[effect.diffraction]\nf_number = {:?}", decades(dice, 0.05, 60.0)));
    }
    if glass {
        if dice.chance(0.4) {
            add(format!("[effect.absorption]\nper_mm = {:?}", decades(dice, 1e-6, 1e-2)));
        }
        if dice.chance(0.3) {
            add("[effect.fresnel]".to_owned());
            if dice.chance(0.5) {
                add(format!("[effect.coating]\nindex = 1.38\nthickness_nm = {:?}", decades(dice, 0.1, 100.0)));
            }
            if dice.chance(0.4) {
                add(format!("[effect.ghosts]\nbehind = {:?}", dice.from(0.0, 1.0)));
            }
        }
        if dice.chance(0.3) {
            add(format!("[effect.manufacture]\ndecentre_mm = [{:?}, 0.0, 0.01]", decades(dice, 1e-6, 0.1)));
        }
        if dice.chance(0.2) {
            add(format!("[effect.roughness]\nback_slope_deg = {:?}", decades(dice, 1e-5, 0.1)));
        }
        if dice.chance(0.2) {
            let apart = decades(dice, 0.01, 60.0);
            add(format!("[effect.dispersion]\nlines_nm = [587.5618, {:?}]", 587.5618 + apart));
        }
        if dice.chance(0.2) {
            add(format!("[effect.clipping]\nchamfer_mm = {:?}", decades(dice, 1e-5, 0.1)));
        }
    }
    if dice.chance(0.5) {
        let exposure = decades(dice, 0.3, 20.0);
        let mut sensor = "[effect.sensor]\nwhite_e = 10000.0\nshot_noise = false\n".to_owned();
        if dice.chance(0.6) {
            let bits = dice.of(&[8, 12, 16]);
            let gain = exposure * (f64::from(1u32 << bits) - 1.0) / 10000.0;
            let _ = write!(
                sensor,
                "adc_bits = {bits}\ngain_dn_per_e = {gain:?}\nblack_level_dn = {:?}\n",
                dice.of(&[0.0, 16.0])
            );
        }
        if dice.chance(0.5) {
            let _ = writeln!(sensor, "gamma = {:?}", dice.of(&[2.2, 1.8, 0.7]));
        }
        if dice.chance(0.2) {
            let _ = writeln!(sensor, "prnu = 0.01");
        }
        add(sensor);
    }
    add("[quadrature]\npoints = 4".to_owned());
}

/// What `auto` leaves out of a scene changes its picture by this share of the threshold, and how many effects it leaves out.
fn change(number: u64) -> Option<(f64, usize)> {
    let text = text(number);
    let accuracy = Accuracy { bend_px: BEND_PX, ..Level::Exact.accuracy() };
    let mut scene = Scene { accuracy, ..scene::parse(&text, "auto", None).unwrap_or_else(|p| panic!("{p}\n{text}")) };
    let full: System = built(&scene);
    let dice = &mut Dice::new(!number);
    let grey = 5e-3 * libm::pow(0.3 / 5e-3, dice.share());
    scene.effects.auto = Some(Threshold { grey: Some(grey), px: None });
    let ideal = system::ideal(&scene).ok()?;
    let told = verdicts(&ideal, &scene);
    let dropped: Vec<&str> = told.iter().filter(|v| !v.kept).map(|v| v.effect.key()).collect();
    if dropped.is_empty() {
        return Some((0.0, 0));
    }
    let left = ideal.with_effects(&settled(&told, &scene));
    let [a, b] = [full, left].map(|system| render_wanted(&system, Outputs { truth: false }, &()));
    // A pixel without promise may be anything.
    if a.account.unpromised_pixels + b.account.unpromised_pixels > 0 {
        return None;
    }
    let most =
        a.radiance.data().iter().zip(b.radiance.data()).map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max);
    // The two pictures keep ten lines within the bend, of a contrast that is at most the brightest pixel.
    let brightest = a.radiance.data().iter().fold(1.0f32, |most, v| most.max(*v));
    let share = (most - 2.0 * 10.0 * f64::from(brightest) * BEND_PX) / grey;
    if share > 1.0 {
        println!("scene {number}: {most:.2e} above {grey:.2e} without {dropped:?}\n{text}");
    }
    Some((share, dropped.len()))
}

#[test]
fn what_is_left_out_changes_less_than_the_threshold() {
    let (first, count) = (number("AUTO_LAW_FIRST", 0), number("AUTO_LAW_SCENES", SCENES));
    let found: Vec<(f64, usize)> = (first..first + count).into_par_iter().filter_map(change).collect();
    let dropping = found.iter().filter(|(_, dropped)| *dropped > 0).count();
    let worst = found.iter().map(|(share, _)| *share).fold(0.0, f64::max);
    let broken = found.iter().filter(|(share, _)| *share > 1.0).count();
    println!(
        "{} scenes, of {dropping} something is left out; the worst change is {worst:.3} of the threshold",
        found.len()
    );
    assert!(broken == 0, "{broken} scenes change by more than the threshold");
    assert!(
        4 * dropping as u64 > count && 10 * found.len() as u64 > 8 * count,
        "only {dropping} of {count} scenes leave something out"
    );
}
