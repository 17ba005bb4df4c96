//! Fourier coefficients of voltage and current at a row of frequencies about a reference, gathered block by block.
//!
//! The frequencies are `b` over the period of the sweep, so that a sweep that is repeated puts all its energy there, and a tone that rings
//! freely begins and ends with the same phase in all of them: the free vibration at the beginning of a record, and that at its end, is one and
//! the same smooth function of frequency ([`crate::find::identify::pole_fit`]).

use crate::generate::shape::sine;
use crate::seam::phasor::Phasor;
use crate::sense::demod::Sensed;

/// The most frequencies on each side of the reference.
pub(crate) const MOST_PAIRS: usize = 20;
/// The most frequencies.
pub(crate) const MOST_LINES: usize = 2 * MOST_PAIRS + 1;

/// Voltage and current at rising frequencies.
#[derive(Clone, Debug)]
pub(crate) struct Spectrum {
    /// Frequency of the reference, as an offset from the nominal one, and from one line to the next, Hz.
    centre_hz: f32,
    spacing_hz: f32,
    pairs: usize,
    /// Of a turn in so many blocks as a period has.
    word: u64,
    phase: u64,
    middle: Sensed,
    /// The lines above and below the reference, from it outwards.
    around: [Pair; MOST_PAIRS],
}

/// Two lines as far above the reference and below it.
#[derive(Clone, Copy, Debug, Default)]
struct Pair {
    above: Sensed,
    below: Sensed,
}

impl Spectrum {
    /// An empty one, about `centre_hz`, of a sweep that has `period_blocks` of `block_s` and is `width_hz` wide.
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

    /// How many lines there are.
    pub(crate) fn lines(&self) -> usize {
        2 * self.pairs + 1
    }

    /// Offset of a line from the nominal frequency, Hz.
    pub(crate) fn offset_hz(&self, line: usize) -> f32 {
        self.centre_hz + (line as f32 - self.pairs as f32) * self.spacing_hz
    }

    /// Offset of the middle from the nominal frequency, Hz.
    pub(crate) fn centre_hz(&self) -> f32 {
        self.centre_hz
    }

    /// From line to line, Hz.
    pub(crate) fn spacing_hz(&self) -> f32 {
        self.spacing_hz
    }

    /// Voltage and current of a line.
    pub(crate) fn at(&self, line: usize) -> Sensed {
        let pair = |distance: usize| self.around.get(distance - 1).copied().unwrap_or_default();
        match line {
            _ if line == self.pairs => self.middle,
            _ if line > self.pairs => pair(line - self.pairs).above,
            _ => pair(self.pairs - line).below,
        }
    }
}

/// Adds `x` turned by `turn` above, and turned the other way below: the four products are the same.
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
    fn a_tone_stands_in_its_line_only() {
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
