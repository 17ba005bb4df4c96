//! Numbers from a solved contact study. Fc is the Coulomb force, mu N; Vt the sliding speed; means are over the scene's window.
//!
//! | metric | is |
//! |---|---|
//! | `friction_off_n`, `friction_on_n` | Fc at the end of the window, which is the friction without vibration; mean friction |
//! | `friction_ratio`, `reduction_percent` | mean friction over Fc (thesis 4.17); what is missing to one, in per cent |
//! | `velocity_ratio` | Vt / Vv, Vv being the steady velocity of the sine of this force and frequency without friction |
//! | `peak_velocity_m_per_s`, `peak_displacement_m` | largest velocity and displacement at a step's end within the whole run |
//! | `peak_force_ratio` | largest friction at a step's end within the whole run, over the Fc of that moment |
//! | `reversals` | reversals of the slip in the whole run; of methods that locate them |
//! | `power_ratio` | power into friction, over Fc Vt (4.18) |
//! | `input_ratio` | power from the forcing, over Fc Vt (4.31); of a given motion, the power that keeps it up |
//! | `stored_ratio`, `damper_ratio` | energy gained by mass and spring, and lost in the damper, over Fc Vt times the window |
//! | `power_ratio_as_printed` | `1 + phi_iu - phi_su` (4.35), which is wrong and kept to be shown |
//! | `energy_residual` | what the energy identity misses, over Fc Vt times the window |
//! | `contact_time_percent` | part of the window in contact, of a vibration across the surface; so are the next three |
//! | `mean_indentation_m` | mean deflection of the contact; nothing while the bodies are apart |
//! | `mean_normal_n`, `peak_normal_n` | mean and largest normal force. The mean is the load, where nothing else carries it |
//! | `kappa` | Kt Vv / (w Fc): vibration amplitude in Dahl lengths |
//! | `error_estimate` | how far the friction ratio is from that of half the step |
//! | `steps_per_period`, `plant_states`, `ns_per_period` | what the solution took |

use crate::metrics::Metrics;
use crate::study::contact::Answer;
use contact::{Method, Motion};
use scene::{Excited, problem};

/// The one metric that depends on the machine.
pub const WALL: &str = "ns_per_period";

/// The numbers of a solved study.
pub fn of(study: &Excited, answer: &Answer) -> Metrics {
    let Answer { problem, solution, across } = answer;
    let mut metrics = Metrics::default();
    let (ratios, tally) = (&solution.ratios, solution.tally.as_ref());
    let coulomb_n = tally.map_or(problem.coulomb_n, |tally| tally.coulomb_n);
    let sine = problem::sine(study, problem);
    metrics.put("friction_off_n", coulomb_n);
    metrics.put("friction_on_n", ratios.friction * coulomb_n);
    metrics.put("friction_ratio", ratios.friction);
    metrics.put("reduction_percent", 100.0 * (1.0 - ratios.friction));
    // A mass on its contact has no vibration by itself.
    let shaken_across = across.is_some() && problem.motion != Motion::Kinematic;
    metrics.put("velocity_ratio", (!shaken_across).then(|| problem.sliding_m_per_s / sine.vibration_m_per_s()));
    if let Some(across) = across {
        metrics.put("contact_time_percent", 100.0 * across.contact_share);
        metrics.put("mean_indentation_m", across.mean_indentation_m);
        metrics.put("mean_normal_n", across.mean_normal_n);
        metrics.put("peak_normal_n", across.peak_normal_n);
    }
    metrics.put("peak_velocity_m_per_s", tally.map(|tally| tally.peak_velocity_m_per_s));
    metrics.put("peak_displacement_m", tally.map(|tally| tally.peak_displacement_m));
    metrics.put("peak_force_ratio", tally.map(|tally| tally.peak_force_ratio));
    let locates = !matches!(solution.method, Method::Rk4 | Method::Midpoint);
    metrics.put("reversals", tally.filter(|_| locates).map(|tally| tally.reversals as f64));
    metrics.put("power_ratio", ratios.power);
    metrics.put("input_ratio", ratios.input);
    if let Motion::Sdof { damping_n_s_per_m, .. } = problem.motion {
        metrics.put("stored_ratio", ratios.stored);
        metrics.put("damper_ratio", ratios.damping.filter(|_| damping_n_s_per_m > 0.0));
    }
    metrics.put("power_ratio_as_printed", ratios.power_as_printed);
    metrics.put("energy_residual", ratios.energy_residual);
    metrics.put("kappa", sine.kappa());
    metrics.put("error_estimate", solution.error_estimate);
    metrics.put("steps_per_period", solution.steps_per_period.map(f64::from));
    metrics.put("plant_states", solution.states as f64);
    metrics.put(WALL, solution.ns_per_period);
    metrics
}
