//! Failures of a stack.
//!
//! | fault | effect |
//! |---|---|
//! | shorted | 50 milliohm across it, a spark that has carbonised its path: the voltage at the stack collapses, as nearly all of it drops across the source resistance |
//! | depoled | C0 falls by a third and every coupling to a tenth (Cm to a hundredth, Lm and Rm rise a hundredfold; resonance and Q remain) |
//! | cracked | Q falls to a fifth, and a second mode appears 1.5 % below, with a fifth of Cm and the same Q |
//!
//! The clamped capacitance of the depoled stack is that of unpoled lead zirconate titanate, whose
//! permittivity is some tens of per cent below that of poled ceramic. The mode of the cracked stack
//! belongs to the part of the stack on one side of the crack. The sizes are assumptions.

use crate::circuit::Branch;
use crate::circuit::Circuit;
use crate::parts::Parts;

/// Resistance of a short if the scene gives none, ohm.
pub const SHORT_OHM: f64 = 0.05;
/// Clamped capacitance of a depoled stack, relative to a sound one.
pub const DEPOLED_CAPACITANCE: f64 = 2.0 / 3.0;
/// Coupling (force factor) of a depoled stack, relative to a sound one.
pub const DEPOLED_COUPLING: f64 = 0.1;
/// Quality factor of a cracked stack, relative to a sound one.
pub const CRACKED_Q: f64 = 0.2;
/// Resonance of the mode of a crack, relative to the series resonance.
pub const CRACK_RESONANCE: f64 = 0.985;
/// The motional capacitance of that mode, relative to that of the working mode.
pub const CRACK_STRENGTH: f64 = 0.2;

/// A part of the transducer that breaks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Breakage {
    /// A short of this resistance across the stack, ohm.
    Shorted(f64),
    /// The stack has lost its polarisation.
    Depoled,
    /// The stack has a crack.
    Cracked,
}

/// A breakage that is scheduled for a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scheduled {
    /// Block at whose beginning it occurs, counted from zero.
    pub at_block: u64,
    /// The part that breaks.
    pub breakage: Breakage,
}

impl Breakage {
    /// Returns the elements of a stack after this breakage.
    pub fn apply(self, parts: Parts) -> Parts {
        match self {
            Breakage::Shorted(ohm) => Parts { leak_s: parts.leak_s + 1.0 / ohm, ..parts },
            Breakage::Depoled => {
                let coupling = DEPOLED_COUPLING * DEPOLED_COUPLING;
                let further = parts.further.into_iter().map(|Branch { cm_f, lm_h, rm_ohm }| Branch {
                    cm_f: cm_f * coupling,
                    lm_h: lm_h / coupling,
                    rm_ohm: rm_ohm / coupling,
                });
                let Circuit { c0_f, cm_f, lm_h, rm_ohm, force_factor_n_per_v } = parts.circuit;
                let circuit = Circuit {
                    c0_f: c0_f * DEPOLED_CAPACITANCE,
                    cm_f: cm_f * coupling,
                    lm_h: lm_h / coupling,
                    rm_ohm: rm_ohm / coupling,
                    force_factor_n_per_v: force_factor_n_per_v * DEPOLED_COUPLING,
                };
                Parts { circuit, leak_s: parts.leak_s * DEPOLED_CAPACITANCE, further: further.collect() }
            }
            Breakage::Cracked => {
                let circuit = parts.circuit.with_q(parts.circuit.q() * CRACKED_Q);
                let hz = CRACK_RESONANCE * circuit.series_resonance_hz();
                let cm_f = CRACK_STRENGTH * circuit.cm_f;
                let lm_h = 1.0 / ((std::f64::consts::TAU * hz).powi(2) * cm_f);
                let mut further = parts.further;
                further.push(Branch::new(hz, circuit.q(), lm_h));
                Parts { circuit, further, ..parts }
            }
        }
    }
}
