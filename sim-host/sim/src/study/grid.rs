//! A grid: one metric over two keys.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::{StudyError, cell};
use scene::Grid;
use scene::load::Loaded;

/// A metric over two keys.
#[derive(Clone, Debug, PartialEq)]
pub struct GridResult {
    /// The grid asked for.
    pub grid: Grid,
    /// For each row, the metric in each column.
    pub cells: Vec<Vec<Option<f64>>>,
}

/// Runs every cell of a grid, in parallel; nothing if it is stopped.
pub(super) fn conduct(loaded: &Loaded, grid: &Grid, stop: &AtomicBool) -> Result<Option<GridResult>, StudyError> {
    let places: Vec<(f64, f64)> =
        grid.rows.iter().flat_map(|&row| grid.columns.iter().map(move |&column| (row, column))).collect();
    let run_cell = |&(row, column): &(f64, f64)| {
        let keys = [format!("{}={row}", grid.row_key), format!("{}={column}", grid.column_key)];
        let place = keys.join(", ");
        let cell = cell::load(loaded, &place, &[grid.set.as_slice(), &keys].concat())?;
        Ok(cell::run(&cell, &place, stop)?.get(&grid.metric))
    };
    let values = places.par_iter().map(run_cell).collect::<Result<Vec<_>, StudyError>>()?;
    let cells = values.chunks(grid.columns.len()).map(<[_]>::to_vec).collect();
    Ok((!stop.load(Ordering::Relaxed)).then(|| GridResult { grid: grid.clone(), cells }))
}
