//! A hard fault ends the image, with a message. Without it one would loop for ever, and the host would wait.
#![expect(unsafe_code, reason = "cortex-m-rt accepts a hard fault handler only as an unsafe fn")]

use cortex_m_rt::{ExceptionFrame, exception};
use semihosting::{eprintln, process};

// SAFETY: marked because a handler may meet broken invariants; this one changes nothing and exits.
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    eprintln!("hard fault at {:#010x}", frame.pc());
    process::exit(102)
}
