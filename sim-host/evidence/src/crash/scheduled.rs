//! The switch thrown at stated moments, on the plant alone: what the rule of the controller is for. An ideal switch with edges of 3 ms.

use super::plant;
use crate::evidence::Error;
use plant::dring::Bench;
use plant::dring::motion::{Extremes, Motion};

/// Block by block, as the controller would, s.
const BLOCK_S: f64 = 32e-6;
/// How long a crash is followed, s.
const LENGTH_S: f64 = 0.16;

/// Who sits there, and when LOW begins and ends, ms.
const TIMES: &[(&str, Option<f64>, Option<f64>)] = &[
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

/// A crash with the switch thrown at stated moments.
pub struct Scheduled {
    /// Percentile of the occupant.
    pub occupant: &'static str,
    /// When LOW begins, ms since the crash does.
    pub low_ms: Option<f64>,
    /// When HIGH comes back, ms.
    pub high_ms: Option<f64>,
    /// Results of the crash.
    pub extremes: Extremes,
    /// What the passive belt makes of it.
    pub passive: Extremes,
}

/// A crash on the bench, followed to `length_s` after its beginning. `low` says whether the drive is ON, by the time since then, s; `see` looks
/// at each block's end.
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

/// Runs all of them.
pub fn run() -> Result<Vec<Scheduled>, Error> {
    TIMES.iter().map(|&(occupant, low_ms, high_ms)| one(occupant, low_ms, high_ms)).collect()
}

fn one(occupant: &'static str, low_ms: Option<f64>, high_ms: Option<f64>) -> Result<Scheduled, Error> {
    let (bench, edge_s) = plant(&[format!("rig.dring.occupant={occupant}")])?;
    let followed = |low: &dyn Fn(f64) -> bool| crash(&bench, edge_s, LENGTH_S, low, |_, _| ()).extremes();
    let low = |since_s: f64| low_ms.is_some_and(|ms| since_s >= 1e-3 * ms) && high_ms.is_none_or(|ms| since_s < 1e-3 * ms);
    Ok(Scheduled { occupant, low_ms, high_ms, extremes: followed(&low), passive: followed(&|_| false) })
}
