//! The certified map of the columns that a seam passes through, on either side of which light takes another way through the glass: the
//! seam as a curve, and for either way a polynomial over all of the columns, by rays that take it also beyond the ridge.
//!
//! Rays vouch for it as for a patch of the map (`map`): along the border of what is seen by each way, the seam being a part of it,
//! and inside, they take the way that the curve tells and agree with its polynomial.

use super::centre_rays::CentreTracer;
use super::map::{BORDER_STEP, INSET_PX, INSIDE, MapPatch, corners};
use super::region::Region;
use crate::effect::Hook;
use crate::num::chebyshev::{Interpolation, points};
use crate::system::{Side, System, Way};
use glam::DVec2;

/// The ways left and right of the seam between the sides.
pub(super) const SIDES: [Way; 2] = [Way::through(Side::Left), Way::through(Side::Right)];

/// The map of the columns that a seam passes through.
#[derive(Debug)]
pub(super) struct SeamMap {
    /// The pixels for which it stands.
    pub(super) region: Region,
    /// What is seen by the ways left and right of it, each over all of the region.
    pub(super) sides: [MapPatch; 2],
    /// The column of the seam, in px, by rising powers of the t of the sides.
    curve: Vec<f64>,
    /// How far the seam strays from its chord within a row at most, in px.
    pub(super) stray_px: f64,
    /// How far pixels under the seam may be off for the bend of map and seam, in px: what third orders leave of the bend allowed.
    pub(super) allowed_px: f64,
}

/// Fewer rows are traced for less than the fit costs.
const LEAST_ROWS: usize = 64;
/// Degree of the curve.
const CURVE_DEGREE: usize = 12;
/// Steps of the secant method to the ridge, and the step at which it is there, in px.
const SECANTS: usize = 12;
const THERE_PX: f64 = 1e-11;
/// Rays on either side of the curve vouch for it: this far from it, in px, or the error allowed to the map.
const BESIDE_PX: f64 = 1e-7;
/// Places along the upper and the lower border of the region.
const ALONG_BORDER: usize = 8;

impl SeamMap {
    /// Traces and fits `region`, left and right of whose seam light takes these ways; `None` where rays do not vouch for it, or where
    /// something besides that ridge is to be seen there, or mirror images that are not `copied`. `rays` counts them.
    pub(super) fn fit(
        tracer: &CentreTracer,
        region: &Region,
        ways: [Way; 2],
        copied: bool,
        rays: &mut u64,
    ) -> Option<Self> {
        // Pixels on the axis itself are not copied.
        let system = tracer.system();
        let mirrored = system.is_mirror_symmetric() && !copied;
        let other_ways = system.clips() || system.effects().act_by(Hook::Transport) || mirrored;
        if other_ways || region.rows.len() < LEAST_ROWS || region.columns.is_empty() {
            return None;
        }

        // Find the curve, and check which way light takes on either side of it.
        let continued = system.continued();
        let scale = 1.0 / system.board().pattern.square_mm;
        let patches = ways.map(|way| MapPatch::over(system, region, way.front.into(), way.front == Side::Left));
        let (curve, bend_px) = curve(&continued, region, ways, rays)?;
        let column = |y: f64| at(&curve, patches[0].t(y));
        let (left, right) = places(system, region, &patches[0], column).into_iter().partition(|px| px.x < column(px.y));
        let mut check = |way: Way, places: Vec<DVec2>| {
            let seen_mm = tracer.of_class(way.front.into(), &places, rays)?;
            let seen = seen_mm.into_iter().map(|mm| mm * scale);
            places.iter().all(|px| system.takes(*px, way)).then(|| places.iter().copied().zip(seen).collect::<Vec<_>>())
        };
        let checks = [check(ways[0], left)?, check(ways[1], right)?];

        // Fit what is seen by either way, by rays that take it also beyond the ridge.
        let fit = |k: usize, patch: MapPatch, rays: &mut u64| {
            let checks = &mut checks[k].clone();
            // The scale is that between the first two.
            let last = checks.pop()?;
            checks.insert(1.min(checks.len()), last);
            let mut one = |px: &DVec2| {
                *rays += 1;
                let (ray, _) = continued.exit_ray_by(*px, ways[k]).ok()?;
                continued.board().intersect(&ray).ok().map(|(mm, _)| mm)
            };
            let mut through = |places: &[DVec2]| places.iter().map(&mut one).collect();
            patch.fitted(system.accuracy(), checks, &mut through, scale)
        };
        let [left, right] = patches;
        let sides = [fit(0, left, rays)?, fit(1, right, rays)?];
        let truncation_px = sides.iter().map(|side| side.truncation_px).fold(0.0, f64::max);
        let allowed_px = system.accuracy().bend_px - truncation_px;
        // NaN must not pass.
        (allowed_px > 0.0).then(|| Self { region: region.clone(), sides, curve, stray_px: bend_px, allowed_px })
    }

    /// The column of the seam at the height y of the picture, in px.
    #[inline(always)]
    pub(super) fn column(&self, y: f64) -> f64 {
        at(&self.curve, self.sides[0].t(y))
    }

    /// The map of the way by which `px` sees.
    pub(super) fn side_at(&self, px: DVec2) -> &MapPatch {
        &self.sides[usize::from(px.x >= self.column(px.y))]
    }
}

/// The polynomial at t.
#[inline(always)]
fn at(powers: &[f64], t: f64) -> f64 {
    powers.iter().rev().fold(0.0, |p, c| p * t + c)
}

/// The column of the seam by powers of t, from -1 to 1 over the rows of `region`, and how far it strays from its chord within
/// a row at most, in px. `continued` has surfaces that go on beyond the ridge.
fn curve(continued: &System, region: &Region, ways: [Way; 2], rays: &mut u64) -> Option<(Vec<f64>, f64)> {
    let [low, high] = corners(region);
    let (middle, half) = (0.5 * (low.y + high.y), 0.5 * (high.y - low.y));
    let nodes = points(CURVE_DEGREE + 1);
    let column = |t: &f64| {
        let mut off_mm = |x: f64| {
            *rays += 1;
            let px = DVec2::new(x, middle + t * half);
            let off_mm = if ways[0].front == ways[1].front {
                continued.exit_ray_by(px, ways[1]).ok().map(|(_, back_x_mm)| back_x_mm)
            } else {
                continued.front_x_mm(px, ways[1].front)
            };
            off_mm.map(|off_mm| (x, off_mm))
        };
        ridge_column([low.x, high.x], &mut off_mm)
    };
    let columns: Vec<f64> = nodes.iter().map(column).collect::<Option<_>>()?;
    let series = Interpolation::new(&[0.0], &nodes)?.series(|_, j| columns[j]);
    let stray_px = series.bound(0, 2) / (8.0 * half * half);
    Some((series.powers(0, CURVE_DEGREE).pop()?, stray_px))
}

/// Where the secant method, from two columns on, finds the ridge, in px, given a column with how far off it is.
fn ridge_column(from: [f64; 2], off_mm: &mut dyn FnMut(f64) -> Option<(f64, f64)>) -> Option<f64> {
    let (mut before, mut here) = (off_mm(from[0])?, off_mm(from[1])?);
    for _ in 0..SECANTS {
        let x: f64 = here.0 - here.1 * (here.0 - before.0) / (here.1 - before.1);
        if !x.is_finite() || (x - here.0).abs() < THERE_PX {
            break;
        }
        (before, here) = (here, off_mm(x)?);
    }
    Some(here.0)
}

/// The places that check the map: along the border of the region, on both sides of the seam, and inside.
fn places(system: &System, region: &Region, patch: &MapPatch, column: impl Fn(f64) -> f64) -> Vec<DVec2> {
    let [low, high] = corners(region);
    let [low, high] = [low + INSET_PX, high - INSET_PX];
    let beside_px = system.accuracy().map_px.min(BESIDE_PX);
    let mut places = Vec::new();
    for y in region.rows.clone().step_by(BORDER_STEP).chain([region.rows.end]) {
        let y = (y as f64).clamp(low.y, high.y);
        places.extend([low.x, high.x, column(y) - beside_px, column(y) + beside_px].map(|x| DVec2::new(x, y)));
    }
    for k in 0..=ALONG_BORDER {
        let x = low.x + (high.x - low.x) * (k as f64 / ALONG_BORDER as f64);
        places.extend([low.y, high.y].map(|y| DVec2::new(x, y)));
    }
    places.extend((0..INSIDE).map(|k| patch.inside(k)));
    // Where the seam is within a rounding of the border, or leaves the region by it.
    places.retain(|px| px.x >= low.x && px.x <= high.x && (px.x - column(px.y)).abs() > 0.5 * beside_px);
    places
}
