//! What changes between two networks, as relative changes of entries of the matrix.

use crate::parts::Parts;

/// Relative change of the damping that counts as none (round-off).
const ROUND_OFF_REL: f64 = 1e-9;

/// A change that a series follows; `s` is its size, relative to the centre of the series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// The clamped capacitance: `1/C0` with `1 + s`.
    Clamped,
    /// The working mode's inductance: `1/Lm` with `1 + s`.
    Inductance,
    /// The working mode's resonance at constant inductance and quality factor: `1/Cm` with
    /// `(1 + s)^2`, `Rm/Lm` with `1 + s`.
    Resonance,
    /// The working mode's damping besides: `Rm/Lm` with `1 + s`.
    Damping,
    /// The resonance of a further mode at constant inductance and quality factor.
    Further(usize),
}

/// All changes. A stack has up to three further modes, and a crack adds one.
pub const ALL: [Change; 8] = [
    Change::Clamped,
    Change::Inductance,
    Change::Resonance,
    Change::Damping,
    Change::Further(0),
    Change::Further(1),
    Change::Further(2),
    Change::Further(3),
];

impl Change {
    /// Returns every `s` from one network to another, in the order of [`ALL`]; `None` if anything
    /// else differs.
    pub fn between(from: &Parts, to: &Parts) -> Option<[f64; ALL.len()]> {
        if from.leak_s != to.leak_s || from.further.len() != to.further.len() {
            return None;
        }
        let (a, b) = (&from.circuit, &to.circuit);
        let [resonance, damping] = moved([a.cm_f, a.rm_ohm / a.lm_h], [b.cm_f, b.rm_ohm / b.lm_h]);
        let mut changes = [0.0; ALL.len()];
        changes[..4].copy_from_slice(&[a.c0_f / b.c0_f - 1.0, a.lm_h / b.lm_h - 1.0, resonance, damping]);
        for ((s, a), b) in changes[4..].iter_mut().zip(&from.further).zip(&to.further) {
            let [resonance, damping] = moved([a.cm_f, a.rm_ohm / a.lm_h], [b.cm_f, b.rm_ohm / b.lm_h]);
            if a.lm_h != b.lm_h || damping.is_nan() || damping.abs() > ROUND_OFF_REL {
                return None;
            }
            *s = resonance;
        }
        Some(changes)
    }

    /// Returns `true` if `s` is more than round-off.
    pub fn is_more_than_round_off(self, s: f64) -> bool {
        s != 0.0 && (self != Change::Damping || s.is_nan() || s.abs() > ROUND_OFF_REL)
    }

    /// Returns what changes from one network to another; `None` if anything without a series does.
    pub fn kinds(from: &Parts, to: &Parts) -> Option<Vec<Change>> {
        let changes = Self::between(from, to)?.into_iter().zip(ALL);
        Some(changes.filter(|(s, change)| change.is_more_than_round_off(*s)).map(|(_, change)| change).collect())
    }
}

/// Returns the relative changes of the resonance at constant Q, and of the damping besides, from
/// `Cm` and `Rm/Lm` of a branch to others.
fn moved(from: [f64; 2], to: [f64; 2]) -> [f64; 2] {
    let resonance = (from[0] / to[0]).sqrt();
    [resonance - 1.0, to[1] / (from[1] * resonance) - 1.0]
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::circuit::Branch;
    use crate::circuit::Circuit;

    const A3: Circuit = Circuit { c0_f: 300e-9, cm_f: 20e-9, lm_h: 0.7916e-3, rm_ohm: 3.08, force_factor_n_per_v: 5.566 };

    pub fn parts(further: usize) -> Parts {
        let further = (0..further).map(|k| Branch::new(41e3 + 3e3 * k as f64, 90.0, 4e-3)).collect();
        Parts { circuit: A3, leak_s: 1e-3, further }
    }

    /// Returns the elements after one change by `s`.
    pub fn with(change: Change, parts: &Parts, s: f64) -> Parts {
        let mut to = parts.clone();
        let circuit = parts.circuit;
        match change {
            Change::Resonance => to.circuit = circuit.with_series_resonance(circuit.series_resonance_hz() * (1.0 + s)),
            Change::Damping => to.circuit.rm_ohm *= 1.0 + s,
            Change::Clamped => to.circuit.c0_f /= 1.0 + s,
            Change::Inductance => {
                to.circuit.lm_h /= 1.0 + s;
                to.circuit.rm_ohm /= 1.0 + s;
                to.circuit.force_factor_n_per_v *= (1.0 + s).sqrt();
            }
            Change::Further(k) => {
                let branch = parts.further[k];
                to.further[k] = branch.with_series_resonance(branch.series_resonance_hz() * (1.0 + s));
            }
        }
        to
    }

    #[test]
    fn what_changes_is_found() {
        let from = parts(2);
        let kinds = |to: &Parts| Change::kinds(&from, to);
        let all = [Change::Clamped, Change::Inductance, Change::Resonance, Change::Damping, Change::Further(0)];
        let to = all.iter().fold(from.clone(), |to, change| with(*change, &to, 1e-3));
        assert_eq!(kinds(&to), Some(all.to_vec()));
        assert_eq!(kinds(&with(Change::Damping, &from, 1e-3)), Some(vec![Change::Damping]));
        assert_eq!(kinds(&Parts { leak_s: 2e-3, ..from.clone() }), None);
        assert_eq!(kinds(&parts(3)), None);
        let damped = Branch { rm_ohm: 2.0 * from.further[0].rm_ohm, ..from.further[0] };
        assert_eq!(kinds(&Parts { further: vec![damped, from.further[1]], ..from.clone() }), None);
    }
}
