//! Spectrum of a sequence of codes or samples, and the purity of its tone.
//!
//! ```text
//! P(k) = |sum x(n) w(n) exp(-2 pi j k n / N)|^2,    w(n) = sin(pi n / N)^8
//!
//! SNDR   tone over everything else except the mean          SFDR   tone over the strongest other
//!                                                                  line
//! alias  the strongest harmonic that the sample rate has folded back, relative to the tone
//! ```
//!
//! The window's side lobes fall by 54 dB an octave (Nuttall 1981, IEEE Trans. ASSP 29, "Some
//! windows with very good sidelobe behavior"). They reach 200 dB at 24 bins and fall fast from
//! there, which is below the rounding of f32. Neither tone nor lines need a whole number of
//! periods. The power of a line is the sum of `LOBE_BINS` bins to either side. Noise of a
//! full-scale sine rounded to N bits: `SNDR = 6.02 N + 1.76 dB`.

use std::f64::consts::PI;

use realfft::RealFftPlanner;

/// Number of bins of a line to either side.
const LOBE_BINS: usize = 24;
/// Highest harmonic that is searched among the aliases.
const HIGHEST_HARMONIC: u32 = 1024;

/// The power spectrum of one record, with its tone.
pub struct Spectrum {
    /// Power of each bin, from zero to half the sample rate.
    power: Vec<f64>,
    /// Number of samples.
    count: usize,
    /// Frequency of the tone, cycles a sample.
    tone: f64,
}

impl Spectrum {
    /// Analyses `samples`, which contain a tone of `cycles_per_sample`: an even number, at least a
    /// few hundred, better 2^16.
    pub fn new(samples: &[f64], cycles_per_sample: f64) -> Self {
        let count = samples.len() & !1;
        let mut windowed: Vec<f64> = samples[..count].iter().enumerate().map(|(n, x)| x * window(n, count)).collect();
        let transform = RealFftPlanner::<f64>::new().plan_fft_forward(count);
        let mut bins = transform.make_output_vec();
        // The lengths are those of the plan.
        let done = transform.process(&mut windowed, &mut bins);
        debug_assert!(done.is_ok());
        Spectrum { power: bins.iter().map(|bin| bin.norm_sqr()).collect(), count, tone: cycles_per_sample }
    }

    /// Returns tone over noise and distortion, dB.
    pub fn sndr_db(&self) -> f64 {
        let tone = self.line(self.tone);
        let rest: f64 = self.rest().map(|bin| self.power[bin]).sum();
        decibel(tone / rest)
    }

    /// Returns tone over the strongest other line, dB.
    pub fn sfdr_db(&self) -> f64 {
        let strongest =
            self.rest().map(|bin| self.lobe(bin, |other| !self.is_tone(other) && other > LOBE_BINS)).fold(0.0, f64::max);
        decibel(self.line(self.tone) / strongest)
    }

    /// Returns the strongest folded harmonic, dB relative to the tone.
    ///
    /// A harmonic `k` beyond half the sample rate appears at `|k f - m fs|`. A harmonic that
    /// coincides with the tone, the mean, or a harmonic that is not folded cannot be distinguished
    /// and is omitted. `None` if all are omitted.
    pub fn alias_dbc(&self) -> Option<f64> {
        let own: Vec<usize> = (1..).map(|k| f64::from(k) * self.tone).take_while(|&f| f <= 0.5).map(|f| self.bin(f)).collect();
        let apart = |bin: usize| bin > 2 * LOBE_BINS && own.iter().all(|&other| bin.abs_diff(other) > 2 * LOBE_BINS);
        let folded = (1..=HIGHEST_HARMONIC).map(|k| f64::from(k) * self.tone).filter(|&f| f > 0.5).map(fold);
        let strongest = folded.map(|f| self.bin(f)).filter(|&bin| apart(bin)).map(|bin| self.lobe(bin, |_| true));
        strongest.reduce(f64::max).map(|strongest| decibel(strongest / self.line(self.tone)))
    }

    /// Returns the power of everything that is neither the mean nor a harmonic below half the
    /// sample rate, dB relative to the tone: folded harmonics and noise together.
    pub fn foreign_dbc(&self) -> f64 {
        let own: Vec<usize> = (1..).map(|k| f64::from(k) * self.tone).take_while(|&f| f < 0.5).map(|f| self.bin(f)).collect();
        let foreign =
            (LOBE_BINS + 1..self.power.len()).filter(|&bin| own.iter().all(|&harmonic| bin.abs_diff(harmonic) > LOBE_BINS));
        decibel(foreign.map(|bin| self.power[bin]).sum::<f64>() / self.line(self.tone))
    }

    /// Returns the power within a band, relative to all power except the mean; from and to in
    /// cycles a sample.
    pub fn part_within(&self, from: f64, to: f64) -> f64 {
        let all: f64 = self.power[LOBE_BINS + 1..].iter().sum();
        self.power[self.bin(from)..=self.bin(to)].iter().sum::<f64>() / all
    }

    /// Returns the bins that are neither the tone nor the mean.
    fn rest(&self) -> impl Iterator<Item = usize> + '_ {
        (LOBE_BINS + 1..self.power.len()).filter(|&bin| !self.is_tone(bin))
    }

    fn is_tone(&self, bin: usize) -> bool {
        bin.abs_diff(self.bin(self.tone)) <= LOBE_BINS
    }

    fn bin(&self, cycles_per_sample: f64) -> usize {
        (cycles_per_sample * self.count as f64).round() as usize
    }

    fn line(&self, cycles_per_sample: f64) -> f64 {
        self.lobe(self.bin(cycles_per_sample), |_| true)
    }

    /// Returns the power of the bins around one, for the bins that `counts` accepts.
    fn lobe(&self, bin: usize, counts: impl Fn(usize) -> bool) -> f64 {
        let (from, to) = (bin.saturating_sub(LOBE_BINS), (bin + LOBE_BINS + 1).min(self.power.len()));
        (from..to).filter(|&other| counts(other)).map(|other| self.power[other]).sum()
    }
}

/// Returns the frequency at which a sampled tone appears (aliasing), in 0 to 0.5 cycles a sample.
fn fold(cycles_per_sample: f64) -> f64 {
    (cycles_per_sample - cycles_per_sample.round()).abs()
}

fn window(n: usize, count: usize) -> f64 {
    (PI * n as f64 / count as f64).sin().powi(8)
}

fn decibel(power_ratio: f64) -> f64 {
    10.0 * power_ratio.log10()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    const COUNT: usize = 1 << 16;
    /// Frequency of the tone, cycles a sample; not a whole number of periods.
    const TONE: f64 = 0.040_412_345;

    fn samples(x: impl Fn(f64) -> f64) -> Vec<f64> {
        (0..COUNT).map(|n| x(n as f64)).collect()
    }

    fn tone(n: f64) -> f64 {
        (TAU * TONE * n).sin()
    }

    fn near(found: f64, expected: f64, within: f64) {
        assert!((found - expected).abs() < within, "{found} is not {expected}");
    }

    #[test]
    fn foreign_power_excludes_harmonics() {
        let harmonics = |n: f64| tone(n) + 0.3 * (TAU * 3.0 * TONE * n).sin() + 0.1 * (TAU * 11.0 * TONE * n).sin();
        near(Spectrum::new(&samples(|n| harmonics(n) + 1e-3 * (TAU * 0.2 * n).sin()), TONE).foreign_dbc(), -60.0, 0.01);
        let spectrum = Spectrum::new(&samples(|n| tone(n) + (TAU * 0.2 * n).sin()), TONE);
        near(spectrum.part_within(0.03, 0.05), 0.5, 1e-6);
    }

    #[test]
    fn a_spur_has_its_level_at_any_frequency() {
        for (db, at) in [(-40.0, 0.123_456), (-80.0, 0.3), (-120.0, 0.499_3), (-150.0, 2.0 * TONE)] {
            let spur = 10f64.powf(db / 20.0);
            let spectrum = Spectrum::new(&samples(|n| tone(n) + spur * (TAU * at * n).cos()), TONE);
            near(spectrum.sfdr_db(), -db, 0.01);
            near(spectrum.sndr_db(), -db, 0.01);
        }
    }

    /// Only the window's side lobes remain of a pure tone.
    #[test]
    fn a_pure_tone_with_an_offset_is_clean() {
        let spectrum = Spectrum::new(&samples(|n| tone(n) + 0.7), TONE);
        assert!(spectrum.sfdr_db() > 195.0, "{}", spectrum.sfdr_db());
        assert!(spectrum.sndr_db() > 195.0, "{}", spectrum.sndr_db());
    }

    /// `6.02 N + 1.76` assumes an error that is uniform within a step: the phase takes all values.
    #[test]
    fn rounding_noise_matches_the_formula() {
        for bits in [8, 10, 12, 14, 16] {
            let full = 2f64.powi(bits - 1);
            let sndr = Spectrum::new(&samples(|n| (full * tone(n)).round()), TONE).sndr_db();
            // At 8 bits the error is not quite uniform: 0.1 dB; at 16 it is the noise of one
            // record.
            near(sndr, 20.0 * 2f64.log10() * f64::from(bits) + 10.0 * 1.5f64.log10(), 0.12);
        }
    }

    #[test]
    fn only_folded_harmonics_are_aliases() {
        // 13 f = 0.525 appears at 0.475; 3 f is not an alias, at any level.
        let wave = |n: f64| tone(n) + 0.3 * (3.0 * TAU * TONE * n).sin() + 1e-3 * (13.0 * TAU * TONE * n).sin();
        let spectrum = Spectrum::new(&samples(wave), TONE);
        near(spectrum.alias_dbc().unwrap(), -60.0, 0.01);
        near(spectrum.sfdr_db(), -20.0 * 0.3f64.log10(), 0.01);
        // A quarter of the sample rate: every folded harmonic coincides with another harmonic or
        // the mean.
        assert_eq!(Spectrum::new(&samples(|n| (TAU * 0.25 * n).sin()), 0.25).alias_dbc(), None);
    }
}
