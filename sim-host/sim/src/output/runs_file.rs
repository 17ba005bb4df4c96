//! `runs.csv`: every run of several, with its seed, drawn values and metrics. Units are in the
//! column names.

use std::path::Path;

use crate::study::monte_carlo::MonteCarlo;
use scene::metrics;

/// Writes the runs. A metric that a run lacks is empty; a metric that all runs lack has no column.
pub(super) fn write(runs: &MonteCarlo, path: &Path) -> Result<(), csv::Error> {
    let mut file = csv::Writer::from_path(path)?;
    let any = |name: &&str| runs.runs.iter().any(|run| run.metrics.get(name).is_some());
    let names: Vec<&str> = metrics::names().filter(any).collect();
    let head = ["run", "seed"].into_iter().chain(runs.keys.iter().map(String::as_str)).chain(["locked"]);
    file.write_record(head.chain(names.iter().copied()))?;
    for run in &runs.runs {
        let mut row = vec![run.draw.number.to_string(), run.draw.seed.to_string()];
        row.extend(run.draw.values.iter().map(|value| format!("{value:?}")));
        row.push(u8::from(run.locked).to_string());
        row.extend(names.iter().map(|name| run.metrics.get(name).map_or_else(String::new, |value| value.to_string())));
        file.write_record(row)?;
    }
    file.flush()?;
    Ok(())
}
