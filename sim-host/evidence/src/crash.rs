//! The crash: the suite `crash.toml`, in which the firmware decides, and studies of the plant
//! alone.
//!
//! ```text
//! crash.toml   single crashes, and a thousand of each class     --+
//! scheduled    the switch acts at given times                   --+--> tables: docs/evidence/crash.md, report
//! mass         mass from force and payout, by least squares     --+
//! wrap         friction along the wrap of the D-ring, by the direction of its vibration --> tables: docs/evidence/dring.md, by its test
//! ```
//!
//! All of it is simulated (SIL), with assumed people in an assumed belt.

pub mod mass;
pub mod scheduled;
mod table;

#[cfg(test)]
mod tests;
#[cfg(test)]
mod wrap;

use crate::evidence::{Error, Evidence, Options, built_in};
use plant::dring::Bench;
use scene::load::load;
use sim::study::StudyError;

/// The text of the suite.
pub(crate) const SUITE: &str = include_str!("../suites/crash.toml");

/// The scene of all studies.
const SCENE: &str = "dring-crash";
/// Number of crashes from which the mass is estimated, full and quick.
const CRASHES: [u32; 2] = [4000, 500];

/// Runs the suite and both studies.
pub fn run(options: &mut Options) -> Result<Evidence, Error> {
    let crashes = CRASHES[usize::from(options.quick)];
    built_in(("crash", SUITE), options, |_, report| {
        report.tables.push(table::scheduled(&scheduled::run()?));
        report.tables.push(table::mass(&mass::run(crashes)?));
        Ok(())
    })
}

/// Returns the plant of the scene, and the duration of a switching edge, s.
fn plant(sets: &[String]) -> Result<(Bench, f64), Error> {
    let loaded = load(SCENE, &[sets, &["rig.dring.at_s=0.001".to_owned()]].concat())?;
    let dring = loaded.scene.driven().and_then(|scene| scene.dring()).ok_or(StudyError::Incomplete)?;
    Ok((Bench::of(dring), 1e-3 * dring.edge_ms))
}
