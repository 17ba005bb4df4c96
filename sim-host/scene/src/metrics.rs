//! The table of all metrics: name, unit, meaning, window and sign.
//!
//! Names are a contract: the unit comes last, and a name has the same meaning in every scene. A
//! scene's expectations are checked against this table before the run. Measurement, report and
//! `explain` read it, and `docs/metrics-and-files.md` is generated from it. A run has only the
//! metrics that are meaningful in its scene.

pub mod figures;
mod table;

use std::sync::LazyLock;

use crate::nearest::{listed, nearest, short};

pub use table::METRICS;

/// A metric of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Metric {
    /// Name of the metric, of one run and of the median of several.
    pub name: &'static str,
    /// Unit of the metric; `1` for a ratio or a count.
    pub unit: &'static str,
    /// Range of values, which determines the statistics over several runs.
    pub sign: Sign,
    /// Part of a run that it is measured over.
    pub window: Window,
    /// Meaning of the metric.
    pub meaning: &'static str,
}

/// Range of values of a metric, which determines its statistics over several runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    /// The metric is zero or more.
    Magnitude,
    /// The metric may have either sign.
    Signed,
    /// Either sign, best at zero. Over several runs, percentile and maximum are of the absolute
    /// value.
    Error,
    /// 0 or 1 in one run; over several runs, the number of runs in which it is 1.
    Flag,
    /// A code number. Over several runs it exists only if all runs have the same.
    Code,
    /// A count over several runs.
    Count,
}

impl Sign {
    /// Describes the range of values in words.
    pub fn meaning(self) -> &'static str {
        match self {
            Sign::Magnitude => "zero or more",
            Sign::Signed => "either sign",
            Sign::Error => "either sign, best at zero",
            Sign::Flag => "0 or 1; over several runs, the number of runs in which it is 1",
            Sign::Code => "a code number; over several runs, only if all have the same",
            Sign::Count => "number of runs, out of several",
        }
    }
}

/// Part of a run that a metric is measured over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Window {
    /// All steady blocks of the run.
    Steady,
    /// The blocks with the drive OFF.
    Off,
    /// The blocks with the drive ON.
    On,
    /// The blocks with the drive ON or OFF, for the load cell.
    LoadCell,
    /// Whole periods of bursts, or the steady blocks of a continuous drive.
    WholePeriods,
    /// The end of the first ON window of a belt under a horn.
    EndOfOn,
    /// The last set point of the friction switch.
    SetPoint,
    /// The window of a contact study.
    Periods,
    /// The whole run, from its first block.
    Run,
    /// The edges of bursts.
    Edges,
    /// From the lock stage to the end.
    Lock,
    /// From the last step disturbance to the end.
    Step,
    /// From one event to another; the meaning of the metric names them.
    Event,
    /// The latest estimate of the scan or the observer.
    Identified,
    /// The crash, from the beginning of its pulse.
    Crash,
    /// The end of the run.
    End,
    /// All calls of the controller, in an emulator.
    Blocks,
    /// All runs of a scene.
    Runs,
    /// The working mode of a design, at its operating point.
    Working,
}

impl Window {
    /// All windows, in the order of the page.
    pub const ALL: [Window; 19] = [
        Window::Steady,
        Window::Off,
        Window::On,
        Window::LoadCell,
        Window::WholePeriods,
        Window::EndOfOn,
        Window::SetPoint,
        Window::Periods,
        Window::Run,
        Window::Edges,
        Window::Lock,
        Window::Step,
        Window::Event,
        Window::Identified,
        Window::Crash,
        Window::End,
        Window::Blocks,
        Window::Runs,
        Window::Working,
    ];

    /// Returns the short name of the window.
    pub fn name(self) -> &'static str {
        match self {
            Window::Steady => "steady",
            Window::Off => "OFF",
            Window::On => "ON",
            Window::LoadCell => "load cell",
            Window::WholePeriods => "whole periods",
            Window::EndOfOn => "end of ON",
            Window::SetPoint => "set point",
            Window::Periods => "periods",
            Window::Run => "run",
            Window::Edges => "edges",
            Window::Lock => "lock",
            Window::Step => "step",
            Window::Event => "event",
            Window::Identified => "identified",
            Window::Crash => "crash",
            Window::End => "end",
            Window::Blocks => "blocks",
            Window::Runs => "runs",
            Window::Working => "working mode",
        }
    }

    /// Describes the part of a run.
    pub fn meaning(self) -> &'static str {
        match self {
            Window::Steady => {
                "blocks of the run with envelope one, starting 20 ms after an edge, the last step disturbance or the last set \
                 point (or after a third of the remaining run, if that is shorter)"
            }
            Window::Off => {
                "blocks of the run without drive, starting 20 ms after the edge, while the belt moves; for a belt under a \
                 horn, the last 2 ms before its first ON window; for a contact study, the end of its window"
            }
            Window::On => {
                "steady blocks; for the friction switch, whole burst periods starting 50 ms after the last set point; for a \
                 belt under a horn, the last 2 ms of its first ON window; for a contact study, its window \
                 (`integrator.window_periods`)"
            }
            Window::LoadCell => "as OFF and ON, but starting 50 ms after an edge, because the cell is slow",
            Window::WholePeriods => {
                "whole periods of `controller.burst.period_s`, ON and OFF, starting 50 ms after the first burst or the last step \
                 disturbance; for the friction switch, after its last set point; without bursts (also for a chirp), the steady blocks"
            }
            Window::EndOfOn => "the last 2 ms of the first ON window",
            Window::SetPoint => {
                "whole burst periods starting 50 ms after the survey or the last set point, until the next set point or the end"
            }
            Window::Periods => "the steady state of a contact study, or the window that `integrator.window_periods` gives",
            Window::Run => "the whole run; for a driven scene, its blocks in mode `Run`",
            Window::Edges => "the edges of the first 64 bursts of the run, each from its first DAC sample; the worst of them",
            Window::Lock => {
                "from the first DAC sample of the lock stage to the first disturbance, or to the first OFF of more than 20 ms; \
                 only if no scan precedes the lock stage (a scan already finds the frequency)"
            }
            Window::Step => "from the last step disturbance to the end of the run",
            Window::Event => "from one event to another, as named in the meaning",
            Window::Identified => "the latest estimate of the scan or the observer; for a design, the working mode",
            Window::Crash => "from the beginning of the pulse to the end of the run",
            Window::End => "the end of the run",
            Window::Blocks => "all calls of `process`, with `--pil`",
            Window::Runs => "all runs of a scene with `runs`",
            Window::Working => "the working mode of a design, at its operating point",
        }
    }
}

/// Renamed metrics: former and present name. A former name is accepted if a run has no metric of
/// that name.
pub const RENAMED: &[(&str, &str)] =
    &[("reduction_percent", "shoulder_force_reduction_percent"), ("input_power_w", "drive_power_w")];

/// A figure that depends on the machine. It is not a metric, because it differs from run to run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MachineFigure {
    /// Name of the figure.
    pub name: &'static str,
    /// Unit of the figure.
    pub unit: &'static str,
    /// Meaning of the figure.
    pub meaning: &'static str,
}

/// All machine figures, in `machine.json` and in `machine` of `--format json`. If a run does not
/// have a figure, it is absent.
pub const MACHINE: &[MachineFigure] = &[
    MachineFigure { name: "wall_s", unit: "s", meaning: "Wall time of the simulation itself" },
    MachineFigure {
        name: "simulated_s_per_wall_s",
        unit: "1",
        meaning: "Simulated time divided by wall time; for several runs, the sum of all",
    },
    MachineFigure {
        name: "ns_per_period",
        unit: "ns",
        meaning: "Wall time per period of the excitation, for a contact study, from start to result",
    },
    MachineFigure { name: "processors", unit: "1", meaning: "Processors that the program may use at the same time" },
    MachineFigure { name: "system", unit: "", meaning: "Operating system and processor that the program was built for" },
];

/// Returns the machine figure with this name.
pub fn machine_figure(name: &str) -> Option<&'static MachineFigure> {
    MACHINE.iter().find(|figure| figure.name == name)
}

/// Names of a metric's statistics over several runs, except the median.
#[derive(Debug)]
pub struct OfRuns {
    /// The metric of one run.
    pub metric: &'static Metric,
    /// Name of the 95th percentile.
    pub p95: String,
    /// Name of the maximum.
    pub max: String,
    /// Name of the lower end of the interval that contains 95 % of the runs.
    pub low95: String,
    /// Name of its upper end.
    pub high95: String,
}

impl OfRuns {
    /// Returns the names, except that of the median.
    pub fn names(&self) -> [&str; 4] {
        [&self.p95, &self.max, &self.low95, &self.high95]
    }
}

/// Names over several runs, for each metric.
pub static OF_RUNS: LazyLock<Vec<OfRuns>> = LazyLock::new(|| {
    let of = |metric: &'static Metric| {
        let [p95, max, low95, high95] = ["p95", "max", "low95", "high95"].map(|of| format!("{}_{of}", metric.name));
        OfRuns { metric, p95, max, low95, high95 }
    };
    METRICS.iter().map(of).collect()
});

/// Returns the metric with this name.
pub fn metric(name: &str) -> Option<&'static Metric> {
    METRICS.iter().find(|metric| metric.name == name)
}

/// Returns the metric that a statistic over several runs, other than the median, is computed from.
pub fn of_one_run(name: &str) -> Option<&'static Metric> {
    OF_RUNS.iter().find(|of| of.names().contains(&name)).map(|of| of.metric)
}

/// Returns the present name of a renamed metric.
pub fn renamed(name: &str) -> Option<&'static str> {
    RENAMED.iter().find(|(former, _)| *former == name).map(|&(_, present)| present)
}

/// Returns `true` for a name that an expectation may use: a metric of one run or of several, or a
/// former name.
pub fn is_known(name: &str) -> bool {
    metric(name).or_else(|| of_one_run(name)).is_some() || renamed(name).is_some()
}

/// Returns the present name of a metric, of one run or of several, for a present or former name.
///
/// # Errors
/// If the name is unknown: a message with the nearest names.
pub fn known(name: &str) -> Result<&'static str, String> {
    let of_several = || OF_RUNS.iter().flat_map(OfRuns::names).find(|known| *known == name);
    let found = metric(name).map(|metric| metric.name).or_else(of_several).or_else(|| renamed(name));
    found.ok_or_else(|| {
        let near = nearest(name, names());
        let meant = if near.is_empty() {
            "; `sim-host explain` lists them".to_owned()
        } else {
            format!("; did you mean {}?", listed(near.into_iter().take(3), "or"))
        };
        format!("there is no metric `{}`{meant}", short(name))
    })
}

/// Returns the names of all metrics.
pub fn names() -> impl Iterator<Item = &'static str> + Clone {
    METRICS.iter().map(|metric| metric.name)
}

/// Returns the position of a metric in the table, or `None` if the name is unknown. A statistic
/// over several runs has the position of its metric.
pub fn rank(name: &str) -> Option<usize> {
    let place = |name: &str| METRICS.iter().position(|metric| metric.name == name);
    place(name).or_else(|| place(of_one_run(name)?.name))
}

#[cfg(test)]
mod tests {
    use super::*;
    use columns::unit as units;

    #[test]
    fn names_are_unique_and_end_in_their_units() {
        for metric in METRICS {
            assert_eq!(METRICS.iter().filter(|other| other.name == metric.name).count(), 1, "{}", metric.name);
            if let Some(unit) = units::split(metric.name).1 {
                assert_eq!(unit.symbol, metric.unit, "{}", metric.name);
            }
            assert!(metric.name.contains("percent") == (metric.unit == "%"), "{}", metric.name);
            assert!(!metric.meaning.is_empty() && !metric.meaning.ends_with('.'), "{}", metric.name);
        }
    }

    #[test]
    fn every_former_name_has_a_metric() {
        assert!(RENAMED.iter().all(|(_, present)| metric(present).is_some()));
    }
}
