//! Why a text is no table of numbers.

/// Why a text is no table of numbers.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TableError {
    /// There is no line but comments.
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
    /// A line that is no numbers stands among those that are.
    #[error("`{begins}` interrupts the table of numbers")]
    Interrupted {
        /// Number of the line, from 1.
        line: usize,
        /// Beginning of the line.
        begins: String,
    },
    /// The heading has another number of columns than the table.
    #[error("{numbers} numbers, but the heading names {names} columns{}", if *.decimal_comma { "; a decimal comma cannot be told from a comma between fields: export with semicolons" } else { "" })]
    Width {
        /// Number of the first line of the table, from 1.
        line: usize,
        /// Numbers in each line.
        numbers: usize,
        /// Columns that the heading names.
        names: usize,
        /// Whether a decimal comma between commas explains it.
        decimal_comma: bool,
    },
}

impl TableError {
    /// Number of the line that shows it, from 1.
    pub fn line(&self) -> Option<usize> {
        match self {
            TableError::Empty | TableError::NoNumbers | TableError::NoTable { .. } => None,
            TableError::OneLine { line } | TableError::Interrupted { line, .. } | TableError::Width { line, .. } => Some(*line),
        }
    }
}
