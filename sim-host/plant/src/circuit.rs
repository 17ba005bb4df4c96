//! Equivalent circuit of a stack (Butterworth 1914, Van Dyke 1928), from either form in which a
//! scene can state it.
//!
//! `omega^2 = 1 / (Lm Cm)`, `Q = omega Lm / Rm`, `k^2 = Cm / (C0 + Cm)`.

use scene::Bvd;

/// Equivalent circuit, as the elements in the equations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circuit {
    /// Clamped capacitance of the transducer, F.
    pub c0_f: f64,
    /// Motional capacitance of the branch, F.
    pub cm_f: f64,
    /// Motional inductance of the branch, H.
    pub lm_h: f64,
    /// Motional resistance of the branch, ohm.
    pub rm_ohm: f64,
    /// Force factor of the branch, N/V.
    pub force_factor_n_per_v: f64,
}

/// Series branch of one mode in the equivalent circuit.
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
    /// Returns the branch of a further mode: `Cm = 1 / (omega^2 Lm)`, `Rm = omega Lm / Q`. Its
    /// force factor does not matter, as the mode does not move the tip along the friction.
    pub fn from_mode(mode: &scene::Mode) -> Self {
        Self::new(mode.series_resonance_hz, mode.q, mode.lm_h)
    }

    /// Creates the branch with this resonance, Hz, quality factor and inductance, H.
    pub fn new(series_resonance_hz: f64, q: f64, lm_h: f64) -> Self {
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

    /// Returns the quality factor at series resonance.
    pub fn q(&self) -> f64 {
        self.omega() * self.lm_h / self.rm_ohm
    }

    /// Returns the branch with another series resonance, Hz, at constant inductance and quality
    /// factor.
    pub fn with_series_resonance(self, hz: f64) -> Self {
        Self::new(hz, self.q(), self.lm_h)
    }
}

impl Circuit {
    /// Converts either form of a scene's stack. A validated scene gives one of them in full.
    pub fn from_bvd(bvd: &Bvd) -> Self {
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

    /// Returns the motional branch of the circuit.
    fn branch(&self) -> Branch {
        Branch { cm_f: self.cm_f, lm_h: self.lm_h, rm_ohm: self.rm_ohm }
    }

    /// Series resonance of the branch, rad/s.
    pub fn omega(&self) -> f64 {
        self.branch().omega()
    }

    /// Series resonance of the branch, Hz.
    pub fn series_resonance_hz(&self) -> f64 {
        self.branch().series_resonance_hz()
    }

    /// Returns the quality factor at series resonance.
    pub fn q(&self) -> f64 {
        self.branch().q()
    }

    /// Returns the circuit with another series resonance, at constant inductance and quality
    /// factor.
    pub fn with_series_resonance(self, hz: f64) -> Self {
        let Branch { cm_f, lm_h, rm_ohm } = self.branch().with_series_resonance(hz);
        Circuit { cm_f, lm_h, rm_ohm, ..self }
    }

    /// Returns the circuit with another quality factor, at constant resonance.
    pub fn with_q(self, q: f64) -> Self {
        Circuit { rm_ohm: self.omega() * self.lm_h / q, ..self }
    }

    /// Returns the time constant of the ring-up, s.
    pub fn time_constant_s(&self) -> f64 {
        2.0 * self.lm_h / self.rm_ohm
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
            ct_f: None,
            cm_f: None,
            lm_h: None,
            rm_ohm: None,
            series_resonance_hz: Some(A3.series_resonance_hz()),
            parallel_resonance_hz: None,
            q: Some(A3.q()),
            coupling: Some(0.25),
            force_factor_n_per_v: 5.566,
            loss_tangent: 0.0,
            temperature_hz_per_k: 0.0,
            temperature_c0_per_k: 0.0,
            duffing_hz_per_a2: 0.0,
            temperature_rm_per_k: 0.0,
            temperature_force_factor_per_k: 0.0,
            amplitude_rm_per_a2: 0.0,
            amplitude_rm_most: None,
        };
        let circuit = Circuit::from_bvd(&bvd);
        assert!((circuit.cm_f / A3.cm_f - 1.0).abs() < 1e-12);
        assert!((circuit.lm_h / A3.lm_h - 1.0).abs() < 1e-12);
        assert!((circuit.rm_ohm / A3.rm_ohm - 1.0).abs() < 1e-12);
    }
}
