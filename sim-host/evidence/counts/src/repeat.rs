//! Repetition of a kernel, so often that the resolution of the timer does not matter.

use core::hint::black_box;

use qemu_m4::counter::Counter;

/// Returns the ticks of `repetitions` of a kernel: those of twice as many less those of as many,
/// which cancels everything around the loop.
pub fn repeat(counter: &Counter, repetitions: u32, mut kernel: impl FnMut()) -> i64 {
    // One loop in the code, because two might be compiled differently.
    let mut run = |count: u32| counter.ticks(|| (0..black_box(count)).for_each(|_| kernel()));
    let mut ticks = [0; 2];
    for (ticks, count) in ticks.iter_mut().zip([repetitions, 2 * repetitions]) {
        *ticks = run(count);
    }
    i64::from(ticks[1]) - i64::from(ticks[0])
}
