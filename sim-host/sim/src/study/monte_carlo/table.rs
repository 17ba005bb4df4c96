//! Remarks and tables of several runs: typical values, worst cases, and commands that repeat them.

use super::statistics::{self, Spread};
use super::uncertainty::{self, Shares};
use crate::instruments::Line;
use crate::numbers::number;
use crate::study::Study;
use crate::study::monte_carlo::MonteCarlo;
use report::TableBlock;
use scene::{Scene, metrics};

/// Rows of the table of all runs: label and metric.
const ROWS: &[(&str, &str)] = &[
    ("lock to within 100 Hz [ms]", "lock_time_100hz_ms"),
    ("lock to within 20 Hz [ms]", "lock_time_20hz_ms"),
    ("lock to within 4 Hz [ms]", "lock_time_4hz_ms"),
    ("relock to within 100 Hz [ms]", "relock_time_100hz_ms"),
    ("relock to within 20 Hz [ms]", "relock_time_20hz_ms"),
    ("relock to within 4 Hz [ms]", "relock_time_4hz_ms"),
    ("scan and lock [ms]", "acquire_time_ms"),
    ("bias, steady [Hz]", "frequency_bias_hz"),
    ("jitter, steady [Hz]", "frequency_jitter_hz"),
    ("largest error, steady [Hz]", "frequency_error_max_hz"),
    ("motional phase, steady [degrees]", "motional_phase_deg"),
    ("tip velocity [m/s]", "tip_velocity_m_per_s"),
    ("reduction [%]", "reduction_percent"),
    ("friction ratio", "friction_ratio"),
    ("mean friction [N]", "friction_on_n"),
    ("power ratio", "power_ratio"),
    ("reduction of the force at the shoulder [%]", "shoulder_force_reduction_percent"),
    ("peak force at the shoulder [N]", "peak_shoulder_force_n"),
    ("the same, passive belt [N]", "passive_peak_shoulder_force_n"),
    ("excursion of the torso [m]", "torso_excursion_m"),
    ("the same, passive belt [m]", "passive_torso_excursion_m"),
    ("chest acceleration [g]", "chest_acceleration_g"),
    ("time to LOW friction [ms]", "switch_time_ms"),
    ("time from fault to silence [us]", "fault_latency_us"),
];

/// Counted results: label and metric.
const COUNTS: &[(&str, &str)] = &[
    ("completed", "runs_completed"),
    ("with a true lock", "runs_locked"),
    ("ended in a fault", "runs_faulted"),
    ("with a false lock", "false_locks"),
    ("with an undetected loss of lock", "undetected_losses"),
    ("with friction LOW", "switched"),
];

/// Published results of hardware: system, time, frequency deviation, source.
const PUBLISHED: &[[&str; 4]] = &[
    [
        "ultrasonic scalpel and motor, voltage-sensing bridge: build-up",
        "10, then 3 ms",
        "250, then 200 Hz under load",
        "Micromachines 14(12) 2147, 2023",
    ],
    [
        "1 MHz transducer, phase-locked loop on a dsPIC: average convergence",
        "9 to 12 ms",
        "±0.2 %, which is 80 Hz at 40 kHz",
        "Boontaklang and Chompoo-Inwai 2019",
    ],
    [
        "travelling-wave motor, amplitude and parallel resonance: velocity response",
        "3 to 4 ms",
        "not stated",
        "Sensors 19(23) 5326, 2019",
    ],
];

/// Number of runs from which an interval of 95 % excludes some of them.
const MIN_INTERVAL_RUNS: usize = 41;

/// Headline metrics.
pub const HEADLINE: &[Line] = &[
    ("lock time to 20 Hz, median", "lock_time_20hz_ms", "ms"),
    ("lock time to 20 Hz, 95 %", "lock_time_20hz_ms_p95", "ms"),
    ("relock time to 20 Hz, 95 %", "relock_time_20hz_ms_p95", "ms"),
    ("bias, 95 %", "frequency_bias_hz_p95", "Hz"),
    ("locked", "runs_locked", "runs"),
    ("ended in a fault", "runs_faulted", "runs"),
    ("false locks", "false_locks", "runs"),
    ("undetected losses", "undetected_losses", "runs"),
    ("with friction LOW", "switched", "runs"),
    ("reduction of the force at the shoulder, median", "shoulder_force_reduction_percent", "%"),
];

/// Returns the intervals of the main metrics and the number of runs, as headlines.
pub fn first(scene: &Scene, runs: &MonteCarlo) -> Vec<(String, String)> {
    let intervals = uncertainty::intervals(scene, runs);
    let tiles = intervals.iter().map(|interval| (interval.line.0.to_owned(), interval.text()));
    tiles.chain([("runs".to_owned(), runs.runs.len().to_string())]).collect()
}

/// Returns the introduction.
pub fn preface(runs: &MonteCarlo) -> String {
    let varied = if runs.keys.is_empty() { "only the seed".to_owned() } else { runs.keys.join(", ") };
    format!(
        "Monte Carlo over {} runs, each with its own seed. Varied between them: {varied}. All runs, with their drawn values, \
         are in runs.csv.",
        runs.runs.len()
    )
}

/// Returns remarks on few runs and on uncertain ends, and the worst run with the command that
/// repeats it.
pub fn remarks(study: &Study, runs: &MonteCarlo) -> Vec<String> {
    let few = (runs.runs.len() < MIN_INTERVAL_RUNS && !uncertainty::intervals(study.scene, runs).is_empty()).then(|| {
        format!("With fewer than {MIN_INTERVAL_RUNS} runs, the ends of an interval are the smallest and the largest value.")
    });
    let unknown = uncertainty::end_error_rel(study.scene, &runs.runs).filter(|error| *error >= uncertainty::END_ERROR_REL);
    let unknown = unknown.filter(|_| few.is_none()).map(|error| {
        format!(
            "An end of the interval has a standard error of {} % of its width after {} runs: more --samples narrow it down.",
            number((100.0 * error).round()),
            runs.runs.len()
        )
    });
    few.into_iter().chain(unknown).chain(worst(study, runs)).collect()
}

fn worst(study: &Study, runs: &MonteCarlo) -> Option<String> {
    let (worst, why) = runs.worst(study.scene)?;
    let changes: String = study.changes.iter().map(|change| format!(" --set '{change}'")).collect();
    let again = format!("sim-host run {} --run {}{changes}", study.origin, worst.draw.number);
    let drew = worst.draw.sets(&runs.keys).join(", ");
    Some(format!("The worst run is number {} ({why}): {drew}. To repeat it with its full report: {again}", worst.draw.number))
}

/// Returns the tables of several runs.
pub fn tables(study: &Study, runs: &MonteCarlo) -> Vec<TableBlock> {
    let mut tables = vec![spreads(study, runs)];
    tables.extend(shares(study, runs));
    tables.push(counts(study, runs));
    if study.metrics.get("runs_locked").is_some() {
        let rows = PUBLISHED.iter().map(|row| row.map(str::to_owned).to_vec()).collect();
        let caption =
            "Measured on hardware with other loads, by each source's own definition of a lock. The results above are simulated.";
        tables.push(TableBlock::new("published", "Published figures", caption, &["", "time", "frequency", "source"], rows));
    }
    tables
}

fn spreads(study: &Study, runs: &MonteCarlo) -> TableBlock {
    let row = |&(label, name): &(&str, &str)| {
        let spread = statistics::spread(name, runs.runs.iter().map(|run| &run.metrics))?;
        let Spread { median, p95, max, interval: [low, high], have } = spread;
        let mut row = vec![label.to_owned()];
        row.extend([median, low, high, p95, max].map(shown));
        row.push(have.to_string());
        row.push(reference(study, name));
        Some(row)
    };
    let mut rows: Vec<Vec<String>> = ROWS.iter().filter_map(row).collect();
    let mut header = vec!["", "median", "2.5 %", "97.5 %", "95 %", "largest", "counted runs", "expected"];
    if rows.iter().all(|row| row.last().is_some_and(String::is_empty)) {
        header.pop();
        rows.iter_mut().for_each(|row| drop(row.pop()));
    }
    let caption = "Of the runs, the named part is at or below each number: 95 % of them are between 2.5 % and 97.5 %.";
    let of_driven = " A run without a time never reached it, and counts as infinite. For bias and phase, `95 %` and `largest` are \
                     those of the absolute value. Times are from the first sample of the lock stage, or from the last step.";
    let caption = &format!("{caption}{}", if study.scene.controller.is_some() { of_driven } else { "" });
    TableBlock::new("runs", "All runs", caption, &header, rows)
}

/// Returns the table of what the scatter of the main metric comes from.
fn shares(study: &Study, runs: &MonteCarlo) -> Option<TableBlock> {
    let interval = uncertainty::intervals(study.scene, runs).into_iter().next()?;
    let (label, metric, _) = interval.line;
    let Shares { keys, rest } = uncertainty::shares(study.scene, runs, metric)?;
    let percent = |part: f64| format!("{:.0}", 100.0 * part);
    let rows = keys.into_iter().map(|(keys, part)| vec![keys.join(", "), percent(part)]);
    let rows = rows.chain([vec!["rest".to_owned(), percent(rest)]]).collect();
    let caption = format!(
        "Part of the variance of `{metric}` that each drawn number explains by itself (first-order Sobol' index). The rest comes \
         from combinations of them, and from noise."
    );
    Some(TableBlock::new("shares", &format!("Where the scatter of the {label} comes from"), &caption, &["", "part [%]"], rows))
}

/// Returns the expectations of the scene for a metric, if there are any.
fn reference(study: &Study, name: &str) -> String {
    let of = |judged: &str| match metrics::of_one_run(judged) {
        Some(base) if base.name == name => Some(if judged.ends_with("_p95") { "95 %: " } else { "largest: " }),
        None if judged == name => Some("median: "),
        _ => None,
    };
    let texts = study.judged.iter().filter_map(|judged| Some(format!("{}{}", of(&judged.metric)?, judged.limit)));
    texts.collect::<Vec<_>>().join(", ")
}

fn counts(study: &Study, runs: &MonteCarlo) -> TableBlock {
    let row = |&(label, name): &(&str, &str)| {
        study.metrics.get(name).map(|count| vec![label.to_owned(), count.to_string(), format!("of {}", runs.asked)])
    };
    TableBlock::new("counts", "Runs", "", &["", "runs", ""], COUNTS.iter().filter_map(row).collect())
}

fn shown(value: f64) -> String {
    if value.is_finite() { number(value) } else { "never".to_owned() }
}

/// Describes the runs in one line.
pub fn manner(runs: &MonteCarlo) -> String {
    let count = runs.runs.len();
    let time = |wall_s: f64| format!("{count} runs in {} s: {} runs per second", number(wall_s), number(count as f64 / wall_s));
    runs.wall_s.map_or_else(|| format!("{count} runs"), time)
}

/// Returns the number of completed runs in words.
pub fn reached(runs: &MonteCarlo) -> String {
    format!("{} of {} runs", runs.runs.len(), runs.asked)
}

/// Returns number of runs and drive hash for the footer.
pub fn footer(runs: &MonteCarlo) -> Vec<(&'static str, String)> {
    let hash = runs.drive_hash().map(|hash| ("drive hash", format!("{hash:016x}")));
    std::iter::once(("runs", runs.runs.len().to_string())).chain(hash).collect()
}
