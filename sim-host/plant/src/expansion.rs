//! A flow that follows one changing element of its network, as a Taylor series about the network
//! for which it was computed.
//!
//! Usually one thing drifts at a time: a resonance (by temperature, amplitude, load), a damping,
//! the clamped capacitance. Along such a path the network is a polynomial in the relative change
//! `s`, so its exponential has a series in `s` that converges for any change. The coefficients up
//! to the fourth are exact ([`exponential_series`]). The fifth sets the range: up to the `s` at
//! which its term is `MAX_NEGLECTED_TERM`. Outside that range a new series is computed.

use crate::network::{DRIVE, FORCE, FURTHER, I, V0, VC, network};
use crate::parts::Parts;
use crate::step_flow::{Layout, StepFlow};
use contact::flow::{Matrix, exponential_series};
use scene::Amplifier;

/// Number of coefficients of the series that are used.
const COEFFICIENTS: usize = 5;
/// Number of coefficients that are computed: one more, for the bound.
const COEFFICIENTS_COMPUTED: usize = COEFFICIENTS + 1;
/// Largest first neglected term, for a flow with voltages of order one: near the round-off of the
/// exponential itself.
const MAX_NEGLECTED_TERM: f64 = 1e-15;
/// Largest range of a series, relative change.
const MAX_RANGE_REL: f64 = 0.1;
/// Relative difference below which two numbers count as equal (round-off).
const ROUND_OFF_REL: f64 = 1e-9;

/// The element that changes; `s` is its change relative to the centre of the series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// The working mode's resonance at constant inductance and quality factor: `1/Cm` with
    /// `(1 + s)^2`, `Rm` with `1 + s`.
    Resonance,
    /// The working mode's damping: `Rm` with `1 + s`.
    Damping,
    /// The clamped capacitance: `1/C0` with `1 + s`.
    Clamped,
    /// The resonance of a further mode.
    Further(usize),
}

impl Path {
    /// Returns the path from one network to another, and the distance along it; `None` if more than
    /// one thing differs.
    pub fn between(from: &Parts, to: &Parts) -> Option<(Path, f64)> {
        let (a, b) = (&from.circuit, &to.circuit);
        if from.leak_s != to.leak_s || a.lm_h != b.lm_h || a.force_factor_n_per_v != b.force_factor_n_per_v {
            return None;
        }
        let moved: Vec<usize> = (0..from.further.len()).filter(|&k| from.further[k] != to.further[k]).collect();
        let of_resonance = |cm: [f64; 2], rm: [f64; 2]| {
            let s = (cm[0] / cm[1]).sqrt() - 1.0;
            (rm[1] / (rm[0] * (1.0 + s)) - 1.0).abs().le(&ROUND_OFF_REL).then_some(s)
        };
        match (a.c0_f != b.c0_f, a.cm_f != b.cm_f, a.rm_ohm != b.rm_ohm, moved.as_slice()) {
            (true, false, false, []) => Some((Path::Clamped, a.c0_f / b.c0_f - 1.0)),
            (false, false, true, []) => Some((Path::Damping, b.rm_ohm / a.rm_ohm - 1.0)),
            (false, true, _, []) => of_resonance([a.cm_f, b.cm_f], [a.rm_ohm, b.rm_ohm]).map(|s| (Path::Resonance, s)),
            (false, false, false, &[k]) => {
                let (a, b) = (&from.further[k], &to.further[k]);
                let s = of_resonance([a.cm_f, b.cm_f], [a.rm_ohm, b.rm_ohm]).filter(|_| a.lm_h == b.lm_h);
                s.map(|s| (Path::Further(k), s))
            }
            _ => None,
        }
    }

    /// Returns the network as a polynomial in the relative change.
    fn series<const N: usize>(self, parts: &Parts, amplifier: &Amplifier) -> [Matrix<N>; 3] {
        let still: Matrix<N> = network(parts, amplifier);
        let [mut first, mut second] = [[[0.0; N]; N]; 2];
        let mut resonance = |i: usize, vc: usize| {
            first[vc][i] = 2.0 * still[vc][i];
            second[vc][i] = still[vc][i];
            first[i][i] = still[i][i];
        };
        match self {
            Path::Resonance => resonance(I, VC),
            Path::Further(k) => resonance(FURTHER + 2 * k, FURTHER + 2 * k + 1),
            Path::Damping => first[I][I] = still[I][I],
            Path::Clamped => first[V0] = still[V0],
        }
        [still, first, second]
    }
}

/// The series of a flow along a path.
#[derive(Clone, Debug)]
pub struct Expansion {
    parts: Parts,
    path: Path,
    reach: f64,
    /// Coefficients by degree, for every number of the flow in order.
    coefficients: [Vec<f64>; COEFFICIENTS],
}

impl Expansion {
    /// Creates the series of the flow of `parts` along `path`, and the flow itself.
    pub fn new(parts: &Parts, path: Path, amplifier: &Amplifier, layout: &Layout) -> (Self, StepFlow) {
        match parts.further.len() {
            0 => Self::with_size::<FURTHER>(parts, path, amplifier, layout),
            1 => Self::with_size::<{ FURTHER + 2 }>(parts, path, amplifier, layout),
            2 => Self::with_size::<{ FURTHER + 4 }>(parts, path, amplifier, layout),
            3 => Self::with_size::<{ FURTHER + 6 }>(parts, path, amplifier, layout),
            _ => Self::with_size::<{ FURTHER + 8 }>(parts, path, amplifier, layout),
        }
    }

    fn with_size<const N: usize>(parts: &Parts, path: Path, amplifier: &Amplifier, layout: &Layout) -> (Self, StepFlow) {
        let network: [Matrix<N>; 3] = path.series(parts, amplifier);
        let mut known: Vec<(f64, [Matrix<N>; COEFFICIENTS_COMPUTED])> = Vec::new();
        let mut over = |seconds: f64| match known.iter().find(|(time, _)| *time == seconds) {
            Some((_, series)) => *series,
            None => {
                let series = exponential_series(&network.map(|matrix| matrix.map(|row| row.map(|x| x * seconds))));
                known.push((seconds, series));
                series
            }
        };
        let mut flows: Vec<_> =
            (0..COEFFICIENTS).map(|degree| StepFlow::new(layout, &mut |seconds| over(seconds)[degree])).collect();
        let most = known.iter().map(|(_, series)| size(&series[COEFFICIENTS], parts)).fold(0.0, f64::max);
        let reach = (MAX_NEGLECTED_TERM / most).powf(1.0 / COEFFICIENTS as f64).min(MAX_RANGE_REL);
        let mut coefficients = [const { Vec::new() }; COEFFICIENTS];
        for (flow, coefficients) in flows.iter_mut().zip(&mut coefficients) {
            flow.each(|numbers| coefficients.extend_from_slice(numbers));
        }
        (Expansion { parts: parts.clone(), path, reach, coefficients }, flows.swap_remove(0))
    }

    /// Changes a flow of the same shape to that of `parts`. Returns `false` if that is outside the
    /// range of the series.
    pub fn lead(&self, parts: &Parts, flow: &mut StepFlow) -> bool {
        let Some((_, s)) = self.distance(parts).filter(|(path, s)| *path == self.path && s.abs() <= self.reach) else {
            return false;
        };
        let mut begin = 0;
        flow.each(|numbers| {
            let [a, b, c, d, e] = self.coefficients.each_ref().map(|degree| &degree[begin..begin + numbers.len()]);
            for (n, x) in numbers.iter_mut().enumerate() {
                *x = a[n] + s * (b[n] + s * (c[n] + s * (d[n] + s * e[n])));
            }
            begin += numbers.len();
        });
        true
    }

    /// Returns the path and distance from the network of the series to another; along its own path
    /// if they are the same.
    fn distance(&self, parts: &Parts) -> Option<(Path, f64)> {
        if self.parts == *parts { Some((self.path, 0.0)) } else { Path::between(&self.parts, parts) }
    }
}

/// Returns the largest entry of a matrix that maps states to states, with every state expressed as
/// a voltage: currents times the reactance of their branch, forces over the force factor.
fn size<const N: usize>(matrix: &Matrix<N>, parts: &Parts) -> f64 {
    let circuit = &parts.circuit;
    let volts = |index: usize| match index {
        I => (circuit.lm_h / circuit.cm_f).sqrt(),
        FORCE => 1.0 / circuit.force_factor_n_per_v,
        FURTHER.. if (index - FURTHER).is_multiple_of(2) => {
            let branch = &parts.further[(index - FURTHER) / 2];
            (branch.lm_h / branch.cm_f).sqrt()
        }
        _ => 1.0,
    };
    let entries = (0..N).flat_map(|row| (0..N).map(move |column| (row, column)));
    entries
        .filter(|(row, _)| ![DRIVE, FORCE].contains(row))
        .map(|(row, column)| matrix[row][column].abs() * volts(row) / volts(column))
        .fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::circuit::Branch;
    use crate::circuit::Circuit;
    use crate::timing::Timing;

    const A3: Circuit = Circuit { c0_f: 300e-9, cm_f: 20e-9, lm_h: 0.7916e-3, rm_ohm: 3.08, force_factor_n_per_v: 5.566 };

    fn layout(steps: u32, late_s: f64, further: usize) -> Layout {
        let timing = Timing { sample_s: 1e-6, steps, conversions: 2, skew_s: 30e-9 };
        Layout { timing, late_s, source_ohm: 0.3, further }
    }

    fn parts(further: usize) -> Parts {
        let further = (0..further).map(|k| Branch::new(41e3 + 3e3 * k as f64, 90.0, 4e-3)).collect();
        Parts { circuit: A3, leak_s: 1e-3, further }
    }

    /// Returns the elements at `s` along a path.
    fn along(path: Path, parts: &Parts, s: f64) -> Parts {
        let mut to = parts.clone();
        let circuit = parts.circuit;
        match path {
            Path::Resonance => to.circuit = circuit.with_series_resonance(circuit.series_resonance_hz() * (1.0 + s)),
            Path::Damping => to.circuit.rm_ohm *= 1.0 + s,
            Path::Clamped => to.circuit.c0_f /= 1.0 + s,
            Path::Further(k) => {
                let branch = parts.further[k];
                to.further[k] = branch.with_series_resonance(branch.series_resonance_hz() * (1.0 + s));
            }
        }
        to
    }

    /// Returns every number of a flow.
    fn numbers(flow: &mut StepFlow) -> Vec<f64> {
        let mut numbers = Vec::new();
        flow.each(|some| numbers.extend_from_slice(some));
        numbers
    }

    /// Within its range, on both sides, the series equals the exact flow in every number.
    #[test]
    fn the_series_is_exact_within_its_range() {
        let amplifier = Amplifier::default();
        let mut worst = 0.0f64;
        for (path, modes, steps, late_s) in [
            (Path::Resonance, 0, 1, 0.0),
            (Path::Resonance, 2, 3, 0.3e-6),
            (Path::Damping, 0, 1, 0.0),
            (Path::Clamped, 1, 2, 0.0),
            (Path::Further(1), 3, 1, 0.7e-6),
        ] {
            let (parts, layout) = (parts(modes), layout(steps, late_s, modes));
            let (expansion, mut flow) = Expansion::new(&parts, path, &amplifier, &layout);
            assert_eq!(numbers(&mut flow), numbers(&mut StepFlow::from_parts(&parts, &amplifier, &layout)), "{path:?}");
            for s in [-0.999 * expansion.reach, 0.37 * expansion.reach, 0.999 * expansion.reach] {
                let to = along(path, &parts, s);
                assert!(expansion.lead(&to, &mut flow), "{path:?} {s}");
                let (got, exact) = (numbers(&mut flow), numbers(&mut StepFlow::from_parts(&to, &amplifier, &layout)));
                for (got, exact) in got.iter().zip(&exact) {
                    worst = worst.max((got - exact).abs() / exact.abs().max(1e-3));
                }
            }
            println!("{path:?} with {modes} further modes: reach {:.1e}, worst so far {worst:.1e}", expansion.reach);
            let beyond = along(path, &parts, 1.01 * expansion.reach);
            assert!(!expansion.lead(&beyond, &mut flow), "{path:?}");
        }
        // Measured 2.8e-12, mostly the round-off of nine squarings in both.
        assert!(worst < 1e-11, "{worst:e}");
    }

    #[test]
    fn two_changes_at_once_have_no_path() {
        let from = parts(2);
        let path = |to: &Parts| Path::between(&from, to).map(|(path, _)| path);
        assert_eq!(path(&along(Path::Clamped, &along(Path::Resonance, &from, 1e-3), 1e-3)), None);
        assert_eq!(path(&along(Path::Further(0), &along(Path::Further(1), &from, 1e-3), 1e-3)), None);
        assert_eq!(path(&along(Path::Damping, &along(Path::Resonance, &from, 1e-3), 1e-3)), None);
        assert_eq!(path(&Parts { leak_s: 2e-3, ..from.clone() }), None);
        assert_eq!(path(&along(Path::Damping, &from, 1e-3)), Some(Path::Damping));
    }
}
