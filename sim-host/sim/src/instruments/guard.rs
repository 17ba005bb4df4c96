//! Faults and limits: the final ones of the controller, and the time until the drive was OFF.

use firmware::seam::fault::Limit;

use super::{Instrument, View};
use crate::metrics::Metrics;

/// Instrument of every driven scene.
pub(super) struct Guard;

impl Instrument for Guard {
    fn metrics(&self, run: &View, metrics: &mut Metrics) {
        metrics.put("fault_code", run.rows.last().map(|row| f64::from(row.fault)));
        metrics.put("fault_latency_us", fault_latency_s(run).map(|s| s * 1e6));
        metrics.put("limit_code", limit_code(run).map(f64::from));
    }

    fn remarks(&self, run: &View) -> Vec<String> {
        let fault = run.record.last.fault;
        let fault =
            fault.map(|fault| format!("The run ended in fault {}, {}: see {}.", fault.code(), fault.called(), fault.place()));
        let limit = limit_code(run).and_then(|code| Limit::try_from(code).ok());
        let limit = limit.map(|limit| {
            format!("In the last block under drive, limit {} was active, {}: see {}.", limit as u8, limit.called(), limit.place())
        });
        fault.into_iter().chain(limit).collect()
    }
}

/// Returns the number of the limit in the last block under drive, or zero. A measurement of the
/// clamped capacitance does not hide a limit that lasts.
fn limit_code(run: &View) -> Option<u8> {
    let mut driven = run.rows.iter().rev().filter(|row| row.drive_v > 0.0);
    let last = driven.clone().next();
    driven.find(|row| !row.probes()).filter(|row| row.limit != 0).or(last).map(|row| row.limit)
}

/// Returns the time from the first fault of the scene to the first sample without drive: the
/// beginning of a block, or the point at which the fault truncated the block before.
fn fault_latency_s(run: &View) -> Option<f64> {
    let at = run.scene.fault.iter().map(|fault| fault.at_s).reduce(f64::min)?;
    let faulted = run.rows.iter().position(|row| row.fault != 0).filter(|&row| row > 0)?;
    let muted = faulted + run.rows[faulted..].iter().position(|row| row.drive_v == 0.0)?;
    // If the drive was muted before it faulted, it was silent earlier.
    let silent =
        run.rows[..=muted].iter().rev().take_while(|row| row.drive_v == 0.0 && row.time_s - run.block_s >= at - 1e-9).last()?;
    let (muted, dropped_s) = if run.rows[faulted - 1].limit == Limit::BeltMuted as u8 {
        (silent, 0.0)
    } else {
        (&run.rows[muted], run.rows[muted - 1].dropped_s)
    };
    Some(muted.time_s - run.block_s - dropped_s - at)
}
