//! A block of codes, of which those at rest cost less.

use firmware::seam::block::{DriveBlock, SenseBlock};

use super::DrivenStack;
use crate::sums::Sums;

impl DrivenStack {
    /// Plays what of a block has not been played yet.
    pub(super) fn play_all(&mut self, drive: &DriveBlock, sums: &mut Sums, sense: &mut SenseBlock) {
        let codes = drive.lanes.first().map_or(&[][..], |lane| lane.as_slice());
        // A copy, which no other pointer reaches: sums that are read back from memory wait for what was written there.
        let mut local = sums.clone();
        while let Some(&code) = codes.get(sense.v.len()) {
            let left = &codes[sense.v.len()..];
            let resting = left.iter().take_while(|&&code| self.rests_at(code)).count();
            if resting > 0 {
                self.rest_on(resting, &mut local, sense);
                continue;
            }
            let (v, i) = self.play(code, &mut local);
            // A sense block holds as many samples as the longest drive block.
            if sense.v.push(v).is_err() || sense.i.push(i).is_err() {
                break;
            }
        }
        *sums = local;
    }

    /// Whether nothing moves while this code is played, and nothing is recorded of it.
    #[inline(always)]
    fn rests_at(&self, code: u16) -> bool {
        self.at_rest && self.samples.is_none() && self.delay.is_none() && self.dac.volts(code) == self.held_v
    }

    /// Plays so many codes at rest: the steps are all like the last one, and so is what is seen.
    #[inline(always)]
    fn rest_on(&mut self, codes: usize, sums: &mut Sums, sense: &mut SenseBlock) {
        let last = self.last;
        for _ in 0..codes * self.timing.steps as usize {
            sums.add(&last);
        }
        for _ in 0..codes {
            let (mut v, mut i) = (0, 0);
            for &(scaled, conversions) in &self.seen {
                let [voltage, current] = self.adc.digitize(scaled, conversions);
                v += voltage;
                i += current;
            }
            let _ = (sense.v.push(v), sense.i.push(i));
        }
    }
}
