//! Static pictures of a figure: SVG for print, PNG for everything else.
//!
//! Both use the same painter and geometry. The painter works on whole pixels, so its surface is
//! finer than the picture. The SVG is scaled down by its view box, the PNG by averaging, which also
//! smooths the edges.

use std::io::Cursor;

use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, IntoDrawingArea};
use plotters::prelude::{BitMapBackend, DrawingBackend, SVGBackend};
use plotters::style::WHITE;
use plotters::style::text_anchor::HPos;

use super::axis::Scale;
use super::chart::{Before, Layout, PANEL_GAP, Plot, ROOM_BELOW, TICK_SIZE};
use super::extent::scales;
use super::heat_map;
use super::legend::Legend;
use super::marks;
use super::page::is_forbidden;
use super::prepare::{panel, prepared};
use super::sheet::{Failure, Lettering, Sheet};
use super::style::{INK, Pen, prepare_font};
use crate::drawing::PrintSize;
use crate::figure::{Axis, Figure, Style};

/// Surface pixels per point of the SVG: coordinates are accurate to a quarter of a point.
const SVG_ZOOM: u32 = 4;
/// Surface pixels per pixel of the PNG for screens, which has one pixel per point.
const PNG_ZOOM: u32 = 3;
/// Pixels per point of the PNG for print: 452 dots an inch.
const PRINT_PIXELS: u32 = 2;
/// Surface pixels per pixel of the PNG for print.
const PRINT_ZOOM: u32 = 2;
/// Points of the canvas in a millimetre of print; tick labels have letters of 7.3 typographic
/// points.
const POINTS_PER_MM: f64 = 1600.0 / 180.0;

/// Width and height of a figure for screens, points.
const WIDE: (u32, u32) = (1600, 900);
/// Width and height of a figure with equal units on both axes, points.
const SQUARE: (u32, u32) = (1160, 1000);
/// Height of a further plot over the same axis, points.
const PANEL: u32 = 380;
/// Height over width of a figure in print.
const PRINT_SHAPE: f64 = 0.6;
/// Smallest height in print that has room for labels and curves, mm.
const PRINT_MIN_MM: f64 = 58.0;
/// Largest height of a further plot in print, mm.
const PRINT_PANEL_MAX_MM: f64 = 30.0;

/// Size of the title in points.
const TITLE_SIZE: f64 = 32.0;

/// Top of the head of a picture, in points.
const HEAD: f64 = 18.0;
/// Height of the title in points.
const TITLE_HEIGHT: f64 = 48.0;
/// Vertical room for the label of a tick, in points.
const TICK_HEIGHT: f64 = 52.0;
/// Smallest horizontal gap between the labels of two ticks, in points.
const TICK_GAP: f64 = 34.0;

/// The canvas for a figure.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Canvas {
    /// Printed size, if it is for print.
    pub print: Option<PrintSize>,
    /// `true` if the heading is outside the picture: next to it in a page, or below it in a paper.
    pub untitled: bool,
}

impl Canvas {
    /// Creates a canvas for a separate file.
    pub fn file(print: Option<PrintSize>) -> Self {
        Canvas { print, untitled: print.is_some() }
    }

    /// Returns width and height for this figure, in points.
    fn size(self, figure: &Figure) -> (u32, u32) {
        let panels = figure.panels.len() as u32;
        let Some(print) = self.print else {
            let (width, height) = if figure.is_plane() { SQUARE } else { WIDE };
            // The upper plot is lower if there are others below.
            return (width, if panels == 0 { height } else { height - 250 + panels * PANEL });
        };
        let shape = if figure.is_plane() { f64::from(SQUARE.1) / f64::from(SQUARE.0) } else { PRINT_SHAPE };
        let own = || (shape * print.width_mm).max(PRINT_MIN_MM) + f64::from(panels) * PRINT_PANEL_MAX_MM;
        let points = |mm: f64| (mm * POINTS_PER_MM).round() as u32;
        (points(print.width_mm), points(print.height_mm.unwrap_or_else(own)))
    }

    /// Formats width and height as attributes of an SVG.
    fn extent(self, (width, height): (u32, u32)) -> String {
        match self.print {
            None => format!("width=\"{width}\" height=\"{height}\""),
            Some(_) => {
                let [width, height] = [width, height].map(|points| (100.0 * f64::from(points) / POINTS_PER_MM).round() / 100.0);
                format!("width=\"{width}mm\" height=\"{height}mm\"")
            }
        }
    }
}

/// Returns the figure as an SVG document.
pub(super) fn svg(figure: &Figure, canvas: Canvas) -> Result<String, String> {
    prepare_font()?;
    let figure = &*prepared(figure);
    let size = canvas.size(figure);
    let fine = (size.0 * SVG_ZOOM, size.1 * SVG_ZOOM);
    let mut document = String::new();
    {
        let root = SVGBackend::with_string(&mut document, fine).into_drawing_area();
        paint(&root, figure, Pen::vector(SVG_ZOOM), size, canvas).map_err(|e| e.to_string())?;
    }
    if let Some(map) = &figure.map {
        document = heat_map::embedded(&document, map)?;
    }
    document = document.replace(is_forbidden, "\u{fffd}");
    let fine = format!("width=\"{}\" height=\"{}\"", fine.0, fine.1);
    Ok(document.replacen(&fine, &canvas.extent(size), 1))
}

/// Returns the figure as a PNG file.
pub(super) fn png(figure: &Figure, canvas: Canvas) -> Result<Vec<u8>, String> {
    prepare_font()?;
    let figure = &*prepared(figure);
    let size = canvas.size(figure);
    let (pixels, zoom) = canvas.print.map_or((1, PNG_ZOOM), |_| (PRINT_PIXELS, PRINT_ZOOM));
    let fine = (size.0 * pixels * zoom, size.1 * pixels * zoom);
    let mut surface = vec![0; 3 * fine.0 as usize * fine.1 as usize];
    {
        let root = BitMapBackend::with_buffer(&mut surface, fine).into_drawing_area();
        paint(&root, figure, Pen::bitmap(pixels * zoom), size, canvas).map_err(|e| e.to_string())?;
    }
    let coarse = average(&surface, fine.0 as usize, zoom as usize);
    let per_metre = canvas.print.map(|_| (1e3 * POINTS_PER_MM * f64::from(pixels)).round() as u32);
    encoded(&coarse, (size.0 * pixels, size.1 * pixels), per_metre)
}

/// Encodes RGB pixels as a PNG file, with its resolution in pixels per metre if there is one.
pub(super) fn encoded(pixels: &[u8], (width, height): (u32, u32), per_metre: Option<u32>) -> Result<Vec<u8>, String> {
    let mut file = Cursor::new(Vec::new());
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let unit = png::Unit::Meter;
    encoder.set_pixel_dims(per_metre.map(|per| png::PixelDimensions { xppu: per, yppu: per, unit }));
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(pixels));
    written.map_err(|error| error.to_string())?;
    Ok(file.into_inner())
}

/// Replaces blocks of `zoom` x `zoom` RGB pixels by their mean.
fn average(fine: &[u8], fine_width: usize, zoom: usize) -> Vec<u8> {
    let width = fine_width / zoom;
    let count = (zoom * zoom) as u32;
    let mut coarse = Vec::with_capacity(fine.len() / (zoom * zoom));
    for rows in fine.chunks_exact(3 * fine_width * zoom) {
        let mut sums = vec![0_u32; 3 * width];
        for row in rows.chunks_exact(3 * fine_width) {
            for (sums, pixels) in sums.chunks_exact_mut(3).zip(row.chunks_exact(3 * zoom)) {
                for pixel in pixels.chunks_exact(3) {
                    sums.iter_mut().zip(pixel).for_each(|(sum, &value)| *sum += u32::from(value));
                }
            }
        }
        coarse.extend(sums.into_iter().map(|sum| ((sum + count / 2) / count) as u8));
    }
    coarse
}

/// Paints title, legend and plots from top to bottom.
fn paint<DB: DrawingBackend>(
    root: &DrawingArea<DB, Shift>,
    figure: &Figure,
    pen: Pen,
    size: (u32, u32),
    canvas: Canvas,
) -> Result<(), Failure<DB>> {
    root.fill(&WHITE)?;
    let (width, height) = (f64::from(size.0), f64::from(size.1));
    let sheet = Sheet { root, pen };
    let panels: Vec<Figure> = (0..figure.panels.len()).map(|place| panel(figure, place)).collect();
    let (x, y) = scales(figure);
    // A rough height of each plot, before the exact layout is known: most of the canvas divided
    // equally.
    let rough = (height - 200.0) / (1 + panels.len()) as f64;
    let mut ys = vec![y];
    ys.extend(panels.iter().map(|panel| scales(panel).1));
    ys.iter_mut().for_each(|y| *y = y.clone().with_ticks(((rough / TICK_HEIGHT) as usize).clamp(2, 8)));
    let labels = ys.iter().flat_map(|y| y.ticks().into_iter().map(|tick| sheet.text_width(&y.label(tick), TICK_SIZE)));
    let left = 76.0 + labels.fold(0.0, f64::max);
    let right = width - if figure.map.is_some() { heat_map::BAR_ROOM } else { 40.0 };
    let x = with_room(x, right - left, &sheet);

    let mut top = HEAD;
    if !canvas.untitled && !figure.title.is_empty() {
        let fit = (right - left) / sheet.text_width(&figure.title, TITLE_SIZE).max(1.0);
        let title = Lettering { size: TITLE_SIZE * fit.min(1.0), color: INK, hold: HPos::Left };
        sheet.write(&figure.title, title, (pen.px(left), pen.px(top + 0.4 * TITLE_HEIGHT)))?;
        top += TITLE_HEIGHT;
    }
    let elsewhere = marks::spans_without_room(figure, &x, right - left, &sheet);
    let legend = Legend::lay_out(figure, &elsewhere, right - left, &sheet);
    legend.draw(&sheet, (left, top))?;

    // The bar of a map has its title above it.
    let top = top + if figure.map.is_some() { 40.0 } else { 12.0 } + legend.height();
    let bottom = height - ROOM_BELOW - 16.0;
    let gaps = PANEL_GAP * panels.len() as f64;
    let each = (bottom - top - gaps) / (1 + panels.len()) as f64;
    let mut before = Before::default();
    let whole = figure;
    for (place, (plot, y)) in std::iter::once(whole).chain(&panels).zip(ys).enumerate() {
        let top = top + place as f64 * (each + PANEL_GAP);
        let open = place < panels.len();
        let layout = Layout { left, right, top, bottom: top + each, canvas: (width, height), open };
        let (x, y) = if plot.is_plane() { equalize(x.clone(), y, &layout) } else { (x.clone(), y) };
        // Intervals are labelled once.
        let hidden: Vec<&str> =
            if place == 0 { elsewhere.clone() } else { plot.shaded.iter().map(|s| s.label.as_str()).collect() };
        let upper = open.then(|| Figure { x: Axis { label: String::new(), ..plot.x.clone() }, ..plot.clone() });
        let figure = upper.as_ref().unwrap_or(plot);
        let repeats = place > 0 && whole.panels[place - 1].repeats;
        let above = if repeats { Before::default() } else { before };
        Plot { figure, sheet: &sheet, x, y, before: above }.draw(&layout, &hidden)?;
        if !repeats {
            before.curves += plot.series.len();
            before.dots += plot.series.iter().filter(|series| series.style == Style::Points).count();
        }
    }
    root.present()
}

/// Returns the scale with as many labelled ticks, up to ten, as fit next to each other.
fn with_room<DB: DrawingBackend>(x: Scale, width: f64, sheet: &Sheet<DB>) -> Scale {
    let fits = |x: &Scale| {
        let ticks = x.ticks();
        let widest = ticks.iter().map(|&tick| sheet.text_width(&x.label(tick), TICK_SIZE)).fold(0.0, f64::max);
        // Names are never omitted.
        ticks.len() as f64 * (widest + TICK_GAP) <= width
    };
    (3..=10).rev().map(|most| x.clone().with_ticks(most)).find(fits).unwrap_or_else(|| x.with_ticks(2))
}

/// Widens one of the scales so that a unit of either has the same length.
fn equalize(mut x: Scale, mut y: Scale, layout: &Layout) -> (Scale, Scale) {
    let (width, height) = (layout.right - layout.left, layout.bottom - layout.top);
    let unit = (x.extent() / width).max(y.extent() / height);
    x.widen_to(unit * width);
    y.widen_to(unit * height);
    (x, y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::{HeatMap, Panel, Series, Span};

    const SCREEN: Canvas = Canvas { print: None, untitled: false };

    fn figure() -> Figure {
        let x: Vec<f64> = (0..500).map(|i| f64::from(i) * 0.01).collect();
        let y = x.iter().map(|x| if *x > 4.0 { f64::NAN } else { x.sin() }).collect();
        Figure {
            id: "wave".into(),
            title: "a < b & \"c\"\u{1b}".into(),
            series: vec![Series { x, y, ..Series::default() }],
            shaded: vec![Span { from: 1.0, to: 2.0, label: "ON".into() }],
            ..Figure::default()
        }
    }

    #[test]
    fn svg_is_one_escaped_document_with_a_curve() {
        let document = svg(&figure(), SCREEN).unwrap();
        assert!(document.starts_with("<svg width=\"1600\" height=\"900\" viewBox=\"0 0 6400 3600\""));
        assert!(document.trim_end().ends_with("</svg>"));
        assert!(document.contains("a &lt; b &amp; &quot;c&quot;\u{fffd}"));
        assert!(document.contains("<polyline"));
        assert!(!document.contains("NaN"));
    }

    #[test]
    fn png_has_its_header_size_and_some_ink() {
        let bytes = png(&figure(), SCREEN).unwrap();
        assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
        assert_eq!(&bytes[16..24], [0, 0, 0x06, 0x40, 0, 0, 0x03, 0x84]);
        // A blank sheet of this size compresses to fewer bytes.
        assert!(bytes.len() > 20_000, "only {} bytes", bytes.len());
    }

    #[test]
    fn in_print_a_figure_has_its_size_and_no_title() {
        let canvas = Canvas::file("88mm".parse().ok());
        let document = svg(&figure(), canvas).unwrap();
        assert!(
            document.starts_with("<svg width=\"87.98mm\" height=\"58.05mm\" viewBox=\"0 0 3128 2064\""),
            "{}",
            &document[..120]
        );
        assert!(!document.contains("&lt; b"));
        let bytes = png(&figure(), canvas).unwrap();
        // 782 by 516 points at two pixels each: 1564 by 1032 pixels, at 17778 pixels a metre.
        assert_eq!(&bytes[16..24], [0, 0, 0x06, 0x1c, 0, 0, 0x04, 0x08]);
        let physical = bytes.windows(4).position(|chunk| chunk == b"pHYs").unwrap();
        assert_eq!(&bytes[physical + 4..physical + 13], [0, 0, 0x45, 0x72, 0, 0, 0x45, 0x72, 1]);
    }

    #[test]
    fn panels_share_the_horizontal_axis() {
        let series = vec![Series { name: "below".into(), x: vec![0.0, 5.0], y: vec![0.0, 2000.0], ..Series::default() }];
        let panels = vec![Panel { y: Axis { label: "other [N]".into(), ..Axis::default() }, series, ..Panel::default() }];
        let two = Figure { panels, x: Axis { label: "time [s]".into(), ..Axis::default() }, ..figure() };
        let document = svg(&two, SCREEN).unwrap();
        assert_eq!((document.matches("time [s]").count(), document.matches("other [N]").count()), (1, 1));
        assert!(document.contains("#d55e00") || document.contains("#D55E00"), "the second curve has the second colour");
        assert_eq!(SCREEN.size(&two), (1600, 1030));
    }

    #[test]
    fn empty_series_are_not_in_the_legend() {
        let mut two = figure();
        two.series[0].name = "wave".into();
        let named = |name: &str, x: &[f64]| Series { name: name.into(), x: x.into(), y: x.into(), ..Series::default() };
        two.series.extend([named("gone", &[]), named("unknown", &[f64::NAN]), named("there", &[1.0])]);
        let document = svg(&two, SCREEN).unwrap();
        let has = |name: &str| document.contains(&format!(">\n{name}\n</text>")) || document.contains(&format!(">{name}</text>"));
        assert_eq!(["wave", "gone", "unknown", "there"].map(has), [true, false, false, true]);
    }

    #[test]
    fn a_map_is_one_stretched_bitmap() {
        let columns = (0..40).map(|x| (0..20).map(|y| f64::from(x * y)).collect()).collect();
        let map =
            HeatMap { x: (0.0, 4.0), y: (0.0, 1.0), columns, range: (0.0, 600.0), label: "value".into(), ..HeatMap::default() };
        let figure = Figure { map: Some(HeatMap { contours: vec![55.5, 999.0], ..map }), ..Figure::default() };
        let document = svg(&figure, SCREEN).unwrap();
        let image = document.split("<image ").nth(1).unwrap().split("/>").next().unwrap();
        assert!(
            image.contains("preserveAspectRatio=\"none\"") && image.contains("href=\"data:image/png;base64,iVBOR"),
            "{image}"
        );
        assert!(document.contains("\n55.5\n") && !document.contains("\n999\n"), "a level is labelled where it is reached");
        assert!(!image.contains("width=\"40\"") && document.len() < 60_000, "{}", document.len());
    }

    #[test]
    fn equal_units_are_for_linear_axes() {
        let log = Axis { log: true, ..Axis::default() };
        let series = vec![Series { x: vec![1.0, 1e3], y: vec![0.0, 1e15], ..Series::default() }];
        let figure = Figure { x: log, series, equal_aspect: true, ..Figure::default() };
        assert_eq!(SCREEN.size(&figure), WIDE);
        assert!(svg(&figure, SCREEN).is_ok());
    }

    #[test]
    fn an_empty_figure_is_still_a_picture() {
        assert!(svg(&Figure { equal_aspect: true, ..Figure::default() }, SCREEN).is_ok());
    }

    #[test]
    fn averaging_keeps_flat_ground() {
        assert_eq!(average(&[200; 3 * 4 * 2], 4, 2), [200; 3 * 2]);
    }
}
