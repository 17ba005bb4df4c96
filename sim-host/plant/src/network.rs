//! Amplifier and stack as a linear network of five states, plus two for each further mode: the
//! equations.
//!
//! ```text
//!  DAC (held) -> Butterworth low-pass -> e --[ Rs ]--+------ v0 ------+
//!                                                    |                |
//!                                                 C0 || G    Lm - Cm - Rm - (F / phi)  (and Lk - Ck - Rk, ...)
//!                                                    |                |
//!                                                   gnd              gnd
//! ```
//!
//! | state | unit | equation |
//! |---|---|---|
//! | `e` amplifier output | V | `e' = w_a d` |
//! | `d` its scaled slope | V | `d' = w_a (u - e - sqrt(2) d)` |
//! | `v0` stack voltage | V | `C0 v0' = (e - v0) / Rs - G v0 - i - sum of ik` |
//! | `i` motional current | A | `Lm i' = v0 - Rm i - vc - F / phi` |
//! | `vc` motional capacitor | V | `Cm vc' = i` |
//! | `ik` current of a further mode | A | `Lk ik' = v0 - Rk ik - vk` |
//! | `vk` its capacitor | V | `Ck vk' = ik` |
//!
//! `phi` is the force factor, N/V: tip velocity `i / phi`, tip displacement `Cm vc / phi`. `F` is
//! the friction on the tip, positive against positive motion. It acts back on the motional branch
//! as the voltage `F / phi`: at 10 N and mu 0.3 that is 0.5 V of a 3 V drive. A further mode does
//! not contribute to the tip's motion along the friction. `G` is the leakage in parallel with C0.
//! Equivalent circuit: Butterworth 1914, Van Dyke 1928; force factor: Mason 1948.

use crate::circuit::Circuit;
use crate::parts::Parts;
use contact::flow::Matrix;
use scene::Amplifier;

/// States of the network without further modes.
pub const STATES: usize = 5;
pub(super) const E: usize = 0;
pub(super) const D: usize = 1;
pub(super) const V0: usize = 2;
pub(super) const I: usize = 3;
pub(super) const VC: usize = 4;
/// Index of the drive input, V, which is constant during a step.
pub(super) const DRIVE: usize = STATES;
/// Index of the friction input, N, which is constant during a step.
pub(super) const FORCE: usize = STATES + 1;
/// Index of the current of the first further mode. The voltage of its capacitor follows, then the
/// next mode.
pub(super) const FURTHER: usize = STATES + 2;

/// Returns `A` of `x' = A x` for states and inputs together; the rows of the inputs are zero. `N`
/// is `FURTHER` plus two for each further mode.
pub fn network<const N: usize>(parts: &Parts, amplifier: &Amplifier) -> Matrix<N> {
    let Circuit { c0_f, cm_f, lm_h, rm_ohm, force_factor_n_per_v } = parts.circuit;
    let corner = std::f64::consts::TAU * amplifier.bandwidth_hz;
    let source = amplifier.source_ohm;
    let mut a = [[0.0; N]; N];
    a[E][D] = corner;
    a[D][E] = -corner;
    a[D][D] = -corner * std::f64::consts::SQRT_2;
    a[D][DRIVE] = corner;
    a[V0][E] = 1.0 / (source * c0_f);
    a[V0][V0] = -1.0 / (source * c0_f) - parts.leak_s / c0_f;
    a[V0][I] = -1.0 / c0_f;
    a[I][V0] = 1.0 / lm_h;
    a[I][I] = -rm_ohm / lm_h;
    a[I][VC] = -1.0 / lm_h;
    a[I][FORCE] = -1.0 / (lm_h * force_factor_n_per_v);
    a[VC][I] = 1.0 / cm_f;
    for (k, branch) in parts.further.iter().enumerate() {
        let (i, vc) = (FURTHER + 2 * k, FURTHER + 2 * k + 1);
        a[V0][i] = -1.0 / c0_f;
        a[i][V0] = 1.0 / branch.lm_h;
        a[i][i] = -branch.rm_ohm / branch.lm_h;
        a[i][vc] = -1.0 / branch.lm_h;
        a[vc][i] = 1.0 / branch.cm_f;
    }
    a
}
