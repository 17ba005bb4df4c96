//! Amplitude spectra of evenly sampled signals.

use realfft::RealFftPlanner;

/// Half the width of a line, bins: the window's main lobe.
pub const LOBE_BINS: usize = 4;

/// Amplitude spectrum, in which a sine of amplitude a has a peak of a.
pub struct Spectrum {
    /// Spacing of the bins, Hz.
    pub bin_hz: f64,
    /// Amplitude of each bin.
    pub amplitude: Vec<f64>,
}

/// Line of a spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Frequency of the line, Hz.
    pub hz: f64,
    /// Amplitude of the line.
    pub amplitude: f64,
}

impl Spectrum {
    /// Computes the spectrum of samples at intervals of `every_s`, through a four-term
    /// Blackman-Harris window (Harris 1978; side lobes at -92 dB).
    pub fn new(samples: &[f64], every_s: f64) -> Self {
        let count = samples.len();
        let transform = RealFftPlanner::<f64>::new().plan_fft_forward(count);
        let mut sum = 0.0;
        let mut windowed: Vec<f64> = samples
            .iter()
            .enumerate()
            .map(|(index, sample)| {
                let angle = std::f64::consts::TAU * index as f64 / count as f64;
                let weight = 0.358_75 - 0.488_29 * angle.cos() + 0.141_28 * (2.0 * angle).cos() - 0.011_68 * (3.0 * angle).cos();
                sum += weight;
                sample * weight
            })
            .collect();
        let mut bins = transform.make_output_vec();
        let done = transform.process(&mut windowed, &mut bins).is_ok();
        let amplitude = bins.iter().map(|bin| if done { 2.0 * bin.norm() / sum } else { f64::NAN }).collect();
        Spectrum { bin_hz: 1.0 / (count as f64 * every_s), amplitude }
    }

    /// Returns the frequencies of the bins up to a limit, Hz.
    pub fn frequencies_hz(&self, up_to_hz: f64) -> Vec<f64> {
        (0..self.amplitude.len()).map(|bin| bin as f64 * self.bin_hz).take_while(|&hz| hz <= up_to_hz).collect()
    }

    /// Returns the amplitude at a frequency, Hz: the largest within a line's width.
    pub fn at(&self, hz: f64) -> f64 {
        let bin = (hz / self.bin_hz).round() as usize;
        let (from, to) = (bin.saturating_sub(LOBE_BINS / 2), (bin + LOBE_BINS / 2 + 1).min(self.amplitude.len()));
        self.amplitude[from.min(to)..to].iter().copied().fold(0.0, f64::max)
    }

    /// Returns the lines between two frequencies that are above a floor and the largest within
    /// their width.
    pub fn lines(&self, from_hz: f64, to_hz: f64, floor: f64) -> Vec<Line> {
        let (first, last) = ((from_hz / self.bin_hz) as usize, (to_hz / self.bin_hz) as usize);
        (first..last.min(self.amplitude.len()))
            .filter(|&bin| {
                let around = &self.amplitude[bin.saturating_sub(LOBE_BINS)..(bin + LOBE_BINS + 1).min(self.amplitude.len())];
                self.amplitude[bin] > floor && around.iter().all(|&other| other <= self.amplitude[bin])
            })
            .map(|bin| Line { hz: bin as f64 * self.bin_hz, amplitude: self.amplitude[bin] })
            .collect()
    }

    /// Returns the share of the power between two frequencies that is outside the lines at `hz`.
    pub fn elsewhere(&self, from_hz: f64, to_hz: f64, hz: &[f64]) -> f64 {
        let (first, last) = ((from_hz / self.bin_hz) as usize, (to_hz / self.bin_hz) as usize);
        let (mut all, mut other) = (0.0, 0.0);
        for bin in first..last.min(self.amplitude.len()) {
            let power = self.amplitude[bin] * self.amplitude[bin];
            all += power;
            if hz.iter().all(|&hz| (bin as f64 - hz / self.bin_hz).abs() > (LOBE_BINS + 1) as f64) {
                other += power;
            }
        }
        other / all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_have_their_amplitudes() {
        let signal = |n: usize| {
            let t = std::f64::consts::TAU * n as f64 * 1e-6;
            0.7 * (60e3 * t).cos() + 0.002 * (13e3 * t).sin()
        };
        let samples: Vec<f64> = (0..10_000).map(signal).collect();
        let spectrum = Spectrum::new(&samples, 1e-6);
        let lines = spectrum.lines(1e3, 400e3, 1e-3);
        assert_eq!(lines.iter().map(|line| line.hz.round()).collect::<Vec<_>>(), [13e3, 60e3]);
        assert!((lines[1].amplitude - 0.7).abs() < 1e-6 && (spectrum.at(13e3) - 0.002).abs() < 1e-6, "{lines:?}");
        assert!(spectrum.elsewhere(1e3, 400e3, &[13e3, 60e3]) < 1e-9);
    }
}
