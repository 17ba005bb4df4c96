//! Tables in delimited text: encoding, delimiter, decimal sign, comments, preamble and heading are
//! found from the text alone. [`read`] accepts only a table of numbers, and reports the first line
//! that is not one; [`read_mixed`] also accepts columns of words. [`mod@file`] reads files within
//! limits, and [`visible`] prepares text from outside for a terminal.
//!
//! # Example
//!
//! ```
//! let table = sonoglide_delimited::read("t [s];v [mm/s]\n0,0;12,5\n0,1;13,5\n", None)?;
//! assert_eq!(table.header.as_deref(), Some(&["t [s]".to_owned(), "v [mm/s]".to_owned()][..]));
//! assert_eq!(table.columns[1], [12.5, 13.5]);
//!
//! let error = sonoglide_delimited::read("t,v\n0,1\n1,1\n2,overload\n3,1\n", None).unwrap_err();
//! assert_eq!(error.line(), Some(4));
//! # Ok::<(), sonoglide_delimited::TableError>(())
//! ```
#![forbid(unsafe_code)]

mod error;
pub mod file;
mod form;
mod mixed;
mod table;
mod text;

pub use error::TableError;
pub use mixed::{Cells, MixedTable, read_mixed};
pub use table::{Table, read};
pub use text::{beginning, decode, hidden, number, visible, visible_line};
