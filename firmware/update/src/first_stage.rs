//! The first stage's decision after each reset: what is swapped, what is checked, whether the slot is started.
//!
//! | state | done | started |
//! |---|---|---|
//! | confirmed, or brought back | the image's checksum | the image |
//! | marked | swap, then checksum, digest and signature | the new image on trial; where that is not as it must be, the former one |
//! | on trial, and reset again | swapped back | the former image |
//! | the slot is damaged | the store's image is taken, where it is whole and signed | that one, on trial |
//!
//! A power cut within a swap is followed by the rest of it. A word that was cut reads as it happens to (the flash driver gives zeros for what its error
//! correction cannot read): each word of the state is written after what it stands for, so that both readings are right.

use embassy_boot::{BlockingFirmwareState, BootLoader, BootLoaderConfig, State};
use embedded_storage::nor_flash::NorFlash;

use crate::check::{Depth, Target};

/// Bytes that are copied at once.
const PIECE: usize = 256;
/// Bytes that the flash writes at once.
const WORD: usize = 8;
/// What is tried until nothing more can be: swap, back, the store's image, and back from that.
const ATTEMPTS: usize = 4;
/// The word of `embassy-boot` for a swap, of which [`State`] gives the name only.
const SWAP: [u8; WORD] = [0xf0; WORD];

/// What the first stage has decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    /// The image in the slot is started.
    Start,
    /// There is no image that could be started.
    Nothing,
}

/// Does what is due, and decides. The three flashes never fail to read: what is damaged reads as anything.
pub fn decide<A: NorFlash, D: NorFlash, S: NorFlash>(slot: &mut A, store: &mut D, state: &mut S, target: &Target) -> Decision {
    for _ in 0..ATTEMPTS {
        let mut piece = [0; PIECE];
        let config = BootLoaderConfig { active: &mut *slot, dfu: &mut *store, state: &mut *state };
        // A flash that refuses an erase or a word is tried again: the progress is stored.
        let Ok(found) = BootLoader::new(config).prepare_boot(&mut piece) else { continue };
        let depth = if found == State::Swap { Depth::Signature } else { Depth::Checksum };
        if target.image(slot, 0, depth).is_ok() {
            return Decision::Start;
        }
        // On trial: the next turn brings the former image back. Otherwise the slot is damaged.
        if found != State::Swap && !rescue(store, state, target) {
            return Decision::Nothing;
        }
    }
    Decision::Nothing
}

/// Marks what the store holds, if it is an image that may be started; returns whether it is. After a swap the former image stands a page further.
fn rescue<D: NorFlash, S: NorFlash>(store: &mut D, state: &mut S, target: &Target) -> bool {
    let page = D::ERASE_SIZE as u32;
    if target.image(store, 0, Depth::Signature).is_ok() {
        let mut word = [0; WORD];
        return BlockingFirmwareState::new(state, &mut word).mark_updated().is_ok();
    }
    if target.image(store, page, Depth::Signature).is_err() {
        return false;
    }
    // As if the swap had just ended: progress of all its steps, and the mark at last.
    let pages = store.capacity() as u32 / page - 1;
    let done = [0; WORD];
    state.erase(0, state.capacity() as u32).is_ok()
        && (0..2 * pages).all(|step| state.write((2 + step) * WORD as u32, &done).is_ok())
        && state.write(0, &SWAP).is_ok()
}
