//! Instructions of a drive period, which are the same on every run, unlike times.
//!
//! This executable is started again under valgrind's counter and runs only one method: once over
//! [`SHORT_RUN_PERIODS`] periods and once over [`LONG_RUN_PERIODS`]. The difference counts the
//! periods in between: start-up and tables cancel.

use std::path::Path;
use std::process::{Command, Stdio};

use rayon::prelude::*;

use super::method::by_name;
use super::work::Curve;
use contact::SolveError;
use contact::table_4_1::{VELOCITY_RATIO, table_4_1};

/// Periods of the shorter run.
pub const SHORT_RUN_PERIODS: u32 = 4;
/// Periods of the longer run.
pub const LONG_RUN_PERIODS: u32 = 12;
/// Program that counts.
const COUNTER: &str = "valgrind";
/// Its options for the fastest count: no caches, no file.
const COUNTER_OPTIONS: [&str; 3] = ["--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null"];
/// Start of the line with the count.
const COUNT_LINE: &str = "I refs:";

/// Reason why nothing was counted.
#[derive(Debug, thiserror::Error)]
pub enum Uncounted {
    /// The counter is not installed.
    #[error("{COUNTER} is not on PATH")]
    Absent,
    /// The count of the instructions failed.
    #[error("{COUNTER} did not count {method} at {steps} steps: {said}")]
    Failed {
        /// Name of the method.
        method: &'static str,
        /// Steps a period.
        steps: u32,
        /// Last line of its output.
        said: String,
    },
}

/// Runs only one method over some periods, for the counter. Returns `false` for an unknown method.
pub fn run_alone(method: &str, steps: u32, periods: u32) -> Result<bool, SolveError> {
    let Some(method) = by_name(method) else { return Ok(false) };
    let problem = table_4_1(VELOCITY_RATIO, f64::from(periods));
    std::hint::black_box((method.run)(&problem, steps)?);
    Ok(true)
}

/// Counts every setting of every method by starting `executable` with `options` and
/// `METHOD,STEPS,PERIODS`.
pub fn count(curves: &mut [Curve], executable: &Path, options: &[&str]) -> Result<(), Uncounted> {
    let there = Command::new(COUNTER).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    if !there.is_ok_and(|status| status.success()) {
        return Err(Uncounted::Absent);
    }
    curves.par_iter_mut().try_for_each(|curve| {
        let method = curve.method.name;
        curve.points.par_iter_mut().try_for_each(|point| {
            let total = |periods| one(executable, options, method, point.steps, periods);
            point.instructions =
                Some((total(LONG_RUN_PERIODS)? - total(SHORT_RUN_PERIODS)?) / f64::from(LONG_RUN_PERIODS - SHORT_RUN_PERIODS));
            Ok(())
        })
    })
}

fn one(executable: &Path, options: &[&str], method: &'static str, steps: u32, periods: u32) -> Result<f64, Uncounted> {
    let failed = |said: String| Uncounted::Failed { method, steps, said };
    let output = Command::new(COUNTER)
        .args(COUNTER_OPTIONS)
        .arg(executable)
        .args(options)
        .arg(format!("{method},{steps},{periods}"))
        .output()
        .map_err(|error| failed(error.to_string()))?;
    let said = String::from_utf8_lossy(&output.stderr);
    let total = said.lines().find_map(parse);
    total.filter(|_| output.status.success()).ok_or_else(|| failed(said.lines().last().unwrap_or_default().into()))
}

/// Parses the count of a line such as `==12== I   refs:      16,193,520`.
fn parse(line: &str) -> Option<f64> {
    let words: Vec<&str> = line.split_whitespace().skip(1).collect();
    let number = words.join(" ");
    let number = number.strip_prefix(COUNT_LINE)?;
    number.trim().replace(',', "").parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_count_is_read() {
        assert_eq!(parse("==12== I   refs:      16,193,520"), Some(16_193_520.0));
        assert_eq!(parse("==12== Cachegrind, a high-precision tracing profiler"), None);
    }

    #[test]
    fn one_method_runs_alone() {
        assert!(run_alone("linexp-2", 8, 4).unwrap());
        assert!(!run_alone("no-such-method", 8, 4).unwrap());
    }
}
