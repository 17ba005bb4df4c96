//! Circuit values: conversion of any complete set to the elements of the equivalent circuit. Every
//! set is resolved here.
//!
//! ```text
//! omega_s^2 Lm Cm = 1,   Q = omega_s Lm / Rm,   fp = fs sqrt(1 + Cm / C0),   k^2 = Cm / (C0 + Cm)
//! ```
//!
//! Instead of C0, the capacitance far below the resonance may be given: `CT = C0 + Cm`, as measured
//! by a bridge at 1 kHz. Then `k^2 = Cm / CT` and `CT / C0 = (fp / fs)^2`.
//!
//! A complete set contains `c0_f` or `ct_f`, and either of the following:
//!
//! * one of `q` and `rm_ohm`, and two of `series_resonance_hz`, `parallel_resonance_hz`, `lm_h`,
//!   `cm_f` and `coupling`; `cm_f` and `coupling` count as one, because each gives the other;
//! * both `q` and `rm_ohm`, and one of those five, since `Q Rm = sqrt(Lm / Cm)`.
//!
//! Additional values are accepted if they agree to 1 %, as rounded numbers of an analyser do. A
//! value that disagrees is named in the error.

use std::f64::consts::TAU;

/// Circuit values, as far as they are given.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Given {
    /// Clamped capacitance, F.
    pub c0_f: Option<f64>,
    /// Capacitance far below the resonance, F: clamped and motional together.
    pub ct_f: Option<f64>,
    /// Motional capacitance, F.
    pub cm_f: Option<f64>,
    /// Motional inductance, H.
    pub lm_h: Option<f64>,
    /// Motional resistance, ohm.
    pub rm_ohm: Option<f64>,
    /// Series resonance, Hz.
    pub series_resonance_hz: Option<f64>,
    /// Parallel resonance, Hz.
    pub parallel_resonance_hz: Option<f64>,
    /// Quality factor at the series resonance.
    pub q: Option<f64>,
    /// Effective coupling.
    pub coupling: Option<f64>,
}

/// Elements of a circuit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elements {
    /// Clamped capacitance, F.
    pub c0_f: f64,
    /// Motional capacitance, F.
    pub cm_f: f64,
    /// Motional inductance, H.
    pub lm_h: f64,
    /// Motional resistance, ohm.
    pub rm_ohm: f64,
}

/// Reason why a set of values does not define a circuit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CircuitError {
    /// Values are missing.
    #[error("the circuit is incomplete: {0}")]
    Incomplete(String),
    /// A value differs from the one that follows from the others.
    #[error("the circuit contradicts itself: `{name}` is {given:e}, but {follows:.3e} follows from the other values")]
    Contradicting {
        /// Name of the value.
        name: &'static str,
        /// The value as given.
        given: f64,
        /// The value that follows from the others.
        follows: f64,
    },
}

/// Largest relative difference that is taken for rounding.
const ROUNDING_REL: f64 = 0.01;

impl Elements {
    /// Returns the series resonance, Hz.
    pub fn series_resonance_hz(&self) -> f64 {
        1.0 / (TAU * (self.lm_h * self.cm_f).sqrt())
    }

    /// Returns the parallel resonance, Hz.
    pub fn parallel_resonance_hz(&self) -> f64 {
        self.series_resonance_hz() * (1.0 + self.cm_f / self.c0_f).sqrt()
    }

    /// Returns the quality factor at the series resonance.
    pub fn q(&self) -> f64 {
        (self.lm_h / self.cm_f).sqrt() / self.rm_ohm
    }

    /// Returns the effective coupling.
    pub fn coupling(&self) -> f64 {
        (self.cm_f / (self.c0_f + self.cm_f)).sqrt()
    }
}

impl Given {
    /// Returns names and values in the order of the fields, without the clamped capacitance.
    fn named(&self) -> [(&'static str, Option<f64>); 7] {
        [
            ("cm_f", self.cm_f),
            ("lm_h", self.lm_h),
            ("rm_ohm", self.rm_ohm),
            ("series_resonance_hz", self.series_resonance_hz),
            ("parallel_resonance_hz", self.parallel_resonance_hz),
            ("q", self.q),
            ("coupling", self.coupling),
        ]
    }

    /// Returns the elements that follow from the values.
    ///
    /// # Errors
    /// If values are missing, or if a value contradicts the others.
    pub fn resolve(&self) -> Result<Elements, CircuitError> {
        let incomplete = |what: &str| CircuitError::Incomplete(what.to_owned());
        let square = |hz: f64| (TAU * hz).powi(2);
        let c0_f = match (self.c0_f, self.ct_f) {
            (Some(c0_f), _) => c0_f,
            (None, Some(ct_f)) => self.clamped(ct_f)?,
            (None, None) => return Err(incomplete("`c0_f` or `ct_f` is missing")),
        };
        let by_coupling = || self.coupling.map(|k| c0_f * k * k / (1.0 - k * k));
        let by_resonances = || {
            let (fs, fp) = (self.series_resonance_hz?, self.parallel_resonance_hz?);
            Some(c0_f * ((fp / fs).powi(2) - 1.0))
        };
        let by_series = || Some(1.0 / (square(self.series_resonance_hz?) * self.lm_h?));
        let by_parallel = || Some(1.0 / (square(self.parallel_resonance_hz?) * self.lm_h? - 1.0 / c0_f));
        let by_impedance = || self.by_impedance();
        // With Lm = (Q Rm)^2 Cm the parallel resonance is (wp Q Rm Cm)^2 = 1 + Cm / C0, with one
        // positive root.
        let by_parallel_and_impedance = || {
            let a = square(self.parallel_resonance_hz?) * self.impedance()?.powi(2);
            Some((1.0 / c0_f + (1.0 / (c0_f * c0_f) + 4.0 * a).sqrt()) / (2.0 * a))
        };
        let cm_f = self.cm_f.or_else(by_coupling).or_else(by_resonances).or_else(by_series).or_else(by_parallel);
        let cm_f = cm_f.or_else(by_impedance).or_else(by_parallel_and_impedance);
        let two = "two of `series_resonance_hz`, `parallel_resonance_hz`, `lm_h` and (`cm_f` or `coupling`) are needed, or one \
                   of them with both `q` and `rm_ohm`";
        let cm_f = cm_f.ok_or_else(|| incomplete(two))?;
        if !(cm_f > 0.0 && cm_f.is_finite()) {
            let given = self.parallel_resonance_hz.unwrap_or_default();
            let follows = self.series_resonance_hz.or(self.lm_h.map(|lm| 1.0 / (TAU * (lm * c0_f).sqrt()))).unwrap_or_default();
            return Err(CircuitError::Contradicting { name: "parallel_resonance_hz", given, follows });
        }
        let by_parallel = || self.parallel_resonance_hz.map(|fp| (1.0 + cm_f / c0_f) / (square(fp) * cm_f));
        let by_series = || self.series_resonance_hz.map(|fs| 1.0 / (square(fs) * cm_f));
        let by_both = || Some(self.impedance()?.powi(2) * cm_f);
        let lm_h = self.lm_h.or_else(by_series).or_else(by_parallel).or_else(by_both).ok_or_else(|| incomplete(two))?;
        let by_q = || self.q.map(|q| (lm_h / cm_f).sqrt() / q);
        let rm_ohm = self.rm_ohm.or_else(by_q).ok_or_else(|| incomplete("`q` or `rm_ohm` is needed"))?;
        let elements = Elements { c0_f, cm_f, lm_h, rm_ohm };
        self.agrees(&elements)?;
        Ok(elements)
    }

    /// Returns `Q Rm = sqrt(Lm / Cm)`, ohm.
    fn impedance(&self) -> Option<f64> {
        Some(self.q? * self.rm_ohm?)
    }

    /// Returns the motional capacitance from Q, Rm and series resonance or inductance, F.
    fn by_impedance(&self) -> Option<f64> {
        let impedance = self.impedance()?;
        let by_series = || Some(1.0 / (TAU * self.series_resonance_hz? * impedance));
        by_series().or_else(|| Some(self.lm_h? / (impedance * impedance)))
    }

    /// Returns the clamped capacitance from the capacitance far below the resonance, F.
    fn clamped(&self, ct_f: f64) -> Result<f64, CircuitError> {
        let by_coupling = || self.coupling.map(|k| ct_f * k * k);
        let by_series = || Some(1.0 / ((TAU * self.series_resonance_hz?).powi(2) * self.lm_h?));
        let by_resonances = || Some(ct_f * (1.0 - (self.series_resonance_hz? / self.parallel_resonance_hz?).powi(2)));
        let cm_f = self.cm_f.or_else(by_coupling).or_else(by_resonances).or_else(by_series).or_else(|| self.by_impedance());
        // Given only Lm and the parallel resonance, Cm and C0 could be exchanged.
        let cm_f = cm_f.ok_or_else(|| {
            let needed = "in addition to `ct_f`, one of these is needed: `cm_f`; `coupling`; `series_resonance_hz` with \
                          `parallel_resonance_hz` or `lm_h`; `series_resonance_hz` or `lm_h` with `q` and `rm_ohm`";
            CircuitError::Incomplete(needed.to_owned())
        })?;
        if cm_f > 0.0 && cm_f < ct_f {
            Ok(ct_f - cm_f)
        } else {
            Err(CircuitError::Contradicting { name: "ct_f", given: ct_f, follows: cm_f })
        }
    }

    /// Checks every given value against the elements.
    fn agrees(&self, elements: &Elements) -> Result<(), CircuitError> {
        let follows = [
            elements.cm_f,
            elements.lm_h,
            elements.rm_ohm,
            elements.series_resonance_hz(),
            elements.parallel_resonance_hz(),
            elements.q(),
            elements.coupling(),
        ];
        let total = [(("ct_f", self.ct_f), elements.c0_f + elements.cm_f)];
        for ((name, given), follows) in self.named().into_iter().zip(follows).chain(total) {
            // NaN agrees with nothing.
            let agrees = |given: f64| (given / follows - 1.0).abs() <= ROUNDING_REL;
            if let Some(given) = given.filter(|&given| !agrees(given)) {
                return Err(CircuitError::Contradicting { name, given, follows });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRUTH: Elements = Elements { c0_f: 4.422e-9, cm_f: 617.7e-12, lm_h: 25.58e-3, rm_ohm: 7.115 };

    fn all() -> Given {
        Given {
            c0_f: Some(TRUTH.c0_f),
            ct_f: None,
            cm_f: Some(TRUTH.cm_f),
            lm_h: Some(TRUTH.lm_h),
            rm_ohm: Some(TRUTH.rm_ohm),
            series_resonance_hz: Some(TRUTH.series_resonance_hz()),
            parallel_resonance_hz: Some(TRUTH.parallel_resonance_hz()),
            q: Some(TRUTH.q()),
            coupling: Some(TRUTH.coupling()),
        }
    }

    /// Returns the values of `all` that are selected by the bits of a mask, in the order of
    /// `named`.
    fn some(mask: u32) -> Given {
        let all = all();
        let pick = |bit: u32, value: Option<f64>| value.filter(|_| mask >> bit & 1 == 1);
        Given {
            c0_f: all.c0_f,
            ct_f: None,
            cm_f: pick(0, all.cm_f),
            lm_h: pick(1, all.lm_h),
            rm_ohm: pick(2, all.rm_ohm),
            series_resonance_hz: pick(3, all.series_resonance_hz),
            parallel_resonance_hz: pick(4, all.parallel_resonance_hz),
            q: pick(5, all.q),
            coupling: pick(6, all.coupling),
        }
    }

    #[test]
    fn complete_sets_agree_and_others_are_refused() {
        for mask in 0..128 {
            let given = some(mask);
            let resistive = given.rm_ohm.is_some() || given.q.is_some();
            let strength = given.cm_f.is_some() || given.coupling.is_some();
            let kinds =
                [given.lm_h.is_some(), given.series_resonance_hz.is_some(), given.parallel_resonance_hz.is_some(), strength];
            let both = given.rm_ohm.is_some() && given.q.is_some();
            let complete = resistive && kinds.into_iter().filter(|given| *given).count() >= if both { 1 } else { 2 };
            match given.resolve() {
                Ok(found) => {
                    assert!(complete, "{given:?}");
                    for (found, truth) in [(found.cm_f, TRUTH.cm_f), (found.lm_h, TRUTH.lm_h), (found.rm_ohm, TRUTH.rm_ohm)] {
                        assert!((found / truth - 1.0).abs() < 1e-9, "{given:?}: {found:?}");
                    }
                }
                Err(error) => assert!(!complete && matches!(error, CircuitError::Incomplete(_)), "{given:?}: {error}"),
            }
        }
    }

    /// Every complete set with C0 is also complete with CT, except Lm with the parallel resonance:
    /// there Cm and C0 could be exchanged.
    #[test]
    fn total_capacitance_can_replace_the_clamped_one() {
        for mask in 0..128 {
            let by_clamped = some(mask);
            let by_total = Given { c0_f: None, ct_f: Some(TRUTH.c0_f + TRUTH.cm_f), ..by_clamped };
            let tells = by_clamped.cm_f.is_some()
                || by_clamped.coupling.is_some()
                || by_clamped.series_resonance_hz.is_some()
                    && (by_clamped.lm_h.is_some() || by_clamped.parallel_resonance_hz.is_some())
                || by_clamped.impedance().is_some() && (by_clamped.series_resonance_hz.is_some() || by_clamped.lm_h.is_some());
            match by_total.resolve() {
                Ok(found) => {
                    let c0 = (found.c0_f / TRUTH.c0_f - 1.0).abs();
                    assert!(tells && by_clamped.resolve().is_ok() && c0 < 1e-9, "{by_total:?}: {found:?}");
                }
                Err(error) => assert!(!tells || by_clamped.resolve().is_err(), "{by_total:?}: {error}"),
            }
        }
        let small = Given { c0_f: None, ct_f: Some(0.5 * TRUTH.cm_f), ..all() };
        assert!(matches!(small.resolve(), Err(CircuitError::Contradicting { name: "ct_f", .. })));
        let both = Given { ct_f: Some(TRUTH.c0_f), ..all() };
        assert!(matches!(both.resolve(), Err(CircuitError::Contradicting { name: "ct_f", .. })));
    }

    #[test]
    fn rounded_values_pass_and_contradictions_fail() {
        assert!(Given { q: Some(TRUTH.q() * 1.005), ..all() }.resolve().is_ok());
        let error = Given { q: Some(100.0), ..all() }.resolve().unwrap_err().to_string();
        assert!(error.starts_with("the circuit contradicts itself: `q` is 1e2, but 9.04"), "{error}");
        let below = Given { parallel_resonance_hz: Some(39e3), ..some(0b11_1000) };
        assert!(matches!(below.resolve(), Err(CircuitError::Contradicting { name: "parallel_resonance_hz", .. })));
    }
}
