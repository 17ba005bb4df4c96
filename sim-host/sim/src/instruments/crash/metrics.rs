//! Numbers of a crash, of the belt that is switched; with `passive_` before them, of the same belt without a drive.
//!
//! | metric | meaning |
//! |---|---|
//! | `peak_shoulder_force_n` | the largest force at the shoulder |
//! | `torso_excursion_m` | the farthest that the torso gets from where it sat |
//! | `chest_acceleration_g` | the largest acceleration that the shoulder belt gives it |
//! | `reduction_percent` | by how much the peak force is less than that of the passive belt |
//! | `added_excursion_m` | by how much the excursion is more |
//! | `payout_speed_m_per_s` | the fastest that webbing slides out over the D-ring |
//! | `switched` | 1 if the drive went ON in the crash, 0 if not |
//! | `switch_time_ms` | from the beginning of the pulse to the first block in which the drive plays |
//! | `actuator_power_w` | the most power that the actuator gives to the contact, of one whose law knows it |
//! | `energy_residual` | part of the pulse's work that is not accounted for |
//! | `error_estimate` | how far force and excursion are from those of half the step, relative |

use crate::metrics::Metrics;
use plant::dring::crash::Film;

/// Adds the metrics of a crash that has begun.
pub(super) fn add(film: &Film, metrics: &mut Metrics) {
    let (switched, passive) = (&film.switched, &film.passive);
    metrics.put("reduction_percent", 100.0 * (1.0 - switched.shoulder_n / passive.shoulder_n));
    metrics.put("peak_shoulder_force_n", switched.shoulder_n);
    metrics.put("passive_peak_shoulder_force_n", passive.shoulder_n);
    metrics.put("torso_excursion_m", switched.excursion_m);
    metrics.put("passive_torso_excursion_m", passive.excursion_m);
    metrics.put("added_excursion_m", switched.excursion_m - passive.excursion_m);
    metrics.put("chest_acceleration_g", film.chest_g(switched.shoulder_n));
    metrics.put("passive_chest_acceleration_g", film.chest_g(passive.shoulder_n));
    metrics.put("payout_speed_m_per_s", switched.payout_m_per_s);
    metrics.put("passive_payout_speed_m_per_s", passive.payout_m_per_s);
    metrics.put("switched", if film.low_s.is_some() { 1.0 } else { 0.0 });
    metrics.put("switch_time_ms", film.low_s.map(|s| 1e3 * s));
    metrics.put("actuator_power_w", switched.actuator_w);
    metrics.put("energy_residual", film.energy_residual);
    metrics.put("error_estimate", film.error_estimate);
}
