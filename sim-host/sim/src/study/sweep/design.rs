//! The points of a sweep: every combination of some axes, or a list. A point has a number, and its values follow from that alone.

use serde_json::{Value, json};

use super::SweepError;
use super::axis::Axis;

/// Most points of a sweep.
pub const MOST_POINTS: u64 = 100_000_000;
/// Most values of an axis that are written out where the sweep is described.
const WRITTEN: u64 = 10_000;

/// The points of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub enum Design {
    /// Every combination; the last axis changes fastest.
    Product(Vec<Axis>),
    /// Given points.
    List {
        /// The keys.
        keys: Vec<String>,
        /// For each point, the value of each key.
        rows: Vec<Vec<f64>>,
    },
}

impl Design {
    /// Every combination of some axes.
    pub fn product(axes: Vec<Axis>) -> Result<Self, SweepError> {
        if let Some((_, again)) = axes.iter().enumerate().find(|&(at, axis)| axes[..at].iter().any(|other| other.key == axis.key))
        {
            return Err(SweepError::Twice(again.key.clone()));
        }
        let points = axes.iter().map(|axis| u128::from(axis.count())).product::<u128>();
        if axes.is_empty() || points > MOST_POINTS.into() {
            return Err(SweepError::Points(points));
        }
        Ok(Design::Product(axes))
    }

    /// Points of a CSV: a head with the keys, and a line a point.
    pub fn read(file: &str, text: impl std::io::Read) -> Result<Self, SweepError> {
        let wrong = |line: u64, why: String| SweepError::File { file: file.to_owned(), line, why };
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text);
        let of_csv = |error: csv::Error| wrong(error.position().map_or(1, csv::Position::line), error.to_string());
        let keys: Vec<String> = reader.headers().map_err(of_csv)?.iter().map(str::to_owned).collect();
        if let Some((_, again)) = keys.iter().enumerate().find(|&(at, key)| keys[..at].contains(key)) {
            return Err(SweepError::Twice(again.clone()));
        }
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(of_csv)?;
            let line = record.position().map_or(0, csv::Position::line);
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
            Design::List { rows, .. } => rows.len() as u64,
        }
    }

    /// The keys that differ from point to point.
    pub fn keys(&self) -> Vec<&str> {
        match self {
            Design::Product(axes) => axes.iter().map(|axis| axis.key.as_str()).collect(),
            Design::List { keys, .. } => keys.iter().map(String::as_str).collect(),
        }
    }

    /// The smallest and the largest value of a key, by its place.
    pub fn ends(&self, key: usize) -> (f64, f64) {
        match self {
            Design::Product(axes) => axes[key].ends(),
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

    /// What makes this design, and no other.
    pub fn json(&self) -> Value {
        match self {
            Design::Product(axes) => {
                let axis = |axis: &Axis| {
                    let (least, most) = axis.ends();
                    json!({ "key": axis.key, "count": axis.count(), "least": least, "most": most, "values": axis.listed(WRITTEN) })
                };
                json!({ "axes": axes.iter().map(axis).collect::<Vec<_>>() })
            }
            Design::List { keys, rows } => {
                // A list may be long: its text stands for it.
                let text: String = rows.iter().flatten().map(|value| format!("{value:e},")).collect();
                json!({ "keys": keys, "values_hash": format!("{:016x}", crate::record::text_hash(&text)) })
            }
        }
    }
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

    #[test]
    fn a_file_has_a_head_and_a_line_a_point() {
        let design = Design::read("p.csv", "a, b\n1, 2e3\n-3, 4\n".as_bytes()).expect("points");
        assert_eq!((design.keys(), design.values(1), design.ends(1)), (vec!["a", "b"], vec![-3.0, 4.0], (4.0, 2e3)));
        for (text, why) in
            [("", "no points"), ("a\n", "no points"), ("a,b\n1\n", "p.csv"), ("a\n1\nx\n", "line 3"), ("a,a\n1,2\n", "`a`")]
        {
            let error = Design::read("p.csv", text.as_bytes()).expect_err(text).to_string();
            assert!(error.contains(why), "{text:?}: {error}");
        }
    }
}
