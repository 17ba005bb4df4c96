//! Text of a measured file: decoded whatever the instrument has written it in, and its numbers.

/// The text of a file in UTF-8, UTF-16 with its mark, or Latin-1.
pub fn decode(bytes: &[u8]) -> String {
    let wide = |bytes: &[u8], of: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes.chunks_exact(2).map(|pair| of([pair[0], pair[1]])).collect();
        String::from_utf16_lossy(&units)
    };
    match bytes {
        [0xff, 0xfe, rest @ ..] => wide(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => wide(rest, u16::from_be_bytes),
        [0xef, 0xbb, 0xbf, rest @ ..] => String::from_utf8_lossy(rest).into_owned(),
        _ => String::from_utf8(bytes.to_vec()).unwrap_or_else(|_| bytes.iter().map(|&byte| char::from(byte)).collect()),
    }
}

/// A number with a decimal point, or with a decimal comma where that is asked for. Infinities and NaN are none.
pub fn number(field: &str, comma: bool) -> Option<f64> {
    let field = field.trim().trim_matches('"').trim();
    let looks = field.starts_with(|first: char| first.is_ascii_digit() || "+-.,".contains(first));
    if !looks || field.len() > 64 {
        return None;
    }
    let parsed = match (comma, field.contains(','), field.contains('.')) {
        (true, _, true) | (false, true, _) => return None,
        (true, true, _) => field.replace(',', ".").parse::<f64>(),
        _ => field.parse::<f64>(),
    };
    parsed.ok().filter(|value| value.is_finite())
}

/// The beginning of a text, as a message can show it.
pub fn beginning(text: &str) -> String {
    const LONGEST: usize = 48;
    let clean: String = text.trim().chars().map(|c| if c.is_control() { ' ' } else { c }).take(LONGEST + 1).collect();
    if clean.chars().count() > LONGEST { clean.chars().take(LONGEST).collect::<String>() + " …" } else { clean }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_a_point_or_a_comma_and_never_both() {
        assert_eq!(number(" \"1,5e3\" ", true), Some(1500.0));
        assert_eq!((number("1.5", false), number("-.5", false)), (Some(1.5), Some(-0.5)));
        assert!(
            [("1.000,5", true), ("1,5", false), ("nan", false), ("inf", false), ("1e999", false), ("", false)]
                .iter()
                .all(|(field, comma)| number(field, *comma).is_none())
        );
    }

    #[test]
    fn text_of_windows_and_of_old_instruments_is_read() {
        let wide: Vec<u8> = [0xff, 0xfe].into_iter().chain("f;θ".encode_utf16().flat_map(u16::to_le_bytes)).collect();
        assert_eq!(decode(&wide), "f;θ");
        assert_eq!(decode(b"theta [\xb0]"), "theta [°]");
    }
}
