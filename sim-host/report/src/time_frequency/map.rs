//! Result of every time-frequency analysis: power over time and frequency.

/// Power over time and frequency, both evenly spaced.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// Time of the first column's middle, s from the first sample.
    pub first_s: f64,
    /// Time from column to column, s.
    pub every_s: f64,
    /// Frequency from row to row, Hz; the first row is zero hertz.
    pub bin_hz: f64,
    /// Power by time, then by frequency.
    pub columns: Vec<Vec<f64>>,
}

impl Map {
    /// Returns the time of a column's middle, s from the first sample.
    pub fn time_s(&self, column: usize) -> f64 {
        self.first_s + column as f64 * self.every_s
    }

    /// Returns the strongest frequency of each column, Hz: the ridge.
    pub fn ridge_hz(&self) -> Vec<f64> {
        let strongest = |column: &Vec<f64>| {
            let rows = column.iter().enumerate();
            rows.fold((0, f64::NEG_INFINITY), |best, (row, &power)| if power > best.1 { (row, power) } else { best }).0
        };
        self.columns.iter().map(|column| strongest(column) as f64 * self.bin_hz).collect()
    }

    /// Returns the largest power of the map.
    pub fn peak(&self) -> f64 {
        self.columns.iter().flatten().copied().fold(0.0, f64::max)
    }
}
