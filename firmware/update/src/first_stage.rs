//! Decision of the first stage after each reset: swap, check, and start of the slot.
//!
//! | state | action | started image |
//! |---|---|---|
//! | confirmed, or rolled back | the image's checksum is checked | the image in the slot |
//! | marked | swap, then check of checksum, digest and signature | the new image on trial; if a check fails, the former one |
//! | on trial, and reset again | swap back | the former image |
//! | the slot is damaged | the image in the store is swapped in, if it is complete and signed | that image, on trial |
//!
//! After a power cut during a swap, the swap is completed. A word whose write was cut may read as
//! old, new or zero (the flash driver returns zeros for a word that its error correction cannot
//! read). Each word of the state is written after the step that it records, so that either reading
//! is correct.

use embassy_boot::{BlockingFirmwareState, BootLoader, BootLoaderConfig, State};
use embedded_storage::nor_flash::NorFlash;

use crate::check::{Depth, Target};

/// Number of bytes copied at once.
const PIECE_BYTES: usize = 256;
/// Size of the unit of writing of the flash, bytes.
const WORD_BYTES: usize = 8;
/// Largest number of attempts: swap, swap back, the image of the store, and back from that.
const MAX_ATTEMPTS: usize = 4;
/// Word of `embassy-boot` for a swap, which its [`State`] does not export.
const SWAP_WORD: [u8; WORD_BYTES] = [0xf0; WORD_BYTES];

/// Decision of the first stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    /// Start the image in the slot.
    Start,
    /// No image can be started.
    Nothing,
}

/// Performs the pending actions and decides. The three flashes must never fail to read: damaged
/// words may read as any value.
pub fn decide<A: NorFlash, D: NorFlash, S: NorFlash>(slot: &mut A, store: &mut D, state: &mut S, target: &Target) -> Decision {
    for _ in 0..MAX_ATTEMPTS {
        let mut piece = [0; PIECE_BYTES];
        let config = BootLoaderConfig { active: &mut *slot, dfu: &mut *store, state: &mut *state };
        // After a refused erase or write, the next attempt continues, because the progress is
        // stored.
        let Ok(found) = BootLoader::new(config).prepare_boot(&mut piece) else { continue };
        let depth = if found == State::Swap { Depth::Signature } else { Depth::Checksum };
        if target.image(slot, 0, depth).is_ok() {
            return Decision::Start;
        }
        // On trial: the next attempt restores the former image. Otherwise the slot is damaged.
        if found != State::Swap && !rescue(store, state, target) {
            return Decision::Nothing;
        }
    }
    Decision::Nothing
}

/// Marks the image in the store, if it may be started. Returns `true` if it is marked. After a swap
/// the former image is one page further on.
fn rescue<D: NorFlash, S: NorFlash>(store: &mut D, state: &mut S, target: &Target) -> bool {
    let page = D::ERASE_SIZE as u32;
    if target.image(store, 0, Depth::Signature).is_ok() {
        let mut word = [0; WORD_BYTES];
        return BlockingFirmwareState::new(state, &mut word).mark_updated().is_ok();
    }
    if target.image(store, page, Depth::Signature).is_err() {
        return false;
    }
    // Write the state after a completed swap: the progress of all its steps, and the mark last.
    let pages = store.capacity() as u32 / page - 1;
    let done = [0; WORD_BYTES];
    state.erase(0, state.capacity() as u32).is_ok()
        && (0..2 * pages).all(|step| state.write((2 + step) * WORD_BYTES as u32, &done).is_ok())
        && state.write(0, &SWAP_WORD).is_ok()
}
