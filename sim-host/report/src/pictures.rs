//! Writing a report: pictures, data files and the page.

mod axis;
mod chart;
mod clip;
mod colour_map;
mod contour;
mod crash_section;
mod curve;
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

use std::fs::{self, File};
use std::io;
use std::path::Path;

use rayon::prelude::*;

use self::draw::Canvas;
#[cfg(feature = "pdf")]
pub use self::pdf::pdf;
use crate::data::{ReportError, check, data_file, write_error};
use crate::drawing::{Drawing, PictureFormat};
use crate::{Figure, Report};

/// Writes `report.html` and, for each figure, `ID.svg`, `ID.png` and `ID.csv`.
///
/// # Errors
/// As [`write_drawn`].
pub fn write(report: &Report, dir: &Path) -> Result<(), ReportError> {
    write_drawn(report, dir, &Drawing::default())
}

/// Writes `report.html` and, for each figure, `ID.csv` and the pictures in the requested formats.
///
/// The directory is created if it does not exist; files of the same name are replaced. The page is
/// written last, so a page that exists has all its figure files.
///
/// # Errors
/// If a figure is malformed, which is checked before anything is written, or if a file cannot be
/// written.
pub fn write_drawn(report: &Report, dir: &Path, drawing: &Drawing) -> Result<(), ReportError> {
    check(&report.figures)?;
    check_formats(drawing)?;
    fs::create_dir_all(dir).map_err(write_error(dir))?;
    let path = dir.join("report.html");
    let figures = || report.figures.par_iter().try_for_each(|figure| write_figure(figure, dir, drawing));
    let (figures, page) = rayon::join(figures, || page::page(report, &drawing.formats).map_err(draw_error(&path)));
    figures?;
    let page = page?;
    fs::write(&path, page).map_err(write_error(&path))
}

/// Returns a figure as an SVG document, as [`write()`] writes it.
///
/// # Errors
/// If the figure is malformed or cannot be drawn.
pub fn svg(figure: &Figure) -> Result<String, ReportError> {
    check(std::slice::from_ref(figure))?;
    draw::svg(figure, Canvas::default()).map_err(draw_error(Path::new(&format!("{}.svg", figure.id))))
}

/// Checks that every requested format can be drawn.
fn check_formats(drawing: &Drawing) -> Result<(), ReportError> {
    let missing = drawing.formats.iter().find(|&&format| format == PictureFormat::Pdf && drawing.pdf.is_none());
    missing.map_or(Ok(()), |format| Err(ReportError::Format { format: format.ending() }))
}

/// Writes the files of one figure.
fn write_figure(figure: &Figure, dir: &Path, drawing: &Drawing) -> Result<(), ReportError> {
    let file = |extension: &str| dir.join(format!("{}.{extension}", figure.id));

    let path = file("csv");
    File::create(&path)
        .and_then(|target| data_file::write(figure, target).map_err(io::Error::from))
        .map_err(write_error(&path))?;

    let canvas = Canvas::file(drawing.size);
    let to_pdf = drawing.pdf.unwrap_or(|_| Err("no PDF writer".to_owned()));
    for format in &drawing.formats {
        let path = file(format.ending());
        let picture = match format {
            PictureFormat::Svg => draw::svg(figure, canvas).map(String::into_bytes),
            PictureFormat::Png => draw::png(figure, canvas),
            PictureFormat::Pdf => draw::svg(figure, canvas).and_then(|svg| to_pdf(&svg)),
        };
        fs::write(&path, picture.map_err(draw_error(&path))?).map_err(write_error(&path))?;
    }
    Ok(())
}

fn draw_error(path: &Path) -> impl FnOnce(String) -> ReportError {
    |reason| ReportError::Draw { path: path.to_owned(), reason }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{HeatMap, Series};

    #[test]
    fn pdf_without_a_converter_writes_nothing() {
        let dir = std::env::temp_dir().join("report-without-pdf-that-must-not-exist");
        let drawing = Drawing { formats: vec![PictureFormat::Svg, PictureFormat::Pdf], ..Drawing::default() };
        let refused = write_drawn(&Report::default(), &dir, &drawing);
        assert!(matches!(refused, Err(ReportError::Format { format: "pdf" })) && !dir.exists(), "{refused:?}");
    }

    #[test]
    fn malformed_figures_write_nothing() {
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
