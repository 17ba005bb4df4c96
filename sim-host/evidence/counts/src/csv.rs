//! The lines of CSV that the image prints.

use semihosting::println;

/// Prints one kernel: group, name, samples of one repetition, repetitions, and ticks of all of
/// them.
pub fn line(group: &str, kernel: &str, samples: usize, repetitions: u32, ticks: i64) {
    println!("{group},\"{kernel}\",{samples},{repetitions},{ticks}");
}
