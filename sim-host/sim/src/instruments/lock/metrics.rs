//! Metrics of the lock: time to a lasting lock, accuracy after it, and correctness of the lock
//! reports.

use firmware::seam::mode::Mode;

use super::claims;
use crate::instruments::View;
use crate::metrics::Metrics;
use crate::record::Row;
use report::statistics::mean;

/// Duration of an OFF above which it ends the time to lock, s; one between bursts is shorter.
const PAUSE_S: f64 = 0.02;

/// Adds the metrics of the lock.
pub(super) fn add(run: &View, metrics: &mut Metrics) {
    run.lock(metrics);
    run.steady_state(metrics);
    let claims = claims::evaluate(run);
    metrics.put("false_locks", claims.map(|claims| f64::from(u8::from(claims.false_lock))));
    metrics.put("undetected_losses", claims.map(|claims| f64::from(u8::from(claims.undetected_loss))));
}

impl View<'_> {
    fn lock(&self, metrics: &mut Metrics) {
        let (scan, lock, run) = (self.plays_from(Mode::Scan), self.plays_from(Mode::Lock), self.plays_from(Mode::Run));
        metrics.put("acquire_time_ms", scan.zip(run).map(|(scan, run)| 1e3 * (run - scan)));
        let first_disturbed = self.disturbed_s.iter().copied().fold(f64::INFINITY, f64::min);
        // A preceding scan has already found the frequency; there is no pull-in.
        let lock = lock.filter(|&lock| scan.is_none_or(|scan| scan > lock));
        let end_s = lock.and_then(|lock| self.pauses_s(lock)).map_or(first_disturbed, |s| s.min(first_disturbed));
        let last_step = self.steps_s.iter().copied().reduce(f64::max);
        for (name, again, bound) in [
            ("lock_time_100hz_ms", "relock_time_100hz_ms", 100.0),
            ("lock_time_20hz_ms", "relock_time_20hz_ms", 20.0),
            ("lock_time_4hz_ms", "relock_time_4hz_ms", 4.0),
        ] {
            let locks = |lock: f64| self.locks_within(lock, (end_s, first_disturbed), bound);
            metrics.put(name, lock.and_then(locks).map(|s| 1e3 * s));
            let relocks = |step: f64| settles(self.driven(step, f64::INFINITY), step, bound);
            metrics.put(again, last_step.and_then(relocks).map(|s| 1e3 * s));
        }
    }

    /// Returns the blocks under drive at the lock point between two times, s.
    fn driven(&self, from: f64, to: f64) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(move |row| row.time_s > from && row.time_s < to && row.drive_v > 0.0 && !row.probes())
    }

    /// Returns the beginning of the first OFF after `from` that lasts longer than [`PAUSE_S`], s.
    fn pauses_s(&self, from: f64) -> Option<f64> {
        let mut began: Option<f64> = None;
        for row in self.rows.iter().filter(|row| row.time_s > from) {
            let silent = row.mode == Mode::Run && row.drive_v == 0.0;
            began = silent.then(|| began.unwrap_or(row.time_s));
            if began.is_some_and(|began| row.time_s - began > PAUSE_S) {
                return began;
            }
        }
        None
    }

    /// Returns the time from `from`, the beginning of the lock stage, to within `bound`, s, if that
    /// is reached before `end_s`. The frequency is held while the drive is OFF, so the first block
    /// between `end_s` and `to` shows the frequency reached by the last block before.
    fn locks_within(&self, from: f64, (end_s, to): (f64, f64), bound: f64) -> Option<f64> {
        let next = self.driven(end_s, to).next().filter(|row| is_within(row, bound));
        settles(self.driven(from, end_s).chain(next), from, bound)
    }

    fn steady_state(&self, metrics: &mut Metrics) {
        let errors = || self.steady().filter(|row| !row.probes()).map(|row| row.frequency_hz - row.truth.series_resonance_hz);
        let bias = mean(errors());
        metrics.put("frequency_bias_hz", bias);
        metrics.put("frequency_jitter_hz", bias.and_then(|bias| mean(errors().map(|e| (e - bias).powi(2)))).map(f64::sqrt));
        metrics.put("frequency_error_max_hz", errors().map(f64::abs).reduce(f64::max));
        let (p, q) = self.steady().fold((0.0, 0.0), |(p, q), row| (p + row.truth.power_w, q + row.truth.quadrature_w));
        metrics.put("motional_phase_deg", (p != 0.0).then(|| q.atan2(p).to_degrees()));
    }
}

/// Returns `true` if a block plays within `bound`, Hz, of the true resonance.
fn is_within(row: &Row, bound: f64) -> bool {
    (row.frequency_hz - row.truth.series_resonance_hz).abs() <= bound
}

/// Returns the time from `from` to the last of these blocks that is off by more than `bound`, s;
/// `None` if that is the final block.
fn settles<'a>(blocks: impl Iterator<Item = &'a Row>, from: f64, bound: f64) -> Option<f64> {
    let (mut outside, mut end) = (None, None);
    for row in blocks {
        if !is_within(row, bound) {
            outside = Some(row.time_s);
        }
        end = Some(row.time_s);
    }
    (end > outside).then(|| outside.map_or(0.0, |outside| outside - from))
}
