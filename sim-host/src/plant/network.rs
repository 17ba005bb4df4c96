//! Amplifier and stack as a linear network of five states: the equations.
//!
//! ```text
//!  DAC (held) -> Butterworth low-pass -> e --[ Rs ]--+------ v0 ------+
//!                                                    |                |
//!                                                   C0        Lm - Cm - Rm - (F / phi)
//!                                                    |                |
//!                                                   gnd              gnd
//! ```
//!
//! | state | unit | equation |
//! |---|---|---|
//! | `e` amplifier output | V | `e' = w_a d` |
//! | `d` its scaled slope | V | `d' = w_a (u - e - sqrt(2) d)` |
//! | `v0` stack voltage | V | `C0 v0' = (e - v0) / Rs - i` |
//! | `i` motional current | A | `Lm i' = v0 - Rm i - vc - F / phi` |
//! | `vc` motional capacitor | V | `Cm vc' = i` |
//!
//! `phi` is the force factor, N/V: tip velocity `i / phi`, tip displacement `Cm vc / phi`. `F`, the friction on the tip in the
//! direction against positive motion, comes back into the motional branch as the voltage `F / phi`: at 10 N and mu 0.3 that is
//! 0.5 V of a 3 V drive. Equivalent circuit: Butterworth 1914, Van Dyke 1928; force factor: Mason 1948.

use crate::plant::circuit::Circuit;
use crate::plant::flow::Matrix;
use crate::scene::Amplifier;

/// States of the network.
pub const STATES: usize = 5;
pub(super) const E: usize = 0;
pub(super) const D: usize = 1;
pub(super) const V0: usize = 2;
pub(super) const I: usize = 3;
pub(super) const VC: usize = 4;
/// The two inputs, which do not change during a step: drive, V, and friction, N.
pub(super) const DRIVE: usize = STATES;
pub(super) const FORCE: usize = STATES + 1;

/// `x' = A x` for states and inputs together; the rows of the inputs are zero.
pub type Network = Matrix<{ STATES + 2 }>;

/// The network of a circuit behind an amplifier.
pub fn network(circuit: &Circuit, amplifier: &Amplifier) -> Network {
    let &Circuit { c0_f, cm_f, lm_h, rm_ohm, force_factor_n_per_v } = circuit;
    let corner = std::f64::consts::TAU * amplifier.bandwidth_hz;
    let source = amplifier.source_ohm;
    let mut a = Network::default();
    a[E][D] = corner;
    a[D][E] = -corner;
    a[D][D] = -corner * std::f64::consts::SQRT_2;
    a[D][DRIVE] = corner;
    a[V0][E] = 1.0 / (source * c0_f);
    a[V0][V0] = -1.0 / (source * c0_f);
    a[V0][I] = -1.0 / c0_f;
    a[I][V0] = 1.0 / lm_h;
    a[I][I] = -rm_ohm / lm_h;
    a[I][VC] = -1.0 / lm_h;
    a[I][FORCE] = -1.0 / (lm_h * force_factor_n_per_v);
    a[VC][I] = 1.0 / cm_f;
    a
}
