//! A plant played sample by sample, as by the pins of a microcontroller, instead of in whole
//! blocks.
//!
//! The codes are the same, bit for bit: a sample does not depend on later codes, and changes
//! between two blocks occur where the blocks of the scene begin.

use firmware::seam::block::{DriveBlock, MAX_LANES, SlowSense};

use crate::Plant;
use crate::motor::Block;
use crate::sums::Sums;

/// A plant that is played code by code.
#[derive(Clone, Debug)]
pub struct Stream {
    plant: Plant,
    /// The block in progress, as played so far.
    drive: DriveBlock,
    block_samples: usize,
    open: Open,
    slow: SlowSense,
}

/// Sums of the block in progress.
#[derive(Clone, Debug)]
enum Open {
    /// No block is in progress.
    Between,
    Stack(Sums),
    Motor(Box<Block>),
}

impl Stream {
    /// Creates a stream for a plant on `lanes` lanes; `block_samples` codes are a block.
    pub fn new(plant: Plant, lanes: usize, block_samples: usize) -> Self {
        let drive = DriveBlock::silent(lanes, 0, 0);
        Stream { plant, drive, block_samples, open: Open::Between, slow: SlowSense::default() }
    }

    /// Plays one code on each lane. Returns the codes of voltage and current that were sampled
    /// meanwhile at the lane `listen`.
    pub fn play(&mut self, codes: [u16; MAX_LANES], listen: u8) -> (u16, u16) {
        for (lane, code) in self.drive.lanes.iter_mut().zip(codes) {
            // A block never has more samples than its capacity.
            let _ = lane.push(code);
        }
        if matches!(self.open, Open::Between) {
            self.open = match &mut self.plant {
                Plant::Stack(stack) => Open::Stack(stack.begin()),
                Plant::Crash(crash) => Open::Stack(crash.begin()),
                Plant::Motor(motor) => Open::Motor(Box::new(motor.begin())),
            };
        }
        let lanes = self.drive.lanes.len();
        let sampled = match (&mut self.plant, &mut self.open) {
            (Plant::Stack(stack), Open::Stack(sums)) => stack.play(codes[0], sums),
            (Plant::Crash(crash), Open::Stack(sums)) => crash.play(codes[0], sums),
            (Plant::Motor(motor), Open::Motor(block)) => {
                let codes = std::array::from_fn(|lane| (lane < lanes).then_some(codes[lane]));
                motor.play(&codes, usize::from(listen).min(MAX_LANES - 1), block)
            }
            _ => (0, 0),
        };
        if self.drive.lanes.first().is_some_and(|lane| lane.len() == self.block_samples) {
            self.end();
        }
        sampled
    }

    fn end(&mut self) {
        let open = std::mem::replace(&mut self.open, Open::Between);
        match (&mut self.plant, &open) {
            (Plant::Stack(stack), Open::Stack(sums)) => self.slow = stack.end(sums, self.block_samples),
            (Plant::Crash(crash), Open::Stack(sums)) => self.slow = crash.end(&self.drive, sums),
            (Plant::Motor(motor), Open::Motor(block)) => motor.end(&self.drive, block),
            _ => {}
        }
        self.drive.lanes.iter_mut().for_each(|lane| lane.clear());
    }

    /// Returns the slow sensors at the end of the last whole block.
    pub fn slow(&self) -> &SlowSense {
        &self.slow
    }

    /// Returns the plant.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }
}

#[cfg(test)]
mod tests {
    use firmware::seam::block::SenseBlock;
    use hal_mock::analog::Analog;
    use scene::load::load;

    use super::*;

    #[test]
    fn samples_equal_those_of_blocks() {
        for (name, lanes) in [
            ("lock", 1),
            ("friction-ratio", 1),
            ("lock-drift", 1),
            ("self-heating", 1),
            ("belt-stop", 1),
            ("dring-crash", 1),
            ("usm", 4),
        ] {
            let loaded = load(name, &[]).unwrap();
            let mut blocks = Plant::new(&loaded.scene.driven().unwrap());
            let mut stream = Stream::new(blocks.clone(), lanes, 32);
            let mut drive = DriveBlock::silent(lanes, 32, 2048);
            let mut sense = SenseBlock::default();
            for block in 0..2000_u32 {
                for (lane, codes) in drive.lanes.iter_mut().enumerate() {
                    for (n, code) in codes.iter_mut().enumerate() {
                        let phase = (32 * block + n as u32 + 6 * lane as u32) % 25;
                        *code = if phase < 12 { 2600 } else { 1496 };
                    }
                }
                blocks.exchange(&drive, &mut sense);
                let codes = |n: usize| std::array::from_fn(|lane| drive.lanes.get(lane).map_or(0, |codes| codes[n]));
                let sampled: Vec<(u16, u16)> = (0..32).map(|n| stream.play(codes(n), 0)).collect();
                assert_eq!(sampled, sense.v.iter().copied().zip(sense.i.iter().copied()).collect::<Vec<_>>(), "{name} {block}");
                assert_eq!(*stream.slow(), sense.slow, "{name} {block}");
            }
            assert_eq!(stream.plant().truth(), blocks.truth(), "{name}");
            assert!(blocks.truth().tip_velocity_m_per_s > 0.0, "{name} moves");
        }
    }
}
