//! `sim-host sweep plan`: how many points there are, and from a few of them, how much time and room they take. Nothing is written.

use std::time::Duration;

use serde_json::json;

use super::{Exit, Format, STOP, Shard};
use sim::study::sweep::{Rows, Sweep};

/// How long points are run.
const BUDGET: Duration = Duration::from_secs(3);
/// Places within the sweep at which points are run.
const PLACES: u64 = 8;
/// Points at a place, if they are fast.
const TOGETHER: u64 = 32;
/// Points that take no longer are fast.
const FAST: Duration = Duration::from_millis(20);

/// Runs some points, on one thread, and says what all of them take.
pub(super) fn run(sweep: &Sweep, shard: Shard, format: Format) -> anyhow::Result<Exit> {
    let count = sweep.design.count();
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let rows = |from: u64, to: u64| alone.install(|| sweep.rows(from..to.min(count), &STOP, &|| ()));
    // The first one also reads tables that others find read.
    rows(0, 1)?;
    let began = processor_time();
    rows(0, 1)?;
    let together = if processor_time() - began < FAST { TOGETHER } else { 1 };
    let (mut spent, mut found) = (Duration::ZERO, Rows::new(sweep.design.keys().len(), sweep.metrics.len()));
    for place in 0..PLACES {
        let from = (count - 1) * (2 * place + 1) / (2 * PLACES);
        let began = processor_time();
        if let Some(some) = rows(from, from + together)? {
            spent += processor_time() - began;
            found.append(some);
        }
        if spent > BUDGET {
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
            "{of_shard} points{shard}\nabout {} of one processor, from {run} points run{}\nabout {} on disk\n",
            time(cpu_s),
            if failed == 0 { String::new() } else { format!(", {failed} of them without result") },
            size(bytes),
        ),
        Format::Json => {
            let json = json!({ "points": of_shard, "cpu_s": cpu_s, "bytes": bytes, "points_run": run, "failures": failed });
            format!("{json:#}\n")
        }
    })?;
    Ok(Exit::Done)
}

/// Time that this process has had of processors, or where the system does not say so the time that has passed.
fn processor_time() -> Duration {
    #[cfg(unix)]
    {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
        Duration::new(time.tv_sec.max(0).unsigned_abs(), time.tv_nsec.max(0).unsigned_abs() as u32)
    }
    #[cfg(not(unix))]
    super::super::clock()
}

/// Bytes of these rows in the parts, in the Parquet file of all, and in the CSV.
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
    fn sizes_and_times_read_well() {
        assert_eq!((time(3.21), time(600.0), time(36_000.0)), ("3.2 s".into(), "10.0 min".into(), "10.0 h".into()));
        assert_eq!((size(2e3), size(3e7), size(4.5e9)), ("2 kB".into(), "30 MB".into(), "4.5 GB".into()));
    }
}
