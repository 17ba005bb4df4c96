//! Handler that ends the image after a hard fault, with a message. The default handler would loop
//! forever, and the host would wait.
#![expect(unsafe_code, reason = "cortex-m-rt accepts a hard fault handler only as an unsafe fn")]

use cortex_m_rt::{ExceptionFrame, exception};
use semihosting::{eprintln, process};

// SAFETY: unsafe because a handler may run with broken invariants. This one changes nothing and
// exits.
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    eprintln!("hard fault at {:#010x}", frame.pc());
    process::exit(102)
}
