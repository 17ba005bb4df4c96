//! `sim-host sweep plan`: number of points, and an estimate of the time and disk space from a few
//! of them. Writes nothing.

use std::time::Duration;

use serde_json::json;

use super::{Exit, Format, STOP, Shard};
use sim::study::sweep::{Rows, Sweep};

/// Processor time after which no further points are run.
const TIME_BUDGET: Duration = Duration::from_secs(3);
/// Number of places within the sweep at which points are run.
const PLACES: u64 = 8;
/// Number of fast points at each place.
const POINTS_PER_PLACE: u64 = 32;
/// Longest processor time of a fast point.
const FAST_POINT: Duration = Duration::from_millis(20);

/// Runs some points on one thread, and prints the estimate for all.
pub(super) fn run(sweep: &Sweep, shard: Shard, format: Format) -> anyhow::Result<Exit> {
    let count = sweep.design.count();
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let rows = |from: u64, to: u64| alone.install(|| sweep.rows(from..to.min(count), &STOP, &|| ()));
    // The first run also reads tables, which later runs find in memory.
    rows(0, 1)?;
    let began = processor_time();
    rows(0, 1)?;
    let together = if processor_time() - began < FAST_POINT { POINTS_PER_PLACE } else { 1 };
    let (mut spent, mut found) = (Duration::ZERO, Rows::new(sweep.design.keys().len(), sweep.metrics.len()));
    for place in 0..PLACES {
        let from = (count - 1) * (2 * place + 1) / (2 * PLACES);
        let began = processor_time();
        if let Some(some) = rows(from, from + together)? {
            spent += processor_time() - began;
            found.append(some);
        }
        if spent > TIME_BUDGET {
            break;
        }
    }
    let run = found.points.len() as f64;
    if run == 0.0 {
        return Ok(Exit::Failed);
    }
    let of_shard = shard.count(count);
    let cpu_s = spent.as_secs_f64() / run * of_shard as f64;
    let bytes = (bytes(&found) / run * of_shard as f64).round();
    let failed = found.failures.iter().flatten().count();
    let shard = if shard == Shard::WHOLE { String::new() } else { format!(" of {count}, shard {shard}") };
    super::super::print(&match format {
        Format::Human => format!(
            "{of_shard} points{shard}\nabout {} of processor time, from {run} points run{}\nabout {} on disk\n",
            time(cpu_s),
            if failed == 0 { String::new() } else { format!(", {failed} of them without a result") },
            size(bytes),
        ),
        Format::Json => {
            let json = json!({ "points": of_shard, "cpu_s": cpu_s, "bytes": bytes, "points_run": run, "failures": failed });
            format!("{json:#}\n")
        }
    })?;
    Ok(Exit::Done)
}

/// Returns the processor time of this process, or the elapsed time if the system does not report
/// it.
fn processor_time() -> Duration {
    #[cfg(unix)]
    {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
        Duration::new(time.tv_sec.max(0).unsigned_abs(), time.tv_nsec.max(0).unsigned_abs() as u32)
    }
    #[cfg(not(unix))]
    super::super::clock()
}

/// Returns the bytes of these rows in the parts, in the joined Parquet file, and in the CSV.
fn bytes(rows: &Rows) -> f64 {
    let text = |value: f64| format!("{value:?},").len() as f64;
    let keys = rows.keys.iter().flatten().map(|&value| (1.0, text(value)));
    let metrics = rows.metrics.iter().flatten().map(|value| value.map_or((0.0, 1.0), |value| (8.0, text(value))));
    let hashes = rows.drive_hashes.iter().flatten().map(|_| (16.0, 17.0));
    let (binary, text) = keys.chain(metrics).chain(hashes).fold((0.0, 0.0), |(a, b), (c, d)| (a + c, b + d));
    // The number of the point, and the last line break.
    2.0 * binary + text + 8.0 * rows.points.len() as f64
}

fn time(seconds: f64) -> String {
    match seconds {
        s if s < 120.0 => format!("{s:.1} s"),
        s if s < 7200.0 => format!("{:.1} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

fn size(bytes: f64) -> String {
    match bytes {
        b if b < 1e6 => format!("{:.0} kB", b / 1e3),
        b if b < 1e9 => format!("{:.0} MB", b / 1e6),
        b => format!("{:.1} GB", b / 1e9),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_times_have_suitable_units() {
        assert_eq!((time(3.21), time(600.0), time(36_000.0)), ("3.2 s".into(), "10.0 min".into(), "10.0 h".into()));
        assert_eq!((size(2e3), size(3e7), size(4.5e9)), ("2 kB".into(), "30 MB".into(), "4.5 GB".into()));
    }
}
