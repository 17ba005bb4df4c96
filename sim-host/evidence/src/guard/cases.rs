//! What happens to a belt, what its encoder says of it, and what must come of it.

use super::build::{self, Build};

/// Speed below which counts come later than the interlock waits, m/s.
pub fn slowest_m_per_s(counts_per_mm: f64, stop_ms: f64) -> f64 {
    1.0 / (1e3 * counts_per_mm * 1e-3 * stop_ms)
}

/// What the interlock waits for, and an encoder that is good enough, and the force channel's bandwidth.
pub const STOP_MS: f64 = 2.4;
const COUNTS_PER_MM: f64 = 100.0;
const FORCE_HZ: f64 = 500.0;
/// The drive is to be OFF so soon, ms.
const TARGET_MS: f64 = 5.0;

/// Events of belt and encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// The belt comes to a stand, at once or over up to 20 ms.
    Stops,
    /// The belt slows, within 5 ms, to anything up to seven tenths of the slowest that the interlock bears.
    Slows,
    /// The encoder stays at its last count.
    Sticks,
    /// A line of the encoder breaks.
    Breaks,
    /// The belt stops, and the encoder goes on counting at its pace.
    Lies,
}

/// An event, and what must come of it.
#[derive(Clone, Copy, Debug)]
pub struct Event {
    /// Name of the event, in tables.
    pub name: &'static str,
    /// Event of belt or encoder.
    pub what: What,
    /// Setting `limits.belt_stop_ms` of the controller.
    pub stop_ms: f64,
    /// Bandwidth of the force channel, Hz, if there is one.
    pub force_hz: Option<f64>,
    /// The drive must be OFF within so long, ms; none where the time is only reported.
    pub at_most_ms: Option<f64>,
}

const fn event(name: &'static str, what: What) -> Event {
    Event { name, what, stop_ms: STOP_MS, force_hz: Some(FORCE_HZ), at_most_ms: Some(TARGET_MS) }
}

/// All events that are run.
pub const EVENTS: &[Event] = &[
    event("stop", What::Stops),
    event("slow", What::Slows),
    event("stuck", What::Sticks),
    event("lost", What::Breaks),
    Event { at_most_ms: None, ..event("lies, force channel of 500 Hz", What::Lies) },
    Event { at_most_ms: None, force_hz: Some(2000.0), ..event("lies, 2 kHz", What::Lies) },
    Event { at_most_ms: None, force_hz: Some(80.0), ..event("lies, 80 Hz", What::Lies) },
    Event { force_hz: None, ..event("stop, encoder alone", What::Stops) },
    Event { force_hz: None, ..event("slow, encoder alone", What::Slows) },
    Event { at_most_ms: None, force_hz: None, stop_ms: 4.0, ..event("stop, encoder alone, 4 ms", What::Stops) },
    Event { at_most_ms: None, force_hz: None, stop_ms: 4.0, ..event("slow, encoder alone, 4 ms", What::Slows) },
];

impl Event {
    /// What this run is built like: 10 to 70 mm/s with a ripple of 10 %.
    pub fn build(&self, run: u32) -> Build {
        let seed = u64::from(run) + 1;
        let part = |salt: u64| build::part(seed, salt);
        Build {
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

/// An encoder of a standing belt that goes on counting, without a force channel to detect it.
#[derive(Clone, Copy, Debug)]
pub struct EncoderFault {
    /// The pace at which the encoder counts while the belt stands, m/s.
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
    /// The rig with the limits that are to catch the fault.
    pub fn build(&self) -> Build {
        Build {
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

/// A belt that moves, and must not be taken for one that does not.
#[derive(Clone, Copy, Debug)]
pub struct MovingBelt {
    /// Counts of its encoder, 1/mm.
    pub counts_per_mm: f64,
    /// Setting `limits.belt_stop_ms` of the controller.
    pub stop_ms: f64,
    /// Speed of the belt, m/s.
    pub speed_m_per_s: f64,
    /// Ripple, rms as a part of it, at 10 Hz.
    pub ripple_rms: f64,
    /// Whether the belt must not trip at all.
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
    /// Speed, encoder and ripple of the belt, in words.
    pub fn name(&self) -> String {
        let MovingBelt { counts_per_mm, stop_ms, speed_m_per_s, ripple_rms, .. } = self;
        format!("{counts_per_mm} counts/mm, {stop_ms} ms, {} mm/s, {} %", 1e3 * speed_m_per_s, 100.0 * ripple_rms)
    }

    /// What a part of it is built like.
    pub fn build(&self, part: u32) -> Build {
        Build {
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

    /// How often a second the speed sinks below what the interlock bears (Rice 1944): `f exp(-L^2 / 2)`, `L` deviations down.
    pub fn expected_per_s(&self) -> f64 {
        let slowest = slowest_m_per_s(self.counts_per_mm, self.stop_ms);
        let level = (1.0 - slowest / self.speed_m_per_s) / self.ripple_rms;
        if level > 0.0 { RIPPLE_HZ * libm::exp(-0.5 * level * level) } else { f64::INFINITY }
    }
}
