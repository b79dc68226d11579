//! The convergence of the design as a sheet and a chart.

use super::document::StudyFigure;
use crate::analysis::convergence::{AxisMiss, MarchPlan};
use crate::num::ode::Integrator;
use crate::plot::axis::Scale;
use crate::plot::chart::{self, AxisInput, ChartInput, ChartSeries, Front, Look, Point};
use crate::report::sheet::{Cell, StudySheet};

/// One march with one fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MarchRow {
    /// How it stepped.
    pub plan: MarchPlan,
    /// What came out.
    pub miss: AxisMiss,
    /// Time of the march with all its fits, in s.
    pub seconds: f64,
}

/// The name of an integrator.
fn name(integrator: Integrator) -> &'static str {
    match integrator {
        Integrator::Euler => "Euler",
        Integrator::Midpoint => "midpoint",
        Integrator::Rk4 => "RK4",
        Integrator::DormandPrince(_) => "adaptive",
    }
}

/// The rows, each with the order that it shows against the one before, of twice or so its step.
pub fn sheet(rows: &[MarchRow]) -> StudySheet {
    let mut sheet = StudySheet::new(
        "convergence",
        "Mean distance from O' to where the rays behind the prism meet the axis",
        &[
            ("method", "how the march steps"),
            ("step_um", "the step on the sensor; of adaptive steps the way that they divide, um"),
            ("tolerance_mm", "error that an adaptive step may have, mm"),
            ("degree", "total degree of the fitted polynomials"),
            ("mean_abs_mm", "mean over 40 rays of the middle row of |z - z_O'| where they meet the axis, mm"),
            ("order", "log of the ratio of path spreads over that of the steps, against the longer step before"),
            ("path_spread_mm", "largest less smallest optical path over the marched points, mm"),
            ("seconds", "time of the march with all its fits, s"),
        ],
    );
    for row in rows {
        let tolerance = if let Integrator::DormandPrince(mm) = row.plan.integrator { Some(mm) } else { None };
        let longer = rows.iter().rev().find(|other| {
            let same = other.plan.integrator == row.plan.integrator && other.miss.degree == row.miss.degree;
            same && other.plan.step_um > row.plan.step_um * 1.01
                && tolerance.is_none()
                && !rows.iter().any(|between| {
                    between.plan.integrator == row.plan.integrator
                        && between.plan.step_um > row.plan.step_um * 1.01
                        && between.plan.step_um < other.plan.step_um / 1.01
                })
        });
        let order = longer.map(|longer| {
            let ratio = |of: fn(&MarchRow) -> f64| libm::log(of(longer) / of(row));
            ratio(|r| r.miss.path_spread_mm) / ratio(|r| r.plan.step_um)
        });
        sheet.push(vec![
            name(row.plan.integrator).into(),
            row.plan.step_um.into(),
            Cell::from(tolerance),
            row.miss.degree.into(),
            row.miss.mean_abs_mm.into(),
            order.into(),
            row.miss.path_spread_mm.into(),
            row.seconds.into(),
        ]);
    }
    sheet
}

/// The distances over the step, a line a method and degree.
pub fn figures(scene: &str, rows: &[MarchRow]) -> Vec<StudyFigure> {
    let mut series: Vec<ChartSeries> = Vec::new();
    for row in rows.iter().filter(|row| !matches!(row.plan.integrator, Integrator::DormandPrince(_))) {
        let name = format!("{}, degree {}", name(row.plan.integrator), row.miss.degree);
        let point = Point::new(row.plan.step_um, row.miss.mean_abs_mm);
        match series.iter_mut().find(|s| s.name == name) {
            Some(found) => found.points.push(point),
            None => {
                series.push(ChartSeries { name, look: Look::MarkersAndLine, points: vec![point], labels: Vec::new() })
            }
        }
    }
    let title = format!("Convergence of the design: scene {scene}");
    let drawing = chart::draw(&ChartInput {
        title: title.clone(),
        note: "where the fitted polynomials end, a shorter step buys nothing".to_owned(),
        x: AxisInput { name: "step on the sensor, µm".to_owned(), scale: Scale::Log, range: None },
        y: AxisInput { name: "mean distance from O′ along the axis, mm".to_owned(), scale: Scale::Log, range: None },
        series,
        front: Front::None,
        size_px: [1400, 900],
    });
    vec![StudyFigure { name: "convergence".to_owned(), title, drawing }]
}
