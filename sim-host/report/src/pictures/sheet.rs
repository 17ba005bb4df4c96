//! The canvas of a figure's parts: a surface with functions for text.

use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind};
use plotters::element::{Circle, Polygon, Rectangle};
use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, RGBColor};

use super::style::{INK, Pen};

/// A failure of the surface.
pub(super) type Failure<DB> = DrawingAreaErrorKind<<DB as DrawingBackend>::ErrorType>;

/// Style of a text.
#[derive(Clone, Copy)]
pub(super) struct Lettering {
    /// Size of the text, in points.
    pub size: f64,
    /// Colour of the letters.
    pub color: RGBColor,
    /// Horizontal alignment of the text at its position.
    pub hold: HPos,
}

/// Outlines of the dots that distinguish series in print without colour; the first is a circle.
const DOTS: [&[(f64, f64)]; 4] = [
    &[],
    &[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)],
    &[(0.0, -1.25), (1.15, 0.8), (-1.15, 0.8)],
    &[(0.0, -1.3), (1.3, 0.0), (0.0, 1.3), (-1.3, 0.0)],
];

/// The whole canvas and the pen for it.
pub(super) struct Sheet<'r, DB: DrawingBackend> {
    /// The surface, in its own pixels.
    pub root: &'r DrawingArea<DB, Shift>,
    /// Sizes on this surface.
    pub pen: Pen,
}

impl<DB: DrawingBackend> Sheet<'_, DB> {
    /// Returns the width of a text in points.
    pub fn text_width(&self, text: &str, size: f64) -> f64 {
        f64::from(self.text_pixels(text, size)) / f64::from(self.pen.zoom)
    }

    /// Returns the width of a text in pixels.
    pub fn text_pixels(&self, text: &str, size: f64) -> i32 {
        let style = self.pen.text(size, INK);
        self.root.estimate_text_size(text, &style).map_or(0, |(width, _)| width as i32)
    }

    /// Writes a text with its middle height at `place`, in pixels.
    pub fn write(&self, text: &str, look: Lettering, place: (i32, i32)) -> Result<(), Failure<DB>> {
        if text.is_empty() {
            return Ok(());
        }
        let style = self.pen.text(look.size, look.color).pos(Pos::new(look.hold, VPos::Center));
        self.root.draw_text(text, &style, (place.0, place.1 + self.pen.text_drop(look.size)))
    }

    /// Writes a text on a plate that keeps it readable over grid and curves.
    pub fn note(&self, text: &str, look: Lettering, plate: RGBColor, place: (i32, i32)) -> Result<(), Failure<DB>> {
        if text.is_empty() {
            return Ok(());
        }
        let width = self.text_pixels(text, look.size);
        let left = match look.hold {
            HPos::Left => place.0,
            HPos::Center => place.0 - width / 2,
            HPos::Right => place.0 - width,
        };
        let (room, half) = (self.pen.px(4.0), self.pen.px(0.55 * look.size));
        let corners = [(left - room, place.1 - half), (left + width + room, place.1 + half)];
        self.root.draw(&Rectangle::new(corners, plate.mix(0.8).filled()))?;
        self.write(text, look, place)
    }

    /// Draws a dot at `place`, in pixels; `kind` chooses its shape.
    pub fn dot(&self, kind: usize, radius: f64, color: RGBColor, place: (i32, i32)) -> Result<(), Failure<DB>> {
        let outline = DOTS[kind % DOTS.len()];
        if outline.is_empty() {
            return self.root.draw(&Circle::new(place, self.pen.px(radius), color.filled()));
        }
        let corner = |&(x, y): &(f64, f64)| (place.0 + self.pen.px(x * radius), place.1 + self.pen.px(y * radius));
        self.root.draw(&Polygon::new(outline.iter().map(corner).collect::<Vec<_>>(), color.filled()))
    }
}
