//! Numbers from the record of a driven run.
//!
//! | metric | over |
//! |---|---|
//! | `friction_off_n` | true friction while the drive is OFF, settled |
//! | `friction_on_n`, `tip_velocity_m_per_s`, `frequency_*`, `motional_phase_deg`, … | **steady** blocks: running, envelope one, settled, after the last step disturbance |
//! | `load_cell_*` | the same by the cell's reading, from 50 ms after the edge |
//! | `lock_time_B_ms` | from the first DAC sample of the lock stage to the last moment that the frequency played is more than B off the true one, before the first disturbance |
//! | `relock_time_B_ms` | from the last step disturbance to the same |
//! | `false_locks`, `undetected_losses` | 1 if the controller said that it was locked and was not, 0 if not: see `lock_claims.rs` |
//! | `series_resonance_hz`, `q`, `coupling`, … | what scan or observer has identified; with `_sd`, the standard deviation that it states |
//! | `modes_found` | resonances that the scan has listed, in the window and beside it |
//! | `acquire_time_ms` | from the first DAC sample of the scan to the first of the run |
//! | `rise_time_ms`, `fall_time_ms` | from the burst's first DAC sample to 95 % of the steady envelope of the true tip velocity, and from its end (the first sample of a brake) to 5 %; of all bursts while running the worst, of the first 64: see `edges.rs` |
//! | `residual_percent` | the largest envelope after a burst's last sample, that of a brake included, of the steady one; the worst likewise |
//! | `overshoot_percent` | the largest envelope of the run over the steady one; not where a step disturbance makes two steady states |
//! | `drive_peak_v`, `drive_rms_v`, `input_power_w`, `tip_velocity_rms_…`, `tip_velocity_peak_…` | steady blocks, any waveform: see `electrical.rs` |
//! | `fault_code`, `limit_code` | the fault at the end of the run; the limit in its last block under drive; 0 is none |
//! | `fault_latency_us` | from the scene's first fault to the first block without drive once the controller has faulted, or has been muted (limit 101) until it did |
//! | `belt_stop_to_mute_ms`, `ring_down_ms`, `exposure_j_per_mm` | only with a belt encoder: see `weld.rs` |
//! | `instructions_total`, `mean_block_…`, `worst_block_…`, `stack_…`, `image_…` | only of a run in QEMU: see `processor.rs` |
//!
//! **Settled** is what comes 20 ms after an edge; or a third of what is left of the run from its first block of running, or from its last
//! step disturbance, if that is less.
//!
//! Where the friction is switched (`switch.rs`), `friction_on_n` and what follows from it are means over whole burst periods, from 50 ms after the
//! survey or the last step of what is wanted, and steady blocks are those from there on.
//!
//! A pull that lags by half a second never settles within 20 ms: what a belt's friction is measured over stands in `belt.rs`.
//!
//! The tip velocity of a stator is that of its crests, across the ring. What only a motor has stands in `motor.rs`, what only a crash
//! has in `crash.rs`.

mod belt;
mod crash;
mod edges;
mod electrical;
pub mod lock_claims;
mod motor;
mod processor;
pub mod switch;
mod weld;

use firmware::seam::fault::Limit;
use firmware::seam::mode::Mode;

use super::Metrics;
use crate::record::{Record, Row};
use scene::{Driven, Slider};

/// After an edge or a disturbance, this long is not counted as steady, s,
const SETTLE_S: f64 = 0.02;
/// or this part of what is left of the run, if that is less.
const SETTLE_PART: f64 = 1.0 / 3.0;
/// The same for the load cell.
const CELL_SETTLE_S: f64 = 0.05;

/// The numbers of a run.
pub fn of(scene: &Driven, record: &Record) -> Metrics {
    let mut metrics = Metrics::default();
    let view = View::new(scene, record);
    view.friction(scene, &mut metrics);
    view.belt(scene, &mut metrics);
    view.edges(record, &mut metrics);
    view.lock(&mut metrics);
    view.steady_state(&mut metrics);
    electrical::add(&view, &mut metrics);
    view.motor(scene, &mut metrics);
    view.switch(scene, &mut metrics);
    view.weld(scene, &mut metrics);
    match &record.crash {
        Some(film) => crash::add(film, &mut metrics),
        None => metrics.put("energy_residual", (record.energy.supplied_j != 0.0).then(|| record.energy.residual())),
    }
    if let Some(transducer) = record.last.transducer {
        let found_hz = f64::from(transducer.series_resonance_hz);
        metrics.put("series_resonance_hz", found_hz);
        metrics.put("series_resonance_error_hz", view.scan_ends().map(|row| found_hz - row.truth.series_resonance_hz));
        metrics.put("parallel_resonance_hz", f64::from(transducer.parallel_resonance_hz));
        metrics.put("q", f64::from(transducer.q));
        metrics.put("rm_ohm", f64::from(transducer.rm_ohm));
        metrics.put("lm_h", f64::from(transducer.lm_h));
        metrics.put("cm_f", f64::from(transducer.cm_f));
        metrics.put("c0_f", f64::from(transducer.c0_f));
        metrics.put("coupling", f64::from(transducer.coupling));
        let sd = transducer.deviations;
        metrics.put("series_resonance_sd_hz", f64::from(sd.series_resonance_hz));
        metrics.put("parallel_resonance_sd_hz", f64::from(sd.parallel_resonance_hz));
        metrics.put("q_sd", f64::from(sd.q));
        metrics.put("rm_sd_ohm", f64::from(sd.rm_ohm));
        metrics.put("lm_sd_h", f64::from(sd.lm_h));
        metrics.put("cm_sd_f", f64::from(sd.cm_f));
        metrics.put("c0_sd_f", f64::from(sd.c0_f));
        metrics.put("coupling_sd", f64::from(sd.coupling));
        metrics.put("modes_found", f64::from(transducer.modes));
    }
    let claims = lock_claims::of(scene, record);
    metrics.put("false_locks", claims.map(|claims| f64::from(u8::from(claims.false_lock))));
    metrics.put("undetected_losses", claims.map(|claims| f64::from(u8::from(claims.undetected_loss))));
    metrics.put("fault_code", record.rows.last().map(|row| f64::from(row.fault)));
    metrics.put("fault_latency_us", view.fault_latency_s(scene).map(|s| s * 1e6));
    metrics.put("limit_code", record.rows.iter().rfind(|row| row.drive_v > 0.0).map(|row| f64::from(row.limit)));
    processor::add(record, &mut metrics);
    metrics.put("plant_states", record.plant_states as f64);
    let simulated_s = record.rows.last().map_or(0.0, |row| row.time_s);
    metrics.put("simulated_s_per_wall_s", record.wall_s.map(|wall_s| simulated_s / wall_s));
    metrics
}

/// A record with what its metrics share: which blocks are steady, and for how long the envelope has been what it is.
pub struct View<'a> {
    rows: &'a [Row],
    block_s: f64,
    /// For each block, since when its envelope is what it is and nothing was disturbed, s.
    calm_s: Vec<f64>,
    disturbed_s: Vec<f64>,
    steps_s: Vec<f64>,
    /// What is settled comes so long after an edge, s.
    settle_s: f64,
    /// The friction switch holds what was wanted last from here on, s.
    held_from_s: f64,
}

impl<'a> View<'a> {
    /// Looks at a record.
    pub fn new(scene: &Driven, record: &'a Record) -> Self {
        let steps_s = scene.disturbance.iter().filter(|d| d.to.is_some()).map(|d| d.at_s).collect();
        let disturbed_s = scene.disturbance.iter().map(|d| d.at_s).collect::<Vec<_>>();
        let block_s = record.sample_s * record.block_samples as f64 * record.every as f64;
        let mut view = View {
            rows: &record.rows,
            block_s,
            calm_s: Vec::new(),
            disturbed_s,
            steps_s,
            settle_s: SETTLE_S,
            held_from_s: f64::NEG_INFINITY,
        };
        view.calm_s = view.calm_times();
        view.settle_s = view.settling_s();
        view.held_from_s = view.held_from_s(scene);
        view
    }

    fn settling_s(&self) -> f64 {
        let running_s = self.plays_from(Mode::Run).unwrap_or(f64::NEG_INFINITY);
        let from_s = self.steps_s.iter().copied().fold(running_s, f64::max);
        let left_s = self.rows.last().map_or(0.0, |row| row.time_s - from_s);
        if left_s > 0.0 { SETTLE_S.min(SETTLE_PART * left_s) } else { SETTLE_S }
    }

    fn calm_times(&self) -> Vec<f64> {
        let mut since = 0.0;
        let mut last: Option<&Row> = None;
        let mut calm = Vec::with_capacity(self.rows.len());
        for row in self.rows {
            let begins = row.time_s - self.block_s;
            let same = last.is_some_and(|last| last.envelope == row.envelope && last.mode == row.mode);
            let stepped = self.steps_s.iter().any(|&at| at >= begins && at < row.time_s);
            if !same || stepped {
                since = begins;
            }
            calm.push(row.time_s - since);
            last = Some(row);
        }
        calm
    }

    fn settled(&self, envelope: f64, settle_s: f64) -> impl Iterator<Item = &'a Row> + '_ {
        let last_step_s = self.steps_s.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let kept = move |row: &Row, calm: f64| {
            row.mode == Mode::Run && row.envelope == envelope && calm > settle_s && row.time_s > last_step_s
        };
        self.rows.iter().zip(&self.calm_s).filter(move |&(row, &calm)| kept(row, calm)).map(|(row, _)| row)
    }

    /// Running, envelope one, some time after the last edge, and after the last step disturbance.
    pub fn steady(&self) -> impl Iterator<Item = &'a Row> + '_ {
        self.settled(1.0, self.settle_s).filter(|row| row.time_s > self.held_from_s)
    }

    /// The ON windows as they were played while running, s.
    pub fn on_windows(&self) -> Vec<(f64, f64)> {
        let mut windows: Vec<(f64, f64)> = Vec::new();
        let mut open = false;
        for row in self.after(self.plays_from(Mode::Run).unwrap_or(f64::INFINITY)) {
            // A block that is ON in part begins late or ends early by the rest of it.
            let (begins, part) = (row.time_s - self.block_s, self.block_s * row.envelope.min(1.0));
            match (open, windows.last_mut()) {
                (true, Some(window)) if row.envelope > 0.0 => window.1 = begins + part,
                _ if row.envelope > 0.0 => windows.push((row.time_s - part, row.time_s)),
                _ => {}
            }
            open = row.envelope > 0.0;
        }
        windows
    }

    /// The blocks that play entirely after a moment.
    pub fn after(&self, time_s: f64) -> &'a [Row] {
        let half_s = 0.5 * self.block_s;
        &self.rows[self.rows.partition_point(|row| row.time_s - self.block_s < time_s - half_s)..]
    }

    /// When the first block of this mode begins to play, s.
    pub fn plays_from(&self, mode: Mode) -> Option<f64> {
        // The row of block k is what `process` said after it; what it said plays two blocks after k, so begins one row later.
        self.rows.iter().find(|row| row.mode == mode).map(|row| row.time_s + self.block_s)
    }

    fn scan_ends(&self) -> Option<&'a Row> {
        self.rows.iter().rfind(|row| row.mode == Mode::Scan)
    }

    fn friction(&self, scene: &Driven, metrics: &mut Metrics) {
        // A slider at rest has a force, and no friction to speak of.
        let sliding = |slider: &&Slider| slider.speed_m_per_s != 0.0;
        let Some(slider) = scene.sliding().map(|(_, slider)| slider).filter(sliding) else { return };
        let force = |row: &Row| row.truth.friction_mean_n;
        let cell = |row: &Row| row.truth.load_cell_n;
        // What a belt keeps that stands is none either.
        let stops_s = scene.belt_stops_s().unwrap_or(f64::INFINITY);
        let off = |settle_s: f64| self.settled(0.0, settle_s).filter(move |row| row.time_s < stops_s);
        let off_n = mean(off(self.settle_s).map(force));
        let on = self.held(scene).map_or_else(|| mean(self.steady().map(force)), |held| mean(held.iter().map(force)));
        metrics.put("friction_off_n", off_n);
        metrics.put("friction_on_n", on);
        let ratio = off_n.zip(on).map(|(off, on)| on / off);
        metrics.put("friction_ratio", ratio);
        metrics.put("reduction_percent", ratio.map(|ratio| 100.0 * (1.0 - ratio)));
        let off_n = mean(off(CELL_SETTLE_S).map(cell));
        let on =
            self.held(scene).map_or_else(|| mean(self.settled(1.0, CELL_SETTLE_S).map(cell)), |held| mean(held.iter().map(cell)));
        metrics.put("load_cell_off_n", off_n);
        metrics.put("load_cell_on_n", on);
        metrics.put("load_cell_reduction_percent", off_n.zip(on).map(|(off, on)| 100.0 * (1.0 - on / off)));
        let tip = mean(self.steady().map(|row| row.truth.tip_velocity_m_per_s));
        metrics.put("velocity_ratio", tip.map(|tip| slider.speed_m_per_s / tip));
    }

    fn edges(&self, record: &Record, metrics: &mut Metrics) {
        let tip = |row: &Row| row.truth.tip_velocity_m_per_s;
        let Some(steady) = mean(self.steady().map(tip)) else { return };
        let at_edges = edges::add(self, &record.edges, record.sample_s, metrics).unwrap_or(0.0);
        let peak = self.rows.iter().filter(|row| row.mode == Mode::Run).map(tip).fold(at_edges, f64::max);
        metrics.put("tip_velocity_m_per_s", steady);
        metrics.put("peak_velocity_m_per_s", peak);
        metrics.put("overshoot_percent", self.steps_s.is_empty().then(|| 100.0 * (peak / steady - 1.0).max(0.0)));
    }

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

    /// How long after `from` the frequency played is last more than `bound` off, s; nothing if it still is at the end.
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

    /// From the first fault of the scene to the first block without drive.
    fn fault_latency_s(&self, scene: &Driven) -> Option<f64> {
        let at = scene.fault.iter().map(|fault| fault.at_s).reduce(f64::min)?;
        let faulted = self.rows.iter().position(|row| row.fault != 0).filter(|&row| row > 0)?;
        let muted = faulted + self.rows[faulted..].iter().position(|row| row.drive_v == 0.0)?;
        // What was muted until it faulted has been silent for longer.
        let silent = self.rows[..=muted]
            .iter()
            .rev()
            .take_while(|row| row.drive_v == 0.0 && row.time_s - self.block_s >= at - 1e-9)
            .last()?;
        let muted = if self.rows[faulted - 1].limit == Limit::BeltMuted as u8 { silent } else { &self.rows[muted] };
        Some(muted.time_s - self.block_s - at)
    }
}

/// When, between two blocks, the condition begins to hold, by linear interpolation of the tip velocity.
fn crossing(before: &Row, after: &Row, there: &dyn Fn(f64) -> bool, tip: impl Fn(&Row) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..20 {
        let part = 0.5 * (low + high);
        if there(tip(before) + part * (tip(after) - tip(before))) { high = part } else { low = part }
    }
    before.time_s + high * (after.time_s - before.time_s)
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0usize), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / count as f64)
}
