//! Metrics of a solved contact study.

use crate::metrics::Metrics;
use crate::study::answer::Answer;
use contact::{Method, Motion};
use scene::{Excited, Model, problem};

/// Metrics of the steady state, which a window of the run does not show.
pub const STEADY: [&str; 2] = ["steady_friction_ratio", "settling_periods"];

/// Returns the metrics of a solved study.
pub fn measure(study: &Excited, answer: &Answer) -> Metrics {
    let Answer { problem, solution, steady, across, in_plane } = answer;
    let mut metrics = Metrics::default();
    let (ratios, tally) = (&solution.ratios, solution.tally.as_ref());
    let coulomb_n = tally.map_or(problem.coulomb_n, |tally| tally.coulomb_n);
    let sine = problem::sine(study, problem);
    metrics.put("friction_off_n", coulomb_n);
    metrics.put("friction_on_n", ratios.friction * coulomb_n);
    metrics.put("friction_ratio", ratios.friction);
    metrics.put("steady_friction_ratio", steady.map(|(ratio, _)| ratio));
    metrics.put("settling_periods", steady.map(|(_, orbit)| report::rounded(orbit.settling_periods(), 3)));
    metrics.put("transverse_friction_n", in_plane.as_ref().map(|in_plane| in_plane.transverse_rms_n));
    metrics.put("reduction_percent", 100.0 * (1.0 - ratios.friction));
    // A mass on its contact has no given vibration.
    let shaken_across = across.is_some() && problem.motion != Motion::Kinematic;
    metrics.put("velocity_ratio", (!shaken_across).then(|| problem.sliding_m_per_s / sine.vibration_m_per_s()));
    if let Some(across) = across {
        metrics.put("contact_time_percent", 100.0 * across.contact_share);
        metrics.put("mean_indentation_m", across.mean_indentation_m);
        metrics.put("mean_normal_n", across.mean_normal_n);
        metrics.put("peak_normal_n", across.peak_normal_n);
        if let Some(compliant) = across.compliant {
            metrics.put("stick_time_percent", 100.0 * compliant.stick_share);
            metrics.put("critical_speed_m_per_s", compliant.critical_m_per_s);
            metrics.put("coefficient_ratio", compliant.coefficient_ratio);
        }
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
    // A law of one's own has no stiffness that is known.
    metrics.put("kappa", (!matches!(study.model, Model::Expression(_))).then(|| sine.kappa()));
    metrics.put("error_estimate", solution.error_estimate);
    metrics.put("record_error_estimate", solution.record_error_estimate);
    metrics.put("tolerance_met", f64::from(solution.tolerance_met));
    metrics.put("steps_per_period", solution.steps_per_period.map(f64::from));
    metrics.put("plant_states", solution.states as f64);
    metrics
}
