//! The sums that the normal equations of the corner fit consist of.

use super::corner_model::{PARAMETERS, Right};
use nalgebra::SMatrix;

/// The products of the derivatives.
pub(super) type Normal = SMatrix<f64, PARAMETERS, PARAMETERS>;

/// The normal matrix, the right side and the weighted sum of squared differences at a model.
#[derive(Debug, Clone)]
pub(super) struct Equations {
    pub(super) normal: Normal,
    pub(super) right: Right,
    pub(super) squares: f64,
}
