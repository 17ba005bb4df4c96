//! A plant sample by sample, as the pins of a part play and sample it, in place of whole blocks.
//!
//! The codes are the same, bit for bit: what a sample is depends on no later code, and what changes between two blocks changes where the
//! blocks of the scene begin.

use firmware::seam::block::SlowSense;

use crate::driven_stack::DrivenStack;
use crate::sums::Sums;

/// A stack that is played code by code.
#[derive(Clone, Debug)]
pub struct Stream {
    stack: DrivenStack,
    block_samples: usize,
    sums: Sums,
    samples: usize,
    slow: SlowSense,
}

impl Stream {
    /// Begins with the stack as it is; `block_samples` codes are a block.
    pub fn new(stack: DrivenStack, block_samples: usize) -> Self {
        Stream { stack, block_samples, sums: Sums::new(), samples: 0, slow: SlowSense::default() }
    }

    /// Plays one code, and returns the codes of voltage and current that were sampled meanwhile.
    pub fn play(&mut self, code: u16) -> (u16, u16) {
        if self.samples == 0 {
            self.sums = self.stack.begin();
        }
        let sampled = self.stack.play(code, &mut self.sums);
        self.samples += 1;
        if self.samples == self.block_samples {
            self.slow = self.stack.end(&self.sums, self.samples);
            self.samples = 0;
        }
        sampled
    }

    /// The slow sensors at the end of the last whole block.
    pub fn slow(&self) -> &SlowSense {
        &self.slow
    }

    /// The stack.
    pub fn stack(&self) -> &DrivenStack {
        &self.stack
    }
}

#[cfg(test)]
mod tests {
    use firmware::seam::block::{DriveBlock, SenseBlock};
    use hal_mock::analog::Analog;
    use scene::load::load;

    use super::*;
    use crate::Plant;

    #[test]
    fn samples_are_those_of_blocks() {
        for name in ["lock", "friction-ratio", "lock-drift"] {
            let loaded = load(name, &[]).unwrap();
            let Plant::Stack(stack) = Plant::new(&loaded.scene.driven().unwrap()) else { panic!("{name}") };
            let (mut blocks, mut stream) = (stack.clone(), Stream::new(*stack, 32));
            let mut drive = DriveBlock::silent(1, 32, 2048);
            let mut sense = SenseBlock::default();
            for block in 0..2000_u32 {
                for (n, code) in drive.lanes[0].iter_mut().enumerate() {
                    *code = if (32 * block + n as u32) % 25 < 12 { 2600 } else { 1496 };
                }
                blocks.exchange(&drive, &mut sense);
                let sampled: Vec<(u16, u16)> = drive.lanes[0].iter().map(|&code| stream.play(code)).collect();
                assert_eq!(sampled, sense.v.iter().copied().zip(sense.i.iter().copied()).collect::<Vec<_>>(), "{name} {block}");
                assert_eq!(*stream.slow(), sense.slow, "{name} {block}");
            }
            assert_eq!(stream.stack().truth().tip_velocity_m_per_s, blocks.truth().tip_velocity_m_per_s);
            assert!(blocks.truth().tip_velocity_m_per_s > 0.0, "{name} moves");
        }
    }
}
