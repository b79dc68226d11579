//! The parts of an instrument and their checksums.

use super::canonical::{Canonical, CanonicalObject, checksum_of_bits, checksums_of_columns};
use super::effects::effects;
use crate::geom::{Pose, Rect};
use crate::scene::{
    BiprismSpec, BoardSpec, CalibrationSpec, CameraSpec, CloudSpec, DesignGoal, DesignSettings, DesignedSurface,
    GlassSpec, ImageSpec, MarchOrder, MeshSpec, Method, Objective, PointCloudSpec, PolynomialPatch, PolynomialSpec,
    PrismSpec, Rear, RevolvedPatch, RevolvedSpec, Scene, TexelFilter, TextureSpec,
};
use crate::surface::mesh::{Normals, Triangles};
use crate::system::System;
use glam::DVec3;
use serde_json::{Map, Value};

/// The form of the checksums.
pub const FORM: &str = "biprism-instrument/1";

/// The form of those of a prism of triangles, whose numbers are told by the checksums of their bits.
const FORM_OF_MESHES: &str = "biprism-instrument/2";

/// The key of [`FORM`] among the parts.
const FORM_KEY: &str = "form";

/// What the truth of a picture depends on: for each part of the scene and of the `system` built from it, its name and its
/// checksum, in hexadecimal, with their [`FORM`]. Of effects those count that are kept.
pub fn parts(scene: &Scene, system: &System) -> Map<String, Value> {
    let form = (FORM_KEY.to_owned(), Value::from(form(scene)));
    let sums = texts(scene, system).map(|(name, part)| (name.to_owned(), Value::from(part.checksum())));
    std::iter::once(form).chain(sums).collect()
}

/// The form of what is told of a scene.
fn form(scene: &Scene) -> &'static str {
    if matches!(scene.prism, PrismSpec::Mesh(_)) { FORM_OF_MESHES } else { FORM }
}

/// What each part stands for.
fn texts<'a>(scene: &'a Scene, system: &'a System) -> [(&'static str, CanonicalObject<'a>); 4] {
    [
        ("camera", camera(&scene.camera)),
        ("prism", prism(&scene.prism)),
        ("board", seen(scene)),
        ("effects", effects(system.effects())),
    ]
}

/// How the instrument of a picture is to that of a scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Likeness {
    /// The same.
    Same,
    /// It has these other parts, by name.
    Others(Vec<String>),
    /// The picture tells its instrument in another form, or not at all.
    Unknown,
}

/// Whether `said`, the parts that a picture's notes give, are those of `scene` and its `system`.
pub fn likeness(scene: &Scene, system: &System, said: &Value) -> Likeness {
    if ![FORM, FORM_OF_MESHES].iter().any(|form| said[FORM_KEY] == *form) {
        return Likeness::Unknown;
    }
    let differs = |(name, sum): &(String, Value)| name != FORM_KEY && said[name] != *sum;
    let mut others: Vec<String> = parts(scene, system).into_iter().filter(differs).map(|(name, _)| name).collect();

    // A prism of triangles may have been told in the form of all others once.
    if form(scene) != FORM && said[FORM_KEY] == FORM {
        others.retain(|name| name != "prism");
        return if others.is_empty() { Likeness::Unknown } else { Likeness::Others(others) };
    }
    if others.is_empty() { Likeness::Same } else { Likeness::Others(others) }
}

// Every field of a type is named once, so that a new one is not forgotten.

fn object<'a>() -> CanonicalObject<'a> {
    CanonicalObject::default()
}

fn camera<'a>(camera: &CameraSpec) -> CanonicalObject<'a> {
    let &CameraSpec { position_mm, focal_length_mm, width_px, height_px, pitch_mm, calibration } = camera;
    let plain = object()
        .with("position_mm", position_mm)
        .with("focal_length_mm", focal_length_mm)
        .with("width_px", width_px)
        .with("height_px", height_px)
        .with("pitch_mm", pitch_mm);
    // A plain pinhole says nothing of it.
    if camera.calibrated().is_none() {
        return plain;
    }
    let CalibrationSpec { principal_px: _, rotation, distortion, focal_ratio } = calibration;
    plain
        .with("principal_px", camera.principal_px())
        .with("rotation_columns", rotation.to_cols_array())
        .with("distortion", distortion.coefficients())
        .with("focal_ratio", focal_ratio)
}

fn board<'a>(board: &BoardSpec) -> CanonicalObject<'a> {
    let &BoardSpec { columns, rows, square_mm, margin_mm, world_from_board, black, white, background } = board;
    object()
        .with("columns", columns)
        .with("rows", rows)
        .with("square_mm", square_mm)
        .with("margin_mm", margin_mm)
        .with("black", black)
        .with("white", white)
        .with("background", background)
        .with("pose", pose(&world_from_board))
}

/// The board with its texture, and the objects where there are some.
fn seen<'a>(scene: &Scene) -> CanonicalObject<'a> {
    let own =
        |plate: &BoardSpec, shown: &Option<TextureSpec>| board(plate).maybe("texture", shown.as_ref().map(texture));
    let objects: Canonical<'_> = scene.objects.iter().map(|object| own(&object.plate, &object.texture)).collect();
    own(&scene.board, &scene.texture).maybe("objects", (!scene.objects.is_empty()).then_some(objects))
}

fn texture<'a>(texture: &TextureSpec) -> CanonicalObject<'a> {
    match texture {
        TextureSpec::Chart => object().with("kind", "chart"),
        TextureSpec::Noise { seed, finest_mm } => {
            object().with("kind", "noise").with("seed", *seed).with("finest_mm", *finest_mm)
        }
        TextureSpec::Image(ImageSpec { file: _, light, width_mm, filter }) => object()
            .with("kind", "image")
            .with("width_mm", *width_mm)
            .with("linear", *filter == TexelFilter::Linear)
            .with("columns", light.width())
            .with("light", checksum_of_bits(light.data().iter().map(|v| v.to_bits())).as_str()),
    }
}

fn prism(prism: &PrismSpec) -> CanonicalObject<'_> {
    // What is not solid says nothing of it.
    let kind = object().with("kind", prism.kind()).maybe("solid", prism.is_solid().then_some(true));
    match prism {
        PrismSpec::None => kind,
        PrismSpec::Flat(flat) => biprism(kind, flat),
        PrismSpec::Freeform(flat, settings) => biprism(kind, flat).with("design", design(settings)),
        PrismSpec::Polynomial(PolynomialSpec { body, front, back }) => {
            glass(kind, body).with("front", patch(front)).with("back", patch(back))
        }
        PrismSpec::Revolved(RevolvedSpec { body, front, back }) => {
            glass(kind, body).with("front", revolved(front)).with("back", revolved(back))
        }
        PrismSpec::PointCloud(PointCloudSpec { body, front, back }) => {
            glass(kind, body).with("front", cloud(front)).with("back", cloud(back))
        }
        PrismSpec::Mesh(MeshSpec { body, front, back, normals, left, told: _ }) => {
            let normals = match normals {
                Normals::Flat => "flat",
                Normals::Smooth => "smooth",
            };
            let left: Option<Canonical<'_>> = left.as_ref().map(|sheets| sheets.iter().map(triangles).collect());
            glass(kind, body)
                .with("normals", normals)
                .with("front", triangles(front))
                .with("back", triangles(back))
                .maybe("left", left)
        }
    }
}

fn cloud(cloud: &CloudSpec) -> CanonicalObject<'_> {
    // How much a fit may leave, and what a file is called, change no instrument that is made.
    let CloudSpec { points_mm, degree, symmetric, max_residual_mm: _, file: _ } = cloud;
    object().with("points_mm", Canonical::Points(points_mm)).with("degree", *degree).with("symmetric", *symmetric)
}

fn triangles(sheet: &Triangles) -> CanonicalObject<'_> {
    let Triangles { points_mm, point_normals, triangles } = sheet;
    // A zero has one sign.
    let bytes = |v: f64| (v + 0.0).to_le_bytes();
    let points = |all: &[DVec3]| checksums_of_columns(all.iter().map(|p| p.to_array().map(bytes)));
    object()
        .with("points_mm", points(points_mm).as_str())
        .with("point_normals", points(point_normals).as_str())
        .with("triangles", checksums_of_columns(triangles.iter().map(|t| t.map(u32::to_le_bytes))).as_str())
}

fn biprism<'a>(kind: CanonicalObject<'a>, flat: &BiprismSpec) -> CanonicalObject<'a> {
    let BiprismSpec { body, ridge_distance_mm, thickness_mm, facet_angle_rad } = flat;
    glass(kind, body)
        .with("ridge_distance_mm", *ridge_distance_mm)
        .with("thickness_mm", *thickness_mm)
        .maybe("facet_angle_rad", *facet_angle_rad)
}

fn glass<'a>(kind: CanonicalObject<'a>, body: &GlassSpec) -> CanonicalObject<'a> {
    // What a prism is meant to be changes nothing of its pictures.
    let GlassSpec { index, outer_index, glass, wavelength_nm, solid: _, world_from_prism, law: _ } = body;
    kind.with("index", *index)
        .with("outer_index", *outer_index)
        .with("wavelength_nm", *wavelength_nm)
        .maybe("glass", glass.map(|material| material.name))
        .with("pose", pose(world_from_prism))
}

fn design<'a>(settings: &DesignSettings) -> CanonicalObject<'a> {
    let DesignSettings { objective, surface, virtual_camera_z_mm, order, degree, method, step_px, goal } = settings;
    let objective = match objective {
        Objective::March => None,
        Objective::Epipolar => Some("epipolar"),
        Objective::ToedIn => Some("toed_in"),
        Objective::Pinhole => Some("pinhole"),
        Objective::Depth => Some("depth"),
    };
    let surface = match surface {
        DesignedSurface::Polynomial => None,
        DesignedSurface::Revolved => Some("revolved"),
    };
    let order = match order {
        MarchOrder::XThenY => "x_then_y",
        MarchOrder::YThenX => "y_then_x",
    };
    let method = match method {
        Method::Euler => "euler",
        Method::Midpoint => "midpoint",
        Method::Rk4 => "rk4",
    };
    object()
        .maybe("objective", objective)
        .maybe("surface", surface)
        .maybe("virtual_camera_z_mm", *virtual_camera_z_mm)
        .with("order", order)
        .with("method", method)
        .with("degree", *degree)
        .with("step_px", *step_px)
        .maybe("goal", (*goal != DesignGoal::default()).then(|| goal_of(goal)))
}

fn goal_of<'a>(goal: &DesignGoal) -> Canonical<'a> {
    let DesignGoal { rear, square, f_number, spot_weight, z_min_mm, depth_mm } = *goal;
    let rear = match rear {
        Rear::Own => "own",
        Rear::Even => "even",
        Rear::Flat => "flat",
    };
    object()
        .with("rear", rear)
        .with("square", square)
        .maybe("f_number", f_number)
        .with("spot_weight", spot_weight)
        .with("z_min_mm", z_min_mm)
        .with("depth_mm", depth_mm)
        .into()
}

fn patch(patch: &PolynomialPatch) -> CanonicalObject<'_> {
    let PolynomialPatch { sag, domain: Rect { min, max } } = patch;
    object().with("sag", sag).with("least_mm", *min).with("most_mm", *max)
}

fn revolved(patch: &RevolvedPatch) -> CanonicalObject<'_> {
    let RevolvedPatch { point_mm, axis, profile, azimuth_rad } = patch;
    let coefficients: Canonical<'_> = profile.coefficients().iter().copied().collect();
    object()
        .with("point_mm", *point_mm)
        .with("axis", *axis)
        .with("along_mm", profile.ends())
        .with("azimuth_rad", *azimuth_rad)
        .with("profile_mm", coefficients)
}

fn pose<'a>(pose: &Pose) -> CanonicalObject<'a> {
    let Pose { rotation, translation_mm } = pose;
    object().with("rotation_columns", rotation.to_cols_array()).with("translation_mm", *translation_mm)
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

    /// Pictures keep their identity from version to version: neither a renamed type nor a moved field may change it. The
    /// checksums are those of the texts by FNV-1a in Python.
    #[test]
    fn checksums_are_those_of_earlier_versions() {
        let effects = "[effect.thin_lens]\nf_number = 8.0\nfocus_mm = 990.0\n[effect.cos4]\n[effect.fresnel]\n\
            [effect.sensor]\nwhite_e = 5000.0\nseed = 7\n[effect.clipping]\nchamfer_mm = 0.2\n";
        let told = serde_json::to_string(&sums(&format!("{SCENE}{effects}"))).unwrap();
        let sums = [
            r#""form":"biprism-instrument/1""#,
            r#""camera":"8df46dc53a1e87b5""#,
            r#""prism":"a0804b086fd833ea""#,
            r#""board":"108aaa14c5e3cb73""#,
            r#""effects":"e74be42dff94c1c7""#,
        ];
        assert_eq!(told, format!("{{{}}}", sums.join(",")));
    }

    /// The text of a part, by hand.
    #[test]
    fn a_part_is_canonical_json() {
        let scene = scene::parse(SCENE, "test", None).unwrap();
        let system = system::build(&scene).unwrap();
        let texts = texts(&scene, &system).map(|(_, text)| text.to_string());
        let camera = r#"{"focal_length_mm":3.5e1,"height_px":3e1,"pitch_mm":2.2e-1,"position_mm":[0e0,0e0,0e0],"width_px":4.8e1}"#;
        assert_eq!(texts[0], camera);
        for text in texts {
            let read: Value = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {text}"));
            let keys: Vec<_> = read.as_object().unwrap().keys().collect();
            assert!(keys.is_sorted(), "{text}");
        }
    }

    /// Every number of the scene is in it, to the last bit; what only names things is not.
    #[test]
    fn a_changed_number_changes_the_checksum() {
        let own = sums(SCENE);
        for (part, from, to) in [
            ("camera", "35.0", "35.000000000000007"),
            ("camera", "height_px = 30", "height_px = 31"),
            ("prism", "78.472", "78.47200000000001"),
            ("board", "1000.0]", "1000.0000000000001]"),
        ] {
            let changed = sums(&SCENE.replacen(from, to, 1));
            assert_ne!(own[part], changed[part], "{to}");
        }
        assert_eq!(own, sums(&SCENE.replace("name = \"test\"", "name = \"other\"\naccuracy = \"draft\"")));
    }

    /// A picture of another version tells nothing, which is not the same as another instrument.
    #[test]
    fn a_picture_without_a_form_is_of_an_unknown_instrument() {
        let scene = scene::parse(SCENE, "test", None).unwrap();
        let system = system::build(&scene).unwrap();
        let mut said = Value::from(parts(&scene, &system));
        assert_eq!(likeness(&scene, &system, &said), Likeness::Same);
        said["prism"] = "0123456789abcdef".into();
        assert_eq!(likeness(&scene, &system, &said), Likeness::Others(vec!["prism".to_owned()]));
        for form in [Value::Null, "biprism-instrument/0".into()] {
            said[FORM_KEY] = form;
            assert_eq!(likeness(&scene, &system, &said), Likeness::Unknown);
        }
        assert_eq!(likeness(&scene, &system, &Value::Null), Likeness::Unknown);
    }

    /// Nothing is known of a prism of triangles that was told by its numbers, which is not another prism.
    #[test]
    fn triangles_have_a_form_of_their_own() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cases/prism_mesh.toml");
        let scene = scene::load(path.as_ref()).unwrap();
        let system = system::build(&scene).unwrap();
        let mut said = Value::from(parts(&scene, &system));
        assert_eq!((&said[FORM_KEY], likeness(&scene, &system, &said)), (&FORM_OF_MESHES.into(), Likeness::Same));
        said["prism"] = "0123456789abcdef".into();
        assert_eq!(likeness(&scene, &system, &said), Likeness::Others(vec!["prism".to_owned()]));
        said[FORM_KEY] = FORM.into();
        assert_eq!(likeness(&scene, &system, &said), Likeness::Unknown);
        said["camera"] = "0123456789abcdef".into();
        assert_eq!(likeness(&scene, &system, &said), Likeness::Others(vec!["camera".to_owned()]));
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
