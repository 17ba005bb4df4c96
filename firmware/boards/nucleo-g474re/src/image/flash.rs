//! Parts of the flash that are written while the board runs: the settings, and what an update needs. RM0440 3.3 (flash of category 3).
//!
//! Written in double words, once after each erase; a page is erased in 22 ms (DS12288), while the code goes on from the first bank. If the option
//! bytes make one bank of the two, nothing is written: an erase would stall the block interrupt.
//!
//! A word whose write was cut by power reads as an error of two bits, which raises the non-maskable interrupt (`alarm.rs`): that read fails, or gives
//! zeros where the reader has checksums of its own, and the processor goes on.
//!
//! The data cache is off while the flash is open: a read of one bank while the other one is written or erased may leave wrong data in it (ES0430
//! 2.2.2). It is reset before it is on again, because it may hold what the pages held before.
#![expect(unsafe_code, reason = "the flash is written and read at its addresses")]

use core::ptr;
use core::sync::atomic::{AtomicBool, Ordering, compiler_fence};

use boards_common::area::Area;
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};
use nucleo_g474re::pages::{FLASH as FIRST_BANK, PAGE, SECOND_BANK, SETTINGS, WORD};
use stm32_metapac::FLASH;
use stm32_metapac::flash::regs::Sr;

use super::watchdog::nurse;

/// Pages of a bank (RM0440 3.3.1).
const PAGES_OF_A_BANK: u32 = (SECOND_BANK - FIRST_BANK) / PAGE;
/// FLASH_KEYR (3.7.3).
const KEYS: [u32; 2] = [0x4567_0123, 0xcdef_89ab];

/// A read since the last look has met a word that cannot be corrected.
static DAMAGED: AtomicBool = AtomicBool::new(false);

/// What has failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlashError {
    /// Beyond the end.
    Beyond,
    /// Not on the grid of pages or words.
    Unaligned,
    /// A word that cannot be read.
    Damaged,
    /// The flash has refused.
    Refused,
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            FlashError::Beyond => NorFlashErrorKind::OutOfBounds,
            FlashError::Unaligned => NorFlashErrorKind::NotAligned,
            FlashError::Damaged | FlashError::Refused => NorFlashErrorKind::Other,
        }
    }
}

/// Marks the read that is under way as failed: the non-maskable interrupt has found a word that cannot be corrected.
pub fn mark_damaged() {
    DAMAGED.store(true, Ordering::Relaxed);
}

/// Pages of the flash.
#[derive(Clone, Copy)]
pub struct Pages {
    area: Area,
    damage: Damage,
}

/// What the read of a word gives that cannot be corrected.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Damage {
    /// The read fails.
    Fails,
    /// The word reads as zeros: its reader has a checksum over it, or takes any value.
    Zeros,
}

impl Pages {
    /// The pages of the settings.
    pub const SETTINGS: Pages = Pages::new(SETTINGS, Damage::Fails);

    /// Pages of an area.
    pub const fn new(area: Area, damage: Damage) -> Self {
        Pages { area, damage }
    }
}

impl ErrorType for Pages {
    type Error = FlashError;
}

impl ReadNorFlash for Pages {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        // Looking through all pages takes longer than the watchdog waits.
        nurse();
        let at = self.area.address(offset, bytes.len() as u32, 1).ok_or(FlashError::Beyond)?;
        let words = bytes.chunks_mut(WORD as usize).zip((at..).step_by(WORD as usize));
        for (word, at) in words {
            DAMAGED.store(false, Ordering::Relaxed);
            for (byte, at) in word.iter_mut().zip(at..) {
                // SAFETY: within the area, which is always mapped; volatile, because it changes by other means than writes.
                *byte = unsafe { ptr::read_volatile(at as *const u8) };
            }
            compiler_fence(Ordering::SeqCst);
            if DAMAGED.load(Ordering::Relaxed) {
                if self.damage == Damage::Fails {
                    return Err(FlashError::Damaged);
                }
                word.fill(0);
            }
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.area.size as usize
    }
}

impl NorFlash for Pages {
    const WRITE_SIZE: usize = WORD as usize;
    const ERASE_SIZE: usize = PAGE as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        let length = to.checked_sub(from).ok_or(FlashError::Beyond)?;
        let at = self.area.address(from, length, PAGE).ok_or(FlashError::Unaligned)?;
        let _open = Open::now()?;
        for page in (at..at + length).step_by(PAGE as usize) {
            // RM0440 3.3.6: FLASH_CR.PER, BKER, PNB, then STRT (3.7.5).
            FLASH.cr().modify(|w| {
                w.set_per(true);
                w.set_bker(page >= SECOND_BANK);
                w.set_pnb(((page - FIRST_BANK) / PAGE % PAGES_OF_A_BANK) as u8);
            });
            FLASH.cr().modify(|w| w.set_strt(true));
            let done = finish();
            FLASH.cr().modify(|w| w.set_per(false));
            done?;
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        let at = self.area.address(offset, bytes.len() as u32, WORD).ok_or(FlashError::Unaligned)?;
        let _open = Open::now()?;
        let (words, _) = bytes.as_chunks::<{ WORD as usize }>();
        for (word, at) in words.iter().zip((at..).step_by(WORD as usize)) {
            let [a, b, c, d, e, f, g, h] = *word;
            let (low, high) = (u32::from_le_bytes([a, b, c, d]), u32::from_le_bytes([e, f, g, h]));
            // RM0440 3.3.7: FLASH_CR.PG, then the two halves of a double word.
            FLASH.cr().modify(|w| w.set_pg(true));
            // SAFETY: two aligned words within the area, which no code that runs and no reference is in; the flash is open for it.
            unsafe {
                ptr::write_volatile(at as *mut u32, low);
                ptr::write_volatile((at + 4) as *mut u32, high);
            }
            let done = finish();
            FLASH.cr().modify(|w| w.set_pg(false));
            done?;
        }
        Ok(())
    }
}

/// The flash, unlocked and without its data cache until this is dropped.
struct Open;

impl Open {
    /// Waits for what is under way, clears old errors, unlocks and switches the data cache off: FLASH_SR (3.7.4), FLASH_KEYR (3.7.3). Only with two banks: FLASH_OPTR.DBANK (3.7.7).
    fn now() -> Result<Self, FlashError> {
        if !FLASH.optr().read().dbank() {
            return Err(FlashError::Refused);
        }
        while FLASH.sr().read().bsy() {
            nurse();
        }
        FLASH.sr().write_value(errors());
        if FLASH.cr().read().lock() {
            KEYS.into_iter().for_each(|key| FLASH.keyr().write_value(key));
        }
        if FLASH.cr().read().lock() {
            return Err(FlashError::Refused);
        }
        // FLASH_ACR.DCEN (3.7.1): see above.
        FLASH.acr().modify(|w| w.set_dcen(false));
        Ok(Open)
    }
}

impl Drop for Open {
    fn drop(&mut self) {
        FLASH.cr().modify(|w| w.set_lock(true));
        // FLASH_ACR.DCRST, which wants the cache off (3.7.1).
        FLASH.acr().modify(|w| w.set_dcrst(true));
        FLASH.acr().modify(|w| w.set_dcrst(false));
        FLASH.acr().modify(|w| w.set_dcen(true));
    }
}

/// Waits until the flash is done, and says how it went: FLASH_SR.BSY and its errors (3.7.4).
fn finish() -> Result<(), FlashError> {
    while FLASH.sr().read().bsy() {
        nurse();
    }
    let failed = FLASH.sr().read().0 & errors().0 != 0;
    FLASH.sr().write_value(errors());
    if failed { Err(FlashError::Refused) } else { Ok(()) }
}

/// The flags of failure.
fn errors() -> Sr {
    let mut flags = Sr(0);
    flags.set_operr(true);
    flags.set_progerr(true);
    flags.set_wrperr(true);
    flags.set_pgaerr(true);
    flags.set_sizerr(true);
    flags.set_pgserr(true);
    flags.set_miserr(true);
    flags.set_fasterr(true);
    flags
}
