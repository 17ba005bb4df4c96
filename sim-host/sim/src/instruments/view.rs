//! View of a driven run for its instruments: steady blocks, ON windows, and beginning of each mode.
//!
//! A block is **settled** if it is 20 ms after an edge. If a third of the run after its first block
//! in `Run`, or after its last step disturbance, is shorter, that time applies instead. **Steady**
//! blocks are in `Run`, with envelope one, settled, and after the last step disturbance; with
//! switched friction, also after the survey and the last set point.

use firmware::seam::mode::Mode;

use crate::record::{Record, Row};
use plant::truth::MotorTruth;
use scene::Driven;

/// Time after an edge or a disturbance that does not count as steady, s.
const SETTLE_S: f64 = 0.02;
/// Fraction of the rest of the run that does not count as steady, if that is less.
const SETTLE_FRACTION: f64 = 1.0 / 3.0;

/// A scene and the record of its run, with the steady blocks and the times of constant envelope
/// that all instruments share.
pub struct View<'a> {
    /// Scene that was run.
    pub scene: Driven<'a>,
    /// Record of the run.
    pub record: &'a Record,
    pub(super) rows: &'a [Row],
    /// Interval between rows, s.
    pub(super) block_s: f64,
    /// Time of each block since the last change of envelope or mode, and the last step disturbance,
    /// s.
    calm_s: Vec<f64>,
    /// Beginning of each disturbance, s.
    pub(super) disturbed_s: Vec<f64>,
    /// Time of each step disturbance, s.
    pub(super) steps_s: Vec<f64>,
    /// Settling time after an edge, s.
    pub(super) settle_s: f64,
    /// Time from which the friction switch holds its last set point, s.
    held_from_s: f64,
}

impl<'a> View<'a> {
    /// Creates the view of a record.
    pub fn new(scene: &Driven<'a>, record: &'a Record) -> Self {
        let steps_s = scene.disturbance.iter().filter(|d| d.to.is_some()).map(|d| d.at_s).collect();
        let disturbed_s = scene.disturbance.iter().map(|d| d.at_s).collect::<Vec<_>>();
        let block_s = record.sample_s * record.block_samples as f64 * record.every as f64;
        let mut view = View {
            scene: *scene,
            record,
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
        view.held_from_s = view.held_from_s();
        view
    }

    fn settling_s(&self) -> f64 {
        let running_s = self.plays_from(Mode::Run).unwrap_or(f64::NEG_INFINITY);
        let from_s = self.steps_s.iter().copied().fold(running_s, f64::max);
        let left_s = self.rows.last().map_or(0.0, |row| row.time_s - from_s);
        if left_s > 0.0 { SETTLE_S.min(SETTLE_FRACTION * left_s) } else { SETTLE_S }
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

    /// Returns the blocks in `Run` with this envelope, more than `settle_s` after an edge and after
    /// the last step disturbance.
    pub(super) fn settled(&self, envelope: f64, settle_s: f64) -> impl Iterator<Item = &'a Row> + '_ {
        let last_step_s = self.steps_s.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let counts = move |row: &Row, calm: f64| {
            row.mode == Mode::Run && row.envelope == envelope && calm > settle_s && row.time_s > last_step_s
        };
        self.rows.iter().zip(&self.calm_s).filter(move |&(row, &calm)| counts(row, calm)).map(|(row, _)| row)
    }

    /// Returns the steady blocks: in `Run`, with envelope one, settled after the last edge, and
    /// after the last step disturbance.
    pub fn steady(&self) -> impl Iterator<Item = &'a Row> + '_ {
        self.settled(1.0, self.settle_s).filter(|row| row.time_s > self.held_from_s)
    }

    /// Returns the ON windows as played in `Run`, s.
    pub fn on_windows(&self) -> Vec<(f64, f64)> {
        let mut windows: Vec<(f64, f64)> = Vec::new();
        let mut open = false;
        for row in self.after(self.plays_from(Mode::Run).unwrap_or(f64::INFINITY)) {
            // A partial block begins late or ends early by the rest of it.
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

    /// Returns the blocks that play entirely after a time.
    pub fn after(&self, time_s: f64) -> &'a [Row] {
        let half_s = 0.5 * self.block_s;
        &self.rows[self.rows.partition_point(|row| row.time_s - self.block_s < time_s - half_s)..]
    }

    /// Returns the true state of the motor in a row's block.
    pub(super) fn motor_truth(&self, row: &Row) -> Option<&'a MotorTruth> {
        self.record.motors.get(row.number as usize)
    }

    /// Returns the time at which the first block of this mode begins to play, s.
    pub fn plays_from(&self, mode: Mode) -> Option<f64> {
        // The row of block k is the output of `process` after it. That output plays two blocks
        // after k, and so begins one row later.
        self.rows.iter().find(|row| row.mode == mode).map(|row| row.time_s + self.block_s)
    }

    /// Returns the last block of the scan.
    pub(super) fn scan_ends(&self) -> Option<&'a Row> {
        self.rows.iter().rfind(|row| row.mode == Mode::Scan)
    }
}

/// Returns the time between two blocks at which the condition begins to hold, s, by linear
/// interpolation of the tip velocity.
pub(super) fn crossing(before: &Row, after: &Row, there: &dyn Fn(f64) -> bool, tip: impl Fn(&Row) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..20 {
        let part = 0.5 * (low + high);
        if there(tip(before) + part * (tip(after) - tip(before))) { high = part } else { low = part }
    }
    before.time_s + high * (after.time_s - before.time_s)
}
