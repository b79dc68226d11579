//! Numbers without physics.

pub mod poly2;
pub mod stats;
