//! Halves of the rings that DMA and the interrupt use in turn, and blocks that came late.
//!
//! Two rings of two blocks each, one that DMA fills from the ADC and one that it plays to the DAC, both at the sample rate. While DMA
//! is in one half of both, the other half belongs to the interrupt: it reads the samples there, and writes the codes that
//! play when DMA comes to this half again, which is the latency of [`LATENCY_BLOCKS`](firmware::seam::block::LATENCY_BLOCKS).
//!
//! ```text
//! block           k         k+1        k+2
//! ADC fills     first     second      first
//! DAC plays     first     second      first
//! interrupt           first: reads k, writes k+2
//! ```

/// Samples in a block: as many as the part has time for, in whole periods of 40 kHz and of 20 kHz.
///
/// Most of what a block costs does not depend on its length. Blocks of 64 were measured before this was chosen: `docs/board.md`.
pub const BLOCK: usize = 100;
/// Blocks that may be missed before the amplifier's enable drops, but for a part of one.
pub const MISSED: u32 = 2;
/// Samples in a ring.
pub const RING: usize = 2 * BLOCK;
/// Cycles of the processor in a sample: 170 MHz at 1 Msps.
pub const CYCLES_PER_SAMPLE: u32 = 170;
/// Cycles of the processor in a block.
pub const CYCLES_PER_BLOCK: u32 = CYCLES_PER_SAMPLE * BLOCK as u32;

/// A half of a ring.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Half {
    /// The first block.
    First,
    /// The second block.
    Second,
}

impl Half {
    /// The half that a position is in.
    pub fn at(position: usize) -> Half {
        if position % RING < BLOCK { Half::First } else { Half::Second }
    }

    /// The other half.
    pub fn other(self) -> Half {
        match self {
            Half::First => Half::Second,
            Half::Second => Half::First,
        }
    }

    /// The position of its first sample.
    pub fn start(self) -> usize {
        match self {
            Half::First => 0,
            Half::Second => BLOCK,
        }
    }
}

/// Samples that DMA has moved in this round, from the number that remains: it counts down and starts again at [`RING`].
pub fn position(remaining: u16) -> usize {
    RING.wrapping_sub(remaining.into()) % RING
}

/// The place of a half's sample in the DAC's ring: one place early, because a trigger plays the word that the trigger before has fetched.
pub fn slot(half: Half, sample: usize) -> usize {
    (half.start() + sample + RING - 1) % RING
}

/// The places of a half's samples in the DAC's ring: that of the first, and those of the others.
pub fn places<Place>(ring: &[Place; RING], half: Half) -> (&Place, &[Place]) {
    let start = half.start();
    (&ring[slot(half, 0)], &ring[start..start + BLOCK - 1])
}

/// Whether the codes written for `half` are there before they are fetched, with a sample to spare. `next` is the place that DMA fetches next.
pub fn is_in_time(half: Half, next: usize) -> bool {
    Half::at(next + 1) == half.other()
}

/// Whether the two rings are in step: how far the DAC's is ahead does not change. A lost trigger or a lost transfer moves one of them.
///
/// For a moment of each sample the lead is another one: after the one ring has moved, and before the other has. That is less than a third of a sample
/// ([`TRIGGER_AFTER`](crate::sampling::TRIGGER_AFTER): some 8 cycles of 170), so that two of three looks a third of a sample apart agree.
#[derive(Clone, Debug, Default)]
pub struct Step {
    lead: Option<usize>,
}

impl Step {
    /// Takes the positions in both rings, of the ADC and of the DAC. Where the lead is another one than before, `again` looks three more times, a third of
    /// a sample later each, and these decide: the first look may lie a whole sample before one of them, and does not count. The first call says what is
    /// in step.
    pub fn holds(&mut self, positions: (usize, usize), mut again: impl FnMut() -> (usize, usize)) -> bool {
        let lead = |(adc, dac): (usize, usize)| (dac + RING - adc % RING) % RING;
        if self.lead == Some(lead(positions)) {
            return true;
        }
        let [first, second, third] = [(); 3].map(|()| lead(again()));
        let usual = if second == third { second } else { first };
        *self.lead.get_or_insert(usual) == usual
    }
}

/// Counts blocks that were due and did not come, by the processor's cycle counter.
#[derive(Clone, Debug, Default)]
pub struct Beat {
    last: Option<u32>,
}

impl Beat {
    /// How many blocks were missed since the last call, which may have been late or early by less than half a block.
    pub fn missed(&mut self, now: u32) -> u32 {
        let last = self.last.replace(now).unwrap_or(now.wrapping_sub(CYCLES_PER_BLOCK));
        let due = (now.wrapping_sub(last) + CYCLES_PER_BLOCK / 2) / CYCLES_PER_BLOCK;
        due.saturating_sub(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The positions at a cycle: the ADC's ring moves with each sample, the DAC's `apart` cycles later.
    fn at(cycle: u32, apart: u32) -> (usize, usize) {
        let place = |cycle: u32| (cycle / CYCLES_PER_SAMPLE) as usize % RING;
        (place(cycle + CYCLES_PER_SAMPLE), place(cycle + 7 * CYCLES_PER_SAMPLE - apart))
    }

    /// Whether the rings are in step at a cycle, where looking takes `before` cycles until the first look after it and `between` from one to the next.
    fn is_in_step(step: &mut Step, cycle: u32, before: u32, between: u32) -> bool {
        let mut now = cycle + before;
        let again = || {
            let seen = at(now, 8);
            now += between;
            seen
        };
        step.holds(at(cycle, 8), again)
    }

    #[test]
    fn rings_in_step_are_so_at_any_cycle_however_long_the_first_look_took() {
        for began in 0..CYCLES_PER_SAMPLE {
            // The loop of `delay` takes three to five cycles, and what looks some ten.
            for between in 45..=80 {
                let mut step = Step::default();
                for cycle in began..began + 3 * CYCLES_PER_SAMPLE {
                    let before = 20 + cycle % 200;
                    assert!(is_in_step(&mut step, cycle, before, between), "{began} {between} {cycle} {before}");
                }
            }
        }
    }

    #[test]
    fn a_lost_trigger_is_seen_at_all_cycles_but_those_between_the_two_rings() {
        for lost in [1, RING - 1] {
            let mut seen = 0;
            for cycle in 0..CYCLES_PER_SAMPLE {
                let mut step = Step { lead: Some((6 + lost) % RING) };
                seen += u32::from(!is_in_step(&mut step, cycle, 60, 57));
            }
            assert!(seen >= CYCLES_PER_SAMPLE - 8, "{lost}: {seen}");
        }
    }
}
