//! What several test programs share: each is a crate of its own and uses what it needs.
#![allow(dead_code, unreachable_pub, missing_docs)]

pub mod board;
pub mod long_run;
pub mod twin;
