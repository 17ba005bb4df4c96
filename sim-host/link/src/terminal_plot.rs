//! Plots in characters. Each character is a Braille pattern of Unicode, two dots wide and four
//! high, so that the distance of dots is about the same in both directions.

/// Width of the plot, characters.
const COLUMNS: usize = 56;
/// Height of the plot, lines.
const ROWS: usize = 18;
/// Code point of the empty Braille pattern.
const FIRST_PATTERN: u32 = 0x2800;
/// Bit of each dot of a pattern, by column and row.
const DOT_BITS: [[u32; 4]; 2] = [[0x01, 0x02, 0x04, 0x40], [0x08, 0x10, 0x20, 0x80]];

/// Plot of points in a plane. Both axes have the same scale, unless it is stretched.
#[derive(Clone, Debug, Default)]
pub struct TerminalPlot {
    labels: (String, String),
    line: Vec<(f64, f64)>,
    marks: Vec<(f64, f64)>,
    stretched: bool,
}

impl TerminalPlot {
    /// Creates an empty plot with the labels of its axes.
    pub fn new(across: &str, up: &str) -> Self {
        TerminalPlot { labels: (across.into(), up.into()), ..TerminalPlot::default() }
    }

    /// Scales each axis separately to its side.
    pub fn stretched(mut self) -> Self {
        self.stretched = true;
        self
    }

    /// Adds a line, given by closely spaced points.
    pub fn line(&mut self, points: impl IntoIterator<Item = (f64, f64)>) {
        self.line.extend(points);
    }

    /// Adds points that are drawn as an `o` each.
    pub fn marks(&mut self, points: impl IntoIterator<Item = (f64, f64)>) {
        self.marks.extend(points);
    }

    /// Returns the plot as text.
    pub fn drawn(&self) -> String {
        let all = || self.line.iter().chain(&self.marks).filter(|(x, y)| x.is_finite() && y.is_finite());
        let ends = |values: &mut dyn Iterator<Item = f64>| {
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
        };
        let (x, y) = (ends(&mut all().map(|point| point.0)), ends(&mut all().map(|point| point.1)));
        if !(x.0 <= x.1 && y.0 <= y.1) {
            return "(nothing to draw)".into();
        }
        let (wide, high) = ((2 * COLUMNS - 1) as f64, (4 * ROWS - 1) as f64);
        let (across, up) = ((x.1 - x.0) / wide, (y.1 - y.0) / high);
        let units = if self.stretched { (across, up) } else { (across.max(up), across.max(up)) };
        let units = (units.0.max(f64::MIN_POSITIVE), units.1.max(f64::MIN_POSITIVE));
        // Centres the shorter side.
        let (left, top) = (0.5 * (x.0 + x.1 - units.0 * wide), 0.5 * (y.0 + y.1 + units.1 * high));
        let dot = |&(x, y): &(f64, f64)| {
            let place = |distance: f64, most: f64| distance.round().clamp(0.0, most) as usize;
            (place((x - left) / units.0, wide), place((top - y) / units.1, high))
        };
        let mut cells = vec![[0_u32; COLUMNS]; ROWS];
        for (x, y) in self.line.iter().filter(|(x, y)| x.is_finite() && y.is_finite()).map(dot) {
            cells[y / 4][x / 2] |= DOT_BITS[x % 2][y % 4];
        }
        let mut rows: Vec<Vec<char>> = cells
            .iter()
            .map(|row| row.iter().map(|bits| char::from_u32(FIRST_PATTERN + bits).unwrap_or(' ')).collect())
            .collect();
        for (x, y) in self.marks.iter().filter(|(x, y)| x.is_finite() && y.is_finite()).map(dot) {
            rows[y / 4][x / 2] = 'o';
        }
        let (right, bottom) = (left + units.0 * wide, top - units.1 * high);
        let mut text = format!("{:>9.1} ┤ {}\n", top, self.labels.1);
        for row in rows {
            text += &format!("{:>9} │{}\n", "", row.into_iter().collect::<String>().trim_end_matches('\u{2800}'));
        }
        text += &format!("{bottom:>9.1} └{}\n", "─".repeat(COLUMNS));
        let (first, last) = (format!("{left:.1}"), format!("{right:.1} {}", self.labels.0));
        text + &format!("{:>11}{first}{last:>width$}", "", width = COLUMNS.saturating_sub(first.len()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_circle_is_as_high_as_it_is_wide() {
        let mut plot = TerminalPlot::new("x", "y");
        plot.line((0..1000).map(|n| (f64::from(n) * std::f64::consts::TAU / 1000.0).sin_cos()));
        let text = plot.drawn();
        let rows: Vec<&str> = text.lines().skip(1).take(ROWS).map(|row| row.split_once('│').unwrap().1).collect();
        let inked = |row: &str| row.chars().filter(|&c| c != '\u{2800}').count();
        assert!(rows.iter().all(|row| inked(row) > 0), "{text}");
        // 72 dots high, so 72 dots wide: 36 characters, in the middle of 56.
        let ends = |row: &str| (row.chars().position(|c| c != '\u{2800}'), row.chars().count());
        let widest = rows.iter().map(|row| ends(row).1 - ends(row).0.unwrap()).max().unwrap();
        assert!((35..=37).contains(&widest), "{widest}\n{text}");
    }

    #[test]
    fn an_empty_plot_and_a_single_point_are_drawn() {
        let mut plot = TerminalPlot::new("x", "y");
        assert_eq!(plot.drawn(), "(nothing to draw)");
        plot.marks([(1.0, 1.0), (f64::NAN, 0.0)]);
        assert_eq!(plot.drawn().matches('o').count(), 1);
    }
}
