//! What drawing asks of figures and series.

use crate::figure::{Figure, Series, Style};

impl Series {
    /// Whether it has a point at all: a legend need not name what is not there.
    pub(super) fn shows_something(&self) -> bool {
        self.x.iter().zip(&self.y).any(|(x, y)| x.is_finite() && y.is_finite())
    }
}

impl Figure {
    /// Whether both axes have the same unit of length.
    pub(super) fn is_plane(&self) -> bool {
        self.equal_aspect && !self.x.log && !self.y.log
    }

    /// The curves that a legend names: those of panels only where they are not the same again.
    pub(super) fn named_series(&self) -> impl Iterator<Item = &Series> {
        self.series.iter().chain(self.panels.iter().filter(|panel| !panel.repeats).flat_map(|panel| &panel.series))
    }

    /// How many series of dots come before the one at `index` of those named.
    pub(super) fn dots_before(&self, index: usize) -> usize {
        self.named_series().take(index).filter(|series| series.style == Style::Points).count()
    }
}
