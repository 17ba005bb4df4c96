//! Steady friction of a vibration velocity that consists of straight lines: square, sawtooth,
//! triangle.
//!
//! Over a piece without a reversal the slip z keeps its direction (sign s). The speed goes from
//! |v0| to |v1| within the phase T, and
//!
//! ```text
//! f = s + (f0 - s) exp(-kappa z),        z = |v0| u + (|v1| - |v0|) u^2 / (2 T)
//! integral of f V = s (z + ...) ,        elementary:  integral of exp(-kappa z) dz = (1 - e^(-kappa Z)) / kappa
//! integral of f   = s T + (f0 - s) I,    I = T (1 - e^(-kappa Z)) / (kappa Z) at constant speed, an error function otherwise
//! ```
//!
//! A period maps f to `alpha f + beta`, so the steady state is `beta / (1 - alpha)`. According to
//! Dahl's law, friction does not change at rest (V = 0). Coulomb friction is the limit of infinite
//! kappa, with the same behaviour.

use std::f64::consts::TAU;

use super::super::tally::Ratios;
use super::super::waveform::Shape;
use super::stroke::CUT_EXPONENT;
use super::{CONSTANT_FRICTION_KAPPA, gauss};

/// Stretch of slip in one direction; velocities over Vv, phase in rad.
#[derive(Clone, Copy, Debug)]
struct Piece {
    v0: f64,
    v1: f64,
    phase: f64,
    sign: f64,
}

/// Steady period.
#[derive(Clone, Debug)]
pub(super) struct Lines {
    kappa: f64,
    xi: f64,
    pieces: Vec<Piece>,
    /// Friction over Fc at the beginning of each piece.
    begins: Vec<f64>,
}

/// Returns, for each straight stretch, the vibration velocity over Vv at its beginning and end, and
/// its fraction of a period.
fn stretches(shape: Shape) -> Option<&'static [(f64, f64, f64)]> {
    match shape {
        Shape::Square => Some(&[(1.0, 1.0, 0.5), (-1.0, -1.0, 0.5)]),
        Shape::Sawtooth => Some(&[(-1.0, 1.0, 1.0)]),
        Shape::Triangle => Some(&[(-1.0, 1.0, 0.5), (1.0, -1.0, 0.5)]),
        _ => None,
    }
}

impl Lines {
    /// Computes the steady state of `V = xi + factor w(p)`; `None` if the shape does not consist of
    /// lines.
    pub(super) fn new(shape: Shape, factor: f64, xi: f64, kappa: f64) -> Option<Self> {
        let mut pieces = Vec::new();
        for &(from, to, part) in stretches(shape)? {
            let (v0, v1, phase) = (xi + factor * from, xi + factor * to, TAU * part);
            if v0 * v1 < 0.0 {
                let first = phase * v0 / (v0 - v1);
                pieces.push(Piece { v0, v1: 0.0, phase: first, sign: v0.signum() });
                pieces.push(Piece { v0: 0.0, v1, phase: phase - first, sign: v1.signum() });
            } else {
                let sign = if v0 + v1 == 0.0 { 0.0 } else { (v0 + v1).signum() };
                pieces.push(Piece { v0, v1, phase, sign });
            }
        }
        let slip: f64 = pieces.iter().map(Piece::slip).sum();
        let mut force = if kappa < CONSTANT_FRICTION_KAPPA {
            pieces.iter().map(|piece| piece.sign * piece.slip()).sum::<f64>() / slip
        } else {
            let beta = pieces.iter().fold(0.0, |force, piece| piece.after(force, kappa));
            beta / -(-kappa * slip).exp_m1()
        };
        let mut begins = Vec::new();
        for piece in &pieces {
            begins.push(force);
            force = piece.after(force, kappa);
        }
        Some(Lines { kappa, xi, pieces, begins })
    }

    /// Returns the fraction of a difference in friction that remains after one period.
    pub(super) fn forget(&self) -> f64 {
        (-self.kappa * self.pieces.iter().map(Piece::slip).sum::<f64>()).exp()
    }

    /// Returns the ratios; `factor` is the sign of the vibration in the slip.
    pub(super) fn ratios(&self, factor: f64) -> Ratios {
        let (mut friction, mut power, mut moving) = (0.0, 0.0, 0.0);
        for (piece, begin) in self.pieces.iter().zip(&self.begins) {
            let off = begin - piece.sign;
            let (held, held_moving) = piece.integrals(self.kappa, self.xi);
            friction += piece.sign * piece.phase + off * held;
            power += piece.slip() + piece.sign * off * piece.relaxed(self.kappa);
            moving += piece.sign * piece.phase * (0.5 * (piece.v0 + piece.v1) - self.xi) + off * held_moving;
        }
        let friction = friction / TAU;
        if self.xi == 0.0 {
            return Ratios { friction, ..Ratios::default() };
        }
        let (power, input) = (power / (TAU * self.xi), factor * moving / (TAU * self.xi));
        Ratios {
            friction,
            power: Some(power),
            input: Some(input),
            stored: Some(0.0),
            damping: Some(0.0),
            energy_residual: Some(power - friction - factor * input),
            ..Ratios::default()
        }
    }

    /// Returns F / Fc at a phase, in turns since the beginning of the period.
    pub(super) fn force(&self, phase_turns: f64) -> f64 {
        let mut left = TAU * (phase_turns - phase_turns.floor());
        for (piece, begin) in self.pieces.iter().zip(&self.begins) {
            if left < piece.phase {
                let slip = piece.slip_at(left);
                let decay = if slip == 0.0 { 1.0 } else { (-self.kappa * slip).exp() };
                return piece.sign + (begin - piece.sign) * decay;
            }
            left -= piece.phase;
        }
        self.begins.first().copied().unwrap_or(0.0)
    }
}

impl Piece {
    fn slip(&self) -> f64 {
        0.5 * (self.v0 + self.v1).abs() * self.phase
    }

    fn slip_at(&self, u: f64) -> f64 {
        (u * (self.v0 + 0.5 * (self.v1 - self.v0) * u / self.phase)).abs()
    }

    fn after(&self, force: f64, kappa: f64) -> f64 {
        // At rest friction does not change, even at infinite kappa.
        let forgotten = if self.slip() == 0.0 { 0.0 } else { -(-kappa * self.slip()).exp_m1() };
        force + (self.sign - force) * forgotten
    }

    /// Returns the integral of `exp(-kappa z)` over the slip z.
    fn relaxed(&self, kappa: f64) -> f64 {
        match kappa {
            _ if kappa < CONSTANT_FRICTION_KAPPA => self.slip(),
            f64::INFINITY => 0.0,
            _ => -(-kappa * self.slip()).exp_m1() / kappa,
        }
    }

    /// Returns the integrals of `exp(-kappa z)` and of `x' exp(-kappa z)` over the phase.
    fn integrals(&self, kappa: f64, xi: f64) -> (f64, f64) {
        let (v0, slope) = (self.v0, (self.v1 - self.v0) / self.phase);
        if slope == 0.0 {
            let held = if v0 == 0.0 { self.phase } else { self.relaxed(kappa) / v0.abs() };
            return (held, (v0 - xi) * held);
        }
        if kappa == f64::INFINITY {
            return (0.0, 0.0);
        }
        // Phase at which kappa times slip is CUT_EXPONENT, if the piece gets that far: |v0| u ±
        // |slope| u^2 / 2 = CUT_EXPONENT / kappa.
        let cut_slip = CUT_EXPONENT / kappa;
        let reach = if self.slip() <= cut_slip {
            self.phase
        } else {
            let signed = 0.5 * slope * self.sign;
            2.0 * cut_slip / (v0.abs() + (v0 * v0 + 4.0 * signed * cut_slip).max(0.0).sqrt())
        };
        let sums = gauss::whole().iter().fold((0.0, 0.0), |(held, moving), node| {
            let u = reach * node.at;
            let decay = node.weight * (-kappa * self.slip_at(u)).exp();
            (held + decay, moving + (v0 + slope * u - xi) * decay)
        });
        (reach * sums.0, reach * sums.1)
    }
}
