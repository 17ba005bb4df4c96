//! Divider of the low-power UART.
//!
//! ```text
//! LPUART_BRR = 256 * clock / baud: 20 bits, at least 0x300; the clock must be 3 to 4096 times the baud rate      (RM0440 38.4.7)
//! ```

/// Largest divider, from the 20 bits of the register.
const MAX_DIVIDER: u32 = 0xf_ffff;
/// Smallest divider that the manual permits.
const MIN_DIVIDER: u32 = 0x300;
/// Dividers above the smallest one with which the transmission may fail (ES0430 2.17.1).
const MAX_FAULTY_DIVIDER: u32 = 0x3ff;

/// Returns the divider, rounded to the nearest integer. Returns `None` if this clock cannot produce
/// this baud rate (both in Hz).
pub const fn divider(clock_hz: u32, baud: u32) -> Option<u32> {
    if baud == 0 {
        return None;
    }
    // 256 times the largest clock takes 40 bits.
    let divider = (256 * clock_hz as u64 + baud as u64 / 2) / baud as u64;
    let is_faulty = divider > MIN_DIVIDER as u64 && divider <= MAX_FAULTY_DIVIDER as u64;
    if divider < MIN_DIVIDER as u64 || divider > MAX_DIVIDER as u64 || is_faulty { None } else { Some(divider as u32) }
}
