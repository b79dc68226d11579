//! Surfaces that are clouds of points.

use super::*;

#[test]
fn clouds_keep_the_odd_powers_of_y() {
    let place = good();
    let untilted = place.built(&clouds(FRONT, BACK));
    let tilt = 0.02;
    place.write("back.csv", csv(RIGHT, |x, y| back(x, y) + tilt * y));
    let tilted = place.built(&clouds(FRONT, BACK));
    assert!(apart_mm(&untilted, &tilted) > 4.0, "a tilt of 20 mrad moves what is seen by about 5.7 mm");
    let domain = "centre_mm = [0, 0]\nscale_mm = [1, 1]\ndomain_mm = [[-1.3, 16.3], [-12.4, 12.4]]";
    let polynomial = place.built(&format!(
        "kind = \"polynomial\"\n[prism.front]\n{domain}\nterms = [[0, 0, 40], [1, 0, 0.2], [2, 0, -2e-3], [0, 2, 1e-3], \
         [3, 0, 3e-5], [1, 4, -2e-6]]\n[prism.back]\n{domain}\nterms = [[0, 0, 46], [1, 0, 1e-3], [0, 2, 2e-4], [0, 1, {tilt}]]"
    ));
    // Rounding of points near 46 mm through a fit of condition 1e3 or so.
    assert!(apart_mm(&polynomial, &tilted) < 1e-9, "{:e}", apart_mm(&polynomial, &tilted));
    // The front may be tilted as well, and a cloud that is said to be symmetric is held to it.
    place.write("front.csv", csv(RIGHT, |x, y| front(x, y, 0.01)));
    place.built(&clouds(FRONT, BACK));
    let words = place.refused(&clouds(&format!("{FRONT}, symmetric = true"), BACK));
    assert!(words.contains("`prism.front` (front.csv)") && words.contains("leave `symmetric` out"), "{words}");
    place.write("front.csv", csv(RIGHT, |x, y| front(x, y, 0.0)));
    let even = place.built(&clouds(&format!("{FRONT}, symmetric = true"), BACK));
    assert!(apart_mm(&even, &tilted) < 1e-9);
}

#[test]
fn what_a_fit_leaves_is_shown_everywhere() {
    let place = good();
    let low = clouds("file = \"front.csv\", degree = 2, max_residual_mm = 0.5", BACK);
    let scene = scene::load(&place.scene(&low)).unwrap();
    let rough = built(&scene);
    let right = place.built(&clouds(FRONT, BACK));
    place.scene(&low);
    let check = place.run(&["check", "scene.toml"]);
    assert!(check.status.success());
    let words = said(&check.stdout);
    assert!(
        words.contains("fit     front: degree 2 through 437 points leaves RMS") && words.contains("fit     back"),
        "{words}"
    );
    let json: Value = serde_json::from_slice(&place.run(&["check", "scene.toml", "--json"]).stdout).unwrap();
    let fit = &json["surface_fits"]["front"];
    let number = |key: &str| fit[key].as_f64().unwrap_or_else(|| panic!("{key}: {fit}"));
    assert!(number("max_mm") > number("rms_mm") && number("rms_mm") > 1e-3 && number("max_px") > 0.0);
    // Where the worst point is, the fit is off by the largest residual.
    let worst = fit["worst_mm"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect::<Vec<_>>();
    assert!((worst[2] - front(worst[0], worst[1], 0.0)).abs() < 1e-12);
    // What two degrees more would move is about what the right degree moves.
    let moved = (0..192).map(|k| DVec2::new(0.5 + f64::from(k % 16) * 6.0, 0.5 + f64::from(k / 16) * 6.5)).fold(
        0.0,
        |worst: f64, px| {
            let Ok(here) = rough.footprint(px) else { return worst };
            let there = right.footprint(px).unwrap().sight.board_mm;
            worst.max((here.jacobian.inverse() * (there - here.sight.board_mm)).length())
        },
    );
    let ratio = number("finer_px") / moved;
    assert!(moved > 0.1 && ratio > 0.3 && ratio < 3.0, "{moved} {}", number("finer_px"));
    let render = place.run(&["render", "scene.toml", "--out", "a.png", "--out", "a.exr"]);
    assert!(said(&render.stderr).contains("fit of the front: degree 2"), "{}", said(&render.stderr));
    let measure = place.run(&["measure", "a.exr", "--scene", "scene.toml", "--json"]);
    let report: Value = serde_json::from_slice(&measure.stdout).unwrap_or_else(|_| panic!("{}", said(&measure.stderr)));
    assert_eq!(report["designs"][0]["surface_fits"]["front"]["max_mm"], fit["max_mm"]);
}

/// A sag that is higher by r moves what is seen by `max_px` of a residual of r.
#[test]
fn the_px_of_a_sag_are_those_of_the_ray() {
    let place = good();
    let system = place.built(&clouds(FRONT, BACK));
    let scene = scene::load(&place.path().join("scene.toml")).unwrap();
    let [front, _] = biprism::analysis::fit_shift::fit_shifts(&scene, &system).unwrap();
    let at = front.residuals.worst_mm;
    place.write("front.csv", csv(RIGHT, |x, y| self::front(x, y, 0.0) + 0.01));
    let raised = place.built(&clouds(FRONT, BACK));
    let px = (0..96 * 80).map(|k| DVec2::new(0.5 + f64::from(k % 96), 0.5 + f64::from(k / 96)));
    let near = px.min_by(|a, b| {
        let far = |px: &DVec2| system.path(*px).0.points[0].truncate().abs().distance(DVec2::new(at.x, at.y.abs()));
        far(a).total_cmp(&far(b))
    });
    let here = system.footprint(near.unwrap()).unwrap();
    let moved =
        (here.jacobian.inverse() * (raised.trace(near.unwrap()).unwrap().board_mm - here.sight.board_mm)).length();
    let told = front.px_per_mm.unwrap() * 0.01;
    // The grid of rays is 1/20 of the picture, over which the deviation changes by a few percent.
    assert!((told / moved - 1.0).abs() < 0.2, "{told} {moved}");
}

#[test]
fn clouds_that_do_not_fit_are_refused_with_what_is_wrong() {
    let place = good();
    // A degree that is too low.
    let words = place.refused(&clouds("file = \"front.csv\", degree = 2", BACK));
    assert!(
        words.contains("lies") && words.contains("`max_residual_mm` is 0.001") && words.contains("write `degree = 5`"),
        "{words}"
    );
    // Two points far off, by their numbers and places.
    let text = csv(RIGHT, |x, y| front(x, y, 0.0));
    let spoilt: Vec<String> = text
        .lines()
        .enumerate()
        .map(|(k, line)| {
            let [x, y, z] = [0, 1, 2].map(|i| line.split(',').nth(i).unwrap().to_owned());
            match k {
                100 => format!("{x},{y},{}", z.parse::<f64>().unwrap() + 0.05),
                200 => format!("{x},{y},900"),
                _ => line.to_owned(),
            }
        })
        .collect();
    place.write("spoilt.csv", spoilt.join("\n"));
    let words = place.refused(&clouds("file = \"spoilt.csv\", degree = 5", BACK));
    assert!(
        words.contains("without 2 outliers the rest leaves")
            && words.contains("mm: point 200 at")
            && words.contains("point 100 at"),
        "{words}"
    );
    assert!(words.contains("remove them from the file, or write `max_residual_mm = "), "{words}");
    // Noise has no cure but a larger tolerance, and what is offered is enough.
    let noise = |x: f64, y: f64| 0.05 * (1e4 * libm::sin(12.9898 * x + 78.233 * y)).fract();
    place.write("noisy.csv", csv(RIGHT, |x, y| front(x, y, 0.0) + noise(x, y)));
    let words = place.refused(&clouds("file = \"noisy.csv\", degree = 5", BACK));
    let offered =
        words.split("`max_residual_mm = ").nth(1).unwrap_or_else(|| panic!("{words}")).split('`').next().unwrap();
    place.built(&clouds(&format!("file = \"noisy.csv\", degree = 5, max_residual_mm = {offered}"), BACK));
    // Both facets, and a ridge somewhere else.
    place.write("whole.csv", csv([-16.0, 16.0], |x, y| front(x.abs(), y, 0.0)));
    let words = place.refused(&clouds("file = \"whole.csv\", degree = 5", BACK));
    assert!(words.contains("kink at x = 0") && words.contains("the right half only"), "{words}");
    place.write("whole.csv", csv([0.0, 32.0], |x, y| front((x - 15.0).abs(), y, 0.0)));
    let words = place.refused(&clouds("file = \"whole.csv\", degree = 5", BACK));
    assert!(words.contains("a kink near x = 15") && words.contains("`offset_mm = [-15"), "{words}");
    // Front and back in one file.
    let both = csv(RIGHT, |x, y| front(x, y, 0.0)) + csv(RIGHT, back).trim_start_matches("x,y,z\n");
    place.write("both.csv", both);
    let words = place.refused(&clouds("file = \"both.csv\", degree = 5", BACK));
    assert!(words.contains("two sheets") && words.contains("a file each"), "{words}");
}

#[test]
fn units_and_frames_of_a_cloud_are_brought_to_the_prism() {
    let place = good();
    let plain = place.built(&clouds(FRONT, BACK));
    let moved = |name: &str, key: &str, change: &dyn Fn(DVec3) -> DVec3| {
        let text = points(RIGHT).map(|p| change(p.extend(front(p.x, p.y, 0.0))));
        place.write(name, text.fold("x,y,z\n".to_owned(), |t, p| t + &format!("{:?},{:?},{:?}\n", p.x, p.y, p.z)));
        let same = place.built(&clouds(&format!("file = \"{name}\", degree = 5, {key}"), BACK));
        let apart = apart_mm(&plain, &same);
        assert!(apart < 1e-8, "{key}: {apart:e}");
    };
    moved("m.csv", "unit = \"m\"", &|p| p / 1000.0);
    moved("um.csv", "unit = \"um\"", &|p| p * 1000.0);
    moved("in.csv", "unit = \"in\"", &|p| p / 25.4);
    moved("vertex.csv", "offset_mm = [0, 0, 40]", &|p| p - DVec3::Z * 40.0);
    moved("left.csv", "flip = \"x\"", &|p| DVec3::new(-p.x, p.y, p.z));
    // Lens programs count sag towards the camera, each from its vertex, some in metres.
    moved("z.csv", "unit = \"m\", flip = [\"z\"], offset_mm = [0, 0, 40]", &|p| {
        DVec3::new(p.x, p.y, 40.0 - p.z) / 1000.0
    });
    // The pose comes last: tilted about the origin of the surface, then moved.
    let pose = biprism::geom::Pose::new(DVec3::new(0.5, -1.0, 40.0), DVec3::new(0.0, 0.0, 0.1));
    moved(
        "pose.csv",
        &format!(
            "flip = \"y\", offset_mm = [0, 0, -2], pose = {{ position_mm = [0.5, -1, 40], tilt_deg = [0, 0, {:?}] }}",
            0.1f64.to_degrees()
        ),
        &|p| {
            let own = pose.inverse().point(p) + DVec3::Z * 2.0;
            DVec3::new(own.x, -own.y, own.z)
        },
    );
}
