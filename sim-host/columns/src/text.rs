//! Text of a measured file: its decoding, and its numbers.

/// Decodes a file in UTF-8, UTF-16 with byte order mark, or Latin-1.
///
/// Line ends of old instruments, a carriage return alone, become line feeds.
pub fn decode(bytes: &[u8]) -> String {
    let text = decoded(bytes);
    if text.contains('\r') && !text.contains('\n') { text.replace('\r', "\n") } else { text }
}

/// Decodes a file, with its line ends.
fn decoded(bytes: &[u8]) -> String {
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

/// Smallest value with which instruments mark an overflow (SCPI: 9.9E37, 9.91E37).
const MIN_OVERFLOW: f64 = 9.8e37;

/// Parses a number with a decimal point, or a decimal comma if `comma`. Infinities, NaN and the
/// overflow values of instruments are rejected.
pub fn number(field: &str, comma: bool) -> Option<f64> {
    parsed(field, comma).filter(|value| value.is_finite() && value.abs() < MIN_OVERFLOW)
}

/// Returns `true` for the overflow value of an instrument.
pub fn is_overflow(field: &str) -> bool {
    parsed(field, field.contains(',')).is_some_and(|value| value.abs() >= MIN_OVERFLOW)
}

fn parsed(field: &str, comma: bool) -> Option<f64> {
    let field = field.trim();
    let looks = field.starts_with(|first: char| first.is_ascii_digit() || "+-.,".contains(first));
    if !looks || field.len() > 64 {
        return None;
    }
    match (comma, field.contains(','), field.contains('.')) {
        (true, true, true) | (false, true, _) => None,
        (true, true, _) => field.replace(',', ".").parse().ok().filter(|_| !field.ends_with(',')),
        (true, _, true) => None,
        _ => field.parse().ok(),
    }
}

/// Returns the beginning of a text for a message.
pub fn beginning(text: &str) -> String {
    const MAX_LETTERS: usize = 48;
    let clean: String = text.trim().chars().map(|c| if c.is_control() { ' ' } else { c }).take(MAX_LETTERS + 1).collect();
    if clean.chars().count() > MAX_LETTERS { clean.chars().take(MAX_LETTERS).collect::<String>() + " …" } else { clean }
}

/// Returns `true` for a control character, or one that overrides the direction of text.
fn is_hidden(letter: char) -> bool {
    letter.is_control() || matches!(letter, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// Returns the first control character of a text, or character that overrides its direction. Line
/// breaks and tabs do not count.
pub fn hidden(text: &str) -> Option<char> {
    text.lines().flat_map(str::chars).find(|&letter| is_hidden(letter) && letter != '\t')
}

/// Returns a text for a terminal: hidden characters other than line breaks and tabs are escaped.
pub fn visible(text: &str) -> String {
    escaped(&text.replace("\r\n", "\n"), |letter| is_hidden(letter) && !matches!(letter, '\n' | '\t'))
}

/// Returns a text for one line of a terminal: all hidden characters are escaped.
pub fn visible_line(text: &str) -> String {
    escaped(text, is_hidden)
}

fn escaped(text: &str, is_escaped: impl Fn(char) -> bool) -> String {
    let mut safe = String::with_capacity(text.len());
    for letter in text.chars() {
        if is_escaped(letter) { safe.extend(letter.escape_default()) } else { safe.push(letter) }
    }
    safe
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_a_point_or_a_comma_and_never_both() {
        assert_eq!((number(" 1,5e3 ", true), number("1,", true)), (Some(1500.0), None));
        assert_eq!((number("1.5", false), number("-.5", false)), (Some(1.5), Some(-0.5)));
        assert!(
            [
                ("1.000,5", true),
                ("1,5", false),
                ("nan", false),
                ("inf", false),
                ("1e999", false),
                ("9.9E37", false),
                ("-9,91e37", true),
                ("", false)
            ]
            .iter()
            .all(|(field, comma)| number(field, *comma).is_none())
        );
    }

    #[test]
    fn hidden_characters_are_escaped() {
        let hostile = "a\u{1b}[2Jb\u{9b}c\u{7f}d\u{202e}e\rf";
        let safe = "a\\u{1b}[2Jb\\u{9b}c\\u{7f}d\\u{202e}e\\rf";
        assert_eq!((visible(hostile), visible_line(hostile), hidden(hostile)), (safe.into(), safe.into(), Some('\u{1b}')));
        assert_eq!((visible("µ\r\n\tb"), visible_line("µ\n"), hidden("µ\r\n\tb")), ("µ\n\tb".into(), "µ\\n".into(), None));
    }

    #[test]
    fn a_carriage_return_alone_ends_a_line() {
        assert_eq!((decode(b"f,R\r1,2\r"), decode(b"f,R\r\n1,2\r\n")), ("f,R\n1,2\n".into(), "f,R\r\n1,2\r\n".into()));
    }

    #[test]
    fn utf16_and_latin1_are_decoded() {
        let wide: Vec<u8> = [0xff, 0xfe].into_iter().chain("f;θ".encode_utf16().flat_map(u16::to_le_bytes)).collect();
        assert_eq!(decode(&wide), "f;θ");
        assert_eq!(decode(b"theta [\xb0]"), "theta [°]");
    }
}
