//! Wait at the resonance until the vibration left by a sweep no longer turns the motional phase.
//!
//! A tracker that starts then measures a single tone. A free vibration at the driven frequency does
//! not turn the phase, however long it lasts. After four time constants any vibration has decayed.

use crate::seam::block::LATENCY_BLOCKS;
use crate::seam::compare::larger;
use crate::seam::phasor::Phasor;
use crate::seam::transducer::Transducer;
use crate::sense::demod::Sensed;
use crate::sense::motional::Motional;

const TAU: f32 = core::f32::consts::TAU;

/// Maximum duration, in time constants.
const MAX_TIME_CONSTANTS: f32 = 4.0;
/// Maximum motional phase after the ring-down, rad.
const IN_PHASE_RAD: f32 = 0.01;
/// Number of consecutive blocks within that phase that end the wait.
const IN_PHASE_BLOCKS: u32 = 8;

/// Relative uncertainty of the clamped capacitance apart from noise.
///
/// Images of the drive's converter also flow through it and are read at the drive's frequency. With
/// an amplifier of 200 kHz it seems up to 3.2 % smaller, less if the source's resistance blocks the
/// images (column `c0_error_f` of the file that `evidence transducers` writes). A faster amplifier
/// passes more of them.
pub(crate) const C0_UNCERTAINTY_REL: f32 = 0.018;

/// Turn of the motional phase at the lock point by other resonances, if a scan has found some, rad.
pub(crate) const OTHER_MODES_RAD: f32 = 0.02;
/// Tangent of the phase by which other resonances may turn the lock, relative to the difference of
/// the clamped susceptances of the scan and of the tones off resonance in motional conductances:
/// neither resolves those resonances, and the lock is off by one to three times that difference.
const TURN_PER_CONTRADICTION: f32 = 2.85;

/// Result of a scan, during the ring-down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RingDown {
    /// Identified transducer, with deviations by noise.
    pub(crate) transducer: Transducer,
    /// The same with all deviations, and the quality of a lock on it.
    pub(crate) stated: Transducer,
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
        RingDown { transducer, stated: transducer, motional, slope, blocks: 0, in_phase: 0, longest_blocks }
    }

    /// States deviations and quality. `is_crowded`: other resonances turn the phase.
    /// `off_resonance_c0_f`: clamped capacitance from the tones off resonance, F.
    // In a block with time for it: the next stage begins in one of the longest.
    pub(crate) fn state(&mut self, is_crowded: bool, off_resonance_c0_f: Option<f32>) {
        let stated = &mut self.stated;
        widen(stated, if is_crowded { OTHER_MODES_RAD } else { 0.0 });
        let off_f = off_resonance_c0_f.map_or(0.0, |c0_f| stated.c0_f - c0_f);
        let contradiction = TAU * stated.series_resonance_hz * off_f.abs() * stated.rm_ohm;
        // Two standard deviations, in half bandwidths.
        let shift = 4.0 * stated.q * stated.deviations.series_resonance_hz / stated.series_resonance_hz;
        stated.quality.turn(larger(TURN_PER_CONTRADICTION * contradiction, shift));
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

/// Adds to the deviations of a scan those apart from noise: of the clamped capacitance, and by a
/// turn of the motional phase by other resonances, rad.
fn widen(transducer: &mut Transducer, phase_rad: f32) {
    let Transducer { series_resonance_hz: hz, parallel_resonance_hz, q, rm_ohm, lm_h, cm_f, c0_f, coupling, deviations, .. } =
        transducer;
    if phase_rad > 0.0 {
        let add = |deviation: &mut f32, size: f32| *deviation = fpu::sqrtf(*deviation * *deviation + size * size);
        add(&mut deviations.series_resonance_hz, 0.5 * phase_rad * *hz / *q);
        add(&mut deviations.q, phase_rad * *q);
        add(&mut deviations.rm_ohm, phase_rad * *rm_ohm);
        add(&mut deviations.lm_h, phase_rad * *lm_h);
    }
    // `fp / fs = sqrt(1 + Cm / C0)`, and the coupling is `sqrt(Cm / (C0 + Cm))`.
    let part = *cm_f / (*c0_f + *cm_f);
    deviations.c0_f += C0_UNCERTAINTY_REL * *c0_f;
    deviations.parallel_resonance_hz += 0.5 * part * C0_UNCERTAINTY_REL * *parallel_resonance_hz;
    deviations.coupling += 0.5 * (1.0 - part) * C0_UNCERTAINTY_REL * *coupling;
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
