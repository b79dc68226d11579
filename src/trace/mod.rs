//! A ray's trip through interfaces.

pub mod carry;
pub mod nonsequential;
pub mod packet;
pub mod sequential;

#[cfg(test)]
mod nonsequential_tests;
