//! Four amplifiers, four pairs of electrodes and two modes as a linear network of sixteen states:
//! the equations.
//!
//! | state | unit | equation |
//! |---|---|---|
//! | `v_j` voltage of lane j | V | `C0 v_j' = (e_j - v_j) / Rs - sum over modes of phi p_jm s_m` |
//! | `s_m` velocity of mode m | m/s | `m s_m' = sum over lanes of phi p_jm v_j - c s_m - K_m q_m + Q_m` |
//! | `q_m` its amplitude | m | `q_m' = s_m` |
//! | `e_j` amplifier output | V | `e_j' = w_a d_j` |
//! | `d_j` its scaled slope | V | `d_j' = w_a (u_j - e_j - sqrt(2) d_j)` |
//!
//! `phi` is the force factor, N/V, and `p_jm` the participation of lane j in mode m; it couples
//! voltage to force and velocity to current. The electrodes of a lane that is not connected
//! receive no current from `e_j`, and keep their charge. Inputs are the four drives `u_j`, V, and
//! the friction on the two modes `Q_m`, N.

use firmware::seam::block::MAX_LANES;

use crate::motor::model::Model;
use crate::motor::participation::MODES;
use contact::flow::Matrix;
use scene::Amplifier;

/// States of the network.
pub const STATES: usize = 3 * MAX_LANES + 2 * MODES;
pub(super) const V: usize = 0;
pub(super) const S: usize = V + MAX_LANES;
pub(super) const Q: usize = S + MODES;
pub(super) const E: usize = Q + MODES;
pub(super) const D: usize = E + MAX_LANES;
/// Index of the first drive input, V.
pub(super) const DRIVE: usize = STATES;
/// Index of the first friction input, N.
pub(super) const FORCE: usize = DRIVE + MAX_LANES;

/// Number of states and inputs.
pub const WIDTH: usize = FORCE + MODES;

/// `x' = A x` for states and inputs together; the rows of the inputs are zero.
pub type Network = Matrix<WIDTH>;

/// Returns the network of a stator with its amplifiers.
pub fn network(model: &Model, amplifier: &Amplifier) -> Network {
    let corner = std::f64::consts::TAU * amplifier.bandwidth_hz;
    let source = amplifier.source_ohm;
    let mut a = [[0.0; WIDTH]; WIDTH];
    for lane in 0..MAX_LANES {
        let (v, e, d) = (V + lane, E + lane, D + lane);
        a[e][d] = corner;
        a[d][e] = -corner;
        a[d][d] = -corner * std::f64::consts::SQRT_2;
        a[d][DRIVE + lane] = corner;
        if model.connected[lane] {
            a[v][e] = 1.0 / (source * model.c0_f);
            a[v][v] = -1.0 / (source * model.c0_f);
        }
        for mode in 0..MODES {
            let coupling = model.force_factor_n_per_v * model.participation[lane][mode];
            a[v][S + mode] = -coupling / model.c0_f;
            a[S + mode][v] = coupling / model.mass_kg;
        }
    }
    for mode in 0..MODES {
        let (s, q) = (S + mode, Q + mode);
        a[s][s] = -model.damping_n_s_per_m / model.mass_kg;
        a[s][q] = -model.stiffness_n_per_m(mode) / model.mass_kg;
        a[s][FORCE + mode] = 1.0 / model.mass_kg;
        a[q][s] = 1.0;
    }
    a
}
