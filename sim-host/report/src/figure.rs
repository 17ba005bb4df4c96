//! Contents of a report: plain data, filled in by the instruments and studies.
//!
//! The data do not depend on how they are drawn. The same [`Figure`] becomes an SVG for a paper, a
//! PNG for a README, a CSV for other tools and a panel of the HTML page, so the four always agree.

use super::crash_view::CrashView;
use super::table::TableBlock;

/// One page: headline numbers, prose, tables, figures and an appendix, in that order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Report {
    /// Heading of the page.
    pub title: String,
    /// One line under the heading.
    pub subtitle: String,
    /// Headline numbers, shown as large tiles: label, then value with its unit.
    pub summary: Vec<(String, String)>,
    /// Prose, one entry per paragraph, plain text.
    pub paragraphs: Vec<String>,
    /// Tables, shown before the figures.
    pub tables: Vec<TableBlock>,
    /// A crash that can be played, shown before the tables.
    pub crash: Option<CrashView>,
    /// Figures, each also written to its own files.
    pub figures: Vec<Figure>,
    /// Reference tables, shown after the figures.
    pub appendix: Vec<TableBlock>,
    /// Origin of the numbers: label and value (version, seed, hash of the inputs).
    pub footer: Vec<(String, String)>,
    /// `true` if the run was stopped early; the page states this at its top.
    pub interrupted: bool,
}

/// One plot: curves over two axes, or a map of values, with the marks that explain them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Figure {
    /// Stem of the figure's file names and its anchor in the page.
    pub id: String,
    /// Short heading drawn above the plot.
    pub title: String,
    /// Explanation for the reader; shown in the page, not in the image.
    pub caption: String,
    /// Horizontal axis of the figure.
    pub x: Axis,
    /// Vertical axis of the figure.
    pub y: Axis,
    /// Curves, drawn in this order, coloured by their place in the list.
    pub series: Vec<Series>,
    /// Values over the plane, instead of curves.
    pub map: Option<HeatMap>,
    /// Intervals of x shaded behind the curves.
    pub shaded: Vec<Span>,
    /// Single labelled points, drawn on top.
    pub markers: Vec<Marker>,
    /// Horizontal reference lines: y and label.
    pub hlines: Vec<(f64, String)>,
    /// `true` if one unit of x is drawn as long as one unit of y, as for a locus in a plane.
    ///
    /// Has no effect on logarithmic axes.
    pub equal_aspect: bool,
    /// `true` if the page shows a zoomable plot instead of the static picture.
    ///
    /// Needs x in ascending order; a locus is always static.
    pub interactive: bool,
    /// Further plots below over the same horizontal axis, each with its own vertical axis; empty
    /// for a map.
    pub panels: Vec<Panel>,
    /// `true` if lines are evenly sampled signals without content near half the sample rate. They
    /// are then drawn through interpolated values instead of as polygons. The CSV has the samples.
    pub band_limited: bool,
    /// Quantity along each curve of a locus that is on neither axis, such as the frequency: a
    /// column of the CSV.
    pub along: Option<Along>,
}

/// A plot below another, over the same horizontal axis.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Panel {
    /// Vertical axis of the panel.
    pub y: Axis,
    /// Curves of the panel.
    pub series: Vec<Series>,
    /// `true` if its curves show the same items as those of the uppermost plot, in the same order:
    /// same colours, named once. Otherwise the colours continue from the plots above.
    pub repeats: bool,
    /// Horizontal reference lines: y and label.
    pub hlines: Vec<(f64, String)>,
}

/// A quantity along the curves of a locus.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Along {
    /// Name of the column in the CSV, with the unit, such as `frequency_hz`.
    pub csv_column: String,
    /// Values for each series, one for each of its points.
    pub values: Vec<Vec<f64>>,
}

/// Values over a plane as colours, in cells of equal size; the figure's axes end at the edges of
/// the map.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct HeatMap {
    /// Outer edges of the first and the last column.
    pub x: (f64, f64),
    /// Outer edges of the lowest and the highest row.
    pub y: (f64, f64),
    /// Values by column, from the lowest row to the highest; a cell whose value is not finite is
    /// hatched.
    pub columns: Vec<Vec<f64>>,
    /// Values of the darkest and the lightest colour; values beyond have the colour of that end.
    pub range: (f64, f64),
    /// Levels with a contour line and its label.
    pub contours: Vec<f64>,
    /// Quantity and unit of the values, such as `power [dB]`.
    pub label: String,
    /// Name of the columns in the CSV, with the unit; the row's position on the vertical axis is
    /// appended.
    pub csv_column: String,
}

/// One axis of a [`Figure`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Axis {
    /// Quantity and unit, such as `friction [N]`.
    pub label: String,
    /// `true` for a logarithmic scale; values that are not positive leave a gap.
    pub log: bool,
    /// Interval shown; by default that of the data.
    pub range: Option<(f64, f64)>,
    /// Names of the positions 0, 1, 2, …, which then are the only ticks; for linear axes.
    pub names: Vec<String>,
    /// `true` if values are drawn by their magnitude, as for errors on a logarithmic axis; the CSV
    /// keeps their signs.
    pub magnitude: bool,
}

impl Axis {
    /// Creates a linear axis of a quantity in a unit, `1` for a ratio.
    pub fn of(quantity: &str, unit: &str) -> Self {
        let label = if unit == "1" { quantity.to_owned() } else { format!("{quantity} [{}]", unit.replace("um", "µm")) };
        Axis { label, ..Axis::default() }
    }
}

/// One curve of a [`Figure`]. A value that is not finite leaves a gap.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// Name of the column in the CSV, with the unit, such as `friction_true_n`.
    pub csv_column: String,
    /// Abscissae of the points.
    pub x: Vec<f64>,
    /// Ordinates, one for each x.
    pub y: Vec<f64>,
    /// Style of the curve.
    pub style: Style,
}

/// Style of a [`Series`].
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Style {
    /// Points joined by a solid line.
    #[default]
    Line,
    /// A dashed line, for models and references.
    Dashed,
    /// Separate dots, for measurements.
    Points,
    /// A solid line on a tinted band, for a mean with its extremes.
    Band {
        /// Lower edge, one value for each x.
        lower: Vec<f64>,
        /// Upper edge, one value for each x.
        upper: Vec<f64>,
    },
}

/// A shaded interval of x.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Span {
    /// Beginning of the interval.
    pub from: f64,
    /// End of the interval.
    pub to: f64,
    /// State within the interval, such as `ON`.
    pub label: String,
}

/// A point with a label.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Marker {
    /// Abscissa of the point.
    pub x: f64,
    /// Ordinate of the point.
    pub y: f64,
    /// Text next to the point.
    pub label: String,
}
