//! The image: calibrates, counts every kernel, and ends.
//!
//! | exit | means |
//! |---|---|
//! | 0 | all lines are printed |
//! | 1 | the timer does not count instructions here |
//! | 101 | a panic; its message is on standard error |

use cortex_m_rt::entry;
use semihosting::{eprintln, println, process};

use crate::counter::{Counter, Ticks};
use crate::{controller, generators, stages};

#[entry]
fn main() -> ! {
    let counter = Counter::start();
    if let Err(ticks) = counter.calibrate() {
        eprintln!("the timer took {ticks} ticks for a loop of known length: start QEMU with `-icount shift=0`");
        process::exit(1)
    }
    println!("kernel,samples,repetitions,ticks,ticks_of_twice");
    generators::count(&counter);
    stages::count(&counter);
    controller::count(&counter);
    process::exit(0)
}

/// Prints one kernel: the samples in one repetition, how many repetitions, and what they took.
pub fn line(kernel: &str, samples: usize, repetitions: u32, ticks: Ticks) {
    println!("{kernel},{samples},{repetitions},{},{}", ticks.once, ticks.twice);
}
