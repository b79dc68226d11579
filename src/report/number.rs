//! Numbers as a person reads them.

/// A value as a person reads it: three or five decimals, or an exponent where these say little.
pub fn number(value: Option<f64>) -> String {
    match value {
        None => "-".to_owned(),
        Some(0.0) => "0".to_owned(),
        Some(v) if v.abs() < 1e-4 || v.abs() >= 1e5 => format!("{v:.2e}"),
        Some(v) if v.abs() < 1.0 => format!("{v:.5}"),
        Some(v) => format!("{v:.3}"),
    }
}

/// A length to six digits.
pub fn rounded(mm: f64) -> String {
    let digits = (5.0 - libm::floor(libm::log10(mm.abs()))).clamp(0.0, 9.0) as usize;
    let text = format!("{mm:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}
