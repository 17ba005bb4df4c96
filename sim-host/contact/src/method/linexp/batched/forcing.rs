//! The forcing of eight contacts over a stretch: cosines of constant frequency for all, or straight
//! lines for all.

use std::f64::consts::TAU;

use fearless_simd::Simd;

use super::turn::sine_cosine;
use super::vector::{Vector, WIDTH, all, each};
use crate::forcing::{Forcing, INVERSE};

/// Forcings of one kind, one for each contact.
#[derive(Clone, Copy)]
pub(super) enum Forcings<S: Simd> {
    Cosine { size: Vector<S>, turns: Vector<S>, hz: Vector<S> },
    Line { value: Vector<S>, slope: Vector<S> },
}

impl<S: Simd> Forcings<S> {
    /// Combines the forcings, if they are of one kind.
    #[inline(always)]
    pub fn combine(simd: S, forcings: &[Forcing; WIDTH]) -> Option<Self> {
        let cosine = |forcing: &Forcing| match *forcing {
            Forcing::Cosine { size, turns, hz, hz_per_s: 0.0 } => Some([size, turns, hz]),
            _ => None,
        };
        let line = |forcing: &Forcing| match *forcing {
            Forcing::Line { value, slope } => Some([value, slope]),
            Forcing::Cosine { .. } => None,
        };
        if forcings.iter().all(|forcing| cosine(forcing).is_some()) {
            let of = |k: usize| each(simd, |number| cosine(&forcings[number]).map_or(0.0, |cosine| cosine[k]));
            return Some(Forcings::Cosine { size: of(0), turns: of(1), hz: of(2) });
        }
        let of = |k: usize| each(simd, |number| line(&forcings[number]).map_or(0.0, |line| line[k]));
        forcings.iter().all(|forcing| line(forcing).is_some()).then(|| Forcings::Line { value: of(0), slope: of(1) })
    }

    /// Returns the forcing of one contact.
    #[inline(always)]
    pub fn one(&self, number: usize) -> Forcing {
        match self {
            Forcings::Cosine { size, turns, hz } => {
                Forcing::Cosine { size: size[number], turns: turns[number], hz: hz[number], hz_per_s: 0.0 }
            }
            Forcings::Line { value, slope } => Forcing::Line { value: value[number], slope: slope[number] },
        }
    }

    /// Batched [`Oscillator::forcing`](crate::method::oscillator::Oscillator::forcing).
    #[inline(always)]
    pub fn taylor_in<const N: usize>(&self, s: Vector<S>, unit: Vector<S>, per_mass: Vector<S>) -> [Vector<S>; N] {
        let mut out = [all(s.simd, 0.0); N];
        match *self {
            Forcings::Cosine { size, turns, hz } => {
                let omega = hz * TAU * unit;
                let (sine, cosine) = sine_cosine(turns + s * hz);
                let (mut y, mut z) = (size * cosine, size * sine);
                for (coefficient, over) in out.iter_mut().zip(INVERSE) {
                    *coefficient = y;
                    let by = omega * over;
                    (y, z) = (-by * z, by * y);
                }
            }
            Forcings::Line { value, slope } => {
                out[0] = value + slope * s;
                out[1] = slope * unit;
            }
        }
        for c in &mut out {
            *c *= per_mass;
        }
        out
    }
}
