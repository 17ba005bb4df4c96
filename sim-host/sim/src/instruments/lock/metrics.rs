//! Metrics of the lock: how soon the frequency is right for good, how right it stays, and what the controller claims.

use firmware::seam::mode::Mode;

use super::claims;
use crate::instruments::View;
use crate::metrics::Metrics;
use crate::record::Row;
use report::statistics::mean;

/// An OFF that lasts longer ends the time to lock, s, and not one between the bursts of a schedule.
const PAUSE_S: f64 = 0.02;

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
        // A scan that comes first has found the frequency, and nothing is left to be pulled in.
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

    /// The blocks under drive at the lock point between two moments, s.
    fn driven(&self, from: f64, to: f64) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(move |row| row.time_s > from && row.time_s < to && row.drive_v > 0.0 && !row.probes())
    }

    /// When the first OFF of the run begins, after a moment, that lasts longer than [`PAUSE_S`], s.
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

    /// How long a lock stage that begins at `from` takes to within `bound`, s, if it does before the first of two moments. The frequency is held while the
    /// drive is OFF: the first block after that moment, before the second, says where the last one before has come to.
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

/// Whether a block plays within so many Hz of the true resonance.
fn is_within(row: &Row, bound: f64) -> bool {
    (row.frequency_hz - row.truth.series_resonance_hz).abs() <= bound
}

/// How long after `from` the last of these blocks is that plays off by more than `bound`, s; none if the very last is.
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
