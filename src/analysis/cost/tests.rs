use super::*;
use crate::accuracy::Level;
use crate::{scene, system};

/// Half the paper's field, on pixels small enough that few of them have to be divided often.
fn study() -> CostStudy {
    let text = "name = \"small\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = 256\nheight_px = 144\n\
         pixel_pitch_um = 20.625\n[prism]\nkind = \"freeform\"\nindex = 1.48\nridge_distance_mm = 78.472\n\
         thickness_mm = 8.545\n[board]\ncolumns = 41\nrows = 41\nsquare_mm = 10.0\nposition_mm = [0.0, 0.0, 1000.0]\n";
    let scene = scene::parse(text, "test", None).expect("a right scene");
    let system = system::build(&scene).expect("it can be built");
    let settings = CostSettings {
        repetitions: 1,
        patience_s: 1.0,
        levels: Level::ALL.to_vec(),
        bends_px: vec![1e-2, 1e-4],
        supersampling: vec![1, 4],
        steps_um: vec![165.0, 20.625],
        degrees: vec![3, 5],
        triangles: vec![2_000, 20_000],
        pupil_points: vec![8, 64],
        pupil_reference: 256,
        mesh_triangles: Some(8),
    };
    cost(&scene, &system, &settings, &())
}

/// No time is judged here, only what the times are set against.
#[test]
fn the_study_tells_better_settings_from_worse() {
    let study = study();
    let of = |knob: &str| study.pictures.iter().filter(|s| s.knob == knob).collect::<Vec<_>>();
    let levels = of("level");
    assert_eq!(levels.len(), 4);
    for setting in &levels {
        let account = setting.account.expect("levels give account");
        let (lines, corners) = (setting.lines_px.expect("lines"), setting.corners_px.expect("corners"));
        assert!(lines.max <= account.promise_px + 1e-6 && lines.n > 1000, "{setting:?}");
        assert!(corners.max <= account.promise_px + 1e-9 && corners.n == study.corners, "{setting:?}");
        assert!(setting.time_ms.min > 0.0 && setting.rmse < 1e-2, "{setting:?}");
        // Two settings that show nearly the same picture lead the detector to the same places; where it stops is within
        // 1e-6 px.
        let found = setting.measured.shifts_px.expect("corners are found");
        assert!(found.n > 50 && found.max <= 10.0 * account.promise_px + 2e-6, "{setting:?}");
    }
    assert_eq!(levels[3].account.map(|a| a.level), Some(Level::Reference));
    assert_eq!(levels[3].rmse, 0.0);
    for knob in ["map_degree", "patch_px, degree 3", "samples, grid", "samples, jittered"] {
        let (first, last) = (of(knob)[0], *of(knob).last().expect("some"));
        assert!(last.rmse < first.rmse, "{first:?} {last:?}");
    }
    // Point samples know nothing of a line between them: with 4 x 4, rms shifts of about 1/4/sqrt(12) = 0.07 px.
    let samples = of("samples, grid")[1].lines_px.expect("lines");
    assert!((0.02..0.15).contains(&samples.rms), "{samples:?}");

    for pair in study.meshes.chunks(2) {
        let [flat, smooth] = pair else { panic!("each size comes with both normals") };
        assert_eq!((flat.lost, smooth.lost), (0, 0));
        assert!(smooth.corners_px.expect("all met").max < flat.corners_px.expect("all met").max, "{pair:?}");
    }
    let (coarse, fine) = (&study.meshes[1], &study.meshes[3]);
    assert!(fine.corners_px.expect("all met").max < coarse.corners_px.expect("all met").max);

    // More points of a pupil and higher levels are nearer to the finer picture of the same effect.
    let points = ["thin_lens", "telecentric"].into_iter().flat_map(|lens| [(lens, "points", 2), (lens, FILLED, 2)]);
    for (effect, knob, count) in points.chain([("mesh", "level", 3)]) {
        let own: Vec<&EffectSetting> = study.effects.iter().filter(|s| s.effect == effect && s.knob == knob).collect();
        assert_eq!(own.len(), count, "{effect}, {knob}");
        let (first, last) = (own[0], own[count - 1]);
        // Eight times the points would leave a third of the error even if they were drawn at random.
        let least = if knob == "level" { 1.0 } else { 2.0 };
        assert!(least * last.rmse < first.rmse && first.time_ms.min > 0.0, "{first:?} {last:?}");
    }

    let design = |knob: &str| study.designs.iter().filter(|d| d.knob == knob).collect::<Vec<_>>();
    for knob in ["euler", "midpoint", "rk4"] {
        let (coarse, fine) = (design(knob)[0], design(knob)[1]);
        assert!(fine.optical_path_spread_mm < coarse.optical_path_spread_mm, "{coarse:?} {fine:?}");
    }
    assert_eq!((design("dormand_prince").len(), design("degree").len()), (4, 2));
    assert!(study.designs.iter().all(|d| d.axis_mean_abs_mm.is_some_and(|d| d.is_finite())));
}
