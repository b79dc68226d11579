//! By how much the edges of a lattice lie towards dark, from the directions along its lines.

use super::curvature::lean;
use super::lattice_lines::Grid;
use super::lean::Lean;
use crate::num::stats::quantile;
use glam::IVec2;
use std::ops::{Mul, Sub};

/// The standard error of a median of n normal deviates is this times their interquartile range over the root of n.
const MEDIAN_ERROR: f64 = 0.93;
/// Standard errors from which on the lean of edges is believed, lines from which on it is sought, and the least in px:
/// below it a corner errs by less than the bend of its lines would.
const SURE: f64 = 4.0;
const LEAST_LINES: usize = 6;
const LEAST_LEAN_PX: f64 = 1e-3;

/// Along columns' indices and along rows'.
const AXES: [IVec2; 2] = [IVec2::X, IVec2::Y];

/// By how much something grows with the index along a direction at a cell: from the cells on both sides, or at an end from three.
fn by_index<T: Copy + Sub<Output = T> + Mul<f64, Output = T>>(
    cell: IVec2,
    direction: IVec2,
    of: impl Fn(IVec2) -> Option<T>,
) -> Option<T> {
    let at = |k: i32| of(cell + direction * k);
    let at_end = |sign: i32| {
        let (here, beside) = (at(0)?, at(sign)?);
        let first = beside - here;
        let growth = at(2 * sign).map_or(first, |far| first * 1.5 - (far - beside) * 0.5);
        Some(growth * f64::from(sign))
    };
    match (at(-1), at(1)) {
        (Some(before), Some(after)) => Some((after - before) * 0.5),
        (None, _) => at_end(1),
        (_, None) => at_end(-1),
    }
}

impl Grid {
    /// Finds by how much all edges lean towards dark, as the lines of both families show it ([`lean`]): a straight edge
    /// through what is a step says nothing of the line's bend, so [`Self::nodes`] turns the directions back.
    ///
    /// It counts where the lines agree on it: their median must be four of its own standard errors away from 0.
    pub(super) fn find_lean(&mut self) {
        // Take what each line says, from its first corner on: in px, and as a share of the squares.
        let told = self.lean_forms().map(|form| {
            self.lean = form;
            let leans: Vec<f64> = self.leans_of_lines().iter().map(|beyond| form.value() + beyond).collect();
            let [low, middle, high] = [0.25, 0.5, 0.75].map(|q| quantile(&leans, q).unwrap_or(0.0));
            (
                form.of(middle),
                MEDIAN_ERROR * (high - low) / (leans.len().max(1) as f64).sqrt() / middle.abs(),
                leans.len(),
            )
        });

        // Believe the median of that on which the lines agree better, where its standard error, from the middle half, says so.
        let (lean, error, lines) = if told[1].1 < told[0].1 { told[1] } else { told[0] };
        self.lean = lean;
        let sure = lines >= LEAST_LINES && SURE * error <= 1.0 && self.lean_px().abs() >= LEAST_LEAN_PX;
        self.lean = if sure { lean } else { Lean::NONE };
    }

    /// The lean as it is known, in px and as a share of the squares.
    fn lean_forms(&self) -> [Lean; 2] {
        let spacings: Vec<f64> = self
            .lattice()
            .keys()
            .flat_map(|&cell| [0, 1].map(|axis| self.spacing_px(IVec2::from_array(cell), axis)))
            .flatten()
            .collect();
        let spacing = quantile(&spacings, 0.5).unwrap_or(1.0);
        match self.lean {
            Lean::Even(px) => [self.lean, Lean::OfSquare(px / spacing)],
            Lean::OfSquare(share) => [Lean::Even(share * spacing), self.lean],
        }
    }

    /// What each line says of the lean beyond what is known, in the form of that.
    fn leans_of_lines(&self) -> Vec<f64> {
        let mut leans = Vec::new();
        for &cell in self.lattice().keys() {
            for direction in [IVec2::X, IVec2::Y] {
                let cell = IVec2::from_array(cell);
                if self.at(cell - direction).is_none() {
                    leans.extend(self.nodes(cell, direction).and_then(|(nodes, own)| lean(&nodes, own, self.lean)));
                }
            }
        }
        leans
    }

    /// By how many px edges lie towards dark, at the median over the corners.
    pub(super) fn lean_px(&self) -> f64 {
        let leans: Vec<f64> = self.lattice().keys().flat_map(|&cell| self.leans_px(IVec2::from_array(cell))).collect();
        quantile(&leans, 0.5).unwrap_or(0.0)
    }

    /// By how many px the edges along both lines through a cell lie towards dark.
    pub(super) fn leans_px(&self, cell: IVec2) -> [f64; 2] {
        [0, 1].map(|axis| match self.lean {
            Lean::Even(px) => px,
            Lean::OfSquare(_) => self.lean.at(self.spacing_px(cell, axis).unwrap_or(0.0)),
        })
    }

    /// By what share of it this grows with each px along those lines.
    pub(super) fn lean_rates(&self, cell: IVec2) -> [f64; 2] {
        let rate = |axis: usize| {
            let along = AXES[axis];
            let by_index = by_index(cell, along, |cell| self.spacing_px(cell, axis))?;
            Some(by_index / (self.spacing_px(cell, axis)? * self.step(cell, along)?.length()))
        };
        [0, 1].map(|axis| match self.lean {
            Lean::Even(_) => 0.0,
            Lean::OfSquare(_) => rate(axis).filter(|rate| rate.is_finite()).unwrap_or(0.0),
        })
    }

    /// How far the lines beside that along an axis through a cell are, in px, as the paces of the lattice there say.
    pub(super) fn spacing_px(&self, cell: IVec2, axis: usize) -> Option<f64> {
        let at = |cell: IVec2| self.at(cell);
        let paces = [by_index(cell, AXES[0], at)?, by_index(cell, AXES[1], at)?];
        let spacing = paces[0].perp_dot(paces[1]).abs() / paces[axis].length();
        spacing.is_finite().then_some(spacing)
    }
}
