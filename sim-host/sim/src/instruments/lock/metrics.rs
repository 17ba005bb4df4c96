//! Metrics of the lock.
//!
//! | metric | over |
//! |---|---|
//! | `frequency_*`, `motional_phase_deg`, `drive_power_w` | steady blocks |
//! | `lock_time_B_ms` | from the first DAC sample of the lock stage to the last moment that the frequency played is more than B off the true one, before the first disturbance |
//! | `relock_time_B_ms` | from the last step disturbance to the same |
//! | `acquire_time_ms` | from the first DAC sample of the scan to the first of the run |
//! | `false_locks`, `undetected_losses` | 1 if the controller said that it was locked and was not, 0 if not: see [`claims`] |

use firmware::seam::mode::Mode;

use super::claims;
use crate::instruments::View;
use crate::instruments::view::mean;
use crate::metrics::Metrics;

/// Adds the metrics of the lock.
pub(super) fn add(run: &View, metrics: &mut Metrics) {
    run.lock(metrics);
    run.steady_state(metrics);
    let claims = claims::of(run);
    metrics.put("false_locks", claims.map(|claims| f64::from(u8::from(claims.false_lock))));
    metrics.put("undetected_losses", claims.map(|claims| f64::from(u8::from(claims.undetected_loss))));
}

impl View<'_> {
    fn lock(&self, metrics: &mut Metrics) {
        let (scan, lock, run) = (self.plays_from(Mode::Scan), self.plays_from(Mode::Lock), self.plays_from(Mode::Run));
        metrics.put("acquire_time_ms", scan.zip(run).map(|(scan, run)| 1e3 * (run - scan)));
        let first_disturbed = self.disturbed_s.iter().copied().fold(f64::INFINITY, f64::min);
        let stays =
            |from: Option<f64>, to: f64, bound: f64| from.and_then(|from| self.stays_within(from, to, bound)).map(|s| 1e3 * s);
        let last_step = self.steps_s.iter().copied().reduce(f64::max);
        for (name, again, bound) in [
            ("lock_time_100hz_ms", "relock_time_100hz_ms", 100.0),
            ("lock_time_20hz_ms", "relock_time_20hz_ms", 20.0),
            ("lock_time_4hz_ms", "relock_time_4hz_ms", 4.0),
        ] {
            metrics.put(name, stays(lock, first_disturbed, bound));
            metrics.put(again, stays(last_step, f64::INFINITY, bound));
        }
    }

    /// How long after `from` the frequency played is last more than `bound` off, s; none if it still is at the end.
    fn stays_within(&self, from: f64, to: f64, bound: f64) -> Option<f64> {
        let played = self.rows.iter().filter(|row| row.time_s > from && row.time_s < to && row.drive_v > 0.0);
        let mut outside = None;
        let mut end = None;
        for row in played {
            if (row.frequency_hz - row.truth.series_resonance_hz).abs() > bound {
                outside = Some(row.time_s);
            }
            end = Some(row.time_s);
        }
        let settled = outside.map_or(0.0, |outside| outside - from);
        (end > outside).then_some(settled)
    }

    fn steady_state(&self, metrics: &mut Metrics) {
        let errors = || self.steady().map(|row| row.frequency_hz - row.truth.series_resonance_hz);
        let bias = mean(errors());
        metrics.put("frequency_bias_hz", bias);
        metrics.put("frequency_jitter_hz", bias.and_then(|bias| mean(errors().map(|e| (e - bias).powi(2)))).map(f64::sqrt));
        metrics.put("frequency_error_max_hz", errors().map(f64::abs).reduce(f64::max));
        let (p, q) = self.steady().fold((0.0, 0.0), |(p, q), row| (p + row.truth.power_w, q + row.truth.quadrature_w));
        metrics.put("motional_phase_deg", (p != 0.0).then(|| q.atan2(p).to_degrees()));
        metrics.put("drive_power_w", mean(self.steady().map(|row| row.truth.power_w)));
    }
}
