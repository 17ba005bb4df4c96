//! Several stacks batched, each in a lane of the same registers.
//!
//! A lane computes the same as [`DrivenStack::exchange`](hal_mock::analog::Analog::exchange), bit
//! for bit, in the same order. A single stack is slower, as each of its operations waits for the
//! result of the one before. A stack is batched for a block if it has no contact, no further modes
//! and no late drive, does not heat itself, is not recorded sample by sample, and is driven.
//! Otherwise, and from the sample on after which it is at rest, it runs alone.

use firmware::seam::block::{DriveBlock, MAX_BLOCK_SAMPLES, SenseBlock};

use super::DrivenStack;
use crate::converter;
use crate::noise;
use crate::quad::{Kernel, LANES, Quad, Registers, run_widest};
use crate::stack::lanes::{Flows, States};
use crate::sums::{BatchSums, Sums};

/// A plant and its next block.
#[derive(Debug)]
pub struct Voice<'a> {
    /// The plant.
    pub plant: &'a mut DrivenStack,
    /// The block to play.
    pub drive: &'a DriveBlock,
    /// The measurements during the block.
    pub sense: &'a mut SenseBlock,
}

/// Batched plants; each plant keeps its lane from block to block.
#[derive(Clone, Debug)]
pub struct Abreast {
    noise: noise::NoiseBatch,
    /// `true` for each lane whose noise is held here instead of in its plant.
    holds: [bool; LANES],
    flows: Flows,
    scales: [Scales; 2],
    /// Voltages that are played in this block, V.
    volts: [Quad; MAX_BLOCK_SAMPLES],
    /// Codes that are sampled in this block.
    codes: [[[u16; LANES]; 2]; MAX_BLOCK_SAMPLES],
}

/// Factor of a channel's values, offset, factor of the noise, and the largest code.
type Scales = [Quad; 4];

/// A block of several plants in progress.
struct Block {
    states: States,
    sums: BatchSums,
    /// The drive of the last sample, V.
    held_v: Quad,
    samples: usize,
    /// Number of samples that have been played.
    played: usize,
}

impl Default for Abreast {
    fn default() -> Self {
        Abreast {
            noise: noise::NoiseBatch::new(),
            holds: [false; LANES],
            flows: Flows::default(),
            scales: [[Quad::default(); 4]; 2],
            volts: [Quad::default(); MAX_BLOCK_SAMPLES],
            codes: [[[0; LANES]; 2]; MAX_BLOCK_SAMPLES],
        }
    }
}

impl Voice<'_> {
    fn codes(&self) -> &[u16] {
        self.drive.lanes.first().map_or(&[][..], |lane| lane.as_slice())
    }

    /// Returns `true` if it can be batched with others of the same division of samples.
    fn fits(&self, samples: usize, conversions: u32) -> bool {
        let DrivenStack { timing, stack, elements, sliding, delay, samples: recorded, .. } = &*self.plant;
        let alone = sliding.is_some() || delay.is_some() || recorded.is_some() || elements.heats();
        let simple = !alone && stack.parts().further.is_empty();
        let codes = self.codes();
        let driven = codes.iter().any(|code| *code != codes[0]);
        simple && driven && codes.len() == samples && (timing.steps, timing.conversions) == (1, conversions)
    }
}

impl Abreast {
    /// Plays a block of each plant.
    pub fn exchange(&mut self, voices: &mut [Option<Voice>; LANES]) {
        let mut sums: [Sums; LANES] = std::array::from_fn(|_| Sums::new());
        for (voice, sums) in voices.iter_mut().zip(&mut sums) {
            if let Some(voice) = voice {
                *sums = voice.plant.begin();
                voice.sense.v.clear();
                voice.sense.i.clear();
            }
        }
        let lanes = self.joining(voices);
        if lanes != [false; LANES] {
            self.play(voices, lanes, &mut sums);
        }
        for (voice, sums) in voices.iter_mut().zip(&mut sums) {
            let Some(voice) = voice else { continue };
            let samples = voice.codes().len();
            // The plants that run alone from the beginning, or from the sample at which they came
            // to rest.
            voice.plant.play_all(voice.drive, sums, voice.sense);
            voice.sense.slow = voice.plant.end(sums, samples);
        }
    }

    /// Selects the lanes that are batched in this block. Moves the noise of these lanes here, and
    /// returns the noise of the others to their plants.
    fn joining(&mut self, voices: &mut [Option<Voice>; LANES]) -> [bool; LANES] {
        let first = voices.iter().flatten().next();
        let (samples, conversions) = first.map_or((0, 0), |first| (first.codes().len(), first.plant.timing.conversions));
        let mut lanes = voices.each_ref().map(|voice| voice.as_ref().is_some_and(|voice| voice.fits(samples, conversions)));
        if lanes.iter().filter(|&&joins| joins).count() < 2 {
            lanes = [false; LANES];
        }
        for (lane, voice) in voices.iter_mut().enumerate() {
            let Some(Voice { plant, .. }) = voice else { continue };
            let noise = &mut plant.adc.noise;
            match (lanes[lane], self.holds[lane]) {
                (true, false) => {
                    if self.holds == [false; LANES] {
                        self.noise.follow(noise);
                    }
                    self.holds[lane] = self.noise.take(lane, noise);
                    lanes[lane] = self.holds[lane];
                }
                (false, true) => {
                    self.noise.give_back(lane, noise);
                    self.holds[lane] = false;
                }
                (true, true) | (false, false) => {}
            }
        }
        lanes
    }

    /// Plays a block of the batched lanes, each until it is at rest.
    fn play(&mut self, voices: &mut [Option<Voice>; LANES], mut lanes: [bool; LANES], sums: &mut [Sums; LANES]) {
        let mut block = self.begin(voices, lanes);
        while block.played < block.samples {
            let resting = run_widest(PlayUntilRest { abreast: self, block: &mut block, lanes });
            for lane in (0..LANES).filter(|&lane| resting[lane]) {
                if let Some(voice) = &mut voices[lane] {
                    self.leave(lane, voice, &block, &mut sums[lane]);
                    self.noise.give_back(lane, &mut voice.plant.adc.noise);
                    voice.plant.rest();
                }
                (self.holds[lane], lanes[lane]) = (false, false);
            }
        }
        for lane in (0..LANES).filter(|&lane| lanes[lane]) {
            if let Some(voice) = &mut voices[lane] {
                self.leave(lane, voice, &block, &mut sums[lane]);
            }
        }
    }

    /// Copies the data of a block from the plants.
    fn begin(&mut self, voices: &[Option<Voice>; LANES], lanes: [bool; LANES]) -> Block {
        let sums = BatchSums::default();
        let mut block = Block { states: States::default(), sums, held_v: Quad::default(), samples: 0, played: 0 };
        for (lane, voice) in voices.iter().enumerate() {
            let Some(voice) = voice.as_ref().filter(|_| lanes[lane]) else {
                // Zero volts at rest: the other contents of the lane have no effect.
                self.volts.iter_mut().for_each(|volts| volts[lane] = 0.0);
                continue;
            };
            let DrivenStack { stack, adc, dac, held_v, .. } = &*voice.plant;
            self.flows.take(lane, stack);
            block.states.take(lane, stack);
            block.held_v[lane] = *held_v;
            for (channel, scales) in self.scales.iter_mut().enumerate() {
                scales.iter_mut().zip(adc.scales(channel)).for_each(|(quad, scale)| quad[lane] = scale);
            }
            self.volts.iter_mut().zip(voice.codes()).for_each(|(volts, code)| volts[lane] = dac.volts(*code));
            block.samples = voice.codes().len();
        }
        block
    }

    /// Copies the results to a plant.
    fn leave(&self, lane: usize, voice: &mut Voice, block: &Block, sums: &mut Sums) {
        block.sums.give(lane, sums);
        block.states.give_back(lane, &mut voice.plant.stack, block.held_v[lane]);
        voice.plant.held_v = block.held_v[lane];
        for [v, i] in &self.codes[..block.played] {
            // A sense block holds as many samples as the longest drive block.
            let _ = (voice.sense.v.push(v[lane]), voice.sense.i.push(i[lane]));
        }
    }
}

/// Plays until one of `lanes` is at rest, or to the end of the block. Returns the lanes at rest.
struct PlayUntilRest<'a> {
    abreast: &'a mut Abreast,
    block: &'a mut Block,
    lanes: [bool; LANES],
}

impl Kernel for PlayUntilRest<'_> {
    type Output = [bool; LANES];

    #[inline(always)]
    fn with<F: Registers>(self, four: F) -> [bool; LANES] {
        let PlayUntilRest { abreast, block, lanes } = self;
        let Abreast { noise, flows, scales, volts, codes, .. } = abreast;
        let (mut states, mut sums) = (block.states.wide(four), block.sums.wide(four));
        let mut held_v = block.held_v;
        let mut resting = [false; LANES];
        for (&played, codes) in volts.iter().zip(codes).take(block.samples).skip(block.played) {
            let volts = played.wide(four);
            flows.advance(&mut states, volts);
            sums.add(states.voltage(), states.motional_current(), states.motional_voltage());
            let mut sensed = [[0; LANES]; 2];
            for conversion in 0..flows.conversions() {
                let looks = flows.look(conversion, &states, volts);
                let normal = noise.pair();
                for channel in 0..2 {
                    let [lsb_per_unit, zero, noise_lsb, top] = &scales[channel];
                    let scaled = looks[channel] * lsb_per_unit.wide(four) + zero.wide(four);
                    let noisy = scaled + normal[channel].wide(four) * noise_lsb.wide(four);
                    let converted = converter::codes(noisy, top.wide(four));
                    for lane in 0..LANES {
                        sensed[channel][lane] += converted[lane];
                    }
                }
            }
            for channel in 0..2 {
                for lane in 0..LANES {
                    codes[channel][lane] = sensed[channel][lane] as u16;
                }
            }
            block.played += 1;
            let held = std::mem::replace(&mut held_v, played);
            if held.wide(four).equals_any(volts) {
                let still = states.stored().are_still();
                resting = std::array::from_fn(|lane| lanes[lane] && held[lane] == played[lane] && still[lane]);
                if resting != [false; LANES] {
                    break;
                }
            }
        }
        (block.states, block.sums, block.held_v) = (states.stored(), sums.stored(), held_v);
        resting
    }
}
