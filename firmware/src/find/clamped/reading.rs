//! Properties of the transducer from the fitted elements, with standard deviations.

use crate::find::clamped::fit::Solution;
use crate::find::clamped::model::{self, C, D, D2, Elements, G, H, K, K2, THETA, UNKNOWNS, X2, XS, turn};
use crate::seam::phasor::{Phasor, magnitude};
use crate::seam::transducer::LockQuality;
use crate::sense::motional::Motional;

const TAU: f32 = core::f32::consts::TAU;

/// A value and its standard deviation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// Estimated value.
    pub value: f32,
    /// Standard deviation of the value.
    pub(crate) deviation: f32,
}

/// Clamped branch and transducer as measured by the tones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clamped {
    /// Clamped branch and motional axis, for tracking.
    pub motional: Motional,
    /// Clamped capacitance as measured by the converters, F.
    pub c0_f: Measured,
    /// Rotation of the motional admittance by the sensing chain, rad; the angle of the axis.
    pub(crate) turn_rad: Measured,
    /// Motional inductance of the transducer, H.
    pub lm_h: Measured,
    /// Series resonance frequency of the transducer, Hz.
    pub resonance_hz: Measured,
    /// Quality factor of the resonance.
    pub q: Measured,
    /// Standard deviation of the lock point that follows from [`Clamped::motional`], Hz.
    pub lock_deviation_hz: f32,
    /// Quality of a lock with this branch.
    pub quality: LockQuality,
    /// Frequency of a second resonance, Hz, and its strength relative to the first.
    pub second_mode: Option<(f32, f32)>,
}

/// Elements whose deviations are computed; the lock point follows after them.
const READ_ELEMENTS: [usize; 5] = [C, THETA, K, XS, D];
/// Number of elements per block.
const ELEMENTS_PER_BLOCK: usize = 2;

/// Standard deviations of the elements of a solution, computed over several blocks.
#[derive(Clone, Debug, Default)]
pub(crate) struct Deviations {
    elements: [f32; READ_ELEMENTS.len()],
    /// Standard deviation of the motional phase at the lock point, rad.
    turn: f32,
    next: usize,
}

impl Deviations {
    /// Starts again.
    pub(crate) fn restart(&mut self) {
        self.next = 0;
    }

    /// Computes the next deviations. Returns `true` if all were complete before the call.
    pub(crate) fn advance(&mut self, solution: &Solution) -> bool {
        let rest = READ_ELEMENTS.iter().zip(&mut self.elements).skip(self.next).take(ELEMENTS_PER_BLOCK);
        match rest.len() {
            0 if self.next > READ_ELEMENTS.len() => return true,
            0 => {
                self.turn = solution.deviation(&turns(&solution.elements));
                self.next += 1;
            }
            read => {
                for (&n, deviation) in rest {
                    *deviation = solution.deviation(&core::array::from_fn(|k| if k == n { 1.0 } else { 0.0 }));
                }
                self.next += read;
            }
        }
        false
    }

    fn get(&self, element: usize) -> f32 {
        READ_ELEMENTS.iter().zip(self.elements).find(|(n, _)| **n == element).map_or(0.0, |(_, deviation)| deviation)
    }
}

/// Computes the clamped branch at the resonance, relative to the nominal susceptance, and its
/// derivatives by the elements.
fn branch(e: &Elements) -> (Phasor, [Phasor; UNKNOWNS]) {
    // Removes the motional branch.
    let mut clamped = *e;
    clamped[K] = 0.0;
    model::admittance(&clamped, e[XS])
}

/// Computes the rotation of the motional phase per error of each element, through `Y0` (relative to
/// the motional conductance) and through the axis.
fn turns(e: &Elements) -> [f32; UNKNOWNS] {
    let us = 1.0 + e[XS];
    let (axis, (_, by)) = (turn(e[THETA] * us), branch(e));
    let conductance = e[K] / (e[D] * us);
    let mut turns: [f32; UNKNOWNS] = core::array::from_fn(|n| match n {
        C | G | H | THETA | K2 | X2 | D2 => (by[n] * axis.conj()).im / conductance,
        _ => 0.0,
    });
    turns[THETA] += us;
    turns
}

/// Derives the transducer from a solution, with the nominal frequency, Hz, and the reference
/// capacitance, F.
pub(crate) fn read(solution: &Solution, deviations: &Deviations, nominal_hz: f32, nominal_c0_f: f32) -> Clamped {
    let e = &solution.elements;
    let us = 1.0 + e[XS];
    let of = |n: usize, scale: f32| deviations.get(n) * scale;
    let axis = turn(e[THETA] * us);
    let y0 = branch(e).0 * (TAU * nominal_hz * nominal_c0_f);
    let lm_h = 1.0 / (TAU * TAU * nominal_hz * nominal_hz * e[K] * nominal_c0_f);
    let hz = nominal_hz * us;
    let apart = || magnitude(Phasor::new(2.0 * (e[X2] - e[XS]), e[D2]));
    let others = if e[K2] != 0.0 { e[K2] / e[K] * e[D] / apart() } else { 0.0 };
    Clamped {
        motional: Motional { y0: Phasor::new(y0.re, y0.im / us), axis },
        c0_f: Measured { value: e[C] * nominal_c0_f, deviation: of(C, nominal_c0_f) },
        turn_rad: Measured { value: e[THETA] * us, deviation: of(THETA, us) },
        lm_h: Measured { value: lm_h, deviation: of(K, lm_h / e[K]) },
        resonance_hz: Measured { value: hz, deviation: of(XS, nominal_hz) },
        q: Measured { value: 1.0 / e[D], deviation: of(D, 1.0 / (e[D] * e[D])) },
        lock_deviation_hz: 0.5 * hz * e[D] * deviations.turn,
        // Two standard deviations.
        quality: LockQuality::new(2.0 * deviations.turn, others, solution.misfit),
        second_mode: (e[K2] != 0.0).then(|| (nominal_hz * (1.0 + e[X2]), e[K2] / e[K])),
    }
}
