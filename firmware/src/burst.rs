//! The ON/OFF envelope: when the drive is let through, to the sample, and how it gets there.
//!
//! A gate (scheduled, or ordered) is followed by a ramp that moves one step a sample while it is open and back while it
//! is closed, so that an edge may be interrupted at any time. `envelope = (1 - cos(pi ramp)) / 2`, or the ramp itself
//! where it has a single step (hard edge).

use heapless::Vec;

use crate::block::{Gate, MAX_BLOCK_SAMPLES};
use crate::config::{Burst as Config, Edge, MAX_WINDOWS, Schedule as ScheduleConfig};
use crate::error::{Error, in_range};
use crate::shape::sine;

/// The longest time a schedule can name, s (three years).
const LONGEST_S: f64 = 1e8;

/// The gate's schedule, in samples.
#[derive(Clone, Debug)]
enum Schedule {
    Continuous,
    Windows(Vec<(u64, u64), MAX_WINDOWS>),
    Periodic { period: u64, on: u64 },
}

impl Schedule {
    fn build(config: &ScheduleConfig, sample_hz: f64) -> Result<Self, Error> {
        let samples =
            |parameter, seconds| in_range(parameter, seconds, 0.0, LONGEST_S).map(|s| libm::round(s * sample_hz) as u64);
        Ok(match config {
            ScheduleConfig::Continuous => Schedule::Continuous,
            ScheduleConfig::Windows(windows) => {
                let windows = windows
                    .iter()
                    .map(|&(on, off)| Ok((samples("burst.on_s", on)?, samples("burst.off_s", off)?)))
                    .collect::<Result<Vec<_, MAX_WINDOWS>, Error>>()?;
                let in_order = windows.iter().all(|w| w.0 < w.1) && windows.windows(2).all(|pair| pair[0].1 <= pair[1].0);
                if !in_order {
                    return Err(Error::BurstWindows);
                }
                Schedule::Windows(windows)
            }
            &ScheduleConfig::Periodic { period_s, duty } => {
                in_range("burst.duty", duty, 0.0, 1.0)?;
                in_range("burst.period_s", period_s, 1.0 / sample_hz, LONGEST_S)?;
                let period = samples("burst.period_s", period_s)?;
                Schedule::Periodic { period, on: libm::round(duty * period as f64) as u64 }
            }
        })
    }

    /// Whether the gate is open at sample `now`, and for how many samples it stays so.
    fn gate(&self, now: u64) -> (bool, u64) {
        match self {
            Schedule::Continuous => (true, u64::MAX),
            Schedule::Windows(windows) => windows
                .iter()
                .find_map(|&(on, off)| match now {
                    n if n < on => Some((false, on - n)),
                    n if n < off => Some((true, off - n)),
                    _ => None,
                })
                .unwrap_or((false, u64::MAX)),
            &Schedule::Periodic { period, on } => {
                let phase = now % period;
                if phase < on { (true, on - phase) } else { (false, period - phase) }
            }
        }
    }
}

/// The envelope of one block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Envelope<'a> {
    /// The same throughout.
    Flat(f32),
    /// Sample by sample.
    Edge(&'a [f32]),
}

impl Envelope<'_> {
    /// The envelope's mean over the block.
    pub fn mean(&self) -> f32 {
        match self {
            Envelope::Flat(level) => *level,
            Envelope::Edge(levels) => levels.iter().sum::<f32>() / levels.len().max(1) as f32,
        }
    }

    /// Whether it is the same throughout.
    pub fn is_flat(&self) -> bool {
        matches!(self, Envelope::Flat(_))
    }
}

/// The envelope generator.
#[derive(Clone, Debug)]
pub struct Burst {
    schedule: Schedule,
    /// Samples an edge takes; 1 is a hard edge.
    edge: u32,
    /// Where the ramp stands, 0 (OFF) to `edge` (ON).
    ramp: u32,
    /// The envelope of the last block with an edge.
    levels: Vec<f32, MAX_BLOCK_SAMPLES>,
}

impl Burst {
    /// `frequency_hz` is the nominal drive frequency, by which soft edges are measured.
    pub fn build(config: &Config, frequency_hz: f32, sample_hz: f32) -> Result<Self, Error> {
        let edge = match config.edge {
            Edge::Hard => 1,
            Edge::Soft { cycles } => {
                in_range("burst.edge.cycles", cycles.into(), 0.5, 1e4)?;
                ((cycles * sample_hz / frequency_hz) as u32).max(1)
            }
        };
        Ok(Burst { schedule: Schedule::build(&config.schedule, sample_hz.into())?, edge, ramp: 0, levels: Vec::new() })
    }

    /// The envelope from sample `now` on, for `samples` samples.
    pub fn envelope(&mut self, gate: Gate, now: u64, samples: usize) -> Envelope<'_> {
        let (open, stays) = self.gate(gate, now);
        let settled = self.ramp == if open { self.edge } else { 0 };
        if settled && stays >= samples as u64 {
            return Envelope::Flat(if open { 1.0 } else { 0.0 });
        }
        self.levels.clear();
        for n in 0..samples.min(MAX_BLOCK_SAMPLES) as u64 {
            let level = self.step(self.gate(gate, now + n).0);
            // There is room for as many samples as a block can have.
            let _ = self.levels.push(level);
        }
        Envelope::Edge(&self.levels)
    }

    /// Opens or closes at once, without an edge: for tones outside the schedule, and for faults.
    pub fn snap(&mut self, open: bool) -> Envelope<'_> {
        self.ramp = if open { self.edge } else { 0 };
        Envelope::Flat(if open { 1.0 } else { 0.0 })
    }

    fn gate(&self, gate: Gate, now: u64) -> (bool, u64) {
        match gate {
            Gate::Scheduled => self.schedule.gate(now),
            Gate::On => (true, u64::MAX),
            Gate::Off => (false, u64::MAX),
        }
    }

    fn step(&mut self, open: bool) -> f32 {
        self.ramp = if open { (self.ramp + 1).min(self.edge) } else { self.ramp.saturating_sub(1) };
        if self.edge == 1 {
            return self.ramp as f32;
        }
        let half_turns = (u64::from(self.ramp) << 32) / u64::from(self.edge);
        0.5 - 0.5 * sine::rotation(half_turns << 31).re
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn burst(schedule: ScheduleConfig, edge: Edge) -> Burst {
        Burst::build(&Config { schedule, edge }, 40e3, 1e6).unwrap()
    }

    fn levels(burst: &mut Burst, now: u64, samples: usize) -> Vec<f32, MAX_BLOCK_SAMPLES> {
        match burst.envelope(Gate::Scheduled, now, samples) {
            Envelope::Flat(level) => core::iter::repeat_n(level, samples).collect(),
            Envelope::Edge(levels) => levels.iter().copied().collect(),
        }
    }

    #[test]
    fn hard_window_opens_and_closes_at_the_sample() {
        let windows = [(10e-6, 20e-6)].into_iter().collect();
        let got = levels(&mut burst(ScheduleConfig::Windows(windows), Edge::Hard), 0, 32);
        let on = |n: usize| (10..20).contains(&n);
        assert!(got.iter().enumerate().all(|(n, &level)| level == if on(n) { 1.0 } else { 0.0 }), "{got:?}");
    }

    #[test]
    fn blocks_join_without_a_seam() {
        let windows: Vec<_, MAX_WINDOWS> = [(13e-6, 90e-6)].into_iter().collect();
        let mut whole = burst(ScheduleConfig::Windows(windows.clone()), Edge::Soft { cycles: 1.0 });
        let mut parts = whole.clone();
        let got: std::vec::Vec<f32> = (0..4).flat_map(|k| levels(&mut parts, 32 * k, 32)).collect();
        let expected: std::vec::Vec<f32> = (0..2).flat_map(|k| levels(&mut whole, 64 * k, 64)).collect();
        assert_eq!(got, expected);
    }

    #[test]
    fn soft_edge_is_a_raised_cosine() {
        let windows = [(0.0, 1.0)].into_iter().collect();
        let got = levels(&mut burst(ScheduleConfig::Windows(windows), Edge::Soft { cycles: 1.0 }), 0, 40);
        assert!((got[11] - 0.468_6).abs() < 1e-3, "{got:?}");
        assert!(got.windows(2).all(|pair| pair[1] >= pair[0]));
        assert_eq!(got[24], 1.0);
    }

    #[test]
    fn periodic_schedule_repeats() {
        let mut periodic = burst(ScheduleConfig::Periodic { period_s: 20e-6, duty: 0.25 }, Edge::Hard);
        let ones = levels(&mut periodic, 1_000_000, 60).iter().filter(|&&level| level == 1.0).count();
        assert_eq!(ones, 15);
    }

    #[test]
    fn windows_out_of_order_are_refused() {
        let windows = [(2.0, 3.0), (1.0, 1.5)].into_iter().collect();
        let config = Config { schedule: ScheduleConfig::Windows(windows), edge: Edge::Hard };
        assert_eq!(Burst::build(&config, 40e3, 1e6).unwrap_err(), Error::BurstWindows);
    }
}
