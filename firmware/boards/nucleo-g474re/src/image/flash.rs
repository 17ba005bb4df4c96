//! Flash areas that are written while the board runs: the settings and the areas of an update.
//! RM0440 3.3 (flash of category 3).
//!
//! The flash is written in double words, once after each erase. Erasing a page takes 22 ms
//! (DS12288), while the code continues from the first bank. If the option bytes select one bank
//! instead of two, nothing is written, because an erase would stall the block interrupt.
//!
//! If power fails during a write, the word later reads as an error of two bits, which raises the
//! non-maskable interrupt (`alarm.rs`). That read then fails, or returns zeros if the reader has
//! its own checksums. The processor continues.
//!
//! The data cache is off while the flash is open: reading one bank while the other is written or
//! erased may leave wrong data in the cache (ES0430 2.2.2). The cache is reset before it is enabled
//! again, because it may hold the former contents of the pages.
#![expect(unsafe_code, reason = "the flash is written and read at its addresses")]

use core::ptr;
use core::sync::atomic::{AtomicBool, Ordering, compiler_fence};

use boards_common::area::Area;
use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};
use nucleo_g474re::pages::{FLASH as FIRST_BANK, PAGE, SECOND_BANK, SETTINGS, WORD};
use stm32_metapac::FLASH;
use stm32_metapac::flash::regs::Sr;

use super::watchdog::keep_alive;

/// Number of pages of a bank (RM0440 3.3.1).
const PAGES_PER_BANK: u32 = (SECOND_BANK - FIRST_BANK) / PAGE;
/// Keys for FLASH_KEYR (3.7.3).
const UNLOCK_KEYS: [u32; 2] = [0x4567_0123, 0xcdef_89ab];

/// `true` if a read has found an uncorrectable word since this was last cleared.
static DAMAGED: AtomicBool = AtomicBool::new(false);

/// Error of a flash access.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlashError {
    /// The access exceeds the end of the area.
    Beyond,
    /// The access is not aligned to pages or words.
    Unaligned,
    /// A word cannot be read.
    Damaged,
    /// The flash has refused or failed the operation.
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

/// Marks the current read as failed. Called when the non-maskable interrupt reports an
/// uncorrectable word.
pub fn mark_damaged() {
    DAMAGED.store(true, Ordering::Relaxed);
}

/// Pages of an area of the flash.
#[derive(Clone, Copy)]
pub struct Pages {
    area: Area,
    damage: Damage,
}

/// Result of reading an uncorrectable word.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Damage {
    /// The read fails.
    Fails,
    /// The word reads as zeros: its reader checks a checksum, or accepts any value.
    Zeros,
}

impl Pages {
    /// Pages of the settings.
    pub const SETTINGS: Pages = Pages::new(SETTINGS, Damage::Fails);

    /// Creates the pages of an area.
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
        // Reading all pages takes longer than the period of the watchdog.
        keep_alive();
        let at = self.area.address(offset, bytes.len() as u32, 1).ok_or(FlashError::Beyond)?;
        let words = bytes.chunks_mut(WORD as usize).zip((at..).step_by(WORD as usize));
        for (word, at) in words {
            DAMAGED.store(false, Ordering::Relaxed);
            for (byte, at) in word.iter_mut().zip(at..) {
                // SAFETY: the address is within the area, which is always mapped; volatile, because
                // erases and the hardware change it too.
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
        let _open = Open::unlock()?;
        for page in (at..at + length).step_by(PAGE as usize) {
            // RM0440 3.3.6: FLASH_CR.PER, BKER, PNB, then STRT (3.7.5).
            FLASH.cr().modify(|w| {
                w.set_per(true);
                w.set_bker(page >= SECOND_BANK);
                w.set_pnb(((page - FIRST_BANK) / PAGE % PAGES_PER_BANK) as u8);
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
        let _open = Open::unlock()?;
        let (words, _) = bytes.as_chunks::<{ WORD as usize }>();
        for (word, at) in words.iter().zip((at..).step_by(WORD as usize)) {
            let [a, b, c, d, e, f, g, h] = *word;
            let (low, high) = (u32::from_le_bytes([a, b, c, d]), u32::from_le_bytes([e, f, g, h]));
            // RM0440 3.3.7: FLASH_CR.PG, then the two halves of a double word.
            FLASH.cr().modify(|w| w.set_pg(true));
            // SAFETY: two aligned words within the area, which contains no running code and no
            // reference; the flash is open for it.
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

/// The flash while it is unlocked, with its data cache off; dropping this value restores both.
struct Open;

impl Open {
    /// Waits for the current operation, clears old errors, unlocks the flash and switches the data
    /// cache off.
    ///
    /// FLASH_SR (3.7.4), FLASH_KEYR (3.7.3). Fails unless there are two banks: FLASH_OPTR.DBANK.
    fn unlock() -> Result<Self, FlashError> {
        if !FLASH.optr().read().dbank() {
            return Err(FlashError::Refused);
        }
        while FLASH.sr().read().bsy() {
            keep_alive();
        }
        FLASH.sr().write_value(errors());
        if FLASH.cr().read().lock() {
            UNLOCK_KEYS.into_iter().for_each(|key| FLASH.keyr().write_value(key));
        }
        if FLASH.cr().read().lock() {
            return Err(FlashError::Refused);
        }
        // FLASH_ACR.DCEN (3.7.1): see the module documentation.
        FLASH.acr().modify(|w| w.set_dcen(false));
        Ok(Open)
    }
}

impl Drop for Open {
    fn drop(&mut self) {
        FLASH.cr().modify(|w| w.set_lock(true));
        // FLASH_ACR.DCRST, which requires the cache to be off (3.7.1).
        FLASH.acr().modify(|w| w.set_dcrst(true));
        FLASH.acr().modify(|w| w.set_dcrst(false));
        FLASH.acr().modify(|w| w.set_dcen(true));
    }
}

/// Waits until the flash is done and returns the result: FLASH_SR.BSY and its errors (3.7.4).
fn finish() -> Result<(), FlashError> {
    while FLASH.sr().read().bsy() {
        keep_alive();
    }
    let failed = FLASH.sr().read().0 & errors().0 != 0;
    FLASH.sr().write_value(errors());
    if failed { Err(FlashError::Refused) } else { Ok(()) }
}

/// Returns the error flags of FLASH_SR.
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
