//! The table of all metrics: name, unit, meaning, window and sign. Names are a contract: units last, and one meaning in every scene.
//!
//! A scene's expectations are checked against this table before anything is run; what is measured, reported and explained is read from it, and the
//! page `docs/data.md` is generated from it. A run has the metrics that mean something in its scene, and no others.

pub mod figures;
mod table;

use std::sync::LazyLock;

use crate::nearest::{listed, nearest, short};

pub use table::METRICS;

/// A metric of a run, as the tables describe it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Metric {
    /// Name of the metric, of one run and of the median of several.
    pub name: &'static str,
    /// Unit of the metric; `1` of a ratio or a count.
    pub unit: &'static str,
    /// Which values it may have.
    pub sign: Sign,
    /// What part of a run it is measured over.
    pub window: Window,
    /// Meaning of the metric.
    pub meaning: &'static str,
}

/// Which values a metric may have, and so what several runs make of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    /// The metric is zero or more.
    Magnitude,
    /// The metric may have either sign.
    Signed,
    /// Either sign, and best at zero: of several runs, percentile and maximum are of the absolute value.
    Error,
    /// 0 or 1 of one run; of several, the number of runs that have it.
    Flag,
    /// A number that stands for something: of several runs there is one only where all have the same.
    Code,
    /// A count over several runs.
    Count,
}

impl Sign {
    /// Which values these are, in words.
    pub fn meaning(self) -> &'static str {
        match self {
            Sign::Magnitude => "zero or more",
            Sign::Signed => "either sign",
            Sign::Error => "either sign, best at zero",
            Sign::Flag => "0 or 1; of several runs, how many have it",
            Sign::Code => "a number that stands for something; of several runs, if it is the same in all",
            Sign::Count => "how many of several runs",
        }
    }
}

/// What part of a run a metric is measured over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Window {
    /// All steady blocks of the run.
    Steady,
    /// The drive is OFF.
    Off,
    /// The drive is ON.
    On,
    /// The blocks with drive ON and OFF, by the load cell.
    LoadCell,
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
    /// From the lock stage on.
    Lock,
    /// From the last step disturbance on.
    Step,
    /// From one event to another, as the meaning says.
    Event,
    /// The latest estimate of scan or observer.
    Identified,
    /// The crash, from the beginning of its pulse.
    Crash,
    /// The end of the run.
    End,
    /// All calls of the controller, in an emulator.
    Blocks,
    /// All runs of a scene.
    Runs,
}

impl Window {
    /// All windows, in the order of the page.
    pub const ALL: [Window; 17] = [
        Window::Steady,
        Window::Off,
        Window::On,
        Window::LoadCell,
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
    ];

    /// Short name of the window.
    pub fn name(self) -> &'static str {
        match self {
            Window::Steady => "steady",
            Window::Off => "OFF",
            Window::On => "ON",
            Window::LoadCell => "load cell",
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
        }
    }

    /// What part of a run it is.
    pub fn meaning(self) -> &'static str {
        match self {
            Window::Steady => {
                "blocks of the run with envelope one, from 20 ms after an edge, the last step disturbance or the last set point on (or after a third of \
                 what is left of the run, if that is less)"
            }
            Window::Off => {
                "blocks of the run without drive, from 20 ms after the edge on, while the belt moves; of a belt under a horn, the last 2 ms before its \
                 first ON window; of a contact study, the end of its window"
            }
            Window::On => {
                "steady blocks; of the friction switch, whole burst periods from 50 ms after the last set point on; of a belt under a horn, the last 2 ms \
                 of its first ON window; of a contact study, its window (`integrator.window_periods`)"
            }
            Window::LoadCell => "as OFF and ON, but from 50 ms after an edge on: the cell is slow",
            Window::EndOfOn => "the last 2 ms of the first ON window",
            Window::SetPoint => {
                "whole burst periods from 50 ms after the survey, or after the last set point, to the next set point or the end"
            }
            Window::Periods => "the window of a contact study, `integrator.window_periods`",
            Window::Run => "the whole run; of a driven one, its blocks of mode `Run`",
            Window::Edges => "the edges of the first 64 bursts of the run, each from its first DAC sample on; the worst of them",
            Window::Lock => {
                "from the first DAC sample of the lock stage to the first disturbance, or to the first OFF of more than 20 ms; only of a lock stage that is not \
                 preceded by a scan, which finds the frequency before"
            }
            Window::Step => "from the last step disturbance to the end of the run",
            Window::Event => "from one event to another, as the meaning says",
            Window::Identified => "the latest estimate of scan or observer",
            Window::Crash => "from the beginning of the pulse to the end of the run",
            Window::End => "the end of the run",
            Window::Blocks => "all calls of `process`, with `--pil`",
            Window::Runs => "all runs of a scene with `runs`",
        }
    }
}

/// Metrics that have another name now: the former one, and the present one. A former name is read where a run has no metric of that name.
pub const RENAMED: &[(&str, &str)] =
    &[("reduction_percent", "shoulder_force_reduction_percent"), ("input_power_w", "drive_power_w")];

/// A figure that depends on the machine: none of a run's metrics, because it differs from run to run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MachineFigure {
    /// Name of the figure.
    pub name: &'static str,
    /// Unit of the figure.
    pub unit: &'static str,
    /// Meaning of the figure.
    pub meaning: &'static str,
}

/// All figures of the machine, in `machine.json` and in `machine` of `--format json`. A figure that a run does not have is absent.
pub const MACHINE: &[MachineFigure] = &[
    MachineFigure { name: "wall_s", unit: "s", meaning: "Wall time of the simulation itself" },
    MachineFigure {
        name: "simulated_s_per_wall_s",
        unit: "1",
        meaning: "Simulated time over wall time; of several runs, of all together",
    },
    MachineFigure {
        name: "ns_per_period",
        unit: "ns",
        meaning: "Wall time for a period of the excitation, of a contact study: all from the question to the answer",
    },
    MachineFigure { name: "processors", unit: "1", meaning: "Processors that the program may use at the same time" },
    MachineFigure { name: "system", unit: "", meaning: "Operating system and processor that the program was built for" },
];

/// The figure of the machine of this name.
pub fn machine_figure(name: &str) -> Option<&'static MachineFigure> {
    MACHINE.iter().find(|figure| figure.name == name)
}

/// Names of a metric over several runs besides its median.
#[derive(Debug)]
pub struct OfRuns {
    /// The metric of one run.
    pub metric: &'static Metric,
    /// Name of the 95th percentile.
    pub p95: String,
    /// Name of the maximum.
    pub max: String,
}

/// For each metric, its names over several runs.
pub static OF_RUNS: LazyLock<Vec<OfRuns>> = LazyLock::new(|| {
    let of =
        |metric: &'static Metric| OfRuns { metric, p95: format!("{}_p95", metric.name), max: format!("{}_max", metric.name) };
    METRICS.iter().map(of).collect()
});

/// The metric of this name.
pub fn metric(name: &str) -> Option<&'static Metric> {
    METRICS.iter().find(|metric| metric.name == name)
}

/// The metric of one run that a percentile or maximum of several is made of.
pub fn of_one_run(name: &str) -> Option<&'static Metric> {
    OF_RUNS.iter().find(|of| of.p95 == name || of.max == name).map(|of| of.metric)
}

/// The present name of a metric with a former one.
pub fn renamed(name: &str) -> Option<&'static str> {
    RENAMED.iter().find(|(former, _)| *former == name).map(|&(_, present)| present)
}

/// Whether an expectation may name this: a metric, of one run or of several, or its former name.
pub fn is_known(name: &str) -> bool {
    metric(name).or_else(|| of_one_run(name)).is_some() || renamed(name).is_some()
}

/// The present name of a metric, of one run or of several, that is called by this name.
///
/// # Errors
/// What to say of a name that there is not, with those that are near.
pub fn known(name: &str) -> Result<&'static str, String> {
    let of_several = || OF_RUNS.iter().flat_map(|of| [of.p95.as_str(), of.max.as_str()]).find(|known| *known == name);
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

/// The names of all metrics.
pub fn names() -> impl Iterator<Item = &'static str> + Clone {
    METRICS.iter().map(|metric| metric.name)
}

/// The place of a metric in the table; percentile and maximum come after their metric. None of an unknown name.
pub fn rank(name: &str) -> Option<usize> {
    let place = |name: &str| METRICS.iter().position(|metric| metric.name == name);
    place(name).or_else(|| place(of_one_run(name)?.name))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units;

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
