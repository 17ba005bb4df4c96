//! Delimiters, comments and headings, for tables of numbers and tables with words.

/// Separator between fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Delimiter {
    /// A single character.
    Sign(char),
    /// Any number of blanks.
    Blank,
}

/// Delimiters, in the order of preference.
pub(crate) const DELIMITERS: [Delimiter; 4] =
    [Delimiter::Sign(';'), Delimiter::Sign('\t'), Delimiter::Sign(','), Delimiter::Blank];
/// Beginnings of a comment.
const COMMENT_SIGNS: [&str; 4] = ["#", "!", "%", "//"];

impl Delimiter {
    /// Returns the fields of a line, without quotes; a delimiter after the last field ends the
    /// line.
    pub(crate) fn split(self, line: &str) -> Vec<&str> {
        self.fields(line, true)
    }

    /// Returns the fields of a line, without quotes. If `ends`, a delimiter after the last field
    /// ends the line; otherwise an empty field follows it.
    pub(crate) fn fields(self, line: &str, ends: bool) -> Vec<&str> {
        match self {
            Delimiter::Blank => line.split_whitespace().map(unquoted).collect(),
            Delimiter::Sign(sign) => {
                let line = line.trim_end_matches(|c: char| c != sign && c.is_whitespace());
                let line = if ends { line.strip_suffix(sign).unwrap_or(line) } else { line };
                line.split(sign).map(unquoted).collect()
            }
        }
    }

    /// Returns `true` if a comma can be a decimal sign between such delimiters.
    pub(crate) fn leaves_commas(self) -> bool {
        self != Delimiter::Sign(',')
    }

    /// Returns the name of the delimiter for a message.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Delimiter::Sign(';') => "semicolons",
            Delimiter::Sign('\t') => "tabs",
            Delimiter::Sign(_) => "commas",
            Delimiter::Blank => "blanks",
        }
    }
}

fn unquoted(field: &str) -> &str {
    field.trim().trim_matches('"').trim()
}

/// Returns a line without its comment sign, and `true` if it had one.
pub(crate) fn without_comment(line: &str) -> (&str, bool) {
    let line = line.trim();
    let comment = COMMENT_SIGNS.iter().find_map(|sign| line.strip_prefix(sign));
    (comment.unwrap_or(line), comment.is_some())
}

/// Returns the last line of a preamble, if it contains names.
pub(crate) fn heading(before: &[&str], delimiter: Delimiter) -> Option<Vec<String>> {
    let line = before.iter().rev().map(|line| without_comment(line).0).find(|line| !line.trim().is_empty())?;
    let fields: Vec<String> = delimiter.split(line).into_iter().map(str::to_owned).collect();
    fields.iter().any(|field| field.chars().any(char::is_alphabetic)).then_some(fields)
}
