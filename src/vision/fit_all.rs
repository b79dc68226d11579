//! Corner measurement on a lattice of candidates: estimate the blur, fit, prune, and fit again.

use super::blur::{self, FIRST_MARGIN_PX, FIRST_SIGMA_PX, FirstFits, MAYBE_SHARP_PX};
use super::blur_shape::{PictureBlur, moved_width_px};
use super::candidate::Candidate;
use super::candidates::Candidates;
use super::corner_fit::{CornerFit, fit};
use super::corner_model::{Effort, Model};
use super::corner_site::CornerSite;
use super::detection::{Corner, Detection, Polarity, Reason, Rejected};
use super::elongation::{elongation, elongation_by_motion, skew};
use super::kinks::prune_kinks;
use super::lattice_growth::{Lattice, is_broad};
use super::lattice_lines::Grid;
use super::lean::Lean;
use super::marks::holds_marks;
use super::neighbours::{Neighbourhood, hanging};
use super::numbering::{from_zero, normalise};
use super::odd_residuals::widen_unlike;
use super::pixel_sums::WindowFrame;
use super::resolution::{Resolution, resolution};
use super::scatter::hold_against_lattice;
use super::settings::{Blur, Settings};
use super::shape_fit::find_shapes;
use glam::DVec2;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Lines nearer to each other than so many blurs blur into each other's windows.
const LEAST_SPACING: f64 = 6.0;
/// Half the first fit's window: at least this share of a step and this many px.
const FIRST_HALF: (f64, f64) = (0.25, 8.0);
const LAST_MARGIN_PX: f64 = 0.3;
/// The first fit is done when a step is below this, in px.
const FIRST_STEP_PX: f64 = 0.01;
/// Rounds of first fits at most. The bend of a line follows from its fitted corners: where it turns out other than it
/// was taken for, and this would move the corner by more than this many px and this share of its standard deviation,
/// the corner is fitted again.
const FIRST_ROUNDS: usize = 2;
const DUE: (f64, f64) = (2e-4, 0.2);
/// The last fits are made in so many rounds at most, again where the bends that full windows show would move a corner by more than
/// this many px and standard deviations.
const ROUNDS: usize = 4;
const LAST_DUE: (f64, f64) = (1e-5, 1.0);
/// The last fit is done when a step is below this, in px. Steps shrink with their square over some 0.3 px, so the next
/// would be of 1e-5 px.
const LAST_STEP_PX: f64 = 2e-3;
/// Under a blur below this, in px, that range is as narrow as the blur, and an edge on the border of its pixels comes
/// nearer by a share at each step only, since without blur its slope is a wider pixel's (`edge_spread`): there the step
/// itself must be as small.
const NARROW_SIGMA_PX: f64 = 0.1;
const NARROW_STEP_PX: f64 = 1e-5;
/// Steps of the last fit at most: of a blur that is known, of a narrow one, and of a free one.
const LAST_STEPS: [usize; 3] = [6, 32, 12];
/// A fit that ends further than this from its candidate, in pixels of the resolution that this was found in, has found something else.
const MOST_MOVE_PX: f64 = 3.0;
/// Fewer corners leave less than 20 degrees of freedom beside a board of second degree (`scatter`).
const FEW: usize = 16;
/// The last fits are made so often at most: again without a corner that turned out to be none, since the bends of its lines were
/// taken from it too.
const LAST_ROUNDS: usize = 2;

/// Measures the corners of one lattice. The answer turns down corners of that lattice only.
pub(super) fn measure_lattice(candidates: &Candidates<'_>, lattice: &Lattice, settings: &Settings) -> Detection {
    let lattice = normalise(lattice, |k| candidates.list[k].position);
    match resolution(candidates, &lattice, settings) {
        Resolution::Own(first) => measure_upright(candidates, lattice, settings, first),
        Resolution::Coarser(picture) => {
            let found = measure_upright(&picture.candidates(), lattice, &picture.settings(settings), None);
            picture.in_picture(found)
        }
    }
}

/// Measures the corners of a lattice that is numbered upright.
fn measure_upright(
    candidates: &Candidates<'_>,
    lattice: Lattice,
    settings: &Settings,
    first: Option<FirstFits>,
) -> Detection {
    let mut rejected = Vec::new();
    let positions: Vec<DVec2> = candidates.list.iter().map(|c| c.position).collect();
    let mut grid = Grid::new(lattice, positions);

    let mut sigma_px = first_blur(candidates, &mut grid, settings, first);
    let mut start_sigma = sigma_px.unwrap_or([FIRST_SIGMA_PX; 2]);

    // Fit all corners in small windows, and drop those that make kinks in their lines.
    first_fits(candidates, &mut grid, &mut rejected, &PictureBlur::gaussian(start_sigma), settings);
    prune_kinks(&mut grid, &mut rejected);
    prune_hanging(candidates, &mut grid, &mut rejected);

    // Estimate the blur again where the bends and leans, which are known now, change it.
    sigma_px = again(candidates, &grid, settings, sigma_px);
    start_sigma = sigma_px.unwrap_or(start_sigma);

    // Fit the corners that are left in full windows, under a blur of another shape where the picture shows one; where edges
    // lean, or marks lie beside them, it is not alike to both sides of them.
    let blur = match settings.blur {
        Blur::Common if grid.marked => PictureBlur::gaussian(start_sigma),
        Blur::Common if grid.lean.is_none() => find_shapes(candidates, &grid.pilots(), settings, start_sigma, false),
        Blur::Common => find_shapes(candidates, &grid.sites(), settings, start_sigma, true),
        _ => PictureBlur::gaussian(start_sigma),
    };
    let mut last = BTreeMap::new();
    for _ in 0..LAST_ROUNDS {
        let before = rejected.len();
        last_fits(candidates, &mut grid, &mut rejected, (&blur, &mut last), settings);
        prune_hanging(candidates, &mut grid, &mut rejected);
        if rejected[before..].iter().all(|r| !matches!(r.reason, Reason::Residual | Reason::OffLattice)) {
            break;
        }
    }
    if grid.lattice().len() < settings.min_corners || !is_broad(grid.lattice()) {
        rejected.extend(
            grid.lattice().values().map(|&k| Rejected { position_px: grid.positions[k], reason: Reason::NoGrid }),
        );
        return Detection::none(rejected);
    }

    // Number the corners, and hold their covariances against the lattice.
    let mut corners = numbered(&grid, last.into_values());
    widen_unlike(&mut corners);
    hold_against_lattice(&mut corners, !grid.lean.is_none() || blur.shapes.iter().any(|s| !s.is_gaussian()));

    // Take the blur's shape at a corner in the middle of those that told it.
    let some = grid.pilots();
    let normals = some.get(some.len() / 2).map(CornerSite::normals);
    let elongated_blur = if blur.is_moved() {
        sigma_px = normals.map(|n| n.map(|n| moved_width_px(blur.sigma_px[0], n.dot(blur.half_way_px))));
        elongation_by_motion(blur.sigma_px[0], blur.half_way_px)
    } else {
        sigma_px.and_then(|sigma_px| elongation(normals?, sigma_px, grid.skew))
    };
    let (lean_px, marked_squares) = (grid.lean_px(), grid.marked);
    Detection { corners, rejected, sigma_px, elongated_blur, lean_px, marked_squares }
}

/// The blur from some corners, with what else the grid should know before any of it is fitted: whether its squares hold marks, and
/// how the blurs across both families of lines go together.
fn first_blur(
    candidates: &Candidates<'_>,
    grid: &mut Grid,
    settings: &Settings,
    first: Option<FirstFits>,
) -> Option<[f64; 2]> {
    // See whether the squares hold marks, and estimate the blur.
    grid.marked = holds_marks(candidates, &grid.pilots(), settings);
    let mut sigma_px = match settings.blur {
        Blur::Known(sigma_px) => Some([sigma_px.max(0.0); 2]),
        Blur::Common | Blur::PerCorner => {
            let pilots = grid.pilots();
            // Beside marks the windows are others.
            let first = first.filter(|_| !grid.marked);
            let first = first.unwrap_or_else(|| blur::first_fits(candidates, &pilots, settings));
            blur::estimate(candidates, &pilots, settings, first)
        }
    };
    if let (Some(sigma), Blur::Common | Blur::PerCorner) = (&mut sigma_px, settings.blur) {
        (grid.skew, *sigma) = skew(candidates, &grid.pilots(), settings, *sigma);
    }
    sigma_px
}

/// The blur, estimated again where it is far narrower than a pixel, since it shows in few pixels and hangs on the bends, and where
/// ink spread, since edges that lean look wider than they are.
fn again(candidates: &Candidates<'_>, grid: &Grid, settings: &Settings, known: Option<[f64; 2]>) -> Option<[f64; 2]> {
    let start = known.unwrap_or([FIRST_SIGMA_PX; 2]);
    let (narrow, inked) = (start[0].max(start[1]) < MAYBE_SHARP_PX, matches!(grid.lean, Lean::OfSquare(_)));
    if matches!(settings.blur, Blur::Known(_)) || !(narrow || inked) {
        return known;
    }
    let pilots = grid.pilots();
    if narrow {
        let first = blur::first_fits(candidates, &pilots, settings);
        blur::estimate(candidates, &pilots, settings, first).or(known)
    } else {
        Some(blur::estimate_again(candidates, &pilots, settings, start))
    }
}

/// The corners of the last fits, numbered from column and row 0.
fn numbered(grid: &Grid, last: impl Iterator<Item = Outcome>) -> Vec<Corner> {
    // Add the doubt of the bends that were carried over from the lattice. Of a few corners the lattice does not tell errors from a
    // bend, but the directions along its lines do.
    let few = grid.lattice().len() < FEW;
    let doubted = |cell: [i32; 2], half: f64, fit: CornerFit| {
        let doubt_px2 = grid.doubt_px2(cell, &fit.model, half);
        let scale = if few { grid.error_scale(cell) } else { 1.0 };
        CornerFit { covariance_px2: scale * fit.covariance_px2 + doubt_px2, ..fit }
    };

    // Number the corners from column and row 0.
    let fits: BTreeMap<usize, CornerFit> =
        last.filter_map(|(cell, k, half, fit)| Some((k, doubted(cell, half, fit.ok()?)))).collect();
    let lattice = from_zero(grid.lattice());
    lattice.iter().filter_map(|(&index, k)| Some(corner(index, grid.positions[*k], fits.get(k)?))).collect()
}

/// Whether the fit of a corner ended too far from where it was sought.
fn moved(candidate: &Candidate, fit: &CornerFit) -> bool {
    fit.model.corner.length() > MOST_MOVE_PX * candidate.scale
}

/// First fits: small windows, from the candidates, in rounds until the bends of the lines have settled.
fn first_fits(
    candidates: &Candidates<'_>,
    grid: &mut Grid,
    rejected: &mut Vec<Rejected>,
    blur: &PictureBlur,
    settings: &Settings,
) {
    let effort = Effort { free_blur: false, steps: 8, tolerance_px: FIRST_STEP_PX, most_sigma_px: f64::INFINITY };
    for _ in 0..FIRST_ROUNDS {
        // Fit the corners that were not fitted yet, or that the new bends would move.
        let due = |[shift, sigma]: [f64; 2]| shift > DUE.0.max(DUE.1 * sigma);
        let first = fit_all(candidates, grid, |site| {
            let half = settings.window.min(FIRST_HALF.0.max(FIRST_HALF.1 / site.step_px()));
            let half = site.half(half, blur);
            site.due_px
                .is_none_or(due)
                .then(|| (site.frame(blur, half, FIRST_MARGIN_PX), site.model(blur, settings.light), effort))
        });
        if first.is_empty() {
            break;
        }

        // Drop the corners that moved too far or whose contrast is weak, and choose the powers of the lines anew.
        prune(grid, rejected, (&first, &BTreeMap::new()), |(cell, k), fit, around| {
            if moved(&candidates.list[k], fit) {
                Some(Reason::Moved)
            } else if around.is_faint(cell) {
                Some(Reason::LowContrast)
            } else {
                None
            }
        });
        grid.find_lean();
        grid.choose_powers();
    }
}

/// Last fits: full windows, with the bends from the positions of the first fits; of those that are in `last` only the corners that
/// the bends would move.
fn last_fits(
    candidates: &Candidates<'_>,
    grid: &mut Grid,
    rejected: &mut Vec<Rejected>,
    (blur, last): (&PictureBlur, &mut BTreeMap<[i32; 2], Outcome>),
    settings: &Settings,
) {
    // Choose the steps and the tolerance by the blur: free, narrow or wide.
    let free_blur = settings.blur == Blur::PerCorner;
    let narrow = blur.sigma_px[0].min(blur.sigma_px[1]) < NARROW_SIGMA_PX;
    let (steps, tolerance_px) = match (free_blur, narrow) {
        (true, _) => (LAST_STEPS[2], LAST_STEP_PX),
        (false, true) => (LAST_STEPS[1], NARROW_STEP_PX),
        (false, false) => (LAST_STEPS[0], LAST_STEP_PX),
    };

    let due = |[shift, sigma]: [f64; 2]| shift > LAST_DUE.0.max(LAST_DUE.1 * sigma);
    let all = last.is_empty();
    for round in 0..ROUNDS {
        // Fit every corner, and then those that the new bends would move.
        let fitted = fit_all(candidates, grid, |site| {
            let effort = Effort { free_blur, steps, tolerance_px, most_sigma_px: 0.5 * site.step_px() };
            ((all && round == 0) || site.due_px.is_none_or(due)).then(|| {
                let half = site.half(settings.window, blur);
                (site.frame(blur, half, LAST_MARGIN_PX), site.model(blur, settings.light), effort)
            })
        });
        if fitted.is_empty() {
            break;
        }

        // Drop the corners whose fit did not converge, moved too far, or leaves too large a residual.
        prune(grid, rejected, (&fitted, last), |(cell, k), fit, around| {
            if fit.last_step_px > 0.05 {
                Some(Reason::NotConverged)
            } else if moved(&candidates.list[k], fit) {
                Some(Reason::Moved)
            } else if around.is_unlike(cell) {
                Some(Reason::Residual)
            } else {
                None
            }
        });
        last.extend(fitted.into_iter().map(|outcome| (outcome.0, outcome)));
        grid.find_lean();
        grid.choose_powers();
    }
}

fn corner(index: [i32; 2], position_px: DVec2, fit: &CornerFit) -> Corner {
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

/// What became of a corner, and half its window in steps.
type Outcome = ([i32; 2], usize, f64, Result<CornerFit, Reason>);

/// Fits those corners of the lattice that `setup` wants, in its order whatever the number of threads.
fn fit_all(
    candidates: &Candidates<'_>,
    grid: &Grid,
    setup: impl Fn(&CornerSite) -> Option<(WindowFrame, Model, Effort)> + Sync,
) -> Vec<Outcome> {
    let cells: Vec<([i32; 2], usize)> = grid.lattice().iter().map(|(&cell, &k)| (cell, k)).collect();
    let one = |&(cell, k): &([i32; 2], usize)| {
        let Some(site) = grid.site(cell) else { return Some((cell, k, 0.0, Err(Reason::NoGrid))) };
        let (frame, model, effort) = setup(&site)?;
        Some((cell, k, frame.half, fit_one(candidates, &site, &frame, &model, &effort)))
    };
    cells.par_iter().map(one).collect::<Vec<_>>().into_iter().flatten().collect()
}

fn fit_one(
    candidates: &Candidates<'_>,
    site: &CornerSite,
    frame: &WindowFrame,
    model: &Model,
    effort: &Effort,
) -> Result<CornerFit, Reason> {
    if site.spacing_px() < LEAST_SPACING * model.widest_px() {
        return Err(Reason::Blurred);
    }
    let window = site.window(candidates, frame);
    if window.visible < crate::vision::settings::LEAST_VISIBLE {
        return Err(Reason::Cut);
    }
    fit(&window, model, effort).ok_or(Reason::NotConverged)
}

/// Takes the fitted positions over and drops the corners whose fit failed or breaks a rule, beside those of earlier rounds.
fn prune(
    grid: &mut Grid,
    rejected: &mut Vec<Rejected>,
    (outcomes, earlier): (&[Outcome], &BTreeMap<[i32; 2], Outcome>),
    rule: impl Fn(([i32; 2], usize), &CornerFit, &Neighbourhood) -> Option<Reason>,
) {
    let fits: BTreeMap<[i32; 2], &CornerFit> = earlier
        .values()
        .chain(outcomes)
        .filter(|outcome| grid.lattice().contains_key(&outcome.0))
        .filter_map(|(cell, _, _, fit)| Some((*cell, fit.as_ref().ok()?)))
        .collect();
    let around = Neighbourhood::new(fits.into_iter(), grid.contrasts());
    for (cell, k, half, outcome) in outcomes {
        match outcome
            .as_ref()
            .map_err(|&reason| reason)
            .and_then(|fit| rule((*cell, *k), fit, &around).map_or(Ok(fit), Err))
        {
            Ok(fit) => grid.take(*cell, *k, fit, *half),
            Err(reason) => {
                rejected.push(Rejected { position_px: grid.positions[*k], reason });
                grid.remove(*cell);
            }
        }
    }
}

/// Drops corners that hang on the lattice by a single neighbour.
fn prune_hanging(candidates: &Candidates<'_>, grid: &mut Grid, rejected: &mut Vec<Rejected>) {
    for cell in hanging(grid.lattice(), |cell| grid.expected(cell).is_some_and(|(at, px)| candidates.shows(at, px))) {
        if let Some(k) = grid.remove(cell) {
            rejected.push(Rejected { position_px: grid.positions[k], reason: Reason::OffLattice });
        }
    }
}

/// How many crossings hang on a lattice by a single neighbour before it is measured.
pub(super) fn hanging_candidates(candidates: &Candidates<'_>, lattice: &Lattice) -> usize {
    let grid = Grid::new(lattice.clone(), candidates.list.iter().map(|c| c.position).collect());
    let shows = |cell| grid.expected(cell).is_some_and(|(at, px)| candidates.shows(at, px));
    hanging(grid.lattice(), shows).len()
}
