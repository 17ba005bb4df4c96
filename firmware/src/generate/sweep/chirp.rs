//! Chirp: the frequency runs from one value to another, linearly or exponentially, and then stays,
//! restarts or returns.
//!
//! The phase has 64 bits, and so have its increment `w` and the increment `s` of that increment. A
//! leg takes a whole number of blocks `B` of `N` samples; block `b` plays
//! `w(b), w(b) + s(b), w(b) + 2 s(b), ...`:
//!
//! ```text
//! linear        w(b) = from + b N S,              s = S,                     S = (to - from) / (B N), with 32 more bits
//! exponential   e(b + 1) = e(b) + e(b) R,         s = (e(b + 1) - e(b)) / N,   R = (to / from)^(1 / B) - 1
//!               w(b) = e(b) + e(b) M - s (N - 1) / 2,   so that a block advances the phase as the exponential does: its mean over N samples
//!                                                 is e(b) (1 + M), M = R / (N ((1 + R)^(1 / N) - 1)) - 1
//! ```
//!
//! Within a block the exponential is replaced by its chord, which is off by `R^2 / 8` of the
//! frequency at most: 7e-10 for a decade in a million samples. Each leg begins at an exact word, so
//! that errors do not accumulate over legs. Within a leg of an hour, rounding adds up to less than
//! 2e-5 Hz for an exponential from 20 to 200 kHz, and to nothing for a linear chirp.

use crate::generate::nco::tuning_word;
use crate::generate::sweep::MAX_FREQUENCY_REL;
use crate::seam::config::{Around, Chirp as Config, ChirpKind, Config as Whole, Then, TrackingMode};
use crate::seam::error::Error;
use crate::seam::features::{self, Waveforms};

/// 2^64.
const TWO_POW_64: f64 = 18_446_744_073_709_551_616.0;
/// Largest growth of an exponential chirp in a block, as a logarithm: beyond it, the chord deviates
/// too much.
const MAX_GROWTH_LOG: f64 = 0.5;
/// Number of terms of [`exp_m1`]: `0.5^15 / 16! = 1e-18`.
const TERMS: u32 = 15;
/// Largest change of frequency of a chirp about a tracked resonance in one time constant `tau`,
/// relative to the scale of the phase, `1 / (2 pi tau)`: the phase must follow the frequency.
const MAX_RATE_REL: f64 = 0.1;

/// One run from one end to the other.
#[derive(Clone, Copy, Debug)]
struct Leg {
    /// Word at the beginning; for a chirp about the resonance, its offset.
    from: i64,
    law: Law,
}

/// Law of growth of the word.
#[derive(Clone, Copy, Debug)]
enum Law {
    /// Growth by this step a sample, 2^96 a turn.
    Linear { step: i128 },
    /// Growth by `growth` of itself a block. Its mean over a block is above its beginning by `lead`
    /// of itself. Both are times 2^64.
    Exponential { growth: i128, lead: i128 },
}

/// The chirp.
#[derive(Clone, Debug)]
pub(crate) struct Chirp {
    _enabled: Waveforms,
    legs: [Leg; 2],
    then: Then,
    around: Around,
    samples: i64,
    /// Number of blocks in a leg.
    blocks: u64,
    /// `true` on the second leg.
    back: bool,
    block: u64,
    /// Word at the beginning of the next block.
    word: i64,
}

impl Chirp {
    /// Builds a chirp. Checks that both ends are within the sample rate, and that none is at or
    /// below 0 Hz.
    pub(crate) fn build(config: &Config, whole: &Whole) -> Result<Self, Error> {
        let enabled = features::waveforms()?;
        config.check()?;
        let sample_hz = f64::from(whole.sample_hz);
        let block_s = f64::from(whole.block_samples) / sample_hz;
        let (start, stop) = (f64::from(config.start_hz), f64::from(config.stop_hz));
        Config::TIME_S.check_within(config.time_s, block_s, f64::INFINITY)?;
        let centre = match config.around {
            Around::Zero => 0.0,
            Around::Resonance => f64::from(whole.drive.frequency_hz),
        };
        for (setting, hz) in [(Config::START_HZ, start), (Config::STOP_HZ, stop)] {
            setting.check_within(hz, 1.0 - centre, MAX_FREQUENCY_REL * sample_hz - centre)?;
        }
        let tracked = whole.tracking.mode != TrackingMode::Off;
        match config.around {
            Around::Zero if tracked => return Err(Error::ChirpAgainstTracking),
            Around::Resonance if !tracked => return Err(Error::ResonanceWithoutTracking),
            Around::Resonance if config.kind == ChirpKind::Exponential => return Err(Error::ExponentialAroundResonance),
            Around::Resonance => {
                let tau_s = f64::from(whole.tracking.nominal_q) / (core::f64::consts::PI * centre);
                let shortest = core::f64::consts::TAU * tau_s * tau_s * (stop - start).abs() / MAX_RATE_REL;
                Config::TIME_S.check_within(config.time_s, shortest, f64::INFINITY)?;
            }
            Around::Zero if config.kind == ChirpKind::Exponential => {
                let shortest = libm::log(stop / start).abs() / MAX_GROWTH_LOG * block_s;
                Config::TIME_S.check_within(config.time_s, shortest, f64::INFINITY)?;
            }
            Around::Zero => {}
        }
        let blocks = libm::round(config.time_s / block_s).max(1.0);
        let leg = |from: f64, to: f64| Leg::new(config.kind, from / sample_hz, to / sample_hz, blocks, whole.block_samples);
        let mut chirp = Chirp {
            _enabled: enabled,
            legs: [leg(start, stop), leg(stop, start)],
            then: config.then,
            around: config.around,
            samples: whole.block_samples.into(),
            blocks: blocks as u64,
            back: false,
            block: 0,
            word: 0,
        };
        chirp.restart();
        Ok(chirp)
    }

    /// Returns to the beginning.
    pub(crate) fn restart(&mut self) {
        self.begin(false);
    }

    fn begin(&mut self, back: bool) {
        (self.back, self.block, self.word) = (back, 0, self.legs[usize::from(back)].from);
    }

    /// Returns the word of the next block's first sample, and its increment; `held` is the word of
    /// the tracked resonance.
    #[inline(never)]
    pub(crate) fn next(&mut self, held: u64) -> (u64, u64) {
        let base = match self.around {
            Around::Zero => 0,
            Around::Resonance => held,
        };
        if self.block == self.blocks {
            match self.then {
                Then::Hold => return (base.wrapping_add_signed(self.legs[usize::from(!self.back)].from), 0),
                Then::Repeat => self.begin(false),
                Then::UpDown => self.begin(!self.back),
            }
        }
        self.block += 1;
        let leg = self.legs[usize::from(self.back)];
        let (word, step);
        match leg.law {
            Law::Linear { step: exact } => {
                (word, step) = (self.word, (exact >> 32) as i64);
                self.word = leg.from.wrapping_add(((exact * i128::from(self.block) * i128::from(self.samples)) >> 32) as i64);
            }
            Law::Exponential { growth, lead } => {
                let part = |of: i128| ((i128::from(self.word) * of) >> 64) as i64;
                step = part(growth) / self.samples;
                word = self.word + part(lead) - step * (self.samples - 1) / 2;
                self.word += part(growth);
            }
        }
        (base.wrapping_add_signed(word), step as u64)
    }
}

impl Leg {
    /// Creates a leg between two frequencies, cycles a sample.
    fn new(kind: ChirpKind, from: f64, to: f64, blocks: f64, samples: u16) -> Self {
        let samples = f64::from(samples);
        let word = |cycles: f64| if cycles < 0.0 { -(tuning_word(-cycles) as i64) } else { tuning_word(cycles) as i64 };
        let law = match kind {
            ChirpKind::Linear => {
                let span = i128::from(word(to)) - i128::from(word(from));
                Law::Linear { step: (span << 32) / ((blocks as i128) * (samples as i128)) }
            }
            ChirpKind::Exponential => {
                let rate = libm::log(to / from) / blocks;
                let growth = exp_m1(rate);
                let lead = if rate == 0.0 { 0.0 } else { growth / (samples * exp_m1(rate / samples)) - 1.0 };
                Law::Exponential { growth: (growth * TWO_POW_64) as i128, lead: (lead * TWO_POW_64) as i128 }
            }
        };
        Leg { from: word(from), law }
    }
}

/// Returns `exp(x) - 1` by its series, to double precision up to [`MAX_GROWTH_LOG`]:
/// `x (1 + x / 2 (1 + x / 3 (...)))`. The general function would take 1.4 kB of a board's flash.
fn exp_m1(x: f64) -> f64 {
    let tail = (2..=TERMS).rev().fold(1.0, |tail, n| 1.0 + x / f64::from(n) * tail);
    x * tail
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::nco::cycles_per_sample;

    #[test]
    fn the_series_has_double_precision() {
        let worst = (-500..=500).map(|n| f64::from(n) / 1000.0).fold(0.0f64, |worst, x| {
            let exact = libm::expm1(x);
            worst.max((exp_m1(x) - exact).abs() / exact.abs().max(f64::MIN_POSITIVE))
        });
        // Measured: 4.2e-16.
        assert!(worst < 6e-16, "{worst}");
    }

    /// Returns the exact phase after a leg of `seconds`, turns.
    fn exact(kind: ChirpKind, from: f64, to: f64, seconds: f64) -> f64 {
        match kind {
            ChirpKind::Linear => 0.5 * (from + to) * seconds,
            ChirpKind::Exponential => (to - from) * seconds / libm::log(to / from),
        }
    }

    fn chirp(kind: ChirpKind, from: f64, to: f64, blocks: u64, then: Then) -> Chirp {
        let leg = |from: f64, to: f64| Leg::new(kind, from / 1e6, to / 1e6, blocks as f64, 32);
        let legs = [leg(from, to), leg(to, from)];
        let mut chirp = Chirp {
            _enabled: features::Enabled,
            legs,
            then,
            around: Around::Zero,
            samples: 32,
            blocks,
            back: false,
            block: 0,
            word: 0,
        };
        chirp.restart();
        chirp
    }

    /// Runs a leg. Returns the frequency at its end, Hz, and the deviation of the phase from the
    /// exact one, turns.
    fn run(kind: ChirpKind, from: f64, to: f64, blocks: u64) -> (f64, f64) {
        let mut chirp = chirp(kind, from, to, blocks, Then::Hold);
        let mut turns = 0.0;
        for _ in 0..blocks {
            let (word, step) = chirp.next(0);
            turns += 32.0 * cycles_per_sample(word) + 496.0 * (step as i64 as f64 / TWO_POW_64);
        }
        // Samples are half a sample early: their sum of f(n) lacks half of the rise in frequency.
        let sum = exact(kind, from, to, blocks as f64 * 32e-6) - 0.5e-6 * (to - from);
        (cycles_per_sample(chirp.next(0).0) * 1e6, turns - sum)
    }

    #[test]
    fn a_decade_in_a_million_samples_ends_at_its_frequency() {
        for kind in [ChirpKind::Linear, ChirpKind::Exponential] {
            for (from, to) in [(20e3, 200e3), (200e3, 20e3), (39e3, 41e3)] {
                let (end, phase) = run(kind, from, to, 31_250);
                assert!((end - to).abs() < 1e-6, "{kind:?} {from} to {to} ends at {end}");
                // The sum and the integral of an exponential differ in the third order, too: 1e-6
                // turns.
                assert!(phase.abs() < 2e-5, "{kind:?} {from} to {to}: {phase} turns");
            }
        }
    }

    #[test]
    fn a_millisecond_and_an_hour_are_as_exact() {
        for kind in [ChirpKind::Linear, ChirpKind::Exponential] {
            assert!((run(kind, 20e3, 200e3, 31).0 - 200e3).abs() < 1e-6);
        }
        // The last block of an hour: the linear word is a product, the exponential one a sum over
        // 1e8 blocks.
        let mut hour = chirp(ChirpKind::Linear, 20e3, 200e3, 112_500_000, Then::Hold);
        hour.block = 112_499_999;
        hour.next(0);
        assert!((hour.word as f64 / TWO_POW_64 * 1e6 - 200e3).abs() < 1e-7);
        let mut slow = chirp(ChirpKind::Exponential, 20e3, 200e3, 112_500_000, Then::Hold);
        (0..112_500_000).for_each(|_| {
            slow.next(0);
        });
        let off_hz = slow.word as f64 / TWO_POW_64 * 1e6 - 200e3;
        assert!(off_hz.abs() < 2e-5 && off_hz.abs() > 2e-6, "{off_hz}");
    }

    #[test]
    fn a_chirp_holds_repeats_or_returns() {
        let starts = |then| {
            let mut chirp = chirp(ChirpKind::Linear, 20e3, 40e3, 4, then);
            core::array::from_fn::<f64, 10, _>(|_| libm::round(cycles_per_sample(chirp.next(0).0) * 1e6))
        };
        assert_eq!(starts(Then::Hold), [20e3, 25e3, 30e3, 35e3, 40e3, 40e3, 40e3, 40e3, 40e3, 40e3]);
        assert_eq!(starts(Then::Repeat), [20e3, 25e3, 30e3, 35e3, 20e3, 25e3, 30e3, 35e3, 20e3, 25e3]);
        assert_eq!(starts(Then::UpDown), [20e3, 25e3, 30e3, 35e3, 40e3, 35e3, 30e3, 25e3, 20e3, 25e3]);
    }
}
