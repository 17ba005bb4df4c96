//! All values of a transducer, from its equivalent circuit (Butterworth 1914, Van Dyke 1928).
//!
//! ```text
//! k^2 = Cm / (C0 + Cm),    M = 1 / (omega C0 Rm),    tau = Q / (pi fs)
//! ```
//!
//! `M` is the figure of merit (IEEE 177): the phase between voltage and total current returns to
//! zero above the series resonance only if `M > 2`. Near the resonance, with
//! `x = 2 Q (f - fs) / fs`, the zero is at `Im{1 / (1 + j x)} + 1 / M = 0`:
//!
//! ```text
//! x = M / 2 - sqrt(M^2 / 4 - 1)
//! ```

use serde::Serialize;

use plant::circuit::Circuit;

/// Figure of merit above which the phase between voltage and total current has a zero.
pub const ZERO_PHASE_M: f64 = 2.0;

/// Values of a transducer and those derived from them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Full {
    /// Series resonance of the stack, Hz.
    pub series_resonance_hz: f64,
    /// Parallel resonance of the stack, Hz.
    pub parallel_resonance_hz: f64,
    /// Quality factor of the stack.
    pub q: f64,
    /// Motional resistance of the stack, ohm.
    pub rm_ohm: f64,
    /// Motional inductance of the stack, H.
    pub lm_h: f64,
    /// Motional capacitance of the stack, F.
    pub cm_f: f64,
    /// Clamped capacitance of the stack, F.
    pub c0_f: f64,
    /// Effective electromechanical coupling of the stack.
    pub coupling: f64,
    /// Figure of merit M.
    pub figure_of_merit: f64,
    /// Time constant of the ring-up, ms.
    pub time_constant_ms: f64,
    /// Offset above the series resonance at which a loop on the phase of the total current would
    /// settle, Hz; `None` if the phase has no zero.
    pub zero_phase_bias_hz: Option<f64>,
}

impl Full {
    /// Computes the derived values of a circuit.
    pub fn from_circuit(circuit: &Circuit) -> Self {
        let (hz, q) = (circuit.series_resonance_hz(), circuit.q());
        let Circuit { c0_f, cm_f, lm_h, rm_ohm, .. } = *circuit;
        let m = 1.0 / (circuit.omega() * c0_f * rm_ohm);
        let bias = || hz / (2.0 * q) * (0.5 * m - (0.25 * m * m - 1.0).sqrt());
        Full {
            series_resonance_hz: hz,
            parallel_resonance_hz: hz * (1.0 + cm_f / c0_f).sqrt(),
            q,
            rm_ohm,
            lm_h,
            cm_f,
            c0_f,
            coupling: (cm_f / (c0_f + cm_f)).sqrt(),
            figure_of_merit: m,
            time_constant_ms: 1e3 * circuit.time_constant_s(),
            zero_phase_bias_hz: (m > ZERO_PHASE_M).then(bias),
        }
    }
}
