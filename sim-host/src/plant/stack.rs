//! Amplifier and stack: a linear network of five states, moved by its exact flow.
//!
//! ```text
//!  DAC (held) -> Butterworth low-pass -> e --[ Rs ]--+------ v0 ------+
//!                                                    |                |
//!                                                   C0        Lm - Cm - Rm - (F / phi)
//!                                                    |                |
//!                                                   gnd              gnd
//! ```
//!
//! | state | unit | equation |
//! |---|---|---|
//! | `e` amplifier output | V | `e' = w_a d` |
//! | `d` its scaled slope | V | `d' = w_a (u - e - sqrt(2) d)` |
//! | `v0` stack voltage | V | `C0 v0' = (e - v0) / Rs - i` |
//! | `i` motional current | A | `Lm i' = v0 - Rm i - vc - F / phi` |
//! | `vc` motional capacitor | V | `Cm vc' = i` |
//!
//! `phi` is the force factor, N/V: tip velocity `i / phi`, tip displacement `Cm vc / phi`. `F`, the friction on the tip in the
//! direction against positive motion, comes back into the motional branch as the voltage `F / phi`: at 10 N and mu 0.3 that is
//! 0.5 V of a 3 V drive. Equivalent circuit: Butterworth 1915, Van Dyke 1925; force factor: Mason 1948.

use crate::plant::flow::{Matrix, exponential};
use crate::scene::{Amplifier, Bvd};

/// States of the network.
pub const STATES: usize = 5;
const E: usize = 0;
const D: usize = 1;
const V0: usize = 2;
const I: usize = 3;
const VC: usize = 4;

/// The equivalent circuit in the form the equations need.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circuit {
    /// Clamped capacitance, F.
    pub c0_f: f64,
    /// Motional capacitance, F.
    pub cm_f: f64,
    /// Motional inductance, H.
    pub lm_h: f64,
    /// Motional resistance, ohm.
    pub rm_ohm: f64,
    /// Force factor, N/V.
    pub force_factor_n_per_v: f64,
}

impl Circuit {
    /// From either form of a scene's stack. A scene that has passed its rules gives one of them in full.
    pub fn of(bvd: &Bvd) -> Self {
        let of_resonance = |hz: f64, q: f64, k: f64| {
            let cm_f = bvd.c0_f * k * k / (1.0 - k * k);
            let omega = std::f64::consts::TAU * hz;
            let lm_h = 1.0 / (omega * omega * cm_f);
            (cm_f, lm_h, omega * lm_h / q)
        };
        let (cm_f, lm_h, rm_ohm) = match (bvd.cm_f, bvd.lm_h, bvd.rm_ohm) {
            (Some(cm_f), Some(lm_h), Some(rm_ohm)) => (cm_f, lm_h, rm_ohm),
            _ => of_resonance(bvd.series_resonance_hz.unwrap_or(40e3), bvd.q.unwrap_or(50.0), bvd.coupling.unwrap_or(0.25)),
        };
        Circuit { c0_f: bvd.c0_f, cm_f, lm_h, rm_ohm, force_factor_n_per_v: bvd.force_factor_n_per_v }
    }

    /// Series resonance, rad/s.
    pub fn omega(&self) -> f64 {
        1.0 / (self.lm_h * self.cm_f).sqrt()
    }

    /// Series resonance, Hz.
    pub fn series_resonance_hz(&self) -> f64 {
        self.omega() / std::f64::consts::TAU
    }

    /// Quality factor at series resonance.
    pub fn q(&self) -> f64 {
        self.omega() * self.lm_h / self.rm_ohm
    }

    /// The same inductance and quality factor at another resonance.
    pub fn with_series_resonance(self, hz: f64) -> Self {
        let omega = std::f64::consts::TAU * hz;
        let cm_f = 1.0 / (omega * omega * self.lm_h);
        Circuit { cm_f, rm_ohm: omega * self.lm_h / self.q(), ..self }
    }

    /// The same resonance with another quality factor.
    pub fn with_q(self, q: f64) -> Self {
        Circuit { rm_ohm: self.omega() * self.lm_h / q, ..self }
    }

    /// Time constant of the ring-up, s.
    pub fn time_constant_s(&self) -> f64 {
        2.0 * self.lm_h / self.rm_ohm
    }

    /// Modal mass at the tip, kg.
    pub fn modal_mass_kg(&self) -> f64 {
        self.lm_h * self.force_factor_n_per_v.powi(2)
    }
}

/// A vector of states, padded so that pairs fill vector registers.
type Padded = [f64; STATES + 1];

/// The network and its state.
#[derive(Clone, Debug)]
pub struct Stack {
    circuit: Circuit,
    amplifier: Amplifier,
    step_s: f64,
    skew_s: f64,
    x: Padded,
    /// Columns of the flow: one for each state.
    flow: [Padded; STATES],
    /// Response to the drive, held over the step, V.
    drive: Padded,
    /// Response to the friction, held over the step, N.
    force: Padded,
    /// Rows that look back by the skew: (from the state, from the drive).
    look_back: ([f64; STATES], f64),
    /// Whether that row is the voltage's (sampled first) or the current's.
    voltage_first: bool,
}

impl Stack {
    /// A stack at rest, moved in steps of `step_s`; the current is sampled `skew_s` after the voltage.
    pub fn new(circuit: Circuit, amplifier: &Amplifier, step_s: f64, skew_s: f64) -> Self {
        let mut stack = Stack {
            circuit,
            amplifier: amplifier.clone(),
            step_s,
            skew_s,
            x: Padded::default(),
            flow: Default::default(),
            drive: Padded::default(),
            force: Padded::default(),
            look_back: Default::default(),
            voltage_first: skew_s > 0.0,
        };
        stack.remake();
        stack
    }

    /// The circuit as it is now.
    pub fn circuit(&self) -> &Circuit {
        &self.circuit
    }

    /// Changes the circuit; the charge on the motional capacitor and the current stay.
    pub fn set_circuit(&mut self, circuit: Circuit) {
        self.x[VC] *= self.circuit.cm_f / circuit.cm_f;
        self.circuit = circuit;
        self.remake();
    }

    fn remake(&mut self) {
        let Circuit { c0_f, cm_f, lm_h, rm_ohm, force_factor_n_per_v } = self.circuit;
        let corner = std::f64::consts::TAU * self.amplifier.bandwidth_hz;
        let source = self.amplifier.source_ohm;
        // Rows: states, then the two inputs (drive, force), which do not change during a step.
        let mut a: Matrix<{ STATES + 2 }> = Default::default();
        a[E][D] = corner;
        a[D][E] = -corner;
        a[D][D] = -corner * std::f64::consts::SQRT_2;
        a[D][STATES] = corner;
        a[V0][E] = 1.0 / (source * c0_f);
        a[V0][V0] = -1.0 / (source * c0_f);
        a[V0][I] = -1.0 / c0_f;
        a[I][V0] = 1.0 / lm_h;
        a[I][I] = -rm_ohm / lm_h;
        a[I][VC] = -1.0 / lm_h;
        a[I][STATES + 1] = -1.0 / (lm_h * force_factor_n_per_v);
        a[VC][I] = 1.0 / cm_f;

        let over = |seconds: f64| exponential(&a.map(|row| row.map(|x| x * seconds)));
        let step = over(self.step_s);
        let column = |c: usize| std::array::from_fn(|r| if r < STATES { step[r][c] } else { 0.0 });
        self.flow = std::array::from_fn(column);
        self.drive = column(STATES);
        self.force = column(STATES + 1);

        let back = over(-self.skew_s.abs());
        let row = |r: usize| -> [f64; STATES] { std::array::from_fn(|c| back[r][c]) };
        self.look_back = if self.voltage_first {
            (row(V0), back[V0][STATES])
        } else {
            let (e, v0) = (row(E), row(V0));
            (std::array::from_fn(|c| (e[c] - v0[c]) / source), (back[E][STATES] - back[V0][STATES]) / source)
        };
    }

    /// Moves by one step with the drive at `volts` and the friction held at `newtons`.
    #[inline]
    pub fn advance(&mut self, volts: f64, newtons: f64) {
        let mut next: Padded = std::array::from_fn(|r| self.drive[r] * volts + self.force[r] * newtons);
        for (column, &x) in self.flow.iter().zip(&self.x) {
            for (y, a) in next.iter_mut().zip(column) {
                *y += a * x;
            }
        }
        self.x = next;
    }

    /// Adds what a friction larger by `newtons` over the step just made would have done.
    #[inline]
    pub fn correct_force(&mut self, newtons: f64) {
        for (x, a) in self.x.iter_mut().zip(&self.force) {
            *x += a * newtons;
        }
    }

    /// Voltage at the stack, V.
    #[inline]
    pub fn voltage(&self) -> f64 {
        self.x[V0]
    }

    /// Total current into the stack, A.
    #[inline]
    pub fn current(&self) -> f64 {
        (self.x[E] - self.x[V0]) / self.amplifier.source_ohm
    }

    /// Motional current, A.
    #[inline]
    pub fn motional_current(&self) -> f64 {
        self.x[I]
    }

    /// Voltage of the motional capacitor, V: the displacement times `phi / Cm`.
    #[inline]
    pub fn motional_voltage(&self) -> f64 {
        self.x[VC]
    }

    /// Tip velocity, m/s.
    #[inline]
    pub fn tip_velocity(&self) -> f64 {
        self.x[I] / self.circuit.force_factor_n_per_v
    }

    /// Tip displacement, m.
    #[inline]
    pub fn tip_displacement(&self) -> f64 {
        self.x[VC] * self.circuit.cm_f / self.circuit.force_factor_n_per_v
    }

    /// Amplitude of the tip velocity, m/s: the present one and a quarter period later, taken together.
    pub fn tip_amplitude(&self) -> f64 {
        let stored = self.x[VC] * self.circuit.cm_f * self.circuit.omega();
        self.x[I].hypot(stored) / self.circuit.force_factor_n_per_v
    }

    /// Energy that the motional branch holds, J.
    pub fn stored_j(&self) -> f64 {
        0.5 * (self.circuit.lm_h * self.x[I].powi(2) + self.circuit.cm_f * self.x[VC].powi(2))
    }

    /// Voltage and current as the converters sample them: the later of the two now, the other by the skew before, with the
    /// drive at `volts` in between. A skew is shorter than a step, so the drive has not changed.
    #[inline]
    pub fn sampled(&self, volts: f64) -> (f64, f64) {
        if self.skew_s == 0.0 {
            return (self.voltage(), self.current());
        }
        let (row, drive) = &self.look_back;
        let before = row.iter().zip(&self.x).map(|(a, x)| a * x).sum::<f64>() + drive * volts;
        if self.voltage_first { (before, self.current()) } else { (self.voltage(), before) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A3: Circuit = Circuit { c0_f: 300e-9, cm_f: 20e-9, lm_h: 0.7916e-3, rm_ohm: 3.08, force_factor_n_per_v: 5.566 };

    #[test]
    fn both_forms_of_a_stack_are_the_same_circuit() {
        let bvd = Bvd {
            c0_f: 300e-9,
            cm_f: None,
            lm_h: None,
            rm_ohm: None,
            series_resonance_hz: Some(A3.series_resonance_hz()),
            q: Some(A3.q()),
            coupling: Some(0.25),
            force_factor_n_per_v: 5.566,
        };
        let circuit = Circuit::of(&bvd);
        assert!((circuit.cm_f / A3.cm_f - 1.0).abs() < 1e-12);
        assert!((circuit.lm_h / A3.lm_h - 1.0).abs() < 1e-12);
        assert!((circuit.rm_ohm / A3.rm_ohm - 1.0).abs() < 1e-12);
    }

    /// Drives with a sine sampled so finely that holding it does not matter, and compares with the admittance.
    #[test]
    fn steady_state_is_the_admittance() {
        let amplifier = Amplifier { full_scale_v: 20.0, bandwidth_hz: 1e7, source_ohm: 0.3 };
        let step = 1e-8;
        let hz = 40_100.0;
        let omega = std::f64::consts::TAU * hz;
        let mut stack = Stack::new(A3, &amplifier, step, 0.0);
        let (mut re, mut im, mut vre, mut vim) = (0.0, 0.0, 0.0, 0.0);
        let settled = 1_000_000;
        let measured = 4 * 2494; // four periods, to a part in 2e5
        for n in 0..settled + measured {
            let t = n as f64 * step;
            stack.advance((omega * t).sin(), 0.0);
            if n >= settled {
                let (s, c) = (omega * t).sin_cos();
                (re, im) = (re + stack.current() * c, im - stack.current() * s);
                (vre, vim) = (vre + stack.voltage() * c, vim - stack.voltage() * s);
            }
        }
        let norm = vre * vre + vim * vim;
        let y = ((re * vre + im * vim) / norm, (im * vre - re * vim) / norm);
        let reactance = omega * A3.lm_h - 1.0 / (omega * A3.cm_f);
        let square = A3.rm_ohm.powi(2) + reactance.powi(2);
        let expected = (A3.rm_ohm / square, omega * A3.c0_f - reactance / square);
        assert!((y.0 - expected.0).abs() < 2e-4 && (y.1 - expected.1).abs() < 2e-4, "{y:?} {expected:?}");
    }

    #[test]
    fn step_size_does_not_change_the_answer() {
        let mut coarse = Stack::new(A3, &Amplifier::default(), 1e-6, 0.0);
        let mut fine = Stack::new(A3, &Amplifier::default(), 1e-7, 0.0);
        for n in 0..5000 {
            let volts = if (n / 12) % 2 == 0 { 3.0 } else { -3.0 };
            coarse.advance(volts, 0.2);
            (0..10).for_each(|_| fine.advance(volts, 0.2));
        }
        let scale = coarse.motional_current().abs().max(0.1);
        assert!((coarse.motional_current() - fine.motional_current()).abs() < 1e-10 * scale);
        assert!((coarse.voltage() - fine.voltage()).abs() < 1e-10);
    }

    #[test]
    fn skew_looks_back_along_the_exact_flow() {
        for skew in [80e-9, -80e-9] {
            let mut skewed = Stack::new(A3, &Amplifier::default(), 5e-7, skew);
            let mut before = Stack::new(A3, &Amplifier::default(), 5e-7 - 80e-9, 0.0);
            let mut rest = Stack::new(A3, &Amplifier::default(), 80e-9, 0.0);
            for _ in 0..40 {
                skewed.advance(2.5, 0.0);
                before.advance(2.5, 0.0);
                rest.x = before.x;
                rest.advance(2.5, 0.0);
                let expected = if skew > 0.0 { (before.voltage(), rest.current()) } else { (rest.voltage(), before.current()) };
                let got = skewed.sampled(2.5);
                assert!((got.0 - expected.0).abs() < 1e-9 && (got.1 - expected.1).abs() < 1e-9, "{got:?} {expected:?}");
                before.x = rest.x;
            }
        }
    }
}
