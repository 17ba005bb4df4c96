//! The elements of a stack's network: the circuit of the wanted mode, what leaks, and the further modes.

use crate::circuit::Circuit;

/// A further mode: a series branch in parallel with that of the wanted one. Its force factor does not matter, as it does not move the
/// tip along the friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Branch {
    /// Capacitance, F.
    pub cm_f: f64,
    /// Inductance, H.
    pub lm_h: f64,
    /// Resistance, ohm.
    pub rm_ohm: f64,
}

impl Branch {
    /// The branch of a mode: `Cm = 1 / (omega^2 Lm)`, `Rm = omega Lm / Q`.
    pub fn of(mode: &scene::Mode) -> Self {
        Self::at(mode.series_resonance_hz, mode.q, mode.lm_h)
    }

    /// The branch with this resonance, Hz, quality factor and inductance, H.
    pub fn at(series_resonance_hz: f64, q: f64, lm_h: f64) -> Self {
        let omega = std::f64::consts::TAU * series_resonance_hz;
        Branch { cm_f: 1.0 / (omega * omega * lm_h), lm_h, rm_ohm: omega * lm_h / q }
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

    /// The same inductance and quality factor at another resonance, Hz.
    pub fn with_series_resonance(self, hz: f64) -> Self {
        Self::at(hz, self.q(), self.lm_h)
    }
}

/// The elements of a stack's network.
#[derive(Clone, Debug, PartialEq)]
pub struct Parts {
    /// The circuit of the wanted mode.
    pub circuit: Circuit,
    /// Conductance in parallel with the clamped capacitance, S.
    pub leak_s: f64,
    /// Further modes.
    pub further: Vec<Branch>,
}

impl Parts {
    /// Those of a scene's stack at rest and at ambient temperature. The dielectric loss is a conductance that has the stated loss
    /// tangent at the series resonance: `G = tan(delta) omega C0`, and keeps its value whatever changes on the way.
    pub fn of(stack: &scene::Stack) -> Self {
        let circuit = Circuit::of(&stack.bvd);
        let leak_s = stack.bvd.loss_tangent * circuit.omega() * circuit.c0_f;
        Parts { circuit, leak_s, further: stack.mode.iter().map(Branch::of).collect() }
    }
}

impl From<Circuit> for Parts {
    /// The wanted mode alone, which does not leak.
    fn from(circuit: Circuit) -> Self {
        Parts { circuit, leak_s: 0.0, further: Vec::new() }
    }
}
