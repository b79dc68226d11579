//! The parts of an instrument and their checksums.

use super::checksum::Checksum;
use super::effects;
use crate::geom::{Pose, Rect};
use crate::scene::{
    BiprismSpec, BoardSpec, CalibrationSpec, CameraSpec, CloudSpec, DesignSettings, GlassSpec, MarchOrder, MeshSpec,
    Method, PointCloudSpec, PolynomialPatch, PolynomialSpec, PrismSpec, Scene,
};
use crate::surface::mesh::{Normals, Triangles};
use crate::system::System;
use serde_json::{Map, Value};

/// What the truth of a picture depends on: for each part of the scene and of the `system` built from it, its name and its
/// checksum, in hexadecimal. Of effects those count that are kept.
pub fn parts(scene: &Scene, system: &System) -> Map<String, Value> {
    let part = |name: &str, sum: String| (name.to_owned(), Value::from(sum));
    [
        part("camera", Checksum::of(|values| camera(values, &scene.camera))),
        part("prism", Checksum::of(|values| prism(values, &scene.prism))),
        part("board", Checksum::of(|values| board(values, &scene.board))),
        part("effects", Checksum::of(|values| effects::add(values, system.effects()))),
    ]
    .into_iter()
    .collect()
}

/// The parts that are not those of `said`, by name.
pub fn others(scene: &Scene, system: &System, said: &Value) -> Vec<String> {
    parts(scene, system).into_iter().filter(|(name, sum)| said[name] != *sum).map(|(name, _)| name).collect()
}

// Every field of a type is named once, so that a new one is not forgotten.

fn camera(values: &mut Checksum, camera: &CameraSpec) {
    let &CameraSpec { position_mm, focal_length_mm, width_px, height_px, pitch_mm, calibration } = camera;
    values.point(position_mm);
    values.number(focal_length_mm);
    values.count(width_px);
    values.count(height_px);
    values.number(pitch_mm);
    // A plain pinhole says nothing of it, and keeps the checksum that it has had.
    if camera.calibrated().is_some() {
        let CalibrationSpec { principal_px: _, rotation, distortion, focal_ratio } = calibration;
        values.plane_point(camera.principal_px());
        values.numbers(rotation.to_cols_array());
        values.numbers(distortion.coefficients());
        values.number(focal_ratio);
    }
}

fn board(values: &mut Checksum, board: &BoardSpec) {
    let &BoardSpec { columns, rows, square_mm, margin_mm, world_from_board, black, white, background } = board;
    values.count(columns);
    values.count(rows);
    values.numbers([square_mm, margin_mm, black, white, background]);
    pose(values, &world_from_board);
}

fn prism(values: &mut Checksum, prism: &PrismSpec) {
    values.word(prism.kind());
    match prism {
        PrismSpec::None => {}
        PrismSpec::Flat(flat) => biprism(values, flat),
        PrismSpec::Freeform(flat, settings) => {
            biprism(values, flat);
            design(values, settings);
        }
        PrismSpec::Polynomial(PolynomialSpec { body, front, back }) => {
            glass(values, body);
            [front, back].into_iter().for_each(|surface| patch(values, surface));
        }
        PrismSpec::PointCloud(PointCloudSpec { body, front, back }) => {
            glass(values, body);
            // How much a fit may leave, and what a file is called, change no instrument that is made.
            for CloudSpec { points_mm, degree, symmetric, max_residual_mm: _, file: _ } in [front, back] {
                values.list(points_mm, |values, point| values.point(*point));
                values.count(*degree);
                values.count(usize::from(*symmetric));
            }
        }
        PrismSpec::Mesh(MeshSpec { body, front, back, normals, left, told: _ }) => {
            glass(values, body);
            values.word(match normals {
                Normals::Flat => "flat",
                Normals::Smooth => "smooth",
            });
            for Triangles { points_mm, point_normals, triangles } in
                [front, back].into_iter().chain(left.iter().flatten())
            {
                values.list(points_mm, |values, point| values.point(*point));
                values.list(point_normals, |values, normal| values.point(*normal));
                values.list(triangles, |values, corners| values.numbers(corners.map(f64::from)));
            }
        }
    }
}

fn biprism(values: &mut Checksum, flat: &BiprismSpec) {
    let BiprismSpec { body, ridge_distance_mm, thickness_mm, facet_angle_rad } = flat;
    glass(values, body);
    values.numbers([*ridge_distance_mm, *thickness_mm]);
    values.option(*facet_angle_rad, Checksum::number);
}

fn glass(values: &mut Checksum, body: &GlassSpec) {
    let GlassSpec { index, outer_index, glass, wavelength_nm, world_from_prism } = body;
    values.numbers([*index, *outer_index, *wavelength_nm]);
    values.option(*glass, |values, material| values.word(material.name));
    pose(values, world_from_prism);
}

fn design(values: &mut Checksum, settings: &DesignSettings) {
    let DesignSettings { order, degree, method, step_px } = settings;
    values.word(match order {
        MarchOrder::XThenY => "x_then_y",
        MarchOrder::YThenX => "y_then_x",
    });
    values.word(match method {
        Method::Euler => "euler",
        Method::Midpoint => "midpoint",
        Method::Rk4 => "rk4",
    });
    values.count(*degree);
    values.number(*step_px);
}

fn patch(values: &mut Checksum, patch: &PolynomialPatch) {
    let PolynomialPatch { sag, domain: Rect { min, max } } = patch;
    values.polynomial(sag);
    values.plane_point(*min);
    values.plane_point(*max);
}

fn pose(values: &mut Checksum, pose: &Pose) {
    let Pose { rotation, translation_mm } = pose;
    values.numbers(rotation.to_cols_array());
    values.point(*translation_mm);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{scene, system};

    fn sums(text: &str) -> Map<String, Value> {
        let scene = scene::parse(text, "test", None).unwrap_or_else(|problem| panic!("{problem}\n{text}"));
        parts(&scene, &system::build(&scene).unwrap())
    }

    const SCENE: &str = "name = \"test\"\n[camera]\nfocal_length_mm = 35.0\nwidth_px = 48\nheight_px = 30\n\
        pixel_pitch_um = 220.0\n[prism]\nkind = \"freeform\"\nindex = 1.48\nridge_distance_mm = 78.472\n\
        thickness_mm = 8.545\n[board]\ncolumns = 41\nrows = 41\nsquare_mm = 10.0\nposition_mm = [0.0, 0.0, 1000.0]\n";

    /// Pictures keep their identity from version to version: neither a renamed type nor a moved field may change it.
    #[test]
    fn checksums_are_those_of_earlier_versions() {
        let effects = "[effect.thin_lens]\nf_number = 8.0\nfocus_mm = 990.0\n[effect.cos4]\n[effect.fresnel]\n\
            [effect.sensor]\nwhite_e = 5000.0\nseed = 7\n[effect.clipping]\nchamfer_mm = 0.2\n";
        let told = serde_json::to_string(&sums(&format!("{SCENE}{effects}"))).unwrap();
        let sums = [
            r#""camera":"32de115be9f41af6""#,
            r#""prism":"ca17ae0be3fa70d8""#,
            r#""board":"fde61d3554b3e3a6""#,
            r#""effects":"321b9c6fa1bf2168""#,
        ];
        assert_eq!(told, format!("{{{}}}", sums.join(",")));
    }

    #[test]
    fn each_part_stands_for_itself() {
        let own = sums(SCENE);
        for (part, from, to) in [
            ("camera", "width_px = 48", "width_px = 50"),
            ("prism", "index = 1.48", "index = 1.4801"),
            ("prism", "kind = \"freeform\"", "kind = \"flat\""),
            ("prism", "[board]", "[prism.design]\norder = \"y-then-x\"\n[board]"),
            ("board", "columns = 41", "columns = 43"),
            ("effects", "[board]", "[effect.cos4]\n[board]"),
            ("effects", "[board]", "[effect.manufacture.back]\ntilt_deg = [0.1, 0.0, 0.0]\n[board]"),
        ] {
            let changed = sums(&SCENE.replace(from, to));
            let other: Vec<_> = own.keys().filter(|name| own[*name] != changed[*name]).collect();
            assert_eq!(other, [part], "{to}");
        }
    }
}
