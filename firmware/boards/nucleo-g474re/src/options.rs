//! The option bytes as this board needs them. RM0440 3.4, FLASH_OPTR (3.7.8), FLASH_WRP1AR (3.7.13).
//!
//! | bit of the report | option | as it should be | otherwise |
//! |---|---|---|---|
//! | 0 | `BOR_LEV` | 4: reset below 2.8 V | flash is written, and the amplifier enabled, at a supply that is too low (delivered: 0) |
//! | 1 | `DBANK` | 1: two banks | no settings are stored, no update is possible (delivered: 1) |
//! | 2 | `BFB2` | 0: boot from the first bank | ST's loader in system memory runs after each reset, and drives pins (delivered: 0) |
//! | 3 | `nBOOT0`, `nSWBOOT0` | `nSWBOOT0` 0 and `nBOOT0` 1: the pin PB8 cannot choose ST's loader | a level at PB8 starts that (delivered: both 1) |
//! | 4 | `RDP` | not level 0, for a board that leaves the laboratory | whoever has a probe reads and changes everything (delivered: level 0) |
//! | 5 | `WRP1A` | the first stage's pages, 0 to 7 | a fault of an image can erase it (delivered: nothing) |
//! | 6 | `SRAM_PE` | 1: parity of the RAM is not checked | what a reset leaves in RAM is read at start, and was never written after power-on: a parity error (delivered: 1) |
//! | 7 | `IWDG_SW`, `IWDG_STOP`, `IWDG_STDBY` | 1: the watchdog is started by the image, and runs on in stop and standby | the first stage has no time for a swap where it is 0, as the hardware starts it with 0.5 s (delivered: 1) |

/// FLASH_OPTR's fields (3.7.8).
const RDP_LEVEL_0: u32 = 0xaa;
/// The last page of the first stage.
const LAST_PROTECTED: u32 = crate::slots::FIRST_STAGE / crate::pages::PAGE - 1;

/// Names of the options, by their bits in a report.
pub const NAMES: [&str; 8] =
    ["BOR_LEV", "DBANK", "BFB2", "nSWBOOT0 and nBOOT0", "RDP", "WRP1A", "SRAM_PE", "IWDG_SW, IWDG_STOP, IWDG_STDBY"];

/// Options that are not as they should be, one bit each, by FLASH_OPTR and FLASH_WRP1AR. Without a first stage nothing has to be protected.
pub fn mismatches(options: u32, protected: u32, has_first_stage: bool) -> u16 {
    let bit = |n: u32| options >> n & 1 == 1;
    let (first, last) = (protected & 0x7f, protected >> 16 & 0x7f);
    let wrong = [
        options >> 8 & 7 != 4,
        !bit(22),
        bit(20),
        bit(26) || !bit(27),
        options & 0xff == RDP_LEVEL_0,
        has_first_stage && !(first == 0 && last >= LAST_PROTECTED),
        !bit(24),
        !(bit(16) && bit(17) && bit(18)),
    ];
    wrong.into_iter().enumerate().fold(0, |bits, (n, wrong)| bits | u16::from(wrong) << n)
}

/// Names of the options in a report.
pub fn names(bits: u16) -> impl Iterator<Item = &'static str> {
    NAMES.into_iter().enumerate().filter(move |(n, _)| bits >> n & 1 == 1).map(|(_, name)| name)
}
