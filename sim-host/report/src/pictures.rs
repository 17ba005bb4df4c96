//! Writing a report: pictures, data files and the page.

mod axis;
mod chart;
mod clip;
mod colour_map;
mod crash_section;
mod curve;
mod data_file;
mod decimate;
mod draw;
mod drawn;
mod extent;
mod heat_map;
mod legend;
mod marks;
mod number;
mod page;
mod plot_data;
mod sheet;
mod style;

use std::collections::HashSet;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::{Figure, HeatMap, Report};

/// Why a report could not be written.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// The directory or a file cannot be written.
    #[error("cannot write {}", path.display())]
    Write {
        /// The directory or file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A picture cannot be drawn.
    #[error("cannot draw {}: {reason}", path.display())]
    Draw {
        /// The picture's file.
        path: PathBuf,
        /// What the plotting library said.
        reason: String,
    },
    /// A figure's id cannot be the stem of its files.
    #[error("figure id {id:?} is empty, used twice, or has characters other than a-z A-Z 0-9 _ -")]
    Id {
        /// The id.
        id: String,
    },
    /// A map has no cells, or columns of different lengths, or curves above it that its table has no room for.
    #[error("figure {figure}: the columns of the map differ in length, or there are none, or curves above them")]
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

/// Writes `report.html` and, for each figure, `ID.svg`, `ID.png` and `ID.csv`.
///
/// The directory is created if it does not exist; files of the same name are replaced. The page is
/// written last, so a page that exists has its figures beside it.
///
/// # Errors
/// If a figure is malformed, which is found out before anything is written, or if a file cannot be
/// written.
pub fn write(report: &Report, dir: &Path) -> Result<(), ReportError> {
    check(&report.figures)?;
    fs::create_dir_all(dir).map_err(failure(dir))?;
    let path = dir.join("report.html");
    let figures = || report.figures.par_iter().try_for_each(|figure| write_figure(figure, dir));
    let (figures, page) = rayon::join(figures, || page::page(report).map_err(undrawn(&path)));
    figures?;
    let page = page?;
    fs::write(&path, page).map_err(failure(&path))
}

/// A figure as an SVG document, as [`write()`] writes it.
///
/// # Errors
/// If the figure is malformed or cannot be drawn.
pub fn svg(figure: &Figure) -> Result<String, ReportError> {
    check(std::slice::from_ref(figure))?;
    draw::svg(figure, true).map_err(undrawn(Path::new(&format!("{}.svg", figure.id))))
}

/// The data of a figure as CSV, as [`write()`] writes them.
///
/// # Errors
/// If the figure is malformed.
pub fn csv(figure: &Figure) -> Result<String, ReportError> {
    check(std::slice::from_ref(figure))?;
    let path = PathBuf::from(format!("{}.csv", figure.id));
    let mut bytes = Vec::new();
    data_file::write(figure, &mut bytes).map_err(io::Error::from).map_err(failure(&path))?;
    String::from_utf8(bytes).map_err(|error| failure(&path)(io::Error::new(io::ErrorKind::InvalidData, error)))
}

/// Writes the files of one figure.
fn write_figure(figure: &Figure, dir: &Path) -> Result<(), ReportError> {
    let file = |extension: &str| dir.join(format!("{}.{extension}", figure.id));

    let path = file("csv");
    File::create(&path).and_then(|target| data_file::write(figure, target).map_err(io::Error::from)).map_err(failure(&path))?;

    let path = file("svg");
    let picture = draw::svg(figure, true).map_err(undrawn(&path))?;
    fs::write(&path, picture).map_err(failure(&path))?;

    let path = file("png");
    draw::png(figure, &path).map_err(undrawn(&path))
}

fn check(figures: &[Figure]) -> Result<(), ReportError> {
    let mut ids = HashSet::new();
    for figure in figures {
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        let usable = !figure.id.is_empty() && figure.id.chars().all(plain);
        if !usable || !ids.insert(figure.id.as_str()) {
            return Err(ReportError::Id { id: figure.id.clone() });
        }
        let sound = |map: &HeatMap| {
            let rows = map.size().1;
            rows > 0 && map.columns.iter().all(|column| column.len() == rows) && figure.series.is_empty()
        };
        if figure.map.as_ref().is_some_and(|map| !sound(map)) {
            return Err(ReportError::Map { figure: figure.id.clone() });
        }
        for series in &figure.series {
            if series.columns().iter().any(|column| column.len() != series.x.len()) {
                let (figure, series) = (figure.id.clone(), series.name.clone());
                return Err(ReportError::Length { figure, series });
            }
        }
    }
    Ok(())
}

fn failure(path: &Path) -> impl FnOnce(io::Error) -> ReportError {
    |source| ReportError::Write { path: path.to_owned(), source }
}

fn undrawn(path: &Path) -> impl FnOnce(String) -> ReportError {
    |reason| ReportError::Draw { path: path.to_owned(), reason }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Series;

    #[test]
    fn malformed_figures_are_refused_before_anything_is_written() {
        let dir = std::env::temp_dir().join("report-that-must-not-exist");
        let figure = |id: &str| Figure { id: id.into(), ..Figure::default() };
        let map = |columns: Vec<Vec<f64>>| Figure { map: Some(HeatMap { columns, ..HeatMap::default() }), ..figure("map") };
        let ragged = Series { x: vec![1.0], ..Series::default() };
        for figures in [
            vec![figure("../escape")],
            vec![figure("")],
            vec![figure("twice"), figure("twice")],
            vec![map(Vec::new())],
            vec![map(vec![vec![1.0, 2.0], vec![1.0]])],
            vec![Figure { series: vec![Series::default()], ..map(vec![vec![1.0]]) }],
            vec![Figure { series: vec![ragged], ..figure("ragged") }],
        ] {
            assert!(write(&Report { figures, ..Report::default() }, &dir).is_err());
        }
        assert!(!dir.exists());
    }

    #[test]
    fn errors_name_the_file() {
        let occupied = std::env::temp_dir().join(format!("occupied-{}", std::process::id()));
        fs::write(&occupied, "").unwrap();
        let error = write(&Report::default(), &occupied).unwrap_err();
        fs::remove_file(&occupied).unwrap();
        assert!(error.to_string().contains("occupied"), "{error}");
    }
}
