//! Check that the rings are in step, at every cycle of the quiet part of a sample.

use boards_common::step::Step;

const RING: usize = 200;
const CYCLES_PER_SAMPLE: usize = 170;
/// Cycles of a sample at which the rings of the ADC and of the DAC move.
const MOVES: (usize, usize) = (23, 15);

/// Returns the positions in both rings at a cycle, if each has lost this number of half samples.
fn positions(cycle: usize, lost: (usize, usize)) -> (usize, usize) {
    let place = |moves: usize, lost: usize| {
        (cycle + 9 * CYCLES_PER_SAMPLE - moves - lost * CYCLES_PER_SAMPLE / 2) / CYCLES_PER_SAMPLE % RING
    };
    (place(MOVES.0, lost.0), (place(MOVES.1, lost.1) + 2) % RING)
}

#[test]
fn every_lost_trigger_is_detected_and_nothing_else() {
    for quiet in 25..=99 {
        for lost in [(0, 0), (1, 0), (2, 0), (5, 0), (0, 2), (0, 6)] {
            let mut step = Step::<RING>::default();
            let blocks = (0..5).map(|block| quiet + block * RING / 2 * CYCLES_PER_SAMPLE);
            assert!(blocks.clone().all(|cycle| step.holds(positions(cycle, (0, 0)))), "{quiet}");
            assert!(blocks.clone().all(|cycle| step.holds(positions(cycle, lost)) == (lost == (0, 0))), "{quiet} {lost:?}");
        }
    }
}
