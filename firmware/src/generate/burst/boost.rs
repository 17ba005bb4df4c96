//! The boosted burst: rung up by a [stroke](super::stroke) louder than the drive, held, and rung down by one against it.
//!
//! Each stroke is planned where it begins, from the vibration at that moment: what an earlier burst has left, or what a short one has
//! come to. A gate that turns round before a stroke is over is followed after whole periods of it, so that these cancel; a boost of an odd number
//! of half cycles is paid back by a brake of an odd number.

use super::passage::ends_falling;
use super::ring::Ring;
use super::stroke::{Stroke, Strokes};
use super::{Burst, State};
use crate::generate::nco::Stretch;
use crate::seam::block::Gate;
use crate::seam::compare::within;

/// A stroke that wants more than its ceiling by this part is limited.
const LIMITED: f32 = 0.01;
/// Strokes for a drive that differs by less than this part need not be planned again.
const SAME: f32 = 0.01;

/// A stroke of so many half cycles is long enough for a tracker to listen to.
const LONG: u32 = 64;

/// The boosted burst.
#[derive(Clone, Debug, Default)]
pub(super) struct Boost {
    pub(super) ring: Ring,
    strokes: Option<Strokes>,
    /// The drive of an envelope of one, V.
    volts: f32,
    /// Drive of the stroke under way, V, and its half cycles.
    stroke_volts: f32,
    stroke: u32,
    /// An odd boost waits for its odd brake.
    odd: bool,
    limited: bool,
}

impl Boost {
    /// Takes the strokes that are planned, or none: then bursts begin and end hard.
    pub(super) fn set_strokes(&mut self, strokes: Option<Strokes>) {
        self.limited = strokes.is_none_or(|strokes| !strokes.lands);
        self.strokes = strokes;
    }

    /// Whether there are strokes, and they are for this drive.
    pub(super) fn fits(&self, volts: f32) -> bool {
        self.strokes.as_ref().is_some_and(|strokes| (strokes.volts - volts).abs() <= SAME * volts)
    }

    /// Whether an edge is limited.
    pub(super) fn limited(&self) -> bool {
        self.limited
    }

    /// How much louder than the drive a stroke may get.
    pub(super) fn loudest(&self, volts: f32) -> f32 {
        match &self.strokes {
            Some(strokes) if strokes.ceiling > volts && volts > 0.0 => strokes.ceiling / volts,
            _ => 1.0,
        }
    }

    /// The envelope of the stroke under way.
    pub(super) fn level(&self) -> f32 {
        if self.volts > 0.0 { self.stroke_volts / self.volts } else { 0.0 }
    }

    /// So many samples at this envelope.
    pub(super) fn advance(&mut self, level: f32, samples: usize) {
        self.ring.advance(level * self.volts, samples);
    }

    /// The first lane passes zero, into its rising or falling half.
    pub(super) fn pass(&mut self, state: State, open: bool, falling: bool) -> State {
        match state {
            State::Closed if open => self.rise(falling),
            State::Rising { falling: began, left } if left <= 1 => {
                self.odd |= self.stroke % 2 == 1;
                self.pass(State::Open { falling: began }, open, falling)
            }
            // Whole periods of the boost, and the gate has closed.
            State::Rising { falling: began, .. } if !open && falling == began => self.fall(),
            State::Rising { falling: began, left } => State::Rising { falling: began, left: left - 1 },
            State::Open { falling: began } if !open && falling == began => self.fall(),
            State::Braking { left } if left <= 1 => {
                self.odd &= self.stroke.is_multiple_of(2);
                if open { self.rise(falling) } else { State::Closed }
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
        let needed = stroke.volts(self.ring.volts(), to);
        self.limited = !strokes.lands || needed.abs() > (1.0 + LIMITED) * strokes.ceiling;
        self.stroke_volts = within(needed, -strokes.ceiling, strokes.ceiling);
        self.stroke = stroke.half_cycles;
    }
}

/// What concerns boosted bursts only.
impl Burst {
    /// The level of a boosted burst, if it is the same throughout a block; a long stroke moves on. `stays`: the gate does.
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
        let level = match stroke.map(|left| goes_on(left, stretch, samples)) {
            None => f32::from(u8::from(open)),
            Some(true) => boost.level(),
            Some(false) => return None,
        };
        boost.advance(level, samples);
        boost.ring.end_block();
        self.falling = ends_falling(stretch, samples);
        Some(level)
    }

    /// A block of a boosted burst ends.
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

    /// Takes the drive of the next block, by which a boost is louder, V.
    pub(crate) fn set_drive(&mut self, volts: f32) {
        self.loudest = self.boost.as_ref().map_or(1.0, |boost| boost.loudest(volts));
    }

    /// Whether the gate turns within so many samples from `now` on.
    pub(crate) fn turns_within(&mut self, gate: Gate, now: u64, samples: u64) -> bool {
        self.gate(gate, now).1 < samples
    }

    /// Whether edges are boosted.
    #[inline]
    pub(crate) fn boosts(&self) -> bool {
        self.boosts
    }

    /// Whether an edge is not what was asked for, because the limits leave too little for it, or because there is nothing to plan it by.
    #[inline]
    pub(crate) fn limited(&self) -> bool {
        self.boosts && self.boost.as_ref().is_some_and(Boost::limited)
    }

    /// Whether the strokes that were planned are for this drive, V.
    pub(crate) fn fits(&self, volts: f32) -> bool {
        self.boost.as_ref().is_none_or(|boost| boost.fits(volts))
    }

    /// Takes the strokes of a boosted burst; without, edges are hard.
    pub(crate) fn set_strokes(&mut self, strokes: Option<Strokes>) {
        if let Some(boost) = &mut self.boost {
            boost.set_strokes(strokes);
        }
    }

    /// Sets the decay rate of the vibration, 1/sample, in blocks of so many samples.
    pub(crate) fn set_rate(&mut self, per_sample: f32, samples: usize) {
        if let Some(boost) = &mut self.boost {
            boost.ring.set_rate(per_sample, samples);
        }
    }

    /// Takes the vibration measured in a block, as the steady drive that would hold it, V.
    pub(crate) fn update(&mut self, volts: f32) {
        if let Some(boost) = &mut self.boost {
            boost.ring.update(volts);
        }
    }

    /// Whether a boosted burst had rung up to a drive of `volts` before the last block.
    pub(crate) fn was_rung_up(&self, volts: f32) -> bool {
        self.boost.as_ref().is_some_and(|boost| boost.ring.was_rung_up(volts))
    }

    /// Whether the block being played is informative to a tracker: the drive, and a long boost of it. A brake and its DC-offset correction leave almost no signal.
    pub(crate) fn is_telling(&self) -> bool {
        self.boost.as_ref().is_none_or(|boost| match self.state {
            State::Open { .. } => true,
            State::Rising { .. } => boost.stroke >= LONG,
            State::Closed | State::Braking { .. } => false,
        })
    }

    /// Forgets the vibration of another transducer or of another time.
    pub(crate) fn restart(&mut self) {
        if let Some(boost) = &mut self.boost {
            *boost = Boost::default();
        }
    }
}

/// Whether a stroke goes on for longer than a block, of which as many half cycles are taken off it then.
fn goes_on(left: &mut u32, stretch: &Stretch, samples: usize) -> bool {
    // From the last sample of the block before to its own last.
    let before = u128::from(stretch.phase.wrapping_sub(stretch.word));
    let passed = (((before + u128::from(stretch.word) * samples as u128) >> 63) - (before >> 63)) as u32;
    let longer = *left > passed;
    *left -= if longer { passed } else { 0 };
    longer
}

#[cfg(test)]
mod tests;
