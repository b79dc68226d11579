//! A ray through two surfaces, over any kind of number: the exit ray and all its derivatives from one formula.

use super::anchored::AnchoredBasis;
use crate::num::scalar::{Differentiable, Dual, Taylor, along, dot};

/// Partial derivatives that are carried: height and slopes of the front and of the back where the ray meets them, the numbers
/// of the law, and the lens's focus.
pub(super) const SEEDS: usize = 12;
/// The first seed of the law's numbers.
pub(super) const LAW_SEED: usize = 6;
/// The seed of the focus.
pub(super) const FOCUS_SEED: usize = 11;
/// The number of the Jacobian's pass.
pub(super) type Partial = Dual<SEEDS>;

/// Newton's method for a hit is done when a step is below this, in mm: the rounding of a place in a prism.
const HIT_MM: f64 = 1e-13;
/// It gives up after so many steps.
const MOST_STEPS: usize = 24;

/// A surface to be met by rays of numbers `N`.
pub(super) trait SmoothSheet<N> {
    /// z, dz/dx and dz/dy.
    fn plain(&self, x: f64, y: f64) -> [f64; 3];
    /// The same with what `N` carries.
    fn lifted(&self, x: N, y: N) -> [N; 3];
}

/// A surface by its coefficients.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fixed<'a> {
    pub(super) basis: &'a AnchoredBasis,
    pub(super) c: &'a [f64],
}

impl SmoothSheet<f64> for Fixed<'_> {
    fn plain(&self, x: f64, y: f64) -> [f64; 3] {
        self.basis.heights(x, y, |k, t| self.c[k] * t)
    }

    fn lifted(&self, x: f64, y: f64) -> [f64; 3] {
        self.plain(x, y)
    }
}

/// A surface whose height and slopes, where the ray meets it, are seeds from `seed` on.
pub(super) struct Seeded<'a>(pub(super) Fixed<'a>, pub(super) usize);

impl SmoothSheet<Partial> for Seeded<'_> {
    fn plain(&self, x: f64, y: f64) -> [f64; 3] {
        self.0.plain(x, y)
    }

    fn lifted(&self, x: Partial, y: Partial) -> [Partial; 3] {
        let Self(Fixed { basis, c }, seed) = self;
        let z = basis.heights(x, y, |k, t| t.times(c[k]));
        std::array::from_fn(|k| z[k] + Partial::variable(0.0, seed + k))
    }
}

/// A surface whose coefficients move along a line.
pub(super) struct Moving<'a>(pub(super) Fixed<'a>, pub(super) &'a [f64]);

impl SmoothSheet<Taylor> for Moving<'_> {
    fn plain(&self, x: f64, y: f64) -> [f64; 3] {
        self.0.plain(x, y)
    }

    fn lifted(&self, x: Taylor, y: Taylor) -> [Taylor; 3] {
        let Self(Fixed { basis, c }, rate) = self;
        basis.heights(x, y, |k, t| t * Taylor([c[k], rate[k], 0.0]))
    }
}

/// A point of a ray and its direction, which need not be a unit vector before the glass and is one behind it.
#[derive(Debug, Clone, Copy)]
pub(super) struct GlassRay<N> {
    pub(super) origin: [N; 3],
    pub(super) direction: [N; 3],
}

/// The ray behind the prism, and where it met front and back.
#[derive(Debug, Clone, Copy)]
pub(super) struct GlassPassage<N> {
    pub(super) exit: GlassRay<N>,
    pub(super) front_mm: [f64; 3],
    pub(super) back_mm: [f64; 3],
}

/// The ray through `front` and `back` into and out of a glass of the index `index_ratio`; `None` where it misses, is
/// totally reflected, or would leave before it enters.
pub(super) fn pass<N: Differentiable>(
    ray: &GlassRay<N>,
    [front, back]: [&impl SmoothSheet<N>; 2],
    index_ratio: f64,
) -> Option<GlassPassage<N>> {
    let (entry, normal) = meet(ray, front)?;
    let length = dot(ray.direction, ray.direction).sqrt();
    let unit = ray.direction.map(|d| d / length);
    let inside = GlassRay { origin: entry, direction: refract(unit, normal, 1.0 / index_ratio)? };
    let (leave, normal) = meet(&inside, back)?;
    let exit = GlassRay { origin: leave, direction: refract(inside.direction, normal, index_ratio)? };
    let [front_mm, back_mm] = [entry, leave].map(|p| p.map(N::value));
    (back_mm[2] > front_mm[2]).then_some(GlassPassage { exit, front_mm, back_mm })
}

/// Where a ray meets a surface, and the unit normal there, towards +z.
pub(super) fn meet<N: Differentiable>(ray: &GlassRay<N>, sheet: &impl SmoothSheet<N>) -> Option<([N; 3], [N; 3])> {
    // Find the place.
    let (o, d) = (ray.origin.map(N::value), ray.direction.map(N::value));
    let mut t = (sheet.plain(o[0], o[1])[0] - o[2]) / d[2];
    let mut last = f64::INFINITY;
    for _ in 0..MOST_STEPS {
        let [x, y, z] = along(o, t, d);
        let [sag, zx, zy] = sheet.plain(x, y);
        let step = (z - sag) / (d[2] - zx * d[0] - zy * d[1]);
        t -= step;
        last = step.abs();
        if last < HIT_MM {
            break;
        }
    }
    if !(last < 1e3 * HIT_MM && t > 0.0) {
        return None;
    }

    // Newton's method doubles the orders that are right: two steps for first and second derivatives.
    let mut way = N::constant(t);
    for _ in 0..2 {
        let [x, y, z] = along(ray.origin, way, ray.direction);
        let [sag, zx, zy] = sheet.lifted(x, y);
        way = way - (z - sag) / (ray.direction[2] - zx * ray.direction[0] - zy * ray.direction[1]);
    }
    let point = along(ray.origin, way, ray.direction);
    let [_, zx, zy] = sheet.lifted(point[0], point[1]);
    let length = (N::constant(1.0) + zx * zx + zy * zy).sqrt();
    Some((point, [-zx / length, -zy / length, N::constant(1.0) / length]))
}

/// Snell's law for unit vectors, the normal along the ray (Born & Wolf, Principles of Optics, 3.2.2); `None` beyond the
/// critical angle.
fn refract<N: Differentiable>(incoming: [N; 3], normal: [N; 3], eta: f64) -> Option<[N; 3]> {
    let cos_in = dot(incoming, normal);
    let square = (cos_in * cos_in - N::constant(1.0)).times(eta * eta) + N::constant(1.0);
    if !(cos_in.value() > 0.0 && square.value() > 0.0) {
        return None;
    }
    let gamma = square.sqrt() - cos_in.times(eta);
    Some(std::array::from_fn(|k| incoming[k].times(eta) + gamma * normal[k]))
}
