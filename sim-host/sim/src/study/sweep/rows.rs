//! Rows of a sweep: values and metrics of each point, and the hash of its codes, or the reason that
//! it has no result.

/// Rows of some points, stored by columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rows {
    /// Numbers of the points, from zero.
    pub points: Vec<i64>,
    /// Values of each key.
    pub keys: Vec<Vec<f64>>,
    /// Values of each metric, if a point has it.
    pub metrics: Vec<Vec<Option<f64>>>,
    /// Hash of every drive code of a driven run, in hexadecimal digits.
    pub drive_hashes: Vec<Option<String>>,
    /// Number of the fault that ended a driven run, or 0.
    pub fault_codes: Vec<Option<i32>>,
    /// Reasons that points have no result.
    pub failures: Vec<Option<String>>,
}

/// Result of a point.
#[derive(Default)]
pub(super) struct PointResult {
    pub(super) metrics: Vec<Option<f64>>,
    pub(super) drive_hash: Option<String>,
    pub(super) fault_code: Option<i32>,
}

impl Rows {
    /// Creates an empty table for these numbers of keys and metrics.
    pub fn new(keys: usize, metrics: usize) -> Self {
        Rows { keys: vec![Vec::new(); keys], metrics: vec![Vec::new(); metrics], ..Rows::default() }
    }

    /// Adds the row of a point.
    pub(super) fn push(&mut self, point: u64, values: &[f64], measured: Result<PointResult, String>) {
        self.points.push(point as i64);
        self.keys.iter_mut().zip(values).for_each(|(column, &value)| column.push(value));
        let (measured, failure) = match measured {
            Ok(measured) => (measured, None),
            Err(why) => (PointResult { metrics: vec![None; self.metrics.len()], ..PointResult::default() }, Some(why)),
        };
        self.metrics.iter_mut().zip(measured.metrics).for_each(|(column, value)| column.push(value));
        self.drive_hashes.push(measured.drive_hash);
        self.fault_codes.push(measured.fault_code);
        self.failures.push(failure);
    }

    /// Returns the column names of such rows: number, keys, metrics, hash, fault.
    pub fn head<'a>(keys: &'a [String], metrics: &'a [String]) -> impl Iterator<Item = &'a str> {
        let names = keys.iter().chain(metrics).map(String::as_str);
        ["point"].into_iter().chain(names).chain(["drive_hash", "fault_code"])
    }

    /// Returns the number of a row's point and the values of its keys, as text that is read back
    /// exactly.
    pub fn point_cells(&self, row: usize) -> impl Iterator<Item = String> {
        [self.points[row].to_string()].into_iter().chain(self.keys.iter().map(move |key| format!("{:?}", key[row])))
    }

    /// Returns all cells of a row, in the order of [`Rows::head`].
    pub fn cells(&self, row: usize) -> impl Iterator<Item = String> {
        let metrics = self.metrics.iter().map(move |metric| metric[row].map_or_else(String::new, |value| format!("{value:?}")));
        let fault = self.fault_codes[row].map_or_else(String::new, |code| code.to_string());
        self.point_cells(row).chain(metrics).chain([self.drive_hashes[row].clone().unwrap_or_default(), fault])
    }

    /// Removes the first `count` rows.
    pub fn drop_first(&mut self, count: usize) {
        if count > 0 {
            *self = self.split_off(count);
        }
    }

    /// Removes the rows from `from` on, and returns them.
    pub fn split_off(&mut self, from: usize) -> Rows {
        Rows {
            points: self.points.split_off(from),
            keys: self.keys.iter_mut().map(|column| column.split_off(from)).collect(),
            metrics: self.metrics.iter_mut().map(|column| column.split_off(from)).collect(),
            drive_hashes: self.drive_hashes.split_off(from),
            fault_codes: self.fault_codes.split_off(from),
            failures: self.failures.split_off(from),
        }
    }

    /// Appends rows of the same keys and metrics.
    pub fn append(&mut self, mut rows: Rows) {
        self.points.append(&mut rows.points);
        self.keys.iter_mut().zip(&mut rows.keys).for_each(|(all, some)| all.append(some));
        self.metrics.iter_mut().zip(&mut rows.metrics).for_each(|(all, some)| all.append(some));
        self.drive_hashes.append(&mut rows.drive_hashes);
        self.fault_codes.append(&mut rows.fault_codes);
        self.failures.append(&mut rows.failures);
    }
}
