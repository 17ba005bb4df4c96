//! Option bytes that this board requires. RM0440 3.4, FLASH_OPTR, FLASH_WRP1AR.
//!
//! | bit of the report | option | required value | effect of another value |
//! |---|---|---|---|
//! | 0 | `BOR_LEV` | 4: reset below 2.8 V | flash is written and the amplifier is enabled at too low a supply (delivered: 0) |
//! | 1 | `DBANK` | 1: two banks | no settings are stored, no update is possible (delivered: 1) |
//! | 2 | `BFB2` | 0: boot from the first bank | ST's loader in system memory runs after each reset and drives pins (delivered: 0) |
//! | 3 | `nBOOT0`, `nSWBOOT0` | `nSWBOOT0` 0 and `nBOOT0` 1: the pin PB8 cannot select ST's loader | a high level at PB8 starts ST's loader (delivered: both 1) |
//! | 4 | `RDP` | not level 0, for a board that leaves the laboratory | anyone with a probe can read and change everything (delivered: level 0) |
//! | 5 | `WRP1A` | the pages of the first stage, 0 to 7 | a faulty image can erase the first stage (delivered: nothing) |
//! | 6 | `SRAM_PE` | 1: parity of the RAM is not checked | parity error: at start the image reads RAM that survives a reset, which was never written after power-on (delivered: 1) |
//! | 7 | `IWDG_SW`, `IWDG_STOP`, `IWDG_STDBY` | 1: the image starts the watchdog, which also runs in stop and standby | if 0, the hardware starts the watchdog with 0.5 s, too short for a swap by the first stage (delivered: 1) |

/// Value of FLASH_OPTR.RDP for level 0.
const RDP_LEVEL_0: u32 = 0xaa;
/// Last page of the first stage.
const LAST_PROTECTED: u32 = crate::slots::FIRST_STAGE / crate::pages::PAGE - 1;

/// Names of the options, indexed by their bit in a report.
pub const NAMES: [&str; 8] =
    ["BOR_LEV", "DBANK", "BFB2", "nSWBOOT0 and nBOOT0", "RDP", "WRP1A", "SRAM_PE", "IWDG_SW, IWDG_STOP, IWDG_STDBY"];

/// Returns the options with a wrong value, one bit each, from FLASH_OPTR and FLASH_WRP1AR. Write
/// protection is required only with a first stage.
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

/// Returns the names of the options in a report.
pub fn names(bits: u16) -> impl Iterator<Item = &'static str> {
    NAMES.into_iter().enumerate().filter(move |(n, _)| bits >> n & 1 == 1).map(|(_, name)| name)
}
