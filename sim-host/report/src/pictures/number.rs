//! Typographic formatting of numbers.
//!
//! Digits beyond the precision of a tick are noise (`0.30000000000000004`), and long runs of digits
//! are misread. Integer parts of five digits or more are grouped by a narrow space, minus is a
//! minus sign, and powers of ten use superscripts.

/// Narrow no-break space between groups of three digits.
const GROUP: char = '\u{202f}';

/// Formats `value` with a fixed number of decimals.
pub(super) fn fixed(value: f64, decimals: usize) -> String {
    let digits = format!("{:.decimals$}", value.abs());
    let (whole, fraction) = digits.split_at(digits.find('.').unwrap_or(digits.len()));
    let negative = value < 0.0 && digits.bytes().any(|b| (b'1'..=b'9').contains(&b));
    let mut text = String::from(if negative { "−" } else { "" });
    for (place, digit) in whole.chars().enumerate() {
        if place > 0 && whole.len() > 4 && (whole.len() - place).is_multiple_of(3) {
            text.push(GROUP);
        }
        text.push(digit);
    }
    text + fraction
}

/// Returns the number of decimals needed to distinguish values that are `step` apart.
pub(super) fn decimals(step: f64) -> usize {
    let places = (-step.abs().log10() - 1e-9).ceil();
    if places > 0.0 { places.min(12.0) as usize } else { 0 }
}

/// Formats `value` as a multiple of `10^exponent`.
pub(super) fn scaled(value: f64, exponent: i32, decimals: usize) -> String {
    let mantissa = fixed(value / 10f64.powi(exponent), decimals);
    if mantissa.bytes().any(|b| (b'1'..=b'9').contains(&b)) {
        format!("{mantissa}·{}", power_of_ten(exponent))
    } else {
        String::from("0")
    }
}

/// Formats `10` with a superscript exponent.
pub(super) fn power_of_ten(exponent: i32) -> String {
    let raised = exponent.to_string().chars().map(superscript).collect::<String>();
    format!("10{raised}")
}

fn superscript(digit: char) -> char {
    match digit {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        other => other.to_digit(10).and_then(|d| char::from_u32(0x2070 + d)).unwrap_or(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fixed_rounds_groups_and_signs() {
        assert_eq!(fixed(0.1 + 0.2, 1), "0.3");
        assert_eq!(fixed(-0.5, 1), "−0.5");
        assert_eq!(fixed(-0.001, 1), "0.0");
        assert_eq!(fixed(1234.0, 0), "1234");
        assert_eq!(fixed(40_000.5, 1), "40\u{202f}000.5");
        assert_eq!(fixed(1_234_567.0, 0), "1\u{202f}234\u{202f}567");
    }

    #[test]
    fn decimals_follow_the_step() {
        let steps = [1000.0, 1.0, 0.5, 0.2, 0.1, 0.05, 0.001];
        assert_eq!(steps.map(decimals), [0, 0, 1, 1, 1, 2, 3]);
    }

    #[test]
    fn powers_are_raised() {
        assert_eq!(power_of_ten(-12), "10⁻¹²");
        assert_eq!(scaled(2.5e-5, -5, 1), "2.5·10⁻⁵");
        assert_eq!(scaled(0.0, -5, 1), "0");
        assert_eq!(scaled(-1e-7, -7, 0), "−1·10⁻⁷");
    }
}
