//! Many crashes of each class of occupants: pulse, belt, slack and what the seat reads are drawn anew for each. The firmware decides.

use std::sync::atomic::AtomicBool;

use super::{SCENE, Trouble};
use scene::load::load;
use sim::instruments::runs::statistics;
use sim::metrics::Metrics;
use sim::study::monte_carlo::OneRun;
use sim::study::{self, Options};

/// What varies, and between what.
pub const VARIED: &[(&str, f64, f64)] = &[
    ("rig.dring.pulse_g", 15.0, 25.0),
    ("rig.dring.belt_stiffness_n_per_m", 40e3, 120e3),
    ("rig.dring.slack_m", 0.0, 0.03),
    ("rig.dring.seat_error", -0.15, 0.15),
];

/// The classes: name and key.
const CLASSES: &[(&str, &str)] = &[("light", "5th"), ("medium", "50th"), ("heavy", "95th")];

/// A class of occupants that has crashed many times.
pub struct Class {
    /// Its name.
    pub name: &'static str,
    /// Its key.
    pub occupant: &'static str,
    /// The crashes.
    pub runs: Vec<OneRun>,
}

impl Class {
    /// How many were switched LOW.
    pub fn low(&self) -> usize {
        self.count(|metrics| metrics.get("switched") == Some(1.0))
    }

    /// How many stayed HIGH.
    pub fn high(&self) -> usize {
        self.count(|metrics| metrics.get("switched") == Some(0.0))
    }

    /// How many ended in a fault.
    pub fn faulted(&self) -> usize {
        self.count(|metrics| metrics.get("fault_code") != Some(0.0))
    }

    fn count(&self, holds: impl Fn(&Metrics) -> bool) -> usize {
        self.runs.iter().filter(|run| holds(&run.metrics)).count()
    }

    /// The value of a metric that this part of the runs does not exceed.
    pub fn percentile(&self, metric: &str, part: f64) -> f64 {
        let mut values: Vec<f64> = self.runs.iter().filter_map(|run| run.metrics.get(metric)).collect();
        values.sort_by(f64::total_cmp);
        statistics::percentile(&values, part)
    }
}

/// The changes that make the scene one of many crashes.
fn changes(occupant: &str, runs: u32) -> Vec<String> {
    let varied = VARIED.iter().enumerate().flat_map(|(n, (key, from, to))| {
        [format!("vary.{n}.key={key}"), format!("vary.{n}.from={from:?}"), format!("vary.{n}.to={to:?}")]
    });
    [format!("runs={runs}"), format!("rig.dring.occupant={occupant}")].into_iter().chain(varied).collect()
}

/// Runs all classes.
pub fn conduct(runs: u32, stop: &AtomicBool) -> Result<Vec<Class>, Trouble> {
    let one = |&(name, occupant): &(&'static str, &'static str)| {
        let loaded = load(SCENE, &changes(occupant, runs)).map_err(|error| Trouble::Scene(name.to_owned(), error))?;
        let study = study::run(&loaded, Options { stop: Some(stop), ..Options::default() })
            .map_err(|error| Trouble::Many(name, error))?;
        let runs = study.monte_carlo().map_or_else(Vec::new, |many| many.runs.clone());
        Ok(Class { name, occupant, runs })
    };
    CLASSES.iter().map(one).collect()
}

/// How to run a class by itself.
pub fn command(occupant: &str, runs: u32) -> String {
    let sets: String = changes(occupant, runs).iter().map(|set| format!(" --set {set}")).collect();
    format!("sim-host run {SCENE}{sets}")
}
