//! What became of a failure, judged against the plant.
//!
//! Dangerous is a block, two blocks or later after the failure, in which the drive is on and
//!
//! * the amplifier is ordered or made to give more than 1.2 times `limits.voltage_v`, or
//! * the frequency is more than half a bandwidth, `fs / (2 Q)`, beside the true series resonance.

use firmware::seam::fault::Limit;
use firmware::seam::mode::Mode;
use sim::record::Row;

use super::place::Failed;

/// How far above a limit is dangerous.
const TOO_MUCH: f64 = 1.2;
/// Blocks after a failure in which what was ordered before it still plays.
const QUEUED: f64 = 3.0;
/// A block that swings by less than this part of the voltage limit is silent.
const SILENT: f64 = 1e-3;
/// The end of a run, in which it is judged what it has come to, s.
const END_S: f64 = 0.01;

/// What became of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Verdict {
    /// The fault that has ended it, or the limit that holds in most of its end, unless that only tells of a measurement; zero: nothing was said.
    pub(super) said: u8,
    /// How long it was driven from the failure until it was off for good, ms, where a fault has ended it.
    pub(super) off_ms: Option<f64>,
    /// Energy into the motional branch from the failure until then, J.
    pub(super) energy_j: f64,
    /// How long it was dangerous before the controller was off, ms.
    pub(super) dangerous_ms: f64,
    /// Whether it is so in most of what is driven in the end.
    pub(super) still: bool,
}

impl Verdict {
    /// Dangerous in the end, and nothing was said.
    pub(super) fn is_undetected(&self) -> bool {
        self.still && self.said == 0
    }
}

/// Judges a run.
pub(super) fn judge(failed: &Failed) -> Verdict {
    let &Failed { limit_v, half_hz, ref record, ref at_s } = failed;
    let block_s = record.block_samples as f64 * record.sample_s;
    let driven = |row: &Row| row.swing.peak_v > SILENT * limit_v;
    let dangerous = |row: &&Row| {
        let beside = row.drive_v > 0.0 && matches!(row.mode, Mode::Lock | Mode::Run);
        let beside_hz = row.frequency_hz - row.truth.series_resonance_hz;
        driven(row) && (row.swing.peak_v > TOO_MUCH * limit_v || beside && beside_hz.abs() > half_hz)
    };
    let rows = &record.rows[record.rows.partition_point(|row| row.time_s <= at_s + block_s / 2.0)..];
    let later = &rows[rows.partition_point(|row| row.time_s < at_s + QUEUED * block_s)..];
    let end = &rows[rows.len() - rows.len().min((END_S / block_s) as usize)..];
    let fault = record.last.fault.map_or(0, |fault| fault.code());
    let limit = |row: &Row| if row.limit == Limit::Probing.code() { 0 } else { row.limit };
    let mut limits: Vec<u8> = end.iter().map(limit).collect();
    limits.sort_unstable();
    let limit = limits.get(limits.len() / 2).copied().unwrap_or(0);
    let until_s = |row: &Row| row.time_s - row.dropped_s - (row.time_s - block_s).max(*at_s);
    // Until the controller is off, with the block in which it says so: a DAC that stands cannot be muted by codes, but by the enable line of a board.
    let until_fault = rows.iter().position(|row| row.fault > 0).map_or(rows.len(), |first| (first + 1).min(rows.len()));
    let driven_s: f64 = rows[..until_fault].iter().filter(|row| driven(row)).map(|row| until_s(row).max(0.0)).sum();
    let until_off = &later[..later.iter().position(|row| row.fault > 0).unwrap_or(later.len())];
    let (on, bad) = (end.iter().filter(|row| driven(row)).count(), end.iter().filter(dangerous).count());
    Verdict {
        said: if fault > 0 { fault } else { limit },
        off_ms: (fault > 0).then_some(1e3 * driven_s),
        energy_j: rows.iter().map(|row| row.truth.power_w.max(0.0) * block_s).sum(),
        dangerous_ms: 1e3 * block_s * until_off.iter().filter(dangerous).count() as f64,
        still: 2 * bad > on,
    }
}
