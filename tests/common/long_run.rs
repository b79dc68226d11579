//! How long a test runs: as long as the environment says.

use std::str::FromStr;

/// The number that the environment's `variable` holds, or `otherwise` where it holds none.
pub fn number<T: FromStr>(variable: &str, otherwise: T) -> T {
    std::env::var(variable).ok().and_then(|text| text.parse().ok()).unwrap_or(otherwise)
}
