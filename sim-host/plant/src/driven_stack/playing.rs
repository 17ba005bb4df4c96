//! A block of codes in the widest registers, and at rest.

use firmware::seam::block::{DriveBlock, SenseBlock};

use super::DrivenStack;
use crate::quad::{Four, Portable, Work, widest};
use crate::sums::{Rubbing, Step, Sums};

impl DrivenStack {
    /// Plays what of a block has not been played yet.
    pub(super) fn play_all(&mut self, drive: &DriveBlock, sums: &mut Sums, sense: &mut SenseBlock) {
        widest(PlayAll { plant: self, drive, sums, sense });
    }

    /// Whether nothing moves while this code is played, and nothing is recorded of it.
    #[inline(always)]
    fn rests_at(&self, code: u16) -> bool {
        self.at_rest && self.samples.is_none() && self.delay.is_none() && self.dac.volts(code) == self.held_v
    }

    /// Plays so many codes at rest: the steps are all like the last one, and so is what is seen.
    #[inline(always)]
    fn rest_on<F: Four>(&mut self, four: F, codes: usize, sums: &mut Sums, sense: &mut SenseBlock) {
        let last = self.last;
        for _ in 0..codes * self.timing.steps as usize {
            sums.add(&last);
        }
        for _ in 0..codes {
            let (mut v, mut i) = (0, 0);
            for &(scaled, conversions) in &self.seen {
                let [voltage, current] = self.adc.digitize(scaled.wide(four), conversions);
                v += voltage;
                i += current;
            }
            let _ = (sense.v.push(v), sense.i.push(i));
        }
    }

    /// Rests after a sample in which nothing has moved, of one step without friction: what is seen from now on is what is seen in it.
    pub(super) fn rest(&mut self) {
        let DrivenStack { stack, adc, seen, held_v, .. } = self;
        seen.clear();
        stack.sample(Portable, 0, &stack.held(*held_v), 0.0, |both, conversions| {
            seen.push((adc.scaled(both).quad(), conversions))
        });
        self.last = Step::from_stack(stack, Rubbing::default());
        self.at_rest = true;
    }
}

/// Plays what of a block has not been played yet.
struct PlayAll<'a> {
    plant: &'a mut DrivenStack,
    drive: &'a DriveBlock,
    sums: &'a mut Sums,
    sense: &'a mut SenseBlock,
}

impl Work for PlayAll<'_> {
    type Output = ();

    #[inline(always)]
    fn with<F: Four>(self, four: F) {
        let PlayAll { plant, drive, sums, sense } = self;
        let codes = drive.lanes.first().map_or(&[][..], |lane| lane.as_slice());
        // A copy, which no other pointer reaches: sums that are read back from memory wait for what was written there.
        let mut local = sums.clone();
        while let Some(&code) = codes.get(sense.v.len()) {
            let left = &codes[sense.v.len()..];
            let resting = left.iter().take_while(|&&code| plant.rests_at(code)).count();
            if resting > 0 {
                plant.rest_on(four, resting, &mut local, sense);
                continue;
            }
            let (v, i) = plant.play_in(four, code, &mut local);
            // A sense block holds as many samples as the longest drive block.
            if sense.v.push(v).is_err() || sense.i.push(i).is_err() {
                break;
            }
        }
        *sums = local;
    }
}
