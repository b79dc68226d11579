//! How long a test runs: as long as the environment says. With `EVERY_CASE=1` tests take all of their cases.

use std::str::FromStr;

/// The number that the environment's `variable` holds, or `otherwise` where it holds none.
pub fn number<T: FromStr>(variable: &str, otherwise: T) -> T {
    std::env::var(variable).ok().and_then(|text| text.parse().ok()).unwrap_or(otherwise)
}

/// Each `n`-th of all cases, from number `first` on; all of them where the environment asks for every case.
pub fn each<T>(n: usize, first: usize, all: Vec<T>) -> impl Iterator<Item = T> {
    let (n, first) = if number("EVERY_CASE", 0) == 1 { (1, 0) } else { (n, first % n) };
    all.into_iter().skip(first).step_by(n)
}
