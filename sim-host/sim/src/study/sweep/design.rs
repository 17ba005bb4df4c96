//! The points of a sweep: every combination of some axes, a sample, or a list. A point has a number, and its values follow from that alone.
//!
//! A sample is laid out for Sobol indices (Saltelli et al., Comput. Phys. Commun. 181, 2010): of each pair of independent draws A and B of all keys there
//! is a point A, one for each key that has this key from B and all others from A, and a point B. The draws are those of a Sobol sequence of twice as
//! many dimensions as there are keys, with Owen's scrambling (the crate `sobol_burley`).

use serde_json::{Value, json};

use super::SweepError;
use super::axis::{Axis, Range};

/// Most points of a sweep.
pub const MOST_POINTS: u64 = 100_000_000;
/// Most draws of a sample: as far as the sequence goes.
pub const MOST_DRAWS: u64 = 1 << 16;
/// Most keys of a sample: half of the dimensions of the sequence.
const MOST_SAMPLED: usize = 128;
/// Of all scrambled sequences the one that samples are of.
const SCRAMBLE: u32 = 0;
/// Most values of an axis that are written out where the sweep is described.
const WRITTEN: u64 = 10_000;

/// The points of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub enum Design {
    /// Every combination; the last axis changes fastest.
    Product(Vec<Axis>),
    /// A sample with the points that Sobol indices need.
    Sample {
        /// The keys with their ranges.
        ranges: Vec<Range>,
        /// How many pairs of draws there are.
        draws: u64,
    },
    /// Given points.
    List {
        /// The keys.
        keys: Vec<String>,
        /// For each point, the value of each key.
        rows: Vec<Vec<f64>>,
    },
}

/// How the points of a sweep lie, for figures of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// How many values each key has, if the points are every combination of these.
    pub counts: Option<Vec<u64>>,
    /// For each key whether its values are spread by ratios.
    pub logs: Vec<bool>,
    /// Whether the values of a key are given one by one, and so may lie anywhere.
    pub uneven: bool,
    /// Whether the points are those that Sobol indices need.
    pub sample: bool,
}

impl Design {
    /// Every combination of some axes.
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

    /// A sample of so many pairs of draws.
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

    /// Points of a CSV: a head with the keys, and a line a point.
    pub fn read(file: &str, text: impl std::io::Read) -> Result<Self, SweepError> {
        let wrong = |line: u64, why: String| SweepError::File { file: file.to_owned(), line, why };
        let mut reader = csv::ReaderBuilder::new().flexible(true).trim(csv::Trim::All).from_reader(text);
        let of_csv = |error: csv::Error| wrong(error.position().map_or(1, csv::Position::line), error.to_string());
        let keys: Vec<String> = reader.headers().map_err(of_csv)?.iter().map(str::to_owned).collect();
        if let Some(number) = keys.iter().find(|key| key.parse::<f64>().is_ok()) {
            let why = format!("`{number}` is no key: a file of points begins with a line of keys, as `contact.dahl.mu`");
            return Err(wrong(1, why));
        }
        each_once(keys.iter())?;
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(of_csv)?;
            let line = record.position().map_or(0, csv::Position::line);
            if record.len() != keys.len() {
                let (values, keys) = (record.len(), keys.len());
                return Err(wrong(line, format!("{values} values for {keys} keys")));
            }
            let number = |(key, cell): (&String, &str)| {
                let number = cell.parse::<f64>().ok().filter(|number| number.is_finite());
                number.ok_or_else(|| wrong(line, format!("`{cell}` is no number for `{key}`")))
            };
            rows.push(keys.iter().zip(&record).map(number).collect::<Result<Vec<_>, _>>()?);
            if rows.len() as u64 > MOST_POINTS {
                return Err(SweepError::Points(rows.len() as u128));
            }
        }
        if rows.is_empty() {
            return Err(wrong(1, "no points: a first line with the keys, and then a line a point".to_owned()));
        }
        Ok(Design::List { keys, rows })
    }

    /// How many points there are.
    pub fn count(&self) -> u64 {
        match self {
            Design::Product(axes) => axes.iter().map(Axis::count).product(),
            Design::Sample { ranges, draws } => draws * (ranges.len() as u64 + 2),
            Design::List { rows, .. } => rows.len() as u64,
        }
    }

    /// The keys that differ from point to point.
    pub fn keys(&self) -> Vec<&str> {
        match self {
            Design::Product(axes) => axes.iter().map(|axis| axis.key.as_str()).collect(),
            Design::Sample { ranges, .. } => ranges.iter().map(|range| range.key.as_str()).collect(),
            Design::List { keys, .. } => keys.iter().map(String::as_str).collect(),
        }
    }

    /// The smallest and the largest value of a key, by its place.
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

    /// The values of one point, counted from zero.
    pub fn values(&self, point: u64) -> Vec<f64> {
        match self {
            Design::List { rows, .. } => rows[point as usize].clone(),
            Design::Sample { ranges, .. } => {
                let (pair, place) = (point / (ranges.len() as u64 + 2), point % (ranges.len() as u64 + 2));
                // Place 0 is A, the last is B; between them a key each is of B.
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

    /// How the points lie.
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

    /// What makes this design, and no other.
    pub fn json(&self) -> Value {
        match self {
            Design::Product(axes) => {
                let axis = |axis: &Axis| {
                    let (least, most) = axis.ends();
                    json!({ "key": axis.key, "count": axis.count(), "least": least, "most": most, "log": axis.is_log(), "list": axis.is_list(), "values": axis.listed(WRITTEN) })
                };
                json!({ "axes": axes.iter().map(axis).collect::<Vec<_>>() })
            }
            Design::Sample { ranges, draws } => {
                let range =
                    |range: &Range| json!({ "key": range.key, "least": range.ends.0, "most": range.ends.1, "log": range.log });
                json!({ "sample": "sobol", "draws": draws, "ranges": ranges.iter().map(range).collect::<Vec<_>>() })
            }
            Design::List { keys, rows } => {
                // A list may be long: its text stands for it.
                let text: String = rows.iter().flatten().map(|value| format!("{value:e},")).collect();
                let written = (rows.len() * keys.len() <= WRITTEN as usize).then_some(rows);
                json!({ "keys": keys, "values_hash": format!("{:016x}", crate::record::text_hash(&text)), "values": written })
            }
        }
    }
}

/// Refuses a key that is there twice.
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

    /// Each key is from B in one point of a pair, all are in the last, and none in the first.
    #[test]
    fn a_sample_is_laid_out_for_indices() {
        let ranges = ["a=0:1", "b=10:1000:log"].map(|range| range.parse().expect("a range"));
        let design = Design::sample(ranges.to_vec(), 64).expect("a sample");
        assert_eq!(design.count(), 256);
        for pair in 0..64 {
            let [a, first, second, b] = [0, 1, 2, 3].map(|place| design.values(4 * pair + place));
            assert_eq!((first, second), (vec![b[0], a[1]], vec![a[0], b[1]]));
        }
        // In each half of a range lies half of the draws, as a sequence of low discrepancy has it.
        let below = |key: usize, middle: f64| (0..64).filter(|pair| design.values(4 * pair)[key] < middle).count();
        assert_eq!((below(0, 0.5), below(1, 100.0), below(0, 0.125)), (32, 32, 8));
        assert!(Design::sample(ranges.to_vec(), 1).is_err() && Design::sample(Vec::new(), 8).is_err());
        assert!(Design::sample(ranges.to_vec(), 1 << 17).expect_err("too many").to_string().contains("65536"));
    }

    #[test]
    fn a_file_has_a_head_and_a_line_a_point() {
        let design = Design::read("p.csv", "a, b\n1, 2e3\n-3, 4\n".as_bytes()).expect("points");
        assert_eq!((design.keys(), design.values(1), design.ends(1)), (vec!["a", "b"], vec![-3.0, 4.0], (4.0, 2e3)));
        for (text, why) in [
            ("", "no points"),
            ("a\n", "no points"),
            ("1,2\n3,4\n", "`1` is no key"),
            ("a,b\n1\n", "line 2: 1 values for 2 keys"),
            ("a\n1,2\n", "2 values for 1 keys"),
            ("a\n1\nx\n", "line 3"),
            ("a,a\n1,2\n", "`a`"),
        ] {
            let error = Design::read("p.csv", text.as_bytes()).expect_err(text).to_string();
            assert!(error.contains(why), "{text:?}: {error}");
        }
    }
}
