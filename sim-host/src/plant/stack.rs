//! Amplifier and stack: a linear network of five states, moved by its exact flow.
//!
//! [`network`](crate::plant::network) has the equations. Everything that the network does within a step follows from one matrix
//! exponential; what the converters see between two steps, from others.

use wide::f64x2;

use crate::plant::circuit::Circuit;
use crate::plant::flow::exponential;
use crate::plant::network::{D, DRIVE, E, FORCE, I, Network, STATES, V0, VC, network};
use crate::plant::timing::Timing;
use crate::scene::Amplifier;

/// A sixth row that is no state: the total current `(e - v0) / Rs`, which the flow gives for nothing.
const TOTAL: usize = STATES;

/// The states and the total current, in pairs that fill vector registers: (e, d), (v0, i), (vc, total).
type Pairs = [f64x2; 3];

fn pairs(rows: [f64; 6]) -> Pairs {
    [f64x2::new([rows[E], rows[D]]), f64x2::new([rows[V0], rows[I]]), f64x2::new([rows[VC], rows[TOTAL]])]
}

/// The drive's part of a step.
#[derive(Clone, Copy, Debug)]
pub struct Held(Pairs);

/// The network and its state.
#[derive(Clone, Debug)]
pub struct Stack {
    circuit: Circuit,
    amplifier: Amplifier,
    timing: Timing,
    tip_per_ampere: f64,
    tip_per_volt: f64,
    x: Pairs,
    /// Columns of the flow: one for each state. The stack does not act back on the amplifier, so that the later three
    /// have no first pair.
    flow: [Pairs; STATES],
    /// Response to the drive, held over the step, V.
    drive: Pairs,
    /// Response to the friction, held over the step, N.
    force: Pairs,
    /// The state at the beginning of the last step.
    before: Pairs,
    /// For each step of a sample, the conversions that fall into it.
    conversions: Vec<Vec<Look>>,
}

/// A look at voltage and current (the two lanes) some time into a step, along the exact flow from its beginning, with drive and
/// friction as they are held. Looking back from its end would be unstable: the clamped capacitance settles within nanoseconds.
#[derive(Clone, Copy, Debug, Default)]
struct Look {
    state: [f64x2; STATES],
    drive: f64x2,
    force: f64x2,
}

impl Stack {
    /// A stack at rest.
    pub fn new(circuit: Circuit, amplifier: &Amplifier, timing: Timing) -> Self {
        let mut stack = Stack {
            circuit,
            amplifier: amplifier.clone(),
            timing,
            tip_per_ampere: 0.0,
            tip_per_volt: 0.0,
            x: Pairs::default(),
            flow: Default::default(),
            drive: Pairs::default(),
            force: Pairs::default(),
            before: Pairs::default(),
            conversions: Vec::new(),
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
        self.x[2] *= f64x2::new([self.circuit.cm_f / circuit.cm_f, 1.0]);
        self.circuit = circuit;
        self.remake();
    }

    fn remake(&mut self) {
        let Circuit { cm_f, force_factor_n_per_v, .. } = self.circuit;
        let source = self.amplifier.source_ohm;
        let a = network(&self.circuit, &self.amplifier);
        let over = |seconds: f64| exponential(&a.map(|row| row.map(|x| x * seconds)));
        let step = over(self.timing.step_s());
        let total = |m: &Network, c: usize| (m[E][c] - m[V0][c]) / source;
        let column = |c: usize| pairs(std::array::from_fn(|r| if r == TOTAL { total(&step, c) } else { step[r][c] }));
        self.flow = std::array::from_fn(column);
        self.drive = column(DRIVE);
        self.force = column(FORCE);

        let look = |[v, i]: [f64; 2]| {
            let early = over(v);
            let late = if i == v { early } else { over(i) };
            let column = |c: usize| f64x2::new([early[V0][c], total(&late, c)]);
            Look { state: std::array::from_fn(column), drive: column(DRIVE), force: column(FORCE) }
        };
        self.conversions = self.timing.instants().into_iter().map(|step| step.into_iter().map(look).collect()).collect();
        self.tip_per_ampere = 1.0 / force_factor_n_per_v;
        self.tip_per_volt = cm_f / force_factor_n_per_v;
    }

    /// What the drive does in every step during which it is held at `volts`.
    #[inline]
    pub fn held(&self, volts: f64) -> Held {
        Held(self.drive.map(|row| row * volts))
    }

    /// Moves by one step with the drive held and the friction held at `newtons`.
    #[inline]
    pub fn advance(&mut self, drive: &Held, newtons: f64) {
        let [[e, d], [v0, i], [vc, _]] = self.x.map(f64x2::to_array);
        let [ce, cd, cv, ci, cc] = &self.flow;
        let amplifier = drive.0[0] + ce[0] * e + cd[0] * d;
        let row = |r: usize| drive.0[r] + self.force[r] * newtons + ce[r] * e + cd[r] * d + cv[r] * v0 + ci[r] * i + cc[r] * vc;
        self.before = std::mem::replace(&mut self.x, [amplifier, row(1), row(2)]);
    }

    /// Adds what a friction larger by `newtons` over the step just made would have done.
    #[inline]
    pub fn correct_force(&mut self, newtons: f64) {
        self.x[1] += self.force[1] * newtons;
        self.x[2] += self.force[2] * newtons;
    }

    /// Ends what has rung down to nothing: below 1e-150 V or A, far below any noise. Left alone it decays into denormal numbers,
    /// which take this arithmetic to half its speed.
    pub fn settle(&mut self) {
        let ended = |x: f64| if x.abs() < 1e-150 { 0.0 } else { x };
        self.x = self.x.map(|pair| f64x2::new(pair.to_array().map(ended)));
    }

    fn state(&self, n: usize) -> f64 {
        self.x[n / 2].to_array()[n % 2]
    }

    /// Voltage at the stack, V.
    #[inline]
    pub fn voltage(&self) -> f64 {
        self.state(V0)
    }

    /// Total current into the stack, A.
    #[inline]
    pub fn current(&self) -> f64 {
        self.state(TOTAL)
    }

    /// Motional current, A.
    #[inline]
    pub fn motional_current(&self) -> f64 {
        self.state(I)
    }

    /// Voltage of the motional capacitor, V: the displacement times `phi / Cm`.
    #[inline]
    pub fn motional_voltage(&self) -> f64 {
        self.state(VC)
    }

    /// Tip velocity, m/s.
    #[inline]
    pub fn tip_velocity(&self) -> f64 {
        self.motional_current() * self.tip_per_ampere
    }

    /// Tip displacement, m.
    #[inline]
    pub fn tip_displacement(&self) -> f64 {
        self.motional_voltage() * self.tip_per_volt
    }

    /// Amplitude of the tip velocity, m/s: the present one and a quarter period later, taken together.
    pub fn tip_amplitude(&self) -> f64 {
        let quarter_later = self.motional_voltage() * self.circuit.cm_f * self.circuit.omega();
        self.motional_current().hypot(quarter_later) / self.circuit.force_factor_n_per_v
    }

    /// Energy that the motional branch holds, J.
    pub fn stored_j(&self) -> f64 {
        0.5 * (self.circuit.lm_h * self.motional_current().powi(2) + self.circuit.cm_f * self.motional_voltage().powi(2))
    }

    /// Hands voltage and current at each conversion within step `step` of a sample to `convert`. The step has just been made with
    /// the drive at `volts` and a mean friction of `newtons`.
    #[inline]
    pub fn sample(&self, step: usize, volts: f64, newtons: f64, mut convert: impl FnMut(f64, f64)) {
        let [[e, d], [v0, i], [vc, _]] = self.before.map(f64x2::to_array);
        for look in &self.conversions[step] {
            let [ke, kd, kv, ki, kc] = look.state;
            let both = look.drive * volts + look.force * newtons + ke * e + kd * d + kv * v0 + ki * i + kc * vc;
            let [voltage, current] = both.to_array();
            convert(voltage, current);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn timing(step_s: f64) -> Timing {
        Timing { sample_s: step_s, steps: 1, conversions: 1, skew_s: 0.0 }
    }

    const A3: Circuit = Circuit { c0_f: 300e-9, cm_f: 20e-9, lm_h: 0.7916e-3, rm_ohm: 3.08, force_factor_n_per_v: 5.566 };

    /// Drives with a sine sampled so finely that holding it does not matter, and compares with the admittance.
    #[test]
    fn steady_state_is_the_admittance() {
        let amplifier = Amplifier { bandwidth_hz: 1e7, ..Amplifier::default() };
        let step = 1e-8;
        let hz = 40_100.0;
        let omega = std::f64::consts::TAU * hz;
        let mut stack = Stack::new(A3, &amplifier, timing(step));
        let (mut re, mut im, mut vre, mut vim) = (0.0, 0.0, 0.0, 0.0);
        let settled = 1_000_000;
        let measured = 4 * 2494; // four periods, to a part in 2e5
        for n in 0..settled + measured {
            let t = n as f64 * step;
            stack.advance(&stack.held((omega * t).sin()), 0.0);
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
        let mut coarse = Stack::new(A3, &Amplifier::default(), timing(1e-6));
        let mut fine = Stack::new(A3, &Amplifier::default(), timing(1e-7));
        for n in 0..5000 {
            let volts = if (n / 12) % 2 == 0 { 3.0 } else { -3.0 };
            coarse.advance(&coarse.held(volts), 0.2);
            (0..10).for_each(|_| fine.advance(&fine.held(volts), 0.2));
        }
        let scale = coarse.motional_current().abs().max(0.1);
        assert!((coarse.motional_current() - fine.motional_current()).abs() < 1e-10 * scale);
        assert!((coarse.voltage() - fine.voltage()).abs() < 1e-10);
    }

    /// Every conversion, at any division of the sample and any skew, is what a flow of 20 ns steps shows at its time.
    #[test]
    fn conversions_lie_on_the_exact_flow() {
        for (steps, conversions, skew_s) in [(1, 2, 0.0), (2, 2, 80e-9), (3, 4, -60e-9), (1, 1, 100e-9), (6, 3, 240e-9)] {
            let divided = Timing { sample_s: 1.2e-6, steps, conversions, skew_s };
            let mut stack = Stack::new(A3, &Amplifier::default(), divided);
            let mut fine = Stack::new(A3, &Amplifier::default(), timing(20e-9));
            for volts in [2.5, -1.0, 3.0] {
                let (mut got, mut seen) = (Vec::new(), Vec::new());
                for step in 0..steps as usize {
                    stack.advance(&stack.held(volts), 0.3);
                    stack.sample(step, volts, 0.3, |v, i| got.push((v, i)));
                }
                for _ in 0..60 {
                    fine.advance(&fine.held(volts), 0.3);
                    seen.push((fine.voltage(), fine.current()));
                }
                let at = |time: f64| seen[(time / 20e-9).round() as usize - 1];
                for (k, (v, i)) in got.iter().enumerate() {
                    let time = 1.2e-6 * (k + 1) as f64 / f64::from(conversions);
                    let expected = (at(time - skew_s.max(0.0)).0, at(time + skew_s.min(0.0)).1);
                    assert!((v - expected.0).abs() < 1e-9 && (i - expected.1).abs() < 1e-9, "{k}: {v} {i} {expected:?}");
                }
                assert_eq!(got.len(), conversions as usize);
            }
        }
    }
}
