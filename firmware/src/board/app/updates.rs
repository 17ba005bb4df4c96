//! Updates in the background task, in silence only. A new image is confirmed once it has shown that
//! it can be updated again.

use embedded_hal::digital::{InputPin, OutputPin};
use embedded_io::{Read, ReadReady, Write, WriteReady};
use embedded_storage::nor_flash::NorFlash;

use super::{App, Watchdog};
use crate::board::command::Reply;
use crate::board::update::{Standing, UpdateReport, UpdateVerb};
use crate::seam::refusal::Refusal;

/// Number of blocks that an image on trial must have served before it is confirmed: 0.1 s of blocks
/// of 100 us, ten periods of the watchdog.
const MIN_SERVED_BLOCKS: u32 = 1000;

impl<'a, L, E, S, W, F> App<'a, L, E, S, W, F>
where
    L: Read + ReadReady + Write + WriteReady,
    E: OutputPin,
    S: InputPin,
    W: Watchdog,
    F: NorFlash,
{
    /// Obeys an operation on the update.
    pub(super) fn update(&mut self, verb: &UpdateVerb) -> Reply {
        let silent = self.is_silent();
        let option_bytes = self.hardware.option_bytes;
        let done = match (&mut self.updates, verb) {
            (None, UpdateVerb::Report) => Ok(UpdateReport::default()),
            (None, _) => Err(Refusal::NotConfigured),
            (Some(updates), UpdateVerb::Report) => Ok(updates.report()),
            (Some(_), _) if !silent => Err(Refusal::Driving),
            (Some(updates), verb) => updates.obey(verb).map(|()| updates.report()),
        };
        done.map_or_else(Reply::Nak, |report| Reply::Update(UpdateReport { option_bytes, ..report }))
    }

    /// Runs an ordered check of the received update. Confirms the running image once it has served
    /// enough blocks and has obeyed a host, because it can then be updated again.
    pub(super) fn serve_updates(&mut self) {
        let (silent, serves) = (self.is_silent(), self.block() >= MIN_SERVED_BLOCKS && self.host_obeyed);
        let Some(updates) = self.updates.as_mut().filter(|_| silent) else { return };
        updates.work();
        if serves && updates.report().standing == Standing::Trial {
            updates.confirm();
            // The pages that this erases may contain the marker of stored settings.
            self.settings_store.marker_checked = false;
        }
    }
}
