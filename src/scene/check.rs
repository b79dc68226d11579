//! From the values as written to the [`Scene`]: units, defaults, and what two values of one table say of each other.

use super::document::Document;
use super::effects;
use super::limits::MARCHED_POINTS;
use super::model::*;
use super::schema::*;
use super::surface_files;
use crate::accuracy::Accuracy;
use crate::effect::Effects;
use crate::error::Error;
use crate::geom::Pose;
use crate::io::point_cloud::Surface;
use crate::num::bernstein::MAX_DEGREE;
use crate::num::poly2::Poly2;
use crate::optics::medium;
use crate::scene::PolynomialPatch;
use crate::scene::Rect;
use glam::{DVec2, DVec3};
use std::path::Path;

/// The scene that `file` describes; files that it names are looked for in `folder`.
pub(super) fn scene(document: &Document, file: SceneFile, folder: Option<&Path>) -> Result<Scene, Error> {
    name(document, &file.name)?;
    let camera = camera(&file.camera);
    let board = board(&file.board);
    let prism = prism(document, file.prism, &camera, folder)?;
    let effects =
        effects::tables::effects(document, file.effects, &file.effect, &file.quadrature, &camera, &board, &prism)?;
    Ok(Scene {
        encoding: encoding(document, file.output.encoding, &effects)?,
        effects,
        prism,
        camera,
        board,
        accuracy: match file.accuracy {
            AccuracyFile::Level(LevelFile::Draft) => Accuracy::draft(),
            AccuracyFile::Level(LevelFile::Standard) => Accuracy::standard(),
            AccuracyFile::Level(LevelFile::Exact) => Accuracy::exact(),
            AccuracyFile::Level(LevelFile::Reference) => Accuracy::reference(),
            AccuracyFile::Target(target) => Accuracy::for_target(target.target_px),
        },
        analysis: Analysis { depths_mm: file.analysis.depths_mm, grid: file.analysis.grid },
        expect: file
            .expect
            .into_iter()
            .enumerate()
            .map(|(i, claim)| expect(document, i, claim))
            .collect::<Result<_, _>>()?,
        name: file.name,
    })
}

/// What a sensor's gamma has coded is written as it is.
fn encoding(document: &Document, file: Option<EncodingFile>, effects: &Effects) -> Result<Encoding, Error> {
    let gamma = effects.sensor.map_or(1.0, |sensor| sensor.gamma);
    match file {
        Some(EncodingFile::Srgb) if gamma != 1.0 => {
            let rule = format!(
                "`output.encoding` is \"srgb\" beside `effect.sensor.gamma` {gamma}, and the picture would be coded twice"
            );
            let help = "write \"linear\", which keeps the sensor's values as they are, or take `gamma` out";
            Err(document.problem(document.span("output.encoding"), rule, help))
        }
        None if gamma == 1.0 => Ok(Encoding::Srgb),
        Some(EncodingFile::Srgb) => Ok(Encoding::Srgb),
        Some(EncodingFile::Linear) | None => Ok(Encoding::Linear),
    }
}

/// A name may become a file's name on any system.
fn name(document: &Document, name: &str) -> Result<(), Error> {
    let allowed = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "_-".contains(c);
    match name.chars().find(|c| !allowed(*c)).or(name.chars().next().filter(|c| *c == '-')) {
        None => Ok(()),
        Some(c) => {
            let rule = format!("`name` is {name:?}, and {c:?} may not stand there");
            let help = "use lower-case letters, digits, - and _, and begin without -";
            Err(document.problem(document.span("name"), rule, help))
        }
    }
}

fn camera(file: &CameraFile) -> CameraSpec {
    CameraSpec {
        position_mm: DVec3::from_array(file.position_mm),
        focal_length_mm: file.focal_length_mm,
        width_px: file.width_px,
        height_px: file.height_px,
        pitch_mm: file.pixel_pitch_um / 1000.0,
    }
}

fn prism(document: &Document, file: PrismFile, camera: &CameraSpec, folder: Option<&Path>) -> Result<PrismSpec, Error> {
    Ok(match file {
        PrismFile::None {} => PrismSpec::None,
        PrismFile::Flat(flat) => PrismSpec::Flat(biprism(&flat)),
        PrismFile::Freeform(file) => {
            PrismSpec::Freeform(biprism(&file.biprism), design(document, &file.design, camera)?)
        }
        PrismFile::Polynomial(file) => PrismSpec::Polynomial(PolynomialSpec {
            body: body(&file.body),
            front: patch(document, "prism.front", &file.front)?,
            back: patch(document, "prism.back", &file.back)?,
        }),
        PrismFile::PointCloud(file) => PrismSpec::PointCloud(PointCloudSpec {
            body: body(&file.body),
            front: surface_files::cloud(document, "prism.front", &file.front, folder, Surface::Front)?,
            back: surface_files::cloud(document, "prism.back", &file.back, folder, Surface::Back)?,
        }),
        PrismFile::Mesh(file) => PrismSpec::Mesh(surface_files::mesh(document, body(&file.glass), &file, folder)?),
    })
}

fn body(file: &BodyFile) -> GlassSpec {
    GlassSpec {
        index: file.index,
        outer_index: file.outer_index,
        glass: file.glass.as_deref().and_then(medium::named),
        wavelength_nm: file.wavelength_nm,
        world_from_prism: pose(file.position_mm, file.tilt_deg),
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
    let pixels = (camera.width_px as f64 / 2.0) * camera.height_px as f64;
    let points = pixels / (file.step_px * file.step_px);
    if points > MARCHED_POINTS {
        let rule = format!(
            "`prism.design.step_px` is {}, which marches {points:.1e} points over a half image; the limit is \
             {MARCHED_POINTS:e}",
            file.step_px
        );
        let help = format!("give a step of at least {:.3}", (pixels / MARCHED_POINTS).sqrt() + 0.0005);
        return Err(document.problem(document.span("prism.design.step_px"), rule, help));
    }
    Ok(DesignSettings {
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
        step_px: file.step_px,
    })
}

fn patch(document: &Document, path: &str, file: &PatchFile) -> Result<PolynomialPatch, Error> {
    let [[x_min, x_max], [y_min, y_max]] = file.domain_mm;
    for (i, [min, max]) in file.domain_mm.into_iter().enumerate() {
        if min >= max {
            let rule = format!("`{path}.domain_mm[{i}]` runs from {min} to {max}, which is nowhere");
            let help = "give the smaller bound first: [[x_min, x_max], [y_min, y_max]]";
            return Err(document.problem(document.span(&format!("{path}.domain_mm[{i}]")), rule, help));
        }
    }
    if x_max <= 0.0 {
        let rule = format!("`{path}.domain_mm` ends at x = {x_max}, and the right half of the prism has x above 0");
        let help = "describe the right half: the left one is its mirror image";
        return Err(document.problem(document.span(&format!("{path}.domain_mm")), rule, help));
    }
    for (i, term) in file.terms.iter().enumerate() {
        let TermFile(m, n, _) = *term;
        let problem = |rule, help: &str| {
            let at = format!("{path}.terms[{i}]");
            Err(document.problem(document.span(&at), format!("`{at}` is a term in X^{m} Y^{n}, {rule}"), help))
        };
        if m + n > MAX_DEGREE {
            return problem(format!("of degree {}, and the limit is {MAX_DEGREE}", m + n), "leave the term out");
        }
        if file.terms[..i].iter().any(|t| (t.0, t.1) == (m, n)) {
            return problem("which an earlier one already gives".to_owned(), "add the two coefficients in one term");
        }
    }
    let degree = file.terms.iter().map(|t| t.0 + t.1).max().unwrap_or(0);
    let coefficient = |m, n| file.terms.iter().find(|t| (t.0, t.1) == (m, n)).map_or(0.0, |t| t.2);
    Ok(PolynomialPatch {
        sag: Poly2::new(degree, file.centre_mm, file.scale_mm, coefficient),
        domain: Rect { min: DVec2::new(x_min, y_min), max: DVec2::new(x_max, y_max) },
    })
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

fn expect(document: &Document, i: usize, claim: ExpectFile) -> Result<Expect, Error> {
    let at = |key: &str| document.span(&format!("expect[{i}]{key}"));
    let step = |s: &str| !s.is_empty() && s.chars().all(|c| c.is_ascii_alphanumeric() || "_-".contains(c));
    let value = &claim.value;
    if !value.contains('/') || !value.split('/').all(step) {
        let rule = format!("`expect[{i}].value` is {value:?}, and must be a path in the report");
        let help = "write it as freeform/pinhole/designed/mean_abs_v_mm: the design, then the keys of report.json";
        return Err(document.problem(at(".value"), rule, help));
    }
    match (claim.min, claim.max) {
        (None, None) => {
            let rule = format!("`expect[{i}]` has neither `min` nor `max`, so it claims nothing of {value:?}");
            Err(document.problem(at(""), rule, "add `min = ...`, `max = ...` or both"))
        }
        (Some(min), Some(max)) if min > max => {
            let rule = format!("`expect[{i}].min` is {min}, above its `max` {max}");
            Err(document.problem(at(".min"), rule, "give the smaller bound as `min`"))
        }
        (min, max) => Ok(Expect { value: claim.value, min, max }),
    }
}

fn pose(position_mm: [f64; 3], tilt_deg: [f64; 3]) -> Pose {
    Pose::new(DVec3::from_array(position_mm), DVec3::from_array(tilt_deg.map(f64::to_radians)))
}
