//! Simulated board that consists only of flash: a first stage, an image that receives updates, and
//! a host.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::OnceLock;
use std::vec::Vec;

use firmware::board::update::{CHUNK, Standing, UpdateState, UpdateVerb, Updates as _};
use firmware::seam::refusal::Refusal;

use super::flash::{Area, DamagedRead, FlashPart, PAGE_BYTES};
use crate::check::{Depth, Target};
use crate::first_stage::{Decision, decide};
use crate::identity::{Identity, board};
use crate::key::{DEVELOPMENT, DEVELOPMENT_SEED};
use crate::manifest::{MANIFEST, Manifest};
use crate::receive::Receiver;

/// Number of pages of the slot; the store has one more.
pub const SLOT_PAGES: usize = 5;
pub const ORIGIN: u32 = 0x0800_4200;
pub const PROTOCOL: u8 = 2;
/// Length of both images, bytes: most of the slot, and not a whole number of words.
const IMAGE_BYTES: usize = SLOT_PAGES * PAGE_BYTES - MANIFEST - 77;

/// Returns the requirements of the board.
pub fn target() -> Target {
    let room = (SLOT_PAGES * PAGE_BYTES - MANIFEST) as u32;
    Target { board: board("test-board"), origin: ORIGIN, room, keys: &[DEVELOPMENT] }
}

/// Returns an image of this version and its manifest without a signature.
pub fn image(version: u16) -> (Manifest, Vec<u8>) {
    let bytes: Vec<u8> = (0..IMAGE_BYTES).map(|n| (n * usize::from(version) % 251) as u8).collect();
    let identity = Identity { board: board("test-board"), version: [0, 0, version], protocol: PROTOCOL };
    (Manifest::of(identity, ORIGIN, &bytes), bytes)
}

/// Returns an update file.
pub fn file((manifest, image): (Manifest, Vec<u8>)) -> Vec<u8> {
    [manifest.signed_by(&DEVELOPMENT_SEED).encode().as_slice(), &image].concat()
}

/// Returns the update to this version, 1 to 3; each is signed only once.
pub fn update_to(version: u16) -> &'static [u8] {
    static FILES: OnceLock<[Vec<u8>; 3]> = OnceLock::new();
    &FILES.get_or_init(|| [1, 2, 3].map(|version| file(image(version))))[usize::from(version) - 1]
}

/// Simulated board.
#[derive(Clone, Debug)]
pub struct Board {
    pub part: Rc<RefCell<FlashPart>>,
    /// Returns `true` while the button of the board is held.
    pub is_confirmed: fn() -> bool,
}

impl Board {
    /// Creates a board with an image of version 1 in its slot.
    pub fn new(reads: DamagedRead) -> Self {
        let mut part = FlashPart::new(2 * SLOT_PAGES + 2, reads);
        part.load(0, update_to(1));
        Board { part: Rc::new(RefCell::new(part)), is_confirmed: || false }
    }

    /// Returns an independent board in the same state.
    pub fn copy(&self) -> Self {
        Board { part: Rc::new(RefCell::new(self.part.borrow().clone())), ..*self }
    }

    fn area(&self, page: usize, pages: usize) -> Area {
        Area { part: self.part.clone(), from: page * PAGE_BYTES, size: pages * PAGE_BYTES }
    }

    pub fn slot(&self) -> Area {
        self.area(0, SLOT_PAGES)
    }

    pub fn store(&self) -> Area {
        self.area(SLOT_PAGES, SLOT_PAGES + 1)
    }

    pub fn state(&self) -> Area {
        self.area(2 * SLOT_PAGES + 1, 1)
    }

    /// Resets the board and returns the version that starts. Returns `None` if none starts or if
    /// the power fails.
    pub fn start(&self) -> Option<u16> {
        let decision = decide(&mut self.slot(), &mut self.store(), &mut self.state(), &target());
        if self.part.borrow().is_off() || decision == Decision::Nothing {
            return None;
        }
        let manifest = target().image(&mut self.slot(), 0, Depth::Checksum).expect("a started image is complete");
        Some(manifest.identity.version[2])
    }

    /// Returns the receiver of the running image.
    pub fn receiver(&self) -> Receiver<Area, Area> {
        Receiver::new(self.store(), self.state(), self.slot(), target(), PROTOCOL, self.is_confirmed)
    }

    /// Sends an update, then orders its check and its installation. Returns the final state.
    pub fn update(&self, file: &[u8]) -> Result<UpdateState, Refusal> {
        let mut receiver = self.receiver();
        receiver.obey(&UpdateVerb::Begin(file.len() as u32))?;
        if let state @ UpdateState::Refused(_) = receiver.report().state {
            return Ok(state);
        }
        for (n, piece) in file.chunks(CHUNK).enumerate() {
            let mut chunk = [[0xff; 32]; CHUNK / 32];
            chunk.as_flattened_mut()[..piece.len()].copy_from_slice(piece);
            let write = UpdateVerb::Write((n * CHUNK) as u32, chunk);
            receiver.obey(&write)?;
            if let state @ UpdateState::Refused(_) = receiver.report().state {
                return Ok(state);
            }
            // A repeated chunk, as after a lost answer.
            receiver.obey(&write)?;
        }
        receiver.obey(&UpdateVerb::Check)?;
        receiver.work();
        if receiver.report().state == UpdateState::Complete {
            receiver.obey(&UpdateVerb::Install)?;
        }
        Ok(receiver.report().state)
    }

    /// Confirms the running image, as after a dialogue with the host while blocks are served.
    pub fn confirm(&self) -> Standing {
        let mut receiver = self.receiver();
        receiver.confirm();
        receiver.report().standing
    }
}
