//! What is wrong with a transducer or its wiring: which fault comes of it, and after what time.
//!
//! Each defect is there from the beginning, or comes while the observer follows a load; at several Q, in some runs each, in which what the
//! controller is told differs as in every other case.

use std::collections::BTreeSet;

use firmware::seam::fault::Fault;

use super::Trouble;
use super::cases::Load;
use sim::study;
use sim::study::monte_carlo::OneRun;

/// When a defect comes while running, s.
const RUNNING_S: f64 = 0.08;
/// How long it is waited for its fault, s: a coarse scan takes 0.1 s.
const DURATION_S: f64 = 0.4;

/// What is wrong: as scenes call it, in words, and the faults that it is, from the beginning and while running.
///
/// A short that takes more than the current limit is an over-current before anything else. Exchanged channels can come while running only
/// as a fault of the multiplexer: the voltage is then not what was played, or the lock is lost and the self-test, which is repeated, names them.
const DEFECTS: [Kind; 7] = [
    Kind { key: "open", name: "open", from_start: &[Fault::LoadOpen], running: &[Fault::LoadOpen] },
    Kind { key: "short", name: "short of 50 milliohm", from_start: SHORTED, running: SHORTED },
    Kind { key: "depoled", name: "depoled", from_start: &[Fault::CapacitanceShifted], running: &[Fault::CapacitanceShifted] },
    Kind { key: "cracked", name: "cracked", from_start: &[Fault::ResonanceDamaged], running: &[Fault::ResonanceDamaged] },
    Kind {
        key: "swapped",
        name: "V and I swapped",
        from_start: &[Fault::SenseSwapped],
        running: &[Fault::SenseSwapped, Fault::SensorImplausible],
    },
    Kind {
        key: "saturation",
        name: "both channels saturated",
        from_start: &[Fault::SenseSaturated],
        running: &[Fault::SenseSaturated],
    },
    Kind { key: "sensor_stuck", name: "V stuck", from_start: &[Fault::SensorImplausible], running: &[Fault::SensorImplausible] },
];
const SHORTED: &[Fault] = &[Fault::OverCurrent, Fault::LoadShorted];

struct Kind {
    key: &'static str,
    name: &'static str,
    from_start: &'static [Fault],
    running: &'static [Fault],
}

/// A defect at one load.
pub struct Defect {
    /// What, in words.
    pub name: &'static str,
    /// Quality factor of the stack that breaks.
    pub q: u32,
    /// Whether it comes while running.
    pub running: bool,
    /// The faults that say so.
    pub expected: &'static [Fault],
    /// The faults that the runs end with; 0 is none.
    pub found: BTreeSet<u8>,
    /// Longest time from the defect, or from the first block played, to silence, ms; none if a run goes on.
    pub latest_ms: Option<f64>,
    /// Runs in which a lock was claimed that was none.
    pub unnoticed: usize,
    /// How to see it.
    pub command: String,
}

impl Defect {
    /// Whether it ends as it should, in all runs.
    pub fn holds(&self) -> bool {
        !self.found.is_empty() && self.found.iter().all(|code| self.expected.iter().any(|fault| fault.code() == *code))
    }
}

/// Runs all.
pub(super) fn conduct(runs: u32) -> Result<Vec<Defect>, Trouble> {
    let cases = DEFECTS.iter().flat_map(|kind| [false, true].map(|running| (kind, running)));
    cases.flat_map(|(kind, running)| Load::ALL.iter().map(move |load| one(kind, running, load, runs))).collect()
}

fn one(
    &Kind { key, name, from_start, running: while_running }: &Kind,
    running: bool,
    load: &Load,
    runs: u32,
) -> Result<Defect, Trouble> {
    let expected = if running { while_running } else { from_start };
    let at_s = if running { RUNNING_S } else { 0.0 };
    let own = [format!("duration_s={DURATION_S}"), format!("fault.0.kind={key}"), format!("fault.0.at_s={at_s:?}")];
    let sets: Vec<String> = load.sets.iter().map(|&set| set.to_owned()).chain(own).collect();
    let called = || format!("{name}, Q {}", load.q);
    let command = super::cases::command("lock-cold", &sets);
    let loaded = super::cases::load_many("lock-cold", &sets, runs).map_err(|error| Trouble::Scene(called(), error))?;
    let study = study::run(&loaded, study::Options::default()).map_err(|error| Trouble::Empty(called(), error))?;
    let all = study.monte_carlo().map(|runs| runs.runs.as_slice()).unwrap_or_default();
    let found = all.iter().map(|run| run.metrics.get("fault_code").unwrap_or_default() as u8).collect();
    let claims = |run: &&OneRun| ["false_locks", "undetected_losses"].iter().any(|name| run.metrics.get(name) == Some(1.0));
    let unnoticed = all.iter().filter(claims).count();
    let latencies: Option<Vec<f64>> = all.iter().map(|run| run.metrics.get("fault_latency_us")).collect();
    let latest_ms = latencies.map(|us| 1e-3 * us.into_iter().fold(0.0, f64::max));
    Ok(Defect { name, q: load.q, running, expected, found, latest_ms, unnoticed, command })
}
