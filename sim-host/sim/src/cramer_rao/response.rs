//! The current of a circuit that is driven by a sine, and its derivatives by everything that may be unknown, exact.
//!
//! ```text
//! q'' + 2 alpha q' + omega0^2 q = v / Lm,   v = Re{V exp(j omega t)},   i = q' + C0 v'        alpha = omega0 / (2 Q)
//! i = Re{(S + j omega C0 V) exp(j omega t) + B exp(lambda t)},   S = j omega V / (Lm D),   D = omega0^2 - omega^2 + 2j alpha omega
//! lambda = -alpha + j sqrt(omega0^2 - alpha^2),   B from current and charge at t = 0
//! ```
//!
//! Steady state and one free oscillation, which is all that a second-order circuit has. The charge that a jump of the voltage at t = 0 puts
//! onto C0 passes between two samples. Valid for Q above a half.

use std::f64::consts::TAU;

use realfft::num_complex::Complex64;

use super::{Drive, Start};
use plant::circuit::Circuit;

/// What may be unknown: a place in derivatives and information.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Parameter {
    /// Series resonance of the stack, Hz.
    Resonance,
    /// Logarithm of the quality factor.
    Q,
    /// Logarithm of the motional inductance.
    Lm,
    /// Logarithm of the clamped capacitance.
    C0,
    /// Relative deviation of the voltage.
    Voltage,
    /// Phase of the voltage, rad.
    Phase,
    /// Motional current at t = 0, A.
    State,
    /// Motional current a quarter of a drive period later if nothing acted on it: drive frequency times charge at t = 0, A.
    StateQuadrature,
    /// Slope of the resonance, Hz/s; zero at t = 0. For a settled circuit only.
    Rate,
}

/// How many there are.
pub(super) const PARAMETERS: usize = Parameter::Rate as usize + 1;

/// `Re{(steady + steady_rate t) exp(j omega t) + (free + free_rate t) exp(lambda t)}`.
#[derive(Clone, Copy, Debug, Default)]
struct Term {
    steady: Complex64,
    steady_rate: Complex64,
    free: Complex64,
    free_rate: Complex64,
}

/// The current and its derivatives.
#[derive(Clone, Debug)]
pub(super) struct Response {
    omega: f64,
    lambda: Complex64,
    voltage: Complex64,
    current: Term,
    by: [Term; PARAMETERS],
}

/// The motional branch at t = 0, or a derivative of it.
#[derive(Clone, Copy, Debug, Default)]
struct State {
    /// Current, A.
    current: f64,
    /// Charge, C.
    charge: f64,
}

impl State {
    /// Response of a current `Re{phasor exp(j omega t)}`.
    fn of(phasor: Complex64, omega: f64) -> Self {
        State { current: phasor.re, charge: phasor.im / omega }
    }
}

/// The poles: decay, ringing frequency.
#[derive(Clone, Copy)]
struct Poles {
    alpha: f64,
    ringing: f64,
    square: f64,
}

impl Poles {
    fn of(circuit: &Circuit) -> Self {
        let (alpha, omega0) = (0.5 * circuit.omega() / circuit.q(), circuit.omega());
        Poles { alpha, ringing: (omega0 * omega0 - alpha * alpha).sqrt(), square: omega0 * omega0 }
    }

    /// The free oscillation that leads from the steady state to a current and its slope.
    fn free(&self, current: f64, slope: f64) -> Complex64 {
        Complex64::new(current, -(slope + self.alpha * current) / self.ringing)
    }

    /// What leaves from a state with nothing driving it.
    fn left_by(&self, state: State) -> Complex64 {
        self.free(state.current, -2.0 * self.alpha * state.current - self.square * state.charge)
    }
}

/// Motional current of a circuit in steady state, A.
pub(super) fn settled(circuit: &Circuit, drive: &Drive) -> Complex64 {
    let omega = TAU * drive.hz;
    let reactance = omega * circuit.lm_h - 1.0 / (omega * circuit.cm_f);
    drive.phasor() / Complex64::new(circuit.rm_ohm, reactance)
}

impl Response {
    pub(super) fn new(circuit: &Circuit, drive: &Drive, start: &Start) -> Self {
        let (omega, voltage, poles) = (TAU * drive.hz, drive.phasor(), Poles::of(circuit));
        let (f0, q) = (circuit.series_resonance_hz(), circuit.q());
        let j = Complex64::i();
        let clamped = j * omega * circuit.c0_f * voltage;
        let steady = settled(circuit, drive);
        let lambda = Complex64::new(-poles.alpha, poles.ringing);
        let denominator = Complex64::new(poles.square - omega * omega, 2.0 * poles.alpha * omega);

        // D by resonance and logarithm of Q.
        let denominator_by_f = TAU * Complex64::new(2.0 * circuit.omega(), omega / q);
        let denominator_by_q = -2.0 * j * omega * poles.alpha;
        let steady_by = [-steady * denominator_by_f / denominator, -steady * denominator_by_q / denominator, -steady];

        let is_settled = matches!(start, Start::Settled);
        let before = match start {
            Start::Rest => State::default(),
            Start::Settled => State::of(steady, omega),
            Start::Jump(before) => State::of(settled(before, drive), omega),
        };
        let push = voltage.re / circuit.lm_h;
        let slope = push - 2.0 * poles.alpha * before.current - poles.square * before.charge;
        let free_current = before.current - steady.re;
        let free = if is_settled { Complex64::default() } else { poles.free(free_current, slope - (j * omega * steady).re) };

        // By resonance, logarithm of Q, logarithm of Lm: of alpha, of the ringing, of the slope at t = 0.
        let alpha_by = [poles.alpha / f0, -poles.alpha, 0.0];
        let ringing_by = [poles.ringing / f0, poles.alpha.powi(2) / poles.ringing, 0.0];
        let slope_by = [
            -2.0 * alpha_by[0] * before.current - 2.0 * poles.square / f0 * before.charge,
            -2.0 * alpha_by[1] * before.current,
            -push,
        ];
        let mut by = [Term::default(); PARAMETERS];
        for (n, parameter) in [Parameter::Resonance, Parameter::Q, Parameter::Lm].into_iter().enumerate() {
            let (steady, term) = (steady_by[n], &mut by[parameter as usize]);
            term.steady = steady;
            if !is_settled {
                let rest = slope_by[n] - (j * omega * steady).re + alpha_by[n] * free.re + ringing_by[n] * free.im;
                term.free = poles.free(-steady.re, rest);
                term.free_rate = free * Complex64::new(-alpha_by[n], ringing_by[n]);
            }
        }

        // The current measured before a jump is the sum of both branches: the less C0 takes, the more was motional.
        by[Parameter::C0 as usize].steady = clamped;
        if matches!(start, Start::Jump(_)) {
            by[Parameter::C0 as usize].free = poles.left_by(State::of(-clamped, omega));
        }
        for (parameter, turn) in [(Parameter::Voltage, Complex64::new(1.0, 0.0)), (Parameter::Phase, j)] {
            let motional = turn * steady;
            by[parameter as usize].steady = motional + turn * clamped;
            if !is_settled {
                let slope = (turn * voltage).re / circuit.lm_h - (j * omega * motional).re;
                by[parameter as usize].free = poles.free(-motional.re, slope);
            }
        }
        by[Parameter::State as usize].free = poles.left_by(State { current: 1.0, charge: 0.0 });
        by[Parameter::StateQuadrature as usize].free = poles.left_by(State { current: 0.0, charge: 1.0 / omega });
        if is_settled {
            // D(d/dt) y = t exp(s t) has the solution y = (t / D - D' / D^2) exp(s t); the current is its slope.
            let charge = steady / (j * omega);
            let slope = 2.0 * (j * omega + poles.alpha);
            let force = -denominator_by_f * charge / denominator;
            by[Parameter::Rate as usize].steady = force * (1.0 - j * omega * slope / denominator);
            by[Parameter::Rate as usize].steady_rate = force * j * omega;
        }
        let current = Term { steady: steady + clamped, free, ..Term::default() };
        Response { omega, lambda, voltage, current, by }
    }

    /// Voltage, V, and how it changes with its relative size and its phase.
    pub(super) fn voltage(&self, time_s: f64) -> (f64, [f64; 2]) {
        let now = self.voltage * Complex64::cis(self.omega * time_s);
        (now.re, [now.re, -now.im])
    }

    /// Current, A, and its derivatives.
    pub(super) fn current(&self, time_s: f64) -> (f64, [f64; PARAMETERS]) {
        let driven = Complex64::cis(self.omega * time_s);
        let free = (self.lambda * time_s).exp();
        let of =
            |term: &Term| ((term.steady + term.steady_rate * time_s) * driven + (term.free + term.free_rate * time_s) * free).re;
        (of(&self.current), self.by.each_ref().map(of))
    }
}
