//! Metrics of a crash with the switched belt; the prefix `passive_` marks those of the same belt
//! without a drive.

use crate::metrics::Metrics;
use plant::dring::crash::Playback;

/// Adds the metrics of a crash that has begun.
pub(super) fn add(playback: &Playback, metrics: &mut Metrics) {
    let (switched, passive) = (&playback.switched, &playback.passive);
    metrics.put("shoulder_force_reduction_percent", 100.0 * (1.0 - switched.shoulder_n / passive.shoulder_n));
    metrics.put("peak_shoulder_force_n", switched.shoulder_n);
    metrics.put("passive_peak_shoulder_force_n", passive.shoulder_n);
    metrics.put("torso_excursion_m", switched.excursion_m);
    metrics.put("passive_torso_excursion_m", passive.excursion_m);
    metrics.put("added_excursion_m", switched.excursion_m - passive.excursion_m);
    metrics.put("chest_acceleration_g", playback.chest_g(switched.shoulder_n));
    metrics.put("passive_chest_acceleration_g", playback.chest_g(passive.shoulder_n));
    metrics.put("payout_speed_m_per_s", switched.payout_m_per_s);
    metrics.put("passive_payout_speed_m_per_s", passive.payout_m_per_s);
    metrics.put("switched", if playback.low_s.is_some() { 1.0 } else { 0.0 });
    metrics.put("switch_time_ms", playback.low_s.map(|s| 1e3 * s));
    metrics.put("actuator_power_w", switched.actuator_w);
    if let Some(moment) = &playback.ring {
        let (ring, on) = (&moment.ring, moment.shoulder_n / moment.retractor_n);
        let off = (ring.mu * ring.wrap_rad).exp();
        metrics.put("ring_tension_ratio", on);
        metrics.put("passive_ring_tension_ratio", off);
        metrics.put("ring_tension_lost_percent", 100.0 * (off - on) / (off - 1.0));
        metrics.put("ring_mean_friction_coefficient", on.ln() / ring.wrap_rad);
    }
    metrics.put("energy_residual", playback.energy_residual);
    metrics.put("error_estimate", playback.error_estimate);
}
