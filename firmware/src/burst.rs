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

mod schedule;
#[cfg(test)]
mod tests;

use core::ops::Range;

use heapless::Vec;

use crate::block::{Gate, MAX_BLOCK_SAMPLES};
use crate::burst::schedule::Schedule;
use crate::config::{Burst as Config, Edge};
use crate::error::{Error, in_range};
use crate::nco::Stretch;
use crate::phasor::Phasor;
use crate::shape::sine::Steady;

/// The longest soft edge, samples: its cosine has 2^32 steps a turn.
const LONGEST_EDGE: f32 = (1 << 20) as f32;

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
    /// Every burst ends with a brake, not only those that an order ends.
    brakes: bool,
    /// The envelope of the last block with an edge.
    levels: Vec<f32, MAX_BLOCK_SAMPLES>,
}

impl Burst {
    /// `frequency_hz` is the nominal drive frequency, by which soft edges are measured.
    pub fn build(config: &Config, frequency_hz: f32, sample_hz: f32) -> Result<Self, Error> {
        let edge = match config.edge {
            Edge::Hard => None,
            Edge::Soft { cycles } => {
                in_range("burst.edge.cycles", cycles.into(), 0.5, (LONGEST_EDGE * frequency_hz / sample_hz).min(1e4).into())?;
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
            brakes: config.brake,
            levels: Vec::new(),
        })
    }

    /// Whether a burst that ends under this gate ends with a brake.
    pub fn brakes(&self, gate: Gate) -> bool {
        self.brakes || gate == Gate::Brake
    }

    /// The brake for bursts that end with one. Nothing is braked without one.
    pub fn set_brake(&mut self, brake: Option<Brake>) {
        self.brake = brake;
    }

    /// How much louder than the drive the envelope may get: at least one, and more only by a brake.
    pub fn loudest(&self) -> f32 {
        match self.brake {
            Some(brake) if brake.level > 1.0 => brake.level,
            _ => 1.0,
        }
    }

    /// Whether what plays under this gate is the end of a burst with a brake: the drive stays what it was until that is over.
    pub fn is_ending(&self, gate: Gate) -> bool {
        let ordered = gate == Gate::Brake && matches!(self.state, State::Open { .. });
        self.brake.is_some() && (ordered || matches!(self.state, State::Braking { .. }))
    }

    /// The brake in use.
    pub fn brake(&self) -> Option<Brake> {
        self.brake
    }

    /// Whether the drive is wanted under this gate at sample `now`.
    pub fn is_wanted(&mut self, gate: Gate, now: u64) -> bool {
        self.gate(gate, now).0
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
            self.span(open, self.brakes(gate), stretch, done..done + span);
            done += span;
            if done == samples.min(MAX_BLOCK_SAMPLES) {
                return Envelope::Edge(&self.levels);
            }
            (open, stays) = self.gate(gate, now + done as u64);
        }
    }

    /// Goes along the edge for some samples, up where the gate is open, and stays at its end. Returns how far it has come.
    ///
    /// The level is `(1 - cos(x)) / 2 = sin^2(x / 2)`, whose sine is swung; down, it is that of `-x`.
    fn rise(&mut self, open: bool, edge: u32, samples: usize) -> u32 {
        let half_angle = u64::from(self.half_turn_step * self.ramp) << 31;
        let word = u64::from(self.half_turn_step) << 31;
        let (start, room, end) =
            if open { (half_angle, edge - self.ramp, 1.0) } else { (half_angle.wrapping_neg(), self.ramp, 0.0) };
        let moving = samples.min(room as usize);
        let mut sine = Steady::new(&Stretch { phase: start.wrapping_add(word), word, step: 0 }).swing(Phasor::new(1.0, 0.0));
        for _ in 0..moving {
            let half = sine.take();
            let level = half * half;
            // There is room for as many samples as a block can have. Rounding may not make it louder than one.
            let _ = self.levels.push(if level < 1.0 { level } else { 1.0 });
        }
        if moving == room as usize {
            if let Some(last) = self.levels.last_mut().filter(|_| moving > 0) {
                *last = end;
            }
            self.levels.extend((moving..samples).map(|_| end));
        }
        self.ramp = if open { self.ramp + moving as u32 } else { self.ramp - moving as u32 };
        self.ramp
    }

    /// The envelope of some samples of a block, during which the gate does not change.
    fn span(&mut self, open: bool, brake: bool, stretch: &Stretch, span: Range<usize>) {
        let brake = self.brake.filter(|_| brake);
        let braking = matches!(self.state, State::Braking { .. });
        match self.edge {
            // Up to the last moment before a brake, the drive stays.
            Some(edge) if !braking && (brake.is_none() || self.ramp < edge) => {
                let ramp = self.rise(open, edge, span.len());
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
            // A soft edge opens by its ramp.
            State::Closed if open && self.edge.is_none() => State::Open { falling: self.falling },
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
    pub fn snap(&mut self, open: bool, stretch: &Stretch, samples: usize) -> Envelope<'_> {
        self.falling = falling(stretch.phase_at(samples.saturating_sub(1)));
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
