//! Receiver of updates in the running image: stores the data of the host, checks it, and marks it
//! for start.

use embassy_boot::{BlockingFirmwareState, State};
use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use firmware::board::update::{CHUNK, Chunk, Standing, UpdateDefect as Defect, UpdateReport, UpdateState, UpdateVerb, Updates};
use firmware::seam::refusal::Refusal;

use crate::check::{Depth, Target};
use crate::key::DEVELOPMENT;
use crate::manifest::MANIFEST;

/// Largest unit of writing of the state's flash, bytes.
const MAX_WORD_BYTES: usize = 8;

/// Receiver of updates: their storage and their requirements.
pub struct Receiver<S, T> {
    store: S,
    state: T,
    target: Target,
    /// Protocol of the running image. An update with an older one is refused.
    protocol: u8,
    /// Returns `true` while a person at the board confirms an older version, by a held button.
    is_confirmed: fn() -> bool,
    /// `true` if the update may be older than the running image, as confirmed at its beginning.
    may_be_older: bool,
    /// Version of the running image: the lowest one that is accepted. The slot holds the image that
    /// was confirmed last, so that no second record of it can be lost.
    running: Option<[u16; 3]>,
    standing: Standing,
    update: UpdateState,
    /// Length of the update as announced by the host, bytes.
    length: u32,
}

impl<S: NorFlash, T: NorFlash> Receiver<S, T> {
    /// Creates a receiver that stores updates in `store` and marks them in the first stage's
    /// `state`. `slot` holds the running image. An older version is accepted only if `is_confirmed`
    /// returns `true` when the update begins.
    pub fn new<R: ReadNorFlash>(
        store: S,
        mut state: T,
        mut slot: R,
        target: Target,
        protocol: u8,
        is_confirmed: fn() -> bool,
    ) -> Self {
        let running = target.manifest(&mut slot, 0).ok().map(|manifest| manifest.identity.version);
        let standing = match standing(&mut state) {
            Some(State::Swap) => Standing::Trial,
            Some(State::Revert) => Standing::RolledBack,
            _ => Standing::Confirmed,
        };
        let (may_be_older, update, length) = (false, UpdateState::Nothing, 0);
        Receiver { store, state, target, protocol, is_confirmed, may_be_older, running, standing, update, length }
    }

    /// Returns the flashes.
    pub fn release(self) -> (S, T) {
        (self.store, self.state)
    }

    fn begin(&mut self, length: u32) -> Result<(), Refusal> {
        // While an image is on trial, the store holds its predecessor.
        if self.standing == Standing::Trial {
            return Err(Refusal::Busy);
        }
        self.length = length;
        self.may_be_older = (self.is_confirmed)();
        let room = self.room();
        let fits = (MANIFEST as u32 + 1..=room).contains(&length);
        self.update = if fits { UpdateState::Receiving(0) } else { UpdateState::Refused(Defect::Length(length)) };
        Ok(())
    }

    fn room(&self) -> u32 {
        self.target.room + MANIFEST as u32
    }

    fn write(&mut self, at: u32, chunk: &Chunk) -> Result<(), Refusal> {
        // A repeated chunk whose answer was lost.
        if matches!(self.update, UpdateState::Receiving(received) if at + CHUNK as u32 == received) {
            return Ok(());
        }
        if self.update != UpdateState::Receiving(at) || at >= self.length {
            return Err(Refusal::OutOfRange);
        }
        let page = S::ERASE_SIZE as u32;
        let erased = if at.is_multiple_of(page) { self.store.erase(at, at + page) } else { Ok(()) };
        if erased.and_then(|()| self.store.write(at, chunk.as_flattened())).is_err() {
            self.update = UpdateState::FlashFailed;
            return Err(Refusal::Flash);
        }
        let received = at + CHUNK as u32;
        self.update = UpdateState::Receiving(received);
        // The manifest decides whether the rest is needed.
        if received == MANIFEST as u32
            && let Err(defect) = self.manifest()
        {
            self.update = UpdateState::Refused(defect);
        }
        Ok(())
    }

    fn manifest(&mut self) -> Result<(), Defect> {
        let manifest = self.target.manifest(&mut self.store, 0)?;
        if manifest.identity.protocol < self.protocol {
            return Err(Defect::OlderProtocol(manifest.identity.protocol));
        }
        let offered = manifest.identity.version;
        if let Some(running) = self.running.filter(|running| offered < *running && !self.may_be_older) {
            return Err(Defect::OlderVersion { running, offered });
        }
        if manifest.length != self.length - MANIFEST as u32 { Err(Defect::Length(manifest.length)) } else { Ok(()) }
    }

    fn check(&mut self) -> Result<(), Refusal> {
        match self.update {
            UpdateState::Receiving(received) if received >= self.length && self.length > 0 => {
                self.update = UpdateState::Checking;
                Ok(())
            }
            // A repeated order that was already obeyed.
            UpdateState::Checking | UpdateState::Complete | UpdateState::Refused(_) => Ok(()),
            _ => Err(Refusal::OutOfRange),
        }
    }

    fn install(&mut self) -> Result<(), Refusal> {
        match self.update {
            UpdateState::Marked => return Ok(()),
            UpdateState::Complete => {}
            _ => return Err(Refusal::OutOfRange),
        }
        let mut word = [0; MAX_WORD_BYTES];
        if BlockingFirmwareState::new(&mut self.state, &mut word[..T::WRITE_SIZE]).mark_updated().is_err() {
            self.update = UpdateState::FlashFailed;
            return Err(Refusal::Flash);
        }
        self.update = UpdateState::Marked;
        Ok(())
    }
}

/// Returns the state that the first stage has stored, or `None` if it cannot be read.
fn standing<T: NorFlash>(state: &mut T) -> Option<State> {
    let mut word = [0; MAX_WORD_BYTES];
    BlockingFirmwareState::new(state, &mut word[..T::WRITE_SIZE]).get_state().ok()
}

impl<S: NorFlash, T: NorFlash> Updates for Receiver<S, T> {
    fn report(&mut self) -> UpdateReport {
        UpdateReport {
            state: self.update,
            standing: self.standing,
            running: self.running,
            room: self.room(),
            option_bytes: 0,
            accepts_development_key: self.target.keys.contains(&DEVELOPMENT),
        }
    }

    fn obey(&mut self, verb: &UpdateVerb) -> Result<(), Refusal> {
        match verb {
            UpdateVerb::Report => Ok(()),
            UpdateVerb::Begin(length) => self.begin(*length),
            UpdateVerb::Write(at, chunk) => self.write(*at, chunk),
            UpdateVerb::Check => self.check(),
            UpdateVerb::Install => self.install(),
        }
    }

    fn work(&mut self) {
        if self.update != UpdateState::Checking {
            return;
        }
        let checked = self.manifest().and_then(|()| self.target.image(&mut self.store, 0, Depth::Signature).map(drop));
        self.update = checked.map_or_else(UpdateState::Refused, |()| UpdateState::Complete);
    }

    fn confirm(&mut self) {
        if self.standing != Standing::Trial {
            return;
        }
        let mut word = [0; MAX_WORD_BYTES];
        if BlockingFirmwareState::new(&mut self.state, &mut word[..T::WRITE_SIZE]).mark_booted().is_ok() {
            self.standing = Standing::Confirmed;
        }
    }
}
