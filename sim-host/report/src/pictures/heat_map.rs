//! Heat maps: values over a plane as colours, and the colour bar.
//!
//! The cells are drawn as one bitmap with a pixel each instead of rectangles, which for a map of
//! 400 by 200 cells would be 7 MB of SVG. On a vector surface a placeholder is drawn, which
//! [`embedded`] replaces by the bitmap; on a bitmap surface the pixels are repeated.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use plotters::element::{BitMapElement, PathElement, Rectangle};
use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::HPos;
use plotters::style::{Color, RGBColor, WHITE};

use super::axis::Scale;
use super::chart::{Chart, Layout, Plot, TICK_SIZE};
use super::colour_map::colour;
use super::contour;
use super::sheet::{Failure, Lettering};
use super::style::{FRAME, INK, MUTED};
use crate::figure::{Axis, HeatMap};

/// Colour of a map's placeholder in an SVG, which nothing else in a figure has.
const PLACEHOLDER_COLOUR: RGBColor = RGBColor(1, 2, 3);
/// Background and stripes of a cell without a value; no value has these greys.
const MISSING_COLOUR: RGBColor = RGBColor(240, 240, 240);
const HATCH_COLOUR: RGBColor = RGBColor(150, 150, 150);
/// Period of the stripes, pixels.
const HATCH_PIXELS: usize = 8;
/// Smallest side of an embedded bitmap with stripes, pixels.
const HATCHED_SIDE: usize = 480;
/// Room next to the plot for the bar with its numbers, in points.
pub(super) const BAR_ROOM: f64 = 150.0;
const BAR_GAP: f64 = 26.0;
const BAR_WIDTH: f64 = 26.0;
/// Number of steps of the bar, more than a screen can resolve.
const BAR_STEPS: u32 = 128;
/// Places of a label along its contour line, the best first.
const LABEL_PARTS: [f64; 5] = [0.5, 0.375, 0.625, 0.25, 0.75];

impl HeatMap {
    /// Returns the scales of the axes: exactly the map.
    pub(super) fn scales(&self, x_log: bool, y_log: bool) -> (Scale, Scale) {
        let scale = |range, log| Scale::fit(&Axis { range: Some(range), log, ..Axis::default() }, &[], [0.0, 0.0], false);
        (scale(self.x, x_log).with_ticks(10), scale(self.y, y_log).with_ticks(8))
    }

    /// Returns the position of a value in the colour range, from 0 to 1.
    fn share(&self, value: f64) -> f64 {
        (value - self.range.0) / (self.range.1 - self.range.0)
    }

    /// Returns `true` if every cell has a value.
    fn is_complete(&self) -> bool {
        self.columns.iter().flatten().all(|value| value.is_finite())
    }

    /// Returns red, green and blue of `width` by `height` pixels, from the top left. Cells without
    /// a value are hatched.
    fn pixels(&self, (width, height): (usize, usize)) -> Vec<u8> {
        let (columns, rows) = self.size();
        let pixel = |x: usize, y: usize| {
            let (column, row) = (x * columns / width, (height - 1 - y) * rows / height);
            let value = self.columns[column][row];
            let stripe = (x + y) % HATCH_PIXELS < HATCH_PIXELS / 4;
            let shade = match value.is_finite() {
                true => colour(self.share(value)),
                false if stripe => HATCH_COLOUR,
                false => MISSING_COLOUR,
            };
            [shade.0, shade.1, shade.2]
        };
        (0..height).flat_map(|y| (0..width).flat_map(move |x| pixel(x, y))).collect()
    }
}

impl<DB: DrawingBackend> Plot<'_, '_, DB> {
    /// Draws the map over the whole plot.
    pub(super) fn heat(&self, chart: &Chart<DB>, map: &HeatMap) -> Result<(), Failure<DB>> {
        let (columns, rows) = chart.plotting_area().get_pixel_range();
        if map.size().0 == 0 || map.size().1 == 0 {
            return Ok(());
        }
        if self.sheet.pen.whole_paths {
            let corners = [(columns.start, rows.start), (columns.end, rows.end)];
            return self.sheet.root.draw(&Rectangle::new(corners, PLACEHOLDER_COLOUR.filled()));
        }
        let size = ((columns.end - columns.start).max(1) as usize, (rows.end - rows.start).max(1) as usize);
        let picture =
            BitMapElement::with_owned_buffer((columns.start, rows.start), (size.0 as u32, size.1 as u32), map.pixels(size));
        picture.map_or(Ok(()), |picture| self.sheet.root.draw(&picture))
    }

    /// Draws the contour lines, each level with a label on its longest line.
    pub(super) fn contours(&self, chart: &Chart<DB>, map: &HeatMap) -> Result<(), Failure<DB>> {
        let (columns, rows) = (map.columns.len() as f64, map.size().1 as f64);
        let place = |(x, y)| {
            let shares = ((x + 0.5) / columns, (y + 0.5) / rows);
            (self.x.low + shares.0 * self.x.extent(), self.y.low + shares.1 * self.y.extent())
        };
        let (edges, height) = (chart.plotting_area().get_pixel_range().0, self.sheet.pen.px(1.2 * TICK_SIZE));
        // Each label with its place and half its width.
        let mut labels: Vec<(String, (i32, i32), i32)> = Vec::new();
        for &level in &map.contours {
            let lines = contour::lines(&map.columns, level).into_iter();
            let lines: Vec<Vec<(f64, f64)>> = lines.map(|line| line.into_iter().map(place).collect()).collect();
            // Dark on a light edge, a line is visible on every colour.
            for (ink, width) in [(WHITE, 4.5), (INK, 2.0)] {
                lines.iter().try_for_each(|line| self.stroke(chart, line, ink, width))?;
            }
            let Some(longest) = lines.iter().max_by_key(|line| line.len()) else { continue };
            let text = level.to_string().replace('-', "−");
            let half = self.sheet.text_pixels(&text, TICK_SIZE) / 2 + height / 4;
            let at = |part: f64| {
                let (x, y) = chart.backend_coord(&longest[(part * (longest.len() - 1) as f64) as usize]);
                (x.min(edges.end - half).max(edges.start + half), y)
            };
            let is_free = |&(x, y): &(i32, i32)| {
                labels.iter().all(|(_, at, other)| (at.0 - x).abs() > half + other || (at.1 - y).abs() > height)
            };
            let free = LABEL_PARTS.map(at).into_iter().find(is_free).unwrap_or_else(|| at(LABEL_PARTS[0]));
            labels.push((text, free, half));
        }
        let look = Lettering { size: TICK_SIZE, color: INK, hold: HPos::Center };
        labels.iter().try_for_each(|(text, place, _)| self.sheet.note(text, look, WHITE, *place))
    }

    /// Draws the bar of colours to the right of the plot, with its own axis.
    pub(super) fn colour_bar(&self, map: &HeatMap, layout: &Layout) -> Result<(), Failure<DB>> {
        let sheet = self.sheet;
        let (area, pen) = (sheet.root, sheet.pen);
        let (left, right) = (pen.px(layout.right + BAR_GAP), pen.px(layout.right + BAR_GAP + BAR_WIDTH));
        let height = |share: f64| pen.px(layout.bottom - share * (layout.bottom - layout.top));
        // Each step extends to the bottom and is covered by the next: adjacent steps would show the
        // background between them.
        for step in (0..BAR_STEPS).rev() {
            let part = |steps: f64| steps / f64::from(BAR_STEPS);
            let shade = colour(part(f64::from(step) + 0.5)).filled();
            area.draw(&Rectangle::new([(left, height(part(f64::from(step) + 1.0))), (right, height(0.0))], shade))?;
        }
        area.draw(&Rectangle::new([(left, height(1.0)), (right, height(0.0))], pen.line(FRAME, 1.5)))?;
        let scale = Scale::fit(&Axis { range: Some(map.range), ..Axis::default() }, &[], [0.0, 0.0], false).with_ticks(8);
        let look = Lettering { size: TICK_SIZE, color: MUTED, hold: HPos::Left };
        for tick in scale.ticks() {
            let y = height(map.share(tick));
            area.draw(&PathElement::new(vec![(right, y), (right + pen.px(6.0), y)], pen.line(FRAME, 1.5)))?;
            sheet.write(&scale.label(tick), look, (right + pen.px(12.0), y))?;
        }
        let title = Lettering { size: TICK_SIZE, color: INK, hold: HPos::Right };
        sheet.write(&map.label, title, (pen.px(layout.canvas.0 - 20.0), pen.px(layout.top - 22.0)))
    }
}

/// Replaces the placeholder in an SVG by the bitmap of the map, with a pixel a cell, or more if
/// cells are hatched.
pub(super) fn embedded(document: &str, map: &HeatMap) -> Result<String, String> {
    let fill = format!("fill=\"#{:02X}{:02X}{:02X}\"", PLACEHOLDER_COLOUR.0, PLACEHOLDER_COLOUR.1, PLACEHOLDER_COLOUR.2);
    let Some(at) = document.find(&fill) else { return Ok(document.to_owned()) };
    let begin = document[..at].rfind("<rect ").ok_or("the place of the map is not a rectangle")?;
    let end = at + document[at..].find("/>").ok_or("the place of the map has no end")?;
    let (columns, rows) = map.size();
    let larger = |cells: usize| if map.is_complete() { cells } else { cells * HATCHED_SIDE.div_ceil(cells) };
    let size = (larger(columns), larger(rows));
    let picture = STANDARD.encode(super::draw::encoded(&map.pixels(size), (size.0 as u32, size.1 as u32), None)?);
    let sizes = document[begin..at].trim_start_matches("<rect ").split(" opacity").next().unwrap_or_default();
    Ok(format!(
        "{}<image {sizes} preserveAspectRatio=\"none\" style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{picture}\"{}",
        &document[..begin],
        &document[end..]
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_without_a_value_are_hatched() {
        let map = HeatMap { columns: vec![vec![0.5], vec![f64::NAN]], range: (0.0, 1.0), ..HeatMap::default() };
        let pixels = map.pixels((32, 16));
        let of = |left: bool| pixels.chunks(3).enumerate().filter(move |(at, _)| (at % 32 < 16) == left).map(|(_, pixel)| pixel);
        let shade = colour(0.5);
        assert!(of(true).all(|pixel| pixel == [shade.0, shade.1, shade.2]));
        for grey in [MISSING_COLOUR, HATCH_COLOUR] {
            assert!(of(false).filter(|pixel| *pixel == [grey.0, grey.1, grey.2]).count() >= 64);
        }
    }
}
