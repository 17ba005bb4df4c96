//! Exact current of a circuit driven by a sine, and its derivatives by all unknown parameters.
//!
//! ```text
//! q'' + 2 alpha q' + omega0^2 q = v / Lm,   v = Re{V exp(j omega t)},   i = q' + C0 v'        alpha = omega0 / (2 Q)
//! i = Re{(S + j omega C0 V) exp(j omega t) + B exp(lambda t)},   S = j omega V / (Lm D),   D = omega0^2 - omega^2 + 2j alpha omega
//! lambda = -alpha + j sqrt(omega0^2 - alpha^2),   B from current and charge at t = 0
//! ```
//!
//! The current is the sum of the steady state and the one free oscillation of a second-order
//! circuit. The charge of C0 by a voltage jump at t = 0 flows between two samples. Valid for Q
//! above 0.5.

use std::f64::consts::TAU;

use realfft::num_complex::Complex64;

use super::{Drive, Start};
use plant::circuit::Circuit;

/// Unknown parameter; its value is the index in derivatives and information.
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
    /// Motional current a quarter of a drive period later without a drive: drive frequency times
    /// charge at t = 0, A.
    StateQuadrature,
    /// Slope of the resonance, Hz/s; its change is zero at t = 0. Only for a settled circuit.
    Rate,
}

/// Number of parameters.
pub(super) const PARAMETERS: usize = Parameter::Rate as usize + 1;

/// `Re{(steady + steady_rate t) exp(j omega t) + (free + free_rate t) exp(lambda t)}`.
#[derive(Clone, Copy, Debug, Default)]
struct Term {
    steady: Complex64,
    steady_rate: Complex64,
    free: Complex64,
    free_rate: Complex64,
}

/// Current and its derivatives.
#[derive(Clone, Debug)]
pub(super) struct Response {
    omega: f64,
    lambda: Complex64,
    voltage: Complex64,
    current: Term,
    by: [Term; PARAMETERS],
}

/// State of the motional branch at t = 0, or its derivative.
#[derive(Clone, Copy, Debug, Default)]
struct State {
    /// Current, A.
    current: f64,
    /// Charge, C.
    charge: f64,
}

impl State {
    /// Returns the state of a current `Re{phasor exp(j omega t)}`.
    fn from_phasor(phasor: Complex64, omega: f64) -> Self {
        State { current: phasor.re, charge: phasor.im / omega }
    }
}

/// Poles: decay, ringing frequency, and square of the undamped frequency.
#[derive(Clone, Copy)]
struct Poles {
    alpha: f64,
    ringing: f64,
    square: f64,
}

impl Poles {
    fn new(circuit: &Circuit) -> Self {
        let (alpha, omega0) = (0.5 * circuit.omega() / circuit.q(), circuit.omega());
        Poles { alpha, ringing: (omega0 * omega0 - alpha * alpha).sqrt(), square: omega0 * omega0 }
    }

    /// Returns the free oscillation with this initial current and slope.
    fn free(&self, current: f64, slope: f64) -> Complex64 {
        Complex64::new(current, -(slope + self.alpha * current) / self.ringing)
    }

    /// Returns the free oscillation from a state without a drive.
    fn free_from(&self, state: State) -> Complex64 {
        self.free(state.current, -2.0 * self.alpha * state.current - self.square * state.charge)
    }
}

/// Returns the steady motional current of a circuit, A.
pub(super) fn settled(circuit: &Circuit, drive: &Drive) -> Complex64 {
    let omega = TAU * drive.hz;
    let reactance = omega * circuit.lm_h - 1.0 / (omega * circuit.cm_f);
    drive.phasor() / Complex64::new(circuit.rm_ohm, reactance)
}

impl Response {
    pub(super) fn new(circuit: &Circuit, drive: &Drive, start: &Start) -> Self {
        let (omega, voltage, poles) = (TAU * drive.hz, drive.phasor(), Poles::new(circuit));
        let (f0, q) = (circuit.series_resonance_hz(), circuit.q());
        let j = Complex64::i();
        let clamped = j * omega * circuit.c0_f * voltage;
        let steady = settled(circuit, drive);
        let lambda = Complex64::new(-poles.alpha, poles.ringing);
        let denominator = Complex64::new(poles.square - omega * omega, 2.0 * poles.alpha * omega);

        // Derivatives of D by resonance and logarithm of Q.
        let denominator_by_f = TAU * Complex64::new(2.0 * circuit.omega(), omega / q);
        let denominator_by_q = -2.0 * j * omega * poles.alpha;
        let steady_by = [-steady * denominator_by_f / denominator, -steady * denominator_by_q / denominator, -steady];

        let is_settled = matches!(start, Start::Settled);
        let before = match start {
            Start::Rest => State::default(),
            Start::Settled => State::from_phasor(steady, omega),
            Start::Jump(before) => State::from_phasor(settled(before, drive), omega),
        };
        let push = voltage.re / circuit.lm_h;
        let slope = push - 2.0 * poles.alpha * before.current - poles.square * before.charge;
        let free_current = before.current - steady.re;
        let free = if is_settled { Complex64::default() } else { poles.free(free_current, slope - (j * omega * steady).re) };

        // Derivatives of alpha, ringing, and slope at t = 0, by resonance, logarithm of Q and of
        // Lm.
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

        // The current measured before a jump is the sum of both branches: less current through C0
        // means more motional current.
        by[Parameter::C0 as usize].steady = clamped;
        if matches!(start, Start::Jump(_)) {
            by[Parameter::C0 as usize].free = poles.free_from(State::from_phasor(-clamped, omega));
        }
        for (parameter, turn) in [(Parameter::Voltage, Complex64::new(1.0, 0.0)), (Parameter::Phase, j)] {
            let motional = turn * steady;
            by[parameter as usize].steady = motional + turn * clamped;
            if !is_settled {
                let slope = (turn * voltage).re / circuit.lm_h - (j * omega * motional).re;
                by[parameter as usize].free = poles.free(-motional.re, slope);
            }
        }
        by[Parameter::State as usize].free = poles.free_from(State { current: 1.0, charge: 0.0 });
        by[Parameter::StateQuadrature as usize].free = poles.free_from(State { current: 0.0, charge: 1.0 / omega });
        if is_settled {
            // D(d/dt) y = t exp(s t) has the solution y = (t / D - D' / D^2) exp(s t); the current
            // is its derivative.
            let charge = steady / (j * omega);
            let slope = 2.0 * (j * omega + poles.alpha);
            let force = -denominator_by_f * charge / denominator;
            by[Parameter::Rate as usize].steady = force * (1.0 - j * omega * slope / denominator);
            by[Parameter::Rate as usize].steady_rate = force * j * omega;
        }
        let current = Term { steady: steady + clamped, free, ..Term::default() };
        Response { omega, lambda, voltage, current, by }
    }

    /// Returns the voltage, V, and its derivatives by its relative size and its phase.
    pub(super) fn voltage(&self, time_s: f64) -> (f64, [f64; 2]) {
        let now = self.voltage * Complex64::cis(self.omega * time_s);
        (now.re, [now.re, -now.im])
    }

    /// Returns the current, A, and its derivatives.
    pub(super) fn current(&self, time_s: f64) -> (f64, [f64; PARAMETERS]) {
        let driven = Complex64::cis(self.omega * time_s);
        let free = (self.lambda * time_s).exp();
        let of =
            |term: &Term| ((term.steady + term.steady_rate * time_s) * driven + (term.free + term.free_rate * time_s) * free).re;
        (of(&self.current), self.by.each_ref().map(of))
    }
}
