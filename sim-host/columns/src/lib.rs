//! Tables of measured data from any file: [`read`] finds encoding, delimiter, decimal sign,
//! comments, preamble, heading and units from the text alone. [`Unit`] and [`Heading`] are the one
//! grammar of names and units. [`mod@file`] reads files within limits, and [`visible`] prepares
//! text from outside for a terminal. `formats`, a feature, also reads binary files.
//!
//! # Example
//!
//! ```
//! let table = sonoglide_columns::read("t [s];v [mm/s]\n0,0;12,5\n0,1;13,5\n", None)?;
//! assert_eq!(table.headings(), ["t [s]", "v [mm/s]"]);
//! assert_eq!(table.columns[1].values, [12.5, 13.5]);
//!
//! let error = sonoglide_columns::read("t,v\n0,1\n1,1\n2\n3,1\n", None).unwrap_err();
//! assert_eq!(error.line(), Some(4));
//! # Ok::<(), sonoglide_columns::TableError>(())
//! ```
#![forbid(unsafe_code)]

mod error;
pub mod file;
mod form;
#[cfg(feature = "formats")]
pub mod formats;
pub mod heading;
mod table;
mod text;
pub mod unit;

pub use error::TableError;
#[cfg(feature = "formats")]
pub use formats::{parse, text};
pub use heading::Heading;
pub use table::{BadCell, Column, Table, read};
pub use text::{beginning, decode, hidden, is_overflow, number, visible, visible_line};
pub use unit::{Unit, hertz};

/// Reads the table of a text file. `names`, separated by commas, replaces the heading if given.
///
/// # Errors
/// [`TableError`], with the line that causes it.
#[cfg(not(feature = "formats"))]
pub fn parse(bytes: &[u8], names: Option<&str>) -> Result<Table, TableError> {
    read(&decode(bytes), names)
}

/// Decodes the text of a file.
///
/// # Errors
/// None without the feature `formats`.
#[cfg(not(feature = "formats"))]
pub fn text(bytes: &[u8]) -> Result<String, TableError> {
    Ok(decode(bytes))
}
