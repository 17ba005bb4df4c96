//! The slow side's end of the trims: what a calibration has found comes in, is kept, and is reported.

use embedded_storage::nor_flash::NorFlash;
use heapless::spsc::{Consumer, Producer};

use crate::command::{Refusal, Reply, TrimReport, Verb};
use crate::config::LaneTrims;
use crate::settings::{Kept, Settings};

/// The trims that act, as far as the slow side knows, and what is kept of them.
pub struct Keeper<'a> {
    found: Consumer<'a, LaneTrims>,
    taken: Producer<'a, LaneTrims>,
    acting: LaneTrims,
    kept: Kept,
}

impl<'a> Keeper<'a> {
    /// A keeper between the two queues. `kept` is what the [settings](Settings::lane_trims) had at power-up, and `acting` what the controller
    /// was built with.
    pub fn new(found: Consumer<'a, LaneTrims>, taken: Producer<'a, LaneTrims>, acting: LaneTrims, kept: Kept) -> Self {
        Keeper { found, taken, acting, kept }
    }

    /// Takes what a calibration has found, and keeps it once the drive is silent.
    pub fn keep<F: NorFlash>(&mut self, silent: bool, settings: &mut Settings<F>) {
        while let Some(found) = self.found.dequeue() {
            (self.acting, self.kept) = (found, Kept::Due);
        }
        if silent && self.kept == Kept::Due {
            // That it was not kept is in the report.
            let _ = self.store(settings);
        }
    }

    /// Obeys a command.
    pub fn obey<F: NorFlash>(&mut self, verb: Verb, silent: bool, settings: &mut Settings<F>) -> Reply {
        let done = match verb {
            Verb::Get(point) => return Reply::Settings(self.report(point)),
            _ if !silent => Err(Refusal::Driving),
            Verb::Store => self.store(settings),
            Verb::Clear => settings.clear().map(|()| self.kept = Kept::Nothing).map_err(|_| Refusal::Flash),
            Verb::Defaults => {
                let taken = self.taken.enqueue(LaneTrims::new()).map_err(|_| Refusal::Busy);
                taken.map(|()| self.acting.clear())
            }
        };
        done.map_or_else(Reply::Nak, |()| Reply::Ack)
    }

    fn store<F: NorFlash>(&mut self, settings: &mut Settings<F>) -> Result<(), Refusal> {
        let stored = settings.store(&self.acting);
        self.kept = match stored {
            Ok(()) if self.acting.is_empty() => Kept::Nothing,
            Ok(()) => Kept::Stored,
            // Not tried again unless it is ordered: that would wear the flash out.
            Err(_) => Kept::Failed,
        };
        stored.map_err(|_| Refusal::Flash)
    }

    fn report(&self, point: u8) -> TrimReport {
        let point = self.acting.get(usize::from(point)).copied();
        TrimReport { kept: self.kept, points: self.acting.len() as u8, point }
    }
}
