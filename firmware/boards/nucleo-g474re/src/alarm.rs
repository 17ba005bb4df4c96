//! Reason for the non-maskable interrupt: its sources are distinguished by their flags.
//!
//! RM0440 14.1.3 (interrupt vectors): the interrupt has three sources. These are a failed crystal
//! (clock security system), a wrong parity bit in RAM, and a word of the flash with two wrong bits.
//! FLASH_ECCR (3.7.6) contains the bank of that word and its offset within the bank.

use crate::pages::{FLASH, SECOND_BANK, START};

/// Word of the flash with two wrong bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Word {
    /// `true` if the word is in the system memory, which holds the factory's calibration.
    pub in_system_memory: bool,
    /// `true` if the word is in the second bank.
    pub in_second_bank: bool,
    /// Offset of the word within its bank, bytes.
    pub offset: u32,
}

impl Word {
    /// Returns the address of the word in the flash.
    pub fn address(&self) -> u32 {
        self.offset + if self.in_second_bank { SECOND_BANK } else { FLASH }
    }
}

/// Reason for the non-maskable interrupt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Alarm {
    /// The crystal has stopped.
    ClockFailed,
    /// A word of the RAM has a wrong parity bit.
    RamParity,
    /// A word of the stored settings is damaged: its read fails, and the board continues to run.
    Settings,
    /// A word of the code or of its constants is damaged, at this address.
    Code(u32),
    /// No flag is set.
    Unknown,
}

impl Alarm {
    /// Classifies the flags of the interrupt.
    ///
    /// In two-bank mode the whole second bank belongs to the settings, because the linker script
    /// permits no code there. In one-bank mode the address of the word decides.
    pub fn from_flags(clock_failed: bool, ram_parity: bool, word: Option<Word>, has_two_banks: bool) -> Alarm {
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
