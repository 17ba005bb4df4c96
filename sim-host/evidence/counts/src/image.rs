//! The image: calibrates, counts every kernel, and ends.
//!
//! | exit | means |
//! |---|---|
//! | 0 | all lines are printed |
//! | 1 | the timer does not count instructions here |
//! | 101 | a panic; its message is on standard error |
//!
//! A line is `group,"kernel",samples,repetitions,ticks`: `ticks` is the sum over all repetitions of
//! a kernel, each of which handles `samples` samples.

use cortex_m_rt::entry;
use qemu_m4::counter::Counter;
use semihosting::{eprintln, println, process};

use crate::{generators, power_up, recorder, stages};

#[entry]
fn main() -> ! {
    let counter = Counter::start();
    if let Err(ticks) = counter.calibrate() {
        eprintln!("the timer took {ticks} ticks for a loop of known length: start QEMU with `-icount shift=0`");
        process::exit(1)
    }
    println!("group,kernel,samples,repetitions,ticks");
    generators::count(&counter);
    stages::count(&counter);
    recorder::count(&counter);
    power_up::count(&counter);
    process::exit(0)
}
