//! From a lattice of rough crossings to measured corners: the blur, a first fit, pruning, and the last fit.

use super::blur::{self, FIRST_SIGMA_PX};
use super::curvature::{Line, line};
use super::grid::{Lattice, Lattices, NEIGHBOURS, from_zero, is_broad, normalise};
use super::profile::Shape;
use super::refine::{Effort, Fit, Model, fit};
use super::sight::Sight;
use super::window::{Frame, gather};
use super::{Blur, Corner, Detection, Polarity, Reason, Rejected, Settings};
use crate::num::stats::quantile;
use glam::{DMat2, DVec2, IVec2};
use rayon::prelude::*;

/// Corners on a line from which on its own bend is believed.
const LONG_LINE: usize = 6;
/// A grid of fewer corners is small.
const SMALL_GRID: usize = 64;
/// Corners that the blur is estimated from.
const PILOTS: usize = 24;
/// Lines nearer to each other than so many blurs blur into each other's windows.
const LEAST_SPACING: f64 = 6.0;
/// Half the first fit's window: at least this share of a step and this many px.
const FIRST_HALF: (f64, f64) = (0.25, 8.0);
/// How far a corner may be from where a fit starts before a listed band would be too narrow, in px.
pub(super) const FIRST_MARGIN_PX: f64 = 1.0;
const LAST_MARGIN_PX: f64 = 0.3;
/// The first fit is done when a step is below this, in px.
const FIRST_STEP_PX: f64 = 0.06;
/// The last fit is done when a step is below this, in px. Steps shrink with their square over some 0.3 px, so the next
/// would be of 1e-5 px.
const LAST_STEP_PX: f64 = 2e-3;
/// A fit that ends further than this from its candidate, in px, has found something else.
const MOST_MOVE_PX: f64 = 3.0;
/// The weakest contrast against the median of the lattice.
const LEAST_CONTRAST: f64 = 0.4;
/// A second difference along a line may differ from its neighbours' by this many px or this share of a step.
const MOST_KINK: (f64, f64) = (0.6, 0.12);
/// The largest residual against the median of the lattice, and against the corner's own amplitude.
const MOST_RESIDUAL: (f64, f64) = (3.0, 0.012);

/// A lattice with the best known position of each of its corners.
struct Grid {
    lattice: Lattice,
    positions: Vec<DVec2>,
    /// The model of the first fit, from the corner it found.
    models: Vec<Option<Model>>,
}

/// The lattice around one corner.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    centre: DVec2,
    steps: DMat2,
    lines: [Line; 2],
    /// The light as the first fit found it, or zeros.
    light: [f64; 6],
}

impl Grid {
    /// The lattice line through a cell. Where it is too short to show its bend, the parallel lines beside it show theirs.
    fn line(&self, cell: IVec2, direction: IVec2) -> Option<Line> {
        let own = |cell: IVec2| line(&self.lattice, |k| self.positions[k], cell, direction);
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
        let borrowed = || NEIGHBOURS.into_iter().find_map(|n| own(cell + n)).map(|l| Line { corners: 1, ..l });
        let here = here.or_else(borrowed)?;
        if beside.is_empty() {
            return Some(here);
        }
        Some(Line { curvature: beside.iter().sum::<f64>() / beside.len() as f64, ..here })
    }

    /// Half the way from the corner before to the corner after.
    fn step(&self, cell: IVec2, direction: IVec2) -> Option<DVec2> {
        let at = |c: IVec2| self.lattice.get(&c.to_array()).map(|&k| self.positions[k]);
        let own = |cell: IVec2| {
            let centre = at(cell)?;
            match (at(cell - direction), at(cell + direction)) {
                (Some(before), Some(after)) => Some(0.5 * (after - before)),
                (Some(before), None) => Some(centre - before),
                (None, Some(after)) => Some(after - centre),
                (None, None) => None,
            }
        };
        own(cell).or_else(|| NEIGHBOURS.into_iter().find_map(|n| own(cell + n)))
    }

    fn place(&self, cell: [i32; 2]) -> Option<Place> {
        let number = *self.lattice.get(&cell)?;
        let centre = self.positions[number];
        let cell = IVec2::from_array(cell);
        let steps = DMat2::from_cols(self.step(cell, IVec2::X)?, self.step(cell, IVec2::Y)?);
        let mut lines = [self.line(cell, IVec2::X)?, self.line(cell, IVec2::Y)?];
        let model = self.models[number];
        if let Some(model) = model {
            for (line, angle) in lines.iter_mut().zip(model.normal_rad) {
                let (sin, cos) = libm::sincos(angle);
                line.tangent = DVec2::new(-sin, cos);
            }
        }
        // Less than a square pixel of lattice, or edges that nearly coincide, hold no corner.
        let open = lines[0].tangent.perp_dot(lines[1].tangent).abs() > 0.1;
        (open && steps.determinant().abs() > 1.0).then_some(Place {
            centre,
            steps,
            lines,
            light: model.map_or([0.0; 6], |m| m.light),
        })
    }
}

impl Place {
    pub(super) fn step_px(&self) -> f64 {
        self.steps.x_axis.length().min(self.steps.y_axis.length())
    }

    /// The narrowest distance between parallel lines.
    fn spacing_px(&self) -> f64 {
        self.steps.determinant().abs() / self.steps.x_axis.length().max(self.steps.y_axis.length())
    }

    pub(super) fn model(&self, sigma_px: [f64; 2]) -> Model {
        let normal = |line: &Line| libm::atan2(-line.tangent.x, line.tangent.y);
        Model {
            corner: DVec2::ZERO,
            normal_rad: [normal(&self.lines[0]), normal(&self.lines[1])],
            curvature: self.lines.map(|l| l.curvature),
            sigma_px,
            light: self.light,
        }
    }

    pub(super) fn frame(&self, sigma_px: [f64; 2], half: f64, margin_px: f64) -> Frame {
        let normals = self.lines.map(|l| DVec2::new(l.tangent.y, -l.tangent.x));
        // The farthest point of the window, for the bend of the edges in it.
        let far = half * (self.steps.x_axis.abs() + self.steps.y_axis.abs()).length();
        let bands_px = [0, 1].map(|k| {
            let bend = 0.5 * self.lines[k].curvature.abs() * far * far;
            // A line without corners on both sides may point a few degrees off.
            let turn = if self.lines[k].corners < 3 { 0.15 * far } else { 0.0 };
            Shape::new(normals[k], sigma_px[k]).reach() + bend + turn + margin_px
        });
        Frame { centre: self.centre, steps: self.steps, normals, bands_px, half }
    }
}

/// Measures the corners of the largest lattice.
pub fn measure(sight: &Sight<'_>, lattices: Lattices, settings: &Settings) -> Detection {
    let mut rejected = sight.rejected.clone();
    let mut lattices = lattices.0.into_iter();
    let largest = lattices.next().unwrap_or_default();
    let mut reasons = vec![Some(Reason::NoGrid); sight.candidates.len()];
    lattices.flat_map(Lattice::into_values).for_each(|k| reasons[k] = Some(Reason::OtherGrid));
    largest.values().for_each(|&k| reasons[k] = None);
    let unplaced = sight.candidates.iter().zip(reasons);
    rejected.extend(unplaced.filter_map(|(c, reason)| Some(Rejected { position_px: c.position, reason: reason? })));
    if largest.is_empty() {
        return Detection { corners: Vec::new(), rejected, sigma_px: None };
    }
    let positions: Vec<DVec2> = sight.candidates.iter().map(|c| c.position).collect();
    let lattice = normalise(&largest, |k| positions[k]);
    let mut grid = Grid { lattice, models: vec![None; positions.len()], positions };
    let sigma_px = match settings.blur {
        Blur::Known(sigma_px) => Some([sigma_px.max(0.0); 2]),
        Blur::Common | Blur::PerCorner => estimate_blur(sight, &grid, settings),
    };
    let start_sigma = sigma_px.unwrap_or([FIRST_SIGMA_PX; 2]);
    let moved = |fit: &Fit| fit.model.corner.length() > MOST_MOVE_PX;

    // First fit: a smaller window, from the crossings. The bend of a short line is sensitive to the places of its corners,
    // so a small grid is fitted again from better ones; that is cheap.
    let effort = Effort { free_blur: false, steps: 8, tolerance_px: FIRST_STEP_PX, most_sigma_px: f64::INFINITY };
    let rounds = if grid.lattice.len() < SMALL_GRID { 3 } else { 1 };
    for _ in 0..rounds {
        let first = fit_all(sight, &grid, |place| {
            let half = settings.window.min(FIRST_HALF.0.max(FIRST_HALF.1 / place.step_px()));
            (place.frame(start_sigma, half, FIRST_MARGIN_PX), place.model(start_sigma), effort)
        });
        prune(&mut grid, &mut rejected, &first, |fit, typical| {
            let contrast = fit.model.light[3].abs();
            if moved(fit) {
                Some(Reason::Moved)
            } else if contrast < LEAST_CONTRAST * typical.contrast {
                Some(Reason::LowContrast)
            } else {
                None
            }
        });
    }
    prune_kinks(&mut grid, &mut rejected);

    // Last fit: the full window, curvatures from the first fit's positions.
    let free_blur = settings.blur == Blur::PerCorner;
    let effort = Effort { free_blur, steps: if free_blur { 12 } else { 6 }, tolerance_px: LAST_STEP_PX, ..effort };
    let last = fit_all(sight, &grid, |place| {
        let effort = Effort { most_sigma_px: 0.5 * place.step_px(), ..effort };
        (place.frame(start_sigma, settings.window, LAST_MARGIN_PX), place.model(start_sigma), effort)
    });
    prune(&mut grid, &mut rejected, &last, |fit, typical| {
        let limit = (MOST_RESIDUAL.0 * typical.residual).max(MOST_RESIDUAL.1 * fit.model.light[3].abs());
        if fit.last_step_px > 0.05 {
            Some(Reason::NotConverged)
        } else if moved(fit) {
            Some(Reason::Moved)
        } else if fit.residual > limit {
            Some(Reason::Residual)
        } else {
            None
        }
    });
    if grid.lattice.len() < settings.min_corners || !is_broad(&grid.lattice) {
        rejected.extend(
            grid.lattice.values().map(|&k| Rejected { position_px: grid.positions[k], reason: Reason::NoGrid }),
        );
        return Detection { corners: Vec::new(), rejected, sigma_px: None };
    }
    let fits: std::collections::BTreeMap<usize, Fit> =
        last.into_iter().filter_map(|(_, k, fit)| Some((k, fit.ok()?))).collect();
    let lattice = from_zero(&grid.lattice);
    let corners =
        lattice.iter().filter_map(|(&index, k)| Some(corner(index, grid.positions[*k], fits.get(k)?))).collect();
    Detection { corners, rejected, sigma_px }
}

fn corner(index: [i32; 2], position_px: DVec2, fit: &Fit) -> Corner {
    let amplitude = fit.model.light[3];
    // In the square between +column and +row the distance to the first edge is negative, to the second positive.
    let polarity = if amplitude < 0.0 { Polarity::Main } else { Polarity::Anti };
    Corner {
        position_px,
        index,
        covariance_px2: fit.covariance_px2,
        contrast: 2.0 * amplitude.abs(),
        residual: fit.residual,
        polarity,
    }
}

type Outcome = ([i32; 2], usize, Result<Fit, Reason>);

/// Fits every corner of the lattice, in its order whatever the number of threads.
fn fit_all(sight: &Sight<'_>, grid: &Grid, setup: impl Fn(&Place) -> (Frame, Model, Effort) + Sync) -> Vec<Outcome> {
    let cells: Vec<([i32; 2], usize)> = grid.lattice.iter().map(|(&cell, &k)| (cell, k)).collect();
    cells
        .par_iter()
        .map(|&(cell, k)| {
            let outcome = grid.place(cell).ok_or(Reason::NoGrid).and_then(|place| {
                let (frame, model, effort) = setup(&place);
                if place.spacing_px() < LEAST_SPACING * model.sigma_px[0].max(model.sigma_px[1]) {
                    return Err(Reason::Blurred);
                }
                let window = gather(sight.image, sight.valid.as_ref(), &frame);
                if window.visible < super::LEAST_VISIBLE {
                    return Err(Reason::Cut);
                }
                fit(&window, &model, &effort).ok_or(Reason::NotConverged)
            });
            (cell, k, outcome)
        })
        .collect()
}

/// Medians over a lattice.
struct Typical {
    contrast: f64,
    residual: f64,
}

/// Takes the fitted positions over and drops the corners whose fit failed or breaks a rule.
fn prune(
    grid: &mut Grid,
    rejected: &mut Vec<Rejected>,
    outcomes: &[Outcome],
    rule: impl Fn(&Fit, &Typical) -> Option<Reason>,
) {
    let fits = || outcomes.iter().filter_map(|(_, _, fit)| fit.as_ref().ok());
    let median = |f: fn(&Fit) -> f64| quantile(&fits().map(f).collect::<Vec<_>>(), 0.5).unwrap_or(0.0);
    let typical = Typical { contrast: median(|f| f.model.light[3].abs()), residual: median(|f| f.residual) };
    for (cell, k, outcome) in outcomes {
        match outcome.as_ref().map_err(|&reason| reason).and_then(|fit| match rule(fit, &typical) {
            Some(reason) => Err(reason),
            None => Ok(fit.model),
        }) {
            Ok(model) => {
                grid.positions[*k] += model.corner;
                grid.models[*k] = Some(model.about_corner());
            }
            Err(reason) => {
                rejected.push(Rejected { position_px: grid.positions[*k], reason });
                grid.lattice.remove(cell);
            }
        }
    }
}

/// Drops corners that make a kink in a line: the second difference there is unlike that of the corners beside it.
fn prune_kinks(grid: &mut Grid, rejected: &mut Vec<Rejected>) {
    let second = |cell: IVec2, direction: IVec2| {
        let at = |c: IVec2| grid.lattice.get(&c.to_array()).map(|&k| grid.positions[k]);
        Some(at(cell - direction)? + at(cell + direction)? - 2.0 * at(cell)?)
    };
    let kinked = |cell: IVec2| {
        [IVec2::X, IVec2::Y].into_iter().any(|direction| {
            let Some(own) = second(cell, direction) else { return false };
            let beside: Vec<DVec2> = [direction.perp(), -direction.perp()]
                .into_iter()
                .filter_map(|aside| second(cell + aside, direction))
                .collect();
            if beside.is_empty() {
                return false;
            }
            let expected = beside.iter().sum::<DVec2>() / beside.len() as f64;
            let step = grid.step(cell, direction).map_or(0.0, DVec2::length);
            // A kink of one corner by e shows as 2 e here and as e at its neighbours.
            (own - expected).length() > 2.0 * MOST_KINK.0.max(MOST_KINK.1 * step)
        })
    };
    let cells: Vec<[i32; 2]> = grid.lattice.keys().copied().filter(|&cell| kinked(IVec2::from_array(cell))).collect();
    for cell in cells {
        if let Some(k) = grid.lattice.remove(&cell) {
            rejected.push(Rejected { position_px: grid.positions[k], reason: Reason::OffLattice });
        }
    }
}

/// The blur across the column and the row lines, in px: medians of free fits to some corners spread over the lattice.
fn estimate_blur(sight: &Sight<'_>, grid: &Grid, settings: &Settings) -> Option<[f64; 2]> {
    let inner: Lattice = grid
        .lattice
        .iter()
        .filter(|(cell, _)| {
            NEIGHBOURS.iter().all(|&n| grid.lattice.contains_key(&(IVec2::from_array(**cell) + n).to_array()))
        })
        .map(|(&cell, &k)| (cell, k))
        .collect();
    let stride = inner.len().div_ceil(PILOTS).max(1);
    let pilots = inner.keys().step_by(stride);
    blur::estimate(sight, &pilots.filter_map(|&cell| grid.place(cell)).collect::<Vec<Place>>(), settings.window)
}
