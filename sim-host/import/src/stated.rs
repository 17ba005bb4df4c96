//! A number as it is stated: with as many digits as its standard deviation has two of.

/// Number and standard deviation as text, such as `40012.34` and `0.56`.
pub(crate) fn stated(value: f64, sd: f64) -> (String, String) {
    if sd <= 0.0 || !value.is_finite() || !sd.is_finite() {
        return (report::significant(value), if sd == 0.0 { "0".into() } else { "none".into() });
    }
    let exponent = |x: f64| format!("{x:.1e}").rsplit('e').next().and_then(|text| text.parse::<i32>().ok()).unwrap_or(0);
    let digits = (1 - exponent(sd)).clamp(0, 12) as usize;
    (format!("{value:.digits$}"), format!("{sd:.digits$}"))
}

/// The nearest number with so many digits.
pub(crate) fn rounded(value: f64, digits: usize) -> f64 {
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
}
