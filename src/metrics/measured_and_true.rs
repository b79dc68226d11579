//! A result from detected corners beside the exact one.

use super::deviation::Unmeasurable;

/// One result twice: from detected corners, and exactly. `None` where it was not requested.
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
