//! Static pictures of a figure: SVG for print, PNG for everything else.
//!
//! Both come from one painter and one geometry. The painter works on whole pixels, so it is given a
//! surface finer than the picture: the SVG is scaled down by its view box, the PNG by averaging,
//! which also smooths the edges.

use std::path::Path;

use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, IntoDrawingArea};
use plotters::element::BitMapElement;
use plotters::prelude::{BitMapBackend, DrawingBackend, SVGBackend};
use plotters::style::WHITE;
use plotters::style::text_anchor::HPos;

use super::axis::Scale;
use super::chart::{Layout, Plot, TICK_SIZE};
use super::extent::scales;
use super::heat_map;
use super::legend::Legend;
use super::marks;
use super::sheet::{Failure, Lettering, Sheet};
use super::style::{INK, Pen, prepare_font};
use crate::figure::Figure;

/// Surface pixels per point of the SVG: coordinates to a quarter of a point.
const SVG_ZOOM: u32 = 4;
/// Surface pixels per point of the PNG.
const PNG_ZOOM: u32 = 3;

const WIDE: (u32, u32) = (1600, 900);
const SQUARE: (u32, u32) = (1160, 1000);

const TITLE_SIZE: f64 = 32.0;

/// Where the head of a picture begins and how much of it the title takes, in points.
const HEAD: f64 = 18.0;
const TITLE_HEIGHT: f64 = 48.0;

/// The figure as an SVG document. A page that has a heading of its own needs no title.
pub(super) fn svg(figure: &Figure, titled: bool) -> Result<String, String> {
    prepare_font()?;
    let (width, height) = size(figure);
    let fine = (width * SVG_ZOOM, height * SVG_ZOOM);
    let mut document = String::new();
    let plot = {
        let root = SVGBackend::with_string(&mut document, fine).into_drawing_area();
        paint(&root, figure, Pen::vector(SVG_ZOOM), titled).map_err(|e| e.to_string())?
    };
    if let Some(map) = &figure.map {
        document = heat_map::stretched(document, map, plot);
    }
    let fine = format!("width=\"{}\" height=\"{}\"", fine.0, fine.1);
    Ok(document.replacen(&fine, &format!("width=\"{width}\" height=\"{height}\""), 1))
}

/// Writes the figure as a PNG file.
pub(super) fn png(figure: &Figure, path: &Path) -> Result<(), String> {
    prepare_font()?;
    let (width, height) = size(figure);
    let fine = (width * PNG_ZOOM, height * PNG_ZOOM);
    let mut pixels = vec![0; 3 * fine.0 as usize * fine.1 as usize];
    {
        let root = BitMapBackend::with_buffer(&mut pixels, fine).into_drawing_area();
        paint(&root, figure, Pen::bitmap(PNG_ZOOM), true).map_err(|e| e.to_string())?;
    }
    let pixels = average::<{ PNG_ZOOM as usize }>(&pixels, fine.0 as usize);
    let root = BitMapBackend::new(path, (width, height)).into_drawing_area();
    let picture = BitMapElement::with_owned_buffer((0, 0), (width, height), pixels).ok_or("the picture has the wrong size")?;
    root.draw(&picture).and_then(|()| root.present()).map_err(|e| e.to_string())
}

fn size(figure: &Figure) -> (u32, u32) {
    if figure.is_plane() { SQUARE } else { WIDE }
}

/// Replaces blocks of `ZOOM` x `ZOOM` RGB pixels by their mean.
fn average<const ZOOM: usize>(fine: &[u8], fine_width: usize) -> Vec<u8> {
    let width = fine_width / ZOOM;
    let count = (ZOOM * ZOOM) as u32;
    let mut coarse = Vec::with_capacity(fine.len() / (ZOOM * ZOOM));
    for rows in fine.chunks_exact(3 * fine_width * ZOOM) {
        let mut sums = vec![0_u32; 3 * width];
        for row in rows.chunks_exact(3 * fine_width) {
            for (sums, pixels) in sums.chunks_exact_mut(3).zip(row.chunks_exact(3 * ZOOM)) {
                for pixel in pixels.chunks_exact(3) {
                    sums.iter_mut().zip(pixel).for_each(|(sum, &value)| *sum += u32::from(value));
                }
            }
        }
        coarse.extend(sums.into_iter().map(|sum| ((sum + count / 2) / count) as u8));
    }
    coarse
}

/// Paints title, legend and chart from top to bottom. Says how many pixels wide and high the plot is.
fn paint<DB: DrawingBackend>(
    root: &DrawingArea<DB, Shift>,
    figure: &Figure,
    pen: Pen,
    titled: bool,
) -> Result<(i32, i32), Failure<DB>> {
    root.fill(&WHITE)?;
    let (width, height) = size(figure);
    let sheet = Sheet { root, pen };
    let (x, y) = scales(figure);
    let labels = y.ticks().into_iter().map(|tick| sheet.text_width(&y.label(tick), TICK_SIZE));
    let left = 76.0 + labels.fold(0.0, f64::max);
    let right = f64::from(width) - if figure.map.is_some() { heat_map::BAR_ROOM } else { 40.0 };

    let mut top = HEAD;
    if titled && !figure.title.is_empty() {
        let fit = (right - left) / sheet.text_width(&figure.title, TITLE_SIZE).max(1.0);
        let title = Lettering { size: TITLE_SIZE * fit.min(1.0), color: INK, hold: HPos::Left };
        sheet.write(&figure.title, title, (pen.px(left), pen.px(top + 0.4 * TITLE_HEIGHT)))?;
        top += TITLE_HEIGHT;
    }
    let elsewhere = marks::spans_without_room(figure, &x, right - left, &sheet);
    let legend = Legend::lay_out(figure, &elsewhere, right - left, &sheet);
    legend.draw(&sheet, (left, top))?;

    let layout = Layout {
        left,
        right,
        // The bar of a map has its title above it.
        top: top + if figure.map.is_some() { 40.0 } else { 12.0 } + legend.height(),
        bottom: f64::from(height) - 92.0,
        canvas: (f64::from(width), f64::from(height)),
    };
    let (x, y) = if figure.is_plane() { equalize(x, y, &layout) } else { (x, y) };
    let plot = Plot { figure, sheet: &sheet, x, y }.draw(&layout, &elsewhere)?;
    root.present()?;
    Ok(plot)
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
    use crate::figure::{Axis, HeatMap, Series, Span};

    fn figure() -> Figure {
        let x: Vec<f64> = (0..500).map(|i| f64::from(i) * 0.01).collect();
        let y = x.iter().map(|x| if *x > 4.0 { f64::NAN } else { x.sin() }).collect();
        Figure {
            id: "wave".into(),
            title: "a < b & \"c\"".into(),
            series: vec![Series { x, y, ..Series::default() }],
            shaded: vec![Span { from: 1.0, to: 2.0, label: "ON".into() }],
            ..Figure::default()
        }
    }

    #[test]
    fn svg_is_one_escaped_document_with_a_curve() {
        let document = svg(&figure(), true).unwrap();
        assert!(document.starts_with("<svg width=\"1600\" height=\"900\" viewBox=\"0 0 6400 3600\""));
        assert!(document.trim_end().ends_with("</svg>"));
        assert!(document.contains("a &lt; b &amp; &quot;c&quot;"));
        assert!(document.contains("<polyline"));
        assert!(!document.contains("NaN"));
    }

    #[test]
    fn png_has_its_header_size_and_some_ink() {
        let path = std::env::temp_dir().join(format!("figure-{}.png", std::process::id()));
        png(&figure(), &path).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
        assert_eq!(&bytes[16..24], [0, 0, 0x06, 0x40, 0, 0, 0x03, 0x84]);
        // A blank sheet of this size compresses to less than this.
        assert!(bytes.len() > 20_000, "only {} bytes", bytes.len());
    }

    #[test]
    fn a_map_is_one_stretched_bitmap() {
        let columns = (0..40).map(|x| (0..20).map(|y| f64::from(x * y)).collect()).collect();
        let map =
            HeatMap { x: (0.0, 4.0), y: (0.0, 1.0), columns, range: (0.0, 600.0), label: "value".into(), ..HeatMap::default() };
        let figure = Figure { map: Some(map), ..Figure::default() };
        let document = svg(&figure, true).unwrap();
        let image = document.split("<image ").nth(1).unwrap().split("/>").next().unwrap();
        assert!(
            image.contains("preserveAspectRatio=\"none\"") && image.contains("href=\"data:image/png;base64,iVBOR"),
            "{image}"
        );
        assert!(!image.contains("width=\"40\"") && document.len() < 60_000, "{}", document.len());
    }

    #[test]
    fn equal_units_are_for_linear_axes() {
        let log = Axis { log: true, ..Axis::default() };
        let series = vec![Series { x: vec![1.0, 1e3], y: vec![0.0, 1e15], ..Series::default() }];
        let figure = Figure { x: log, series, equal_aspect: true, ..Figure::default() };
        assert_eq!(size(&figure), WIDE);
        assert!(svg(&figure, true).is_ok());
    }

    #[test]
    fn an_empty_figure_is_still_a_picture() {
        assert!(svg(&Figure { equal_aspect: true, ..Figure::default() }, true).is_ok());
    }

    #[test]
    fn averaging_keeps_flat_ground() {
        assert_eq!(average::<2>(&[200; 3 * 4 * 2], 4), [200; 3 * 2]);
    }
}
