//! What a cutter asks before a prism is made: what it leaves of its law, the shape of its surfaces, its glass, its spot at an
//! aperture, and what errors of manufacture do.

mod bench;
mod form;
mod sphere;
mod residual;
mod spot;
mod sensitivity;
mod sheet;

pub use form::{GlassForm, SurfaceForm, SurfaceMap, surfaces};
pub use residual::{LawResidual, ResidualMap};
pub use sensitivity::{ERRORS, ErrorSensitivity, recalibrated_rss_px};
pub use sheet::{CutterSheet, Floor, Z_MIN_MM, of_design, residuals, sheet};
pub use spot::{F_NUMBER, Spot};
