//! The legend: a row of swatches between title and plot, where it cannot hide data.

use plotters::element::{PathElement, Rectangle};
use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::HPos;
use plotters::style::{Color, RGBColor};

use super::sheet::{Failure, Lettering, Sheet};
use super::style::{FRAME, INK, SHADE, series_color, tint};
use crate::figure::{Figure, Style};

const TEXT_SIZE: f64 = 24.0;
const ROW_HEIGHT: f64 = 36.0;
const SWATCH: f64 = 44.0;
const DOT_SWATCH: f64 = 14.0;
const GAP: f64 = 12.0;
const SPACING: f64 = 38.0;

/// Symbol of an entry.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Swatch {
    Line,
    Dashed,
    Dot(usize),
    Band,
    Shade,
}

impl Swatch {
    fn width(self) -> f64 {
        if matches!(self, Self::Dot(_)) { DOT_SWATCH } else { SWATCH }
    }
}

/// An entry with its position in points from the top left corner of the legend.
struct Entry {
    text: String,
    /// The swatch, or for a continuation line the width of the swatch in the first line.
    swatch: Result<Swatch, f64>,
    color: RGBColor,
    left: f64,
    row: usize,
}

/// A laid-out legend.
pub(super) struct Legend {
    entries: Vec<Entry>,
}

impl Legend {
    /// Creates a legend of every curve, and of the shaded intervals whose label does not fit into
    /// the plot.
    ///
    /// A single curve without shading has no legend; its axis names it.
    pub fn lay_out<DB: DrawingBackend>(figure: &Figure, shades: &[&str], width: f64, sheet: &Sheet<DB>) -> Self {
        let curves = figure.named_series().enumerate().filter(|(_, series)| series.shows_something()).map(|(index, series)| {
            let swatch = match series.style {
                Style::Line => Swatch::Line,
                Style::Dashed => Swatch::Dashed,
                Style::Points => Swatch::Dot(figure.dots_before(index)),
                Style::Band { .. } => Swatch::Band,
            };
            (series.name.as_str(), swatch, series_color(index))
        });
        let intervals = shades.iter().map(|&label| (label, Swatch::Shade, SHADE));
        let named: Vec<_> = curves.chain(intervals).filter(|(name, ..)| !name.is_empty()).collect();
        if named.len() < 2 {
            return Self { entries: Vec::new() };
        }
        let (mut left, mut row) = (0.0, 0);
        let mut entries = Vec::with_capacity(named.len());
        for (text, swatch, color) in named {
            let length = swatch.width() + GAP + sheet.text_width(text, TEXT_SIZE);
            if left > 0.0 && left + length > width {
                (left, row) = (0.0, row + 1);
            }
            let room = width - swatch.width() - GAP;
            let lines = wrapped(text, |line| sheet.text_width(line, TEXT_SIZE) <= room);
            let last = lines.len() - 1;
            entries.extend(lines.into_iter().enumerate().map(|(n, text)| {
                let swatch = (n == 0).then_some(swatch).ok_or(swatch.width());
                Entry { text, swatch, color, left, row: row + n }
            }));
            (left, row) = if last > 0 { (width, row + last) } else { (left + length + SPACING, row) };
        }
        Self { entries }
    }

    /// Returns the height in points, zero for an empty legend.
    pub fn height(&self) -> f64 {
        self.entries.last().map_or(0.0, |last| (last.row + 1) as f64 * ROW_HEIGHT + 6.0)
    }

    /// Draws the legend with its corner at the given position, in points.
    pub fn draw<DB: DrawingBackend>(&self, sheet: &Sheet<DB>, corner: (f64, f64)) -> Result<(), Failure<DB>> {
        let (area, pen) = (sheet.root, sheet.pen);
        let look = Lettering { size: TEXT_SIZE, color: INK, hold: HPos::Left };
        for entry in &self.entries {
            let left = corner.0 + entry.left;
            let middle = corner.1 + (entry.row as f64 + 0.5) * ROW_HEIGHT;
            let at = |x: f64, y: f64| (pen.px(left + x), pen.px(middle + y));
            let stroke = |from: f64, to: f64| PathElement::new(vec![at(from, 0.0), at(to, 0.0)], pen.line(entry.color, 4.0));
            let block = [at(0.0, -11.0), at(SWATCH, 11.0)];
            let Ok(swatch) = entry.swatch else {
                sheet.write(&entry.text, look, at(entry.room(), 0.0))?;
                continue;
            };
            match swatch {
                Swatch::Line => area.draw(&stroke(0.0, SWATCH))?,
                Swatch::Dashed => {
                    for from in [0.0, 17.0, 34.0] {
                        area.draw(&stroke(from, (from + 10.0).min(SWATCH)))?;
                    }
                }
                Swatch::Dot(kind) => sheet.dot(kind, 6.5, entry.color, at(DOT_SWATCH / 2.0, 0.0))?,
                Swatch::Band => {
                    area.draw(&Rectangle::new(block, tint(entry.color)))?;
                    area.draw(&stroke(0.0, SWATCH))?;
                }
                Swatch::Shade => {
                    area.draw(&Rectangle::new(block, entry.color.filled()))?;
                    area.draw(&Rectangle::new(block, pen.line(FRAME, 1.0)))?;
                }
            }
            sheet.write(&entry.text, look, at(entry.room(), 0.0))?;
        }
        Ok(())
    }
}

impl Entry {
    /// Returns the room before the text.
    fn room(&self) -> f64 {
        self.swatch.map_or_else(|width| width, Swatch::width) + GAP
    }
}

/// Divides the text between words into lines that fit; a word that is too long stays whole.
fn wrapped(text: &str, fits: impl Fn(&str) -> bool) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let Some(line) = lines.last_mut() else { break };
        let longer = if line.is_empty() { word.to_owned() } else { format!("{line} {word}") };
        if line.is_empty() || fits(&longer) { *line = longer } else { lines.push(word.to_owned()) }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::wrapped;

    #[test]
    fn long_names_are_cut_between_words() {
        let lines = |text: &str, most: usize| wrapped(text, |line| line.len() <= most);
        assert_eq!(lines("mean and extremes", 20), ["mean and extremes"]);
        assert_eq!(lines("mean and extremes", 9), ["mean and", "extremes"]);
        assert_eq!(lines("mean and extremes", 3), ["mean", "and", "extremes"]);
    }
}
