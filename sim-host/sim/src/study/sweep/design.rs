//! Points of a sweep: every combination of several axes, a sample, or a list. A point has a number,
//! which determines its values.
//!
//! A sample is arranged for Sobol indices (Saltelli et al., Comput. Phys. Commun. 181, 2010). Each
//! pair of independent draws A and B of all keys gives a point A, one point per key with this key
//! from B and all others from A, and a point B. The draws are those of a Sobol sequence with twice
//! as many dimensions as keys and Owen's scrambling (the crate `sobol_burley`).

use serde_json::{Value, json};

use super::SweepError;
use super::axis::{Axis, Range};
use columns::{Column, TableError};
use scene::metrics;

/// Maximum number of points of a sweep.
pub const MOST_POINTS: u64 = 100_000_000;
/// Maximum number of draws of a sample: the length of the sequence.
pub const MOST_DRAWS: u64 = 1 << 16;
/// Maximum number of keys of a sample: half of the dimensions of the sequence.
const MOST_SAMPLED: usize = 128;
/// Number of the scrambled sequence of samples.
const SCRAMBLE: u32 = 0;
/// Columns of a sweep's result that are neither keys nor metrics.
const RESULT_COLUMNS: [&str; 4] = ["point", "drive_hash", "fault_code", "failure"];
/// Maximum number of values of an axis that are written in the description of the sweep.
const MAX_WRITTEN: u64 = 10_000;

/// Points of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub enum Design {
    /// Every combination; the last axis changes fastest.
    Product(Vec<Axis>),
    /// A sample with the points for Sobol indices.
    Sample {
        /// Keys with their ranges.
        ranges: Vec<Range>,
        /// Number of pairs of draws.
        draws: u64,
    },
    /// Listed points.
    List {
        /// Keys of the points.
        keys: Vec<String>,
        /// Values of the keys at each point.
        rows: Vec<Vec<f64>>,
    },
}

/// Arrangement of the points of a sweep, for figures.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// Number of values of each key, if the points are every combination of these.
    pub counts: Option<Vec<u64>>,
    /// `true` for each key with logarithmic spacing.
    pub logs: Vec<bool>,
    /// `true` if the values of a key are listed, and so may be unevenly spaced.
    pub uneven: bool,
    /// `true` if the points are those for Sobol indices.
    pub sample: bool,
}

impl Design {
    /// Creates every combination of several axes.
    pub fn product(axes: Vec<Axis>) -> Result<Self, SweepError> {
        each_once(axes.iter().map(|axis| &axis.key))?;
        let points = axes.iter().fold(1_u128, |points, axis| points.saturating_mul(axis.count().into()));
        if axes.is_empty() {
            return Err(SweepError::None);
        }
        if points > MOST_POINTS.into() {
            return Err(SweepError::Points(points));
        }
        Ok(Design::Product(axes))
    }

    /// Creates a sample of `draws` pairs of draws.
    pub fn sample(ranges: Vec<Range>, draws: u64) -> Result<Self, SweepError> {
        each_once(ranges.iter().map(|range| &range.key))?;
        if ranges.is_empty() || ranges.len() > MOST_SAMPLED {
            return Err(SweepError::Sampled(ranges.len()));
        }
        if !(2..=MOST_DRAWS).contains(&draws) {
            return Err(SweepError::Draws(draws));
        }
        Ok(Design::Sample { ranges, draws })
    }

    /// Creates listed points.
    pub fn listed(keys: Vec<String>, rows: Vec<Vec<f64>>) -> Result<Self, SweepError> {
        each_once(keys.iter())?;
        if keys.is_empty() {
            return Err(SweepError::None);
        }
        Ok(Design::List { keys, rows })
    }

    /// Reads points from the table of a file: a heading with the keys, and one row per point. The
    /// other columns of a sweep's result are left out.
    ///
    /// # Errors
    /// If the file is not such a table, with the line that shows it.
    pub fn read(file: &str, bytes: &[u8]) -> Result<Self, SweepError> {
        let wrong = |line: usize, why: String| SweepError::File { file: file.to_owned(), line: line as u64, why };
        let table = columns::parse(bytes, None).map_err(|error| match error {
            TableError::Empty | TableError::NoNumbers { .. } => {
                wrong(1, "no points: give a first line with the keys, then one line per point".to_owned())
            }
            error => wrong(error.line().unwrap_or(1), error.to_string()),
        })?;
        let line = |row: usize| table.lines.get(row).map_or(row + 1, |line| *line);
        let Some(names) = &table.names else {
            let why = "no keys: a file of points begins with a line of keys, for example `contact.dahl.mu`";
            return Err(wrong(line(0), why.to_owned()));
        };
        each_once(names.iter())?;
        let is_key = |name: &str| !RESULT_COLUMNS.contains(&name) && metrics::known(name).is_err();
        let (keys, columns): (Vec<String>, Vec<&Column>) =
            names.iter().cloned().zip(&table.columns).filter(|(name, _)| is_key(name)).unzip();
        for (key, column) in keys.iter().zip(&columns) {
            column.numbers().map_err(|cell| wrong(line(cell.row), format!("the key `{key}` is {}, not a number", cell.what)))?;
        }
        if table.rows() as u64 > MOST_POINTS {
            return Err(SweepError::Points(table.rows() as u128));
        }
        let rows = (0..table.rows()).map(|row| columns.iter().map(|column| column.values[row]).collect()).collect();
        Ok(Design::List { keys, rows })
    }

    /// Returns the number of points.
    pub fn count(&self) -> u64 {
        match self {
            Design::Product(axes) => axes.iter().map(Axis::count).product(),
            Design::Sample { ranges, draws } => draws * (ranges.len() as u64 + 2),
            Design::List { rows, .. } => rows.len() as u64,
        }
    }

    /// Returns the keys that differ between points.
    pub fn keys(&self) -> Vec<&str> {
        match self {
            Design::Product(axes) => axes.iter().map(|axis| axis.key.as_str()).collect(),
            Design::Sample { ranges, .. } => ranges.iter().map(|range| range.key.as_str()).collect(),
            Design::List { keys, .. } => keys.iter().map(String::as_str).collect(),
        }
    }

    /// Returns the smallest and the largest value of a key, by its index.
    pub fn ends(&self, key: usize) -> (f64, f64) {
        match self {
            Design::Product(axes) => axes[key].ends(),
            Design::Sample { ranges, .. } => ranges[key].ends,
            Design::List { rows, .. } => {
                let values = rows.iter().map(|row| row[key]);
                values.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), value| (least.min(value), most.max(value)))
            }
        }
    }

    /// Returns the values of one point, counted from zero.
    pub fn values(&self, point: u64) -> Vec<f64> {
        match self {
            Design::List { rows, .. } => rows[point as usize].clone(),
            Design::Sample { ranges, .. } => {
                let (pair, place) = (point / (ranges.len() as u64 + 2), point % (ranges.len() as u64 + 2));
                // Place 0 is A, the last is B; each place between has one key from B.
                let of_b = |key: usize| place == key as u64 + 1 || place == ranges.len() as u64 + 1;
                let draw = |(key, range): (usize, &Range)| {
                    let dimension = if of_b(key) { key + ranges.len() } else { key };
                    range.value(sobol_burley::sample(pair as u32, dimension as u32, SCRAMBLE).into())
                };
                ranges.iter().enumerate().map(draw).collect()
            }
            Design::Product(axes) => {
                let mut rest = point;
                let mut values: Vec<f64> = axes
                    .iter()
                    .rev()
                    .map(|axis| {
                        let index = rest % axis.count();
                        rest /= axis.count();
                        axis.value(index)
                    })
                    .collect();
                values.reverse();
                values
            }
        }
    }

    /// Returns the arrangement of the points.
    pub fn shape(&self) -> Shape {
        let none = Shape { counts: None, logs: Vec::new(), uneven: false, sample: false };
        match self {
            Design::Product(axes) => Shape {
                counts: Some(axes.iter().map(Axis::count).collect()),
                logs: axes.iter().map(Axis::is_log).collect(),
                uneven: axes.iter().any(Axis::is_list),
                ..none
            },
            Design::Sample { ranges, .. } => Shape { logs: ranges.iter().map(|range| range.log).collect(), sample: true, ..none },
            Design::List { keys, .. } => Shape { logs: vec![false; keys.len()], ..none },
        }
    }

    /// Describes this design uniquely, as JSON.
    pub fn json(&self) -> Value {
        match self {
            Design::Product(axes) => {
                let axis = |axis: &Axis| {
                    let (least, most) = axis.ends();
                    json!({ "key": axis.key, "count": axis.count(), "least": least, "most": most, "log": axis.is_log(), "list": axis.is_list(), "values": axis.listed(MAX_WRITTEN) })
                };
                json!({ "axes": axes.iter().map(axis).collect::<Vec<_>>() })
            }
            Design::Sample { ranges, draws } => {
                let range =
                    |range: &Range| json!({ "key": range.key, "least": range.ends.0, "most": range.ends.1, "log": range.log });
                json!({ "sample": "sobol", "draws": draws, "ranges": ranges.iter().map(range).collect::<Vec<_>>() })
            }
            Design::List { keys, rows } => {
                // A list may be long: a hash of its text identifies it.
                let text: String = rows.iter().flatten().map(|value| format!("{value:e},")).collect();
                let written = (rows.len() * keys.len() <= MAX_WRITTEN as usize).then_some(rows);
                json!({ "keys": keys, "values_hash": format!("{:016x}", crate::record::text_hash(&text)), "values": written })
            }
        }
    }
}

/// Refuses a key that occurs twice.
fn each_once<'a>(keys: impl Iterator<Item = &'a String>) -> Result<(), SweepError> {
    let mut seen = std::collections::BTreeSet::new();
    for key in keys {
        if !seen.insert(key) {
            return Err(SweepError::Twice(key.clone()));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn product(axes: &[&str]) -> Result<Design, SweepError> {
        Design::product(axes.iter().map(|axis| axis.parse().expect("an axis")).collect())
    }

    #[test]
    fn the_last_axis_changes_fastest() {
        let design = product(&["a=1,2", "b=10:30:3"]).expect("a design");
        let points: Vec<Vec<f64>> = (0..design.count()).map(|point| design.values(point)).collect();
        assert_eq!(points, [[1.0, 10.0], [1.0, 20.0], [1.0, 30.0], [2.0, 10.0], [2.0, 20.0], [2.0, 30.0]]);
    }

    #[test]
    fn too_many_points_are_refused_before_they_are_made() {
        let error = product(&["a=0:1:1000000", "b=0:1:1000000"]).expect_err("1e12 points").to_string();
        assert!(error.contains("1000000000000 points"), "{error}");
        assert!(product(&["a=0:1:1e15", "b=0:1:1e15", "c=0:1:1e15"]).is_err());
        assert!(product(&["a=1,2", "a=3,4"]).expect_err("a key twice").to_string().contains("`a`"));
    }

    /// Each key is from B in one point of a pair; all are in the last point, and none in the first.
    #[test]
    fn sample_is_arranged_for_sobol_indices() {
        let ranges = ["a=0:1", "b=10:1000:log"].map(|range| range.parse().expect("a range"));
        let design = Design::sample(ranges.to_vec(), 64).expect("a sample");
        assert_eq!(design.count(), 256);
        for pair in 0..64 {
            let [a, first, second, b] = [0, 1, 2, 3].map(|place| design.values(4 * pair + place));
            assert_eq!((first, second), (vec![b[0], a[1]], vec![a[0], b[1]]));
        }
        // Half of the draws are in each half of a range, as in any sequence of low discrepancy.
        let below = |key: usize, middle: f64| (0..64).filter(|pair| design.values(4 * pair)[key] < middle).count();
        assert_eq!((below(0, 0.5), below(1, 100.0), below(0, 0.125)), (32, 32, 8));
        assert!(Design::sample(ranges.to_vec(), 1).is_err() && Design::sample(Vec::new(), 8).is_err());
        assert!(Design::sample(ranges.to_vec(), 1 << 17).expect_err("too many").to_string().contains("65536"));
    }

    #[test]
    fn file_has_a_header_and_one_line_per_point() {
        let design = Design::read("p.csv", b"a, b\n1, 2e3\n-3, 4\n").expect("points");
        assert_eq!((design.keys(), design.values(1), design.ends(1)), (vec!["a", "b"], vec![-3.0, 4.0], (4.0, 2e3)));
        for text in ["# mine\na;b\n1,0;2e3\n-3;4\n", "point,a,b,q,drive_hash,failure\n0,1,2e3,64.9,,\n1,-3,4,,0a1b,\n"] {
            assert_eq!(Design::read("p.csv", text.as_bytes()).expect(text), design);
        }
        for (text, why) in [
            ("", "no points"),
            ("a\n", "no points"),
            ("1,2\n3,4\n", "line 1: no keys"),
            ("a,b\n1,2\n1\n", "line 3: 1 cells, but the table has 2 columns"),
            ("a\n1,2\n", "no keys"),
            ("a\n1\nx\n", "line 3"),
            ("a,b\n1,2\n1,x\n", "line 3: the key `b` is `x`, not a number"),
            ("a,a\n1,2\n", "`a`"),
        ] {
            let error = Design::read("p.csv", text.as_bytes()).expect_err(text).to_string();
            assert!(error.contains(why), "{text:?}: {error}");
        }
    }
}
