//! Arguments of figures: size and formats.

use clap::Args;

use super::provenance::provenance;
use report::{Drawing, PictureFormat, PrintSize};
use sim::output::Presentation;

/// Writer of PDF figures, if this build has one.
#[cfg(feature = "pdf")]
const PDF: Option<report::ToPdf> = Some(report::pdf);
#[cfg(not(feature = "pdf"))]
const PDF: Option<report::ToPdf> = None;

/// Parses a format. A format that this build cannot write is refused here, before anything runs.
fn format(text: &str) -> Result<PictureFormat, String> {
    match text.parse()? {
        PictureFormat::Pdf if PDF.is_none() => Err(super::missing_part("writer of PDF figures")),
        format => Ok(format),
    }
}

/// Options of the figures of a report.
#[derive(Args, Default)]
pub(super) struct DrawingArgs {
    /// Size of the figures in print: a width (`88mm` for one column, `180mm` for two), or width x
    /// height (`120x80mm`). Letters have the size of a paper's; titles are left out. Default: 1600
    /// x 900 pixels.
    #[arg(long, value_name = "SIZE")]
    figure_size: Option<PrintSize>,
    /// Formats of the figures: `svg`, `png`, `pdf`, separated by commas. Default: svg,png.
    #[arg(long, value_name = "FORMAT,…", value_delimiter = ',', value_parser = format)]
    figure_format: Vec<PictureFormat>,
}

impl DrawingArgs {
    /// Returns the options of a report and its provenance.
    pub(super) fn presentation(&self) -> Presentation {
        Presentation { drawing: self.drawing(), contours: Vec::new(), provenance: provenance() }
    }

    /// Returns the options of figures, with each format once.
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
