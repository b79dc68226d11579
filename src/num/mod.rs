//! Numbers without physics.

pub mod bernstein;
pub mod chebyshev;
pub mod curve;
pub mod deviates;
pub mod exact;
pub mod lsq;
pub mod normal;
pub mod ode;
pub mod philox;
pub mod poly2;
pub mod powers;
pub mod quadrature;
pub mod simd;
pub mod stats;
pub mod gauss;
pub mod geodesic;
pub mod scalar;
pub mod zernike;
