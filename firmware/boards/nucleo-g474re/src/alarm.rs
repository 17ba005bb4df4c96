//! What the non-maskable interrupt of the part says: its three sources are distinguished by their flags.
//!
//! RM0440 14.1.3 (interrupt vectors): the interrupt is raised by a failed crystal (clock security system), by a wrong parity bit in RAM, and by a word
//! of the flash with two wrong bits. FLASH_ECCR (3.7.6) names the bank of that word and the word's offset within the bank.

use crate::pages::{FLASH, SECOND_BANK, START};

/// A word of the flash with two wrong bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Word {
    /// The word lies in the system memory, which holds the factory's calibration.
    pub in_system_memory: bool,
    /// The word lies in the second bank.
    pub in_second_bank: bool,
    /// The offset of the word within its bank, bytes.
    pub offset: u32,
}

impl Word {
    /// The address of the word in the flash.
    pub fn address(&self) -> u32 {
        self.offset + if self.in_second_bank { SECOND_BANK } else { FLASH }
    }
}

/// A reason for the non-maskable interrupt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Alarm {
    /// The crystal has stopped.
    ClockFailed,
    /// A word of the RAM has a wrong parity bit.
    RamParity,
    /// A word of the stored settings is damaged: that read fails, and the board goes on.
    Settings,
    /// A word of the code or of its constants is damaged, at this address.
    Code(u32),
    /// No flag is set.
    Unknown,
}

impl Alarm {
    /// Classifies the flags. With two banks the whole second bank belongs to the settings, because the linker script refuses code there; with one
    /// bank the address decides.
    pub fn of(clock_failed: bool, ram_parity: bool, word: Option<Word>, has_two_banks: bool) -> Alarm {
        if clock_failed {
            return Alarm::ClockFailed;
        }
        if ram_parity {
            return Alarm::RamParity;
        }
        let Some(word) = word else { return Alarm::Unknown };
        let is_in_settings = has_two_banks && word.in_second_bank || word.address() >= START;
        if is_in_settings && !word.in_system_memory { Alarm::Settings } else { Alarm::Code(word.address()) }
    }
}
