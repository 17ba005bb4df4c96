//! A rehearsal: the firmware's own tracker on the linear model of a ring-up, without converters, contact or amplifier around it.
//!
//! Within a block the drive has one frequency, and the current of the series branch behind the source resistance is, exactly,
//!
//! ```text
//! i(t) = Re{ V Y(w) exp(j w t) + C exp(p t) },    p = -alpha + j sqrt(w0^2 - alpha^2),    Y = 1 / (R + j (w L - 1 / (w C)))
//! ```
//!
//! with `C` from the current and the charge at the block's beginning (Butterworth 1914, Van Dyke 1928). Samples of it go through the same
//! lock-in as in the firmware, least squares over a block, and what the tracker makes of a block is played two blocks later. With noise it
//! is one draw of many; without, it shows what the filter's own gains do. Left out: rounding but as noise, images of the DAC, the
//! amplifier's lag, and further modes.

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
/// What the observer knows of the transducer is taken by the controller every so many blocks.
const LEARN_BLOCKS: usize = 64;

/// What is around the stack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bench {
    /// Nominal frequency of the drive, Hz.
    pub nominal_hz: f64,
    /// Peak drive voltage, V, behind so many ohms.
    pub volts: f64,
    /// Source resistance of the amplifier, ohm.
    pub source_ohm: f64,
    /// Samples a second, Hz.
    pub sample_hz: f64,
    /// Samples in a block.
    pub samples: u16,
    /// Noise of a sample of the current, A rms, and of the voltage, V rms.
    pub noise: (f64, f64),
    /// By which part the clamped capacitance is more than what is taken away for it.
    pub c0_error: f64,
    /// How much later the current is sampled than the voltage, s.
    pub skew_s: f64,
}

/// Estimator that follows the resonance.
#[derive(Clone, Debug)]
pub enum Follower {
    /// The whole tracker of the firmware.
    Tracker(Box<Tracker>),
    /// The observer by itself, without its second integrator.
    WithoutRate(Box<Observer>),
}

/// A block that was played and measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Frequency played, and the true resonance in the middle of the block, Hz.
    pub played_hz: f64,
    /// True resonance of the stack, Hz.
    pub resonance_hz: f64,
    /// Standard deviation that the observer states, Hz.
    pub stated_hz: f64,
    /// What the tracker says of its lock; nothing of an observer by itself.
    pub state: Option<State>,
}

impl Block {
    /// How far off the drive is, Hz.
    pub fn error_hz(&self) -> f64 {
        self.played_hz - self.resonance_hz
    }
}

/// A rehearsal under way.
#[derive(Clone, Debug)]
pub struct Rehearsal {
    bench: Bench,
    follower: Follower,
    branch: Motional,
    /// Blocks played.
    block: usize,
    learned: bool,
    /// Offsets that are decided on and not yet played, the next first, Hz.
    ahead_hz: [f64; LATENCY_BLOCKS],
    current_a: f64,
    charge_c: f64,
    /// Phase of the drive at the beginning of the next block, rad.
    phase: f64,
    random: Option<Xoshiro256PlusPlus>,
}

impl Rehearsal {
    /// A cold start: the drive begins where it passes zero, `phase` (turns) of a period after the first block does. Noise as `random`
    /// draws it, or none.
    pub fn new(bench: Bench, follower: Follower, c0_f: f64, phase: f64, random: Option<Xoshiro256PlusPlus>) -> Self {
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

    /// Moment of the middle of the next block, s.
    pub fn time_s(&self) -> f64 {
        (self.block as f64 + 0.5) * f64::from(self.bench.samples) / self.bench.sample_hz
    }

    /// Plays a block on a stack, measures it, and decides on the next.
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

    /// Samples of a block, through the lock-in.
    fn play(&mut self, circuit: &Circuit, hz: f64) -> Sensed {
        let Bench { sample_hz, samples, source_ohm, volts, .. } = self.bench;
        let step = TAU * hz / sample_hz;
        // Before the first zero of the drive there is silence.
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
