//! A ray's trip through interfaces.

pub mod carry;
pub mod packet;
pub mod sequential;
