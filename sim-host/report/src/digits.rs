//! Numbers as text in tables.

/// A number with four significant digits.
pub fn significant(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 { "0".into() } else { "none".into() };
    }
    let exponent = format!("{value:.3e}").rsplit('e').next().and_then(|text| text.parse::<i32>().ok()).unwrap_or(0);
    if (-3..5).contains(&exponent) {
        let text = format!("{value:.*}", (3 - exponent).max(0) as usize);
        let trimmed = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
        trimmed.to_owned()
    } else {
        format!("{value:.3e}")
    }
}

#[cfg(test)]
mod tests {
    use super::significant;

    #[test]
    fn four_digits() {
        let cases =
            [(0.053_429_6, "0.05343"), (12_978.69, "12979"), (-29.91, "-29.91"), (1.0, "1"), (1.2e-5, "1.200e-5"), (0.0, "0")];
        for (value, text) in cases {
            assert_eq!(significant(value), text);
        }
    }
}
