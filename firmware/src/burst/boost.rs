//! The boosted burst: rung up by a [stroke](super::stroke) louder than the drive, held, and rung down by one against it.
//!
//! Each stroke is planned where it begins, from what [rings](super::ring) at that moment: what an earlier burst has left, or what a short one has
//! come to. A gate that turns round before a stroke is over is followed after whole periods of it, so that these cancel; a boost of an odd number
//! of half cycles is paid back by a brake of an odd number.

use super::ring::Ring;
use super::stroke::{Stroke, Strokes};
use super::{Burst, State};

/// A stroke that wants more than its ceiling by this part is limited.
const LIMITED: f32 = 0.01;
/// Strokes for a drive that differs by less than this part need not be made anew.
const SAME: f32 = 0.01;

/// A stroke of so many half cycles is long enough for a tracker to listen to.
const LONG: u32 = 64;

/// How long the edges of a boosted burst take, for who counts on them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EdgeTimes {
    /// Half cycles of the boost and of the brake.
    pub half_cycles: (u32, u32),
    /// Drive of the boost, from rest, and of the brake, from the level, V.
    pub volts: (f32, f32),
    /// Time constant of the ring as it is driven, half cycles.
    pub time_constant: f32,
}

impl EdgeTimes {
    /// By how many half cycles of the drive the amplitude is longer above `part` of its level than the gate is open: the brake's time down to it less
    /// the boost's time up to it. The gate itself is rounded to whole periods.
    pub fn longer_above(&self, part: f32, level_volts: f32) -> f32 {
        let (boost, brake) = self.volts;
        let up = libm::logf(boost / (boost - part * level_volts));
        let down = libm::logf((level_volts + brake.abs()) / (part * level_volts + brake.abs()));
        self.time_constant * (down - up)
    }
}

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
    /// The drive of the next block, V.
    pub(super) fn set_volts(&mut self, volts: f32) {
        self.volts = volts;
    }

    /// Takes the strokes that are planned, or none: then bursts begin and end hard.
    pub(super) fn set_strokes(&mut self, strokes: Option<Strokes>) {
        self.limited = strokes.is_none_or(|strokes| !strokes.lands);
        self.strokes = strokes;
    }

    /// Whether there are strokes, and they are for this drive and this ceiling.
    pub(super) fn fits(&self, volts: f32, ceiling: f32) -> bool {
        let same = |x: f32, y: f32| (x - y).abs() <= SAME * y;
        self.strokes.is_some_and(|strokes| same(strokes.volts, volts) && same(strokes.ceiling, ceiling))
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

    pub(super) fn times(&self) -> Option<EdgeTimes> {
        self.strokes.map(|strokes| EdgeTimes {
            half_cycles: (strokes.up.half_cycles, strokes.down.half_cycles),
            volts: (strokes.up.volts(0.0, strokes.volts), strokes.down.volts(strokes.volts, 0.0)),
            time_constant: strokes.per_time_constant(),
        })
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

    /// Begins a stroke from what rings to what shall ring, V.
    fn begin(&mut self, stroke: Stroke, to: f32, strokes: &Strokes) {
        let wanted = stroke.volts(self.ring.volts(), to);
        self.limited = !strokes.lands || wanted.abs() > (1.0 + LIMITED) * strokes.ceiling;
        self.stroke_volts = wanted.clamp(-strokes.ceiling, strokes.ceiling);
        self.stroke = stroke.half_cycles;
    }

    /// Opens or closes at once.
    pub(super) fn snap(&mut self) {
        self.odd = false;
    }
}

/// What concerns boosted bursts only.
impl Burst {
    /// Whether edges are boosted.
    pub fn boosts(&self) -> bool {
        self.boost.is_some()
    }

    /// Whether an edge is not what was asked for, because the limits leave too little for it, or because there is nothing to plan it by.
    pub fn limited(&self) -> bool {
        self.boost.as_ref().is_some_and(Boost::limited)
    }

    /// A stroke of so many half cycles is long enough for a tracker to listen to.
    const LONG: u32 = 64;

    /// How long the edges take that are planned now; `None` where they are not boosted.
    pub fn edge_times(&self) -> Option<EdgeTimes> {
        self.boost.as_ref().and_then(Boost::times)
    }

    /// Whether the strokes that were planned are for this drive and this ceiling, V.
    pub fn fits(&self, volts: f32, ceiling: f32) -> bool {
        self.boost.as_ref().is_none_or(|boost| boost.fits(volts, ceiling))
    }

    /// Takes the strokes of a boosted burst, and the rate by which what rings decays, 1/sample. Without strokes edges are hard.
    pub fn set_strokes(&mut self, strokes: Option<Strokes>, per_sample: f32) {
        if let Some(boost) = &mut self.boost {
            boost.set_strokes(strokes);
            boost.ring.set_rate(per_sample);
        }
    }

    /// Takes what was heard to ring in a block of so many samples, as the steady drive that would hold it, V.
    pub fn hear(&mut self, volts: f32, samples: usize) {
        if let Some(boost) = &mut self.boost {
            boost.ring.hear(volts, samples);
        }
    }

    /// Whether a boosted burst has rung up to a drive of `volts` already.
    pub fn is_rung_up(&self, volts: f32) -> bool {
        self.boost.as_ref().is_some_and(|boost| boost.ring.is_rung_up(volts))
    }

    /// Whether what plays now tells a tracker something: the drive, and a long boost of it. What a brake and its payback leave is nearly nothing.
    pub fn is_telling(&self) -> bool {
        self.boost.as_ref().is_none_or(|boost| match self.state {
            State::Open { .. } => true,
            State::Rising { .. } => boost.stroke >= LONG,
            State::Closed | State::Braking { .. } => false,
        })
    }

    /// Forgets what rings, of another transducer or of another time.
    pub fn restart(&mut self) {
        if let Some(boost) = &mut self.boost {
            *boost = Boost::default();
        }
    }
}

#[cfg(test)]
mod tests;
