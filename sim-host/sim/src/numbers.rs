//! Formatting of numbers for tables.

use std::collections::BTreeSet;

/// Formats a number with four significant digits.
pub fn number(value: f64) -> String {
    digits(value, 4)
}

/// Formats a number with seven significant digits, for comparison with others.
pub fn precise(value: f64) -> String {
    digits(value, 7)
}

/// Formats numbers with the fewest significant digits, at least four, that distinguish them.
pub(crate) fn distinct(values: &[f64]) -> Vec<String> {
    let wanted = values.iter().map(|value| value.to_bits()).collect::<BTreeSet<_>>().len();
    let texts = |count: usize| values.iter().map(|&value| digits(value, count)).collect::<Vec<_>>();
    let enough = |texts: &Vec<String>| texts.iter().collect::<BTreeSet<_>>().len() == wanted;
    (4..17).map(texts).find(enough).unwrap_or_else(|| texts(17))
}

fn digits(value: f64, digits: usize) -> String {
    let size = value.abs();
    if value == 0.0 {
        return "0".into();
    }
    if !(1e-3..1e7).contains(&size) {
        return format!("{value:.*e}", digits - 1);
    }
    // The decimals complete the number of digits; whole numbers have none.
    let before = size.log10().floor() as i32 + 1;
    let after = (digits as i32 - before).max(0) as usize;
    let text = format!("{value:.after$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_their_significant_digits() {
        assert_eq!(number(67.440_118), "67.44");
        assert_eq!(number(0.144), "0.144");
        assert_eq!(number(2.0008e-8), "2.001e-8");
        assert_eq!(number(-5.2), "-5.2");
        assert_eq!(precise(39_999.290_1), "39999.29");
        assert_eq!(number(8.0), "8");
        assert_eq!(distinct(&[0.038, 0.068, 0.038]), ["0.038", "0.068", "0.038"]);
        assert_eq!(distinct(&[0.05, 0.050_001]), ["0.05", "0.050001"]);
    }
}
