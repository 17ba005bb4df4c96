//! A rehearsal: the firmware's own tracker on the linear model of a ring-up, without converters,
//! contact and amplifier.
//!
//! Within a block the drive has one frequency. The current of the series branch, fed through the
//! source resistance, is exactly
//!
//! ```text
//! i(t) = Re{ V Y(w) exp(j w t) + C exp(p t) },    p = -alpha + j sqrt(w0^2 - alpha^2),    Y = 1 / (R + j (w L - 1 / (w C)))
//! ```
//!
//! with `C` from the current and the charge at the beginning of the block (Butterworth 1914, Van
//! Dyke 1928). Its samples pass the firmware's lock-in, least squares over a block, and the
//! tracker's result for a block is played two blocks later. With noise, a rehearsal is one of many
//! draws; without noise it shows the effect of the filter's own gains. The model omits images of
//! the DAC, the amplifier's lag and further modes; rounding is only included as noise.

use firmware::seam::block::LATENCY_BLOCKS;
use firmware::seam::phasor::Phasor;
use firmware::seam::transducer::Transducer;
use firmware::sense::demod::Sensed;
use firmware::sense::motional::Motional;
use firmware::track::tracker::observer::{Observer, Played, Prior};
use firmware::track::tracker::{PlayedBlock, State, Tracker};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use realfft::num_complex::Complex64;

use plant::circuit::Circuit;

const TAU: f64 = std::f64::consts::TAU;
/// Interval at which the controller adopts the observer's transducer values, blocks.
const LEARN_BLOCKS: usize = 64;

/// Test bench: the stack's surroundings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RehearsalBench {
    /// Nominal frequency of the drive, Hz.
    pub nominal_hz: f64,
    /// Peak drive voltage before the source resistance, V.
    pub volts: f64,
    /// Source resistance of the amplifier, ohm.
    pub source_ohm: f64,
    /// Sample rate, Hz.
    pub sample_hz: f64,
    /// Samples in a block.
    pub samples: u16,
    /// Noise of a sample of the current, A rms, and of the voltage, V rms.
    pub noise: (f64, f64),
    /// Relative error of the clamped capacitance: true value over the compensated one, minus one.
    pub c0_error: f64,
    /// Delay of the current samples after the voltage samples, s.
    pub skew_s: f64,
}

/// Estimator that follows the resonance.
#[derive(Clone, Debug)]
pub enum Follower {
    /// The whole tracker of the firmware.
    Tracker(Box<Tracker>),
    /// The observer alone, without its second integrator.
    WithoutRate(Box<Observer>),
}

/// A block that was played and measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Frequency played, Hz.
    pub played_hz: f64,
    /// True resonance of the stack in the middle of the block, Hz.
    pub resonance_hz: f64,
    /// Standard deviation that the observer states, Hz.
    pub stated_hz: f64,
    /// Lock state of the tracker; `None` for an observer alone.
    pub state: Option<State>,
}

impl Block {
    /// Returns the drive frequency minus the true resonance, Hz.
    pub fn error_hz(&self) -> f64 {
        self.played_hz - self.resonance_hz
    }
}

/// Rehearsal in progress.
#[derive(Clone, Debug)]
pub struct Rehearsal {
    bench: RehearsalBench,
    follower: Follower,
    branch: Motional,
    /// Number of blocks played.
    block: usize,
    learned: bool,
    /// Frequency offsets decided and not yet played, the next first, Hz.
    ahead_hz: [f64; LATENCY_BLOCKS],
    current_a: f64,
    charge_c: f64,
    /// Phase of the drive at the beginning of the next block, rad.
    phase: f64,
    random: Option<Xoshiro256PlusPlus>,
}

impl Rehearsal {
    /// Starts cold. The drive begins at its zero crossing, `phase` (turns) of a period after the
    /// start of the first block. `random` draws the noise; `None` is without noise.
    pub fn new(bench: RehearsalBench, follower: Follower, c0_f: f64, phase: f64, random: Option<Xoshiro256PlusPlus>) -> Self {
        let branch = Motional::of_capacitance(c0_f as f32, bench.nominal_hz as f32);
        Rehearsal {
            bench,
            follower,
            branch,
            block: 0,
            learned: false,
            ahead_hz: [0.0; LATENCY_BLOCKS],
            current_a: 0.0,
            charge_c: 0.0,
            phase: -TAU * phase.clamp(0.0, 1.0),
            random,
        }
    }

    /// Starts the follower from a prior.
    pub fn observe(&mut self, prior: &Prior) {
        match &mut self.follower {
            Follower::Tracker(tracker) => tracker.observe(self.branch, Default::default(), prior),
            Follower::WithoutRate(observer) => observer.start(prior),
        }
    }

    /// Returns the time of the middle of the next block, s.
    pub fn time_s(&self) -> f64 {
        (self.block as f64 + 0.5) * f64::from(self.bench.samples) / self.bench.sample_hz
    }

    /// Plays a block on a stack, measures it, and decides the frequency of the next.
    pub fn step(&mut self, circuit: &Circuit) -> Block {
        let offset_hz = self.ahead_hz[self.block % LATENCY_BLOCKS];
        let played_hz = self.bench.nominal_hz + offset_hz;
        let whole = self.phase >= 0.0;
        let sensed = self.play(circuit, played_hz);
        let volts = self.bench.volts as f32;
        let relative = (played_hz / self.bench.nominal_hz) as f32;
        let played = PlayedBlock {
            offset_hz: offset_hz as f32,
            volts,
            envelope: whole.then_some(1.0),
            pure: true,
            on: whole,
            driven: true,
            rung_up: false,
        };
        let current = self.branch.current(&sensed, relative);
        let (next_hz, stated_hz, state) = match &mut self.follower {
            Follower::Tracker(tracker) => {
                let current = tracker.motional_current(&sensed, relative);
                tracker.follow(&sensed, current, current, &played);
                if tracker.has_converged()
                    && (!self.learned || self.block.is_multiple_of(LEARN_BLOCKS))
                    && let Some(transducer) = tracker.identify()
                {
                    tracker.set_resonance(&transducer);
                    self.learned = true;
                }
                let stated = tracker.identify().map_or(f32::NAN, |it: Transducer| it.deviations.series_resonance_hz);
                (tracker.offset_hz(), stated, Some(tracker.state()))
            }
            Follower::WithoutRate(observer) => {
                observer.follow(
                    current,
                    sensed.v,
                    Played { offset_hz: played.offset_hz, steady_v: played.envelope.map(|_| volts) },
                );
                observer.forget_rate();
                (observer.offset_hz(), observer.deviation_hz(), None)
            }
        };
        self.ahead_hz[self.block % LATENCY_BLOCKS] = next_hz.into();
        self.block += 1;
        Block { played_hz, resonance_hz: circuit.series_resonance_hz(), stated_hz: stated_hz.into(), state }
    }

    /// Computes the samples of a block and passes them through the lock-in.
    fn play(&mut self, circuit: &Circuit, hz: f64) -> Sensed {
        let RehearsalBench { sample_hz, samples, source_ohm, volts, .. } = self.bench;
        let step = TAU * hz / sample_hz;
        // The drive is silent before its first zero crossing.
        let silent = if self.phase < 0.0 { (-self.phase / step).min(f64::from(samples)) } else { 0.0 };
        let begins = self.phase + silent * step;
        let omega = TAU * hz;
        let rm = circuit.rm_ohm + source_ohm;
        let alpha = rm / (2.0 * circuit.lm_h);
        let pole = Complex64::new(-alpha, (circuit.omega().powi(2) - alpha * alpha).max(0.0).sqrt());
        let drive = Complex64::new(0.0, -volts);
        let steady = drive / Complex64::new(rm, omega * circuit.lm_h - 1.0 / (omega * circuit.cm_f));
        let there = Complex64::from_polar(1.0, begins);
        let rest = (self.current_a - (steady * there).re, self.charge_c - (steady / Complex64::new(0.0, omega) * there).re);
        let inverse = pole.inv();
        let ringing = Complex64::new(rest.0, (rest.0 * inverse.re - rest.1) / inverse.im);
        let at = |n: f64| (ringing * (pole * (n / sample_hz)).exp(), steady * Complex64::from_polar(1.0, begins + n * step));

        let driven = f64::from(samples) - silent;
        let (mut free, forced) = at(0.5 + silent.ceil() - silent);
        let (decay, turn) = ((pole / sample_hz).exp(), Complex64::from_polar(1.0, step));
        let mut rotation = forced / steady;
        let mut lock_in = LockIn::default();
        let silence = silent.ceil() as u16;
        for n in 0..samples {
            let reference = Complex64::from_polar(1.0, self.phase + (f64::from(n) + 0.5) * step);
            let (mut v, mut i) = (0.0, 0.0);
            if n >= silence {
                i = (free + steady * rotation).re;
                v = (drive * rotation).re - source_ohm * i;
                (free, rotation) = (free * decay, rotation * turn);
            }
            let (mut v_noise, mut i_noise) = (0.0, 0.0);
            if let Some(random) = &mut self.random {
                let (a, b): (f64, f64) = (StandardNormal.sample(random), StandardNormal.sample(random));
                (i_noise, v_noise) = (a * self.bench.noise.0, b * self.bench.noise.1);
            }
            lock_in.add(reference, [v, v_noise, i + i_noise]);
        }
        let (free, forced) = at(driven);
        (self.current_a, self.charge_c) = ((free + forced).re, (free / pole + forced / Complex64::new(0.0, omega)).re);
        self.phase = begins + driven * step;
        if self.phase >= TAU {
            self.phase %= TAU;
        }
        let [v, v_noise, i] = lock_in.phasors();
        let clamped = Complex64::new(0.0, omega * circuit.c0_f * (1.0 + self.bench.c0_error));
        let late = Complex64::from_polar(1.0, omega * self.bench.skew_s);
        Sensed { v: phasor(v + v_noise), i: phasor((i + clamped * v) * late) }
    }
}

/// Least-squares phasors of three signals at one frequency.
#[derive(Default)]
struct LockIn {
    sums: [Complex64; 3],
    twice: Complex64,
    count: f64,
}

impl LockIn {
    fn add(&mut self, reference: Complex64, values: [f64; 3]) {
        let back = reference.conj();
        for (sum, value) in self.sums.iter_mut().zip(values) {
            *sum += back * value;
        }
        self.twice += back * back;
        self.count += 1.0;
    }

    fn phasors(&self) -> [Complex64; 3] {
        let image = self.twice / self.count;
        self.sums.map(|r| (r - r.conj() * image) * (2.0 / (self.count * (1.0 - image.norm_sqr()))))
    }
}

fn phasor(x: Complex64) -> Phasor {
    Phasor::new(x.re as f32, x.im as f32)
}
