//! A result from detected corners beside the exact one.

use super::deviation::Unmeasurable;

/// One number twice: from detected corners, and exactly. `None` where it does not exist.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Numbers {
    /// From detected corners.
    pub measured: Option<f64>,
    /// From exact positions or rays.
    pub exact: Option<f64>,
}

/// One result twice: from detected corners, and exactly. `None` where it was never asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredAndTrue<T> {
    /// From detected corners.
    pub measured: Option<Result<T, Unmeasurable>>,
    /// From exact positions or rays.
    pub exact: Option<Result<T, Unmeasurable>>,
}

impl<T> MeasuredAndTrue<T> {
    /// Neither was requested.
    pub const NEITHER: Self = Self { measured: None, exact: None };

    /// Neither has a value, for this reason.
    pub const fn neither(reason: Unmeasurable) -> Self {
        Self { measured: Some(Err(reason)), exact: Some(Err(reason)) }
    }

    /// [`MeasuredAndTrue::of`] of both inputs in one array, the measured one first.
    pub fn of_sides<I>([measured, exact]: [Option<I>; 2], metric: impl Fn(I) -> Result<T, Unmeasurable>) -> Self {
        Self::of(measured, exact, metric)
    }

    /// The number that `pick` takes out of each side, where that side has a value.
    pub fn numbers(&self, pick: impl Fn(&T) -> f64) -> Numbers {
        let side = |side: &Option<Result<T, Unmeasurable>>| Some(pick(side.as_ref()?.as_ref().ok()?));
        Numbers { measured: side(&self.measured), exact: side(&self.exact) }
    }

    /// Both sides by the same function of their own input, `None` where there is no input.
    pub fn of<I>(measured: Option<I>, exact: Option<I>, metric: impl Fn(I) -> Result<T, Unmeasurable>) -> Self {
        Self { measured: measured.map(&metric), exact: exact.map(&metric) }
    }

    /// Each side that has a value, changed by `f`.
    pub fn then<U>(&self, f: impl Fn(&T) -> Result<U, Unmeasurable>) -> MeasuredAndTrue<U> {
        let side = |side: &Option<Result<T, Unmeasurable>>| match side {
            Some(Ok(value)) => Some(f(value)),
            Some(Err(reason)) => Some(Err(*reason)),
            None => None,
        };
        MeasuredAndTrue { measured: side(&self.measured), exact: side(&self.exact) }
    }

    /// Two results made one, side by side: the residuals of both halves pooled. Where one has no value, its reason.
    pub fn with<U, V>(
        &self,
        other: &MeasuredAndTrue<U>,
        f: impl Fn(&T, &U) -> Result<V, Unmeasurable>,
    ) -> MeasuredAndTrue<V> {
        type Side<W> = Option<Result<W, Unmeasurable>>;
        let side = |a: &Side<T>, b: &Side<U>| match (a, b) {
            (Some(Ok(a)), Some(Ok(b))) => Some(f(a, b)),
            (Some(Err(reason)), _) | (_, Some(Err(reason))) => Some(Err(*reason)),
            (None, _) | (_, None) => None,
        };
        MeasuredAndTrue { measured: side(&self.measured, &other.measured), exact: side(&self.exact, &other.exact) }
    }

    /// [`MeasuredAndTrue::then`] by value.
    pub fn flat_then<U>(self, f: impl Fn(T) -> Result<U, Unmeasurable>) -> MeasuredAndTrue<U> {
        MeasuredAndTrue {
            measured: self.measured.map(|side| side.and_then(&f)),
            exact: self.exact.map(|side| side.and_then(&f)),
        }
    }
}
