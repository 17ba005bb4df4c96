//! Delimiter, decimal sign and comments of a text, and the cells of its lines.

use crate::text::number;

/// Maximum number of lines that determine the form of a text.
const MAX_SAMPLED_LINES: usize = 2000;
/// Beginnings of a comment.
const COMMENT_SIGNS: [&str; 4] = ["#", "!", "%", "//"];

/// Delimiter of the cells, and decimal sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Form {
    /// Character between two cells; `None` for any number of blanks.
    sign: Option<char>,
    /// `true` for a decimal comma.
    comma: bool,
}

/// Forms, in the order of preference if they read equally many numbers.
const FORMS: [Form; 8] = [
    Form { sign: Some(';'), comma: false },
    Form { sign: Some(';'), comma: true },
    Form { sign: Some('\t'), comma: false },
    Form { sign: Some('\t'), comma: true },
    Form { sign: Some(','), comma: false },
    // With quotes around the numbers.
    Form { sign: Some(','), comma: true },
    Form { sign: None, comma: false },
    Form { sign: None, comma: true },
];

impl Form {
    /// Finds the form in which lines of a text have the most numbers, and the fewest other cells.
    pub(crate) fn find(lines: &[&str]) -> Self {
        // The beginning may be a preamble; the middle and the end are not.
        let begins = [0, lines.len() / 2, lines.len().saturating_sub(MAX_SAMPLED_LINES / 3)];
        let sampled = || begins.iter().flat_map(|&at| lines[at..].iter().take(MAX_SAMPLED_LINES / 3));
        let score = |form: &Form| {
            let cells = || sampled().filter(|line| !without_comment(line).1).flat_map(|line| form.cells(line));
            let (mut numbers, mut others) = (0, 0);
            for cell in cells().filter(|cell| !cell.is_empty()) {
                *if form.number(cell).is_some() { &mut numbers } else { &mut others } += 1;
            }
            (numbers, std::cmp::Reverse(others))
        };
        let best = FORMS.iter().rev().max_by_key(|form| score(form)).unwrap_or(&FORMS[4]);
        // Blanks also find the numbers in the words of a preamble.
        let mut clear = FORMS.iter().filter(|form| matches!(form.sign, Some(';' | '\t')));
        let found = clear.find(|form| best.has_blanks() && 10 * score(form).0 > 9 * score(best).0);
        *found.unwrap_or(best)
    }

    /// Returns the cells of a line, without quotes.
    pub(crate) fn cells(self, line: &str) -> Cells<'_> {
        Cells { rest: Some(line), sign: self.sign }
    }

    /// Returns the number in a cell.
    pub(crate) fn number(self, cell: &str) -> Option<f64> {
        number(cell, self.comma)
    }

    /// Returns `true` if blanks separate the cells.
    pub(crate) fn has_blanks(self) -> bool {
        self.sign.is_none()
    }

    /// Returns `true` for a decimal comma.
    pub(crate) fn has_decimal_commas(self) -> bool {
        self.comma
    }

    /// Returns `true` if commas separate the cells.
    pub(crate) fn has_commas(self) -> bool {
        self.sign == Some(',')
    }
}

impl std::fmt::Display for Form {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let delimiter = match self.sign {
            Some(';') => "semicolons",
            Some('\t') => "tabs",
            Some(_) => "commas",
            None => "blanks",
        };
        write!(f, "{delimiter} between the fields, decimal {}", if self.comma { "comma" } else { "point" })
    }
}

/// Iterator over the cells of a line.
pub(crate) struct Cells<'a> {
    rest: Option<&'a str>,
    sign: Option<char>,
}

impl<'a> Iterator for Cells<'a> {
    type Item = &'a str;

    fn next(&mut self) -> Option<&'a str> {
        let Some(sign) = self.sign else {
            let rest = self.rest?.trim_start();
            if rest.is_empty() {
                self.rest = None;
                return None;
            }
            let (cell, rest) =
                quoted(rest).unwrap_or_else(|| rest.split_at(rest.find(char::is_whitespace).unwrap_or(rest.len())));
            self.rest = Some(rest);
            return Some(cell);
        };
        let (cell, rest) = quoted(self.rest?.trim_start_matches(' ')).unwrap_or_else(|| ("", self.rest.unwrap_or_default()));
        let (before, rest) = rest.split_once(sign).map_or((rest, None), |(before, rest)| (before, Some(rest)));
        self.rest = rest;
        Some(if cell.is_empty() { before.trim() } else { cell })
    }
}

/// Splits a text that begins with a quote into its quoted part and the rest.
fn quoted(text: &str) -> Option<(&str, &str)> {
    let (cell, rest) = text.strip_prefix('"')?.split_once('"')?;
    Some((cell.trim(), rest))
}

/// Returns a line without its comment sign, and `true` if it had one.
pub(crate) fn without_comment(line: &str) -> (&str, bool) {
    let comment = COMMENT_SIGNS.iter().find_map(|sign| line.trim().strip_prefix(sign));
    // An empty first cell before a tab is a cell.
    (comment.unwrap_or(line.trim_end().trim_start_matches(' ')), comment.is_some())
}
