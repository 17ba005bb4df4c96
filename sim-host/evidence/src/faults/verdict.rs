//! The response to a failure, judged against the plant.
//!
//! A block is dangerous if it begins at least two blocks after the failure, the drive is on, and
//!
//! * the amplifier is ordered or made to exceed 1.2 times `limits.voltage_v`, or
//! * the frequency is more than half a bandwidth, `fs / (2 Q)`, off the true series resonance.

use firmware::seam::fault::Limit;
use firmware::seam::mode::Mode;
use sim::record::Row;

use super::place::Failed;

/// Ratio to the voltage limit above which a drive is dangerous.
const DANGEROUS_RATIO: f64 = 1.2;
/// Number of blocks after a failure in which earlier orders still play.
const QUEUED_BLOCKS: f64 = 3.0;
/// Ratio to the voltage limit below which a block is silent.
const SILENT_REL: f64 = 1e-3;
/// Length of the end of a run over which its final state is judged, s.
const END_S: f64 = 0.01;

/// Verdict on a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Verdict {
    /// Code of the fault that has ended the run, or of the limit that holds in most of its end,
    /// unless the limit only reports a measurement; zero if nothing was reported.
    pub(super) reported_code: u8,
    /// Time of drive from the failure until it was finally off, ms, if a fault has ended it.
    pub(super) off_ms: Option<f64>,
    /// Energy into the motional branch from the failure until then, J.
    pub(super) energy_j: f64,
    /// Time for which it was dangerous before the controller was off, ms.
    pub(super) dangerous_ms: f64,
    /// `true` if it is dangerous in most of the driven blocks at the end.
    pub(super) dangerous_at_end: bool,
}

impl Verdict {
    /// Returns `true` if the run is dangerous at the end and nothing was reported.
    pub(super) fn is_undetected(&self) -> bool {
        self.dangerous_at_end && self.reported_code == 0
    }
}

/// Judges a run.
pub(super) fn judge(failed: &Failed) -> Verdict {
    let &Failed { limit_v, half_hz, ref record, ref at_s } = failed;
    let block_s = record.block_samples as f64 * record.sample_s;
    let driven = |row: &Row| row.swing.peak_v > SILENT_REL * limit_v;
    let dangerous = |row: &&Row| {
        let is_judged = row.drive_v > 0.0 && matches!(row.mode, Mode::Lock | Mode::Run);
        let off_hz = row.frequency_hz - row.truth.series_resonance_hz;
        driven(row) && (row.swing.peak_v > DANGEROUS_RATIO * limit_v || is_judged && off_hz.abs() > half_hz)
    };
    let rows = &record.rows[record.rows.partition_point(|row| row.time_s <= at_s + block_s / 2.0)..];
    let later = &rows[rows.partition_point(|row| row.time_s < at_s + QUEUED_BLOCKS * block_s)..];
    let end = &rows[rows.len() - rows.len().min((END_S / block_s) as usize)..];
    let fault = record.last.fault.map_or(0, |fault| fault.code());
    let limit = |row: &Row| if row.limit == Limit::Probing.code() { 0 } else { row.limit };
    let mut limits: Vec<u8> = end.iter().map(limit).collect();
    limits.sort_unstable();
    let limit = limits.get(limits.len() / 2).copied().unwrap_or(0);
    let until_s = |row: &Row| row.time_s - row.dropped_s - (row.time_s - block_s).max(*at_s);
    // Until the controller is off, including the block in which it reports the fault. A stuck DAC
    // cannot be muted by codes, only by the enable line of a board.
    let until_fault = rows.iter().position(|row| row.fault > 0).map_or(rows.len(), |first| (first + 1).min(rows.len()));
    let driven_s: f64 = rows[..until_fault].iter().filter(|row| driven(row)).map(|row| until_s(row).max(0.0)).sum();
    let until_off = &later[..later.iter().position(|row| row.fault > 0).unwrap_or(later.len())];
    let (on, bad) = (end.iter().filter(|row| driven(row)).count(), end.iter().filter(dangerous).count());
    Verdict {
        reported_code: if fault > 0 { fault } else { limit },
        off_ms: (fault > 0).then_some(1e3 * driven_s),
        energy_j: rows.iter().map(|row| row.truth.power_w.max(0.0) * block_s).sum(),
        dangerous_ms: 1e3 * block_s * until_off.iter().filter(dangerous).count() as f64,
        dangerous_at_end: 2 * bad > on,
    }
}
