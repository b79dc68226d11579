//! Do the maps of `rectify` make a rectified pair, at their depth and, as far as is told, at others?

use crate::instruments::built;
use biprism::analysis::rectify::{Rectifier, Sources};
use biprism::geom::Pose;
use biprism::metrics::pair_residual::PairResidual;
use biprism::scene::{self, BoardSpec};
use biprism::system::System;
use biprism::system::aim::Aimer;
use glam::{DMat2, DVec2, DVec3};

/// The paper's instrument with another prism, on pixels of four times the pitch.
fn instrument(camera: &str, prism: &str) -> System {
    let text = format!(
        "name = \"pair\"\n[camera]\nwidth_px = 480\nheight_px = 270\npixel_pitch_um = 22.0\nfocal_length_mm = 35.0\n{camera}\n\
         [prism]\nindex = 1.48\nridge_distance_mm = 78.472\nthickness_mm = 8.545\n{prism}\n[board]\ncolumns = 41\nrows = 41\n\
         square_mm = 10.0\nposition_mm = [0.0, 0.0, 1000.0]\n"
    );
    built(&scene::parse(&text, "pair", None).unwrap_or_else(|problem| panic!("{problem}")))
}

fn flat() -> System {
    instrument("", "kind = \"flat\"")
}

fn freeform() -> System {
    instrument("", "kind = \"freeform\"\n[prism.design]\nstep_px = 2.0\ndegree = 5")
}

fn exact() -> System {
    let design = "[prism.design]\nobjective = \"epipolar\"\nrear = \"even\"\ndegree = 7\nstep_px = 2.0";
    instrument("", &format!("kind = \"freeform\"\n{design}"))
}

/// A flat prism that stands askew before a camera with a lens.
fn askew() -> System {
    let camera = "principal_point_px = [243.0, 133.0]\nrotation_deg = [0.1, -0.2, 0.3]\ndistortion = [-0.1, 0.05, 1e-3, -2e-3, 0.0]";
    instrument(camera, "kind = \"flat\"\nposition_mm = [0.3, -0.2, 1.0]\ntilt_deg = [0.4, 0.3, -0.5]")
}

fn rectifier(system: &System, depth_mm: f64) -> Rectifier {
    Rectifier::new(system, depth_mm).unwrap_or_else(|problem| panic!("{problem}"))
}

/// The position of the rectified image `k` from which the map takes `full_px`: Newton's method on the map itself.
fn unmapped(sources: &Sources<'_>, k: usize, full_px: DVec2, start: DVec2) -> Option<DVec2> {
    let mut at = start;
    for _ in 0..20 {
        let here = sources.at(k, at)?;
        let step = |along: DVec2| Some((sources.at(k, at + along)? - sources.at(k, at - along)?) / 0.02);
        let change = DMat2::from_cols(step(DVec2::X * 0.01)?, step(DVec2::Y * 0.01)?).inverse() * (full_px - here);
        at += change;
        if change.length() < 1e-9 {
            return Some(at);
        }
    }
    panic!("the map of half {k} is not inverted at {full_px}")
}

/// Both positions in the rectified images of points at `depth_mm` that both halves see, by the maps, and the depths of the points
/// from the pair's centres.
fn shown(system: &System, sources: &Sources<'_>, rectifier: &Rectifier, depth_mm: f64) -> Vec<([DVec2; 2], f64)> {
    let cameras = rectifier.pair().cameras();
    // Any board whose plane holds the point tells where it is seen; this one is not that of the maps.
    let world_from_board = Pose::new(DVec3::new(0.0, 0.0, depth_mm), DVec3::new(0.02, -0.03, 0.0));
    let there = system.with_board(&BoardSpec { world_from_board, ..system.board().pattern });
    let aimer = Aimer::new(&there);
    let mut found = Vec::new();
    for k in 0..240 {
        // Places of the left half, spread evenly (R2 of Roberts, the plastic number's powers).
        let n = f64::from(k) + 0.5;
        let place = DVec2::new((n * 0.754_877_666_246_692_8).fract(), (n * 0.569_840_290_998_053_3).fract());
        let left_px = place * DVec2::new(236.0, 266.0) + 2.0;
        let Ok(hit) = there.trace(left_px) else { continue };
        let world_mm = there.board().world(hit.board_mm);
        let [left, right] = rectifier.frames();
        let Ok(right_px) = aimer.aim(hit.board_mm, right.side()) else { continue };
        if hit.side != left.side() || !right.contains(right.own(right_px)) || !aimer.sees(right_px, right.side()) {
            continue;
        }
        let ideal = [0, 1].map(|k| cameras[k].project(world_mm).expect("before it"));
        let placed = [(0, left_px), (1, right_px)].map(|(k, px)| unmapped(sources, k, px, ideal[k]));
        let [Some(left_px), Some(right_px)] = placed else { continue };
        found.push(([left_px, right_px], cameras[0].camera_from_world.point(world_mm).z));
    }
    assert!(found.len() > 60, "{} points at {depth_mm} mm", found.len());
    found
}

/// The largest vertical disparity and the largest error of the disparity.
fn errors(rectifier: &Rectifier, shown: &[([DVec2; 2], f64)]) -> [f64; 2] {
    let pair = rectifier.pair();
    shown.iter().fold([0.0, 0.0], |[vertical, along]: [f64; 2], ([left, right], depth_mm)| {
        let ideal = pair.focal_px().x * pair.baseline_mm() / depth_mm + pair.offset_px();
        [vertical.max((left.y - right.y).abs()), along.max((left.x - right.x - ideal).abs())]
    })
}

fn told(rectifier: &Rectifier, depth_mm: f64) -> PairResidual {
    rectifier.residual(depth_mm).pairs.expect("points that both halves see")
}

/// At the depth of the maps points are in one row, and their disparity is f b/Z, whatever the prism and the camera: what the
/// search for a position leaves, a few times 1e-9 px, through the inversion of the map.
#[test]
fn maps_are_right_at_their_depth() {
    for (name, system) in [("flat", flat()), ("freeform", freeform()), ("askew", askew())] {
        let rectifier = rectifier(&system, 800.0);
        let sources = Sources::new(&rectifier);
        let here = told(&rectifier, 800.0);
        assert!(here.vertical_max_px < 1e-7 && here.disparity_max_px < 1e-7, "{name}: {here:?}");
        // Points of a plane that the maps do not have, where it crosses theirs.
        let normal = rectifier.pair().common_from_world().transpose() * DVec3::Z;
        let camera_mm = system.camera().position_mm();
        for (k, frame) in rectifier.frames().iter().enumerate() {
            for place in [DVec2::new(0.3, 0.2), DVec2::new(0.6, 0.7), DVec2::new(0.5, 0.5)] {
                let full_px = frame.full(frame.size_px * place);
                let ray = system.exit_ray_through(full_px, frame.side()).expect("it passes");
                let along = (800.0 - normal.dot(ray.origin - camera_mm)) / normal.dot(ray.direction);
                let camera = &rectifier.pair().cameras()[k];
                let seen = camera.project(ray.at(along)).expect("before it");
                let source = sources.at(k, seen).expect("the half sees it");
                assert!((source - full_px).length() < 1e-7, "{name}: {source} for {full_px}");
            }
        }
    }
}

/// At other depths what is left is what is told, by the maps themselves: no point more, and some point more than half of it.
#[test]
fn what_maps_leave_at_other_depths_is_what_is_told() {
    for (name, system) in [("flat", flat()), ("freeform", freeform()), ("askew", askew())] {
        let rectifier = rectifier(&system, 1000.0);
        let sources = Sources::new(&rectifier);
        for depth_mm in [600.0, 2000.0] {
            let shown = shown(&system, &sources, &rectifier, depth_mm);
            let [vertical, along] = errors(&rectifier, &shown);
            // The board of the points is tilted by 0.04 across a field of 0.09 either way: 0.4 % of 1/Z, and 1 % of 1/Z - 1/Z0.
            let most = |px: f64| 1.05 * px + 1e-7;
            let told = told(&rectifier, depth_mm);
            assert!(vertical <= most(told.vertical_max_px), "{name} at {depth_mm}: {vertical} px, {told:?}");
            assert!(along <= most(told.disparity_max_px), "{name} at {depth_mm}: {along} px, {told:?}");
            assert!(along > 0.5 * told.disparity_max_px, "{name} at {depth_mm}: {along} px, {told:?}");
            assert!(vertical > 0.5 * told.vertical_max_px, "{name} at {depth_mm}: {vertical} px, {told:?}");
        }
    }
}

/// The figures: the freeform at most 0.011 px of the paper's 5.5 um from 0.6 to 2 m, the exact design 1e-4 px at every depth
/// and its perfect matcher's depth 1e-4 %; a flat prism is repaired at one depth only.
#[test]
fn how_much_maps_leave() {
    /// Pixels here have four times the paper's pitch.
    const PAPER_PX: f64 = 4.0;
    let left = |system: &System| {
        let rectifier = rectifier(system, 1000.0);
        [600.0, 1000.0, 2000.0, 10_000.0, f64::INFINITY].map(|depth_mm| rectifier.residual(depth_mm))
    };
    let largest = |residual: &biprism::analysis::rectify::DepthResidual| {
        residual.deviation.as_ref().expect("rays").max * PAPER_PX
    };
    for residual in left(&exact()) {
        assert!(largest(&residual) <= 1e-4, "{residual:?}");
        let Some(pairs) = residual.pairs else { continue };
        assert!(pairs.vertical_max_px * PAPER_PX <= 1e-4 && pairs.depth_error.max_percent < 1e-4, "{pairs:?}");
    }
    for residual in &left(&freeform())[..3] {
        assert!(largest(residual) <= 0.011, "{residual:?}");
    }
    let [near, own, far, ..] = left(&flat());
    assert!(largest(&near) > 0.5 && largest(&far) > 0.3 && largest(&own) < 1e-7, "{near:?} {own:?} {far:?}");
}

/// Of the epipolar design the maps are the shift of each row that its law states: kappa(v) = b (sqrt(1 + v^2/f^2) - 1), to the right in
/// the right half.
#[test]
fn the_map_of_an_epipolar_design_is_one_shift_a_row() {
    let system = exact();
    let law = system.prism().and_then(|prism| prism.law().copied()).expect("a design has a law");
    let rectifier = rectifier(&system, 1000.0);
    let sources = Sources::new(&rectifier);
    for (k, mirror) in [(0, -1.0), (1, 1.0)] {
        for y in [1.0, 40.0, 135.0, 200.0, 269.0] {
            for x in [3.0, 77.0, 120.0, 236.0] {
                let source = sources.at(k, DVec2::new(x, y)).expect("the half sees it");
                let slope = (y - 135.0) * 0.022 / 35.0;
                let kappa = law.kappa_mm / 0.022 * ((1.0 + slope * slope).sqrt() - 1.0);
                let first = if k == 0 { 0.0 } else { 240.0 };
                let ideal = DVec2::new(first + x + mirror * kappa, y);
                assert!((source - ideal).length() < 1e-4, "{source} for {ideal}");
            }
        }
        assert!(sources.map(k, &()).off_row_shift_px < 1e-4);
    }
    assert!(Sources::new(&self::rectifier(&flat(), 1000.0)).map(0, &()).off_row_shift_px > 0.05);
}
