//! Curves: lines, dashes, dots and bands.

use plotters::element::{Circle, PathElement, Polygon};
use plotters::prelude::{DashedLineSeries, DrawingBackend};
use plotters::style::{Color, RGBColor};

use super::chart::{Chart, Plot};
use super::clip::{self, Window};
use super::sheet::Failure;
use super::style::{series_color, tint};
use crate::decimate;
use crate::figure::{Series, Style};

impl<DB: DrawingBackend> Plot<'_, '_, DB> {
    /// Draws separate dots.
    pub(super) fn dots(&self, chart: &Chart<DB>, index: usize) -> Result<(), Failure<DB>> {
        let series = &self.figure.series[index];
        let (xs, ys): (Vec<f64>, Vec<f64>) =
            self.points(series).flatten().filter(|&(x, y)| self.x.shows(x) && self.y.shows(y)).unzip();
        let kind = self.before.dots + self.figure.dots_before(index);
        for i in decimate::keep(&[&xs, &ys], decimate::MAX_POINTS) {
            self.sheet.dot(kind, 5.5, series_color(self.before.curves + index), chart.backend_coord(&(xs[i], ys[i])))?;
        }
        Ok(())
    }

    /// Draws a line with its band, clipped to the plot and thinned.
    pub(super) fn curve(&self, chart: &mut Chart<DB>, index: usize) -> Result<(), Failure<DB>> {
        let (series, color) = (&self.figure.series[index], series_color(self.before.curves + index));
        if let Style::Band { lower, upper } = &series.style {
            self.band(chart, &series.x, lower, upper, color)?;
        }
        let window = Window { x: (self.x.low, self.x.high), y: (self.y.low, self.y.high) };
        let pieces = clip::polyline(self.points(series), window);
        let total: usize = pieces.iter().map(Vec::len).sum();
        for piece in pieces {
            let (xs, ys): (Vec<f64>, Vec<f64>) = piece.into_iter().unzip();
            let share = (decimate::MAX_POINTS * xs.len()).div_ceil(total);
            let indices = decimate::keep(&[&xs, &ys], share);
            let path: Vec<_> = indices.into_iter().map(|i| (xs[i], ys[i])).collect();
            if series.style == Style::Dashed {
                self.dashes(chart, path, color, 3.5)?;
            } else {
                self.stroke(chart, &path, color, 3.0)?;
            }
        }
        Ok(())
    }

    fn points(&self, series: &Series) -> impl Iterator<Item = clip::Point> {
        series.x.iter().zip(&series.y).map(|(&x, &y)| self.point(x, y))
    }

    /// Draws a solid line along a path.
    pub(super) fn stroke(&self, chart: &Chart<DB>, path: &[(f64, f64)], color: RGBColor, width: f64) -> Result<(), Failure<DB>> {
        let style = self.sheet.pen.line(color, width);
        if self.sheet.pen.whole_paths {
            return chart.plotting_area().draw(&PathElement::new(path.to_vec(), style));
        }
        // Segments are drawn one by one, with round joints, to avoid holes.
        let joint = style.stroke_width / 2;
        for ends in path.windows(2) {
            chart.plotting_area().draw(&PathElement::new(ends.to_vec(), style))?;
            chart.plotting_area().draw(&Circle::new(ends[1], joint, color.filled()))?;
        }
        Ok(())
    }

    /// Draws a dashed line.
    pub(super) fn dashes(
        &self,
        chart: &mut Chart<DB>,
        path: Vec<(f64, f64)>,
        color: RGBColor,
        width: f64,
    ) -> Result<(), Failure<DB>> {
        let (dash, gap) = (self.sheet.pen.px(12.0), self.sheet.pen.px(8.0));
        let style = self.sheet.pen.line(color, width);
        chart.draw_series(DashedLineSeries::new(path, dash, gap, style)).map(|_| ())
    }

    /// Fills the area between two edges; a gap in one of them is a gap in the band.
    fn band(&self, chart: &mut Chart<DB>, x: &[f64], lower: &[f64], upper: &[f64], color: RGBColor) -> Result<(), Failure<DB>> {
        // Clipped at the sides only, both edges keep the same x.
        let strip = Window { x: (self.x.low, self.x.high), y: (f64::NEG_INFINITY, f64::INFINITY) };
        let edges = |i: usize| self.point(x[i], lower[i]).zip(self.point(x[i], upper[i]));
        let below = clip::polyline((0..x.len()).map(|i| Some(edges(i)?.0)), strip);
        let above = clip::polyline((0..x.len()).map(|i| Some(edges(i)?.1)), strip);
        for (below, above) in below.into_iter().zip(above) {
            let (xs, lows): (Vec<f64>, Vec<f64>) = below.into_iter().unzip();
            let highs: Vec<f64> = above.into_iter().map(|(_, high)| high).collect();
            let indices = decimate::keep(&[&xs, &lows, &highs], decimate::MAX_POINTS);
            let corner = |i: usize, edge: &[f64]| (xs[i], edge[i].clamp(self.y.low, self.y.high));
            let there = indices.iter().map(|&i| corner(i, &lows));
            let back = indices.iter().rev().map(|&i| corner(i, &highs));
            chart.plotting_area().draw(&Polygon::new(there.chain(back).collect::<Vec<_>>(), tint(color)))?;
        }
        Ok(())
    }
}
