//! Waits at the resonance until what a sweep has left no longer turns the motional phase, so that a tracker that starts from there measures one tone
//! only. A free vibration at the driven frequency does not turn it, however long it lasts; and after four time constants
//! nothing does.

use crate::seam::block::LATENCY_BLOCKS;
use crate::seam::phasor::Phasor;
use crate::seam::transducer::Transducer;
use crate::sense::demod::Sensed;
use crate::sense::motional::Motional;

/// Time constants after which a sweep has certainly rung down.
const LONGEST: f32 = 4.0;
/// It has once the motional phase is within so many radians for so many blocks.
const IN_PHASE: (f32, u32) = (0.01, 8);

/// The result of a scan, while it rings down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RingDown {
    /// The transducer.
    pub(crate) transducer: Transducer,
    /// The clamped branch, for tracking.
    pub motional: Motional,
    /// How what other resonances add to the branch changes with the frequency, S/Hz.
    pub(crate) slope: Phasor,
    blocks: u32,
    in_phase: u32,
    longest_blocks: u32,
}

impl RingDown {
    /// Of this result; `still_blocks` have passed since the sweep ended.
    pub(crate) fn new(transducer: Transducer, (motional, slope): (Motional, Phasor), still_blocks: u32, block_s: f32) -> Self {
        let all_blocks = (LONGEST * transducer.time_constant_s() / block_s) as u32;
        // The tone of the resonance itself must have come back.
        let longest_blocks = all_blocks.saturating_sub(still_blocks).max(LATENCY_BLOCKS as u32 + 1);
        RingDown { transducer, motional, slope, blocks: 0, in_phase: 0, longest_blocks }
    }

    /// Takes a block of the tone, at `relative` times the nominal frequency. Returns whether the free vibration has decayed.
    pub(crate) fn is_over(&mut self, sensed: &Sensed, relative: f32) -> bool {
        self.blocks += 1;
        let phase = self.motional.phase_of(self.motional.current(sensed, relative), sensed.v);
        let measured = self.blocks > LATENCY_BLOCKS as u32;
        let within = measured && phase.re > 0.0 && phase.im.abs() < IN_PHASE.0 * phase.re;
        self.in_phase = if within { self.in_phase + 1 } else { 0 };
        self.in_phase >= IN_PHASE.1 || self.blocks >= self.longest_blocks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring_down(still_blocks: u32) -> RingDown {
        let transducer = Transducer { series_resonance_hz: 40e3, q: 65.0, ..Transducer::default() };
        let motional = Motional { y0: Phasor::new(0.0, 0.075), axis: Phasor::new(1.0, 0.0) };
        RingDown::new(transducer, (motional, Phasor::default()), still_blocks, 32e-6)
    }

    /// Blocks until it is over, if the phase is this, rad.
    fn blocks(mut of: RingDown, phase: f32) -> u32 {
        let v = Phasor::new(3.0, 0.0);
        let i = v * (Phasor::new(libm::cosf(phase), libm::sinf(phase)) * 0.3 + Phasor::new(0.0, 0.075));
        (1..1000).find(|_| of.is_over(&Sensed { v, i }, 1.0)).unwrap()
    }

    #[test]
    fn it_ends_with_the_phase_or_with_time() {
        assert_eq!(blocks(ring_down(0), 0.005), 10);
        // Four times 0.517 ms.
        assert_eq!(blocks(ring_down(0), 0.02), 64);
        assert_eq!(blocks(ring_down(50), 0.02), 14);
        assert_eq!(blocks(ring_down(500), 0.02), 3);
    }
}
