//! The fault log: the last faults, with the values played and measured at each.

use serde::{Deserialize, Serialize};

use crate::board::start::Start;
use crate::seam::fault::Fault;
use crate::seam::mode::Mode;
use crate::seam::phasor::Phasor;
use crate::seam::telemetry::Telemetry;
use crate::seam::units::{Hertz, Volts};

/// Number of faults in the log.
pub const LOGGED_FAULTS: usize = 8;

/// A fault of the log, with the report of the block that raised it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FaultEntry {
    /// Number of the block.
    pub block: u32,
    /// The fault that was raised.
    pub fault: Fault,
    /// Mode of the controller when the fault was raised.
    pub mode: Mode,
    /// `true` if the tracker was locked when the fault was raised.
    pub locked: bool,
    /// Frequency of the last codes that were returned before the fault.
    pub frequency: Hertz,
    /// Peak voltage of these codes, before the envelope.
    pub drive: Volts,
    /// Mean envelope of these codes, 0 to 1.
    pub envelope: f32,
    /// Voltage phasor of the measured block, V peak.
    pub v: Phasor,
    /// Current phasor of the measured block, A peak.
    pub i: Phasor,
    /// Motional current of the measured block, A peak.
    pub motional_current: Phasor,
}

/// Answer to a request for a fault of the log.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FaultReport {
    /// Faults since the board was started, up to 65 535.
    pub count: u16,
    /// Requested fault; `None` if there were fewer, or if the log has dropped it.
    pub entry: Option<FaultEntry>,
    /// Cause of the last start.
    pub last_run: Start,
}

/// The last faults. A reset clears the log; the cause of a reset is in [`Start`].
#[derive(Clone, Debug, Default)]
pub(crate) struct FaultLog {
    entries: heapless::HistoryBuf<FaultEntry, LOGGED_FAULTS>,
    count: u16,
}

impl FaultLog {
    /// Records a new fault in the report of a block; `before` is the last report that came before
    /// it.
    pub(crate) fn record(&mut self, report: &Telemetry, before: Option<&Telemetry>) {
        let Some(fault) = report.fault else { return };
        if before.and_then(|before| before.fault) == Some(fault) {
            return;
        }
        let played = before.unwrap_or(report);
        self.count = self.count.saturating_add(1);
        self.entries.write(FaultEntry {
            block: report.block,
            fault,
            mode: played.mode,
            locked: played.locked,
            frequency: played.frequency,
            drive: played.drive,
            envelope: played.envelope,
            v: report.v,
            i: report.i,
            motional_current: report.motional_current,
        });
    }

    /// Returns a fault, by the number of later faults, and the cause of the last start.
    pub(crate) fn report(&self, later: u8, last_run: Start) -> FaultReport {
        let entry = self.entries.oldest_ordered().rev().nth(later.into()).copied();
        FaultReport { count: self.count, entry, last_run }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_log_has_the_last_faults_and_the_count_of_all() {
        let mut log = FaultLog::default();
        let mut before = None;
        for n in 0..2 * LOGGED_FAULTS as u32 + 3 {
            // Each fault follows a block without one, and lasts for three blocks.
            for (k, fault) in
                [None, Some(Fault::OverCurrent), Some(Fault::OverCurrent), Some(Fault::OverCurrent)].into_iter().enumerate()
            {
                let mode = if fault.is_some() { Mode::Fault } else { Mode::Run };
                let report = Telemetry {
                    block: 10 * n + k as u32,
                    drive: Volts(if k == 0 { 3.0 } else { 0.0 }),
                    fault,
                    mode,
                    ..Default::default()
                };
                log.record(&report, before.as_ref());
                before = Some(report);
            }
        }
        let count = 2 * LOGGED_FAULTS as u16 + 3;
        for later in 0..LOGGED_FAULTS as u8 {
            let report = log.report(later, Start::Watchdog);
            let entry = report.entry.expect("an entry of the log");
            assert_eq!((report.count, report.last_run), (count, Start::Watchdog));
            assert_eq!(entry.block, 10 * (u32::from(count) - 1 - u32::from(later)) + 1);
            assert_eq!((entry.mode, entry.drive, entry.fault), (Mode::Run, Volts(3.0), Fault::OverCurrent));
        }
        assert_eq!(log.report(LOGGED_FAULTS as u8, Start::Pin).entry, None);
    }

    #[test]
    fn a_different_fault_is_logged_and_its_end_is_not() {
        let mut log = FaultLog::default();
        assert_eq!(log.report(0, Start::PowerOn), FaultReport { count: 0, entry: None, last_run: Start::PowerOn });
        let with = |fault| Telemetry { fault, ..Default::default() };
        log.record(&with(Some(Fault::LateBlock)), None);
        log.record(&with(Some(Fault::HostLost)), Some(&with(Some(Fault::LateBlock))));
        log.record(&with(None), Some(&with(Some(Fault::HostLost))));
        assert_eq!(
            (log.report(0, Start::Pin).count, log.report(0, Start::Pin).entry.map(|entry| entry.fault)),
            (2, Some(Fault::HostLost))
        );
    }
}
