//! What drawing asks of figures and series.

use crate::figure::{Figure, Series, Style};

impl Series {
    /// The vectors that run beside `x`: y, then the edges of a band.
    pub(super) fn columns(&self) -> Vec<&[f64]> {
        match &self.style {
            Style::Band { lower, upper } => vec![&self.y, lower, upper],
            Style::Line | Style::Dashed | Style::Points => vec![&self.y],
        }
    }
}

impl Figure {
    /// Whether both axes have the same unit of length.
    pub(super) fn is_plane(&self) -> bool {
        self.equal_aspect && !self.x.log && !self.y.log
    }

    /// How many series of dots come before the one at `index`.
    pub(super) fn dots_before(&self, index: usize) -> usize {
        self.series[..index].iter().filter(|series| series.style == Style::Points).count()
    }
}
