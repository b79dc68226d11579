//! The certified map: polynomials that take a pixel position to the board, and rays that vouch for them.
//!
//! Inside a half the map is analytic, so a polynomial through a few dozen rays reproduces it to rounding. Three things
//! vouch for a patch of it: its coefficients fall below the error allowed; further rays, which the fit did not see,
//! agree with it; and every ray along the patch's border, and all those inside, pass the same side and reach the board.
//! What the border says holds inside: where rays meet the surfaces is an open map of the pixel, so that its extremes,
//! and with them a missed surface or the ridge, show at the border first; and total reflection has a root in it that
//! no polynomial follows, so that near it the coefficients do not fall.

use super::centre_rays::{CentreTracer, trace_scalar};
use super::film::Class;
use super::region::Region;
use super::truncation_error::in_px;
use crate::accuracy::Accuracy;
use crate::num::chebyshev::{ChebyshevSeries, Interpolation, MAX_DEGREE, points};
use crate::system::System;
use glam::{DMat2, DVec2};

/// A patch of the map.
#[derive(Debug, Clone)]
pub(super) struct MapPatch {
    /// The pixels for which it stands.
    pub(super) region: Region,
    /// The side that they see through.
    pub(super) class: Class,
    /// Whether x is counted to the left, as on the left half of the picture: mirror images then have the same bits.
    pub(super) flip: bool,
    /// The picture's middle column.
    axis: f64,
    /// Centre (from the axis in x) and 1 / half the sides, in px.
    centre: DVec2,
    inverse_half: DVec2,
    /// u (counted to the left where `flip`) and v in squares of the board, by powers of s, then of t.
    pub(super) powers: [Vec<Vec<f64>>; 2],
    /// Bounds of |du/dx|, |du/dy|, |d2u/dx2| and the same of v, in squares and px.
    pub(super) bounds: [[f64; 3]; 2],
    /// Largest difference from the rays that checked it, in px.
    pub(super) error_px: f64,
    /// How far the map strays from its tangent inside a pixel at most, in px, and by how much of that in its third order.
    pub(super) stray_px: f64,
    pub(super) truncation_px: f64,
    /// What transport effects leave of the light, by powers of s, then of t; `None` without such effects, or where no
    /// polynomial follows them.
    pub(super) throughput: Option<Vec<Vec<f64>>>,
}

/// The tries before the patch is divided: degrees of the interpolation.
const DEGREES: [usize; 4] = [4, 8, 12, MAX_DEGREE];
/// Rays inside a patch that check it.
pub(super) const INSIDE: usize = 64;
/// Px between the rays along the border of a patch.
pub(super) const BORDER_STEP: usize = 16;
/// A polynomial stands for the throughput of a patch where it differs from them by less than this: a sixth of the
/// rounding of f32.
const THROUGHPUT_ERROR: f64 = 1e-8;
/// Positions that are sampled are multiples of this, in px: exact on either half, so that mirrored rays are mirrored.
const GRAIN_PX: f64 = 1.0 / (1u64 << 20) as f64;
/// How far inside the border of a patch its border rays are traced, in px.
pub(super) const INSET_PX: f64 = 1.0 / (1u64 << 30) as f64;

impl MapPatch {
    /// The part of the patch over `region`.
    pub(super) fn part(&self, region: Region) -> Self {
        Self { region, ..self.clone() }
    }

    /// s of the picture's column x, in -1 ..= 1 inside the patch.
    #[inline(always)]
    pub(super) fn s(&self, x: f64) -> f64 {
        let d = if self.flip { self.axis - x } else { x - self.axis };
        (d - self.centre.x) * self.inverse_half.x
    }

    /// t of the picture's row y.
    #[inline(always)]
    pub(super) fn t(&self, y: f64) -> f64 {
        (y - self.centre.y) * self.inverse_half.y
    }

    /// ds/dpx and dt/dpx, without their signs.
    pub(super) fn steps(&self) -> DVec2 {
        self.inverse_half
    }

    /// The picture's position of (s, t), on the grain.
    fn place(&self, s: f64, t: f64) -> DVec2 {
        let on_grain = |v: f64| (v / GRAIN_PX).round() * GRAIN_PX;
        let d = on_grain(self.centre.x + s / self.inverse_half.x);
        let x = if self.flip { self.axis - d } else { self.axis + d };
        DVec2::new(x, on_grain(self.centre.y + t / self.inverse_half.y))
    }

    /// What the patch says that `px` sees, in squares, with the derivatives by px.
    pub(super) fn trace(&self, px: DVec2) -> (DVec2, DMat2) {
        let (s, t) = (self.s(px.x), self.t(px.y));
        let value_and_slopes = |powers: &[Vec<f64>]| {
            let (mut p, mut ps, mut pt) = (0.0, 0.0, 0.0);
            for row in powers.iter().rev() {
                let (r, rt) = row.iter().rev().fold((0.0, 0.0), |(r, rt), c| (r * t + c, rt * t + r));
                (ps, p, pt) = (ps * s + p, p * s + r, pt * s + rt);
            }
            [p, ps * self.inverse_half.x, pt * self.inverse_half.y]
        };
        let ([u, us, ut], [v, vs, vt]) = (value_and_slopes(&self.powers[0]), value_and_slopes(&self.powers[1]));
        let (sign, d) = if self.flip {
            (-1.0, DMat2::from_cols_array(&[us, -vs, -ut, vt]))
        } else {
            (1.0, DMat2::from_cols_array(&[us, vs, ut, vt]))
        };
        (DVec2::new(sign * u, v), d)
    }

    /// A patch over `region`, of what is seen through the side `class`, that is not fitted yet; with x counted to the left where `flip`.
    pub(super) fn over(system: &System, region: &Region, class: Class, flip: bool) -> Self {
        let axis = axis(system);
        let [low, high] = corners(region);
        let middle = 0.5 * (low + high);
        Self {
            region: region.clone(),
            class,
            flip,
            axis,
            centre: DVec2::new(if flip { axis - middle.x } else { middle.x - axis }, middle.y),
            inverse_half: 2.0 / (high - low),
            powers: [Vec::new(), Vec::new()],
            bounds: [[0.0; 3]; 2],
            error_px: 0.0,
            stray_px: 0.0,
            truncation_px: 0.0,
            throughput: None,
        }
    }

    /// Traces `region` and fits it; `None` where rays do not vouch for it. `rays` counts them.
    pub(super) fn fit(tracer: &CentreTracer, region: &Region, rays: &mut u64) -> Option<Self> {
        let system = tracer.system();
        let scale = 1.0 / system.board().pattern.square_mm;
        let flip = corners(region)[1].x <= axis(system) + 0.5;
        let mut patch = Self::over(system, region, Class::Missed, flip);

        // Trace the rays that check the patch: all must pass the side of its middle.
        let [low, high] = corners(region);
        patch.class = trace_scalar(system, 0.5 * (low + high)).1;
        *rays += 1;
        patch.class.side()?;
        let class = patch.class;
        let mut trace = |places: &[DVec2]| tracer.of_class(class, places, rays);
        let places = patch.check_places();
        let seen_mm = trace(&places)?;
        let checks: Vec<(DVec2, DVec2)> = places.into_iter().zip(seen_mm.into_iter().map(|mm| mm * scale)).collect();
        patch.fitted(system.accuracy(), &checks, &mut trace, scale)
    }

    /// The patch by polynomials of rising degree, until coefficients and the rays that check it, two or more, vouch for it;
    /// `trace` says what places see, in mm, where all are of the patch's class, and `scale` how many squares a mm is.
    pub(super) fn fitted(
        mut self,
        &Accuracy { map_px, map_degree, .. }: &Accuracy,
        checks: &[(DVec2, DVec2)],
        trace: &mut impl FnMut(&[DVec2]) -> Option<Vec<DVec2>>,
        scale: f64,
    ) -> Option<Self> {
        let px_per_square = coarse_scale(checks)?;
        let fixed = map_degree.map(|degree| degree.clamp(1, MAX_DEGREE));
        let degrees = fixed.as_ref().map_or(&DEGREES[..], std::slice::from_ref);
        degrees.iter().find_map(|&degree| {
            // A degree that is fixed stands, whatever its coefficients say; the rays still judge it.
            let error = if fixed.is_some() { None } else { Some(map_px / px_per_square) };
            let bounds = self.interpolate(degree, error, trace, scale)?;
            self.agrees(checks, map_px, bounds).then(|| self.clone())
        })
    }

    /// Where rays check the patch: along its border, its corners included, and inside it.
    fn check_places(&self) -> Vec<DVec2> {
        let region = &self.region;
        let [low, high] = corners(region);
        let mut places = Vec::new();
        for x in region.columns.clone().step_by(BORDER_STEP).chain([region.columns.end]) {
            places.extend([low.y, high.y].map(|y| DVec2::new(x as f64, y)));
        }
        for y in region.rows.clone().step_by(BORDER_STEP) {
            places.extend([low.x, high.x].map(|x| DVec2::new(x, y as f64)));
        }
        places.iter_mut().for_each(|px| *px = px.clamp(low + INSET_PX, high - INSET_PX));
        places.extend((0..INSIDE).map(|k| self.inside(k)));
        places
    }

    /// Whether the patch agrees with `checks` to `map_px`; its largest errors are then known, given how far it may
    /// stray from its tangent inside a pixel and what of that is of third order, in squares.
    fn agrees(&mut self, checks: &[(DVec2, DVec2)], map_px: f64, [stray, truncation]: [DVec2; 2]) -> bool {
        (self.error_px, self.stray_px, self.truncation_px) = (0.0, 0.0, 0.0);
        for &(px, seen) in checks {
            let (mapped, jacobian) = self.trace(px);
            let error = (jacobian.inverse() * (mapped - seen)).length();
            // NaN must not pass.
            if error.is_nan() || error > map_px {
                return false;
            }
            self.error_px = self.error_px.max(error);
            self.stray_px = self.stray_px.max(in_px(jacobian, stray));
            self.truncation_px = self.truncation_px.max(in_px(jacobian, truncation));
        }
        true
    }

    /// Place k of a sequence that fills the patch evenly and hits no node: multiples of the plastic number's inverse
    /// powers (Roberts 2018, the R2 sequence).
    pub(super) fn inside(&self, k: usize) -> DVec2 {
        let fill = |alpha: f64| 2.0 * (0.5 + alpha * (k + 1) as f64).fract() - 1.0;
        self.place(fill(0.754_877_666_246_693), fill(0.569_840_290_998_053_3))
    }

    /// Where a polynomial of `degree` is sampled, column by column, and the way from samples to it.
    fn nodes(&self, degree: usize) -> Option<(Vec<Vec<DVec2>>, Interpolation)> {
        let nodes = points(degree + 1);
        let places: Vec<Vec<DVec2>> =
            nodes.iter().map(|&s| nodes.iter().map(|&t| self.place(s, t)).collect()).collect();
        // Where the nodes really are, on the grain.
        let s: Vec<f64> = places.iter().map(|row| self.s(row[0].x)).collect();
        let t: Vec<f64> = places[0].iter().map(|p| self.t(p.y)).collect();
        let interpolation = Interpolation::new(&s, &t)?;
        Some((places, interpolation))
    }

    /// The throughput over the patch as a polynomial, whose coefficients and the throughput at further places vouch for
    /// it.
    pub(super) fn fit_throughput(&self, system: &System, rays: &mut u64) -> Option<Vec<Vec<f64>>> {
        DEGREES.iter().find_map(|&degree| {
            let (places, interpolation) = self.nodes(degree)?;
            let series = interpolation.series(|i, j| system.throughput(places[i][j]));
            *rays += ((degree + 1) * (degree + 1)) as u64;
            let [m, n] = kept(&series, 0.25 * THROUGHPUT_ERROR)?;
            let powers = series.powers(m, n);
            *rays += INSIDE as u64;
            let agrees = |k: usize| {
                let px = self.inside(k);
                let (s, t) = (self.s(px.x), self.t(px.y));
                let line = |row: &Vec<f64>| row.iter().rev().fold(0.0, |p, c| p * t + c);
                let throughput = powers.iter().rev().fold(0.0, |p, row| p * s + line(row));
                (throughput - system.throughput(px)).abs() <= THROUGHPUT_ERROR
            };
            (0..INSIDE).all(agrees).then_some(powers)
        })
    }

    /// Fits polynomials of at most `degree`, whose coefficients beyond the degrees kept sum up to below a quarter of
    /// `error`, in squares, or of just that degree without an `error`; `None` where they do not fall so far, or a ray
    /// strays. Returns how far the map may stray from its tangent inside a pixel, in squares, and what of that is of third
    /// order.
    fn interpolate(
        &mut self,
        degree: usize,
        error: Option<f64>,
        trace: &mut impl FnMut(&[DVec2]) -> Option<Vec<DVec2>>,
        scale: f64,
    ) -> Option<[DVec2; 2]> {
        // Trace the rays at the interpolation's nodes.
        let (places, interpolation) = self.nodes(degree)?;
        let mut seen = trace(&places.concat())?;
        seen.iter_mut().for_each(|mm| *mm = DVec2::new(if self.flip { -mm.x } else { mm.x }, mm.y) * scale);

        // Interpolate u and v, keep the degrees that matter, and bound their derivatives by the coefficients.
        let [mut stray, mut truncation] = [DVec2::ZERO; 2];
        for (axis, powers) in self.powers.iter_mut().enumerate() {
            let series = interpolation.series(|i, j| seen[i * (degree + 1) + j][axis]);
            let [m, n] = error.map_or(Some(series.degrees()), |error| kept(&series, 0.25 * error))?;
            *powers = series.powers(m, n);
            let h = self.inverse_half;
            self.bounds[axis] = [series.bound(1, 0) * h.x, series.bound(0, 1) * h.y, series.bound(2, 0) * (h.x * h.x)];

            // Bound the second and third order half a pixel away each way, by Taylor's terms.
            let [xx, xy, yy] = [(2, 0), (1, 1), (0, 2)].map(|(s, t)| series.bound(s, t) * power(h, s, t));
            let [xxx, xxy, xyy, yyy] =
                [(3, 0), (2, 1), (1, 2), (0, 3)].map(|(s, t)| series.bound(s, t) * power(h, s, t));
            truncation[axis] = (xxx + 3.0 * xxy + 3.0 * xyy + yyy) / 48.0;
            stray[axis] = (xx + 2.0 * xy + yy) / 8.0 + truncation[axis];
        }
        Some([stray, truncation])
    }
}

/// The middle column of a picture, in px.
fn axis(system: &System) -> f64 {
    0.5 * system.camera().size_px()[0] as f64
}

/// The upper left and the lower right corner of a region, in px.
pub(super) fn corners(region: &Region) -> [DVec2; 2] {
    [
        DVec2::new(region.columns.start as f64, region.rows.start as f64),
        DVec2::new(region.columns.end as f64, region.rows.end as f64),
    ]
}

/// Px per square, roughly, from the rays at opposite corners; `None` where they see the same.
fn coarse_scale(checks: &[(DVec2, DVec2)]) -> Option<f64> {
    let (a, b) = (checks.first()?, checks.get(1)?);
    let scale = (a.1 - b.1).length() / (a.0 - b.0).length();
    (scale > 0.0 && scale.is_finite()).then_some(1.0 / scale)
}

/// h.x^s h.y^t
fn power(h: DVec2, s: usize, t: usize) -> f64 {
    (0..s).map(|_| h.x).product::<f64>() * (0..t).map(|_| h.y).product::<f64>()
}

/// The degrees in s and t beyond which the coefficients sum up to less than `error`: at least two below those of the
/// series, whose last two orders so vouch for what the series itself leaves out.
fn kept(series: &ChebyshevSeries, error: f64) -> Option<[usize; 2]> {
    let [m, n] = series.degrees();
    let (mut s, mut t) = (m - 2, n - 2);
    if series.beyond(s, t).is_nan() || series.beyond(s, t) > error {
        return None;
    }
    while s > 1 && series.beyond(s - 1, t) <= error {
        s -= 1;
    }
    while t > 1 && series.beyond(s, t - 1) <= error {
        t -= 1;
    }
    Some([s, t])
}
