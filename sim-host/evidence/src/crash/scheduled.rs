//! The switch thrown at given times, on the plant alone, as a guide for the rule of the controller.
//! The switch is ideal, with edges of 3 ms.

use super::plant;
use crate::evidence::Error;
use plant::dring::Bench;
use plant::dring::motion::{Extremes, Motion};

/// Length of a block of the controller, s; the drive changes only at its ends.
const BLOCK_S: f64 = 32e-6;
/// Time for which a crash is followed, s.
const LENGTH_S: f64 = 0.16;

/// Percentile of the occupant, and times at which LOW begins and ends, ms.
const OCCUPANT_TIMES_MS: &[(&str, Option<f64>, Option<f64>)] = &[
    ("5th", None, None),
    ("5th", Some(0.0), None),
    ("5th", Some(20.0), None),
    ("5th", Some(30.0), None),
    ("5th", Some(35.0), None),
    ("5th", Some(40.0), None),
    ("5th", Some(45.0), None),
    ("5th", Some(50.0), None),
    ("5th", Some(55.0), None),
    ("5th", Some(60.0), None),
    ("5th", Some(65.0), None),
    ("5th", Some(35.0), Some(50.0)),
    ("5th", Some(35.0), Some(70.0)),
    ("50th", None, None),
    ("50th", Some(35.0), None),
    ("50th", Some(35.0), Some(70.0)),
    ("95th", None, None),
    ("95th", Some(35.0), None),
];

/// A crash with the switch thrown at given times.
pub struct Scheduled {
    /// Percentile of the occupant.
    pub occupant: &'static str,
    /// Time at which LOW begins, ms after the beginning of the crash.
    pub low_ms: Option<f64>,
    /// Time at which HIGH returns, ms after the beginning of the crash.
    pub high_ms: Option<f64>,
    /// Results of the crash.
    pub extremes: Extremes,
    /// Results of the same crash with the passive belt.
    pub passive: Extremes,
}

/// Runs a crash on the bench until `length_s` after its beginning. `low` returns `true` if the
/// drive is ON at a time after the beginning, s; `see` is called at the end of each block.
pub(super) fn crash(
    bench: &Bench,
    edge_s: f64,
    length_s: f64,
    low: impl Fn(f64) -> bool,
    mut see: impl FnMut(f64, &Motion),
) -> Motion {
    let mut motion = Motion::new(bench.clone(), 1);
    let begins = bench.pulse.at_s;
    for block in 0..((begins + length_s) / BLOCK_S).ceil() as u64 {
        let (from_s, to_s) = (block as f64 * BLOCK_S, (block + 1) as f64 * BLOCK_S);
        motion.drive(if low(from_s - begins) { 1.0 } else { -1.0 } / edge_s);
        motion.advance_to(to_s);
        see(to_s - begins, &motion);
    }
    motion
}

/// Runs the crashes of all times.
pub fn run() -> Result<Vec<Scheduled>, Error> {
    OCCUPANT_TIMES_MS.iter().map(|&(occupant, low_ms, high_ms)| one(occupant, low_ms, high_ms)).collect()
}

fn one(occupant: &'static str, low_ms: Option<f64>, high_ms: Option<f64>) -> Result<Scheduled, Error> {
    let (bench, edge_s) = plant(&[format!("rig.dring.occupant={occupant}")])?;
    let followed = |low: &dyn Fn(f64) -> bool| crash(&bench, edge_s, LENGTH_S, low, |_, _| ()).extremes();
    let low = |since_s: f64| low_ms.is_some_and(|ms| since_s >= 1e-3 * ms) && high_ms.is_none_or(|ms| since_s < 1e-3 * ms);
    Ok(Scheduled { occupant, low_ms, high_ms, extremes: followed(&low), passive: followed(&|_| false) })
}
