//! Measures the weld guard: the time until the drive is OFF when a belt stops, slows or its encoder
//! fails, the energy into the belt until then, and the rate of false trips of a moving belt.
//!
//! ```text
//! belt motion --> encoder --------> firmware: belt, weld guard --> drive, two blocks later
//!      \--> mean friction --> force channel ---/                    |
//!                 ^---------------- tip velocity <------------------/
//! ```
//!
//! Everything runs at block rate and averages over the carrier ([`friction`]), so that an hour of
//! belt takes seconds. The scenes `belt-stop*` run the same through the whole chain, and a test
//! compares both.

pub mod build;
pub mod cases;
pub mod friction;
pub mod rig;
pub mod table;

#[cfg(test)]
mod tests;

use rayon::prelude::*;

use self::cases::{ENCODER_FAULTS, EVENTS, EncoderFault, Event, MOVING_BELTS, MovingBelt};
use self::rig::{Plan, Rig};
use crate::campaign;
use crate::evidence::{Error, Evidence, Options};
use sim::study::monte_carlo::statistics::{Spread, spread_of};

/// Numbers of runs and lengths of the simulations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Runs {
    /// Number of runs of each event.
    pub runs: u32,
    /// Simulated time of the belt that must not trip at all, s.
    pub seconds: u32,
    /// Simulated time of each other belt, s.
    pub other_seconds: u32,
}

impl Runs {
    /// Numbers for the documentation.
    pub const FULL: Self = Runs { runs: 1000, seconds: 3000, other_seconds: 300 };
    /// Numbers that are enough to detect a regression.
    pub const QUICK: Self = Runs { runs: 60, seconds: 10, other_seconds: 2 };
}

/// Results of many runs of one event.
#[derive(Clone, Debug)]
pub struct EventResult {
    /// Event of the runs.
    pub event: &'static Event,
    /// Number of runs of the event.
    pub runs: u32,
    /// Number of runs in which the drive continued.
    pub missed: u32,
    /// Time from the event to the first block without drive, ms.
    pub off_ms: Spread,
    /// Energy from the event to the first block without drive, J.
    pub exposure_j: Spread,
    /// Time from the first block without drive to 5 % of the tip velocity, ms.
    pub ring_down_ms: Spread,
    /// Fault numbers in which the runs have ended; zero if the drive was muted without a fault yet.
    pub ends: Vec<u8>,
}

impl EventResult {
    /// Returns `true` if every run was detected in time.
    pub fn holds(&self) -> bool {
        self.missed == 0 && self.event.at_most_ms.is_none_or(|most| self.off_ms.max <= most)
    }
}

/// A fault of the encoder that only the limits of energy or time can end.
#[derive(Clone, Debug)]
pub struct Undetected {
    /// Fault of the encoder.
    pub encoder: &'static EncoderFault,
    /// Time until a fault ended it, s; `None` if it lasts longer than a minute.
    pub undetected_s: Option<f64>,
    /// Number of the fault that ended it.
    pub fault: u8,
    /// Energy into the same millimetre of belt, J.
    pub exposure_j: f64,
}

/// Number of false trips of a moving belt.
#[derive(Clone, Debug)]
pub struct MovingResult {
    /// The moving belt.
    pub belt: &'static MovingBelt,
    /// Simulated time of the belt, s.
    pub seconds: f64,
    /// Number of mutes and faults; a fault ends a part.
    pub trips: u32,
    /// Mutes per second that Rice's formula expects from the belt's speed alone.
    pub expected_per_s: f64,
}

impl MovingResult {
    /// Returns `true` unless a belt has tripped that must not trip.
    pub fn holds(&self) -> bool {
        !self.belt.must_pass || self.trips == 0
    }
}

/// Runs all events, encoder faults and belts, and returns the evidence.
pub fn evidence(options: &mut Options) -> Result<Evidence, Error> {
    let runs = if options.quick { Runs::QUICK } else { Runs::FULL };
    let plan = Plan::from_scene()?;
    let stopped = EVENTS.iter().map(|event| {
        (options.progress)(event.name);
        stop(&plan, event, runs.runs)
    });
    let stopped = stopped.collect::<Result<Vec<_>, _>>()?;
    (options.progress)("encoder faults without a force channel");
    let undetected = ENCODER_FAULTS.iter().map(|encoder| run_encoder_fault(&plan, encoder)).collect::<Result<Vec<_>, _>>()?;
    let passed = MOVING_BELTS.iter().map(|belt| {
        (options.progress)(&belt.name());
        pass(&plan, belt, if belt.must_pass { runs.seconds } else { runs.other_seconds })
    });
    let passed = passed.collect::<Result<Vec<_>, _>>()?;
    let late = stopped.iter().filter(|found| !found.holds()).map(|found| found.event.name.to_owned());
    let tripped = passed.iter().filter(|found| !found.holds()).map(|found| found.belt.name());
    let missed = late.chain(tripped).collect();
    let title = "Weld guard: a belt that stops or slows, or whose encoder fails";
    let subtitle = "Simulated: the firmware's guard at block rate, without the carrier";
    let tables = table::tables(plan.power_w, &stopped, &undetected, &passed);
    Ok(campaign::evidence(title, subtitle, tables, Vec::new(), missed))
}

/// Runs one event `runs` times, each with another speed, phase, ripple and moment.
pub fn stop(plan: &Plan, event: &'static Event, runs: u32) -> Result<EventResult, Error> {
    let ended = (0..runs).into_par_iter().map(|run| Rig::new(plan, &event.build(run))?.stop(event, run));
    let ended = ended.collect::<Result<Vec<_>, firmware::seam::error::Error>>()?;
    let mut ends: Vec<u8> = ended.iter().map(|end| end.fault).collect();
    ends.sort_unstable();
    ends.dedup();
    let numbers = |value: fn(&rig::Ended) -> Option<f64>| spread_of(ended.iter().filter_map(value).collect());
    Ok(EventResult {
        event,
        runs,
        missed: ended.iter().filter(|end| end.off_ms.is_none()).count() as u32,
        off_ms: numbers(|end| end.off_ms),
        exposure_j: numbers(|end| Some(end.exposure_j)),
        ring_down_ms: numbers(|end| end.ring_down_ms),
        ends,
    })
}

/// Lets the encoder of a stopped belt count until a fault ends it.
pub fn run_encoder_fault(plan: &Plan, encoder: &'static EncoderFault) -> Result<Undetected, Error> {
    let (undetected_s, fault, exposure_j) = Rig::new(plan, &encoder.build())?.run_encoder_fault(encoder)?;
    Ok(Undetected { encoder, undetected_s, fault, exposure_j })
}

/// Moves a belt for `seconds`, in parts of at most 50 s.
pub fn pass(plan: &Plan, belt: &'static MovingBelt, seconds: u32) -> Result<MovingResult, Error> {
    const PART_S: u32 = 50;
    let parts = seconds.div_ceil(PART_S);
    let part_s = f64::from(seconds) / f64::from(parts);
    let trips = (0..parts).into_par_iter().map(|part| Ok(Rig::new(plan, &belt.build(part))?.pass(part_s)));
    let trips = trips.collect::<Result<Vec<(u32, f64)>, firmware::seam::error::Error>>()?;
    let (trips, seconds) = trips.iter().fold((0, 0.0), |sum, part| (sum.0 + part.0, sum.1 + part.1));
    Ok(MovingResult { belt, seconds, trips, expected_per_s: belt.expected_per_s() })
}
