//! Arguments of figures: their size and their formats.

use clap::Args;

use super::provenance::provenance;
use report::{Drawing, PictureFormat, PrintSize};
use sim::output::Presentation;

/// How the figures of a report are drawn.
#[derive(Args, Default)]
pub(super) struct DrawingArgs {
    /// Size of the figures in print: a width, `88mm` of a column or `180mm` of two, or width x height, `120x80mm`; with letters as large as a paper's, and no
    /// title. Default: 1600 x 900 pixels.
    #[arg(long, value_name = "SIZE")]
    figure_size: Option<PrintSize>,
    /// Formats of the figures: `svg`, `png`, `pdf`, or several with commas between. Default: svg,png.
    #[arg(long, value_name = "FORMAT,…", value_delimiter = ',')]
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
        Drawing { size: self.figure_size, formats, pdf: Some(report::pdf) }
    }
}
