//! Numbers as text in tables.

/// Formats a number with four significant digits.
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

/// Smallest standard deviation that is stated, relative to its value: the digits of a file end
/// there.
pub const MIN_STATED_REL: f64 = 1e-9;

/// Formats a number and its standard deviation, such as `40012.34` and `0.56`: the deviation has
/// two digits.
pub fn stated(value: f64, sd: f64) -> (String, String) {
    if sd <= 0.0 || !value.is_finite() || !sd.is_finite() {
        return (significant(value), if sd == 0.0 { "0".into() } else { "none".into() });
    }
    let sd = sd.max(MIN_STATED_REL * value.abs());
    let decimals = decimals(sd);
    (format!("{value:.decimals$}"), format!("{sd:.decimals$}"))
}

/// Formats a number to the last digit of a standard deviation with two digits.
pub fn rounded_to(value: f64, sd: f64) -> String {
    stated(value, sd).0
}

/// Number of decimals that show two digits of a standard deviation.
fn decimals(sd: f64) -> usize {
    let exponent = format!("{sd:.1e}").rsplit('e').next().and_then(|text| text.parse::<i32>().ok()).unwrap_or(0);
    (1 - exponent).clamp(0, 12) as usize
}

/// Returns the nearest number with `digits` digits.
pub fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits.saturating_sub(1)).parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deviation_has_two_digits() {
        assert_eq!(stated(40_012.336, 0.556), ("40012.34".into(), "0.56".into()));
        assert_eq!(stated(123.4, 17.0), ("123".into(), "17".into()));
        assert_eq!(stated(5.0, 0.0), ("5".into(), "0".into()));
        assert_eq!(rounded(0.012_345_678, 4), 0.01235);
    }

    #[test]
    fn four_digits() {
        let cases =
            [(0.053_429_6, "0.05343"), (12_978.69, "12979"), (-29.91, "-29.91"), (1.0, "1"), (1.2e-5, "1.200e-5"), (0.0, "0")];
        for (value, text) in cases {
            assert_eq!(significant(value), text);
        }
    }
}
