//! The weld guard, measured: how soon the drive is OFF when a belt stops, slows, or its encoder fails; what a belt gets meanwhile; and how
//! often a belt that moves is taken for one that does not.
//!
//! ```text
//! belt motion --> encoder --------> firmware: belt, weld guard --> drive, two blocks later
//!      \--> mean friction --> force channel ---/                    |
//!                 ^---------------- tip velocity <------------------/
//! ```
//!
//! All of it at block rate: the carrier is averaged over ([`friction`]), so that an hour of belt takes seconds. The scenes `belt-stop*` run
//! the same through the whole chain, and a test holds the two against each other.

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
use crate::evidence::{Error, Evidence, Options};
use report::Report;
use sim::study::monte_carlo::statistics::{Spread, spread_of};

/// Runs of each event, seconds of belt for the one that must not trip at all, and for each of the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Runs {
    /// Runs of each event.
    pub runs: u32,
    /// Seconds of belt for the one that must not trip at all.
    pub seconds: u32,
    /// Seconds for each of the others.
    pub other_seconds: u32,
}

impl Runs {
    /// What the documentation states.
    pub const FULL: Self = Runs { runs: 1000, seconds: 3000, other_seconds: 300 };
    /// Enough to see that nothing has become worse.
    pub const QUICK: Self = Runs { runs: 60, seconds: 10, other_seconds: 2 };
}

/// Results of many runs of one event.
#[derive(Clone, Debug)]
pub struct Stopped {
    /// Event of the runs.
    pub event: &'static Event,
    /// Number of runs of the event.
    pub runs: u32,
    /// Runs in which the drive went on.
    pub missed: u32,
    /// From the event to the first block without drive, ms.
    pub off_ms: Spread,
    /// Energy from the event to the first block without drive, J.
    pub exposure_j: Spread,
    /// From the first block without drive to 5 % of the tip velocity, ms.
    pub ring_down_ms: Spread,
    /// What the runs have ended in: fault numbers, zero where the drive was muted and not yet a fault.
    pub ends: Vec<u8>,
}

impl Stopped {
    /// Whether every run was noticed in time.
    pub fn holds(&self) -> bool {
        self.missed == 0 && self.event.at_most_ms.is_none_or(|most| self.off_ms.max <= most)
    }
}

/// A fault of the encoder that nothing but energy or time can end.
#[derive(Clone, Debug)]
pub struct Undetected {
    /// Fault of the encoder.
    pub encoder: &'static EncoderFault,
    /// How long it lasted, s; none if it still does after a minute.
    pub undetected_s: Option<f64>,
    /// The fault that ended it.
    pub fault: u8,
    /// Energy into the millimetre that stood, J.
    pub exposure_j: f64,
}

/// How often a moving belt was taken for a standing one.
#[derive(Clone, Debug)]
pub struct Passed {
    /// Belt that moves in the runs.
    pub belt: &'static MovingBelt,
    /// Simulated time of the belt, s.
    pub seconds: f64,
    /// Mutes and faults; a fault ends a part.
    pub trips: u32,
    /// Mutes a second that Rice's formula expects of the belt's speed alone.
    pub expected_per_s: f64,
}

impl Passed {
    /// Whether what must not trip has not.
    pub fn holds(&self) -> bool {
        !self.belt.must_pass || self.trips == 0
    }
}

/// Runs all events, faults and belts.
pub fn evidence(options: &mut Options) -> Result<Evidence, Error> {
    let runs = if options.quick { Runs::QUICK } else { Runs::FULL };
    let plan = Plan::of_the_scene()?;
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
    let tables = table::tables(plan.power_w, &stopped, &undetected, &passed);
    Ok(Evidence {
        report: Report {
            title: "Weld guard: a belt that stops or slows, or whose encoder fails".into(),
            subtitle: "Simulated: the firmware's guard at block rate, without the carrier".into(),
            tables: tables.clone(),
            ..Report::default()
        },
        docs: tables,
        missed,
        ..Evidence::default()
    })
}

/// Runs one event so often, each time with another speed, phase, ripple and moment.
pub fn stop(plan: &Plan, event: &'static Event, runs: u32) -> Result<Stopped, Error> {
    let ended = (0..runs).into_par_iter().map(|run| Rig::new(plan, &event.build(run))?.stop(event, run));
    let ended = ended.collect::<Result<Vec<_>, firmware::seam::error::Error>>()?;
    let mut ends: Vec<u8> = ended.iter().map(|end| end.fault).collect();
    ends.sort_unstable();
    ends.dedup();
    let numbers = |value: fn(&rig::Ended) -> Option<f64>| spread_of(ended.iter().filter_map(value).collect());
    Ok(Stopped {
        event,
        runs,
        missed: ended.iter().filter(|end| end.off_ms.is_none()).count() as u32,
        off_ms: numbers(|end| end.off_ms),
        exposure_j: numbers(|end| Some(end.exposure_j)),
        ring_down_ms: numbers(|end| end.ring_down_ms),
        ends,
    })
}

/// Lets the encoder of a standing belt count until that is ended.
pub fn run_encoder_fault(plan: &Plan, encoder: &'static EncoderFault) -> Result<Undetected, Error> {
    let (undetected_s, fault, exposure_j) = Rig::new(plan, &encoder.build())?.run_encoder_fault(encoder)?;
    Ok(Undetected { encoder, undetected_s, fault, exposure_j })
}

/// Lets a belt pass for so long, in parts of at most 50 s.
pub fn pass(plan: &Plan, belt: &'static MovingBelt, seconds: u32) -> Result<Passed, Error> {
    const PART_S: u32 = 50;
    let parts = seconds.div_ceil(PART_S);
    let part_s = f64::from(seconds) / f64::from(parts);
    let trips = (0..parts).into_par_iter().map(|part| Ok(Rig::new(plan, &belt.build(part))?.pass(part_s)));
    let trips = trips.collect::<Result<Vec<(u32, f64)>, firmware::seam::error::Error>>()?;
    let (trips, seconds) = trips.iter().fold((0, 0.0), |sum, part| (sum.0 + part.0, sum.1 + part.1));
    Ok(Passed { belt, seconds, trips, expected_per_s: belt.expected_per_s() })
}
