//! What breaks in a stack.
//!
//! | fault | what it does |
//! |---|---|
//! | shorted | 50 milliohm across it, a spark that has carbonised its way: the voltage collapses behind the source resistance |
//! | depoled | C0 falls by a third and every coupling to a tenth (Cm to a hundredth, Lm and Rm to a hundredfold; resonance and Q stay) |
//! | cracked | Q falls to a fifth, and a second mode appears 1.5 % below, with a fifth of Cm and the same Q |
//!
//! The depoled stack's clamped capacitance is that of unpoled ceramic of the lead zirconate titanate family, whose permittivity is some
//! tens of per cent below that of poled one; the cracked one's mode is the crack's own half of the stack. The sizes are assumptions.

use crate::circuit::Branch;
use crate::circuit::Circuit;
use crate::parts::Parts;

/// What a short is left with, ohm.
pub const SHORT_OHM: f64 = 0.05;
/// What a depoled stack keeps of its clamped capacitance.
pub const DEPOLED_CAPACITANCE: f64 = 2.0 / 3.0;
/// What a depoled stack keeps of its coupling: of its force factor.
pub const DEPOLED_COUPLING: f64 = 0.1;
/// What a cracked stack keeps of its quality factor.
pub const CRACKED_Q: f64 = 0.2;
/// Where the mode of a crack is, relative to the series resonance.
pub const CRACK_RESONANCE: f64 = 0.985;
/// The motional capacitance of that mode, relative to that of the working mode.
pub const CRACK_STRENGTH: f64 = 0.2;

/// A part of the transducer that breaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Breakage {
    /// A short across the stack.
    Shorted,
    /// The stack has lost its polarisation.
    Depoled,
    /// The stack has a crack.
    Cracked,
}

/// Something that breaks in a certain block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scheduled {
    /// In which block, counted from zero: so from its beginning.
    pub at_block: u64,
    /// The part that breaks.
    pub breakage: Breakage,
}

impl Breakage {
    /// The elements of a stack that breaks.
    pub fn of(self, parts: Parts) -> Parts {
        match self {
            Breakage::Shorted => Parts { leak_s: parts.leak_s + 1.0 / SHORT_OHM, ..parts },
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
                further.push(Branch::at(hz, circuit.q(), lm_h));
                Parts { circuit, further, ..parts }
            }
        }
    }
}
