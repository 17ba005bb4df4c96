//! The fault log: what the last faults were, and what was heard with each.

use serde::{Deserialize, Serialize};

use crate::board::start::Start;
use crate::seam::fault::Fault;
use crate::seam::mode::Mode;
use crate::seam::phasor::Phasor;
use crate::seam::telemetry::Telemetry;
use crate::seam::units::{Hertz, Volts};

/// Faults that are kept.
pub const KEPT_FAULTS: usize = 8;

/// A fault, with what the block reported that brought it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FaultEntry {
    /// The block.
    pub block: u32,
    /// The fault.
    pub fault: Fault,
    /// What the controller was doing when it came.
    pub mode: Mode,
    /// Whether the tracker was locked then.
    pub locked: bool,
    /// Frequency of the codes that were returned last before it.
    pub frequency: Hertz,
    /// Their peak voltage, before the envelope.
    pub drive: Volts,
    /// Their mean envelope, 0 to 1.
    pub envelope: f32,
    /// Voltage phasor of the block heard, V peak.
    pub v: Phasor,
    /// Its current phasor, A peak.
    pub i: Phasor,
    /// Its motional current, A peak.
    pub motional_current: Phasor,
}

/// A fault of the log, with what stands around it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FaultReport {
    /// Faults since the board was started, up to 65 535.
    pub count: u16,
    /// The one that was asked for; nothing where there were not so many, or where it is not kept any more.
    pub entry: Option<FaultEntry>,
    /// What started the board.
    pub last_run: Start,
}

/// The last faults. A reset forgets them; what a reset was for is in [`Start`].
#[derive(Clone, Debug, Default)]
pub(crate) struct FaultLog {
    entries: heapless::HistoryBuf<FaultEntry, KEPT_FAULTS>,
    count: u16,
}

impl FaultLog {
    /// Takes the report of a block, and that of the one before it, as far as they have come here.
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

    /// A fault by how many came after it, beside what started the board.
    pub(crate) fn report(&self, later: u8, last_run: Start) -> FaultReport {
        let entry = self.entries.oldest_ordered().rev().nth(later.into()).copied();
        FaultReport { count: self.count, entry, last_run }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_faults_are_kept_newest_first_and_all_are_counted() {
        let mut log = FaultLog::default();
        let mut before = None;
        for n in 0..2 * KEPT_FAULTS as u32 + 3 {
            // Each comes after a block without, and lasts for three.
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
        let count = 2 * KEPT_FAULTS as u16 + 3;
        for later in 0..KEPT_FAULTS as u8 {
            let report = log.report(later, Start::Watchdog);
            let entry = report.entry.expect("one that is kept");
            assert_eq!((report.count, report.last_run), (count, Start::Watchdog));
            assert_eq!(entry.block, 10 * (u32::from(count) - 1 - u32::from(later)) + 1);
            assert_eq!((entry.mode, entry.drive, entry.fault), (Mode::Run, Volts(3.0), Fault::OverCurrent));
        }
        assert_eq!(log.report(KEPT_FAULTS as u8, Start::Pin).entry, None);
    }

    #[test]
    fn another_fault_in_place_of_one_is_a_fault_and_none_is_none() {
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
