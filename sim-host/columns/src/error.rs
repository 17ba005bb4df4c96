//! Errors in reading a table.

/// Reason for which a text is not a table.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TableError {
    /// The text has no lines except comments.
    #[error("it is empty")]
    Empty,
    /// No line has a number.
    #[error("no table of numbers; it begins with `{begins}`")]
    NoNumbers {
        /// Beginning of the first line.
        begins: String,
    },
    /// The file is binary and has another format, or is damaged.
    #[error("{0}")]
    Binary(String),
    /// The table has too many lines.
    #[error("it has {lines} lines, but at most {most} are read; save fewer rows, or averages")]
    Long {
        /// Number of lines.
        lines: usize,
        /// Largest number of lines.
        most: usize,
    },
    /// A comma in a number may separate thousands or decimals.
    #[error(
        "`{cell}` may have a decimal comma or a comma between thousands; write the numbers of the table with a decimal point"
    )]
    Comma {
        /// Number of the line, from 1.
        line: usize,
        /// The cell.
        cell: String,
    },
    /// A line without numbers is between lines with numbers, or after them.
    #[error("`{begins}` interrupts the table of numbers")]
    Interrupted {
        /// Number of the line, from 1.
        line: usize,
        /// Beginning of the line.
        begins: String,
    },
    /// A line has fewer or more cells than the others.
    #[error("{cells} cells, but the table has {columns} columns")]
    Cells {
        /// Number of the line, from 1.
        line: usize,
        /// Number of cells of the line.
        cells: usize,
        /// Number of columns of the table.
        columns: usize,
    },
    /// The heading has a different number of columns from the table.
    #[error("{columns} columns, but the heading names {names}{}", if *.decimal_comma {
        "; a decimal comma cannot be distinguished from a comma between fields: export with semicolons"
    } else {
        ""
    })]
    Width {
        /// Number of the first line of the table, from 1.
        line: usize,
        /// Number of columns of the table.
        columns: usize,
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
            TableError::Empty | TableError::NoNumbers { .. } | TableError::Binary(_) | TableError::Long { .. } => None,
            TableError::Interrupted { line, .. }
            | TableError::Cells { line, .. }
            | TableError::Comma { line, .. }
            | TableError::Width { line, .. } => Some(*line),
        }
    }
}
