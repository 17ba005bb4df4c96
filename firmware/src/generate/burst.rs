//! The ON/OFF envelope of the drive, exact to the half cycle, with its edges.
//!
//! A gate (scheduled or ordered) opens and closes. The response depends on the edge:
//!
//! * hard: the burst begins at the next zero crossing of the first lane, in either direction. It
//!   ends at the first zero crossing in the same direction after the gate has closed. It lasts a
//!   whole number of periods, so that its volt-seconds cancel (to the sample; the
//!   [shaper](crate::generate::shaper) corrects the remainder from sampling and rounding).
//! * soft: the envelope follows the gate along a ramp, which an opposite order reverses:
//!   `envelope = (1 - cos(pi ramp)) / 2`.
//! * boost: up by whole half cycles of a larger drive, and down by drive against the vibration, as
//!   fast as the limits allow (`boost`).
//!
//! A burst that ends with a brake continues for some half cycles in antiphase, which stops the
//! vibration.

pub(crate) mod boost;
mod brake;
mod duty;
pub mod envelope;
mod ring;
mod schedule;
mod soft;
pub(crate) mod stroke;
#[cfg(test)]
mod tests;
mod zero_crossing;

use core::ops::Range;

use heapless::Vec;

use crate::generate::burst::boost::Boost;
pub use crate::generate::burst::brake::Brake;
use crate::generate::burst::envelope::{Envelope, Levels};
use crate::generate::burst::schedule::Schedule;
use crate::generate::burst::zero_crossing::{crossings_within, ends_falling, falling, until_crossing, until_crossing_of_chirp};
use crate::generate::nco::Stretch;
use crate::seam::block::{Gate, MAX_BLOCK_SAMPLES};
use crate::seam::compare::larger;
use crate::seam::config::{Burst as Config, Edge};
use crate::seam::error::Error;

/// Length of the longest soft edge, samples: its cosine has 2^32 steps a turn.
const MAX_EDGE_SAMPLES: f32 = (1 << 20) as f32;

/// State of the envelope.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Closed,
    /// Open since a zero crossing, falling or rising.
    Open {
        falling: bool,
    },
    /// Boosted since a zero crossing, falling or rising, for `left` more half cycles.
    Rising {
        falling: bool,
        left: u32,
    },
    /// Driven against the vibration, for `left` more half cycles.
    Braking {
        left: u32,
    },
}

/// Generator of the envelope of bursts.
#[derive(Clone, Debug)]
pub struct Burst {
    schedule: Schedule,
    /// Length of a soft edge, samples; `None` for a hard edge.
    edge: Option<u32>,
    /// Half turn of the soft edge's cosine, divided by its length, 2^32 a turn.
    half_turn_step: u32,
    /// Period of the drive, samples.
    period_of_drive: f32,
    /// Position on the ramp of a soft edge, 0 (OFF) to `edge` (ON).
    ramp: u32,
    state: State,
    /// `true` if the last zero crossing was falling.
    falling: bool,
    brake: Option<Brake>,
    boost: Option<Boost>,
    /// `true` if every burst ends with a brake, not only those that an order ends.
    brakes: bool,
    boosts: bool,
    /// `true` if there is a brake or a boost.
    moves: bool,
    /// Largest level of the envelope; at least one.
    loudest: f32,
    /// Envelope of the last block with an edge, as [`Levels`].
    levels: Vec<i32, MAX_BLOCK_SAMPLES>,
    /// Sum of these levels.
    sum: f32,
}

impl Burst {
    /// Builds the generator. `frequency_hz` is the nominal frequency of the drive, in whose periods
    /// soft edges are measured.
    pub(crate) fn build(config: &Config, frequency_hz: f32, sample_hz: f32) -> Result<Self, Error> {
        let edge = match config.edge {
            Edge::Hard | Edge::Boost => None,
            Edge::Soft => {
                let cycles = config.edge_cycles;
                Config::EDGE_CYCLES.check_within(cycles.into(), 0.0, (MAX_EDGE_SAMPLES * frequency_hz / sample_hz).into())?;
                Some(((cycles * sample_hz / frequency_hz) as u32).max(1))
            }
        };
        Ok(Burst {
            schedule: Schedule::build(&config.schedule, sample_hz.into())?,
            edge,
            half_turn_step: (1 << 31) / edge.unwrap_or(1),
            period_of_drive: sample_hz / frequency_hz,
            ramp: 0,
            state: State::Closed,
            falling: false,
            brake: None,
            boost: (config.edge == Edge::Boost).then(Boost::default),
            brakes: config.brake,
            boosts: config.edge == Edge::Boost,
            moves: config.edge == Edge::Boost,
            loudest: 1.0,
            levels: Vec::new(),
            sum: 0.0,
        })
    }

    /// Returns `true` if bursts begin at once, without a ramp or a boost.
    pub(crate) fn is_hard(&self) -> bool {
        self.edge.is_none() && !self.boosts
    }

    /// Returns `true` if a burst that ends under this gate ends with a brake.
    pub(crate) fn brakes(&self, gate: Gate) -> bool {
        self.brakes || gate == Gate::Brake
    }

    /// Sets the brake of bursts that end with one; `None` disables braking.
    pub(crate) fn set_brake(&mut self, brake: Option<Brake>) {
        self.brake = brake;
        self.loudest = brake.map_or(1.0, |brake| larger(brake.level, 1.0));
        self.moves = brake.is_some();
    }

    /// Returns the largest level of the envelope: at least one, and more only with a brake or a
    /// boost.
    #[inline]
    pub(crate) fn loudest(&self) -> f32 {
        self.loudest
    }

    /// Returns `true` if an edge is under way under this gate: a boost, or the end of a burst with
    /// a brake. The drive that it was planned for must not change until it is over.
    pub(crate) fn is_under_way(&self, gate: Gate) -> bool {
        if !self.moves {
            return false;
        }
        let ordered = (gate == Gate::Brake || gate == Gate::Off && self.boosts) && matches!(self.state, State::Open { .. });
        ordered || matches!(self.state, State::Braking { .. } | State::Rising { .. })
    }

    /// Returns the brake in use.
    pub(crate) fn brake(&self) -> Option<Brake> {
        self.brake
    }

    /// Returns `true` if this gate requests the drive at sample `now`.
    pub(crate) fn is_requested(&mut self, gate: Gate, now: u64) -> bool {
        self.gate(gate, now).0
    }

    /// Returns the envelope of `samples` samples of a stretch from sample `now` on, for a drive of
    /// `volts`.
    #[inline]
    pub fn envelope(&mut self, gate: Gate, now: u64, stretch: &Stretch, samples: usize, volts: f32) -> Envelope<'_> {
        let (open, stays) = self.gate(gate, now);
        if self.boosts {
            if let Some(level) = self.boosted(open, stays >= samples as u64, stretch, samples, volts) {
                return Envelope::Flat(level);
            }
            return self.edge(gate, (open, stays), now, stretch, samples);
        }
        let flat = match self.state {
            State::Open { .. } if open && self.ramp == self.edge.unwrap_or(0) => Some(1.0),
            State::Closed if !open && self.ramp == 0 => Some(0.0),
            _ => None,
        };
        if let Some(level) = flat.filter(|_| stays >= samples as u64) {
            self.falling = ends_falling(stretch, samples);
            return Envelope::Flat(level);
        }
        self.edge(gate, (open, stays), now, stretch, samples)
    }

    /// Returns the envelope of a block in which it is not constant.
    fn edge(&mut self, gate: Gate, now_open: (bool, u64), now: u64, stretch: &Stretch, samples: usize) -> Envelope<'_> {
        let (mut open, mut stays) = now_open;
        if self.levels.len() != samples {
            // There is room for the longest block.
            let _ = self.levels.resize_default(samples);
        }
        let (mut done, samples) = (0, self.levels.len());
        self.sum = 0.0;
        loop {
            let span = stays.min((samples - done) as u64) as usize;
            self.span(open, self.brakes(gate), stretch, done..done + span);
            done += span;
            if done == samples {
                self.end_block();
                let mean = self.sum / samples as f32;
                return Envelope::Edge(Levels { parts: &self.levels, loudest: self.loudest, mean });
            }
            (open, stays) = self.gate(gate, now + done as u64);
        }
    }

    /// Computes the envelope of some samples of a block, during which the gate does not change.
    fn span(&mut self, open: bool, brake: bool, stretch: &Stretch, span: Range<usize>) {
        let brake = self.brake.filter(|_| brake);
        let braking = matches!(self.state, State::Braking { .. });
        match self.edge {
            // A full drive keeps its level until the brake begins.
            Some(edge) if !braking && (brake.is_none() || self.ramp < edge) => {
                let end = span.end;
                let ramp = self.rise(open, edge, span);
                self.falling = falling(stretch.phase_at(end - 1));
                self.state = if ramp == 0 { State::Closed } else { State::Open { falling: self.falling } };
            }
            _ => self.half_cycles(open, brake, stretch, span),
        }
    }

    /// Computes the envelope of some samples, half cycle by half cycle.
    fn half_cycles(&mut self, open: bool, brake: Option<Brake>, stretch: &Stretch, span: Range<usize>) {
        let one = Levels::one(self.loudest);
        let mut n = span.start;
        let mut phase = stretch.phase_at(n);
        while n < span.end {
            let falls = falling(phase);
            if falls != self.falling {
                self.falling = falls;
                self.pass(open, brake);
            }
            let level = self.level();
            let (next, there) = if self.stays(open) {
                // Only the last zero crossing matters.
                self.falling = falling(stretch.phase_at(span.end - 1));
                (span.end, phase)
            } else if stretch.step == 0 {
                let crossings = self.left(open).min(crossings_within(phase, stretch.word, span.end - n)).max(1);
                self.skip(crossings - 1);
                let (samples, there) = until_crossing(phase, stretch.word, crossings);
                (span.end.min(n + samples), there)
            } else {
                let (samples, there) = until_crossing_of_chirp(phase, stretch.word_at(n), stretch.step, span.end - n);
                (n + samples, there)
            };
            if let Some(parts) = self.levels.get_mut(n..next) {
                let part = (level * one) as i32;
                let (fours, rest) = parts.as_chunks_mut::<4>();
                // Written out: a compiler that optimizes for size leaves a loop of one here.
                for [first, second, third, fourth] in fours {
                    (*first, *second, *third, *fourth) = (part, part, part, part);
                }
                rest.fill(part);
            }
            self.sum += level * (next - n) as f32;
            if let Some(boost) = &mut self.boost {
                boost.advance(level, next - n);
            }
            (n, phase) = (next, there);
        }
    }

    /// Returns the number of half cycles for which the level is constant while the gate stays.
    fn left(&self, open: bool) -> u32 {
        match (self.state, open) {
            (State::Rising { left, .. }, true) | (State::Braking { left }, false) => left,
            _ => 1,
        }
    }

    /// Skips this number of half cycles, but not the last one of a stroke.
    fn skip(&mut self, crossings: u32) {
        if let State::Rising { left, .. } | State::Braking { left } = &mut self.state {
            *left -= crossings;
        }
        self.falling ^= crossings % 2 == 1;
    }

    /// Returns `true` if no zero crossing changes anything while the gate stays.
    fn stays(&self, open: bool) -> bool {
        matches!((self.state, open), (State::Closed, false) | (State::Open { .. }, true))
    }

    // Inlined, so that it is in the fast memory of a board like its caller.
    #[inline(always)]
    fn level(&self) -> f32 {
        match self.state {
            State::Closed => 0.0,
            State::Open { .. } => 1.0,
            State::Rising { .. } => self.boost.as_ref().map_or(1.0, Boost::level),
            State::Braking { .. } => match &self.boost {
                Some(boost) => boost.level(),
                None => self.brake.map_or(0.0, |brake| -brake.level),
            },
        }
    }

    /// Changes the state at a zero crossing of the first lane.
    fn pass(&mut self, open: bool, brake: Option<Brake>) {
        if let Some(boost) = &mut self.boost {
            self.state = boost.pass(self.state, open, self.falling);
            return;
        }
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
    pub(crate) fn set_envelope_now(&mut self, open: bool, stretch: &Stretch, samples: usize) -> Envelope<'_> {
        if self.boosts {
            self.set_boost_now(open, samples);
        }
        self.falling = ends_falling(stretch, samples);
        self.ramp = if open { self.edge.unwrap_or(0) } else { 0 };
        self.state = if open { State::Open { falling: self.falling } } else { State::Closed };
        Envelope::Flat(if open { 1.0 } else { 0.0 })
    }

    /// Returns `true` if a drive has not ended.
    #[inline]
    pub(crate) fn is_open(&self) -> bool {
        self.state != State::Closed
    }

    /// Ends the drive, at once or by a linear ramp from its last level to zero over the block: an
    /// end between zero crossings would draw a peak of current into the clamped capacitance.
    #[inline(never)]
    pub(crate) fn fade_out(&mut self, fades: bool, stretch: &Stretch, samples: usize) -> Envelope<'_> {
        if self.levels.len() != samples {
            // There is room for the longest block. The first edge would have no time for this.
            let _ = self.levels.resize_default(samples);
        }
        if !fades {
            return self.set_envelope_now(false, stretch, samples);
        }
        let one = Levels::one(self.loudest);
        let last = match (self.edge, self.levels.last()) {
            (Some(edge), Some(&part)) if !self.ramp.is_multiple_of(edge) => part as f32 / one,
            _ => self.level(),
        };
        let _ = self.set_envelope_now(false, stretch, samples);
        let step = last / samples as f32;
        let (mut level, rise) = (0, (step * one) as i32);
        let mut next = |part: &mut i32| {
            *part = level;
            // The last sum, which is not used, may be 2^31.
            level = level.wrapping_add(rise);
        };
        let (rest, fours) = self.levels.as_rchunks_mut::<4>();
        // Written out: a compiler that optimizes for size leaves a loop of one here.
        for [first, second, third, fourth] in fours.iter_mut().rev() {
            next(fourth);
            next(third);
            next(second);
            next(first);
        }
        rest.iter_mut().rev().for_each(next);
        Envelope::Edge(Levels { parts: &self.levels, loudest: self.loudest, mean: 0.5 * (last - step) })
    }

    fn gate(&mut self, gate: Gate, now: u64) -> (bool, u64) {
        match gate {
            Gate::Scheduled => self.schedule.gate(now),
            Gate::On => (true, u64::MAX),
            Gate::Off | Gate::Brake => (false, u64::MAX),
        }
    }
}
