//! Events of the belt and its encoder, and the required response.

use super::build::{self, RunParameters};

/// Returns the speed below which the time between counts exceeds the interlock's timeout, m/s.
pub fn slowest_m_per_s(counts_per_mm: f64, stop_ms: f64) -> f64 {
    1.0 / (1e3 * counts_per_mm * 1e-3 * stop_ms)
}

/// Timeout of the interlock, ms.
pub const STOP_MS: f64 = 2.4;
/// Resolution of a sufficient encoder, 1/mm.
const COUNTS_PER_MM: f64 = 100.0;
/// Bandwidth of the force channel, Hz.
const FORCE_HZ: f64 = 500.0;
/// Time within which the drive must be OFF, ms.
const MAX_OFF_MS: f64 = 5.0;

/// Kind of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EventKind {
    /// The belt stops, at once or within up to 20 ms.
    Stops,
    /// The belt slows, within 5 ms, to at most seven tenths of the slowest speed that the interlock
    /// allows.
    Slows,
    /// The encoder stays at its last count.
    Sticks,
    /// A line of the encoder breaks.
    Breaks,
    /// The belt stops, but the encoder continues to count at its pace.
    Lies,
}

/// An event, with the required response.
#[derive(Clone, Copy, Debug)]
pub struct Event {
    /// Name in tables.
    pub name: &'static str,
    /// Kind of the event.
    pub what: EventKind,
    /// Setting `limits.belt_stop_ms` of the controller.
    pub stop_ms: f64,
    /// Bandwidth of the force channel, Hz, if there is one.
    pub force_hz: Option<f64>,
    /// Time within which the drive must be OFF, ms; `None` if the time is only reported.
    pub at_most_ms: Option<f64>,
}

const fn event(name: &'static str, what: EventKind) -> Event {
    Event { name, what, stop_ms: STOP_MS, force_hz: Some(FORCE_HZ), at_most_ms: Some(MAX_OFF_MS) }
}

/// All events that are run.
pub const EVENTS: &[Event] = &[
    event("stop", EventKind::Stops),
    event("slow", EventKind::Slows),
    event("stuck", EventKind::Sticks),
    event("lost", EventKind::Breaks),
    Event { at_most_ms: None, ..event("lies, force channel of 500 Hz", EventKind::Lies) },
    Event { at_most_ms: None, force_hz: Some(2000.0), ..event("lies, 2 kHz", EventKind::Lies) },
    Event { at_most_ms: None, force_hz: Some(80.0), ..event("lies, 80 Hz", EventKind::Lies) },
    Event { force_hz: None, ..event("stop, encoder alone", EventKind::Stops) },
    Event { force_hz: None, ..event("slow, encoder alone", EventKind::Slows) },
    Event { at_most_ms: None, force_hz: None, stop_ms: 4.0, ..event("stop, encoder alone, 4 ms", EventKind::Stops) },
    Event { at_most_ms: None, force_hz: None, stop_ms: 4.0, ..event("slow, encoder alone, 4 ms", EventKind::Slows) },
];

impl Event {
    /// Returns the parameters of a run: 10 to 70 mm/s with a ripple of 10 %.
    pub fn build(&self, run: u32) -> RunParameters {
        let seed = u64::from(run) + 1;
        let part = |salt: u64| build::part(seed, salt);
        RunParameters {
            speed_m_per_s: 0.01 + 0.06 * part(1),
            ripple_rms: 0.1,
            counts_per_mm: COUNTS_PER_MM,
            phase: part(2),
            stop_ms: self.stop_ms,
            force_hz: self.force_hz,
            energy_j_per_m: None,
            on_time_s: None,
            seed,
        }
    }
}

/// An encoder of a stopped belt that continues to count, without a force channel to detect it.
#[derive(Clone, Copy, Debug)]
pub struct EncoderFault {
    /// Speed at which the encoder counts while the belt stands still, m/s.
    pub pace_m_per_s: f64,
    /// Setting `limits.energy_j_per_m` of the controller.
    pub energy_j_per_m: Option<f64>,
    /// Setting `limits.on_time_s` of the controller.
    pub on_time_s: Option<f64>,
}

/// All faults of the encoder that are run.
pub const ENCODER_FAULTS: &[EncoderFault] = &[
    EncoderFault { pace_m_per_s: 0.005, energy_j_per_m: Some(100.0), on_time_s: None },
    EncoderFault { pace_m_per_s: 0.01, energy_j_per_m: Some(100.0), on_time_s: None },
    EncoderFault { pace_m_per_s: 0.038, energy_j_per_m: Some(100.0), on_time_s: None },
    EncoderFault { pace_m_per_s: 0.038, energy_j_per_m: Some(100.0), on_time_s: Some(2.5) },
    EncoderFault { pace_m_per_s: 0.01, energy_j_per_m: Some(40.0), on_time_s: None },
];

impl EncoderFault {
    /// Returns the parameters, with the limits that are to end the fault.
    pub fn build(&self) -> RunParameters {
        RunParameters {
            speed_m_per_s: 0.0,
            ripple_rms: 0.0,
            counts_per_mm: COUNTS_PER_MM,
            phase: 0.5,
            stop_ms: STOP_MS,
            force_hz: None,
            energy_j_per_m: self.energy_j_per_m,
            on_time_s: self.on_time_s,
            seed: 1,
        }
    }
}

/// A moving belt, which should not be mistaken for a stopped one.
#[derive(Clone, Copy, Debug)]
pub struct MovingBelt {
    /// Resolution of its encoder, 1/mm.
    pub counts_per_mm: f64,
    /// Setting `limits.belt_stop_ms` of the controller.
    pub stop_ms: f64,
    /// Speed of the belt, m/s.
    pub speed_m_per_s: f64,
    /// Ripple of the speed at 10 Hz, rms, relative to the speed.
    pub ripple_rms: f64,
    /// `true` if the belt must not trip at all.
    pub must_pass: bool,
}

/// Frequency of the ripple, Hz.
pub const RIPPLE_HZ: f64 = 10.0;

const fn belt(counts_per_mm: f64, stop_ms: f64, speed_m_per_s: f64, ripple_rms: f64) -> MovingBelt {
    MovingBelt { counts_per_mm, stop_ms, speed_m_per_s, ripple_rms, must_pass: false }
}

/// All moving belts that are run.
pub const MOVING_BELTS: &[MovingBelt] = &[
    MovingBelt { must_pass: true, ..belt(100.0, STOP_MS, 0.01, 0.1) },
    belt(100.0, STOP_MS, 0.01, 0.125),
    belt(100.0, STOP_MS, 0.01, 0.15),
    belt(100.0, STOP_MS, 0.01, 0.2),
    belt(100.0, STOP_MS, 0.025, 0.2),
    belt(100.0, STOP_MS, 0.025, 0.25),
    belt(100.0, STOP_MS, 0.025, 0.3),
    belt(100.0, 4.0, 0.01, 0.15),
    belt(100.0, 4.0, 0.01, 0.2),
    belt(20.0, STOP_MS, 0.025, 0.1),
    belt(20.0, STOP_MS, 0.038, 0.1),
    belt(20.0, STOP_MS, 0.038, 0.2),
    belt(20.0, 4.0, 0.025, 0.1),
    belt(20.0, 4.0, 0.01, 0.0),
];

impl MovingBelt {
    /// Describes encoder, interlock, speed and ripple.
    pub fn name(&self) -> String {
        let MovingBelt { counts_per_mm, stop_ms, speed_m_per_s, ripple_rms, .. } = self;
        format!("{counts_per_mm} counts/mm, {stop_ms} ms, {} mm/s, {} %", 1e3 * speed_m_per_s, 100.0 * ripple_rms)
    }

    /// Returns the parameters of a part of the simulation.
    pub fn build(&self, part: u32) -> RunParameters {
        RunParameters {
            speed_m_per_s: self.speed_m_per_s,
            ripple_rms: self.ripple_rms,
            counts_per_mm: self.counts_per_mm,
            phase: 0.5,
            stop_ms: self.stop_ms,
            force_hz: Some(FORCE_HZ),
            energy_j_per_m: None,
            on_time_s: None,
            seed: u64::from(part) + 1,
        }
    }

    /// Returns the rate at which the speed falls below the slowest that the interlock allows, 1/s
    /// (Rice 1944): `f exp(-L^2 / 2)`, with the margin `L` in standard deviations.
    pub fn expected_per_s(&self) -> f64 {
        let slowest = slowest_m_per_s(self.counts_per_mm, self.stop_ms);
        let level = (1.0 - slowest / self.speed_m_per_s) / self.ripple_rms;
        if level > 0.0 { RIPPLE_HZ * libm::exp(-0.5 * level * level) } else { f64::INFINITY }
    }
}
