//! The divider of the low-power UART.
//!
//! ```text
//! LPUART_BRR = 256 * clock / baud, of 20 bits and at least 0x300; the clock is 3 to 4096 times the baud rate      (RM0440 38.4.7)
//! ```

/// The largest value of the register's 20 bits, and the smallest that the manual permits.
const LARGEST: u32 = 0xf_ffff;
const SMALLEST: u32 = 0x300;

/// The divider, rounded to the nearest; `None` where this baud rate cannot be had from this clock (both in Hz).
pub const fn divider(clock_hz: u32, baud: u32) -> Option<u32> {
    if baud == 0 {
        return None;
    }
    // 256 times the largest clock takes 40 bits.
    let divider = (256 * clock_hz as u64 + baud as u64 / 2) / baud as u64;
    if divider < SMALLEST as u64 || divider > LARGEST as u64 { None } else { Some(divider as u32) }
}
