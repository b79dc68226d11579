//! What every input must survive: each body takes any bytes and may refuse them, but neither panics, nor hands on a
//! number that is none. Shared by `tests/hostile.rs` and the fuzz targets in `fuzz/`.

use biprism::design::fit::fit;
use biprism::geom::Ray;
use biprism::io::corners;
use biprism::io::mesh;
use biprism::io::point_cloud::{PointFormat, parse_points};
use biprism::scene;
use biprism::scene::PrismSpec;
use biprism::surface::closed_body::sheets;
use biprism::surface::face::Face;
use biprism::surface::mesh::{Mesh, Normals};
use biprism::system::aim::Aimer;
use biprism::system::{self, Side};
use glam::{DVec2, DVec3};
use std::io::Write;

/// A scene's text: refused with a place and a next step, or an instrument whose every ray is a number or a fate.
pub(crate) fn scene_text(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let scene = match scene::parse(text, "hostile", None) {
        Ok(scene) => scene,
        Err(problem) => {
            assert!(!problem.rule.is_empty() && !problem.help.is_empty());
            let _ = problem.render(false);
            return;
        }
    };
    // A design of millions of points is slow by right, and no matter of the text.
    if matches!(&scene.prism, PrismSpec::Freeform(_, d) if scene.camera.width_px * scene.camera.height_px > 10_000 || d.step_px < 1.0)
    {
        return;
    }
    let Ok(system) = system::build(&scene) else { return };
    let size = DVec2::new(scene.camera.width_px as f64, scene.camera.height_px as f64);
    for (i, j) in (0..5).flat_map(|j| (0..5).map(move |i| (i, j))) {
        let px = size * DVec2::new(f64::from(i), f64::from(j)) / 4.0;
        if let Ok(sight) = system.trace(px) {
            assert!(sight.board_mm.is_finite(), "{px} sees {}", sight.board_mm);
        }
    }
    let aimer = Aimer::new(&system);
    for board_mm in [DVec2::ZERO, system.board().corner_at(0.0, 0.0)] {
        for side in Side::ALL {
            if let Ok(px) = aimer.aim(board_mm, side) {
                assert!(px.is_finite(), "{board_mm} is seen at {px}");
            }
        }
    }
}

/// A picture file with the given ending: refused, or every pixel is a number.
pub(crate) fn picture(bytes: &[u8], ending: &str) {
    let mut file = tempfile::Builder::new().suffix(ending).tempfile().expect("a temporary file");
    file.write_all(bytes).expect("it is written");
    match biprism::io::read(file.path(), None) {
        Ok((picture, _)) => assert!(picture.data().iter().all(|v| v.is_finite())),
        Err(problem) => assert!(!problem.rule.is_empty() && !problem.help.is_empty()),
    }
}

/// A photograph, whose curve is stated: refused, or every pixel is a number.
#[allow(dead_code, reason = "there is no fuzz target of its own")]
pub(crate) fn photograph(bytes: &[u8]) {
    let mut file = tempfile::NamedTempFile::new().expect("a temporary file");
    file.write_all(bytes).expect("it is written");
    match biprism::io::read(file.path(), Some(biprism::raster::transfer::Transfer::Linear)) {
        Ok((picture, _)) => assert!(picture.data().iter().all(|v| v.is_finite())),
        Err(problem) => assert!(!problem.rule.is_empty() && !problem.help.is_empty()),
    }
}

/// A mesh: refused, or triangles that rays meet or miss.
pub(crate) fn mesh(bytes: &[u8], format: mesh::MeshFormat) {
    if let Ok(raw) = mesh::parse_mesh("hostile", format, bytes, bytes.len() as u64)
        && mesh::within_reach("hostile", &raw.points).is_ok()
        && let Ok(body) = sheets(&raw.points, &raw.triangles)
    {
        let fronts = [Some(&body.right), body.left.as_ref()];
        let all = fronts.into_iter().flatten().flatten();
        assert!(all.flat_map(|sheet| &sheet.point_normals).all(|n| n.is_normalized()));
    }
    match mesh::parse_triangles("hostile", format, bytes, bytes.len() as u64) {
        Ok(triangles) => {
            assert!(triangles.point_normals.iter().all(|n| n.is_normalized()));
            let aim = triangles.points_mm[triangles.triangles[0][0] as usize];
            let mesh = Mesh::new(triangles, Normals::Smooth);
            for direction in [DVec3::Z, (aim + DVec3::Z).normalize_or(DVec3::X), DVec3::new(0.6, 0.0, 0.8)] {
                let ray = Ray { origin: DVec3::ZERO, direction };
                if let Ok(met) = mesh.intersect(&ray) {
                    assert!(met.t_mm > 0.0 && !met.t_mm.is_nan(), "{}", met.t_mm);
                }
            }
        }
        Err(problem) => assert!(!problem.rule.is_empty() && !problem.help.is_empty()),
    }
}

/// The text of a file of corners: refused, or every position is a number, and what is written of it reads back.
pub(crate) fn corners(bytes: &[u8], format: corners::CornerFormat) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    match corners::parse(text, format, "hostile") {
        Ok(views) => {
            let listed = views.iter().flat_map(|view| &view.corners);
            assert!(listed.map(|corner| corner.position_px).all(|p| p.is_finite()));
            let again = corners::parse(&corners::to_text(&views, format), format, "again");
            let count = |views: &[corners::CornerView]| views.iter().map(|v| v.corners.len()).collect::<Vec<_>>();
            assert!(again.is_ok_and(|again| count(&again) == count(&views)), "what was read cannot be written");
        }
        Err(problem) => assert!(!problem.rule.is_empty() && !problem.help.is_empty()),
    }
}

/// The text of a calibration: refused, or numbers that a camera may have.
pub(crate) fn calibration(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    match biprism::io::calibration::parse(text, "hostile") {
        Ok(found) => {
            assert!(found.focal_px.is_finite() && found.focal_px.min_element() > 0.0 && found.principal_px.is_finite());
            assert!(found.distortion.iter().all(|k| k.is_finite()));
        }
        Err(problem) => assert!(!problem.rule.is_empty() && !problem.help.is_empty()),
    }
}

/// A point cloud: refused, or points that are fitted or refused.
pub(crate) fn cloud(bytes: &[u8], format: PointFormat) {
    for face in Face::ALL {
        match parse_points("hostile", format, bytes, bytes.len() as u64, face) {
            Ok(points) => {
                assert!(points.iter().all(|p| p.is_finite()));
                if points.len() <= 2000
                    && let Ok(fitted) = fit(&points, 4, None)
                {
                    assert!(fitted.rms_mm.is_finite() && fitted.patch.sag.terms().all(|t| t.2.is_finite()));
                }
            }
            Err(problem) => assert!(!problem.rule.is_empty() && !problem.help.is_empty()),
        }
    }
}
