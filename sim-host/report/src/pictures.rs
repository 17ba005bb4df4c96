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
mod interpolate;
mod legend;
mod marks;
mod number;
mod page;
#[cfg(feature = "pdf")]
mod pdf;
mod plot_data;
mod prepare;
mod sheet;
mod style;

use std::collections::HashSet;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use self::draw::Canvas;
use crate::drawing::{Drawing, PictureFormat};
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
    /// Pictures of this format are a feature of the crate that this build does not have.
    #[error("this build draws no {format} files: it lacks the feature `pdf`")]
    Format {
        /// Ending of the files.
        format: &'static str,
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
/// # Errors
/// As [`write_drawn`].
pub fn write(report: &Report, dir: &Path) -> Result<(), ReportError> {
    write_drawn(report, dir, &Drawing::default())
}

/// Writes `report.html` and, for each figure, its pictures as they are asked for and `ID.csv`.
///
/// The directory is created if it does not exist; files of the same name are replaced. The page is
/// written last, so a page that exists has its figures beside it.
///
/// # Errors
/// If a figure is malformed, which is found out before anything is written, or if a file cannot be
/// written.
pub fn write_drawn(report: &Report, dir: &Path, drawing: &Drawing) -> Result<(), ReportError> {
    check(&report.figures)?;
    drawn(drawing)?;
    fs::create_dir_all(dir).map_err(failure(dir))?;
    let path = dir.join("report.html");
    let figures = || report.figures.par_iter().try_for_each(|figure| write_figure(figure, dir, drawing));
    let (figures, page) = rayon::join(figures, || page::page(report, &drawing.formats).map_err(undrawn(&path)));
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
    draw::svg(figure, Canvas::default()).map_err(undrawn(Path::new(&format!("{}.svg", figure.id))))
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

/// Whether this build can draw so.
fn drawn(drawing: &Drawing) -> Result<(), ReportError> {
    let missing = drawing.formats.iter().find(|&&format| format == PictureFormat::Pdf && !cfg!(feature = "pdf"));
    missing.map_or(Ok(()), |format| Err(ReportError::Format { format: format.ending() }))
}

/// Writes the files of one figure.
fn write_figure(figure: &Figure, dir: &Path, drawing: &Drawing) -> Result<(), ReportError> {
    let file = |extension: &str| dir.join(format!("{}.{extension}", figure.id));

    let path = file("csv");
    File::create(&path).and_then(|target| data_file::write(figure, target).map_err(io::Error::from)).map_err(failure(&path))?;

    let canvas = Canvas::file(drawing.size);
    for format in &drawing.formats {
        let path = file(format.ending());
        let picture = match format {
            PictureFormat::Svg => draw::svg(figure, canvas).map(String::into_bytes),
            PictureFormat::Png => draw::png(figure, canvas),
            PictureFormat::Pdf => portable(figure, canvas),
        };
        fs::write(&path, picture.map_err(undrawn(&path))?).map_err(failure(&path))?;
    }
    Ok(())
}

#[cfg(feature = "pdf")]
fn portable(figure: &Figure, canvas: Canvas) -> Result<Vec<u8>, String> {
    pdf::of(&draw::svg(figure, canvas)?)
}

#[cfg(not(feature = "pdf"))]
fn portable(_: &Figure, _: Canvas) -> Result<Vec<u8>, String> {
    Err("this build lacks the feature `pdf`".to_owned())
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
            let fits = |(series, values): (&crate::Series, &Vec<f64>)| series.x.len() == values.len();
            if along.values.len() != figure.series.len() || !figure.series.iter().zip(&along.values).all(fits) {
                return Err(ReportError::Length { figure: figure.id.clone(), series: along.csv_column.clone() });
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
