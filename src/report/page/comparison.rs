//! The page of a comparison, or of one picture that was measured: verdict, pictures to look into, corners, epipolar lines and
//! every figure.

use super::corner_rows::{BUDGET_STEPS, corner_rows, significant};
use super::figure_table::{MetricRow, metric_rows};
use super::origin::PageOrigin;
use super::picture_data::picture_data;
use super::shell::{self, Scripts};
use crate::analysis::epipolar_polynomial::{EpipolarPolynomial, epipolar_polynomials};
use crate::analysis::judge::Judgement;
use crate::raster::Raster;
use crate::report::json::Design;
use crate::report::table;
use crate::scene::Scene;
use crate::system::System;
use serde::Serialize;
use serde_json::{Value, json};

/// One prism of the page.
#[derive(Debug, Clone)]
pub struct PagePrism<'a> {
    /// Its entry in the report.
    pub entry: &'a Design,
    /// What was judged.
    pub judgement: &'a Judgement,
    /// The scene with it.
    pub scene: &'a Scene,
    /// Its instrument.
    pub system: &'a System,
    /// The picture, of linear light; `None` where corners alone were given.
    pub picture: Option<&'a Raster<f32>>,
    /// How the picture was made.
    pub made: String,
    /// What a reader must know besides.
    pub notes: Vec<String>,
}

/// What fills the template.
#[derive(Serialize)]
struct ComparisonContext<'a> {
    title: &'a str,
    verdict: &'a str,
    remarks: Vec<String>,
    prisms: Vec<ListedPrism<'a>>,
    has_budget: bool,
    has_pictures: bool,
    rows: Vec<MetricRow>,
    origin: &'a PageOrigin,
}

#[derive(Serialize)]
struct ListedPrism<'a> {
    name: &'a str,
    made: &'a str,
}

/// The page of these prisms; `verdict` is the sentence that judges them.
pub fn page(title: &str, verdict: &str, prisms: &[PagePrism<'_>], origin: &PageOrigin) -> String {
    let entries: Vec<Design> = prisms.iter().map(|prism| prism.entry.clone()).collect();
    let of_prism: Vec<Value> = prisms.iter().map(|prism| prism_data(prism, prisms.len())).collect();
    let data = json!({ "prisms": of_prism, "budget_steps": BUDGET_STEPS });
    let listed = |prism: &'_ PagePrism<'_>| prism.entry.error_budget.is_some();
    let context = ComparisonContext {
        title,
        verdict,
        remarks: table::remarks(&entries).into_iter().chain(prisms.iter().flat_map(notes)).collect(),
        prisms: prisms.iter().map(|p| ListedPrism { name: &p.entry.name, made: &p.made }).collect(),
        has_budget: prisms.iter().any(listed),
        has_pictures: prisms.iter().any(|prism| prism.picture.is_some()),
        rows: metric_rows(&entries),
        origin,
    };
    shell::page("comparison.html", Scripts::Viewer, &data.to_string(), &context)
}

/// What must be known of a prism, with its name where there are several.
fn notes(prism: &PagePrism<'_>) -> Vec<String> {
    prism.notes.iter().map(|note| format!("{}: {note}", prism.entry.name)).collect()
}

/// What the scripts are told of a prism, one of `count`.
fn prism_data(prism: &PagePrism<'_>, count: usize) -> Value {
    let [left, right] = epipolar_polynomials(prism.scene, prism.system);
    json!({
        "name": prism.entry.name,
        "size": prism.system.camera().size_px(),
        "picture": prism.picture.and_then(|picture| picture_data(picture, count)),
        "corners": corner_rows(prism.judgement, prism.entry.error_budget.as_ref()),
        "epipolar": [left.as_ref().map(epipolar_data), right.as_ref().map(epipolar_data)],
        "board_mm": prism.judgement.view.depth_mm,
    })
}

/// A polynomial for the scripts, its coefficients to seven digits.
fn epipolar_data(polynomial: &EpipolarPolynomial) -> Value {
    let largest = polynomial.coefficients_px.iter().map(|c| c.length()).fold(0.0, f64::max);
    let kept = |axis: usize| -> Vec<f64> {
        let rounded = |value: f64| if value.abs() < 1e-9 * largest { 0.0 } else { significant(value, 6) };
        polynomial.coefficients_px.iter().map(|c| rounded(c[axis])).collect()
    };
    json!({
        "first": polynomial.frame.first_column,
        "other_first": polynomial.other_first_column,
        "size": polynomial.frame.size_px.to_array(),
        "depths_mm": polynomial.depths_mm.map(|mm| significant(mm, 5)),
        "terms": polynomial.terms,
        "x": kept(0),
        "y": kept(1),
        "misfit_px": significant(polynomial.misfit_px, 1),
    })
}
