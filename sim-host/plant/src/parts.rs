//! The elements of a stack's network: the circuit of the working mode, the leakage, and the further
//! modes.

use crate::circuit::{Branch, Circuit};

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
    /// Returns the elements of a scene's stack at rest and at ambient temperature. The dielectric
    /// loss is a conductance that has the stated loss tangent at the series resonance:
    /// `G = tan(delta) omega C0`. It stays constant when other elements change.
    pub fn from_stack(stack: &scene::Stack) -> Self {
        let circuit = Circuit::from_bvd(&stack.bvd);
        let leak_s = stack.bvd.loss_tangent * circuit.omega() * circuit.c0_f;
        Parts { circuit, leak_s, further: stack.mode.iter().map(Branch::from_mode).collect() }
    }
}

impl From<Circuit> for Parts {
    /// Converts the working mode alone, without leakage.
    fn from(circuit: Circuit) -> Self {
        Parts { circuit, leak_s: 0.0, further: Vec::new() }
    }
}
