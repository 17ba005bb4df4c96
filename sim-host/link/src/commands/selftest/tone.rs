//! Amplitude and phase of a tone in a capture, block by block: the amplitude of the board's tone
//! changes between blocks, its frequency does not.
//!
//! In each block least squares with the columns `1, cos(h w t), sin(h w t)`, `h = 1..=HARMONICS`,
//! gives one phasor per harmonic. The frequency minimises the residual of the played codes.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};
use num_complex::Complex;

/// Number of fitted harmonics, the fundamental included.
const HARMONICS: usize = 5;
/// Smallest amplitude of the played codes in a block that is analysed, codes.
const MIN_PLAYED_CODES: f64 = 8.0;
/// Range of the search for the frequency, relative to the nominal frequency of the drive.
const SEARCH_REL: (f64, f64) = (0.5, 1.2);
/// Frequencies of the coarse search.
const COARSE_STEPS: usize = 281;
/// Halvings of the step around the best frequency.
const REFINEMENTS: usize = 20;

/// Tone in a capture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tone {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Number of blocks with the tone.
    pub blocks: usize,
    /// Largest amplitude of the played codes in a block, codes.
    pub played_codes: f64,
    /// Amplitude of the voltage channel, codes per played code.
    pub v_gain: f64,
    /// Amplitude of the current channel, codes per played code.
    pub i_gain: f64,
    /// Delay of the current channel relative to the voltage channel, s.
    pub skew_s: f64,
    /// Delay of the voltage channel relative to the played codes, s.
    pub delay_s: f64,
    /// Harmonics of the voltage channel relative to its fundamental.
    pub thd: f64,
}

/// Finds the tone in the codes of both channels and of the drive; `None` if no block has one.
pub fn find(v: &[u16], i: &[u16], drive: &[u16], block_samples: usize, sample_hz: f64, nominal_hz: f64) -> Option<Tone> {
    let blocks = |codes: &[u16]| -> Vec<DVector<f64>> {
        codes
            .chunks_exact(block_samples)
            .map(|block| DVector::from_iterator(block.len(), block.iter().map(|&code| code.into())))
            .collect()
    };
    let (v, i, drive) = (blocks(v), blocks(i), blocks(drive));
    let swing = |block: &DVector<f64>| 0.5 * (block.max() - block.min());
    let tones: Vec<usize> = (0..drive.len()).filter(|&n| swing(&drive[n]) >= MIN_PLAYED_CODES).collect();
    let loudest = tones.iter().copied().max_by(|a, b| swing(&drive[*a]).total_cmp(&swing(&drive[*b])))?;
    let residual = |hz: f64| -> f64 { tones.iter().map(|&n| fit(&drive[n], hz / sample_hz, 1).1).sum() };
    let frequency_hz = minimum(residual, SEARCH_REL.0 * nominal_hz, SEARCH_REL.1 * nominal_hz);
    let phasors = |block: &DVector<f64>| fit(block, frequency_hz / sample_hz, HARMONICS).0;
    // Weighted with the played power: sums of products with the conjugate of the reference.
    let zero = Complex::new(0.0, 0.0);
    let (mut skew, mut delay, mut i_power, mut v_power, mut power) = (zero, zero, 0.0, 0.0, 0.0);
    for &n in &tones {
        let [v, i, drive] = [&v[n], &i[n], &drive[n]].map(|block| phasors(block)[0]);
        skew += i * v.conj();
        delay += v * drive.conj();
        (i_power, v_power, power) = (i_power + i.norm_sqr(), v_power + v.norm_sqr(), power + drive.norm_sqr());
    }
    let loud = phasors(&v[loudest]);
    let later_s = |product: Complex<f64>| -product.arg() / (TAU * frequency_hz);
    Some(Tone {
        frequency_hz,
        blocks: tones.len(),
        played_codes: phasors(&drive[loudest])[0].norm(),
        v_gain: (v_power / power).sqrt(),
        i_gain: (i_power / power).sqrt(),
        skew_s: later_s(skew),
        delay_s: later_s(delay),
        thd: loud[1..].iter().map(Complex::norm_sqr).sum::<f64>().sqrt() / loud[0].norm(),
    })
}

/// Fits harmonics of a frequency, in cycles per sample, to the samples of a block. Returns the
/// phasor of each, and the sum of squares that remains.
fn fit(block: &DVector<f64>, cycles: f64, harmonics: usize) -> (Vec<Complex<f64>>, f64) {
    let columns = DMatrix::from_fn(block.len(), 1 + 2 * harmonics, |n, column| {
        let angle = TAU * cycles * column.div_ceil(2) as f64 * n as f64;
        if column % 2 == 0 && column > 0 { angle.sin() } else { angle.cos() }
    });
    let Ok(found) = columns.clone().svd(true, true).solve(block, 1e-12) else {
        return (vec![Complex::new(0.0, 0.0); harmonics], f64::INFINITY);
    };
    let phasors = (0..harmonics).map(|h| Complex::new(found[1 + 2 * h], -found[2 + 2 * h])).collect();
    (phasors, (columns * found - block).norm_squared())
}

/// Returns the place of the lowest value within a range.
fn minimum(value: impl Fn(f64) -> f64, low: f64, high: f64) -> f64 {
    let mut step = (high - low) / (COARSE_STEPS - 1) as f64;
    let places = (0..COARSE_STEPS).map(|n| low + step * n as f64);
    let mut best = places.map(|at| (value(at), at)).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, low));
    for _ in 0..REFINEMENTS {
        step *= 0.5;
        for at in [best.1 - step, best.1 + step] {
            let there = value(at);
            if there < best.0 {
                best = (there, at);
            }
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Codes of a rising tone, `later_s` later than the drive, with this gain and second harmonic.
    fn codes(gain: f64, later_s: f64, second: f64) -> Vec<u16> {
        let wave = |n: usize| {
            let phase = TAU * 34e3 * (n as f64 / 1e6 - later_s);
            let rise = 10.0 * (n / 100) as f64;
            (2048.0 + gain * rise * (phase.sin() + second * (2.0 * phase).sin())).round() as u16
        };
        (0..1000).map(wave).collect()
    }

    #[test]
    fn gain_skew_and_distortion_of_a_tone_are_found() {
        let (drive, v, i) = (codes(1.0, 0.0, 0.0), codes(2.0, 0.5e-6, 0.01), codes(2.0, 1.5e-6, 0.0));
        let tone = find(&v, &i, &drive, 100, 1e6, 40e3).unwrap();
        assert!((tone.frequency_hz - 34e3).abs() < 2.0, "{tone:?}");
        assert!((tone.v_gain - 2.0).abs() < 0.01 && (tone.i_gain - 2.0).abs() < 0.01, "{tone:?}");
        assert!((tone.skew_s - 1e-6).abs() < 5e-9 && (tone.delay_s - 0.5e-6).abs() < 5e-9, "{tone:?}");
        assert!((tone.thd - 0.01).abs() < 3e-3, "{tone:?}");
        assert_eq!(tone.blocks, 9);
    }

    #[test]
    fn silence_has_no_tone() {
        let silence = vec![2048; 1000];
        assert_eq!(find(&silence, &silence, &silence, 100, 1e6, 40e3), None);
    }
}
