//! The lattice about one corner: direction and curvature of its two lines, and the steps to its neighbours.

use super::candidate::NEIGHBOURS;
use super::cell_table::CellTable;
use super::corner_fit::CornerFit;
use super::corner_model::Model;
use super::corner_site::CornerSite;
use super::curvature::{
    LatticeLine, LineCorner, Tangent, bend, bend_doubt, least_power, left_by_power, line, powers_of, scale_of,
};
use super::lattice_growth::Lattice;
use super::lean::Lean;
use glam::{DMat2, DVec2, IVec2};
use std::collections::{BTreeMap, VecDeque};

/// Corners on a line from which on its own bend is believed, where only their positions are known.
const LONG_LINE: usize = 6;
/// Corners on a line from which on its own bend is believed, where its corners were fitted.
const OWN_LINE: usize = 3;
/// Corners along a line that are used at most: the corner and the nearest ones.
const MOST: usize = 9;
/// Corners that the blur is estimated from.
const PILOTS: usize = 24;
/// Corners whose lines choose the powers of polynomials along lines.
const VOTERS: usize = 80;
/// A line's bend needs a power of two.
const LEAST_POWER: usize = 2;
/// What is left of a step, in px, after it was taken: its square over this.
const STEP_RANGE_PX: f64 = 0.3;
/// A step of 1 px in the middle of an edge of 2 h turns the straight line through it by this over h.
const STEP_TURN: f64 = 1.5;
/// A line of the lattice: the first of some corners along it, and whether it runs along a row.
type Line = ([i32; 2], bool);

/// A corner as it was last fitted.
#[derive(Debug, Clone, Copy)]
pub(super) struct FittedCorner {
    /// The model, from the corner.
    model: Model,
    /// The unit normals of its edges.
    normals: [DVec2; 2],
    /// Covariance of the corner, in px^2, with what the last step may have left.
    covariance_px2: DMat2,
    /// Half the window along each line, in px.
    half_px: [f64; 2],
    /// Of each edge: its standard deviation across, in px, and [`Tangent::turn_per_px`].
    across: [[f64; 2]; 2],
}

/// A lattice with the best known position of each of its corners.
#[derive(Debug)]
pub(super) struct Grid {
    cells: CellTable,
    pub(super) positions: Vec<DVec2>,
    /// The last fit of each, if any.
    fitted: Vec<Option<FittedCorner>>,
    /// The power of the polynomial along a line of so many fitted corners.
    powers: [usize; MOST + 1],
    /// By how much the squared errors along such lines are larger than told.
    scales: [f64; MOST + 1],
    /// By how much all edges lie towards dark, from the directions along the lines; none where these do not tell it.
    pub(super) lean: Lean,
    /// By how much the blurs across both families go together beyond an even blur's ([`Model::skew`]).
    pub(super) skew: f64,
    /// Whether the squares hold marks (`marks`).
    pub(super) marked: bool,
}

impl Grid {
    pub(super) fn new(lattice: Lattice, positions: Vec<DVec2>) -> Self {
        let powers = std::array::from_fn(|nodes| *powers_of(nodes).start());
        let fitted = vec![None; positions.len()];
        let cells = CellTable::new(lattice);
        Self { cells, fitted, positions, powers, scales: [1.0; MOST + 1], lean: Lean::NONE, skew: 0.0, marked: false }
    }

    /// The corners that are left.
    pub(super) fn lattice(&self) -> &Lattice {
        self.cells.lattice()
    }

    /// Takes the corner at a cell out, and gives its number.
    pub(super) fn remove(&mut self, cell: [i32; 2]) -> Option<usize> {
        self.cells.remove(cell)
    }

    /// The position of the corner at a cell.
    #[inline]
    pub(super) fn at(&self, cell: IVec2) -> Option<DVec2> {
        self.cells.number(cell).map(|k| self.positions[k])
    }

    /// Chooses the powers of the polynomials along lines, from what the lines through some corners leave: alike for all
    /// lines of the same count, since a single line tells little.
    pub(super) fn choose_powers(&mut self) {
        let mut left: [Vec<[f64; 2]>; MOST + 1] = Default::default();
        // Corners of one line leave the same: the line counts once for each, and is asked once.
        let mut asked: BTreeMap<Line, Option<Vec<[f64; 2]>>> = BTreeMap::new();
        let stride = self.lattice().len().div_ceil(VOTERS).max(1);
        for &cell in self.lattice().keys().step_by(stride) {
            for direction in [IVec2::X, IVec2::Y] {
                let Some((nodes, own)) = self.nodes(IVec2::from_array(cell), direction) else { continue };
                let first = IVec2::from_array(cell) - direction * own as i32;
                let line = (first.to_array(), direction == IVec2::X);
                let Some(more) = asked.entry(line).or_insert_with(|| left_by_power(&nodes, own)) else { continue };
                let sums = &mut left[nodes.len()];
                sums.resize(more.len(), [0.0; 2]);
                sums.iter_mut().zip(more.iter()).for_each(|(sum, more)| (0..2).for_each(|i| sum[i] += more[i]));
            }
        }
        self.powers = std::array::from_fn(|nodes| powers_of(nodes).start() + least_power(&left[nodes]));

        // Where edges lean, part of it is left in the directions, unlike from corner to corner: no power may follow that.
        if !self.lean.is_none() {
            for (nodes, power) in self.powers.iter_mut().enumerate() {
                *power = (*power).min(LEAST_POWER.max(nodes.saturating_sub(1)));
            }
        }

        // See what the chosen powers leave, or the least that was asked where edges lean; a line counted once for each of its corners.
        self.scales = std::array::from_fn(|nodes| {
            let left = left[nodes].get(self.powers[nodes].saturating_sub(*powers_of(nodes).start()));
            left.map_or(1.0, |[squares, freedom]| scale_of(squares / freedom, freedom / nodes as f64))
        });
    }

    /// Some corners spread over the lattice, with neighbours on all sides.
    pub(super) fn pilots(&self) -> Vec<CornerSite> {
        let beside = |cell: &[i32; 2]| NEIGHBOURS.map(|n| IVec2::from_array(*cell) + n);
        let inner: Vec<[i32; 2]> = self
            .lattice()
            .keys()
            .filter(|cell| beside(cell).into_iter().all(|other| self.cells.number(other).is_some()))
            .copied()
            .collect();
        let stride = inner.len().div_ceil(PILOTS).max(1);
        inner.into_iter().step_by(stride).filter_map(|cell| self.site(cell)).collect()
    }

    /// All corners.
    pub(super) fn sites(&self) -> Vec<CornerSite> {
        self.lattice().keys().filter_map(|&cell| self.site(cell)).collect()
    }

    /// Takes over a fit in a window of `half` steps.
    pub(super) fn take(&mut self, cell: [i32; 2], number: usize, fit: &CornerFit, half: f64) {
        self.positions[number] += fit.model.corner;
        let cell = IVec2::from_array(cell);
        let half_px = [IVec2::X, IVec2::Y].map(|d| half * self.step(cell, d).map_or(0.0, DVec2::length));
        let left = fit.last_step_px * fit.last_step_px / STEP_RANGE_PX;
        let covariance_px2 = fit.covariance_px2 + DMat2::from_diagonal(DVec2::splat(left * left));
        let (model, normals) = (fit.model.about_corner(), fit.model.normals());
        let across = [0, 1].map(|axis| {
            let normal = normals[axis];
            let variance = normal.dot(covariance_px2 * normal);
            // Towards dark is to one side before the corner and to the other behind it, by the other edge and by which
            // diagonal is bright.
            let side = normals[1 - axis].dot(normal.perp()) * model.light[3];
            [variance.max(0.0).sqrt(), STEP_TURN * side.signum() / half_px[axis]]
        });
        self.fitted[number] = Some(FittedCorner { model, normals, covariance_px2, half_px, across });
    }

    /// The contrasts of the corners that were fitted.
    pub(super) fn contrasts(&self) -> impl Iterator<Item = ([i32; 2], f64)> {
        self.lattice()
            .iter()
            .filter_map(|(&cell, &k)| Some((cell, 2.0 * self.fitted[k].as_ref()?.model.light[3].abs())))
    }

    /// Where the corner of a cell beside a corner of the lattice should be, and how long the step to it is, in px.
    pub(super) fn expected(&self, cell: [i32; 2]) -> Option<(DVec2, f64)> {
        let cell = IVec2::from_array(cell);
        NEIGHBOURS.into_iter().find_map(|back| {
            let from = cell + back;
            let here = self.at(from)?;
            let step = self.step(from, back.abs())? * f64::from(-back.x - back.y);
            Some((here + step, step.length()))
        })
    }

    /// The lattice line through a cell, as positions show it without directions. Where it is too short to show its
    /// bend, the parallel lines beside it show theirs.
    fn straight_line(&self, cell: IVec2, direction: IVec2) -> Option<LatticeLine> {
        let own = |cell: IVec2| {
            let (nodes, own) = self.nodes(cell, direction)?;
            line(&nodes, own)
        };
        let bend = |cell: IVec2| own(cell).filter(|l| l.corners >= LONG_LINE).map(|l| l.curvature);
        let here = own(cell);
        if here.is_some_and(|l| l.corners >= LONG_LINE) {
            return here;
        }
        let beside: Vec<f64> = [direction.perp(), -direction.perp()]
            .into_iter()
            .filter_map(|aside| {
                let near = bend(cell + aside)?;
                // Carried on from two lines where there are two.
                Some(bend(cell + aside * 2).map_or(near, |far| 2.0 * near - far))
            })
            .collect();
        let borrowed = || NEIGHBOURS.into_iter().find_map(|n| own(cell + n)).map(|l| LatticeLine { corners: 1, ..l });
        let here = here.or_else(borrowed)?;
        if beside.is_empty() {
            return Some(here);
        }
        Some(LatticeLine { curvature: beside.iter().sum::<f64>() / beside.len() as f64, ..here })
    }

    /// The corners along a line around a cell, in order, and the place of the cell's own among them.
    pub(super) fn nodes(&self, cell: IVec2, direction: IVec2) -> Option<(Vec<LineCorner>, usize)> {
        // Describe one corner of the line.
        let axis = usize::from(direction == IVec2::Y);
        let node = |offset: i32| {
            let number = self.cells.number(cell + direction * offset)?;
            let tangent = self.fitted[number].as_ref().map(|f| {
                let (normal, [sigma_px, turn_per_px]) = (f.normals[axis], f.across[axis]);
                let spacing_px = match self.lean {
                    Lean::Even(_) => 1.0,
                    Lean::OfSquare(_) => self.spacing_px(cell + direction * offset, axis).unwrap_or(0.0),
                };
                let beyond = f.model.leans_px[axis] - self.lean.at(spacing_px);
                let unit = (normal.perp() - normal * (beyond * turn_per_px)).normalize();
                Tangent { unit, sigma_px, half_px: f.half_px[axis], turn_per_px, spacing_px }
            });
            Some(LineCorner { position: self.positions[number], tangent })
        };

        // Walk outwards on both sides in turn, each side until its first gap.
        let first = node(0)?;
        let mut nodes = VecDeque::with_capacity(MOST);
        nodes.push_back(first);
        let mut own = 0;
        let (mut before, mut after) = (Some(1), Some(1));
        while (before, after) != (None, None) && nodes.len() < MOST {
            before = before.and_then(|k| {
                nodes.push_front(node(-k)?);
                own += 1;
                Some(k + 1)
            });
            if nodes.len() < MOST {
                after = after.and_then(|k| {
                    nodes.push_back(node(k)?);
                    Some(k + 1)
                });
            }
        }
        Some((nodes.into(), own))
    }

    /// The line through a cell, from all that is known of the corners along it, or where these are too few, from the
    /// parallel lines beside it.
    fn line(&self, cell: IVec2, direction: IVec2) -> Option<LatticeLine> {
        let own = self.fitted_line(cell, direction);
        own.filter(|l| l.corners >= OWN_LINE)
            .or_else(|| self.line_beside(cell, direction, OWN_LINE))
            .or(own)
            .or_else(|| self.line_beside(cell, direction, 0))
            .or_else(|| self.straight_line(cell, direction))
    }

    /// The line through a cell whose corners along it were all fitted.
    fn fitted_line(&self, cell: IVec2, direction: IVec2) -> Option<LatticeLine> {
        let (nodes, own) = self.nodes(cell, direction)?;
        let curvature = bend(&nodes, own, self.powers[nodes.len()])?;
        Some(LatticeLine { tangent: nodes[own].tangent?.unit, curvature, corners: nodes.len() })
    }

    /// The line through a fitted cell with the bend that the lines beside it, of so many corners at least, lead to.
    fn line_beside(&self, cell: IVec2, direction: IVec2, least: usize) -> Option<LatticeLine> {
        let (nodes, own) = self.nodes(cell, direction)?;
        let tangent = nodes[own].tangent?.unit;
        let led_to = |aside: IVec2| {
            let line = |k: i32| self.fitted_line(cell + aside * k, direction);
            let bend = |k: i32| line(k).filter(|l| l.corners >= least).map(|l| l.curvature);
            let (one, two, three) = (bend(1)?, bend(2), bend(3));
            Some(match (two, three) {
                (Some(two), Some(three)) => 3.0 * (one - two) + three,
                (Some(two), None) => 2.0 * one - two,
                _ => one,
            })
        };
        let bends: Vec<f64> = [direction.perp(), -direction.perp()].into_iter().filter_map(led_to).collect();
        let curvature = bends.iter().sum::<f64>() / bends.len() as f64;
        curvature.is_finite().then_some(LatticeLine { tangent, curvature, corners: 1 })
    }

    /// By how much the squared errors along the two lines of a cell are larger than told, in the mean.
    pub(super) fn error_scale(&self, cell: [i32; 2]) -> f64 {
        let scale = |direction| self.nodes(IVec2::from_array(cell), direction).map_or(1.0, |n| self.scales[n.0.len()]);
        0.5 * (scale(IVec2::X) + scale(IVec2::Y))
    }

    /// How far the lattice lines' bends at a cell may be off, as standard deviations in 1/px; 0 where they do not tell.
    fn bend_doubts(&self, cell: IVec2) -> [f64; 2] {
        [IVec2::X, IVec2::Y].map(|direction| {
            let doubt = self.nodes(cell, direction).and_then(|(nodes, own)| {
                let power = self.powers[nodes.len()];
                (nodes.len() >= OWN_LINE).then(|| bend_doubt(&nodes, own, power, self.scales[nodes.len()])).flatten()
            });
            doubt.unwrap_or(0.0)
        })
    }

    /// What the doubt of the bends adds to the covariance of the corner at a cell, in px^2: an edge that was fitted with a bend
    /// off by b over t - h .. t + h is off by b h^2 / 6.
    pub(super) fn doubt_px2(&self, cell: [i32; 2], model: &Model, half: f64) -> DMat2 {
        let cell = IVec2::from_array(cell);
        let doubts = self.bend_doubts(cell);
        let normals = model.normals();
        let off = |axis: usize, direction: IVec2| {
            let half_px = half * self.step(cell, direction).map_or(0.0, DVec2::length);
            let shift = doubts[axis] * half_px * half_px / 6.0;
            // The corner slides along the other edge.
            let other = normals[1 - axis].perp();
            let way = other * (shift / other.dot(normals[axis]));
            DMat2::from_cols(way * way.x, way * way.y)
        };
        let sum = off(0, IVec2::X) + off(1, IVec2::Y);
        if sum.is_finite() { sum } else { DMat2::ZERO }
    }

    /// Half the way from the corner before to the corner after.
    pub(super) fn step(&self, cell: IVec2, direction: IVec2) -> Option<DVec2> {
        let own = |cell: IVec2| {
            let centre = self.at(cell)?;
            match (self.at(cell - direction), self.at(cell + direction)) {
                (Some(before), Some(after)) => Some(0.5 * (after - before)),
                (Some(before), None) => Some(centre - before),
                (None, Some(after)) => Some(after - centre),
                (None, None) => None,
            }
        };
        own(cell).or_else(|| NEIGHBOURS.into_iter().find_map(|n| own(cell + n)))
    }

    pub(super) fn site(&self, cell: [i32; 2]) -> Option<CornerSite> {
        let cell = IVec2::from_array(cell);
        let number = self.cells.number(cell)?;
        let steps = DMat2::from_cols(self.step(cell, IVec2::X)?, self.step(cell, IVec2::Y)?);
        let lines = [self.line(cell, IVec2::X)?, self.line(cell, IVec2::Y)?];
        let leans_px = self.leans_px(cell);
        let due_px = self.fitted[number].as_ref().map(|f| {
            // An edge fitted with a wrong bend is off by a sixth of what the bend's error makes at the window's end.
            let off = |k: usize| (lines[k].curvature - f.model.curvature[k]) * f.half_px[k] * f.half_px[k] / 6.0;
            let sigma = (0.5 * (f.covariance_px2.x_axis.x + f.covariance_px2.y_axis.y)).sqrt();
            // Another lean moves the two directions, and the bends with them, by some tenth of its change.
            let lean = 0.1 * (DVec2::from(leans_px) - DVec2::from(f.model.leans_px)).abs().max_element();
            [off(0).abs().max(off(1).abs()).max(lean), sigma]
        });
        // Less than a square pixel of lattice, or edges that nearly coincide, hold no corner.
        let open = lines[0].tangent.perp_dot(lines[1].tangent).abs() > 0.1;
        (open && steps.determinant().abs() > 1.0).then_some(CornerSite {
            centre: self.positions[number],
            steps,
            lines,
            light: self.fitted[number].as_ref().map_or([0.0; 6], |f| f.model.light),
            leans_px,
            lean_rates: self.lean_rates(cell),
            skew: self.skew,
            marked: self.marked,
            due_px,
        })
    }
}
