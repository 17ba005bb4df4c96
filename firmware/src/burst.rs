//! The ON/OFF envelope: when the drive is let through, to the half cycle, and how it gets there.
//!
//! A gate (scheduled, or ordered) says when. What follows it depends on the edge:
//!
//! * hard: the burst begins at the next passage of the first lane through zero, in either direction, and ends at the first passage in the
//!   same direction after the gate has closed: it lasts a whole number of periods, so that its volt-seconds cancel (to the sample; what
//!   sampling and rounding leave, the [shaper](crate::shaper) pays back).
//! * soft: the envelope follows the gate along a ramp, which an opposite order turns round: `envelope = (1 - cos(pi ramp)) / 2`.
//!
//! A burst that is ended by a brake goes on for some half cycles against its own phase, so that what it has rung up is rung down.

use core::ops::Range;

use heapless::Vec;

use crate::block::{Gate, MAX_BLOCK_SAMPLES};
use crate::config::{Burst as Config, Edge, MAX_WINDOWS, Schedule as ScheduleConfig};
use crate::error::{Error, in_range};
use crate::nco::Stretch;
use crate::shape::sine;

/// The longest time a schedule can name, s (three years).
const LONGEST_S: f64 = 1e8;

/// The gate's schedule, in samples.
#[derive(Clone, Debug)]
enum Schedule {
    Continuous,
    Windows(Vec<(u64, u64), MAX_WINDOWS>),
    Periodic {
        period: u64,
        on: u64,
        /// A beginning of a period, the last that was needed.
        begins: u64,
    },
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
                Schedule::Periodic { period, on: libm::round(duty * period as f64) as u64, begins: 0 }
            }
        })
    }

    /// Whether the gate is open at sample `now`, and for how many samples it stays so.
    fn gate(&mut self, now: u64) -> (bool, u64) {
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
            Schedule::Periodic { period, on, begins } => {
                // Mostly the same period, or the next: a division of 64 bits takes longer than the rest.
                let mut phase = now.wrapping_sub(*begins);
                if phase >= *period {
                    phase = if phase < 2 * *period { phase - *period } else { now % *period };
                    *begins = now - phase;
                }
                if phase < *on { (true, *on - phase) } else { (false, *period - phase) }
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

/// How a ringing resonance is stopped: by whole half cycles of drive against it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brake {
    /// Half cycles; even, so that their volt-seconds cancel.
    pub half_cycles: u32,
    /// Amplitude, relative to the drive that is braked.
    pub level: f32,
}

impl Brake {
    /// The shortest brake for a resonance with a time constant of `periods` periods that has rung up under the drive, with up to `headroom`
    /// times that drive: `level = 1 / (exp(t / tau) - 1)` over `t` stops it in full.
    pub fn of(periods: f32, headroom: f32) -> Self {
        // Two half cycles are a period: t / tau = half_cycles / (2 periods).
        let shortest = 2.0 * periods * libm::log1pf(1.0 / headroom.max(1e-3));
        let half_cycles = 2 * (libm::ceilf(0.5 * shortest).clamp(1.0, 1e6) as u32);
        Brake { half_cycles, level: 1.0 / libm::expm1f(half_cycles as f32 / (2.0 * periods)) }
    }
}

/// Where the envelope stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Closed,
    /// Open since a passage through zero in this direction (whether falling).
    Open {
        falling: bool,
    },
    /// Against the drive, for so many half cycles more.
    Braking {
        left: u32,
    },
}

/// The envelope generator.
#[derive(Clone, Debug)]
pub struct Burst {
    schedule: Schedule,
    /// Samples a soft edge takes, and the half turn of its cosine in as many steps (2^32 a turn); none where the edge is hard.
    edge: Option<u32>,
    half_turn_step: u32,
    /// Where the ramp of a soft edge stands, 0 (OFF) to `edge` (ON).
    ramp: u32,
    state: State,
    /// Direction of the last passage through zero.
    falling: bool,
    brake: Option<Brake>,
    /// The envelope of the last block with an edge.
    levels: Vec<f32, MAX_BLOCK_SAMPLES>,
}

impl Burst {
    /// `frequency_hz` is the nominal drive frequency, by which soft edges are measured.
    pub fn build(config: &Config, frequency_hz: f32, sample_hz: f32) -> Result<Self, Error> {
        let edge = match config.edge {
            Edge::Hard => None,
            Edge::Soft { cycles } => {
                in_range("burst.edge.cycles", cycles.into(), 0.5, 1e4)?;
                Some(((cycles * sample_hz / frequency_hz) as u32).max(1))
            }
        };
        Ok(Burst {
            schedule: Schedule::build(&config.schedule, sample_hz.into())?,
            edge,
            half_turn_step: (1 << 31) / edge.unwrap_or(1),
            ramp: 0,
            state: State::Closed,
            falling: false,
            brake: None,
            levels: Vec::new(),
        })
    }

    /// The brake for a burst that is closed by [`Gate::Brake`]. Nothing is braked without one.
    pub fn set_brake(&mut self, brake: Option<Brake>) {
        self.brake = brake;
    }

    /// The brake in use.
    pub fn brake(&self) -> Option<Brake> {
        self.brake
    }

    /// The envelope from sample `now` on, for `samples` samples of a stretch.
    pub fn envelope(&mut self, gate: Gate, now: u64, stretch: &Stretch, samples: usize) -> Envelope<'_> {
        let (mut open, mut stays) = self.gate(gate, now);
        let flat = match self.state {
            State::Open { .. } if open && self.ramp == self.edge.unwrap_or(0) => Some(1.0),
            State::Closed if !open && self.ramp == 0 => Some(0.0),
            _ => None,
        };
        if let Some(level) = flat.filter(|_| stays >= samples as u64) {
            self.falling = falling(stretch.phase_at(samples.saturating_sub(1)));
            return Envelope::Flat(level);
        }
        self.levels.clear();
        let mut done = 0;
        loop {
            let span = stays.min((samples.min(MAX_BLOCK_SAMPLES) - done) as u64) as usize;
            self.span(open, gate == Gate::Brake, stretch, done..done + span);
            done += span;
            if done == samples.min(MAX_BLOCK_SAMPLES) {
                return Envelope::Edge(&self.levels);
            }
            (open, stays) = self.gate(gate, now + done as u64);
        }
    }

    /// The envelope of some samples of a block, during which the gate does not change.
    fn span(&mut self, open: bool, brake: bool, stretch: &Stretch, span: Range<usize>) {
        let brake = self.brake.filter(|_| brake);
        let braking = matches!(self.state, State::Braking { .. });
        match self.edge {
            // Up to the last moment before a brake, the drive stays.
            Some(edge) if !braking && (brake.is_none() || self.ramp < edge) => {
                let levels = &mut self.levels;
                let (mut ramp, step) = (self.ramp, self.half_turn_step);
                for _ in 0..span.len() {
                    ramp = if open { (ramp + 1).min(edge) } else { ramp.saturating_sub(1) };
                    let whole = sine::rotation(u64::from(step * ramp) << 32).re;
                    // There is room for as many samples as a block can have.
                    let _ = levels.push(if ramp == edge { 1.0 } else { 0.5 - 0.5 * whole });
                }
                self.ramp = ramp;
                self.falling = falling(stretch.phase_at(span.end - 1));
                self.state = if ramp == 0 { State::Closed } else { State::Open { falling: self.falling } };
            }
            _ => {
                let mut level = self.level();
                for n in span {
                    let falling = falling(stretch.phase_at(n));
                    if falling != self.falling {
                        self.falling = falling;
                        self.pass(open, brake);
                        level = self.level();
                    }
                    let _ = self.levels.push(level);
                }
            }
        }
    }

    fn level(&self) -> f32 {
        match self.state {
            State::Closed => 0.0,
            State::Open { .. } => 1.0,
            State::Braking { .. } => self.brake.map_or(0.0, |brake| -brake.level),
        }
    }

    /// The first lane passes zero.
    fn pass(&mut self, open: bool, brake: Option<Brake>) {
        self.state = match self.state {
            State::Closed if open => State::Open { falling: self.falling },
            State::Open { falling } if !open && falling == self.falling => {
                self.ramp = 0;
                brake.map_or(State::Closed, |brake| State::Braking { left: brake.half_cycles })
            }
            State::Braking { left } if left > 1 => State::Braking { left: left - 1 },
            State::Braking { .. } => State::Closed,
            unchanged => unchanged,
        };
    }

    /// Opens or closes at once, without an edge: for tones outside the schedule, and for faults.
    pub fn snap(&mut self, open: bool) -> Envelope<'_> {
        self.ramp = if open { self.edge.unwrap_or(0) } else { 0 };
        self.state = if open { State::Open { falling: self.falling } } else { State::Closed };
        Envelope::Flat(if open { 1.0 } else { 0.0 })
    }

    fn gate(&mut self, gate: Gate, now: u64) -> (bool, u64) {
        match gate {
            Gate::Scheduled => self.schedule.gate(now),
            Gate::On => (true, u64::MAX),
            Gate::Off | Gate::Brake => (false, u64::MAX),
        }
    }
}

/// Whether the sine falls below zero after this phase: the second half of the turn.
fn falling(phase: u64) -> bool {
    phase >> 63 == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nco::tuning_word;

    fn burst(schedule: ScheduleConfig, edge: Edge) -> Burst {
        Burst::build(&Config { schedule, edge }, 40e3, 1e6).unwrap()
    }

    fn window(on_s: f64, off_s: f64) -> ScheduleConfig {
        ScheduleConfig::Windows([(on_s, off_s)].into_iter().collect())
    }

    /// A tone whose period is 24.75 samples, from phase zero at sample zero.
    fn tone(now: u64) -> Stretch {
        let word = tuning_word(40_404.0 / 1e6);
        Stretch { phase: word.wrapping_mul(now), word, step: 0 }
    }

    fn levels(burst: &mut Burst, gate: Gate, now: u64, samples: usize) -> std::vec::Vec<f32> {
        match burst.envelope(gate, now, &tone(now), samples) {
            Envelope::Flat(level) => std::vec![level; samples],
            Envelope::Edge(levels) => levels.to_vec(),
        }
    }

    fn run(burst: &mut Burst, gate: Gate, blocks: Range<u64>) -> std::vec::Vec<f32> {
        blocks.flat_map(|k| levels(burst, gate, 32 * k, 32)).collect()
    }

    #[test]
    fn a_hard_burst_lasts_whole_periods_from_a_passage_through_zero() {
        for (on, off) in [(3e-6, 200e-6), (14e-6, 200e-6), (100e-6, 101e-6), (32e-6, 640e-6), (77e-6, 640e-6)] {
            let got = run(&mut burst(window(on, off), Edge::Hard), Gate::Scheduled, 0..40);
            let first = got.iter().position(|&level| level == 1.0).unwrap();
            let last = got.iter().rposition(|&level| level == 1.0).unwrap() + 1;
            assert!(got[first..last].iter().all(|&level| level == 1.0));
            assert!(got[..first].iter().chain(&got[last..]).all(|&level| level == 0.0));
            assert_ne!(falling(tone(0).phase_at(first - 1)), falling(tone(0).phase_at(first)));
            assert!(first as f64 >= on * 1e6 && (first as f64) < on * 1e6 + 13.0, "{first} for {on}");
            assert!(last as f64 >= off * 1e6 && (last as f64) < off * 1e6 + 25.0, "{last} for {off}");
            let periods = (last - first) as f64 / (1e6 / 40_404.0);
            assert!((periods - libm::round(periods)).abs() < 1.0 / 24.0 && periods > 0.9, "{periods}");
        }
    }

    #[test]
    fn a_gate_that_closes_before_zero_is_passed_opens_nothing() {
        // The first passage after the beginning is at sample 13.
        let got = run(&mut burst(window(2e-6, 9e-6), Edge::Hard), Gate::Scheduled, 0..4);
        assert!(got.iter().all(|&level| level == 0.0));
    }

    #[test]
    fn blocks_join_without_a_seam() {
        for edge in [Edge::Hard, Edge::Soft { cycles: 1.0 }] {
            let mut whole = burst(window(13e-6, 90e-6), edge);
            let mut parts = whole.clone();
            let got: std::vec::Vec<f32> = (0..8).flat_map(|k| levels(&mut parts, Gate::Scheduled, 16 * k, 16)).collect();
            let expected: std::vec::Vec<f32> = (0..2).flat_map(|k| levels(&mut whole, Gate::Scheduled, 64 * k, 64)).collect();
            assert_eq!(got, expected);
        }
    }

    #[test]
    fn soft_edge_is_a_raised_cosine() {
        let got = run(&mut burst(window(0.0, 1.0), Edge::Soft { cycles: 1.0 }), Gate::Scheduled, 0..2);
        assert!((got[11] - 0.468_6).abs() < 1e-3, "{got:?}");
        assert!(got.windows(2).all(|pair| pair[1] >= pair[0]));
        assert_eq!(got[24], 1.0);
    }

    #[test]
    fn periodic_schedule_repeats() {
        let mut periodic = burst(ScheduleConfig::Periodic { period_s: 1e-3, duty: 0.25 }, Edge::Hard);
        let ones = run(&mut periodic, Gate::Scheduled, 31_250..31_250 + 625).iter().filter(|&&level| level == 1.0).count();
        assert!((20 * 250 - 250..20 * 250 + 300).contains(&ones), "{ones}");
    }

    /// A resonance `y' = (drive - y) / tau` in envelope: after the brake nothing is left, whatever the headroom.
    #[test]
    fn a_brake_stops_what_rings() {
        for (q, headroom) in [(65.0, 1.0), (65.0, 5.16), (20.0, 1.5), (200.0, 2.0)] {
            let periods = q / core::f32::consts::PI;
            let brake = Brake::of(periods, headroom);
            assert!(brake.level <= headroom && brake.half_cycles.is_multiple_of(2), "{brake:?}");
            let t = brake.half_cycles as f32 / (2.0 * periods);
            let left = libm::expf(-t) * (1.0 + brake.level) - brake.level;
            assert!(left.abs() < 1e-5, "{left}");
        }
        let mut braked = burst(ScheduleConfig::Continuous, Edge::Hard);
        braked.set_brake(Some(Brake { half_cycles: 4, level: 0.7 }));
        run(&mut braked, Gate::On, 0..5);
        let got = run(&mut braked, Gate::Brake, 5..12);
        let against = got.iter().filter(|&&level| level == -0.7).count();
        assert!((49..=50).contains(&against), "{against} samples");
        let end = got.iter().rposition(|&level| level == -0.7).unwrap();
        assert!(got[end + 1..].iter().all(|&level| level == 0.0) && end < 80);
    }

    #[test]
    fn windows_out_of_order_are_refused() {
        let windows = [(2.0, 3.0), (1.0, 1.5)].into_iter().collect();
        let config = Config { schedule: ScheduleConfig::Windows(windows), edge: Edge::Hard };
        assert_eq!(Burst::build(&config, 40e3, 1e6).unwrap_err(), Error::BurstWindows);
    }
}
