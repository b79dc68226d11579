//! A judgement as the report's entry for one prism.

use super::board_pose;
use super::cameras;
use super::json::judgement::{self as to, Depths};
use super::json::{
    AccuracyEntry, Corners, Definition, Depth, Design, Frame, HalfEntry, Halves, Normaliser, PinholeEntry, Stereo,
};
use crate::analysis::judge::{CENTRE_ONLY, CentreFigures, Judgement, PinholeFigures, free_at};
use crate::analysis::photograph::FoundPose;
use crate::analysis::view::Detected;
use crate::effect::Hook;
use crate::metrics::Deviation;
use crate::metrics::reprojection::{ALL, POSE_AND_ANAMORPHIC, POSE_AND_FOCAL, Parameter};
use crate::metrics::row_law::{ROW_LAW, ROW_LAW_AT_ONE_DEPTH};
use crate::render::{AccuracyReport, Counts};
use crate::scene::Scene;
use crate::system::System;
use crate::system::in_light::light_name;
use glam::DVec2;
use std::collections::BTreeMap;

/// The entry of the prism `name`. `pitch_mm` is the side of a pixel.
pub fn entry(
    name: &str,
    judgement: &Judgement,
    fates: &BTreeMap<&'static str, usize>,
    timing_s: BTreeMap<String, f64>,
    pitch_mm: f64,
) -> Design {
    let range = judgement.depths_mm;
    // Where the board is not known, no depth is.
    let board = range.map(|_| [judgement.view.depth_mm; 2]);
    let half = |k: usize| HalfEntry {
        corners: corners(&[&judgement.detected[k]]),
        pinhole: pinhole(&judgement.halves[k], judgement.centres[k].as_ref(), pitch_mm, range),
    };
    let stereo = &judgement.stereo;
    let [rectified_rms, rectified_max] = to::rectified(&stereo.rectified, board);
    let raw = to::stereo(&stereo.disparity, board, &stereo.epipolar, &stereo.depth_law, range);
    Design {
        name: name.to_owned(),
        halves: Halves { left: half(0), right: half(1) },
        stereo: Stereo {
            rectified_vertical_disparity_rms_px: Some(rectified_rms),
            rectified_vertical_disparity_max_px: Some(rectified_max),
            ..to::with_depth_error(raw, &stereo.depth_error, board)
        },
        pinhole: pinhole(&judgement.pooled, None, pitch_mm, range),
        geometry: Some(cameras::geometry(judgement)),
        cameras: cameras::entry(judgement),
        corners: corners(&judgement.detected.each_ref()),
        fates: fates.iter().map(|(name, &n)| ((*name).to_owned(), n as u64)).collect(),
        timing_s,
        not_judged: judgement.not_judged.as_ref().map(ToString::to_string),
        not_judged_cause: judgement.not_judged.as_ref().map(|cause| cause.name().to_owned()),
        matching: None,
        board_pose: None,
        truth_light: None,
        smeared_by: Vec::new(),
        accuracy: None,
        error_budget: None,
        surface_fits: None,
    }
}

/// The entry with what was found of the board of a picture that was not made here.
pub fn of_photograph(entry: Design, found: Option<&FoundPose>) -> Design {
    Design { matching: found.and_then(board_pose::matching), board_pose: found.map(board_pose::entry), ..entry }
}

/// The entry with what is known of a picture that `system`, the instrument of `scene`, made itself: the light of its truth,
/// and what smears its edges.
pub fn of_own_picture(entry: Design, scene: &Scene, system: &System) -> Design {
    let smears =
        system.effects().acting().filter(|row| row.hook == Hook::Ray && system.effects().variants(0).len() > 1);
    Design {
        truth_light: Some(light_name(scene, system)),
        smeared_by: smears.map(|row| row.key().to_owned()).collect(),
        ..entry
    }
}

/// The entry of how accurately a picture was made.
pub fn accuracy(account: &AccuracyReport, counts: &Counts) -> AccuracyEntry {
    AccuracyEntry {
        level: account.level.name().to_owned(),
        target_px: account.target_px,
        promise_px: account.promise_px,
        achieved_px: account.achieved_px(),
        capped_pixels: counts.capped_pixels,
        noise: account.noise,
        noise_target: account.noise_target,
        unpromised_pixels: account.unpromised_pixels,
    }
}

fn pinhole(figures: &PinholeFigures, centre: Option<&CentreFigures>, pitch_mm: f64, range: Depths) -> PinholeEntry {
    let several = figures.depths.len() > 1;
    let free_of_rows: &[Parameter] = if several { &ROW_LAW } else { &ROW_LAW_AT_ONE_DEPTH };
    let (straightness_rms_px, straightness_max_px) = to::straightness(&figures.straightness);
    let depths = figures.depths.iter().map(|d| {
        let here = Some([d.depth_mm; 2]);
        Depth {
            depth_mm: d.depth_mm,
            designed: to::designed_by_corners(&d.designed, pitch_mm, here),
            fitted: to::fitted(&CENTRE_ONLY, &d.fitted, here),
            centre_drift_mm: Definition { depths_mm: here, ..Definition::mm(Normaliser::Fit, Frame::World) }
                .figure(&d.drift_mm, |d| *d),
            straightness_rms_px: to::straightness(&d.straightness).0,
        }
    });
    PinholeEntry {
        designed: to::designed_by_rays(&figures.designed),
        fitted: to::fitted(free_at(&POSE_AND_FOCAL, figures.depths.len()), &figures.fitted, range),
        anamorphic: Some(to::fitted(free_at(&POSE_AND_ANAMORPHIC, figures.depths.len()), &figures.anamorphic, range)),
        principal: Some(to::fitted(free_at(&ALL, figures.depths.len()), &figures.principal, range)),
        homography: Some(to::homography(&figures.homography, range)),
        row_law: Some(to::row_law(free_of_rows, &figures.row_law, &figures.rows_undone, range)),
        straightness_rms_px,
        straightness_max_px,
        centre: centre.map(|c| to::centre(c.designed_mm, &c.common, &c.misses)),
        depths: depths.collect(),
    }
}

fn corners(halves: &[&Detected]) -> Corners {
    let sum = |count: fn(&Detected) -> usize| halves.iter().map(|d| count(d) as u64).sum::<u64>();
    let known =
        |count: fn(&Detected) -> Option<usize>| halves.iter().map(|d| count(d).map(|n| n as u64)).sum::<Option<u64>>();
    let errors: Vec<DVec2> = halves.iter().flat_map(|d| d.errors_px.iter().copied()).collect();
    let errors = Deviation::of(&errors).ok();
    let mut rejected = BTreeMap::new();
    for (reason, n) in halves.iter().flat_map(|d| &d.rejected) {
        *rejected.entry(reason.clone()).or_insert(0) += *n as u64;
    }
    Corners {
        visible: known(|d| d.visible),
        found: sum(|d| d.found),
        partial: sum(|d| d.partial),
        spurious: known(|d| d.wrong),
        rms_error_px: errors.map(|e| e.rms),
        max_error_px: errors.map(|e| e.max),
        rejected,
    }
}
