//! The chart itself: its frame, grid and axes, and the drawing order.

use plotters::chart::{ChartBuilder, ChartContext};
use plotters::coord::cartesian::Cartesian2d;
use plotters::prelude::DrawingBackend;

use super::axis::Scale;
use super::clip;
use super::sheet::{Failure, Sheet};
use super::style::{FINE_GRID, FRAME, GRID, INK, MUTED};
use crate::figure::{Figure, Style};

/// Size of the tick labels and notes in points.
pub(super) const TICK_SIZE: f64 = 23.0;
/// Size of the axis descriptions in points.
const AXIS_SIZE: f64 = 25.0;

/// Smallest scaling of an axis description.
const MIN_LABEL_SCALE: f64 = 0.7;

/// Free space at the edges of the canvas in points.
const EDGE: f64 = 16.0;
/// Room below a plot for the labels and the description of its axis, without that edge.
pub(super) const ROOM_BELOW: f64 = 92.0 - EDGE;
/// Room between two plots over one axis.
pub(super) const PANEL_GAP: f64 = 30.0;

/// Edges of the plot on the canvas, in points.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    /// Left edge of the plot.
    pub left: f64,
    /// Right edge of the plot.
    pub right: f64,
    /// Top edge of the plot.
    pub top: f64,
    /// Bottom edge of the plot.
    pub bottom: f64,
    /// Width and height of the canvas.
    pub canvas: (f64, f64),
    /// `true` if another plot follows below, with the labels of the horizontal axis.
    pub open: bool,
}

/// A plot with its two scales.
pub(super) type Chart<'a, DB> = ChartContext<'a, DB, Cartesian2d<Scale, Scale>>;

/// A figure while it is drawn on a surface.
pub(super) struct Plot<'f, 's, DB: DrawingBackend> {
    /// Figure that is drawn.
    pub figure: &'f Figure,
    /// Surface on which it is drawn.
    pub sheet: &'s Sheet<'s, DB>,
    /// Scale of the horizontal axis.
    pub x: Scale,
    /// Scale of the vertical axis.
    pub y: Scale,
    /// Curves of the plots above.
    pub before: Before,
}

/// Number of curves in the plots above.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Before {
    /// Number of all curves.
    pub curves: usize,
    /// Number of curves of dots.
    pub dots: usize,
}

impl<DB: DrawingBackend> Plot<'_, '_, DB> {
    /// Draws the chart into its place on the canvas. The labels in `elsewhere` are in the legend
    /// instead.
    pub fn draw(&self, layout: &Layout, elsewhere: &[&str]) -> Result<(), Failure<DB>> {
        let pen = self.sheet.pen;
        let (width, height) = (layout.right - layout.left, layout.bottom - layout.top);
        // A description longer than its axis is scaled down.
        let fits = |label: &str, length: f64| length / self.sheet.text_width(label, AXIS_SIZE).max(1.0);
        let smaller = fits(&self.figure.x.label, width + 60.0).min(fits(&self.figure.y.label, height + 20.0)).min(1.0);
        let axis_size = AXIS_SIZE * smaller.max(MIN_LABEL_SCALE);
        // The canvas ends below the plot and its labels.
        let below = if layout.open { PANEL_GAP } else { ROOM_BELOW };
        let label = |position: &f64| if layout.open { String::new() } else { self.x.label(*position) };
        let mut chart = ChartBuilder::on(self.sheet.root)
            .margin_top(pen.px(layout.top))
            .margin_right(pen.px(layout.canvas.0 - layout.right))
            .margin_bottom(pen.px(layout.canvas.1 - layout.bottom - below))
            .margin_left(pen.px(EDGE))
            .x_label_area_size(pen.px(below))
            .y_label_area_size(pen.px(layout.left - EDGE))
            .build_cartesian_2d(self.x.clone(), self.y.clone())?;
        self.shades(&chart)?;
        chart
            .configure_mesh()
            .x_label_formatter(&label)
            .x_desc(self.figure.x.label.as_str())
            .y_desc(self.figure.y.label.as_str())
            .bold_line_style(pen.line(GRID, 1.5))
            .light_line_style(pen.line(FINE_GRID, 1.0))
            .axis_style(pen.line(FRAME, 1.5))
            .label_style(pen.text(TICK_SIZE, MUTED))
            .axis_desc_style(pen.text(axis_size, INK))
            .y_label_offset(pen.text_drop(TICK_SIZE))
            .set_all_tick_mark_size(pen.px(6.0))
            .draw()?;
        if let Some(map) = &self.figure.map {
            self.heat(&chart, map)?;
            self.contours(&chart, map)?;
            self.colour_bar(map, layout)?;
        }
        self.reference_lines(&mut chart)?;
        for (index, series) in self.figure.series.iter().enumerate() {
            match series.style {
                Style::Points => self.dots(&chart, index)?,
                Style::Line | Style::Dashed | Style::Band { .. } => self.curve(&mut chart, index)?,
            }
        }
        self.shade_labels(&chart, elsewhere)?;
        self.markers(&chart)
    }

    /// Returns the position of a point; `None` if it has none on the axes.
    pub fn point(&self, x: f64, y: f64) -> clip::Point {
        self.x.position(x).zip(self.y.position(y))
    }
}
