//! Lock-in: a block of voltage and current against the drive's own phase.
//!
//! For `x(n) = Re{X exp(j theta(n))}`, `theta(n) = theta0 + n omega`, the least-squares `X` over `N` samples is, in closed
//! form for any block length and any frequency (the conjugate term removes the image that a plain boxcar leaves):
//!
//! ```text
//! r  = sum x(n) exp(-j theta(n))
//! S2 = sum exp(-2j theta(n)) = exp(-j (2 theta0 + (N - 1) omega)) sin(N omega) / sin(omega)
//! X  = (2 / N) (r - conj(r) S2 / N) / (1 - |S2|^2 / N^2)
//! ```
//!
//! Being the least-squares fit, it is at the Cramer-Rao bound in white noise. The sum `r` comes from a resonator that the codes ring up
//! (G. Goertzel 1958):
//!
//! ```text
//! s(n) = x(n) + 2 cos(omega) s(n - 1) - s(n - 2),    r = exp(-j theta(N - 1)) (s(N - 1) - exp(-j omega) s(N - 2))
//! ```
//!
//! The same pass over the codes shows the [guard](crate::guard) where it need not look: with `E = sum x^2 - Re{X conj(r)}`, the energy that the
//! tone leaves unexplained, no sample is larger than `|X| + sqrt(E)`.

use crate::generate::nco::Stretch;
use crate::generate::shape::sine;
use crate::seam::block::SenseBlock;
use crate::seam::phasor::Phasor;
use crate::sense::convert::{Convert, SenseScale};

/// Beyond this `|S2|^2 / N^2` single precision has not much to say of a phasor.
const BLIND: f32 = 0.95;

/// Voltage and current of one block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sensed {
    /// Voltage at the stack, V peak.
    pub v: Phasor,
    /// Total current, A peak.
    pub i: Phasor,
}

/// Whether codes of a block may be an end of the converter's range, or beyond the channel's limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Suspect {
    /// Codes of the voltage channel may be.
    pub v: bool,
    /// Codes of the current channel may be.
    pub i: bool,
}

/// Voltage and current phasors of a block in which a tone was played (a chirp's chord), and what is out of order in it.
///
/// The sine of `omega` must not vanish: the frequency lies between zero and half the sample rate. A block that was cut to less
/// than two samples determines no phasor: zero.
pub fn demodulate(convert: &Convert, sense: &SenseBlock, tone: &Stretch) -> (Sensed, Suspect) {
    let samples = sense.v.len().min(sense.i.len());
    if samples < 2 {
        return (Sensed::default(), Suspect { v: true, i: true });
    }
    let count = samples as f32;
    let turn = sine::rotation(tone.word);
    let span = tone.word.wrapping_mul(samples as u64);
    // The phase in the middle of the block leads to the last sample's, and twice of it is that of S2.
    let half = sine::rotation(span / 2);
    let middle = sine::rotation(tone.phase.wrapping_add(span / 2).wrapping_sub(tone.word / 2)).conj();
    let last = sine::rotation(tone.phase.wrapping_add(span).wrapping_sub(tone.word)).conj();
    // Where the block shows so little of a period that the fit cannot distinguish sine from cosine, the guard looks for itself.
    let image = middle * middle * (2.0 * half.im * half.re / (turn.im * count));
    let scale = 2.0 / (count * (1.0 - image.norm_sqr()));
    let blind = image.norm_sqr() > BLIND;
    let (v, i) = ring(convert, &sense.v[..samples], &sense.i[..samples], 2.0 * turn.re);
    let fit = |channel: &SenseScale, ring: Ring| {
        let r = last * ring.against(turn);
        let x = (r - r.conj() * image) * scale;
        let left = ring.energy - (x.re * r.re + x.im * r.im);
        (channel.scale(x), blind || !channel.holds(x.norm_sqr(), left))
    };
    let ((v, v_suspect), (i, i_suspect)) = (fit(&convert.v, v), fit(&convert.i, i));
    (Sensed { v, i }, Suspect { v: v_suspect, i: i_suspect })
}

/// The resonator of a channel.
#[derive(Clone, Copy, Default)]
struct Ring {
    /// `s(n)` and `s(n - 1)`.
    late: f32,
    early: f32,
    /// Of the codes so far.
    energy: f32,
}

impl Ring {
    /// Takes a code about zero; `k` is `2 cos(omega)`.
    #[inline(always)]
    fn take(&mut self, x: f32, k: f32) {
        self.energy += x * x;
        (self.late, self.early) = (x - self.early + k * self.late, self.late);
    }

    /// What has been rung up, against the phase of the last code.
    #[inline]
    fn against(&self, turn: Phasor) -> Phasor {
        Phasor::new(self.late - turn.re * self.early, turn.im * self.early)
    }
}

/// Lets the codes of both channels, equally many, ring up a resonator each. Side by side, neither waits for its own last step.
#[inline(always)]
fn ring(convert: &Convert, v: &[u16], i: &[u16], k: f32) -> (Ring, Ring) {
    let (v_zero, i_zero) = (convert.v.zero(), convert.i.zero());
    let mut rings = (Ring::default(), Ring::default());
    let ((v_fours, v_rest), (i_fours, i_rest)) = (v.as_chunks::<4>(), i.as_chunks::<4>());
    // Written out: a compiler that saves code leaves a loop or a closure here, with all of its state in memory.
    for ([v0, v1, v2, v3], [i0, i1, i2, i3]) in v_fours.iter().zip(i_fours) {
        rings = both(rings, (*v0, *i0), (v_zero, i_zero), k);
        rings = both(rings, (*v1, *i1), (v_zero, i_zero), k);
        rings = both(rings, (*v2, *i2), (v_zero, i_zero), k);
        rings = both(rings, (*v3, *i3), (v_zero, i_zero), k);
    }
    for (v, i) in v_rest.iter().zip(i_rest) {
        rings = both(rings, (*v, *i), (v_zero, i_zero), k);
    }
    rings
}

/// A sample of both channels.
#[inline(always)]
fn both((mut v_ring, mut i_ring): (Ring, Ring), (v, i): (u16, u16), (v_zero, i_zero): (f32, f32), k: f32) -> (Ring, Ring) {
    v_ring.take(f32::from(v) - v_zero, k);
    i_ring.take(f32::from(i) - i_zero, k);
    (v_ring, i_ring)
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
                // Half a step of rounding over a few samples bounds both; short blocks of 20 kHz hold a third of a period.
                let bound = if (samples as f64) * hz < 0.7e6 { 2.5e-3 } else { 4e-4 };
                assert!((magnitude(sensed.v) / 15.0 - 1.0).abs() < bound, "{samples} {hz} {sensed:?}");
                assert!((magnitude(sensed.i) / 1.8 - 1.0).abs() < bound, "{samples} {hz} {sensed:?}");
                assert!((argument(sensed.i * sensed.v.conj()).0 + 0.1).abs() < bound / 5.0, "{samples} {hz} {sensed:?}");
            }
        }
    }

    /// One code at an end of the range is never overlooked, wherever it stands and however large the tone is.
    #[test]
    fn no_code_out_of_order_is_overlooked() {
        let mut convert = Convert::build(&FrontEnd::OF_TESTS).unwrap();
        convert.i.set_limit(3.0);
        let played = Stretch { phase: tuning_word(0.3), word: tuning_word(0.0404), step: 0 };
        for amplitude in [0.0, 10.0, 700.0, 1400.0] {
            for (n, code, v) in (0..32).flat_map(|n| [(n, 0, true), (n, 4095, true), (n, 3549, false), (n, 547, false)]) {
                let clean = tone(amplitude, 0.3, 40_400.0, 32);
                let mut sense = SenseBlock { v: clean.clone(), i: clean, ..SenseBlock::default() };
                assert_eq!(demodulate(&convert, &sense, &played).1, Suspect::default(), "{amplitude}");
                let channel = if v { &mut sense.v } else { &mut sense.i };
                channel[n] = code;
                let suspect = demodulate(&convert, &sense, &played).1;
                assert!(if v { suspect.v } else { suspect.i }, "{amplitude} {n} {code}: {suspect:?}");
            }
        }
    }
}
