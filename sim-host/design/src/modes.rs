//! Modes of a chain with free ends: resonances, losses and equivalent circuit.
//!
//! ```text
//! Y = j w C0 + sum of j w / (Lm (wr^2 - w^2 + j w wr / Q))
//! ```
//!
//! The resonances without losses are found by counting. With losses, each is a complex zero of the
//! tension at the tip, `w = wd + j a`, with `wr = |w|` and `Q = wr / 2 a`; the branch follows from
//! the residue of the admittance there.

use std::f64::consts::TAU;

use crate::build::Parts;
use crate::part::{chain, crossings};
use crate::port::{C, Port, State};

/// Relative width at which the bisection for a resonance ends.
const RESOLUTION_REL: f64 = 1e-14;
/// Largest number of steps for a complex resonance.
const MAX_STEPS: usize = 60;
/// Largest quality factor that differs from infinity.
const LARGEST_Q: f64 = 1e9;
/// Largest ratio of a parallel to a series resonance.
const SEARCH_RANGE: f64 = 20.0;
/// Number of modes above a resonance among which the next driven one is.
const SEARCH_MODES: usize = 12;
/// Points of the contour around a resonance.
const CONTOUR_POINTS: usize = 16;
/// Radius of the contour, relative to the half width of the resonance.
const CONTOUR_REL: f64 = 0.3;

/// A mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode {
    /// Number of the mode, from zero; a rigid motion counts.
    pub number: usize,
    /// Series resonance without losses, Hz: the electrodes are shorted.
    pub series_resonance_hz: f64,
    /// Parallel resonance without losses, Hz: the lowest one above, with open electrodes.
    pub parallel_resonance_hz: Option<f64>,
    /// Quality factor; infinite if nothing takes energy.
    pub q: f64,
    /// Branch of the equivalent circuit.
    pub branch: Option<Branch>,
    /// Angular frequency with losses, 1/s.
    pub(crate) omega: C,
}

/// Branch of a mode in the equivalent circuit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Branch {
    /// Motional inductance, H.
    pub lm_h: f64,
    /// Motional capacitance, F.
    pub cm_f: f64,
    /// Motional resistance, ohm.
    pub rm_ohm: f64,
    /// Force factor at the tip, N/V, or A per m/s.
    pub force_factor_n_per_v: f64,
}

impl Mode {
    /// Returns the angular frequency of the series resonance with losses, 1/s.
    pub(crate) fn resonance(&self) -> f64 {
        self.omega.norm()
    }

    /// Returns the admittance of the mode's branch at a real angular frequency, S.
    pub(crate) fn admittance(&self, w: f64) -> C {
        let Some(branch) = self.branch else { return C::default() };
        C::new(branch.rm_ohm, w * branch.lm_h - 1.0 / (w * branch.cm_f)).inv()
    }
}

/// Returns the angular frequency of a frequency.
pub(crate) fn angular(hz: f64) -> C {
    C::new(TAU * hz, 0.0)
}

/// Returns displacement at the back per volt, and admittance, of a chain with free ends.
pub(crate) fn driven(port: &Port, w: C) -> (C, C) {
    let back = -port.m[1][2] / port.m[1][0];
    (back, C::i() * w * (port.q[0] * back + port.q[2]))
}

/// Returns the number of modes below a frequency, with shorted electrodes.
fn short_below(parts: &Parts, hz: f64) -> usize {
    let (below, tip) = crossings(parts, angular(hz), State::FREE);
    below + usize::from(tip.f.re * tip.u.re < 0.0)
}

/// Returns `true` if a chain is inductive at a frequency.
fn is_inductive(parts: &Parts, hz: f64) -> bool {
    let w = angular(hz);
    (driven(&chain(parts, w), w).1 / (C::i() * w)).re < 0.0
}

/// Returns the frequency at which a count exceeds a number, in a range, Hz.
fn rises(above: usize, (mut low, mut high): (f64, f64), count: impl Fn(f64) -> usize) -> f64 {
    while high - low > RESOLUTION_REL * high {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if count(middle) > above { high = middle } else { low = middle }
    }
    high
}

/// Returns the series resonances in a range, with their numbers.
pub(crate) fn resonances(parts: &Parts, (low, high): (f64, f64)) -> Vec<(usize, f64)> {
    let numbers = short_below(parts, low)..short_below(parts, high);
    let mut from = low;
    numbers
        .map(|number| {
            let hz = rises(number, (from, high), |hz| short_below(parts, hz));
            from = (hz * (1.0 - 1e-12)).max(low);
            (number, hz)
        })
        .collect()
}

/// Returns the series resonance with a number, if it is below a frequency, Hz.
pub(crate) fn resonance(parts: &Parts, number: usize, highest: f64) -> Option<f64> {
    let found = rises(number, (0.0, highest), |hz| short_below(parts, hz));
    (short_below(parts, highest) > number).then_some(found)
}

/// Returns the mode of a series resonance.
pub(crate) fn mode(lossy: &Parts, (number, hz): (usize, f64), is_driven: bool) -> Mode {
    let omega = pole(lossy, hz);
    let q = omega.norm() / (2.0 * omega.im);
    let q = if q > 0.0 && q < LARGEST_Q { q } else { f64::INFINITY };
    let branch = is_driven.then(|| branch(lossy, omega)).flatten();
    Mode { number, series_resonance_hz: hz, parallel_resonance_hz: None, q, branch, omega }
}

/// Returns the parallel resonance above the series resonance of a driven mode, Hz.
///
/// Between two driven modes the susceptance rises from below to above zero (Foster's theorem). A
/// mode that the rings do not excite does not end the range.
pub(crate) fn parallel_resonance(parts: &Parts, mode: &Mode) -> Option<f64> {
    let (low, highest) = (mode.series_resonance_hz, SEARCH_RANGE * mode.series_resonance_hz);
    let next = (1..=SEARCH_MODES).map(|more| rises(mode.number + more, (low, highest), |hz| short_below(parts, hz)));
    let high = next.into_iter().find(|next| !is_inductive(parts, next * (1.0 - 1e-9)))?;
    Some(rises(0, (low * (1.0 + 1e-13), high * (1.0 - 1e-9)), |hz| usize::from(!is_inductive(parts, hz))))
}

/// Returns the complex angular frequency of a mode near a frequency, by the secant method.
fn pole(parts: &Parts, hz: f64) -> C {
    let tension = |w: C| chain(parts, w).m[1][0];
    let (mut last, mut w) = (angular(hz), angular(hz) * C::new(1.0, 1e-4));
    let (mut at_last, mut at) = (tension(last), tension(w));
    for _ in 0..MAX_STEPS {
        let step = at * (w - last) / (at - at_last);
        if !step.is_finite() || step.norm() < 1e-15 * w.norm() {
            break;
        }
        (last, at_last) = (w, at);
        w -= step;
        at = tension(w);
    }
    w
}

/// Returns the branch of a mode. `None` if the electrodes do not excite it.
fn branch(parts: &Parts, omega: C) -> Option<Branch> {
    let port = chain(parts, omega);
    let (tip, charge) = port.apply(State::FREE, C::default());
    let force_factor = charge / tip.u;
    let radius = CONTOUR_REL * omega.im;
    let points = (0..CONTOUR_POINTS).map(|point| {
        let away = C::from_polar(radius, TAU * point as f64 / CONTOUR_POINTS as f64);
        driven(&chain(parts, omega + away), omega + away).1 * away
    });
    let residue = points.sum::<C>() / CONTOUR_POINTS as f64;
    let inductance = -C::i() * omega / (residue * (2.0 * omega.re));
    let lm_h = inductance.re;
    (lm_h.is_finite() && lm_h > 0.0).then(|| Branch {
        lm_h,
        cm_f: 1.0 / (omega.norm_sqr() * lm_h),
        rm_ohm: 2.0 * omega.im * lm_h,
        force_factor_n_per_v: force_factor.re.abs(),
    })
}
