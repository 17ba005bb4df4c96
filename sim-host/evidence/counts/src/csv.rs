//! What is printed.

use semihosting::println;

/// Prints one kernel: its group and name, samples of one repetition, repetitions, and ticks of all.
pub fn line(group: &str, kernel: &str, samples: usize, repetitions: u32, ticks: i64) {
    println!("{group},\"{kernel}\",{samples},{repetitions},{ticks}");
}
