//! Numbers without physics.

pub mod bernstein;
pub mod chebyshev;
pub mod exact;
pub mod lsq;
pub mod ode;
pub mod poly2;
pub mod simd;
pub mod stats;
