//! Fourier coefficients of voltage and current at frequencies around a reference, accumulated block
//! by block.
//!
//! The line frequencies are integer multiples of the inverse sweep period. A repeated sweep has all
//! its energy in these lines. A free vibration starts and ends the record with the same phase in
//! all of them. Its contributions at the beginning and at the end are therefore one smooth function
//! of frequency ([`crate::find::identify::pole_fit`]).

use crate::generate::shape::sine;
use crate::seam::phasor::Phasor;
use crate::sense::demod::Sensed;

/// Maximum number of lines on each side of the reference.
pub(crate) const MOST_PAIRS: usize = 20;
/// Maximum number of lines.
pub(crate) const MOST_LINES: usize = 2 * MOST_PAIRS + 1;

/// Voltage and current at rising frequencies.
#[derive(Clone, Debug)]
pub(crate) struct Spectrum {
    /// Frequency of the reference, as an offset from the nominal frequency, Hz.
    centre_hz: f32,
    /// Distance between lines, Hz.
    spacing_hz: f32,
    pairs: usize,
    /// Phase step per block of one turn per period.
    word: u64,
    phase: u64,
    middle: Sensed,
    /// Lines above and below the reference, from the reference outwards.
    around: [Pair; MOST_PAIRS],
}

/// Two lines at the same distance above and below the reference.
#[derive(Clone, Copy, Debug, Default)]
struct Pair {
    above: Sensed,
    below: Sensed,
}

impl Spectrum {
    /// Creates an empty spectrum around `centre_hz`, for a sweep of width `width_hz` that takes
    /// `period_blocks` blocks of duration `block_s`.
    pub(crate) fn new(centre_hz: f32, width_hz: f32, period_blocks: u32, block_s: f32) -> Self {
        let spacing_hz = 1.0 / (period_blocks.max(1) as f32 * block_s);
        let pairs = (0.5 * width_hz / spacing_hz + 0.5) as usize;
        let word = u64::MAX / u64::from(period_blocks.max(1));
        let (middle, around) = (Sensed::default(), [Pair::default(); MOST_PAIRS]);
        Spectrum { centre_hz, spacing_hz, pairs: pairs.min(MOST_PAIRS), word, phase: 0, middle, around }
    }

    /// Adds the phasors of the next block.
    pub(crate) fn add(&mut self, sensed: &Sensed) {
        let step = sine::rotation(self.phase).conj();
        self.phase = self.phase.wrapping_add(self.word);
        self.middle.v += sensed.v;
        self.middle.i += sensed.i;
        let mut turn = step;
        for Pair { above, below } in self.around.iter_mut().take(self.pairs) {
            both_ways((&mut above.v, &mut below.v), sensed.v, turn);
            both_ways((&mut above.i, &mut below.i), sensed.i, turn);
            turn *= step;
        }
    }

    /// Returns the number of lines.
    pub(crate) fn lines(&self) -> usize {
        2 * self.pairs + 1
    }

    /// Returns the offset of a line from the nominal frequency, Hz.
    pub(crate) fn offset_hz(&self, line: usize) -> f32 {
        self.centre_hz + (line as f32 - self.pairs as f32) * self.spacing_hz
    }

    /// Returns the offset of the centre from the nominal frequency, Hz.
    pub(crate) fn centre_hz(&self) -> f32 {
        self.centre_hz
    }

    /// Returns the distance between lines, Hz.
    pub(crate) fn spacing_hz(&self) -> f32 {
        self.spacing_hz
    }

    /// Returns voltage and current of a line.
    pub(crate) fn at(&self, line: usize) -> Sensed {
        let pair = |distance: usize| self.around.get(distance - 1).copied().unwrap_or_default();
        match line {
            _ if line == self.pairs => self.middle,
            _ if line > self.pairs => pair(line - self.pairs).above,
            _ => pair(self.pairs - line).below,
        }
    }
}

/// Adds `x` rotated by `turn` to `above`, and rotated by `-turn` to `below`; both share four
/// products.
#[inline(always)]
fn both_ways((above, below): (&mut Phasor, &mut Phasor), x: Phasor, turn: Phasor) {
    let (cc, ss, cs, sc) = (x.re * turn.re, x.im * turn.im, x.re * turn.im, x.im * turn.re);
    *above += Phasor::new(cc - ss, sc + cs);
    *below += Phasor::new(cc + ss, sc - cs);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tone_appears_in_its_line_only() {
        let mut spectrum = Spectrum::new(100.0, 3000.0, 256, 32e-6);
        let tone = |block: u32, line: f32| {
            let angle = core::f32::consts::TAU * line * block as f32 / 256.0;
            Phasor::new(libm::cosf(angle), libm::sinf(angle))
        };
        for block in 0..256 {
            spectrum.add(&Sensed { v: tone(block, 3.0), i: tone(block, -7.0) });
        }
        assert_eq!(spectrum.lines(), 25);
        for line in 0..25 {
            let (v, i) = (spectrum.at(line).v / 256.0, spectrum.at(line).i / 256.0);
            let expected = |at: usize| Phasor::new(f32::from(line == at), 0.0);
            assert!((v - expected(15)).norm_sqr() < 1e-10 && (i - expected(5)).norm_sqr() < 1e-10, "{line}: {v} {i}");
        }
        assert!((spectrum.offset_hz(15) - 100.0 - 3.0 * 122.0703).abs() < 1e-2);
    }
}
