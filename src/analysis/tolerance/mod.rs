//! Tolerances of a prism: how much each error of making it costs, one by one and all at once (the design paper's Table 2).
//!
//! An error is put into the scene and the instrument is built anew; nothing is put into a built one.

pub mod made;
mod misshapen;
pub mod operand;
pub mod probe;
pub mod sensitivity;
pub mod trials;

#[cfg(test)]
mod tests;
