//! Properties of figures and series that are needed for drawing.

use crate::figure::{Figure, Series, Style};

impl Series {
    /// Returns `true` if it has at least one point; otherwise the legend does not name it.
    pub(super) fn shows_something(&self) -> bool {
        self.x.iter().zip(&self.y).any(|(x, y)| x.is_finite() && y.is_finite())
    }
}

impl Figure {
    /// Returns `true` if both axes have the same unit of length.
    pub(super) fn is_plane(&self) -> bool {
        self.equal_aspect && !self.x.log && !self.y.log
    }

    /// Returns the curves that a legend names: those of a panel only if it does not repeat the
    /// first plot.
    pub(super) fn named_series(&self) -> impl Iterator<Item = &Series> {
        self.series.iter().chain(self.panels.iter().filter(|panel| !panel.repeats).flat_map(|panel| &panel.series))
    }

    /// Returns the number of series of dots before the one at `index` of the named ones.
    pub(super) fn dots_before(&self, index: usize) -> usize {
        self.named_series().take(index).filter(|series| series.style == Style::Points).count()
    }
}
