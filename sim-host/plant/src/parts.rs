//! The elements of a stack's network: the circuit of the working mode, the leakage, and the further modes.

use crate::circuit::Circuit;

/// A further mode: a series branch in parallel with that of the working mode. Its force factor does not matter, as it does not move the
/// tip along the friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Branch {
    /// Motional capacitance of the mode, F.
    pub cm_f: f64,
    /// Motional inductance of the mode, H.
    pub lm_h: f64,
    /// Motional resistance of the mode, ohm.
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

    /// Series resonance of the mode, rad/s.
    pub fn omega(&self) -> f64 {
        1.0 / (self.lm_h * self.cm_f).sqrt()
    }

    /// Series resonance of the mode, Hz.
    pub fn series_resonance_hz(&self) -> f64 {
        self.omega() / std::f64::consts::TAU
    }

    /// Quality factor at series resonance.
    pub fn q(&self) -> f64 {
        self.omega() * self.lm_h / self.rm_ohm
    }

    /// The branch with another series resonance, Hz, at constant inductance and quality factor.
    pub fn with_series_resonance(self, hz: f64) -> Self {
        Self::at(hz, self.q(), self.lm_h)
    }
}

/// The elements of a stack's network.
#[derive(Clone, Debug, PartialEq)]
pub struct Parts {
    /// The circuit of the working mode.
    pub circuit: Circuit,
    /// Conductance in parallel with the clamped capacitance, S.
    pub leak_s: f64,
    /// Branches of further modes.
    pub further: Vec<Branch>,
}

impl Parts {
    /// The elements of a scene's stack at rest and at ambient temperature. The dielectric loss is a conductance that has the stated loss
    /// tangent at the series resonance: `G = tan(delta) omega C0`, and keeps its value whatever changes on the way.
    pub fn of(stack: &scene::Stack) -> Self {
        let circuit = Circuit::of(&stack.bvd);
        let leak_s = stack.bvd.loss_tangent * circuit.omega() * circuit.c0_f;
        Parts { circuit, leak_s, further: stack.mode.iter().map(Branch::of).collect() }
    }
}

impl From<Circuit> for Parts {
    /// The working mode alone, without leakage.
    fn from(circuit: Circuit) -> Self {
        Parts { circuit, leak_s: 0.0, further: Vec::new() }
    }
}
