//! The rule for which face a ray meets first.

/// Relative rounding of a point's x on its way along a ray, by which it may lie on the other side of the ridge: a few
/// operations.
pub(crate) const RIDGE_ROUNDINGS: f64 = 8.0 * f64::EPSILON;
