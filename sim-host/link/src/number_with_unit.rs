//! Numbers as people type them: `2`, `2V`, `500mV`, `40k`, `"0.5 s"`.

use columns::Unit;

/// Returns the number in `unit`, the symbol of an SI unit. A text without a unit is in `unit`.
///
/// # Errors
///
/// An explanation with a correct example, if the text is not a finite number, or if its unit
/// measures another quantity.
pub fn number_in(text: &str, unit: &str) -> Result<f64, String> {
    let expected = || format!("expected {}", form(unit));
    let (number, written) = split(text).ok_or_else(expected)?;
    let factor = match (written, unit) {
        ("", _) => 1.0,
        // Frequencies are often written without their unit.
        ("k", "Hz") => 1e3,
        ("M", "Hz") => 1e6,
        // In headings of files this means megahertz; an offset may well be typed in millihertz.
        (written, "Hz") if written.starts_with('m') => {
            return Err(format!("`{written}` may be milli or mega; {}", expected()));
        }
        _ => {
            let base = Unit::parse(unit).ok_or_else(expected)?;
            let found =
                Unit::parse_like(written, &base).ok_or_else(|| format!("the unit `{written}` is unknown; {}", expected()))?;
            if !found.measures_like(&base) {
                return Err(format!("`{written}` is not a unit of this quantity; {}", expected()));
            }
            found.factor_to(&base).ok_or_else(|| format!("`{written}` may be milli or mega; {}", expected()))?
        }
    };
    Ok(factor * number)
}

/// Splits a text into a finite number and the unit that follows it, which may be empty.
pub fn split(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    // The longest beginning that is a number: the `e` of `5e3` belongs to it.
    let ends = (1..=text.len()).rev().filter(|&end| text.is_char_boundary(end));
    let (number, end) = ends.filter_map(|end| Some((text[..end].parse::<f64>().ok()?, end))).next()?;
    number.is_finite().then(|| (number, text[end..].trim()))
}

/// Returns `true` if a word is only a number, and the next one only its unit, as in `drive 2 V`.
pub fn belong_together(number: &str, unit: &str) -> bool {
    split(number).is_some_and(|(_, unit)| unit.is_empty())
        && split(unit).is_none()
        && (["k", "M"].contains(&unit) || Unit::parse(unit).is_some())
}

/// Joins each number with the unit that follows it as a word of its own.
pub fn joined(words: Vec<String>) -> Vec<String> {
    words.into_iter().fold(Vec::new(), |mut joined: Vec<String>, word| {
        match joined.last_mut().filter(|last| belong_together(last, &word)) {
            Some(number) => *number += &word,
            None => joined.push(word),
        }
        joined
    })
}

/// Describes the numbers that an argument with this unit accepts.
fn form(unit: &str) -> String {
    match unit {
        "V" => "volts, such as 2, 2V or 500mV".into(),
        "A" => "amperes, such as 0.3, 0.3A or 300mA".into(),
        "s" => "seconds, such as 0.5, 0.5s or 500ms".into(),
        "Hz" => "hertz, such as 40000, 40k or 40kHz".into(),
        "turns" => "turns, such as 0.25 or 90deg".into(),
        other => format!("a number in {other}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_may_have_a_unit_of_its_quantity() {
        let cases = [
            ("2", "V", 2.0),
            ("2V", "V", 2.0),
            ("2 volts", "V", 2.0),
            ("500mV", "V", 0.5),
            ("5e-1v", "V", 0.5),
            ("300mA", "A", 0.3),
            ("40khz", "Hz", 40e3),
            ("40k", "Hz", 40e3),
            ("0.1M", "Hz", 100e3),
            ("500ms", "s", 0.5),
            ("2min", "s", 120.0),
            ("90deg", "turns", 0.25),
        ];
        for (text, unit, value) in cases {
            let read = number_in(text, unit).unwrap();
            assert!((read - value).abs() <= 1e-12 * value, "{text}: {read}");
        }
    }

    #[test]
    fn a_unit_may_be_a_word_of_its_own() {
        let words = |line: &str| joined(line.split(' ').map(str::to_owned).collect()).join(" ");
        assert_eq!(words("drive 2 V --for 500 ms"), "drive 2V --for 500ms");
        assert_eq!(words("commission --max-volts 3 volts -o 3 out"), "commission --max-volts 3volts -o 3 out");
        assert_eq!(words("burst --count 3 --on 0.1 wait 2 3"), "burst --count 3 --on 0.1 wait 2 3");
    }

    #[test]
    fn another_quantity_is_refused_with_an_example() {
        for (text, unit, part) in [
            ("2A", "V", "`A` is not a unit of this quantity; expected volts, such as 2, 2V or 500mV"),
            ("5m", "s", "`m` is not a unit of this quantity"),
            ("500mHz", "Hz", "milli or mega"),
            ("2 bananas", "V", "the unit `bananas` is unknown"),
            ("much", "V", "expected volts"),
            ("nan", "Hz", "expected hertz"),
            ("1e999", "s", "expected seconds"),
            ("", "A", "expected amperes"),
        ] {
            let refused = number_in(text, unit).unwrap_err();
            assert!(refused.contains(part), "{text}: {refused}");
        }
    }
}
