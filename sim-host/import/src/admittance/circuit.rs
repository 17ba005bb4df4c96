//! Fitted circuit: a clamped capacitance with its dielectric loss, and a series branch for each
//! resonance.
//!
//! ```text
//! Y = omega C0 (j + tan d) + sum G / (1 + j Q (f / fs - fs / f)),     G = 1 / Rm
//! Lm = Q Rm / omega_s,  Cm = 1 / (omega_s Q Rm),  fp = fs sqrt(1 + Cm / C0),  k^2 = Cm / (C0 + Cm)
//! ```
//!
//! S. Butterworth, Proc. Phys. Soc. 26 (1914) 264; K. S. Van Dyke, Proc. IRE 16 (1928) 742; IEEE
//! Std
//! 177. The parameters of the fit are `C0`, `C0 tan d`, and the logarithms of `fs`, `Q` and `G` of
//!      each branch. The logarithms keep these positive, and their errors are nearly normal if a
//!      resonance is measured well.

use std::f64::consts::TAU;

use num_complex::Complex64;

/// Number of parameters of the clamped branch.
pub(super) const CLAMPED_PARAMETERS: usize = 2;
/// Number of parameters of a resonance.
pub const BRANCH_PARAMETERS: usize = 3;

/// Series branch of a resonance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Branch {
    /// Series resonance of the branch, Hz.
    pub hz: f64,
    /// Quality factor of the branch.
    pub q: f64,
    /// Conductance at the series resonance, 1 / Rm, S.
    pub siemens: f64,
}

/// Equivalent circuit of a transducer.
#[derive(Clone, Debug, PartialEq)]
pub struct Equivalent {
    /// Clamped capacitance of the transducer, F.
    pub c0_f: f64,
    /// Dielectric loss tangent of the clamped capacitance.
    pub loss_tangent: f64,
    /// Resonances of the transducer.
    pub branches: Vec<Branch>,
}

/// Returns the admittance of a branch by its parameters `ln fs`, `ln Q`, `ln G`, S, and its
/// derivatives by them.
pub fn branch([ln_hz, ln_q, ln_g]: [f64; BRANCH_PARAMETERS], hz: f64) -> (Complex64, [Complex64; BRANCH_PARAMETERS]) {
    let (own, q, g) = (libm::exp(ln_hz), libm::exp(ln_q), libm::exp(ln_g));
    let (up, down) = (hz / own, own / hz);
    let h = Complex64::new(1.0, q * (up - down)).inv();
    let y = g * h;
    let by = |reactance: f64| -y * h * Complex64::new(0.0, reactance);
    (y, [by(-q * (up + down)), by(q * (up - down)), y])
}

impl Branch {
    /// Returns the branch of the parameters `ln fs`, `ln Q`, `ln G`.
    pub fn from_parameters(parameters: &[f64]) -> Self {
        let exp = |at: usize| libm::exp(parameters[at]);
        Branch { hz: exp(0), q: exp(1), siemens: exp(2) }
    }

    /// Returns the parameters `ln fs`, `ln Q`, `ln G`.
    pub fn parameters(&self) -> [f64; BRANCH_PARAMETERS] {
        [self.hz, self.q, self.siemens].map(libm::log)
    }

    /// Returns the admittance at a frequency, S.
    pub fn admittance(&self, hz: f64) -> Complex64 {
        self.siemens / Complex64::new(1.0, self.q * (hz / self.hz - self.hz / hz))
    }

    /// Returns the parallel resonance frequency with a clamped capacitance, Hz.
    pub fn parallel_hz(&self, c0_f: f64) -> f64 {
        self.hz * (1.0 + self.cm_f() / c0_f).sqrt()
    }

    /// Returns the effective coupling factor with a clamped capacitance.
    pub fn coupling(&self, c0_f: f64) -> f64 {
        (self.cm_f() / (c0_f + self.cm_f())).sqrt()
    }

    /// Returns the figure of merit with a clamped capacitance, `Q Cm / C0`: the conductance at the
    /// series resonance, relative to the susceptance of the clamped capacitance.
    pub fn merit(&self, c0_f: f64) -> f64 {
        self.q * self.cm_f() / c0_f
    }

    /// Returns the motional resistance of the branch, ohm.
    pub fn rm_ohm(&self) -> f64 {
        1.0 / self.siemens
    }

    /// Returns the motional inductance of the branch, H.
    pub fn lm_h(&self) -> f64 {
        self.q / (TAU * self.hz * self.siemens)
    }

    /// Returns the motional capacitance of the branch, F.
    pub fn cm_f(&self) -> f64 {
        self.siemens / (TAU * self.hz * self.q)
    }
}

impl Equivalent {
    /// Creates the circuit from the parameters of a fit, with capacitances in units of `farad`.
    pub(super) fn from_parameters(parameters: &[f64], farad: f64) -> Self {
        let c0_f = parameters[0] * farad;
        let branches = parameters[CLAMPED_PARAMETERS..].chunks_exact(BRANCH_PARAMETERS).map(Branch::from_parameters).collect();
        Equivalent { c0_f, loss_tangent: parameters[1] / parameters[0], branches }
    }

    /// Returns the parameters of a fit, with capacitances in units of `farad`.
    pub(super) fn parameters(&self, farad: f64) -> Vec<f64> {
        let c0 = self.c0_f / farad;
        let branches = self.branches.iter().flat_map(Branch::parameters);
        [c0, c0 * self.loss_tangent].into_iter().chain(branches).collect()
    }

    /// Returns the admittance at a frequency, S.
    pub fn admittance(&self, hz: f64) -> Complex64 {
        admittance(&self.parameters(1.0), 1.0, hz, None)
    }
}

/// Returns the admittance at a frequency for the parameters of a fit, S, and optionally its
/// derivatives by them.
pub(super) fn admittance(parameters: &[f64], farad: f64, hz: f64, mut slopes: Option<&mut Vec<Complex64>>) -> Complex64 {
    let siemens = TAU * hz * farad;
    let mut sum = siemens * Complex64::new(parameters[1], parameters[0]);
    if let Some(slopes) = slopes.as_deref_mut() {
        slopes.clear();
        slopes.extend([Complex64::new(0.0, siemens), Complex64::new(siemens, 0.0)]);
    }
    for own in parameters[CLAMPED_PARAMETERS..].chunks_exact(BRANCH_PARAMETERS) {
        let (y, derivatives) = branch([own[0], own[1], own[2]], hz);
        sum += y;
        if let Some(slopes) = slopes.as_deref_mut() {
            slopes.extend(derivatives);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> Equivalent {
        let branches = vec![Branch { hz: 40e3, q: 65.0, siemens: 0.3 }, Branch { hz: 42e3, q: 300.0, siemens: 0.02 }];
        Equivalent { c0_f: 300e-9, loss_tangent: 0.004, branches }
    }

    #[test]
    fn the_elements_give_the_same_admittance() {
        let circuit = example();
        let hz = 40.3e3;
        let omega = TAU * hz;
        let series = |b: &Branch| Complex64::new(b.rm_ohm(), omega * b.lm_h() - 1.0 / (omega * b.cm_f())).inv();
        let clamped = omega * circuit.c0_f * Complex64::new(circuit.loss_tangent, 1.0);
        let expected: Complex64 = clamped + circuit.branches.iter().map(series).sum::<Complex64>();
        assert!((circuit.admittance(hz) / expected - 1.0).norm_sqr() < 1e-24);
    }

    #[test]
    fn derivatives_agree_with_finite_differences() {
        let parameters = example().parameters(1e-9);
        let mut slopes = Vec::new();
        admittance(&parameters, 1e-9, 40.3e3, Some(&mut slopes));
        for at in 0..parameters.len() {
            let step = 1e-7;
            let moved = |by: f64| {
                let mut moved = parameters.clone();
                moved[at] += by;
                admittance(&moved, 1e-9, 40.3e3, None)
            };
            let numeric = (moved(step) - moved(-step)) / (2.0 * step);
            assert!((numeric - slopes[at]).norm_sqr() < 1e-12 * slopes[at].norm_sqr(), "{at}: {numeric} {}", slopes[at]);
        }
        assert_eq!(Equivalent::from_parameters(&parameters, 1e-9).branches.len(), 2);
    }
}
