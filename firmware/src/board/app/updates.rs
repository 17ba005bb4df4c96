//! Updates within the background task: only in silence, and confirmed once the new image has shown that it can be updated again.

use embedded_hal::digital::{InputPin, OutputPin};
use embedded_io::{Read, ReadReady, Write, WriteReady};
use embedded_storage::nor_flash::NorFlash;

use super::{App, Watchdog};
use crate::board::command::Reply;
use crate::board::update::{UpdateReport, UpdateVerb};
use crate::seam::refusal::Refusal;

/// Blocks that an image on trial must have served: 0.1 s of blocks of 100 us, ten periods of the watchdog.
const SERVED: u32 = 1000;

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
        let option_bytes = self.option_bytes;
        let done = match (&mut self.updates, verb) {
            (None, UpdateVerb::Report) => Ok(UpdateReport::default()),
            (None, _) => Err(Refusal::NotConfigured),
            (Some(updates), UpdateVerb::Report) => Ok(updates.report()),
            (Some(_), _) if !silent => Err(Refusal::Driving),
            (Some(updates), verb) => updates.obey(verb).map(|()| updates.report()),
        };
        done.map_or_else(Reply::Nak, |report| Reply::Update(UpdateReport { option_bytes, ..report }))
    }

    /// Checks what was received, where that was ordered; confirms the running image once it has served blocks and has obeyed a host: then it can be
    /// updated again.
    pub(super) fn tend_updates(&mut self) {
        let (silent, serves) = (self.is_silent(), self.block() >= SERVED && self.obeyed);
        let Some(updates) = self.updates.as_mut().filter(|_| silent) else { return };
        updates.work();
        if serves {
            updates.confirm();
        }
    }
}
