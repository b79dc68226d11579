//! The tally of a case: its worst error, gathered one check at a time.

use super::scenes::in_px;
use super::tables::{number, rows};
use crate::optics::fate::Fate;
use crate::system::System;
use glam::DVec2;
use std::collections::BTreeMap;

/// What a case found.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct CaseOutcome {
    /// Count of checks.
    pub checked: usize,
    /// The largest error, in the case's unit.
    pub worst: f64,
    /// Where it was.
    pub worst_at: String,
    /// The largest distance along z between a solved point and its polynomial surface, in mm; `None` without such a one.
    pub residual_mm: Option<f64>,
    /// How rays ended, by name; `board` is the good end.
    pub fates: BTreeMap<&'static str, usize>,
    /// The first properties that did not hold, in words.
    pub broken: Vec<String>,
}

/// More broken properties than this are not told apart.
const MOST_BROKEN: usize = 8;

/// An outcome in the making.
#[derive(Debug, Clone)]
pub struct Tally(CaseOutcome);

impl Default for Tally {
    fn default() -> Self {
        Self(CaseOutcome {
            checked: 0,
            worst: 0.0,
            worst_at: String::new(),
            residual_mm: None,
            fates: BTreeMap::new(),
            broken: Vec::new(),
        })
    }
}

impl Tally {
    /// One check: the error at `place`. An error that is no number breaks the case.
    pub fn error(&mut self, place: impl FnOnce() -> String, error: f64) {
        self.0.checked += 1;
        if error.is_nan() {
            self.broke(format!("the error is not a number at {}", place()));
        } else if error.abs() > self.0.worst {
            self.0.worst = error.abs();
            self.0.worst_at = place();
        }
    }

    /// One check: whether a property holds.
    pub fn require(&mut self, holds: bool, what: impl FnOnce() -> String) {
        self.0.checked += 1;
        if !holds {
            self.broke(what());
        }
    }

    /// How a ray ended.
    pub fn ended<T>(&mut self, end: &Result<T, Fate>) {
        *self.0.fates.entry(end.as_ref().err().map_or("board", |fate| fate.name())).or_insert(0) += 1;
    }

    /// The distance along z between a solved point and its surface, in mm.
    pub fn residual(&mut self, mm: f64) {
        if mm.is_nan() {
            self.broke("a residual is not a number".to_owned());
        }
        self.0.residual_mm = Some(self.0.residual_mm.unwrap_or(0.0).max(mm.abs()));
    }

    fn broke(&mut self, what: String) {
        if self.0.broken.len() < MOST_BROKEN {
            self.0.broken.push(what);
        }
    }

    /// All that was found.
    pub fn done(self) -> CaseOutcome {
        self.0
    }
}

/// Board positions of `system` against a table of x_px, y_px, u_mm, v_mm.
pub(super) fn against(tally: &mut Tally, system: &System, table: &'static str) {
    for row in rows(table) {
        let [x, y, u, v] = [0, 1, 2, 3].map(|k| number(row[k]));
        let px = DVec2::new(x, y);
        let end = system.trace(px);
        tally.ended(&end);
        match end {
            Ok(sight) => tally.error(|| format!("{px}"), in_px(system, px, sight.board_mm - DVec2::new(u, v))),
            Err(fate) => tally.require(false, || format!("{px}: {}", fate.name())),
        }
    }
}
