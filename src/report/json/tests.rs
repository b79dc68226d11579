use super::*;
use crate::metrics::{Deviation, MeasuredAndTrue, Pair, Unmeasurable, epipolar, reprojection, stereo, straightness};
use glam::DVec2;
use serde_json::json;
use std::collections::BTreeMap;
use std::path::Path;

fn deviation(error: f64) -> MeasuredAndTrue<Deviation> {
    MeasuredAndTrue::of(Some(vec![DVec2::new(error, -2.0 * error)]), Some(vec![DVec2::splat(error)]), |e| {
        Deviation::of(&e)
    })
}

/// A report read back; where not, the place and the rule.
fn from_text(text: &str) -> Result<Report, (usize, String)> {
    serde_json::from_str(text).map_err(|error| (error.line(), error.to_string()))
}

fn pinhole() -> PinholeEntry {
    let no_rows = MeasuredAndTrue::of(Some([]), None, |c| {
        straightness::straightness(&c, straightness::StraightnessReference::Chord)
    });
    let (straightness_rms_px, straightness_max_px) = judgement::straightness(&no_rows);
    let designed = judgement::designed_by_corners(&deviation(2.0), 0.005, Some([500.0; 2]));
    let fitted = judgement::fitted(&reprojection::POSE, &deviation(0.125), None);
    let centre = judgement::centre(glam::DVec3::ZERO, &MeasuredAndTrue::NEITHER, &MeasuredAndTrue::NEITHER);
    let depth = Depth {
        depth_mm: 500.0,
        designed: designed.clone(),
        fitted: fitted.clone(),
        centre_drift_mm: Definition::mm(Normaliser::Fit, Frame::World)
            .figure(&MeasuredAndTrue::NEITHER, |d: &(f64, usize)| *d),
        straightness_rms_px: straightness_rms_px.clone(),
    };
    PinholeEntry {
        designed,
        anamorphic: Some(fitted.clone()),
        principal: Some(fitted.clone()),
        homography: Some(fitted.clone()),
        row_law: Some(judgement::row_law(&[], &MeasuredAndTrue::NEITHER, &MeasuredAndTrue::NEITHER, None)),
        fitted,
        straightness_rms_px,
        straightness_max_px,
        centre: Some(centre),
        depths: vec![depth],
    }
}

fn report() -> Report {
    let pair = Pair { index: [0, 0], left_px: DVec2::new(9.0, 5.0), right_px: DVec2::new(7.0, 5.25) };
    let disparity = MeasuredAndTrue::of(Some([pair]), None, |p| stereo::disparity(&p));
    let curves = vec![vec![DVec2::ZERO, DVec2::new(10.0, 1.0), DVec2::new(20.0, 2.0)]];
    let epipolar = MeasuredAndTrue::of(None, Some(curves), |c| epipolar::summary(&c, 960.0));
    let corners =
        Corners { visible: Some(4), found: 3, spurious: Some(0), rms_error_px: Some(0.5), ..Corners::default() };
    let half = HalfEntry { corners: corners.clone(), pinhole: pinhole() };
    let design = Design {
        name: "freeform".to_owned(),
        halves: Halves { left: half.clone(), right: half },
        stereo: judgement::stereo(
            &disparity,
            Some([1000.0; 2]),
            &epipolar,
            &MeasuredAndTrue::NEITHER,
            Some([500.0, 2000.0]),
        ),
        pinhole: pinhole(),
        geometry: Some(judgement::geometry(&MeasuredAndTrue::NEITHER, Some([500.0, 2000.0]))),
        cameras: None,
        corners,
        fates: BTreeMap::from([("ok".to_owned(), 7)]),
        timing_s: BTreeMap::from([("render".to_owned(), 1.5)]),
        not_judged: None,
        not_judged_cause: None,
        matching: None,
        board_pose: None,
        truth_light: None,
        smeared_by: Vec::new(),
        accuracy: None,
        error_budget: None,
        surface_fits: None,
    };
    Report { schema: SchemaName::V1, scene: "paper".to_owned(), designs: vec![design] }
}

/// The contract as it was promised: every key, spelled out.
#[test]
fn keys_of_the_contract_stand_where_they_were_promised() {
    let value: Value = serde_json::from_str(&to_text(&report())).unwrap();
    assert_eq!(value["schema"], "biprism-report/1");
    assert_eq!(value["scene"], "paper");
    let design = &value["designs"][0];
    assert_eq!(design["name"], "freeform");
    for path in [
        "/stereo/vertical_disparity_rms_px",
        "/stereo/vertical_disparity_max_px",
        "/stereo/epipolar_slope_max_rad",
        "/stereo/epipolar_departure_rms_px",
        "/pinhole/designed/mean_abs_h_mm",
        "/pinhole/designed/mean_abs_v_mm",
        "/pinhole/designed/rms_px",
        "/pinhole/fitted/rms_px",
        "/pinhole/straightness_rms_px",
    ] {
        for key in ["measured", "true", "n", "unit", "normaliser", "frame", "pixel_centre"] {
            assert!(design.pointer(&format!("{path}/{key}")).is_some(), "{path}/{key}");
        }
    }
    for path in ["/halves/left", "/halves/right", "/fates", "/timing_s"] {
        assert!(design.pointer(path).is_some_and(Value::is_object), "{path}");
    }
    let corners = &design["corners"];
    assert_eq!(
        *corners,
        json!({"visible": 4, "found": 3, "partial": 0, "false": 0, "rms_error_px": 0.5, "max_error_px": null})
    );
}

#[test]
fn a_figure_says_what_it_is_and_why_it_is_not() {
    let design = &report().designs[0];
    let figure = serde_json::to_value(&design.stereo.vertical_disparity_mean_px).unwrap();
    let expected = json!({
        "measured": -0.25, "true": null, "n": 1, "n_true": 0, "unit": "px", "normaliser": "sum e / N",
        "frame": "raw half image", "pixel_centre": "(i + 0.5, j + 0.5)", "depths_mm": [1000.0, 1000.0],
    });
    assert_eq!(figure, expected);
    let slope = &design.stereo.epipolar_slope_max_rad;
    assert_eq!((slope.measured, slope.n, slope.n_true), (None, 1, 1));
    assert!((slope.exact.unwrap() - libm::atan(0.1)).abs() < 1e-15);
    let reason = design.pinhole.straightness_rms_px.reason.as_deref();
    assert_eq!(reason, Some("too few rows of 3 corners: 0, and at least 1 needed"));
    let infinite =
        MeasuredAndTrue { measured: Some(Ok(f64::INFINITY)), exact: Some(Err(Unmeasurable::Degenerate("flat"))) };
    let figure = Definition::px(Normaliser::Max).figure(&infinite, |v| (*v, 2));
    assert_eq!((figure.measured, figure.exact), (None, None));
    assert_eq!(figure.reason.as_deref(), Some("measured: its value is inf; true: flat"));
}

/// Horizontal is x and vertical is y, in mm and in px, in figures by rays and by corners.
#[test]
fn horizontal_and_vertical_keep_their_places() {
    let both =
        MeasuredAndTrue::of(Some(vec![DVec2::new(3.0, -0.5), DVec2::new(-1.0, 0.25)]), None, |e| Deviation::of(&e));
    let by_corners = judgement::designed_by_corners(&both, 0.005, None);
    let plane = both.then(|px| {
        let mm = px.scaled(0.25);
        Ok(crate::metrics::ray_bundle::PlaneDeviation { plane_z_mm: -35.0, residuals_mm: vec![], mm, px: *px })
    });
    let by_rays = judgement::designed_by_rays(&plane);
    for (designed, mm) in [(by_corners, 0.005), (by_rays, 0.25)] {
        let [h, v] = [&designed.mean_abs_h_px, &designed.mean_abs_v_px].map(|figure| figure.measured.unwrap());
        assert_eq!([h, v], [2.0, 0.375]);
        let [h, v] = [&designed.mean_abs_h_mm, &designed.mean_abs_v_mm].map(|figure| figure.measured.unwrap());
        assert_eq!([h, v], [2.0 * mm, 0.375 * mm]);
    }
}

#[test]
fn two_halves_pool_only_where_both_have_a_value() {
    let (one, bad) = (Some(Ok(1)), Some(Err(Unmeasurable::Degenerate("flat"))));
    let sum = |a: &i32, b: &i32| Ok(a + b);
    let pooled =
        MeasuredAndTrue { measured: one, exact: one }.with(&MeasuredAndTrue { measured: one, exact: bad }, sum);
    assert_eq!(pooled, MeasuredAndTrue { measured: Some(Ok(2)), exact: bad });
    assert_eq!(
        MeasuredAndTrue { measured: bad, exact: None }.with(&MeasuredAndTrue::NEITHER, sum),
        MeasuredAndTrue { measured: bad, exact: None }
    );
}

fn figure_values(figure: &mut Figure, value: f64) {
    (figure.measured, figure.exact) = (Some(libm::sin(value)), Some(libm::exp(-30.0 * value)));
}

#[test]
fn a_report_reads_back_as_it_was_written() {
    let mut report = report();
    // Values of every last bit, not only the round ones above.
    let figure = &mut report.designs[0].stereo.vertical_disparity_rms_px;
    for k in 1..1000 {
        figure_values(figure, 1.0 / f64::from(k));
        let text = serde_json::to_string(figure).unwrap();
        assert_eq!(serde_json::from_str::<Figure>(&text).unwrap(), *figure);
    }
    assert_eq!(from_text(&to_text(&report)).unwrap(), report);
}

#[test]
fn a_strange_report_is_refused_with_its_line() {
    let text = to_text(&report());
    let refused = |text: &str| from_text(text).map(|_| ()).unwrap_err();
    let (line, why) = refused(&text.replace("\"fates\"", "\"fatse\""));
    assert!(line > 1 && why.contains("fatse"), "{line}: {why}");
    assert!(refused(&text.replace("biprism-report/1", "biprism-report/2")).1.contains("biprism-report/2"));
    assert!(refused(&text[..200]).1.contains("EOF"));
    assert!(refused(&text.replace("-0.25", "NaN")).1.contains("expected value"));
}

#[test]
fn paths_find_numbers_and_say_where_they_end() {
    let r = report();
    assert_eq!(number_at(&r, "freeform/stereo/vertical_disparity_rms_px"), Ok(0.25));
    assert_eq!(number_at(&r, "freeform/pinhole/designed/mean_abs_v_mm"), Ok(0.02));
    assert_eq!(number_at(&r, "freeform/pinhole/designed/mean_abs_v_mm/true"), Ok(0.01));
    assert_eq!(number_at(&r, "freeform/pinhole/depths/0/depth_mm"), Ok(500.0));
    assert_eq!(number_at(&r, "freeform/corners/false"), Ok(0.0));
    let why = |path| number_at(&r, path).unwrap_err();
    assert!(why("flat/corners/found").contains("there is freeform"));
    assert!(why("freeform/corners/fuond").contains("visible, found, partial, false"));
    assert!(why("freeform/stereo/epipolar_slope_max_rad").contains("/true"));
    assert!(why("freeform/pinhole/straightness_rms_px").contains("rows of 3 corners: 0"));
    assert!(why("freeform/corners/max_error_px").contains("null"));
    assert!(why("freeform/pinhole").contains("designed"));
    assert!(why("freeform/pinhole/depths/1/depth_mm").contains("a list of 1"));
    assert!(why("").contains("there is no design"));
}

/// `UPDATE_SCHEMA=1 cargo test --release --lib shipped_schema` writes it anew.
#[test]
fn shipped_schema_is_current() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("schemas/report.schema.json");
    if std::env::var_os("UPDATE_SCHEMA").is_some() && std::env::var_os("CI").is_none() {
        std::fs::write(&path, schema_json()).unwrap();
    }
    assert_eq!(std::fs::read_to_string(path).unwrap(), schema_json(), "UPDATE_SCHEMA=1 writes the schema anew");
}

/// The part of JSON Schema that ours uses; anything else is an error, so nothing is passed over.
fn validate(schema: &Value, root: &Value, value: &Value, at: &str) -> Result<(), String> {
    let fail = |why: &str| Err(format!("{at}: {why}"));
    for (keyword, rule) in schema.as_object().ok_or("a schema is an object")? {
        match keyword.as_str() {
            "$ref" => {
                let target = rule.as_str().and_then(|r| root.pointer(r.trim_start_matches('#')));
                validate(target.ok_or("a dangling reference")?, root, value, at)?;
            }
            "type" => {
                let is = |t: &Value| match t.as_str() {
                    Some("object") => value.is_object(),
                    Some("array") => value.is_array(),
                    Some("string") => value.is_string(),
                    Some("number") => value.is_number(),
                    Some("integer") => value.is_u64(),
                    Some("null") => value.is_null(),
                    _ => false,
                };
                if !rule.as_array().map_or_else(|| is(rule), |types| types.iter().any(is)) {
                    return fail(&format!("{value} is not {rule}"));
                }
            }
            "required" => {
                for key in rule.as_array().into_iter().flatten().filter_map(Value::as_str) {
                    if value.is_object() && value.get(key).is_none() {
                        return fail(&format!("no {key}"));
                    }
                }
            }
            "properties" => {
                for (key, child) in value.as_object().into_iter().flatten() {
                    match rule.get(key) {
                        Some(rule) => validate(rule, root, child, &format!("{at}/{key}"))?,
                        None => return fail(&format!("{key} is unknown")),
                    }
                }
            }
            "additionalProperties" if rule.is_object() => {
                for (key, child) in value.as_object().into_iter().flatten() {
                    validate(rule, root, child, &format!("{at}/{key}"))?;
                }
            }
            "items" => {
                for child in value.as_array().into_iter().flatten() {
                    validate(rule, root, child, at)?;
                }
            }
            "const" if rule != value => return fail(&format!("{value} is not {rule}")),
            "enum" if !rule.as_array().is_some_and(|a| a.contains(value)) => return fail(&format!("{value}")),
            "oneOf" | "anyOf" => {
                let fits = |s: &&Value| validate(s, root, value, at).is_ok();
                if rule.as_array().is_none_or(|a| a.iter().filter(fits).count() != 1) {
                    return fail(&format!("{value} is none of {keyword}"));
                }
            }
            "minItems" if value.as_array().is_some_and(|a| rule.as_u64() > Some(a.len() as u64)) => {
                return fail(&format!("{value} is shorter than {rule}"));
            }
            "maxItems" if value.as_array().is_some_and(|a| rule.as_u64() < Some(a.len() as u64)) => {
                return fail(&format!("{value} is longer than {rule}"));
            }
            "minimum" if value.as_f64().is_some_and(|v| rule.as_f64() > Some(v)) => {
                return fail(&format!("{value} is below {rule}"));
            }
            "minItems" | "maxItems" | "minimum" => {}
            "additionalProperties" if *rule == json!(false) => {}
            "const" | "enum" | "$schema" | "$defs" | "title" | "description" | "default" | "format" => {}
            other => return fail(&format!("keyword {other} is not judged by this test")),
        }
    }
    Ok(())
}

#[test]
fn schema_accepts_what_is_written_and_nothing_else() {
    let schema: Value = serde_json::from_str(&schema_json()).unwrap();
    let good = serde_json::to_value(report()).unwrap();
    validate(&schema, &schema, &good, "").unwrap();
    let broken = |path: &str, key: &str, new: Option<Value>| {
        let mut bad = good.clone();
        let place = bad.pointer_mut(path).and_then(Value::as_object_mut).unwrap();
        match new {
            Some(new) => place.insert(key.to_owned(), new),
            None => place.shift_remove(key),
        };
        validate(&schema, &schema, &bad, "").is_err()
    };
    let figure = "/designs/0/stereo/vertical_disparity_rms_px";
    assert!(broken("", "schema", Some(json!("biprism-report/2"))));
    assert!(broken("/designs/0", "stereo", None));
    assert!(broken(figure, "measured", None), "a null must be written, so that scripts need not guess");
    assert!(broken(figure, "unit", Some(json!("pixels"))));
    assert!(broken(figure, "true", Some(json!("0.1"))));
    assert!(broken(figure, "depths_mm", Some(json!([500.0]))));
    assert!(broken(figure, "valeu", Some(json!(0.1))));
    assert!(broken("/designs/0/corners", "found", Some(json!(-1))));
    // Every object of fixed keys is closed.
    let objects = schema["$defs"].as_object().unwrap().values().filter(|d| d.get("properties").is_some());
    assert!(objects.chain([&schema]).all(|d| d["additionalProperties"] == json!(false)));
}
