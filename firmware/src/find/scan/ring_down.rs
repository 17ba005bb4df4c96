//! Wait at the resonance until the vibration left by a sweep no longer turns the motional phase.
//!
//! A tracker that starts then measures a single tone. A free vibration at the driven frequency does
//! not turn the phase, however long it lasts. After four time constants any vibration has decayed.

use crate::seam::block::LATENCY_BLOCKS;
use crate::seam::phasor::Phasor;
use crate::seam::transducer::Transducer;
use crate::sense::demod::Sensed;
use crate::sense::motional::Motional;

/// Maximum duration, in time constants.
const MAX_TIME_CONSTANTS: f32 = 4.0;
/// Maximum motional phase after the ring-down, rad.
const IN_PHASE_RAD: f32 = 0.01;
/// Number of consecutive blocks within that phase that end the wait.
const IN_PHASE_BLOCKS: u32 = 8;

/// Result of a scan, during the ring-down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RingDown {
    /// Identified transducer.
    pub(crate) transducer: Transducer,
    /// Clamped branch for tracking.
    pub motional: Motional,
    /// Slope with frequency of the admittance of the other resonances, S/Hz.
    pub(crate) slope: Phasor,
    blocks: u32,
    in_phase: u32,
    longest_blocks: u32,
}

impl RingDown {
    /// Starts the wait with this result, `still_blocks` after the end of the sweep.
    pub(crate) fn new(transducer: Transducer, (motional, slope): (Motional, Phasor), still_blocks: u32, block_s: f32) -> Self {
        let all_blocks = (MAX_TIME_CONSTANTS * transducer.time_constant_s() / block_s) as u32;
        // At least until the first block at the resonance frequency is measured.
        let longest_blocks = all_blocks.saturating_sub(still_blocks).max(LATENCY_BLOCKS as u32 + 1);
        RingDown { transducer, motional, slope, blocks: 0, in_phase: 0, longest_blocks }
    }

    /// Processes a block of the tone, at `relative` times the nominal frequency. Returns `true` if
    /// the free vibration has decayed.
    pub(crate) fn check_block(&mut self, sensed: &Sensed, relative: f32) -> bool {
        self.blocks += 1;
        let phase = self.motional.phase_of(self.motional.current(sensed, relative), sensed.v);
        let measured = self.blocks > LATENCY_BLOCKS as u32;
        let within = measured && phase.re > 0.0 && phase.im.abs() < IN_PHASE_RAD * phase.re;
        self.in_phase = if within { self.in_phase + 1 } else { 0 };
        self.in_phase >= IN_PHASE_BLOCKS || self.blocks >= self.longest_blocks
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

    /// Returns the number of blocks until the end at a constant phase, rad.
    fn blocks(mut ring_down: RingDown, phase: f32) -> u32 {
        let v = Phasor::new(3.0, 0.0);
        let i = v * (Phasor::new(libm::cosf(phase), libm::sinf(phase)) * 0.3 + Phasor::new(0.0, 0.075));
        (1..1000).find(|_| ring_down.check_block(&Sensed { v, i }, 1.0)).unwrap()
    }

    #[test]
    fn ends_when_in_phase_or_after_four_time_constants() {
        assert_eq!(blocks(ring_down(0), 0.005), 10);
        // Four times 0.517 ms.
        assert_eq!(blocks(ring_down(0), 0.02), 64);
        assert_eq!(blocks(ring_down(50), 0.02), 14);
        assert_eq!(blocks(ring_down(500), 0.02), 3);
    }
}
