//! The waveform of a block in fixed point: computed sample by sample from its shape, then rounded
//! to codes under its envelope.
//!
//! `code = floor(base + peak wave)`, with the wave in 2^-30 and the peak, in codes, in 2^-15. The
//! product in 2^-13 is then the upper half of 64 bits: low by up to 1.2e-4 of a code.

use crate::generate::burst::envelope::Envelope;
use crate::generate::nco::Phases;
use crate::generate::shape::bands::Blend;
use crate::generate::shape::noise::{Dither, Noise};
use crate::generate::shape::sine::{Coefficient, Steps, Swing};
use crate::seam::block::MAX_BLOCK_SAMPLES;
use crate::seam::fixed_point::upper;

/// Number of fraction bits of a code, as it is written.
const FRACTION_BITS: u32 = 13;

/// Waveform, sample by sample: 2^30 is one.
#[derive(Clone, Debug)]
pub(super) struct Wave([i32; MAX_BLOCK_SAMPLES]);

impl Default for Wave {
    fn default() -> Self {
        Wave([0; MAX_BLOCK_SAMPLES])
    }
}

impl Wave {
    /// Peak with which a wave of steps is written, codes: the largest possible, because steps are
    /// codes in 2^-15.
    pub(super) const STEPS_PEAK_CODES: f32 = 32_768.0;

    fn first(&mut self, samples: usize) -> &mut [i32] {
        self.0.get_mut(..samples).unwrap_or_default()
    }

    /// Computes a sine of constant frequency, in steps.
    pub(super) fn swing(&mut self, swing: &Swing, samples: usize) {
        fn swing_of<const SHIFT: u32>(mut steps: Steps, wave: &mut [i32]) {
            four_by_four(wave, || steps.take::<SHIFT>());
        }
        match swing.steps() {
            (steps, false) => swing_of::<0>(steps, self.first(samples)),
            (steps, true) => swing_of::<{ Coefficient::SHIFT }>(steps, self.first(samples)),
        }
    }

    /// Computes a blend of two tables.
    pub(super) fn read(&mut self, blend: &Blend, mut phases: Phases, samples: usize) {
        if blend.weight == 1.0 {
            return self.first(samples).iter_mut().for_each(|place| *place = blend.upper.at(phases.take()));
        }
        // At a constant frequency, a sample takes less time.
        match phases.steady() {
            Some((phase, word)) => self.mix_steady(blend, samples, phase, word),
            None => self.mix_moving(blend, samples, phases),
        }
    }

    /// Computes a blend of two tables at a constant frequency.
    // Not inlined, so that there are enough registers.
    #[inline(never)]
    fn mix_steady(&mut self, blend: &Blend, samples: usize, mut phase: u32, word: u32) {
        let weight = blend.weight();
        for place in self.first(samples) {
            *place = blend.at(phase, weight);
            phase = phase.wrapping_add(word);
        }
    }

    /// Computes a blend of two tables at a changing frequency.
    #[inline(never)]
    fn mix_moving(&mut self, blend: &Blend, samples: usize, mut phases: Phases) {
        let weight = blend.weight();
        self.first(samples).iter_mut().for_each(|place| *place = blend.at(phases.take(), weight));
    }

    /// Computes a noise.
    pub(super) fn fill(&mut self, noise: &mut Noise, samples: usize) {
        noise.fill(self.first(samples));
    }

    /// Rounds the waveform to codes under an envelope, with this peak in codes, about a base with
    /// which truncation rounds. Returns the sum of the codes. A block with an edge has no dither:
    /// rounding errors that follow the signal matter only in a long tone, and silence must be
    /// silent.
    pub(super) fn write(&self, peak: f32, base: f32, envelope: &Envelope, dither: Option<&mut Dither>, codes: &mut [u16]) -> i32 {
        let base = (base * (1 << FRACTION_BITS) as f32) as i32;
        // In 2^-15: up to 2^16 codes.
        let fixed = |codes: f32| (codes * 32_768.0) as i32;
        match (envelope, dither) {
            (Envelope::Edge(levels), _) => self.edge(fixed(peak * levels.loudest), base, levels.parts, codes),
            (Envelope::Flat(level), None) => {
                let peak = fixed(peak * level);
                self.put(codes, || [0; 2], |wave, _| base + upper(wave, peak))
            }
            (Envelope::Flat(level), Some(dither)) => self.dithered(fixed(peak * level), base, dither, codes),
        }
    }

    /// Rounds with dither.
    // Not inlined, so that there are enough registers.
    #[inline(never)]
    fn dithered(&self, peak: i32, base: i32, dither: &mut Dither, codes: &mut [u16]) -> i32 {
        self.put(codes, || dither.take::<FRACTION_BITS>(), |wave, dither| base + upper(wave, peak) + dither)
    }

    /// Rounds under the levels of an edge, given as parts: 2^31 for the largest level.
    #[inline(always)]
    fn edge(&self, peak: i32, base: i32, parts: &[i32], codes: &mut [u16]) -> i32 {
        let (mut sum, end) = (0, codes.len().saturating_sub(1));
        let mut put = |place: &mut u16, wave, part| {
            let code = (base + upper(upper(wave, part) << 1, peak)) >> FRACTION_BITS;
            *place = code as u16;
            sum += code;
        };
        let ((pairs, rest), (parts, last)) = (codes.as_chunks_mut::<2>(), parts.as_chunks::<2>());
        for (([first, second], [wave, next]), [part, other]) in pairs.iter_mut().zip(self.0.as_chunks::<2>().0).zip(parts) {
            put(first, *wave, *part);
            put(second, *next, *other);
        }
        if let ([only], [part], Some(wave)) = (rest, last, self.0.get(end)) {
            put(only, *wave, *part);
        }
        sum
    }

    /// Writes all codes, two at a time, from the wave and from the values of `next`.
    #[inline(always)]
    fn put(&self, codes: &mut [u16], mut next: impl FnMut() -> [i32; 2], value: impl Fn(i32, i32) -> i32) -> i32 {
        let (mut sum, last) = (0, codes.len().saturating_sub(1));
        let mut put = |place: &mut u16, wave, other| {
            let code = value(wave, other) >> FRACTION_BITS;
            *place = code as u16;
            sum += code;
        };
        let (pairs, rest) = codes.as_chunks_mut::<2>();
        for ([first, second], [wave, following]) in pairs.iter_mut().zip(self.0.as_chunks::<2>().0) {
            let [one, other] = next();
            put(first, *wave, one);
            put(second, *following, other);
        }
        if let ([only], Some(wave)) = (rest, self.0.get(last)) {
            put(only, *wave, next()[0]);
        }
        sum
    }
}

/// Fills a wave, four samples at a time: a compiler that optimizes for size leaves a loop of one.
#[inline(always)]
fn four_by_four(wave: &mut [i32], mut next: impl FnMut() -> i32) {
    let (fours, rest) = wave.as_chunks_mut::<4>();
    for [first, second, third, fourth] in fours {
        (*first, *second, *third, *fourth) = (next(), next(), next(), next());
    }
    rest.iter_mut().for_each(|place| *place = next());
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::burst::envelope::Levels;
    use crate::generate::nco::{Stretch, tuning_word};
    use crate::generate::shape::sine::Steady;
    use crate::seam::phasor::Phasor;

    const BASE: f32 = 2048.5;

    /// Every code is the nearest one, or its neighbour if the exact value is near half a code.
    /// Covers steps and their peak, levels and edges, and blocks of odd length.
    #[test]
    fn codes_are_the_rounded_product() {
        for samples in [31, 32, 99, 100] {
            let stretch = Stretch { phase: 0x1234_5678_9abc_def0, word: tuning_word(0.0404), step: 0 };
            let mut wave = Wave::default();
            wave.swing(&Steady::new(&stretch).swing(Phasor::new(1900.0, 0.0)), samples);
            let parts: std::vec::Vec<i32> = (0..samples).map(|n| ((n as i32) << 24) - (1 << 30)).collect();
            let edge = Envelope::Edge(Levels { parts: &parts, loudest: 4.0, mean: 0.0 });
            for (envelope, peak) in
                [(Envelope::Flat(1.0), 1.0), (Envelope::Flat(-0.37), 1.0), (Envelope::Flat(3.9), 0.25), (edge, 0.25)]
            {
                let mut codes = std::vec![0; samples];
                let sum = wave.write(peak * Wave::STEPS_PEAK_CODES, BASE, &envelope, None, &mut codes);
                assert_eq!(sum, codes.iter().map(|&code| i32::from(code)).sum::<i32>());
                for (n, &code) in codes.iter().enumerate() {
                    let level = match envelope {
                        Envelope::Flat(level) => f64::from(level),
                        Envelope::Edge(levels) => 4.0 * f64::from(levels.parts[n]) / 2_147_483_648.0,
                    };
                    let phase = core::f64::consts::TAU * (stretch.phase_at(n) as f64 / 18_446_744_073_709_551_616.0);
                    let exact = 2048.0 + 1900.0 * f64::from(peak) * level * libm::sin(phase);
                    assert!((f64::from(code) - exact).abs() < 0.53, "{n} of {samples}: {code} for {exact}");
                }
            }
        }
    }
}
