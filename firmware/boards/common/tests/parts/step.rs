//! Check that the rings are in step, at every moment at which the interrupt may look.
//!
//! The boards of these tests differ in the length of a ring, the cycles of a sample, and the delay
//! from the ADC's ring to the DAC's. They also differ in the cycles between two looks, which a
//! waiting loop does not fix exactly.

use std::ops::RangeInclusive;

use boards_common::step::Step;

/// Timing of a board and its interrupt.
struct Timing {
    cycles_per_sample: u32,
    /// Delay from the step of the ADC's ring to that of the DAC's, cycles.
    apart: u32,
    /// Time between two looks, cycles: about a third of a sample, within the limits of `Step`.
    between: RangeInclusive<u32>,
}

/// The Nucleo-G474RE: a waiting loop takes three to five cycles per turn, a look about ten.
const NUCLEO: Timing = Timing { cycles_per_sample: 170, apart: 8, between: 45..=80 };
/// A board with a 150 MHz processor and converters at 500 kHz.
const SLOWER: Timing = Timing { cycles_per_sample: 300, apart: 40, between: 41..=129 };

impl Timing {
    /// Returns the positions at a cycle, if the DAC's ring has lost this number of transfers.
    fn at<const RING: usize>(&self, cycle: u32, lost: usize) -> (usize, usize) {
        let place = |cycle: u32| (cycle / self.cycles_per_sample) as usize % RING;
        let dac = place(cycle + 7 * self.cycles_per_sample - self.apart);
        (place(cycle + self.cycles_per_sample), (dac + RING - lost) % RING)
    }

    /// Returns `true` if the check finds the rings in step at a cycle. The first repeated look is
    /// `before` cycles later, and the next ones `between` cycles apart.
    fn is_in_step<const RING: usize>(
        &self,
        step: &mut Step<RING>,
        cycle: u32,
        lost: usize,
        (before, between): (u32, u32),
    ) -> bool {
        let mut now = cycle + before;
        let again = || {
            let seen = self.at::<RING>(now, lost);
            now += between;
            seen
        };
        step.holds(self.at::<RING>(cycle, lost), again)
    }

    fn check_rings_in_step<const RING: usize>(&self) {
        for began in 0..self.cycles_per_sample {
            for between in self.between.clone() {
                let mut step = Step::<RING>::default();
                for cycle in began..began + 3 * self.cycles_per_sample {
                    let before = 20 + cycle % 200;
                    assert!(self.is_in_step(&mut step, cycle, 0, (before, between)), "{began} {between} {cycle} {before}");
                }
            }
        }
    }

    fn check_loss_is_detected<const RING: usize>(&self) {
        for lost in [1, 3, RING - 1] {
            let mut seen = 0;
            for cycle in 0..self.cycles_per_sample {
                let mut step = Step::<RING>::default();
                let looks = (60, self.cycles_per_sample / 3);
                assert!(self.is_in_step(&mut step, cycle, 0, looks));
                seen += u32::from(!self.is_in_step(&mut step, cycle, lost, looks));
            }
            assert!(seen >= self.cycles_per_sample - self.apart, "{lost}: {seen}");
        }
    }
}

#[test]
fn rings_in_step_are_accepted_at_any_cycle() {
    NUCLEO.check_rings_in_step::<200>();
    SLOWER.check_rings_in_step::<128>();
}

#[test]
fn a_lost_trigger_is_detected_except_between_the_two_rings() {
    NUCLEO.check_loss_is_detected::<200>();
    SLOWER.check_loss_is_detected::<128>();
}

const BLOCK: usize = 100;
const RING: usize = 2 * BLOCK;

/// Returns the positions in both rings at a time in samples, if `lost` samples of each are lost.
/// The DAC is two samples ahead and moves an eighth of a sample before the ADC.
fn positions(at: f64, lost: (usize, usize)) -> (usize, usize) {
    let (adc, dac) = (at + RING as f64, at + RING as f64 + 2.125);
    ((adc as usize - lost.0) % RING, (dac as usize - lost.1) % RING)
}

#[test]
fn streams_are_in_step_until_one_has_lost_a_sample() {
    // Each block, also the first, is checked at some moment in its first sample. In the moment
    // after the DAC has moved and before the ADC has, a loss may not be visible; the next block
    // detects it.
    for first in 0..20 {
        for part in 0..20 {
            for lost in [(0, 0), (1, 0), (0, 1), (2, 0), (0, 3)] {
                let mut step = Step::<RING>::default();
                let mut holds = |mut at: f64, lost| {
                    step.holds(positions(at, lost), || {
                        at += 1.0 / 3.0;
                        positions(at, lost)
                    })
                };
                assert!(holds(BLOCK as f64 + f64::from(first) / 20.0, (0, 0)));
                let holds = holds(RING as f64 + f64::from(part) / 20.0, lost);
                assert!(holds == (lost == (0, 0)) || part > 17, "{first} {part} {lost:?}");
                assert!(holds || lost != (0, 0), "{first} {part}");
            }
        }
    }
}
