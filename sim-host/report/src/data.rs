//! The data of figures as CSV, and the check for malformed figures.

pub(crate) mod data_file;

use std::collections::HashSet;
use std::io;
use std::path::{Path, PathBuf};

use crate::{Figure, HeatMap, Series, Style};

/// Reason for which a report could not be written.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// The directory or a file cannot be written.
    #[error("cannot write {}", path.display())]
    Write {
        /// The directory or file.
        path: PathBuf,
        /// The error from the system.
        source: io::Error,
    },
    /// A picture cannot be drawn.
    #[error("cannot draw {}: {reason}", path.display())]
    Draw {
        /// The picture's file.
        path: PathBuf,
        /// The error from the plotting library.
        reason: String,
    },
    /// Pictures of this format need a converter that was not given: [`crate::Drawing::pdf`].
    #[error("cannot draw {format} files: the program has no converter for them")]
    Format {
        /// File extension.
        format: &'static str,
    },
    /// A figure's id cannot be used as a file name.
    #[error("figure id {id:?} is empty, used twice, or has characters other than a-z A-Z 0-9 _ -")]
    Id {
        /// The id.
        id: String,
    },
    /// A map has no cells, columns of different lengths, or additional curves, which its table
    /// cannot contain.
    #[error("figure {figure}: the map has no columns, columns of different lengths, or additional curves")]
    Map {
        /// The figure's id.
        figure: String,
    },
    /// A series has more samples in one column than in another.
    #[error("figure {figure}: the columns of series {series:?} differ in length")]
    Length {
        /// The figure's id.
        figure: String,
        /// The series' name.
        series: String,
    },
}

/// Returns the data of a figure as CSV, as in the figure's file of a report.
///
/// # Errors
/// If the figure is malformed.
pub fn csv(figure: &Figure) -> Result<String, ReportError> {
    check(std::slice::from_ref(figure))?;
    let path = PathBuf::from(format!("{}.csv", figure.id));
    let mut bytes = Vec::new();
    data_file::write(figure, &mut bytes).map_err(io::Error::from).map_err(write_error(&path))?;
    String::from_utf8(bytes).map_err(|error| write_error(&path)(io::Error::new(io::ErrorKind::InvalidData, error)))
}

pub(crate) fn check(figures: &[Figure]) -> Result<(), ReportError> {
    let mut ids = HashSet::new();
    for figure in figures {
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        let usable = !figure.id.is_empty() && figure.id.chars().all(plain);
        if !usable || !ids.insert(figure.id.as_str()) {
            return Err(ReportError::Id { id: figure.id.clone() });
        }
        let sound = |map: &HeatMap| {
            let rows = map.size().1;
            let alone = figure.series.is_empty() && figure.panels.is_empty();
            rows > 0 && map.columns.iter().all(|column| column.len() == rows) && alone
        };
        if figure.map.as_ref().is_some_and(|map| !sound(map)) {
            return Err(ReportError::Map { figure: figure.id.clone() });
        }
        for series in figure.all_series() {
            if series.columns().iter().any(|column| column.len() != series.x.len()) {
                let (figure, series) = (figure.id.clone(), series.name.clone());
                return Err(ReportError::Length { figure, series });
            }
        }
        if let Some(along) = &figure.along {
            let fits = |(series, values): (&Series, &Vec<f64>)| series.x.len() == values.len();
            if along.values.len() != figure.series.len() || !figure.series.iter().zip(&along.values).all(fits) {
                return Err(ReportError::Length { figure: figure.id.clone(), series: along.csv_column.clone() });
            }
        }
    }
    Ok(())
}

pub(crate) fn write_error(path: &Path) -> impl FnOnce(io::Error) -> ReportError {
    |source| ReportError::Write { path: path.to_owned(), source }
}

impl Series {
    /// Returns the vectors parallel to `x`: y, then the edges of a band.
    pub(crate) fn columns(&self) -> Vec<&[f64]> {
        match &self.style {
            Style::Band { lower, upper } => vec![&self.y, lower, upper],
            Style::Line | Style::Dashed | Style::Points => vec![&self.y],
        }
    }
}

impl Figure {
    /// Returns the curves of all its plots, from top to bottom.
    pub(crate) fn all_series(&self) -> impl Iterator<Item = &Series> {
        self.series.iter().chain(self.panels.iter().flat_map(|panel| &panel.series))
    }
}

impl HeatMap {
    /// Returns the numbers of columns and rows.
    pub(crate) fn size(&self) -> (usize, usize) {
        (self.columns.len(), self.columns.first().map_or(0, Vec::len))
    }
}
