//! Marks that explain the curves: shaded intervals, reference lines and labelled points.

use plotters::element::{Circle, Rectangle};
use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::HPos;
use plotters::style::{Color, WHITE};

use super::axis::Scale;
use super::chart::{Chart, Plot, TICK_SIZE};
use super::sheet::{Failure, Lettering, Sheet};
use super::style::{INK, MUTED, SHADE};
use crate::figure::Figure;

/// Returns the labels of the shaded intervals that are too narrow for them on a plot of this width,
/// each once.
pub(super) fn spans_without_room<'f, DB: DrawingBackend>(
    figure: &'f Figure,
    x: &Scale,
    width: f64,
    sheet: &Sheet<DB>,
) -> Vec<&'f str> {
    let mut labels: Vec<&str> = Vec::new();
    for span in &figure.shaded {
        let share = visible_span(x, span.from, span.to).map_or(0.0, |(a, b)| (b - a) / x.extent());
        let fits = share * width > sheet.text_width(&span.label, TICK_SIZE) + 16.0;
        if !fits && !labels.contains(&span.label.as_str()) {
            labels.push(&span.label);
        }
    }
    labels
}

/// Returns the visible part of an interval, in positions.
fn visible_span(x: &Scale, from: f64, to: f64) -> Option<(f64, f64)> {
    let from = x.position(from).unwrap_or(x.low).max(x.low);
    let to = x.position(to).unwrap_or(x.high).min(x.high);
    (from < to).then_some((from, to))
}

impl<DB: DrawingBackend> Plot<'_, '_, DB> {
    /// Draws the shaded intervals, behind everything.
    pub(super) fn shades(&self, chart: &Chart<DB>) -> Result<(), Failure<DB>> {
        for span in &self.figure.shaded {
            if let Some((from, to)) = visible_span(&self.x, span.from, span.to) {
                let corners = [(from, self.y.low), (to, self.y.high)];
                chart.plotting_area().draw(&Rectangle::new(corners, SHADE.filled()))?;
            }
        }
        Ok(())
    }

    /// Draws the labels of the shaded intervals at the top of the plot; those in `elsewhere` are
    /// omitted.
    pub(super) fn shade_labels(&self, chart: &Chart<DB>, elsewhere: &[&str]) -> Result<(), Failure<DB>> {
        let look = Lettering { size: TICK_SIZE, color: MUTED, hold: HPos::Center };
        for span in &self.figure.shaded {
            if elsewhere.contains(&span.label.as_str()) {
                continue;
            }
            if let Some((from, to)) = visible_span(&self.x, span.from, span.to) {
                let (x, y) = chart.backend_coord(&(f64::midpoint(from, to), self.y.high));
                self.sheet.note(&span.label, look, SHADE, (x, y + self.sheet.pen.px(22.0)))?;
            }
        }
        Ok(())
    }

    /// Draws horizontal lines across the plot, each with its label above its right end.
    pub(super) fn reference_lines(&self, chart: &mut Chart<DB>) -> Result<(), Failure<DB>> {
        let look = Lettering { size: TICK_SIZE, color: MUTED, hold: HPos::Right };
        let px = |points| self.sheet.pen.px(points);
        for (value, label) in &self.figure.hlines {
            let Some(y) = self.y.position(*value).filter(|&y| self.y.shows(y)) else { continue };
            // A line across a map would cover data, so only its right end is drawn.
            let (ink, from) = match self.figure.map {
                Some(_) => (WHITE, self.x.high - 0.16 * self.x.extent()),
                None => (MUTED, self.x.low),
            };
            self.dashes(chart, vec![(from, y), (self.x.high, y)], ink, 2.0)?;
            let (right, height) = chart.backend_coord(&(self.x.high, y));
            self.sheet.note(label, look, WHITE, (right - px(10.0), height - px(17.0)))?;
        }
        Ok(())
    }

    /// Draws labelled points, on top of everything.
    pub(super) fn markers(&self, chart: &Chart<DB>) -> Result<(), Failure<DB>> {
        let visible = |x, y| self.point(x, y).filter(|&(x, y)| self.x.shows(x) && self.y.shows(y));
        let samples = self.figure.series.iter().flat_map(|s| s.x.iter().zip(&s.y)).map(|(&x, &y)| (x, y));
        let marks = self.figure.markers.iter().map(|m| (m.x, m.y));
        let busy: Vec<(i32, i32)> =
            samples.chain(marks).filter_map(|(x, y)| visible(x, y)).map(|point| chart.backend_coord(&point)).collect();

        for marker in &self.figure.markers {
            let Some(point) = visible(marker.x, marker.y) else { continue };
            for (radius, color) in [(11.0, WHITE), (8.0, INK)] {
                let dot = Circle::new(point, self.sheet.pen.px(radius), color.filled());
                chart.plotting_area().draw(&dot)?;
            }
            let (look, place) = self.marker_label(chart, &marker.label, chart.backend_coord(&point), &busy);
            self.sheet.note(&marker.label, look, WHITE, place)?;
        }
        Ok(())
    }

    /// Returns the place at which the label of a marker covers the fewest samples: next to it,
    /// above or below.
    fn marker_label(&self, chart: &Chart<DB>, text: &str, (x, y): (i32, i32), busy: &[(i32, i32)]) -> (Lettering, (i32, i32)) {
        let width = self.sheet.text_pixels(text, TICK_SIZE);
        let (aside, off, half) = (self.sheet.pen.px(18.0), self.sheet.pen.px(22.0), self.sheet.pen.px(14.0));
        let (columns, rows) = chart.plotting_area().get_pixel_range();
        let cost = |&(side, shift): &(i32, i32)| {
            let (near, far) = (x + side * aside, x + side * (aside + width));
            let (left, right, middle) = (near.min(far), near.max(far), y + shift * off);
            let outside = left < columns.start || right > columns.end || middle - half < rows.start || middle + half > rows.end;
            let covers = |&&(bx, by): &&(i32, i32)| (left..=right).contains(&bx) && (by - middle).abs() <= half;
            (outside, busy.iter().filter(covers).count())
        };
        let places = [(1, -1), (-1, -1), (1, 1), (-1, 1), (1, 0), (-1, 0)];
        let (side, shift) = places.into_iter().min_by_key(cost).unwrap_or((1, -1));
        let hold = if side > 0 { HPos::Left } else { HPos::Right };
        (Lettering { size: TICK_SIZE, color: INK, hold }, (x + side * aside, y + shift * off))
    }
}
