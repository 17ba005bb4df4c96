//! Lock-in: measures voltage and current of a block relative to the phase of the drive.
//!
//! For `x(n) = Re{X exp(j theta(n))}`, `theta(n) = theta0 + n omega`, the least-squares `X` over
//! `N` samples has a closed form for any block length and frequency (the conjugate term removes the
//! image left by a plain boxcar):
//!
//! ```text
//! r  = sum x(n) exp(-j theta(n))
//! S2 = sum exp(-2j theta(n)) = exp(-j (2 theta0 + (N - 1) omega)) sin(N omega) / sin(omega)
//! X  = (2 / N) (r - conj(r) S2 / N) / (1 - |S2|^2 / N^2)
//! ```
//!
//! As a least-squares fit, it reaches the Cramer-Rao bound in white noise. The sum `r` is computed
//! by a resonator (`resonator.rs`).
//!
//! The same pass over the codes tells the [guard](crate::guard) which blocks need no further check.
//! With `E = sum x^2 - Re{X conj(r)}`, the energy that the tone does not explain, no sample is
//! larger than `|X| + sqrt(E)`.

use crate::generate::nco::Stretch;
use crate::generate::shape::sine::{self, Coefficient};
use crate::seam::block::SenseBlock;
use crate::seam::phasor::Phasor;
use crate::sense::convert::{Convert, SenseScale};
use crate::sense::resonator::ResonatorSum;

/// Value of `|S2|^2 / N^2` above which single precision does not determine a phasor.
const BLIND_IMAGE_SQUARE: f32 = 0.95;
/// Maximum part of the energy of a channel that the tone may leave unexplained.
const MAX_UNEXPLAINED_PART: f32 = 0.1;

/// Voltage and current of one block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sensed {
    /// Voltage at the stack, V peak.
    pub v: Phasor,
    /// Total current, A peak.
    pub i: Phasor,
}

/// Conditions that the guard must check in detail: enough codes at an end of the range to count as
/// clipped, any code beyond the limit of its channel, or unexplained energy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Suspect {
    /// `true` if codes of the voltage channel may be clipped or beyond the limit.
    pub v: bool,
    /// `true` if codes of the current channel may be clipped or beyond the limit.
    pub i: bool,
    /// `true` if the tone leaves more than a tenth of the energy of a channel unexplained, and more
    /// than rounding or a small tone would.
    pub unexplained: bool,
    /// `true` if that channel is the voltage.
    pub distorted: bool,
}

/// Computes the voltage and current phasors of a block in which a tone (or a chirp's chord) was
/// played, and the conditions that need a detailed check.
///
/// The sine of `omega` must not be zero: the frequency must be between zero and half the sample
/// rate. A block of less than two samples does not determine a phasor; the result is zero.
pub fn demodulate(convert: &Convert, sense: &SenseBlock, tone: &Stretch) -> (Sensed, Suspect) {
    let samples = sense.v.len().min(sense.i.len());
    if samples < 2 {
        return (Sensed::default(), Suspect { v: true, i: true, unexplained: true, distorted: true });
    }
    let count = samples as f32;
    let half_turn = sine::rotation(tone.word / 2);
    let (sine_square, turn) = (half_turn.im * half_turn.im, half_turn * half_turn);
    let span = tone.word.wrapping_mul(samples as u64);
    // From the phase in the middle of the block follow that of the last sample, and, doubled, that
    // of S2.
    let half = sine::rotation(span / 2);
    let middle = sine::rotation(tone.phase.wrapping_add(span / 2).wrapping_sub(tone.word / 2)).conj();
    let last = sine::rotation(tone.phase.wrapping_add(span).wrapping_sub(tone.word)).conj();
    // Too small a part of a period does not separate sine and cosine; the guard then checks every
    // code.
    let image = middle * middle * (2.0 * half.im * half.re / (turn.im * count));
    let scale = 2.0 / (count * (1.0 - image.norm_sqr()));
    let blind = image.norm_sqr() > BLIND_IMAGE_SQUARE;
    let reference = Reference { turn, sine_square, last, image, scale };
    let coefficient = Coefficient::of(sine_square);
    let (v, v_fit) = reference.fit(&convert.v, &sense.v[..samples], coefficient);
    let (i, i_fit) = reference.fit(&convert.i, &sense.i[..samples], coefficient);
    let unexplained = v_fit.unexplained | i_fit.unexplained;
    let distorted = v_fit.unexplained;
    (Sensed { v, i }, Suspect { v: blind || !v_fit.holds, i: blind || !i_fit.holds, unexplained, distorted })
}

/// Reference of the fit for both channels of a block.
struct Reference {
    /// Rotation per sample.
    turn: Phasor,
    /// Square of the sine of half that angle.
    sine_square: f32,
    /// Conjugate of the phase of the last sample.
    last: Phasor,
    /// Image `S2 / N`.
    image: Phasor,
    /// Scale `2 / N / (1 - |S2 / N|^2)`.
    scale: f32,
}

impl Reference {
    /// Fits the codes of a channel. Returns the phasor, in SI units, and the quality of the fit.
    #[inline(always)]
    fn fit(&self, channel: &SenseScale, codes: &[u16], coefficient: Coefficient) -> (Phasor, Fit) {
        let sum = ResonatorSum::new(codes, channel.fixed(), coefficient);
        let r = self.last * sum.against(self.turn, self.sine_square);
        let x = (r - r.conj() * self.image) * self.scale;
        let left = sum.energy - (x.re * r.re + x.im * r.im);
        let holds = channel.holds(x.norm_sqr(), left) || channel.is_unclipped(sum.energy, codes.len());
        (
            channel.scale(x),
            Fit { holds, unexplained: left > MAX_UNEXPLAINED_PART * sum.energy && channel.is_large(left, codes.len()) },
        )
    }
}

/// Quality of the fit of a channel.
struct Fit {
    /// `true` if no code can be clipped or beyond the limit.
    holds: bool,
    /// `true` if the tone leaves too much energy unexplained.
    unexplained: bool,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::nco::tuning_word;
    use crate::seam::block::Codes;
    use crate::seam::config::FrontEnd;
    use crate::seam::phasor::{argument, magnitude};

    fn tone(amplitude: f64, turns: f64, hz: f64, samples: usize) -> Codes {
        let wave = |n: usize| amplitude * libm::cos(core::f64::consts::TAU * (turns + hz * 1e-6 * n as f64));
        (0..samples).map(|n| libm::round(2048.0 + wave(n)) as u16).collect()
    }

    #[test]
    fn finds_amplitude_and_phase_at_any_block_length_and_frequency() {
        let convert = Convert::build(&FrontEnd::OF_TESTS).unwrap();
        for samples in [16, 25, 32, 50, 64] {
            for hz in [20_000.0, 40_000.0, 40_400.0, 61_234.5] {
                let phase = 0.123_f64;
                let sense = SenseBlock {
                    v: tone(1500.0, phase, hz, samples),
                    i: tone(900.0, phase - 0.1, hz, samples),
                    ..SenseBlock::default()
                };
                let played = Stretch { phase: tuning_word(phase), word: tuning_word(hz / 1e6), step: 0 };
                let (sensed, suspect) = demodulate(&convert, &sense, &played);
                assert_eq!(suspect, Suspect::default());
                // Rounding by half a step over a few samples limits both; short blocks at 20 kHz
                // contain a third of a period.
                let bound = if (samples as f64) * hz < 0.7e6 { 2.5e-3 } else { 4e-4 };
                assert!((magnitude(sensed.v) / 15.0 - 1.0).abs() < bound, "{samples} {hz} {sensed:?}");
                assert!((magnitude(sensed.i) / 1.8 - 1.0).abs() < bound, "{samples} {hz} {sensed:?}");
                assert!((argument(sensed.i * sensed.v.conj()).0 + 0.1).abs() < bound / 5.0, "{samples} {hz} {sensed:?}");
            }
        }
    }

    /// One code beyond the limit, or more than an eighth of a block at an end of the range, is
    /// always detected, at any position and for any amplitude of the tone.
    #[test]
    fn clipped_or_excessive_codes_are_always_detected() {
        let mut convert = Convert::build(&FrontEnd::OF_TESTS).unwrap();
        convert.i.set_limit(3.0);
        let played = Stretch { phase: tuning_word(0.3), word: tuning_word(0.0404), step: 0 };
        for amplitude in [0.0, 10.0, 700.0, 1400.0] {
            for (n, code, v) in (0..32).flat_map(|n| [(n, 0, true), (n, 4095, true), (n, 3549, false), (n, 547, false)]) {
                let clean = tone(amplitude, 0.3, 40_400.0, 32);
                let mut sense = SenseBlock { v: clean.clone(), i: clean, ..SenseBlock::default() };
                assert_eq!(demodulate(&convert, &sense, &played).1, Suspect::default(), "{amplitude}");
                let (channel, count) = if v { (&mut sense.v, 5) } else { (&mut sense.i, 1) };
                (n..n + count).for_each(|n| channel[n % 32] = code);
                let suspect = demodulate(&convert, &sense, &played).1;
                assert!(if v { suspect.v } else { suspect.i }, "{amplitude} {n} {code}: {suspect:?}");
            }
        }
    }
}
