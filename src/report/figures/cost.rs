//! The study as charts: error over time.

use crate::analysis::cost::{CostStudy, DesignSetting, EffectSetting, FILLED, Meshed, Setting, Spread};
use crate::plot::axis::{Scale, superscript};
use crate::plot::chart::{self, AxisInput, ChartInput, ChartSeries, Front, Look, Point};
use crate::plot::drawing::Drawing;
use crate::report::cost::{Machine, error_px};

/// Size of a chart, in px.
const SIZE_PX: [u32; 2] = [1600, 1000];

/// The title of [`pictures`].
pub fn title(scene: &str, study: &CostStudy) -> String {
    let [width, height] = study.size_px;
    format!("What accuracy costs: scene {scene}, {width} × {height} px")
}

/// The title of [`designs`].
pub(crate) fn design_title(scene: &str) -> String {
    format!("What the design costs: scene {scene}, method and step")
}

/// The title of [`meshes`].
pub(crate) fn mesh_title(scene: &str) -> String {
    format!("What a mesh costs: scene {scene}, one ray a pixel")
}

/// The title of [`effects`].
pub(crate) fn effect_title(scene: &str) -> String {
    format!("What lenses and triangles cost: scene {scene}")
}

/// Largest shift of a line of the board over the time of a picture, for every setting of the simulator.
pub fn pictures(scene: &str, machine: &Machine, study: &CostStudy) -> Drawing {
    let of = |knob: &str| study.pictures.iter().filter(|s| s.knob == knob).collect::<Vec<&Setting>>();
    let named = |name: &str, knob: &str, look: Look, word: &dyn Fn(&Setting) -> String| {
        let settings = of(knob);
        let points = settings.iter().map(|s| point(s.time_ms, error_px(s)));
        ChartSeries {
            name: name.to_owned(),
            look,
            points: points.collect(),
            labels: settings.iter().map(|s| word(s)).collect(),
        }
    };
    let value = |s: &Setting| s.value.clone();
    let power = |s: &Setting| power_of_ten(s.number);
    let series = vec![
        named("levels", "level", Look::MarkersAndLine, &value),
        named("samples on a grid", "samples, grid", Look::MarkersAndLine, &value),
        named("samples, jittered", "samples, jittered", Look::MarkersAndLine, &value),
        named("arithmetic of the map", "arithmetic", Look::Markers, &value),
        named("degree of the map", "map_degree", Look::Markers, &value),
        named("patches of degree 3, px", "patch_px, degree 3", Look::Markers, &value),
        named("surface residual, mm", "surface_residual_mm", Look::Markers, &power),
        named("bend left, px", "bend_px", Look::Markers, &power),
    ];
    chart::draw(&ChartInput {
        title: title(scene, study),
        note: note(machine, study),
        x: axis("CPU time of a picture on one thread, ms"),
        y: axis("largest shift of lines, px"),
        series: series.into_iter().filter(|s| !s.points.is_empty()).collect(),
        front: Front::SmallIsGood,
        size_px: SIZE_PX,
    })
}

/// Largest shift of a corner over the time of one ray a pixel, through the prism as triangles.
pub fn meshes(scene: &str, machine: &Machine, study: &CostStudy) -> Drawing {
    chart::draw(&ChartInput {
        title: mesh_title(scene),
        note: note(machine, study),
        x: axis("CPU time of one ray a pixel on one thread, ms"),
        y: axis("largest shift of corners, px"),
        series: vec![
            mesh_series("normals of the triangles", "flat", &study.meshes),
            mesh_series("normals of the vertices", "smooth", &study.meshes),
        ],
        front: Front::None,
        size_px: SIZE_PX,
    })
}

/// Error of the integration over the time of a design.
pub fn designs(scene: &str, machine: &Machine, study: &CostStudy) -> Drawing {
    let series = [("Euler", "euler"), ("midpoint", "midpoint"), ("RK4", "rk4"), ("Dormand-Prince", "dormand_prince")];
    let named = |(name, knob): (&str, &str)| {
        let own: Vec<&DesignSetting> = study.designs.iter().filter(|d| d.knob == knob).collect();
        ChartSeries {
            name: name.to_owned(),
            look: Look::MarkersAndLine,
            points: own.iter().map(|d| point(d.time_ms, d.optical_path_spread_mm)).collect(),
            labels: own.iter().map(|d| label(d)).collect(),
        }
    };
    chart::draw(&ChartInput {
        title: design_title(scene),
        note: note(machine, study),
        x: axis("CPU time of a design on one thread, ms"),
        y: axis("spread of the optical path over the points, mm"),
        series: series.map(named).into(),
        front: Front::SmallIsGood,
        size_px: SIZE_PX,
    })
}

/// Difference from a finer picture with the same effect over the time of a picture.
pub fn effects(scene: &str, machine: &Machine, study: &CostStudy) -> Drawing {
    let named = |(name, effect, knob): (&str, &str, &str)| {
        let own: Vec<&EffectSetting> = study.effects.iter().filter(|s| s.effect == effect && s.knob == knob).collect();
        ChartSeries {
            name: name.to_owned(),
            look: Look::MarkersAndLine,
            points: own.iter().map(|s| point(s.time_ms, s.rmse)).collect(),
            labels: own.iter().map(|s| s.value.clone()).collect(),
        }
    };
    let series = [
        ("thin lens, pupil points", "thin_lens", "points"),
        ("thin lens, filled", "thin_lens", FILLED),
        ("telecentric lens, pupil points", "telecentric", "points"),
        ("telecentric lens, filled", "telecentric", FILLED),
        ("prism of triangles, level", "mesh", "level"),
    ];
    chart::draw(&ChartInput {
        title: effect_title(scene),
        note: note(machine, study),
        x: axis("CPU time of a picture on one thread, ms"),
        y: axis("RMSE against a finer picture, of full scale 1"),
        series: series.into_iter().map(named).filter(|s| !s.points.is_empty()).collect(),
        front: Front::None,
        size_px: SIZE_PX,
    })
}

/// A step, or a tolerance.
fn label(design: &DesignSetting) -> String {
    match design.knob {
        "dormand_prince" => format!("{} mm", power_of_ten(design.number)),
        _ => design.value.replace("um", "µm"),
    }
}

fn point(time: Spread, error: f64) -> Point {
    Point::new(time.median, error)
}

fn mesh_series(name: &str, normals: &str, meshes: &[Meshed]) -> ChartSeries {
    let own: Vec<&Meshed> = meshes.iter().filter(|m| m.normals == normals && m.corners_px.is_some()).collect();
    ChartSeries {
        name: name.to_owned(),
        look: Look::MarkersAndLine,
        points: own.iter().filter_map(|m| Some(point(m.time_ms, m.corners_px?.max))).collect(),
        labels: own.iter().map(|m| format!("{} triangles", power_of_ten(m.triangles as f64))).collect(),
    }
}

/// The nearest power of ten, in words.
fn power_of_ten(value: f64) -> String {
    format!("10{}", superscript(libm::log10(value).round() as i32))
}

/// Where and how times were taken.
fn note(machine: &Machine, study: &CostStudy) -> String {
    format!("{machine}; median of one interleaved run; yardstick {:.1} ns a ray", study.yardstick_ns.median)
}

fn axis(name: &str) -> AxisInput {
    AxisInput { name: name.to_owned(), scale: Scale::Log, range: None }
}
