//! Mutates texts: lines and words are removed, doubled, swapped between two texts, or replaced by
//! possible words.

use hal_mock::chance::Chance;
use scene::diagnostic::Report;

/// Words that replace numbers, keys and strings.
const WORDS: [&str; 44] = [
    "0",
    "-0",
    "1",
    "-1",
    "0.5",
    "2",
    "3.0",
    "100",
    "4096",
    "65536",
    "1e-300",
    "1e300",
    "-1e9",
    "1e9",
    "inf",
    "-inf",
    "nan",
    "9223372036854775807",
    "-9223372036854775808",
    "9223372036854775808",
    "18446744073709551616",
    "0x7fffffff",
    "1_000",
    "1e",
    "true",
    "false",
    "none",
    "\"\"",
    "\"x\"",
    "''",
    "[]",
    "[1]",
    "[[]]",
    "{}",
    "{ a = 1 }",
    "[1, 2, 3, 4, 5]",
    "\"\"\"",
    "#",
    "=",
    ".",
    "[",
    "]",
    "1979-05-27",
    "\u{1F50A}",
];
/// Depths of nesting.
const NESTING_DEPTHS: [usize; 4] = [3, 60, 300, 5000];

/// Returns a text with some changes; lines and words come from `other`, further words from `words`.
pub(super) fn changed(chance: &mut Chance, text: &str, other: &str, words: &[String]) -> String {
    let mut text = text.to_owned();
    for _ in 0..=chance.below(4) {
        text = change(chance, &text, other, words);
    }
    text
}

fn change(chance: &mut Chance, text: &str, other: &str, words: &[String]) -> String {
    let mut lines: Vec<&str> = text.split_inclusive('\n').collect();
    let line = chance.below(lines.len() as u64) as usize;
    match chance.below(14) {
        0 if lines.len() > 1 => {
            lines.remove(line);
        }
        1 if lines.len() > 1 => lines.insert(line, lines[line]),
        2 if lines.len() > 1 => {
            let with = chance.below(lines.len() as u64) as usize;
            lines.swap(line, with);
        }
        3 => lines.insert(line.min(lines.len()), pick(chance, &other.split_inclusive('\n').collect::<Vec<_>>()).unwrap_or("")),
        4 => return cut(text, chance.below(text.len() as u64 + 1) as usize).to_owned(),
        5 => {
            let mut bytes = text.as_bytes().to_vec();
            if !bytes.is_empty() {
                let at = chance.below(bytes.len() as u64) as usize;
                bytes[at] = if chance.strikes(0.5) { chance.byte() } else { bytes[at] ^ (1 << chance.below(8)) };
            }
            return String::from_utf8_lossy(&bytes).into_owned();
        }
        6 if chance.strikes(0.2) => {
            let deep = NESTING_DEPTHS[chance.below(NESTING_DEPTHS.len() as u64) as usize];
            let one = ["[", "{a=", "a.", "\"", "'", "[["][chance.below(6) as usize];
            return format!("{text}\nx = {}\n", one.repeat(deep));
        }
        _ => return word(chance, text, other, words),
    }
    lines.concat()
}

/// Replaces one word, or inserts something before it.
fn word(chance: &mut Chance, text: &str, other: &str, words: &[String]) -> String {
    let places = spans(text);
    let Some(&(from, to)) = places.get(chance.below(places.len().max(1) as u64) as usize) else { return text.to_owned() };
    let new = match chance.below(3) {
        0 => pick(chance, &spans(other)).map(|(from, to)| other[from..to].to_owned()),
        1 => pick(chance, words),
        _ => None,
    };
    let new = new.unwrap_or_else(|| WORDS[chance.below(WORDS.len() as u64) as usize].to_owned());
    let from_or_to = if chance.strikes(0.1) { from } else { to };
    format!("{}{new}{}", &text[..from], &text[from_or_to..])
}

/// Draws one of the items, if there are any.
pub(super) fn pick<T: Clone>(chance: &mut Chance, among: &[T]) -> Option<T> {
    among.get(chance.below(among.len() as u64) as usize).cloned()
}

/// Returns the positions of the words of a text: runs of letters, digits and similar characters.
fn spans(text: &str) -> Vec<(usize, usize)> {
    let is_part = |letter: char| letter.is_alphanumeric() || matches!(letter, '_' | '-' | '.' | '+');
    let (mut spans, mut open) = (Vec::new(), None);
    for (at, letter) in text.char_indices().chain([(text.len(), ' ')]) {
        match (open, is_part(letter)) {
            (None, true) => open = Some(at),
            (Some(from), false) => {
                spans.push((from, at));
                open = None;
            }
            _ => {}
        }
    }
    spans
}

/// Returns the beginning of a text, cut between two characters.
fn cut(text: &str, at: usize) -> &str {
    (0..=at).rev().find_map(|at| text.get(..at)).unwrap_or_default()
}

/// Returns the kinds of the problems in a report: messages without names, numbers and quoted text.
/// A report without a message is an error.
pub(super) fn kinds(report: &Report) -> Result<Vec<String>, String> {
    let rendered = report.render(false);
    if report.problems().is_empty() || report.problems().iter().any(|problem| problem.message.trim().is_empty()) {
        return Err(format!("refused without a reason: {rendered:?}"));
    }
    Ok(report.problems().iter().map(|problem| kind(&problem.message)).collect())
}

/// Returns a message without numbers and without the text between backticks or quotes.
pub(super) fn kind(message: &str) -> String {
    let mut kind = String::new();
    for (n, part) in message.split(['`', '"']).enumerate() {
        if n % 2 == 0 {
            let plain = part.chars().map(|letter| if letter.is_ascii_digit() { '0' } else { letter });
            plain.for_each(|letter| {
                if !(letter == '0' && kind.ends_with('0')) {
                    kind.push(letter);
                }
            });
        } else {
            kind.push('*');
        }
    }
    kind.chars().take(70).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_found_and_kinds_have_no_names() {
        assert_eq!(spans("a.b = -1e3 # x"), [(0, 3), (6, 10), (13, 14)]);
        assert_eq!(kind("`a.b` must be 10 to 200, not \"x\""), "* must be 0 to 0, not *");
        assert_eq!(cut("aé", 2), "a");
    }

    #[test]
    fn equal_seeds_change_equally() {
        let changed = |seed| changed(&mut Chance::new(seed), "a = 1\nb = 2\n", "c = 3\n", &["d".into()]);
        assert_eq!(changed(7), changed(7));
        assert!((0..20).any(|seed| changed(seed) != "a = 1\nb = 2\n"));
    }
}
