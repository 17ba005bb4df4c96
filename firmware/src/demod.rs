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
//! (G. Goertzel 1958), in the form that rounding spares at low frequencies (C. Reinsch):
//!
//! ```text
//! d(n) = d(n - 1) + x(n) - c s(n - 1),    s(n) = s(n - 1) + d(n),    c = 4 sin^2(omega / 2)
//! r    = exp(-j theta(N - 1)) (s (1 - exp(-j omega)) + d exp(-j omega))    of the last s and d
//! ```
//!
//! The same walk over the codes counts those that are out of order, so that the [guard](crate::guard) has to look closer only where there are any.

use crate::block::SenseBlock;
use crate::convert::{Convert, SenseScale};
use crate::nco::Stretch;
use crate::phasor::Phasor;
use crate::shape::sine;

/// Voltage and current of one block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sensed {
    /// Voltage at the stack, V peak.
    pub v: Phasor,
    /// Total current, A peak.
    pub i: Phasor,
}

/// Codes of a block that are an end of the converter's range, or beyond the channel's limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OutOfOrder {
    /// Of the voltage.
    pub v: u32,
    /// Of the current.
    pub i: u32,
}

/// Voltage and current phasors of a block in which a tone was played (a chirp's [chord](Stretch::chord)), and what is out of order in it.
///
/// The sine of `omega` must not vanish: the frequency lies between zero and half the sample rate. A block that was cut to less
/// than two samples determines no phasor: zero.
pub fn demodulate(convert: &Convert, sense: &SenseBlock, tone: &Stretch) -> (Sensed, OutOfOrder) {
    let samples = sense.v.len().min(sense.i.len());
    if samples < 2 {
        return Default::default();
    }
    let count = samples as f32;
    let half = sine::rotation(tone.word / 2);
    let turn = half * half;
    let c = 4.0 * half.im * half.im;
    let (v, v_outside) = ring(&convert.v, &sense.v[..samples], c);
    let (i, i_outside) = ring(&convert.i, &sense.i[..samples], c);

    let span = tone.word.wrapping_mul(samples as u64);
    let last = sine::rotation(tone.phase.wrapping_add(span.wrapping_sub(tone.word))).conj();
    let (of_s, of_d) = (last * Phasor::new(2.0 * half.im * half.im, 2.0 * half.im * half.re), last * turn.conj());
    let twice_middle = tone.phase.wrapping_add(tone.phase).wrapping_add(span.wrapping_sub(tone.word));
    let image = sine::rotation(twice_middle).conj() * (sine::rotation(span).im / (turn.im * count));
    let scale = 2.0 / (count * (1.0 - image.norm_sqr()));
    let solve = |(s, d): (f32, f32)| {
        let r = of_s * s + of_d * d;
        (r - r.conj() * image) * scale
    };
    let sensed = Sensed { v: convert.v.scale(solve(v)), i: convert.i.scale(solve(i)) };
    (sensed, OutOfOrder { v: v_outside, i: i_outside })
}

/// What the codes of a channel ring up, as value and difference; and how many of them are out of order.
#[inline]
fn ring(channel: &SenseScale, codes: &[u16], c: f32) -> ((f32, f32), u32) {
    let (mut s, mut d, mut outside) = (0.0, 0.0, 0);
    for &code in codes {
        outside += u32::from(channel.is_out_of_order(code));
        d = d + channel.centre(code) - c * s;
        s += d;
    }
    ((s, d), outside)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::block::Codes;
    use crate::config::FrontEnd;
    use crate::nco::tuning_word;
    use crate::phasor::{argument, magnitude};

    const FRONT_END: FrontEnd = FrontEnd {
        volt_per_lsb: 0.01,
        ampere_per_lsb: 0.002,
        sense_mid_code: 2048,
        sense_max_code: 4095,
        drive_volt_per_lsb: 0.01,
        drive_mid_code: 2048,
        drive_max_code: 4095,
        drive_lanes: 4,
    };

    fn tone(amplitude: f64, turns: f64, hz: f64, samples: usize) -> Codes {
        let wave = |n: usize| amplitude * libm::cos(core::f64::consts::TAU * (turns + hz * 1e-6 * n as f64));
        (0..samples).map(|n| libm::round(2048.0 + wave(n)) as u16).collect()
    }

    #[test]
    fn finds_amplitude_and_phase_at_any_block_length_and_frequency() {
        let convert = Convert::build(&FRONT_END).unwrap();
        for samples in [16, 25, 32, 50, 64] {
            for hz in [20_000.0, 40_000.0, 40_400.0, 61_234.5] {
                let phase = 0.123_f64;
                let sense = SenseBlock {
                    v: tone(1500.0, phase, hz, samples),
                    i: tone(900.0, phase - 0.1, hz, samples),
                    ..SenseBlock::default()
                };
                let played = Stretch { phase: tuning_word(phase), word: tuning_word(hz / 1e6), step: 0 };
                let (sensed, outside) = demodulate(&convert, &sense, &played);
                assert_eq!(outside, OutOfOrder::default());
                // Half a step of rounding over a few samples bounds both; short blocks of 20 kHz hold a third of a period.
                let bound = if (samples as f64) * hz < 0.7e6 { 2.5e-3 } else { 4e-4 };
                assert!((magnitude(sensed.v) / 15.0 - 1.0).abs() < bound, "{samples} {hz} {sensed:?}");
                assert!((magnitude(sensed.i) / 1.8 - 1.0).abs() < bound, "{samples} {hz} {sensed:?}");
                assert!((argument(sensed.i * sensed.v.conj()).0 + 0.1).abs() < bound / 5.0, "{samples} {hz} {sensed:?}");
            }
        }
    }
}
