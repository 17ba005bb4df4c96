//! The boosted burst: a ring-up by a [stroke](super::stroke) larger than the drive, a hold, and a
//! stroke against the vibration.
//!
//! Each stroke is planned at its beginning, from the present vibration: the remainder of an earlier
//! burst, or the level that a short one has reached. If the gate reverses before a stroke is over,
//! the burst reacts after whole periods of it, so that these cancel. A boost of an odd number of
//! half cycles is compensated by a brake of an odd number. A brake that a limit has made too weak
//! for the vibration is followed by another.

use super::ring::Ring;
use super::stroke::{CurrentRoom, Stroke, Strokes};
use super::zero_crossing::ends_falling;
use super::{Burst, State};
use crate::generate::nco::Stretch;
use crate::seam::block::Gate;
use crate::seam::compare::{smaller, within};

/// Relative excess over the ceiling above which a stroke counts as limited.
const MAX_EXCESS_REL: f32 = 0.01;
/// Relative change of the drive up to which strokes need not be planned again.
const MAX_DRIVE_CHANGE_REL: f32 = 0.01;

/// Number of half cycles from which a stroke is long enough for a tracker to evaluate.
const MIN_TRACKED_HALF_CYCLES: u32 = 64;

/// The boosted burst.
#[derive(Clone, Debug, Default)]
pub(super) struct Boost {
    pub(super) ring: Ring,
    strokes: Option<Strokes>,
    /// Room within the current limit, for a vibration above that of the drive.
    room: CurrentRoom,
    /// Drive at an envelope of one, V.
    volts: f32,
    /// Drive of the stroke under way, V.
    stroke_volts: f32,
    /// Half cycles of the stroke under way.
    stroke: u32,
    /// `true` if an odd boost waits for its odd brake.
    odd: bool,
    limited: bool,
    /// `true` if a limit has made the stroke under way too weak to reach its target.
    weak: bool,
}

impl Boost {
    /// Sets the planned strokes; with `None`, bursts begin and end hard.
    pub(super) fn set_strokes(&mut self, strokes: Option<Strokes>) {
        self.limited = strokes.is_none_or(|strokes| !strokes.lands);
        self.strokes = strokes;
    }

    /// Returns `true` if there are strokes for this drive.
    pub(super) fn fits(&self, volts: f32) -> bool {
        self.strokes.as_ref().is_some_and(|strokes| (strokes.volts - volts).abs() <= MAX_DRIVE_CHANGE_REL * volts)
    }

    /// Returns `true` if an edge is limited.
    pub(super) fn limited(&self) -> bool {
        self.limited
    }

    /// Returns the largest ratio of a stroke to the drive.
    pub(super) fn loudest(&self, volts: f32) -> f32 {
        match &self.strokes {
            Some(strokes) if strokes.ceiling > volts && volts > 0.0 => strokes.ceiling / volts,
            _ => 1.0,
        }
    }

    /// Returns the envelope of the stroke under way.
    pub(super) fn level(&self) -> f32 {
        if self.volts > 0.0 { self.stroke_volts / self.volts } else { 0.0 }
    }

    /// Advances by this number of samples at this envelope.
    pub(super) fn advance(&mut self, level: f32, samples: usize) {
        self.ring.advance(level * self.volts, samples);
    }

    /// Returns the state after a zero crossing of the first lane, falling or rising.
    pub(super) fn pass(&mut self, state: State, open: bool, falling: bool) -> State {
        match state {
            State::Closed if open => self.rise(falling),
            State::Rising { falling: began, left } if left <= 1 => {
                self.odd |= self.stroke % 2 == 1;
                self.pass(State::Open { falling: began }, open, falling)
            }
            // Whole periods of the boost have passed, and the gate has closed.
            State::Rising { falling: began, .. } if !open && falling == began => self.fall(),
            State::Rising { falling: began, left } => State::Rising { falling: began, left: left - 1 },
            State::Open { falling: began } if !open && falling == began => self.fall(),
            State::Braking { left } if left <= 1 => {
                self.odd &= self.stroke.is_multiple_of(2);
                match open {
                    true => self.rise(falling),
                    false if self.weak => self.fall(),
                    false => State::Closed,
                }
            }
            State::Braking { left } if open && (self.stroke - left) % 2 == 1 => self.rise(falling),
            State::Braking { left } => State::Braking { left: left - 1 },
            unchanged => unchanged,
        }
    }

    fn rise(&mut self, falling: bool) -> State {
        let Some(strokes) = self.strokes else { return State::Open { falling } };
        let up = if self.odd { strokes.with_parity(strokes.up, false) } else { strokes.up };
        self.begin(up, self.volts, &strokes);
        State::Rising { falling, left: up.half_cycles }
    }

    fn fall(&mut self) -> State {
        let Some(strokes) = self.strokes else { return State::Closed };
        let down = strokes.with_parity(strokes.down, self.odd);
        self.begin(down, 0.0, &strokes);
        State::Braking { left: down.half_cycles }
    }

    /// Begins a stroke from the present vibration to a target, V.
    fn begin(&mut self, stroke: Stroke, to: f32, strokes: &Strokes) {
        let from = self.ring.volts();
        let needed = stroke.volts(from, to);
        // The vibration is above that of the drive if the amplitude has just been reduced.
        let high = from.abs() > (1.0 + MAX_DRIVE_CHANGE_REL) * strokes.volts;
        let ceiling = if high { smaller(self.room.volts(from), strokes.ceiling) } else { strokes.ceiling };
        self.weak = needed.abs() > (1.0 + MAX_EXCESS_REL) * ceiling;
        self.limited = !strokes.lands || self.weak;
        self.stroke_volts = within(needed, -ceiling, ceiling);
        self.stroke = stroke.half_cycles;
    }
}

/// Methods for boosted bursts only, except [`Burst::restart`].
impl Burst {
    /// Returns the level of a boosted burst if it is constant over the block, and advances a long
    /// stroke. `stays` is `true` if the gate does not change.
    #[inline(never)]
    pub(super) fn boosted(&mut self, open: bool, stays: bool, stretch: &Stretch, samples: usize, volts: f32) -> Option<f32> {
        let boost = self.boost.as_mut()?;
        boost.volts = volts;
        let stroke = match (&mut self.state, open) {
            _ if !stays => return None,
            (State::Open { .. }, true) | (State::Closed, false) => None,
            (State::Rising { left, .. }, true) | (State::Braking { left }, false) => Some(left),
            _ => return None,
        };
        let level = match stroke.map(|left| advance_stroke(left, stretch, samples)) {
            None => f32::from(u8::from(open)),
            Some(true) => boost.level(),
            Some(false) => return None,
        };
        boost.advance(level, samples);
        boost.ring.end_block();
        self.falling = ends_falling(stretch, samples);
        Some(level)
    }

    /// Ends a block of a boosted burst.
    pub(super) fn end_block(&mut self) {
        if let Some(boost) = &mut self.boost {
            boost.ring.end_block();
        }
    }

    #[inline(never)]
    pub(super) fn set_boost_now(&mut self, open: bool, samples: usize) {
        if let Some(boost) = &mut self.boost {
            boost.odd = false;
            boost.advance(f32::from(u8::from(open)), samples);
            boost.ring.end_block();
        }
    }

    /// Sets the drive of the next block, V, relative to which a boost is larger.
    pub(crate) fn set_drive(&mut self, volts: f32) {
        self.loudest = self.boost.as_ref().map_or(1.0, |boost| boost.loudest(volts));
    }

    /// Returns `true` if the gate changes within `samples` samples from `now` on.
    pub(crate) fn turns_within(&mut self, gate: Gate, now: u64, samples: u64) -> bool {
        self.gate(gate, now).1 < samples
    }

    /// Returns `true` if edges are boosted.
    #[inline]
    pub(crate) fn boosts(&self) -> bool {
        self.boosts
    }

    /// Returns `true` if an edge is not as configured, because the limits leave too little for it,
    /// or because it cannot be planned.
    #[inline]
    pub(crate) fn limited(&self) -> bool {
        self.boosts && self.boost.as_ref().is_some_and(Boost::limited)
    }

    /// Returns `true` if the planned strokes are for this drive, V.
    pub(crate) fn fits(&self, volts: f32) -> bool {
        self.boost.as_ref().is_none_or(|boost| boost.fits(volts))
    }

    /// Sets the strokes of a boosted burst; without them, edges are hard.
    pub(crate) fn set_strokes(&mut self, strokes: Option<Strokes>) {
        if let Some(boost) = &mut self.boost {
            boost.set_strokes(strokes);
        }
    }

    /// Sets the decay rate of the vibration, 1/sample, for blocks of this number of samples.
    pub(crate) fn set_rate(&mut self, per_sample: f32, samples: usize) {
        if let Some(boost) = &mut self.boost {
            boost.ring.set_rate(per_sample, samples);
        }
    }

    /// Sets the room for the drive of an edge within the current limit.
    pub(crate) fn set_room(&mut self, room: CurrentRoom) {
        if let Some(boost) = &mut self.boost {
            boost.room = room;
        }
    }

    /// Takes the vibration measured in a block, as the steady drive that would hold it, V.
    pub(crate) fn update(&mut self, volts: f32) {
        if let Some(boost) = &mut self.boost {
            boost.ring.update(volts);
        }
    }

    /// Returns `true` if the ring-up to a drive of `volts` was complete before the last block.
    pub(crate) fn was_rung_up(&self, volts: f32) -> bool {
        self.boost.as_ref().is_some_and(|boost| boost.ring.was_rung_up(volts))
    }

    /// Returns `true` if the block being played is informative for a tracker: the drive, and a long
    /// boost of it. A brake and its DC-offset correction leave almost no signal.
    pub(crate) fn is_telling(&self) -> bool {
        self.boost.as_ref().is_none_or(|boost| match self.state {
            State::Open { .. } => true,
            State::Rising { .. } => boost.stroke >= MIN_TRACKED_HALF_CYCLES,
            State::Closed | State::Braking { .. } => false,
        })
    }

    /// Discards brake, strokes and vibration of another transducer or of another time.
    pub(crate) fn restart(&mut self) {
        self.set_brake(None);
        self.moves = self.boosts;
        if let Some(boost) = &mut self.boost {
            *boost = Boost::default();
        }
    }
}

/// Returns `true` if a stroke lasts longer than a block, and then subtracts the half cycles of it.
fn advance_stroke(left: &mut u32, stretch: &Stretch, samples: usize) -> bool {
    // From the last sample of the block before to the last sample of this one.
    let before = u128::from(stretch.phase.wrapping_sub(stretch.word));
    let passed = (((before + u128::from(stretch.word) * samples as u128) >> 63) - (before >> 63)) as u32;
    let longer = *left > passed;
    *left -= if longer { passed } else { 0 };
    longer
}

#[cfg(test)]
mod tests;
