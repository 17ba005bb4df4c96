//! A flow that follows the changing elements of its network, as a Taylor series about the network
//! for which it was computed.
//!
//! Elements drift: by temperature, amplitude, load. Each entry of the network's matrix that changes
//! is a product of `1 + s`, one `s` for each of the [`Change`]s, so its exponential has a series in
//! the `s` that converges for any change. The coefficients up to the fourth degree, the third with
//! more than two changes, are exact ([`exponential_series`]). The next power of each `s` sets the
//! range: up to where these terms together are `MAX_NEGLECTED_TERM`; mixed terms of four changes
//! can be 35 times as large. Outside that range a new series is computed.

mod change;

pub use change::{ALL, Change};

use std::sync::OnceLock;

use crate::network::{DRIVE, FORCE, FURTHER, I, V0, VC, network};
use crate::parts::Parts;
use crate::step_flow::{Layout, StepFlow};
use contact::flow::{Matrix, Monomials, exponential_series};
use scene::Amplifier;

/// Largest first neglected term, for a flow with voltages of order one: near the round-off of the
/// exponential itself.
const MAX_NEGLECTED_TERM: f64 = 1e-15;
/// Largest range of a series, relative change.
const MAX_RANGE_REL: f64 = 0.1;

/// The series of a flow in some changes.
#[derive(Clone, Debug)]
pub struct Expansion {
    parts: Parts,
    changes: Vec<Change>,
    monomials: &'static Monomials,
    /// For each change the inverse of its range alone.
    per_range: Vec<f64>,
    /// The numbers of the flow in order, in chunks that fit in registers: for each chunk its
    /// coefficients by monomial, highest degree first.
    coefficients: Vec<Vec<[f64; CHUNK]>>,
    /// The monomials at the present changes.
    values: Vec<f64>,
    /// The numbers of the present flow.
    numbers: Vec<[f64; CHUNK]>,
}

/// Size of the network with four further modes; that of one with fewer ends earlier.
const MOST: usize = FURTHER + 8;
/// Numbers that are evaluated together.
const CHUNK: usize = 8;

/// Returns the degree of the series in a number of changes, and its monomials with one more power
/// of each change for the bound.
fn monomials(changes: usize) -> (u32, &'static Monomials) {
    static OF: [OnceLock<Monomials>; ALL.len() + 1] = [const { OnceLock::new() }; ALL.len() + 1];
    let degree = if changes <= 2 { 4 } else { 3 };
    (degree, OF[changes].get_or_init(|| Monomials::new(changes, degree)))
}

impl Expansion {
    /// Creates the series of the flow of `parts` in `changes`, none or some, and the flow itself.
    pub fn new(parts: &Parts, changes: &[Change], amplifier: &Amplifier, layout: &Layout) -> (Self, StepFlow) {
        let (degree, monomials) = monomials(changes.len());
        let network = polynomial(&network(parts, amplifier), changes, monomials);
        let size = FURTHER + 2 * parts.further.len();
        let mut known: Vec<(f64, Vec<Matrix<MOST>>)> = Vec::new();
        let mut over = |seconds: f64, place: usize| {
            let at = known.iter().position(|(time, _)| *time == seconds).unwrap_or_else(|| {
                let network: Vec<_> = network.iter().map(|matrix| matrix.map(|row| row.map(|x| x * seconds))).collect();
                known.push((seconds, exponential_series(&network, size, monomials)));
                known.len() - 1
            });
            known[at].1[place]
        };
        let used = monomials.exponents().iter().take_while(|of| of.iter().sum::<u32>() <= degree).count();
        let mut flows: Vec<_> = (0..used).map(|place| StepFlow::new(layout, &mut |seconds| over(seconds, place))).collect();
        let mut per_range = vec![0.0; changes.len()];
        for (place, exponents) in monomials.exponents().iter().enumerate().skip(used) {
            let most = known.iter().map(|(_, series)| largest(&series[place], parts)).fold(0.0, f64::max);
            let per = (most / MAX_NEGLECTED_TERM).powf(1.0 / f64::from(degree + 1)).max(1.0 / MAX_RANGE_REL);
            per_range.iter_mut().zip(exponents).filter(|(_, exponent)| **exponent > 0).for_each(|(to, _)| *to = per);
        }
        let mut coefficients = Vec::new();
        for (done, flow) in flows.iter_mut().rev().enumerate() {
            let mut number = 0;
            flow.each(|some| {
                for x in some {
                    let chunk = number / CHUNK;
                    if chunk == coefficients.len() {
                        coefficients.push(vec![[0.0; CHUNK]; used]);
                    }
                    coefficients[chunk][done][number % CHUNK] = *x;
                    number += 1;
                }
            });
        }
        let (values, numbers) = (Vec::new(), vec![[0.0; CHUNK]; coefficients.len()]);
        let (parts, changes) = (parts.clone(), changes.to_vec());
        (Expansion { parts, changes, monomials, per_range, coefficients, values, numbers }, flows.swap_remove(0))
    }

    /// Changes a flow of the same shape to that of `parts`. Returns `false` if that is outside the
    /// range of the series.
    pub fn lead(&mut self, parts: &Parts, flow: &mut StepFlow) -> bool {
        let Some(all) = Change::between(&self.parts, parts) else {
            return false;
        };
        let (mut changes, mut ranges) = ([0.0; ALL.len()], 0.0);
        for (s, change) in all.into_iter().zip(ALL) {
            match self.changes.iter().position(|own| *own == change) {
                Some(place) => {
                    changes[place] = s;
                    ranges += s.abs() * self.per_range[place];
                }
                None if change.is_more_than_round_off(s) => return false,
                None => {}
            }
        }
        if ranges.is_nan() || ranges > 1.0 {
            return false;
        }
        self.monomials.evaluate(&changes, &mut self.values);
        for (numbers, coefficients) in self.numbers.iter_mut().zip(&self.coefficients) {
            // The smallest terms first.
            let terms = coefficients.iter().zip(self.values[..coefficients.len()].iter().rev());
            *numbers = terms.fold([0.0; CHUNK], |mut sum, (coefficients, value)| {
                sum.iter_mut().zip(coefficients).for_each(|(x, coefficient)| *x += coefficient * value);
                sum
            });
        }
        let mut numbers = self.numbers.as_flattened().iter();
        flow.each(|some| some.iter_mut().zip(&mut numbers).for_each(|(to, x)| *to = *x));
        // Friction enters as the voltage `F / phi`.
        let factor = self.parts.circuit.force_factor_n_per_v / parts.circuit.force_factor_n_per_v;
        if factor != 1.0 {
            flow.scale_force(factor);
        }
        true
    }

    /// Returns the cost of a series in a number of changes, in exact flows.
    pub fn cost(changes: usize) -> usize {
        // Measured for one to five changes: 11, 27, 38, 75 and 140 (computed: 10 to 155).
        monomials(changes).1.products() / 2
    }
}

/// Returns a network as a polynomial: each entry that changes is a product of `1 + s`.
fn polynomial(still: &Matrix<MOST>, changes: &[Change], monomials: &Monomials) -> Vec<Matrix<MOST>> {
    let mut polynomial = vec![[[0.0; MOST]; MOST]; monomials.exponents().len()];
    polynomial[0] = *still;
    let mut entry = |row: usize, column: usize, factors: &[Change]| {
        let places: Vec<usize> = factors.iter().filter_map(|of| changes.iter().position(|change| change == of)).collect();
        // Every choice of `s` or 1 from each factor, except 1 from all.
        for choice in 1..1u32 << places.len() {
            let mut exponents = vec![0; changes.len()];
            places.iter().enumerate().filter(|(bit, _)| choice >> bit & 1 == 1).for_each(|(_, place)| exponents[*place] += 1);
            if let Some(place) = monomials.place(&exponents) {
                polynomial[place][row][column] += still[row][column];
            }
        }
    };
    (0..MOST).for_each(|column| entry(V0, column, &[Change::Clamped]));
    [V0, VC, FORCE].into_iter().for_each(|column| entry(I, column, &[Change::Inductance]));
    entry(VC, I, &[Change::Resonance; 2]);
    entry(I, I, &[Change::Resonance, Change::Damping]);
    for (k, i) in (FURTHER..MOST).step_by(2).enumerate() {
        entry(i + 1, i, &[Change::Further(k); 2]);
        entry(i, i, &[Change::Further(k)]);
    }
    polynomial
}

/// Returns the largest entry of a matrix that maps states to states, with every state expressed as
/// a voltage: currents times the reactance of their branch, forces over the force factor.
fn largest(matrix: &Matrix<MOST>, parts: &Parts) -> f64 {
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
    let size = FURTHER + 2 * parts.further.len();
    let entries = (0..size).flat_map(|row| (0..size).map(move |column| (row, column)));
    entries
        .filter(|(row, _)| ![DRIVE, FORCE].contains(row))
        .map(|(row, column)| matrix[row][column].abs() * volts(row) / volts(column))
        .fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::change::tests::{parts, with};
    use super::*;
    use crate::timing::Timing;

    fn layout(steps: u32, late_s: f64, further: usize) -> Layout {
        let timing = Timing { sample_s: 1e-6, steps, conversions: 2, skew_s: 30e-9 };
        Layout { timing, late_s, source_ohm: 0.3, further }
    }

    /// Returns every number of a flow.
    fn numbers(flow: &mut StepFlow) -> Vec<f64> {
        let mut numbers = Vec::new();
        flow.each(|some| numbers.extend_from_slice(some));
        numbers
    }

    /// Within its range, on both sides and with several changes at once, the series equals the
    /// exact flow in every number.
    #[test]
    fn the_series_is_exact_within_its_range() {
        const TEMPERATURE: [Change; 4] = [Change::Clamped, Change::Inductance, Change::Resonance, Change::Damping];
        let amplifier = Amplifier::default();
        let mut worst = 0.0f64;
        for (changes, modes, steps, late_s) in [
            (&[Change::Resonance][..], 0, 1, 0.0),
            (&[Change::Resonance], 2, 3, 0.3e-6),
            (&[Change::Damping], 0, 1, 0.0),
            (&[Change::Clamped], 1, 2, 0.0),
            (&[Change::Further(1)], 3, 1, 0.7e-6),
            (&[Change::Resonance, Change::Damping], 0, 1, 0.0),
            (&[Change::Clamped, Change::Resonance, Change::Further(0)], 1, 2, 0.0),
            (&TEMPERATURE, 0, 1, 0.0),
            (&TEMPERATURE, 2, 2, 0.3e-6),
        ] {
            let (parts, layout) = (parts(modes), layout(steps, late_s, modes));
            let (mut expansion, mut flow) = Expansion::new(&parts, changes, &amplifier, &layout);
            assert_eq!(numbers(&mut flow), numbers(&mut Expansion::new(&parts, &[], &amplifier, &layout).1), "{changes:?}");
            let per_range = expansion.per_range.clone();
            let after = |sizes: &dyn Fn(usize) -> f64| {
                let sized = changes.iter().zip(&per_range).enumerate();
                sized.fold(parts.clone(), |to, (n, (change, per_range))| with(*change, &to, sizes(n) / per_range))
            };
            let number = changes.len() as f64;
            let equal = |sign: f64| move |n: usize| if n.is_multiple_of(2) { 0.999 / number } else { sign * 0.999 / number };
            let mut all: Vec<Parts> = [1.0, -1.0].map(|sign| after(&equal(sign))).into();
            all.extend(
                (0..changes.len())
                    .flat_map(|one| [-0.999, 0.37, 0.999].map(|size| after(&|n| if n == one { size } else { 0.0 }))),
            );
            for to in &all {
                assert!(expansion.lead(to, &mut flow), "{changes:?} {to:?}");
                let (got, exact) = (numbers(&mut flow), numbers(&mut Expansion::new(to, &[], &amplifier, &layout).1));
                for (got, exact) in got.iter().zip(&exact) {
                    worst = worst.max((got - exact).abs() / exact.abs().max(1e-3));
                }
            }
            let ranges: Vec<String> = per_range.iter().map(|per_range| format!("{:.1e}", 1.0 / per_range)).collect();
            println!("{changes:?} with {modes} further modes: ranges {ranges:?}, worst so far {worst:.1e}");
            let beyond = after(&|n| if n + 1 == changes.len() { 1.01 } else { 0.0 });
            assert!(!expansion.lead(&beyond, &mut flow), "{changes:?}");
            let other = with(Change::Damping, &with(Change::Clamped, &parts, 1e-6), 1e-6);
            assert_eq!(expansion.lead(&other, &mut flow), changes == TEMPERATURE, "{changes:?}");
        }
        // Measured 5.2e-12, mostly the round-off of nine squarings in both.
        assert!(worst < 1e-11, "{worst:e}");
    }
}
