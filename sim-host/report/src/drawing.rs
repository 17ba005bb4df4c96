//! Options for drawing figures: formats and printed size.

use std::fmt;
use std::str::FromStr;

/// Options for the figures of a report. By default SVG and PNG of 1600 by 900 points, for screens.
#[derive(Debug, Clone)]
pub struct Drawing {
    /// Printed size; without it a size for screens.
    pub size: Option<PrintSize>,
    /// Formats of the files, each once.
    pub formats: Vec<PictureFormat>,
    /// Converter from SVG to PDF, if available. It adds megabytes; a program that never names it is
    /// linked without it.
    pub pdf: Option<ToPdf>,
}

/// Converts an SVG document to PDF, or returns the reason for the failure.
pub type ToPdf = fn(&str) -> Result<Vec<u8>, String>;

impl Default for Drawing {
    fn default() -> Self {
        Drawing { size: None, formats: vec![PictureFormat::Svg, PictureFormat::Png], pdf: None }
    }
}

/// A format of picture files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PictureFormat {
    /// Lines and text, for browsers and editors.
    Svg,
    /// Pixels.
    Png,
    /// Lines and text with their font, for LaTeX.
    Pdf,
}

impl PictureFormat {
    /// All formats.
    pub const ALL: [PictureFormat; 3] = [PictureFormat::Svg, PictureFormat::Png, PictureFormat::Pdf];

    /// Returns the file extension.
    pub fn ending(self) -> &'static str {
        match self {
            PictureFormat::Svg => "svg",
            PictureFormat::Png => "png",
            PictureFormat::Pdf => "pdf",
        }
    }
}

impl FromStr for PictureFormat {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = Self::ALL.into_iter().find(|format| format.ending() == text.trim());
        known.ok_or_else(|| "must be svg, png or pdf, or several of them separated by commas".to_owned())
    }
}

/// Printed size of a figure, mm. Letters are as large as in a paper, 7 to 8 points, at any size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PrintSize {
    /// Width, mm: 88 for one column, 180 for a page with two columns.
    pub width_mm: f64,
    /// Height, mm; by default it follows from the width and the figure.
    pub height_mm: Option<f64>,
}

/// Smallest side, mm; below it letters and axes leave no room for the curves.
const MIN_SIDE_MM: f64 = 40.0;
/// Largest side, mm: the longer side of A3.
const MAX_SIDE_MM: f64 = 420.0;

impl FromStr for PrintSize {
    type Err = String;

    /// Parses `88mm`, `180mm`, `120x80mm`, `12cmx8cm`, `3.5in`. A number without a unit has the
    /// unit of the number after it, otherwise millimetres.
    fn from_str(text: &str) -> Result<Self, String> {
        let form = || {
            "must be a width in print, such as 88mm (one column) or 180mm (two), or width x height, such as 120x80mm".to_owned()
        };
        let mut parts = text.split(['x', 'X', '×']);
        let lengths: Vec<(f64, Option<f64>)> =
            parts.by_ref().map(|part| length(part.trim())).collect::<Option<_>>().ok_or_else(form)?;
        let (width, height) = match lengths[..] {
            [width] => (width, None),
            [width, height] => (width, Some(height)),
            _ => return Err(form()),
        };
        let unit = height.and_then(|(_, unit)| unit).or(width.1).unwrap_or(1.0);
        let of = |(value, own): (f64, Option<f64>)| value * own.unwrap_or(unit);
        let size = PrintSize { width_mm: of(width), height_mm: height.map(of) };
        let sides = [Some(size.width_mm), size.height_mm];
        match sides.into_iter().flatten().find(|side| !(MIN_SIDE_MM..=MAX_SIDE_MM).contains(side)) {
            Some(side) => Err(format!("{side} mm is outside {MIN_SIDE_MM} to {MAX_SIDE_MM} mm: printed size, not pixels")),
            None => Ok(size),
        }
    }
}

impl fmt::Display for PrintSize {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self.height_mm {
            Some(height_mm) => write!(f, "{}x{height_mm}mm", self.width_mm),
            None => write!(f, "{}mm", self.width_mm),
        }
    }
}

/// Parses a length; the unit is in mm, if there is one.
fn length(text: &str) -> Option<(f64, Option<f64>)> {
    let units = [("mm", 1.0), ("cm", 10.0), ("in", 25.4)];
    let found = units.iter().find_map(|&(unit, mm)| Some((text.strip_suffix(unit)?, Some(mm))));
    let (digits, unit) = found.unwrap_or((text, None));
    let value: f64 = digits.trim().parse().ok()?;
    value.is_finite().then_some((value, unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_with_their_units() {
        let read = |text: &str| text.parse::<PrintSize>().map(|size| (size.width_mm, size.height_mm));
        assert_eq!(read("88mm"), Ok((88.0, None)));
        assert_eq!(read("180"), Ok((180.0, None)));
        assert_eq!(read("120x80mm"), Ok((120.0, Some(80.0))));
        assert_eq!(read("12cm x 8cm"), Ok((120.0, Some(80.0))));
        assert_eq!(read("3.5in").map(|size| size.0.round()), Ok(89.0));
        assert_eq!(read("12cmx80mm"), Ok((120.0, Some(80.0))));
    }

    #[test]
    fn invalid_sizes_are_refused() {
        for text in ["", "mm", "wide", "88mmx", "1x2x3", "88px", "nan", "-88mm"] {
            assert!(text.parse::<PrintSize>().is_err(), "{text}");
        }
        let error = "1600x900".parse::<PrintSize>().unwrap_err();
        assert_eq!(error, "1600 mm is outside 40 to 420 mm: printed size, not pixels");
    }

    #[test]
    fn formats_are_known_by_their_endings() {
        assert_eq!(PictureFormat::ALL.map(|format| format.ending().parse()), PictureFormat::ALL.map(Ok));
        assert!("eps".parse::<PictureFormat>().is_err());
    }
}
