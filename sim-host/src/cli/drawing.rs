//! Arguments of figures: their size and their formats.

use clap::Args;

use super::provenance::provenance;
use report::{Drawing, PictureFormat, PrintSize};
use sim::output::Presentation;

/// Writer of PDF figures, if this build has one.
#[cfg(feature = "pdf")]
const PDF: Option<report::ToPdf> = Some(report::pdf);
#[cfg(not(feature = "pdf"))]
const PDF: Option<report::ToPdf> = None;

/// Reads a format, and refuses one that this build cannot write before anything is run.
fn format(text: &str) -> Result<PictureFormat, String> {
    match text.parse()? {
        PictureFormat::Pdf if PDF.is_none() => Err(super::without("writer of PDF figures")),
        format => Ok(format),
    }
}

/// How the figures of a report are drawn.
#[derive(Args, Default)]
pub(super) struct DrawingArgs {
    /// Size of the figures in print: a width, `88mm` of a column or `180mm` of two, or width x height, `120x80mm`; with letters as large as a paper's, and no
    /// title. Default: 1600 x 900 pixels.
    #[arg(long, value_name = "SIZE")]
    figure_size: Option<PrintSize>,
    /// Formats of the figures: `svg`, `png`, `pdf`, or several with commas between. Default: svg,png.
    #[arg(long, value_name = "FORMAT,…", value_delimiter = ',', value_parser = format)]
    figure_format: Vec<PictureFormat>,
}

impl DrawingArgs {
    /// How a report is shown, and where it comes from.
    pub(super) fn presentation(&self) -> Presentation {
        Presentation { drawing: self.drawing(), provenance: provenance() }
    }

    /// How figures are drawn: each format once.
    pub(super) fn drawing(&self) -> Drawing {
        let mut formats = Vec::new();
        for &format in &self.figure_format {
            if !formats.contains(&format) {
                formats.push(format);
            }
        }
        let formats = if formats.is_empty() { Drawing::default().formats } else { formats };
        Drawing { size: self.figure_size, formats, pdf: PDF }
    }
}
