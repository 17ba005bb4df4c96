//! Conversion of a picture to PDF: lines remain lines, and text remains text, in the embedded font.

use std::sync::{Arc, LazyLock};

use svg2pdf::usvg::fontdb::Database;
use svg2pdf::usvg::{Options, Tree};
use svg2pdf::{ConversionOptions, PageOptions};

use super::style::{FONT, FONT_NAME};

/// The embedded font alone, for the same picture on every machine.
static FONTS: LazyLock<Arc<Database>> = LazyLock::new(|| {
    let mut fonts = Database::new();
    fonts.load_font_data(FONT.to_vec());
    Arc::new(fonts)
});

/// Pixels of the SVG in an inch.
const DOTS_PER_INCH: f32 = 96.0;

/// Converts an SVG document drawn by [`super::svg`] to PDF, with this crate's font embedded.
///
/// # Errors
/// If it is not an SVG document, or cannot be converted.
pub fn pdf(svg: &str) -> Result<Vec<u8>, String> {
    let options = Options { fontdb: FONTS.clone(), font_family: FONT_NAME.to_owned(), dpi: DOTS_PER_INCH, ..Options::default() };
    let tree = Tree::from_str(svg, &options).map_err(|error| error.to_string())?;
    let page = PageOptions { dpi: DOTS_PER_INCH };
    let how = ConversionOptions { embed_text: true, ..ConversionOptions::default() };
    svg2pdf::to_pdf(&tree, how, page).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pictures::draw::{Canvas, svg};
    use crate::{Axis, Figure, HeatMap, Series};

    fn count(bytes: &[u8], text: &str) -> usize {
        bytes.windows(text.len()).filter(|window| *window == text.as_bytes()).count()
    }

    #[test]
    fn a_page_has_the_requested_size_and_its_font() {
        let series = vec![Series { x: vec![0.0, 1.0], y: vec![0.0, 1.0], ..Series::default() }];
        let figure = Figure { x: Axis { label: "time [s]".into(), ..Axis::default() }, series, ..Figure::default() };
        let canvas = Canvas::file("88x60mm".parse().ok());
        let bytes = pdf(&svg(&figure, canvas).unwrap()).unwrap();
        assert!(bytes.starts_with(b"%PDF-"));
        assert_eq!((count(&bytes, "DejaVuSans") > 0, count(&bytes, "/ToUnicode") > 0), (true, true));
        // 88 mm are 249.4 points of 1/72 inch.
        assert!(count(&bytes, "/MediaBox [0 0 249.") == 1, "{}", String::from_utf8_lossy(&bytes[..400]));
    }

    #[test]
    fn a_map_is_a_bitmap_in_it() {
        let map =
            HeatMap { x: (0.0, 1.0), y: (0.0, 1.0), columns: vec![vec![0.0, 1.0]; 3], range: (0.0, 1.0), ..HeatMap::default() };
        let bytes = pdf(&svg(&Figure { map: Some(map), ..Figure::default() }, Canvas::default()).unwrap()).unwrap();
        assert!(count(&bytes, "/Image") > 0);
    }
}
