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

use self::cases::{EVENTS, Event, LIES, Lie, Passage, RIPPLES};
use self::rig::{Plan, Rig};
use scene::load::LoadError;
use sim::instruments::runs::statistics::{Spread, spread_of};

/// How much is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Extent {
    /// Runs of each event.
    pub runs: u32,
    /// Seconds of belt for the passage that must not trip at all.
    pub seconds: u32,
    /// Seconds for each of the others.
    pub other_seconds: u32,
}

impl Extent {
    /// What the documentation states.
    pub const FULL: Self = Extent { runs: 1000, seconds: 3000, other_seconds: 300 };
    /// Enough to see that nothing has become worse.
    pub const QUICK: Self = Extent { runs: 60, seconds: 10, other_seconds: 2 };
}

/// What came of many runs of one event.
#[derive(Clone, Debug)]
pub struct Stopped {
    /// Which.
    pub event: &'static Event,
    /// Runs.
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

/// A lie of the encoder that nothing but energy or time can end.
#[derive(Clone, Debug)]
pub struct Believed {
    /// Which.
    pub lie: &'static Lie,
    /// How long it was believed, s; none if it still is after a minute.
    pub believed_s: Option<f64>,
    /// The fault that ended it.
    pub fault: u8,
    /// Energy into the millimetre that stood, J.
    pub exposure_j: f64,
}

/// How often a moving belt was taken for a standing one.
#[derive(Clone, Debug)]
pub struct Passed {
    /// Which.
    pub passage: &'static Passage,
    /// Seconds of belt.
    pub seconds: f64,
    /// Mutes and faults; a fault ends a part.
    pub trips: u32,
    /// Mutes a second that Rice's formula expects of the belt's speed alone.
    pub expected_per_s: f64,
}

impl Passed {
    /// Whether what must not trip has not.
    pub fn holds(&self) -> bool {
        !self.passage.must_pass || self.trips == 0
    }
}

/// Everything that was run.
pub struct Campaign {
    /// The drive's power into the motional branch, W.
    pub power_w: f64,
    /// Events.
    pub stopped: Vec<Stopped>,
    /// Lies.
    pub believed: Vec<Believed>,
    /// Passages.
    pub passed: Vec<Passed>,
}

impl Campaign {
    /// Whether every target is reached.
    pub fn holds(&self) -> bool {
        self.stopped.iter().all(Stopped::holds) && self.passed.iter().all(Passed::holds)
    }
}

/// Why there is no campaign.
#[derive(Debug, thiserror::Error)]
pub enum Trouble {
    /// The scene that the campaign takes its stack and contact from is not valid.
    #[error(transparent)]
    Scene(#[from] LoadError),
    /// The firmware refuses a case.
    #[error("the firmware refuses a case: {0}")]
    Config(#[from] firmware::seam::error::Error),
}

/// Runs everything; `progress` is told what comes next.
pub fn conduct(extent: Extent, progress: &mut dyn FnMut(&str)) -> Result<Campaign, Trouble> {
    let plan = Plan::of_the_scene()?;
    let stopped = EVENTS.iter().map(|event| {
        progress(event.name);
        stop(&plan, event, extent.runs)
    });
    let stopped = stopped.collect::<Result<Vec<_>, _>>()?;
    progress("lies");
    let believed = LIES.iter().map(|lie| believe(&plan, lie)).collect::<Result<Vec<_>, _>>()?;
    let passed = RIPPLES.iter().map(|passage| {
        progress(&passage.name());
        pass(&plan, passage, if passage.must_pass { extent.seconds } else { extent.other_seconds })
    });
    Ok(Campaign { power_w: plan.power_w, stopped, believed, passed: passed.collect::<Result<_, _>>()? })
}

/// Runs one event so often, each time with another speed, phase, ripple and moment.
pub fn stop(plan: &Plan, event: &'static Event, runs: u32) -> Result<Stopped, Trouble> {
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

/// Tells one lie until it is ended.
pub fn believe(plan: &Plan, lie: &'static Lie) -> Result<Believed, Trouble> {
    let (believed_s, fault, exposure_j) = Rig::new(plan, &lie.build())?.believe(lie)?;
    Ok(Believed { lie, believed_s, fault, exposure_j })
}

/// Lets a belt pass for so long, in parts of at most 50 s.
pub fn pass(plan: &Plan, passage: &'static Passage, seconds: u32) -> Result<Passed, Trouble> {
    const PART_S: u32 = 50;
    let parts = seconds.div_ceil(PART_S);
    let part_s = f64::from(seconds) / f64::from(parts);
    let trips = (0..parts).into_par_iter().map(|part| Ok(Rig::new(plan, &passage.build(part))?.pass(part_s)));
    let trips = trips.collect::<Result<Vec<(u32, f64)>, firmware::seam::error::Error>>()?;
    let (trips, seconds) = trips.iter().fold((0, 0.0), |sum, part| (sum.0 + part.0, sum.1 + part.1));
    Ok(Passed { passage, seconds, trips, expected_per_s: passage.expected_per_s() })
}
