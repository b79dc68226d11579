//! From the values as written to the [`Scene`]: units, defaults, and what two values of one table say of each other.

use super::body_keys::BodyFile;
use super::camera_keys;
use super::design_model::*;
use super::design_rules;
use super::document::Document;
use super::effects;
use super::law::PrismLaw;
use super::model::*;
use super::object_keys;
use super::prism_tables::*;
use super::rules;
use super::schema::*;
use super::source::ValueSource;
use super::surface_files;
use super::texture_keys;
use crate::accuracy::Accuracy;
use crate::effect::Effects;
use crate::error::Error;
use crate::geom::{Pose, Rect};
use crate::num::curve::ChebyshevCurve;
use crate::num::poly2::Poly2;
use crate::optics::medium;
use crate::surface::face::Face;
use crate::surface::shape::{PolynomialPatch, RevolvedPatch};
use glam::{DVec2, DVec3};
use std::path::Path;

/// The scene that `file` describes; files that it names are looked for in `folder`.
pub(super) fn scene(document: &Document, file: SceneFile, folder: Option<&Path>) -> Result<Scene, Error> {
    rules::name(document, &file.name)?;
    let camera = camera_keys::camera(document, &file.camera, folder)?;
    let board = board(&file.board);
    let own_mm = board.world_from_board.translation_mm.z - camera.position_mm.z;
    let prism = prism(document, file.prism, &camera, folder)?;
    let effects =
        effects::tables::effects(document, file.effects, &file.effect, &file.quadrature, &camera, &board, &prism)?;
    rules::calibrated_pinhole(document, &camera, &effects)?;
    Ok(Scene {
        encoding: encoding(document, file.output.encoding, &effects)?,
        effects,
        prism,
        camera,
        texture: match &file.board.texture {
            Some(texture) => Some(texture_keys::texture(document, "board.texture", texture, &board, folder)?),
            None => None,
        },
        objects: object_keys::objects(document, &file.object, board.background, folder)?,
        board,
        board_pose: match file.board.pose {
            BoardPoseFile::Stated => BoardPose::Stated,
            BoardPoseFile::Fit => BoardPose::Fit,
        },
        accuracy: match file.accuracy {
            AccuracyFile::Level(LevelFile::Draft) => Accuracy::draft(),
            AccuracyFile::Level(LevelFile::Standard) => Accuracy::standard(),
            AccuracyFile::Level(LevelFile::Exact) => Accuracy::exact(),
            AccuracyFile::Level(LevelFile::Reference) => Accuracy::reference(),
            AccuracyFile::Target(target) => Accuracy::for_target(target.target_px),
        },
        analysis: Analysis {
            depths_mm: file.analysis.depths_mm.unwrap_or_else(|| Analysis::about(own_mm).depths_mm),
            grid: file.analysis.grid,
        },
        expect: file
            .expect
            .into_iter()
            .enumerate()
            .map(|(i, claim)| expect(document, i, claim))
            .collect::<Result<_, _>>()?,
        name: file.name,
    })
}

fn encoding(document: &Document, file: Option<EncodingFile>, effects: &Effects) -> Result<Encoding, Error> {
    let encoding = match file {
        Some(EncodingFile::Srgb) => Encoding::Srgb,
        Some(EncodingFile::Linear) => Encoding::Linear,
        None if effects.sensor.is_some_and(|sensor| sensor.gamma != 1.0) => Encoding::Linear,
        None => Encoding::Srgb,
    };
    rules::coded_once(document, encoding, effects).map(|()| encoding)
}

fn prism(document: &Document, file: PrismFile, camera: &CameraSpec, folder: Option<&Path>) -> Result<PrismSpec, Error> {
    Ok(match file {
        PrismFile::None {} => PrismSpec::None,
        PrismFile::Flat(flat) => PrismSpec::Flat(biprism(&flat)),
        PrismFile::Freeform(file) => {
            let own = biprism(&file.biprism);
            let flat = match file.design.baseline_mm {
                Some(baseline_mm) => design_rules::with_baseline(document, own, camera, baseline_mm)?,
                None => own,
            };
            PrismSpec::Freeform(flat, design(document, &file.design, camera)?)
        }
        PrismFile::Polynomial(file) => PrismSpec::Polynomial(PolynomialSpec {
            body: body(&file.body),
            front: patch(document, "prism.front", &file.front)?,
            back: patch(document, "prism.back", &file.back)?,
        }),
        PrismFile::Revolved(file) => PrismSpec::Revolved(RevolvedSpec {
            body: body(&file.body),
            front: revolved(document, "prism.front", &file.front)?,
            back: revolved(document, "prism.back", &file.back)?,
        }),
        PrismFile::PointCloud(file) => PrismSpec::PointCloud(PointCloudSpec {
            body: body(&file.body),
            front: surface_files::cloud(document, "prism.front", &file.front, folder, Face::Front)?,
            back: surface_files::cloud(document, "prism.back", &file.back, folder, Face::Back)?,
        }),
        PrismFile::Mesh(file) if file.glass.solid.is_some() => return Err(rules::solid_mesh(document)),
        PrismFile::Mesh(file) => PrismSpec::Mesh(surface_files::mesh(document, body(&file.glass), &file, folder)?),
    })
}

fn body(file: &BodyFile) -> GlassSpec {
    GlassSpec {
        index: file.index,
        outer_index: file.outer_index,
        glass: file.glass.as_deref().and_then(medium::named),
        wavelength_nm: file.wavelength_nm,
        solid: file.solid,
        world_from_prism: pose(file.position_mm, file.tilt_deg),
        law: file.law.map(PrismLaw::from),
    }
}

fn biprism(file: &BiprismFile) -> BiprismSpec {
    BiprismSpec {
        body: body(&file.body),
        ridge_distance_mm: file.ridge_distance_mm,
        thickness_mm: file.thickness_mm,
        facet_angle_rad: file.facet_angle_deg.map(f64::to_radians),
    }
}

fn design(document: &Document, file: &DesignFile, camera: &CameraSpec) -> Result<DesignSettings, Error> {
    let settings = DesignSettings {
        objective: match file.objective {
            ObjectiveFile::March => Objective::March,
            ObjectiveFile::Epipolar => Objective::Epipolar,
            ObjectiveFile::ToedIn => Objective::ToedIn,
            ObjectiveFile::Pinhole => Objective::Pinhole,
            ObjectiveFile::Depth => Objective::Depth,
        },
        surface: match file.surface {
            DesignedSurfaceFile::Polynomial => DesignedSurface::Polynomial,
            DesignedSurfaceFile::Revolved => DesignedSurface::Revolved,
        },
        virtual_camera_z_mm: file.virtual_camera_z_mm,
        order: match file.order {
            OrderFile::XThenY => MarchOrder::XThenY,
            OrderFile::YThenX => MarchOrder::YThenX,
        },
        degree: file.degree,
        method: match file.method {
            MethodFile::Euler => Method::Euler,
            MethodFile::Midpoint => Method::Midpoint,
            MethodFile::Rk4 => Method::Rk4,
        },
        step_px: file.step_px.unwrap_or_else(|| DesignSettings::step_for(camera.width_px)),
        goal: DesignGoal {
            rear: match file.rear {
                RearFile::Own => Rear::Own,
                RearFile::Even => Rear::Even,
                RearFile::Flat => Rear::Flat,
            },
            square: file.square,
            f_number: file.aperture,
            spot_weight: file.spot_weight,
            z_min_mm: file.z_min_mm,
            depth_mm: file.depth_mm,
        },
    };
    design_rules::goal(document, &settings)?;
    rules::design(document, &settings, camera).map(|()| settings)
}

fn revolved(document: &Document, path: &str, file: &RevolvedPatchFile) -> Result<RevolvedPatch, Error> {
    let patch = RevolvedPatch {
        point_mm: DVec3::from_array(file.origin_mm),
        axis: DVec3::from_array(file.axis),
        profile: ChebyshevCurve::new(file.along_mm, file.profile_mm.clone()),
        azimuth_rad: file.azimuth_deg.to_radians(),
    };
    rules::revolved(document, path, &patch).map(|()| patch)
}

fn patch(document: &Document, path: &str, file: &PatchFile) -> Result<PolynomialPatch, Error> {
    let [[x_min, x_max], [y_min, y_max]] = file.domain_mm;
    let domain = Rect { min: DVec2::new(x_min, y_min), max: DVec2::new(x_max, y_max) };
    rules::domain(document, path, &domain)?;
    for (i, term) in file.terms.iter().enumerate() {
        let TermFile(m, n, _) = *term;
        let at = format!("{path}.terms[{i}]");
        rules::term(document, &at, m, n)?;
        if file.terms[..i].iter().any(|t| (t.0, t.1) == (m, n)) {
            let rule = format!("`{at}` is a term in X^{m} Y^{n}, which an earlier one already gives");
            return Err(document.refuse(&at, rule, "add the two coefficients in one term"));
        }
    }
    let degree = file.terms.iter().map(|t| t.0 + t.1).max().unwrap_or(0);
    let coefficient = |m, n| file.terms.iter().find(|t| (t.0, t.1) == (m, n)).map_or(0.0, |t| t.2);
    Ok(PolynomialPatch { sag: Poly2::new(degree, file.centre_mm, file.scale_mm, coefficient), domain })
}

fn board(file: &BoardFile) -> BoardSpec {
    BoardSpec {
        columns: file.columns,
        rows: file.rows,
        square_mm: file.square_mm,
        margin_mm: file.margin_mm.unwrap_or(file.square_mm),
        world_from_board: pose(file.position_mm, file.tilt_deg),
        black: file.black,
        white: file.white,
        background: file.background,
    }
}

fn expect(document: &Document, i: usize, file: ExpectFile) -> Result<Expect, Error> {
    let claim = Expect { value: file.value, min: file.min, max: file.max };
    rules::claim(document, i, &claim).map(|()| claim)
}

fn pose(position_mm: [f64; 3], tilt_deg: [f64; 3]) -> Pose {
    Pose::new(DVec3::from_array(position_mm), DVec3::from_array(tilt_deg.map(f64::to_radians)))
}
