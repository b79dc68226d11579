//! What the command says of its build.

use super::machine::vectors;
use std::sync::LazyLock;

/// The version, and what was built and runs: target, profile, optimisation, compiler, and the vectors that this machine has.
pub(super) static LONG_VERSION: LazyLock<String> = LazyLock::new(|| {
    format!(
        "{}\ntarget:       {}\nprofile:      {}, opt-level {}\nvectors:      {}\ncompiler:     {}, {} or newer",
        env!("CARGO_PKG_VERSION"),
        env!("BIPRISM_TARGET"),
        env!("BIPRISM_PROFILE"),
        env!("BIPRISM_OPT_LEVEL"),
        vectors(),
        env!("BIPRISM_RUSTC"),
        env!("CARGO_PKG_RUST_VERSION"),
    )
});
