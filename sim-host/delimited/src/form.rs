//! What separates fields, what is a comment, and which line is a heading: the same of tables of numbers and of tables with words.

/// What separates fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Delimiter {
    /// A sign.
    Sign(char),
    /// Blanks, as many as there are.
    Blank,
}

/// Delimiters, in the order in which they are preferred.
pub(crate) const DELIMITERS: [Delimiter; 4] =
    [Delimiter::Sign(';'), Delimiter::Sign('\t'), Delimiter::Sign(','), Delimiter::Blank];
/// Signs with which a comment begins.
const COMMENT: [&str; 4] = ["#", "!", "%", "//"];

impl Delimiter {
    /// The fields of a line, without quotes; a delimiter behind the last field ends the line.
    pub(crate) fn split(self, line: &str) -> Vec<&str> {
        self.fields(line, true)
    }

    /// The fields of a line, without quotes. `ends` says whether a delimiter behind the last field ends the line, or an empty field is behind it.
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

    /// Whether a comma can be a decimal sign between such delimiters.
    pub(crate) fn leaves_commas(self) -> bool {
        self != Delimiter::Sign(',')
    }

    /// Name of the delimiter, for a message.
    pub(crate) fn called(self) -> &'static str {
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

/// A line without its comment sign, and whether it had one.
pub(crate) fn bare(line: &str) -> (&str, bool) {
    let line = line.trim();
    let comment = COMMENT.iter().find_map(|sign| line.strip_prefix(sign));
    (comment.unwrap_or(line), comment.is_some())
}

/// The last line of a preamble, if it names something.
pub(crate) fn heading(before: &[&str], delimiter: Delimiter) -> Option<Vec<String>> {
    let line = before.iter().rev().map(|line| bare(line).0).find(|line| !line.trim().is_empty())?;
    let fields: Vec<String> = delimiter.split(line).into_iter().map(str::to_owned).collect();
    fields.iter().any(|field| field.chars().any(char::is_alphabetic)).then_some(fields)
}
