//! Forcing as a function of time, in smooth pieces.
//!
//! Every waveform consists of pieces: cosines of linearly changing frequency, or straight lines.
//! Jumps and corners lie only where pieces meet, so a method that steps from piece to piece never
//! integrates across a jump.
//!
//! | shape | pieces | w(t) |
//! |---|---|---|
//! | sine | one per period | `cos(w t)` |
//! | square | two per period | `+1`, then `-1` |
//! | sawtooth | one per period | rises from `-1` to `+1`, then drops at once |
//! | triangle | two per period | rises from `-1` to `+1`, then falls back |
//! | random | one per hold time | uniform in `[-1, 1]`, held |
//! | chirp | one per cycle | `cos` of a phase whose frequency changes linearly from start to stop over the sweep, then stays |
//! | measured | one between two samples | a straight line from sample to sample |
//! | still | one per period | `0` |

use std::f64::consts::TAU;

use rand_core::SeedableRng;
use rand_distr::{Distribution, Uniform};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::forcing::Forcing;

/// Shape of a forcing with a peak of one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// Cosine of constant amplitude.
    Sine,
    /// Square wave with a duty cycle of one half.
    Square,
    /// Rising sawtooth of constant amplitude.
    Sawtooth,
    /// Symmetric triangle of constant amplitude.
    Triangle,
    /// Uniformly distributed values, each held for a fixed time.
    Random {
        /// Hold time, s.
        hold_s: f64,
        /// Seed of the values.
        seed: u64,
    },
    /// Linear frequency sweep.
    Chirp {
        /// First frequency, Hz.
        start_hz: f64,
        /// Last frequency, Hz.
        stop_hz: f64,
        /// Duration of the sweep, s.
        sweep_s: f64,
    },
    /// Measured samples, joined by straight lines.
    Measured,
    /// No excitation at all.
    Still,
}

/// Shape with amplitude and frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct Waveform {
    shape: Shape,
    amplitude: f64,
    frequency_hz: f64,
    /// Values of a random or a measured waveform.
    held: Vec<f64>,
    /// Times of a measured waveform, s.
    times_s: Vec<f64>,
}

/// Piece of a waveform within which the forcing is smooth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Beginning of the piece, s.
    pub start_s: f64,
    /// Length of the piece, s.
    pub length_s: f64,
    /// Index of this piece within the period; `None` if no other piece is equal to it.
    pub template: Option<usize>,
    /// Forcing since the beginning of the piece.
    pub forcing: Forcing,
}

impl Waveform {
    /// Creates a waveform of a peak (N or m/s) and a frequency, Hz, that covers `duration_s`
    /// seconds.
    pub fn new(shape: Shape, amplitude: f64, frequency_hz: f64, duration_s: f64) -> Self {
        let held = match shape {
            Shape::Random { hold_s, seed } => {
                let count = (duration_s / hold_s).ceil() as usize + 1;
                let mut chance = Xoshiro256PlusPlus::seed_from_u64(seed);
                let values =
                    Uniform::new_inclusive(-1.0, 1.0).map(|uniform| uniform.sample_iter(&mut chance).take(count).collect());
                values.unwrap_or_default()
            }
            _ => Vec::new(),
        };
        Waveform { shape, amplitude, frequency_hz, held, times_s: Vec::new() }
    }

    /// Creates a measured waveform from samples of time, s, and value, N or m/s. Times ascend from
    /// zero. After the last sample the value stays constant. The frequency, Hz, only serves to
    /// count periods.
    pub fn measured(samples: impl IntoIterator<Item = (f64, f64)>, frequency_hz: f64) -> Self {
        let (times_s, held): (Vec<f64>, Vec<f64>) = samples.into_iter().unzip();
        let amplitude = held.iter().fold(0.0f64, |most, value| most.max(value.abs()));
        Waveform { shape: Shape::Measured, amplitude, frequency_hz, held, times_s }
    }

    /// Returns the shape of the waveform.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// Returns the peak of the waveform: N on an oscillator, m/s in a kinematic motion.
    pub fn amplitude(&self) -> f64 {
        self.amplitude
    }

    /// Returns the frequency of the waveform, Hz. For a random or measured waveform or a chirp: the
    /// frequency that serves to count periods.
    pub fn frequency_hz(&self) -> f64 {
        self.frequency_hz
    }

    /// Returns the root mean square of a shape with a peak of one.
    pub fn shape_rms(shape: Shape) -> f64 {
        match shape {
            Shape::Sine | Shape::Chirp { .. } => 0.5f64.sqrt(),
            Shape::Square => 1.0,
            Shape::Sawtooth | Shape::Triangle | Shape::Random { .. } => (1.0f64 / 3.0).sqrt(),
            // Depends on the samples.
            Shape::Measured => f64::NAN,
            Shape::Still => 0.0,
        }
    }

    /// Returns piece number `index` of the waveform.
    pub fn piece(&self, index: u64) -> Piece {
        let (count, period_s) = (index as f64, 1.0 / self.frequency_hz);
        let (a, half_s) = (self.amplitude, 0.5 * period_s);
        let even = index.is_multiple_of(2);
        let (start_s, length_s, template, forcing) = match self.shape {
            Shape::Sine => {
                let forcing = Forcing::Cosine { size: a, turns: 0.0, hz: self.frequency_hz, hz_per_s: 0.0 };
                (count * period_s, period_s, Some(0), forcing)
            }
            Shape::Square => {
                let value = if even { a } else { -a };
                (count * half_s, half_s, Some(usize::from(!even)), Forcing::Line { value, slope: 0.0 })
            }
            Shape::Sawtooth => (count * period_s, period_s, Some(0), Forcing::Line { value: -a, slope: 2.0 * a / period_s }),
            Shape::Triangle => {
                let (value, slope) = if even { (-a, 2.0 * a / half_s) } else { (a, -2.0 * a / half_s) };
                (count * half_s, half_s, Some(usize::from(!even)), Forcing::Line { value, slope })
            }
            Shape::Random { hold_s, .. } => {
                let value = a * self.held.get(index as usize).copied().unwrap_or(0.0);
                (count * hold_s, hold_s, None, Forcing::Line { value, slope: 0.0 })
            }
            Shape::Chirp { start_hz, stop_hz, sweep_s } => {
                let chirp = Sweep { start_hz, stop_hz, sweep_s };
                // The timeline cuts the cycle in which the sweep ends at that moment.
                let (hz, hz_per_s) = chirp.frequency_at(count);
                (chirp.at_turns(count), chirp.cycle_s(count), None, Forcing::Cosine { size: a, turns: 0.0, hz, hz_per_s })
            }
            Shape::Measured => return self.between_samples(index as usize),
            Shape::Still => (count * period_s, period_s, Some(0), Forcing::Line { value: 0.0, slope: 0.0 }),
        };
        Piece { start_s, length_s, template, forcing }
    }

    /// Returns the straight line from one sample to the next; after the last sample, its value for
    /// one period.
    fn between_samples(&self, index: usize) -> Piece {
        let sample = |index: usize| Some((*self.times_s.get(index)?, *self.held.get(index)?));
        match (sample(index), sample(index + 1)) {
            (Some((start_s, value)), Some((end_s, next))) => {
                let length_s = end_s - start_s;
                Piece { start_s, length_s, template: None, forcing: Forcing::Line { value, slope: (next - value) / length_s } }
            }
            _ => {
                let last = self.times_s.len().saturating_sub(1);
                let (end_s, value) = sample(last).unwrap_or_default();
                let length_s = 1.0 / self.frequency_hz;
                let start_s = end_s + (index - last) as f64 * length_s;
                Piece { start_s, length_s, template: None, forcing: Forcing::Line { value, slope: 0.0 } }
            }
        }
    }

    /// Returns `true` if all periods are equal.
    pub fn is_periodic(&self) -> bool {
        matches!(self.shape, Shape::Sine | Shape::Square | Shape::Sawtooth | Shape::Triangle)
    }

    /// Returns the moments at which the forcing changes its form inside a piece, s: the end of a
    /// sweep.
    pub fn breaks(&self) -> Vec<f64> {
        match self.shape {
            Shape::Chirp { sweep_s, .. } => vec![sweep_s],
            _ => Vec::new(),
        }
    }

    /// Returns the forcing of piece `index` with its time counted from a moment within the piece.
    pub fn forcing_from(&self, index: u64, time_s: f64) -> Forcing {
        match self.shape {
            Shape::Chirp { start_hz, stop_hz, sweep_s } => Sweep { start_hz, stop_hz, sweep_s }.forcing(self.amplitude, time_s),
            _ => {
                let piece = self.piece(index);
                piece.forcing.later(time_s - piece.start_s)
            }
        }
    }

    /// Returns the forcing at a moment; at a jump, the value after it.
    pub fn value(&self, time_s: f64) -> f64 {
        let index = match self.shape {
            Shape::Sine => return self.amplitude * (TAU * (self.frequency_hz * time_s).fract()).cos(),
            Shape::Chirp { start_hz, stop_hz, sweep_s } => {
                return Sweep { start_hz, stop_hz, sweep_s }.forcing(self.amplitude, time_s).value(0.0);
            }
            Shape::Still => return 0.0,
            Shape::Square | Shape::Triangle => (2.0 * self.frequency_hz * time_s).floor(),
            Shape::Sawtooth => (self.frequency_hz * time_s).floor(),
            Shape::Random { hold_s, .. } => (time_s / hold_s).floor(),
            Shape::Measured => {
                let after = self.times_s.partition_point(|&sample| sample <= time_s);
                let last = self.times_s.len().saturating_sub(1);
                let (end_s, past) = (self.times_s.last().copied().unwrap_or(0.0), last as f64);
                if after > last {
                    past + ((time_s - end_s) * self.frequency_hz).floor().max(0.0)
                } else {
                    after.saturating_sub(1) as f64
                }
            }
        };
        let piece = self.piece(index as u64);
        piece.forcing.value(time_s - piece.start_s)
    }
}

/// Linear frequency sweep that stays at its last frequency.
struct Sweep {
    start_hz: f64,
    stop_hz: f64,
    sweep_s: f64,
}

impl Sweep {
    fn slope(&self) -> f64 {
        (self.stop_hz - self.start_hz) / self.sweep_s
    }

    /// Returns the phase at a moment, turns.
    fn turns(&self, time_s: f64) -> f64 {
        let swept = time_s.min(self.sweep_s);
        swept * (self.start_hz + 0.5 * self.slope() * swept) + self.stop_hz * (time_s - swept)
    }

    /// Returns the time at which the phase reaches a number of turns, s.
    fn at_turns(&self, turns: f64) -> f64 {
        let whole = self.turns(self.sweep_s);
        if turns >= whole {
            return self.sweep_s + (turns - whole) / self.stop_hz;
        }
        // start t + slope t^2 / 2 = turns, solved in the form that does not cancel
        2.0 * turns / (self.start_hz + (self.start_hz * self.start_hz + 2.0 * self.slope() * turns).max(0.0).sqrt())
    }

    /// Returns the frequency, Hz, and its slope, Hz/s, after a number of turns.
    fn frequency_at(&self, turns: f64) -> (f64, f64) {
        if turns >= self.turns(self.sweep_s) {
            return (self.stop_hz, 0.0);
        }
        ((self.start_hz * self.start_hz + 2.0 * self.slope() * turns).max(0.0).sqrt(), self.slope())
    }

    /// Returns the length of the cycle that begins after a whole number of turns, s.
    ///
    /// It follows from the cycle's mean frequency: the difference of two late moments would carry
    /// their round-off.
    fn cycle_s(&self, turns: f64) -> f64 {
        let (first, last) = (self.frequency_at(turns).0, self.frequency_at(turns + 1.0).0);
        let whole = self.turns(self.sweep_s);
        if turns < whole && turns + 1.0 > whole {
            self.at_turns(turns + 1.0) - self.at_turns(turns)
        } else {
            2.0 / (first + last)
        }
    }

    fn forcing(&self, size: f64, time_s: f64) -> Forcing {
        let turns = self.turns(time_s).fract();
        if time_s >= self.sweep_s {
            Forcing::Cosine { size, turns, hz: self.stop_hz, hz_per_s: 0.0 }
        } else {
            Forcing::Cosine { size, turns, hz: self.start_hz + self.slope() * time_s, hz_per_s: self.slope() }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPES: [Shape; 7] = [
        Shape::Sine,
        Shape::Square,
        Shape::Sawtooth,
        Shape::Triangle,
        Shape::Random { hold_s: 1.3e-6, seed: 3 },
        Shape::Chirp { start_hz: 20e3, stop_hz: 200e3, sweep_s: 0.4e-3 },
        Shape::Still,
    ];

    #[test]
    fn pieces_follow_each_other_and_agree_with_the_value() {
        for shape in SHAPES {
            let waveform = Waveform::new(shape, 2.5, 60e3, 1e-3);
            for index in 0..60 {
                let (piece, next) = (waveform.piece(index), waveform.piece(index + 1));
                assert!((piece.start_s + piece.length_s - next.start_s).abs() < 1e-16, "{shape:?} {index}");
                for part in [0.01, 0.3, 0.99] {
                    let s = part * piece.length_s;
                    let (direct, by_piece) = (waveform.value(piece.start_s + s), piece.forcing.value(s));
                    let swept_in_it = matches!(shape, Shape::Chirp { sweep_s, .. } if piece.start_s + s > sweep_s);
                    assert!((direct - by_piece).abs() < 1e-9 || swept_in_it, "{shape:?} {index}: {direct} {by_piece}");
                }
            }
        }
    }

    #[test]
    fn a_measured_waveform_goes_through_its_samples() {
        let samples = [(0.0, 1.0), (1e-5, -3.0), (1.4e-5, 2.0)];
        let waveform = Waveform::measured(samples, 60e3);
        assert_eq!((waveform.amplitude(), waveform.is_periodic()), (3.0, false));
        for (time, value) in samples {
            assert!((waveform.value(time) - value).abs() < 1e-12);
        }
        assert!((waveform.value(0.5e-5) + 1.0).abs() < 1e-12 && waveform.value(1.0) == 2.0);
        for index in 0..9 {
            let (piece, next) = (waveform.piece(index), waveform.piece(index + 1));
            assert!((piece.start_s + piece.length_s - next.start_s).abs() < 1e-16, "{index}");
            let middle = 0.5 * piece.length_s;
            assert!((waveform.value(piece.start_s + middle) - piece.forcing.value(middle)).abs() < 1e-9, "{index}");
        }
    }

    #[test]
    fn taylor_coefficients_continue_the_forcing() {
        for shape in SHAPES {
            let forcing = Waveform::new(shape, 1.0, 60e3, 1e-3).piece(3).forcing;
            let (s, d) = (0.4e-6, 1e-6);
            let coefficients: [f64; 20] = forcing.taylor(s);
            let sum = coefficients.iter().rev().fold(0.0, |sum, c| sum * d + c);
            assert!((sum - forcing.value(s + d)).abs() < 1e-12, "{shape:?}");
            assert!((forcing.later(s).value(d) - forcing.value(s + d)).abs() < 1e-12, "{shape:?}");
        }
    }

    #[test]
    fn a_sweep_has_its_frequencies_at_its_ends() {
        let shape = Shape::Chirp { start_hz: 20e3, stop_hz: 200e3, sweep_s: 1e-3 };
        let sweep = Sweep { start_hz: 20e3, stop_hz: 200e3, sweep_s: 1e-3 };
        // 110 cycles by the mean frequency.
        assert!((sweep.turns(1e-3) - 110.0).abs() < 1e-9 && (sweep.at_turns(110.0) - 1e-3).abs() < 1e-15);
        let waveform = Waveform::new(shape, 1.0, 60e3, 1e-3);
        assert!((waveform.piece(109).forcing.fastest_hz(waveform.piece(109).length_s).unwrap() - 200e3).abs() < 1.0);
    }

    #[test]
    fn every_cycle_of_a_sweep_is_a_whole_turn_to_round_off() {
        let shape = Shape::Chirp { start_hz: 40e3, stop_hz: 80e3, sweep_s: 1.0 };
        let waveform = Waveform::new(shape, 1.0, 60e3, 1.0);
        for index in [0, 1, 999, 10_000, 59_000] {
            let piece = waveform.piece(index);
            let Forcing::Cosine { turns, hz, hz_per_s, .. } = piece.forcing else { panic!("{piece:?}") };
            let end = turns + piece.length_s * (hz + 0.5 * hz_per_s * piece.length_s);
            assert!(turns == 0.0 && (end - 1.0).abs() < 5e-16, "{index}: {end:e}");
            assert!((piece.start_s + piece.length_s - waveform.piece(index + 1).start_s).abs() < 1e-15, "{index}");
        }
    }

    #[test]
    fn rms_is_that_of_the_shape() {
        for shape in [Shape::Sine, Shape::Square, Shape::Sawtooth, Shape::Triangle] {
            let waveform = Waveform::new(shape, 1.0, 1.0, 1.0);
            let n = 100_000;
            let mean = (0..n).map(|i| waveform.value((f64::from(i) + 0.5) / f64::from(n)).powi(2)).sum::<f64>() / f64::from(n);
            assert!((mean.sqrt() - Waveform::shape_rms(shape)).abs() < 1e-9, "{shape:?}");
        }
    }
}
