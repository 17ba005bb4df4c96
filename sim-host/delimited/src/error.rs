//! Errors in reading a table of numbers.

/// Reason for which a text is not a table of numbers.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TableError {
    /// The text has no lines except comments.
    #[error("it is empty")]
    Empty,
    /// No column has numbers.
    #[error("no table of numbers")]
    NoNumbers,
    /// No line has two numbers or more.
    #[error("it begins with `{begins}`, and no line has two numbers or more")]
    NoTable {
        /// Beginning of the first line that is not empty.
        begins: String,
    },
    /// A single line has numbers.
    #[error("only line {line} is a line of numbers")]
    OneLine {
        /// Number of the line, from 1.
        line: usize,
    },
    /// A line without numbers is between lines with numbers.
    #[error("`{begins}` interrupts the table of numbers")]
    Interrupted {
        /// Number of the line, from 1.
        line: usize,
        /// Beginning of the line.
        begins: String,
    },
    /// The heading has a different number of columns from the table.
    #[error("{numbers} numbers, but the heading names {names} columns{}", if *.decimal_comma {
        "; a decimal comma cannot be distinguished from a comma between fields: export with semicolons"
    } else {
        ""
    })]
    Width {
        /// Number of the first line of the table, from 1.
        line: usize,
        /// Number of numbers in each line.
        numbers: usize,
        /// Number of columns in the heading.
        names: usize,
        /// `true` if a decimal comma between commas explains it.
        decimal_comma: bool,
    },
}

impl TableError {
    /// Returns the number of the line with the error, from 1.
    pub fn line(&self) -> Option<usize> {
        match self {
            TableError::Empty | TableError::NoNumbers | TableError::NoTable { .. } => None,
            TableError::OneLine { line } | TableError::Interrupted { line, .. } | TableError::Width { line, .. } => Some(*line),
        }
    }
}
