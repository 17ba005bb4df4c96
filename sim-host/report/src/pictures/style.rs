//! The look that all figures share: colours, type and sizes.
//!
//! Colours are those of Okabe and Ito, which readers with any common kind of colour vision can
//! distinguish. Sizes are in points of a 1600 x 900 canvas. A [`Pen`] converts them to pixels of
//! the surface, so the same sizes apply to vector and bitmap pictures.

use std::sync::LazyLock;

use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontFamily, FontStyle, IntoFont, RGBAColor, RGBColor, ShapeStyle, TextStyle, register_font};

/// Series colours, in order.
const PALETTE: [RGBColor; 7] = [
    RGBColor(0x00, 0x72, 0xB2),
    RGBColor(0xD5, 0x5E, 0x00),
    RGBColor(0x00, 0x9E, 0x73),
    RGBColor(0xCC, 0x79, 0xA7),
    RGBColor(0xE6, 0x9F, 0x00),
    RGBColor(0x56, 0xB4, 0xE9),
    RGBColor(0x22, 0x22, 0x22),
];

/// Colour of titles, marks and other dark ink.
pub(super) const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
/// Colour of tick labels and notes.
pub(super) const MUTED: RGBColor = RGBColor(0x55, 0x55, 0x55);
/// Colour of axes.
pub(super) const FRAME: RGBColor = RGBColor(0x88, 0x88, 0x88);
/// Colour of grid lines at the ticks.
pub(super) const GRID: RGBColor = RGBColor(0xE2, 0xE2, 0xE2);
/// Colour of grid lines between the ticks of a logarithmic axis.
pub(super) const FINE_GRID: RGBColor = RGBColor(0xF1, 0xF1, 0xF1);
/// Colour of shaded intervals.
pub(super) const SHADE: RGBColor = RGBColor(0xFD, 0xF0, 0xD0);

/// Opacity of the tint of a band.
pub(super) const BAND_OPACITY: f64 = 0.25;

/// Family name of the embedded font.
///
/// The list after the first name is for readers of the SVG, which carries the name but not the
/// font.
const FAMILY: &str = "DejaVu Sans, Verdana, Helvetica, Arial, sans-serif";
/// Name of the embedded font itself.
#[cfg(feature = "pdf")]
pub(super) const FONT_NAME: &str = "DejaVu Sans";
/// The embedded font.
pub(super) static FONT: &[u8] = include_bytes!("../../assets/DejaVuSans-subset.ttf");

static FONT_IS_READY: LazyLock<bool> = LazyLock::new(|| register_font(FAMILY, FontStyle::Normal, FONT).is_ok());

/// Makes the embedded font known to the plotting library, once for all figures.
pub(super) fn prepare_font() -> Result<(), String> {
    if *FONT_IS_READY { Ok(()) } else { Err("the embedded font is damaged".into()) }
}

/// Returns the colour of the series at `index`.
pub(super) fn series_color(index: usize) -> RGBColor {
    PALETTE[index % PALETTE.len()]
}

/// Formats a colour as in CSS.
pub(super) fn css(color: RGBColor) -> String {
    format!("#{:02x}{:02x}{:02x}", color.0, color.1, color.2)
}

/// A pen that draws in points of the canvas on a surface with `zoom` pixels per point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pen {
    /// Pixels of the picture per point.
    pub zoom: u32,
    /// `true` if the surface draws thick paths of any shape correctly as a whole.
    pub whole_paths: bool,
}

impl Pen {
    /// Creates a pen for vector pictures.
    pub const fn vector(zoom: u32) -> Self {
        Self { zoom, whole_paths: true }
    }

    /// Creates a pen for bitmaps, whose rasterizer fills the outline of a thick path by the
    /// even-odd rule: a path that crosses its own outline gets holes.
    pub const fn bitmap(zoom: u32) -> Self {
        Self { zoom, whole_paths: false }
    }

    /// Converts a length to pixels.
    pub fn px(self, points: f64) -> i32 {
        (points * f64::from(self.zoom)).round() as i32
    }

    /// Returns a line of this colour and width.
    pub fn line(self, color: impl Into<RGBAColor>, points: f64) -> ShapeStyle {
        let width = self.px(points).max(1).unsigned_abs();
        ShapeStyle { color: color.into(), filled: false, stroke_width: width }
    }

    /// Returns the downward shift, in pixels, that centres text at the requested height.
    ///
    /// The bitmap rasterizer uses the line's height as the letters' height.
    pub fn text_drop(self, size: f64) -> i32 {
        if self.whole_paths { 0 } else { self.px(0.12 * size) }
    }

    /// Returns text of this size and colour, aligned at its left end and middle height.
    pub fn text(self, points: f64, color: RGBColor) -> TextStyle<'static> {
        (FontFamily::Name(FAMILY), points * f64::from(self.zoom))
            .into_font()
            .color(&color)
            .pos(Pos::new(HPos::Left, VPos::Center))
    }
}

/// Returns the tint of a band around a curve.
pub(super) fn tint(color: RGBColor) -> ShapeStyle {
    color.mix(BAND_OPACITY).filled()
}
