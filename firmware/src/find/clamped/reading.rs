//! What the fitted elements say of the transducer, and how far each may be off.

use crate::find::clamped::fit::Solution;
use crate::find::clamped::model::{self, C, D, D2, Elements, G, H, K, K2, THETA, UNKNOWNS, X2, XS, turn};
use crate::seam::phasor::Phasor;
use crate::sense::motional::Motional;

const TAU: f32 = core::f32::consts::TAU;

/// A value and its standard deviation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// The estimated value.
    pub value: f32,
    /// Its standard deviation.
    pub(crate) deviation: f32,
}

/// Measurements of the tones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clamped {
    /// The clamped branch and the axis, for tracking.
    pub motional: Motional,
    /// Clamped capacitance as the converters see it, F.
    pub c0_f: Measured,
    /// What sensing turns the motional admittance by, rad: the axis.
    pub(crate) turn_rad: Measured,
    /// Motional inductance of the transducer, H.
    pub lm_h: Measured,
    /// Series resonance of the transducer, Hz.
    pub resonance_hz: Measured,
    /// Quality factor of the resonance.
    pub q: Measured,
    /// Standard deviation of the lock point that follows from [`Clamped::motional`], Hz.
    pub lock_deviation_hz: f32,
    /// Rms of what the model leaves, in standard deviations: about one.
    pub(crate) misfit: f32,
    /// A second resonance, Hz, and its strength relative to the first.
    pub second_mode: Option<(f32, f32)>,
}

/// Elements whose deviations are read; after them comes that of the lock point.
const READ: [usize; 5] = [C, THETA, K, XS, D];
/// How many of elements a block has time for.
const A_BLOCK: usize = 2;

/// Deviations of a solution's elements, a block's worth at a time.
#[derive(Clone, Debug, Default)]
pub(crate) struct Deviations {
    elements: [f32; READ.len()],
    /// Of the motional phase at the lock point, rad.
    turn: f32,
    next: usize,
}

impl Deviations {
    /// Forgets them.
    pub(crate) fn restart(&mut self) {
        self.next = 0;
    }

    /// Reads the next ones, unless all have been read. Returns whether they had.
    pub(crate) fn read_on(&mut self, solution: &Solution) -> bool {
        let rest = READ.iter().zip(&mut self.elements).skip(self.next).take(A_BLOCK);
        match rest.len() {
            0 if self.next > READ.len() => return true,
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

    fn of(&self, element: usize) -> f32 {
        READ.iter().zip(self.elements).find(|(n, _)| **n == element).map_or(0.0, |(_, deviation)| deviation)
    }
}

/// The clamped branch of elements at their resonance, relative to the nominal susceptance, and what errors of the elements change it by.
fn branch(e: &Elements) -> (Phasor, [Phasor; UNKNOWNS]) {
    // Without its motional branch.
    let mut clamped = *e;
    clamped[K] = 0.0;
    model::admittance(&clamped, e[XS])
}

/// What an error of each element turns the motional phase by: that of Y0 against the motional conductance, and that of the axis.
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

/// What a solution says of a transducer with this nominal frequency, Hz, and capacitance, F.
pub(crate) fn read(solution: &Solution, deviations: &Deviations, nominal_hz: f32, nominal_c0_f: f32) -> Clamped {
    let e = &solution.elements;
    let us = 1.0 + e[XS];
    let of = |n: usize, scale: f32| deviations.of(n) * scale;
    let axis = turn(e[THETA] * us);
    let y0 = branch(e).0 * (TAU * nominal_hz * nominal_c0_f);
    let lm_h = 1.0 / (TAU * TAU * nominal_hz * nominal_hz * e[K] * nominal_c0_f);
    let hz = nominal_hz * us;
    Clamped {
        motional: Motional { y0: Phasor::new(y0.re, y0.im / us), axis },
        c0_f: Measured { value: e[C] * nominal_c0_f, deviation: of(C, nominal_c0_f) },
        turn_rad: Measured { value: e[THETA] * us, deviation: of(THETA, us) },
        lm_h: Measured { value: lm_h, deviation: of(K, lm_h / e[K]) },
        resonance_hz: Measured { value: hz, deviation: of(XS, nominal_hz) },
        q: Measured { value: 1.0 / e[D], deviation: of(D, 1.0 / (e[D] * e[D])) },
        lock_deviation_hz: 0.5 * hz * e[D] * deviations.turn,
        misfit: solution.misfit,
        second_mode: (e[K2] != 0.0).then(|| (nominal_hz * (1.0 + e[X2]), e[K2] / e[K])),
    }
}
