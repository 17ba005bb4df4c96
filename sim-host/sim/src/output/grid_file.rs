//! Grid of a scene: `grid.csv`, with a row per point.

use std::path::Path;

use crate::study::grid::GridResult;
use crate::study::sweep::Rows;

/// Writes the points; the last column states why a point has no result.
pub(super) fn write(result: &GridResult, path: &Path) -> Result<(), csv::Error> {
    let mut file = csv::Writer::from_path(path)?;
    file.write_record(Rows::head(&result.keys(), &result.metrics).chain(["failure"]))?;
    for (row, failure) in result.rows.failures.iter().enumerate() {
        file.write_record(result.rows.cells(row).chain([report::text_cell(failure.as_deref().unwrap_or_default())]))?;
    }
    file.flush()?;
    Ok(())
}
