//! Playing a block of codes in the widest registers, and at rest.

use firmware::seam::block::{DriveBlock, SenseBlock};

use super::DrivenStack;
use crate::quad::{Kernel, Portable, Registers, run_widest};
use crate::sums::{Step, StepFriction, Sums};

impl DrivenStack {
    /// Plays the rest of a block.
    pub(super) fn play_all(&mut self, drive: &DriveBlock, sums: &mut Sums, sense: &mut SenseBlock) {
        run_widest(PlayAll { plant: self, drive, sums, sense });
    }

    /// Returns `true` if nothing moves while this code is played, and nothing is recorded.
    #[inline(always)]
    fn rests_at(&self, code: u16) -> bool {
        self.at_rest && self.samples.is_none() && self.delay.is_none() && self.dac.volts(code) == self.held_v
    }

    /// Plays `codes` codes at rest: all steps equal the last one, and so do the inputs of the
    /// converters.
    #[inline(always)]
    fn rest_on<F: Registers>(&mut self, four: F, codes: usize, sums: &mut Sums, sense: &mut SenseBlock) {
        let last = self.last;
        for _ in 0..codes * self.timing.steps as usize {
            sums.add(&last);
        }
        for _ in 0..codes {
            let (mut v, mut i) = (0, 0);
            for &(scaled, conversions) in &self.inputs {
                let [voltage, current] = self.adc.digitize(scaled.wide(four), conversions);
                v += voltage;
                i += current;
            }
            let _ = (sense.v.push(v), sense.i.push(i));
        }
    }

    /// Puts the stack at rest after a sample of one step without friction in which nothing moved.
    /// The inputs of the converters in that sample are used from then on.
    pub(super) fn rest(&mut self) {
        let DrivenStack { stack, adc, inputs, held_v, .. } = self;
        inputs.clear();
        stack.sample(Portable, 0, &stack.held(*held_v), 0.0, |both, conversions| {
            inputs.push((adc.scaled(both).quad(), conversions))
        });
        self.last = Step::from_stack(stack, StepFriction::default());
        self.at_rest = true;
    }
}

/// Plays the rest of a block.
struct PlayAll<'a> {
    plant: &'a mut DrivenStack,
    drive: &'a DriveBlock,
    sums: &'a mut Sums,
    sense: &'a mut SenseBlock,
}

impl Kernel for PlayAll<'_> {
    type Output = ();

    #[inline(always)]
    fn with<F: Registers>(self, four: F) {
        let PlayAll { plant, drive, sums, sense } = self;
        let codes = drive.lanes.first().map_or(&[][..], |lane| lane.as_slice());
        // A local copy without aliases: sums in memory would have to be read back after every
        // write.
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
