//! Whether the rings are in step, at any moment at which the interrupt may look.
//!
//! The boards here: how long a ring is, the cycles of a sample, by how many cycles the DAC's ring moves after the ADC's, and the cycles from one look to
//! the next, which a waiting loop does not fix.

use std::ops::RangeInclusive;

use boards_common::step::Step;

/// A board, and what the interrupt does on it.
struct Timing {
    cycles_per_sample: u32,
    /// From the ADC's ring to the DAC's, cycles.
    apart: u32,
    /// From one look to the next, cycles: a third of a sample, within what `Step` permits.
    between: RangeInclusive<u32>,
}

/// The Nucleo-G474RE: a loop takes three to five cycles, and what looks some ten.
const NUCLEO: Timing = Timing { cycles_per_sample: 170, apart: 8, between: 45..=80 };
/// A processor of 150 MHz with converters at 500 kHz.
const SLOWER: Timing = Timing { cycles_per_sample: 300, apart: 40, between: 41..=129 };

impl Timing {
    /// The positions at a cycle, where the DAC's ring has not fetched what it has lost.
    fn at<const RING: usize>(&self, cycle: u32, lost: usize) -> (usize, usize) {
        let place = |cycle: u32| (cycle / self.cycles_per_sample) as usize % RING;
        let dac = place(cycle + 7 * self.cycles_per_sample - self.apart);
        (place(cycle + self.cycles_per_sample), (dac + RING - lost) % RING)
    }

    /// Whether the rings are in step at a cycle, where looking takes `before` cycles until the first look after it and `between` from one to the next.
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

    fn rings_in_step_are_so<const RING: usize>(&self) {
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

    fn a_loss_is_seen<const RING: usize>(&self) {
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
fn rings_in_step_are_so_at_any_cycle_however_long_the_first_look_took() {
    NUCLEO.rings_in_step_are_so::<200>();
    SLOWER.rings_in_step_are_so::<128>();
}

#[test]
fn a_lost_trigger_is_seen_at_all_cycles_but_those_between_the_two_rings() {
    NUCLEO.a_loss_is_seen::<200>();
    SLOWER.a_loss_is_seen::<128>();
}

const BLOCK: usize = 100;
const RING: usize = 2 * BLOCK;

/// Positions in both rings at a time in samples: the DAC is two ahead, and moves an eighth of a sample before the ADC; `lost` samples of each are lost.
fn positions(at: f64, lost: (usize, usize)) -> (usize, usize) {
    let (adc, dac) = (at + RING as f64, at + RING as f64 + 2.125);
    ((adc as usize - lost.0) % RING, (dac as usize - lost.1) % RING)
}

#[test]
fn streams_are_in_step_until_one_has_lost_a_sample() {
    // Each block is looked at somewhere in its first sample, the first one too. In the moment in which the DAC has moved and the ADC has not, what one has lost
    // may not show: the next block shows it.
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
